"""The steps that the commands share: a file becomes a measured crank, a job and a crank become a rotor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from autobalance.beside import beside
from autobalance.command.facet_correction import NOT_ASKED, FacetCorrection
from autobalance.command.memory import keep_freed_memory
from autobalance.crank.alignment import misalignment_warning
from autobalance.crank.anatomy import Anatomy, Face, Overrides
from autobalance.crank.faces import find_faces
from autobalance.crank.recognise import recognise
from autobalance.engine.balance_factor import balance_factor, bob_weight_moments
from autobalance.engine.parts import Parts, ThrowLoad
from autobalance.errors import BodiesError, JobError, RecognitionError
from autobalance.job import Attached, Balance, Crankshaft, Engine, Job, PartWeights, Weight
from autobalance.rotor.moments import Moments
from autobalance.rotor.tolerance import Tolerance
from autobalance.rotor.unbalance import Unbalance
from autobalance.solid.facet_slices import facet_error_from_slices
from autobalance.solid.facets import FacetError, facet_error
from autobalance.solid.read import Source, read

if TYPE_CHECKING:
    from concurrent.futures import Future

    from autobalance.report.record import TrueSurfaces
    from autobalance.solid.csg import Solid

FACETS_MOST = 200_000
"""Triangles up to which every facet is looked at: some 0.5 s for 100 000."""
STROKE_SLACK_MM = 0.1
STROKE_SLACK_SHARE = 0.005


@dataclass(frozen=True, eq=False)
class Crank:
    """A crank file, read, recognised and measured (moments in the rotor frame)."""

    source: Source
    anatomy: Anatomy
    density_g_mm3: float
    moments: Moments
    facets: FacetError | None
    correction: FacetCorrection = NOT_ASKED
    faces: tuple[Face, ...] = ()

    @property
    def volume_mm3(self) -> float:
        """Volume [mm³], what the facets hide added where the moments have it."""
        added = Moments.zero() if self.facets is None else self.correction.part(self.facets.missing)
        return self.source.volume_mm3 + added.mass_g / self.density_g_mm3

    def warnings(self, file: Path) -> tuple[str, ...]:
        """Return what a user should know of the file and the crank in it, one line each."""
        misaligned = misalignment_warning(self.anatomy)
        found = [*self.source.repairs, *([] if misaligned is None else [misaligned])]
        return tuple(f"{file}: {text}" for text in found)


class Stopwatch:
    """Seconds spent in each stage of a run."""

    def __init__(self) -> None:
        """Start the clock."""
        self._start = time.perf_counter()
        self._spent: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of the block for a stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(name, time.perf_counter() - start)

    def add(self, name: str, seconds: float) -> None:
        """Count more seconds for a stage."""
        self._spent[name] = self._spent.get(name, 0.0) + seconds

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds of each stage, and of everything so far."""
        return {**self._spent, "total": time.perf_counter() - self._start}


def measured_crank(
    crankshaft: Crankshaft, watch: Stopwatch, asked: Balance | None = None, with_faces: bool = False
) -> Crank:
    """Read a crank file, recognise the crank in it and measure it, as exactly as ``asked``.

    Its planar faces are looked for only ``with_faces``.
    """
    keep_freed_memory()
    recognition = _Recognition(crankshaft.overrides)
    with watch.stage("load"):
        source = _read(crankshaft, recognition.begin)
    with watch.stage("measure"):
        in_file = source.moments(crankshaft.density_g_mm3)  # while the crank is still being recognised
        try:
            anatomy = recognition.anatomy(source)
        except RecognitionError as error:
            raise RecognitionError(f"{crankshaft.file}: {error}") from None
        looking = beside(
            lambda: find_faces(source.solid.mesh, anatomy, source.surfaces) if with_faces else ()
        )
        moments = in_file.moved(anatomy.file_to_rotor)
        facets = facets_of(source, crankshaft.density_g_mm3, anatomy, asked)
        correction = NOT_ASKED
        if facets is not None and asked is not None:
            correction = FacetCorrection.of(facets, asked.facet_correction)
            moments = moments + correction.part(facets.missing)
        faces = looking.result()
    return Crank(source, anatomy, crankshaft.density_g_mm3, moments, facets, correction, faces)


def work_on_faces(job: Job) -> bool:
    """Tell whether a correction of the job begins at a planar face."""
    return any(hasattr(limits, "faces") for limits in job.methods)


class _Recognition:
    """Looks for the crank in a solid while that is still being checked."""

    def __init__(self, hints: Overrides) -> None:
        self._hints = hints
        self._begun: tuple[Solid, Future[Anatomy]] | None = None

    def begin(self, solid: Solid) -> None:
        """Start with a solid that will most likely stay as it is."""
        self._begun = solid, beside(lambda: recognise(solid, self._hints))

    def anatomy(self, source: Source) -> Anatomy:
        """Return the crank in a file's solid, once it is checked."""
        if self._begun is not None and source.solid is self._begun[0]:
            return self._begun[1].result()
        own = source.surfaces.cylinders if source.surfaces is not None else ()
        return recognise(source.solid, self._hints, own)


def _read(crankshaft: Crankshaft, begun: Callable[[Solid], None]) -> Source:
    pressed_up = not crankshaft.crankpin_in_file
    try:
        return read(crankshaft.file, crankshaft.unit, crankshaft.body, pressed_up=pressed_up, begun=begun)
    except BodiesError as several:
        solid = read(crankshaft.file, crankshaft.unit, "all").solid
        try:
            recognise(solid, replace(crankshaft.overrides, crankpin_in_file=None))
        except RecognitionError as reason:
            raise BodiesError(f"{several}; together they are no crank: {reason}") from None
        raise


def facets_of(
    source: Source, density_g_mm3: float, anatomy: Anatomy, asked: Balance | None = None
) -> FacetError:
    """Estimate what the facets cost: from sections alone where looking at all of them would take long.

    A correction that is ``asked`` for, and a verdict in which the uncertainty counts, look at all of them.
    """
    frame = anatomy.file_to_rotor
    if source.exact is not None:  # measured on the true surfaces
        return FacetError.known(Moments.zero())
    needed = asked is not None and (asked.margin != "none" or asked.facet_correction)
    if source.solid.triangle_count > FACETS_MOST and not needed:
        return facet_error_from_slices(source.solid.mesh, density_g_mm3, frame)
    return facet_error(source.solid.mesh, density_g_mm3, frame)


def surfaces_entry(crank: Crank) -> TrueSurfaces | None:
    """Return what the report says of the true surfaces, where the file keeps them."""
    from autobalance.report.record import TrueSurfaces

    exact = crank.source.exact
    if exact is None:
        return None
    faceted = crank.source.solid.moments(crank.density_g_mm3, crank.anatomy.file_to_rotor)
    return TrueSurfaces(exact.solid.face_kinds(), crank.moments - faceted)


# --- weights ------------------------------------------------------------------------------------------------


def throw_loads(
    anatomy: Anatomy, engine: Engine, weights: PartWeights | None = None
) -> tuple[ThrowLoad, ...]:
    """Return what hangs on each throw; ``weights`` take the place of the job's parts on all of them."""
    return tuple(
        ThrowLoad(
            _parts(weights or engine.of_throw(throw.number).weights, engine.of_throw(throw.number).rods),
            throw.crank_radius_mm,
            throw.angle_rad,
            float(throw.crankpin.centre_mm[2]),
        )
        for throw in anatomy.throws
    )


def _parts(weights: PartWeights, rods: int) -> Parts:
    return Parts(
        rotating_g=total_g(weights.rotating),
        reciprocating_g=total_g(weights.reciprocating),
        crankpin_g=total_g(weights.crankpin),
        rods=rods,
    )


def total_g(weights: Mapping[str, Weight]) -> float:
    """Return the sum of named weights."""
    return sum(weight.mass_g for weight in weights.values())


def attached_moments(attached: tuple[Attached, ...]) -> Moments:
    """Return what attached rotors add: their mass on the axis, their unbalance at their place."""
    total = Moments.zero()
    for part in attached:
        on_axis = Moments.point(part.mass_g, np.array([0.0, 0.0, part.z_mm]))
        total = total + on_axis + unbalance_at(part.unbalance_g_mm, part.z_mm)
    return total


def unbalance_at(unbalance_g_mm: tuple[float, float], z_mm: float) -> Moments:
    """Return the moments of an unbalance at a place on the axis."""
    x, y = unbalance_g_mm
    second = np.zeros((3, 3))
    second[0, 2] = second[2, 0] = x * z_mm
    second[1, 2] = second[2, 1] = y * z_mm
    return Moments(0.0, np.array([x, y, 0.0]), second)


def overbalance_moments(job: Job, tolerance: Tolerance) -> Moments:
    """Return the unbalance that is left on purpose for final drilling, midway between the planes."""
    balance = job.balance
    x = balance.overbalance_g_mm * math.cos(balance.overbalance_rad)
    y = balance.overbalance_g_mm * math.sin(balance.overbalance_rad)
    return unbalance_at((x, y), 0.5 * sum(plane.z_mm for plane in tolerance.planes))


def crank_factor(crank: Moments, loads: tuple[ThrowLoad, ...], attached: Moments) -> float | None:
    """Return the balance factor that a crank has with these parts."""
    rotating = crank + bob_weight_moments(loads, 0.0) + attached
    return balance_factor(Unbalance.of(rotating).resultant_g_mm, loads)


def target_factor(job: Job, anatomy: Anatomy, crank: Moments) -> float:
    """Return the balance factor asked for; with ``"original"``, the untouched crank's with its old parts.

    Raises
    ------
    JobError
        If the crank has no balance factor, or one outside 0..1.
    """
    if job.balance.factor is not None:
        return job.balance.factor
    loads = throw_loads(anatomy, job.engine, job.original)
    found = crank_factor(crank, loads, attached_moments(job.engine.attached))
    asked = f'{job.path.name}: balance.factor = "original"'
    if found is None:
        raise JobError(f"{asked}: the throws cancel each other out, so the crank has no balance factor")
    if not 0.0 <= found <= 1.0:
        raise JobError(
            f"{asked}: the crank's factor with the [original] parts is {found:.4f}; must be 0 to 1; check "
            "the weights, the unit and the density"
        )
    return found


# --- checks against the geometry ----------------------------------------------------------------------------


def check_engine(job: Job, anatomy: Anatomy) -> None:
    """Refuse a job whose engine is not this crank's.

    Raises
    ------
    JobError
        If a throw's number does not exist, or the stroke contradicts a crank radius.
    """
    count = len(anatomy.throws)
    for number in job.engine.by_throw:
        if number > count:
            throws = "1 throw" if count == 1 else f"{count} throws"
            raise JobError(f"{job.path.name}: engine.throw number {number}: the crank has {throws}")
    stroke = job.engine.stroke_mm
    if stroke is None:
        return
    slack = max(STROKE_SLACK_MM, STROKE_SLACK_SHARE * stroke)
    for throw in anatomy.throws:
        found = 2.0 * throw.crank_radius_mm
        if abs(found - stroke) > slack:
            raise JobError(
                f"{job.path.name}: engine.stroke_mm is {stroke:g}, but throw {throw.number} of the crank "
                f"strokes {found:.3f} mm; they must agree within {slack:.3g} mm (is crankshaft.unit right?)"
            )


# --- tolerance ----------------------------------------------------------------------------------------------


def default_planes_mm(anatomy: Anatomy) -> tuple[float, float] | None:
    """Return the mid-planes of the outermost main journals; None with fewer than two."""
    if len(anatomy.main_journals) < 2:
        return None
    first, last = anatomy.main_journals[0], anatomy.main_journals[-1]
    return float(first.centre_mm[2]), float(last.centre_mm[2])


def tolerance_of(job: Job, anatomy: Anatomy, crank: Moments) -> Tolerance:
    """Return what the residual is judged against.

    Raises
    ------
    JobError
        If a dynamic verdict has no planes.
    """
    balance = job.balance
    planes = balance.tolerance_planes_mm or default_planes_mm(anatomy)
    if planes is None and balance.judge == "dynamic":
        count = len(anatomy.main_journals)
        raise JobError(
            f'{job.path.name}: balance.tolerance_planes_mm is missing: judge = "dynamic" needs two '
            f"planes and the crank has {count} main journal{'' if count == 1 else 's'} to take them from"
        )
    rotor = crank + _crankpins_not_in_file(job, anatomy)
    return Tolerance.of(
        grade_mm_s=balance.grade_mm_s,
        service_speed_rad_s=balance.service_speed_rad_s,
        rotor_mass_g=balance.rotor_mass_g or rotor.mass_g,
        z_centre_mm=float(rotor.centre_mm[2]),
        planes_z_mm=planes,
        judge=balance.judge,
        margin=balance.margin,
    )


def _crankpins_not_in_file(job: Job, anatomy: Anatomy) -> Moments:
    total = Moments.zero()
    for throw in anatomy.throws:
        pin = job.engine.of_throw(throw.number).weights.crankpin.get("crankpin")
        if pin is not None:
            total = total + Moments.point(pin.mass_g, throw.crankpin.centre_mm)
    return total
