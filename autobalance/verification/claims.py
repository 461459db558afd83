"""Check a report's claims: job, frame and claims come from it, everything else is measured anew."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from autobalance import job as jobs
from autobalance.balancing import engine_from_job, measured_crank, rotor_from_job, uncertainty_budget
from autobalance.balancing.assembly_from_job import staged_assembly
from autobalance.balancing.chordal_correction import FacetCorrection
from autobalance.balancing.gas_loads import crank_values, gas_loads
from autobalance.correction import KINDS
from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw
from autobalance.engine.balance_factor import bob_weight_moments
from autobalance.engine.force_values import force_values
from autobalance.errors import AutobalanceError, ClaimError, FileError, FormatError, JobError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Array, Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget, Share
from autobalance.solid.chordal_error.estimate import ChordalError, estimate_chordal_error
from autobalance.solid.formats.read import Source, read
from autobalance.solid.formats.write import decode
from autobalance.solid.mesh.measure import soup_moments
from autobalance.solid.mesh.mesh import Floats
from autobalance.solid.mesh.validate import refuse_overlap_exactly
from autobalance.solid.slicing.independent import agreement, slice_moments
from autobalance.units import RAD_S_PER_RPM
from autobalance.verification.cut_claims import check_places

ROUNDING = 1e-9
"""Share by which a number may differ from its claim: sums in another order, no more."""
BAY_ROUNDING = 1e-5
"""The same for loads of mains: the solid between two of them is cut before it is written, or after."""
MOMENT_ROUNDING = 1e-11
"""The same for unbalances, as a share of mass times size: the sums are the same ones as in the run."""
FACET_BARS = 3.0
"""Error bars of what facets hide by which true surfaces may differ from slices of facets laid over them."""
LARGEST = 1e30
"""Size of a number at most: no report holds a larger one, and their products stay finite."""
RIGID = 1e-9
"""Greatest entry of RᵀR − 1 in a rotation."""

Number = TypeVar("Number", int, float)


@dataclass(frozen=True, eq=False)
class Checked:
    """A report all of whose claims hold."""

    checked: int
    within: bool
    residual: Unbalance
    tolerance: Tolerance
    warnings: tuple[str, ...]
    agreement: float | None = None
    budget: Budget | None = None


@dataclass
class Claims:
    """A report's values by dotted path, and a count of those that were found true.

    Raises
    ------
    FormatError
        Where a value is missing or of another type.
    ClaimError
        Where one is not what was measured.
    """

    name: str
    values: Mapping[str, Any]
    held: int = 0
    warnings: list[str] = field(default_factory=list)

    def get(self, path: str, kind: type[Any]) -> Any:
        """Return the value at a dotted path."""
        value: Any = self.values
        for key in path.split("."):
            if not isinstance(value, Mapping) or key not in value:
                raise FormatError(f"{self.name}: {path} is missing; is this a report of autobalance balance?")
            value = value[key]
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number if kind is float else isinstance(value, kind)):
            raise FormatError(f"{self.name}: {path} is of the wrong type; needed {kind.__name__}")
        return value

    def array(self, path: str, shape: tuple[int, ...]) -> Array:
        """Return an array of numbers at a dotted path."""
        return self._as_array(path, self.get(path, list), shape)

    def _as_array(self, path: str, value: Any, shape: tuple[int, ...]) -> Array:
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.zeros(0)
        if array.shape != shape:
            raise FormatError(f"{self.name}: {path} is not {' x '.join(map(str, shape))} numbers")
        return array

    def same(self, path: str, measured: object) -> None:
        """Check a text, a count, or nothing."""
        claimed = self.get(path, object)
        if claimed != measured:
            raise ClaimError(f"{self.name}: {path} is {claimed!r}, but {measured!r} was found")
        self.held += 1

    def near(self, path: str, measured: Any, scale: float, rounding: float = ROUNDING) -> None:
        """Check a number or an array of them against a measurement, up to rounding of ``scale``."""
        found = np.asarray(measured, dtype=np.float64)
        claimed = self._as_array(path, self.get(path, object), found.shape)
        if not np.all(np.abs(claimed - found) <= rounding * scale):  # also refuses NaN
            raise ClaimError(f"{self.name}: {path} is {_text(claimed)}, but {_text(found)} was found")
        self.held += 1


def _text(value: Any) -> str:
    flat = np.asarray(value, dtype=np.float64).reshape(-1)
    text = ", ".join(f"{number:.9g}" for number in flat)
    return text if len(flat) == 1 else f"[{text}]"


def check_report(path: Path, independent: bool = False) -> Checked:
    """Check every number that a report claims of its corrected solid.

    Parameters
    ----------
    path : Path
        The report; its solid is looked for beside it.
    independent : bool
        Measure the solid a second way too, and require both to agree.

    Returns
    -------
    Checked

    Raises
    ------
    FileError, FormatError
        If the report or the solid cannot be read.
    ClaimError
        If a claim fails.
    """
    claims = Claims(path.name, read_report(path))
    try:
        return _checked(claims, path.parent, independent)
    except AutobalanceError:
        raise
    except (ValueError, ArithmeticError) as error:  # what is claimed cannot be: planes out of order, say
        raise FormatError(f"{path.name}: its claims contradict each other: {error}") from None


def _checked(claims: Claims, folder: Path, independent: bool) -> Checked:
    if claims.values.get("command") == "recut":
        from autobalance.verification.recut_claims import check_recut

        return check_recut(claims, folder, independent)
    claims.same("command", "balance")
    job = claimed_job(claims)
    frame = _frame(claims)
    anatomy = _anatomy(claims, frame)
    crank = _claimed_crank(claims)
    source, moments, soup = measured_files(claims, folder, job, frame)
    again = measured_again(claims, source, job, frame) if independent else None
    given_in = _check_input(claims, folder, job, anatomy)
    hidden = hidden_part(claims, job, anatomy, given_in, soup)
    tolerance = _check_tolerance(claims, job, anatomy, crank)
    loads = _check_loads(claims, job, anatomy, crank) - rotor_from_job.overbalance_moments(job, tolerance)
    check_unbalance(claims, "initial", Unbalance.of(crank + loads), tolerance, size_of(source, crank))
    after = moments + hidden + pressed_in(claims)
    residual = Unbalance.of(after + loads)
    check_unbalance(claims, "residual", residual, tolerance, size_of(source, crank))
    _check_after(claims, job, anatomy, crank, after)
    check_places(claims)
    _check_forces(claims, job, anatomy, {"before": crank, "after": after})
    _check_gas_loads(claims, job, anatomy, source, after)
    check_assembly(claims, job, tolerance, residual, size_of(source, crank))
    causes = _causes(claims, job, anatomy, crank, tolerance, given_in)
    _check_doubt(claims, "initial", causes, crank, [], size_of(source, crank))
    budget = _check_doubt(claims, "residual", causes, moments, _depth_rates(claims), size_of(source, crank))
    within = _verdict(claims, tolerance, residual, budget)
    return Checked(claims.held, within, residual, tolerance, tuple(claims.warnings), again, budget)


def claimed_anatomy(claims: Claims) -> Anatomy:
    """Return the journals and throws that a report names, in its frame."""
    return _anatomy(claims, _frame(claims))


def measured_solid(claims: Claims, folder: Path, job: Job, anatomy: Anatomy) -> Moments:
    """Return the moments of a report's corrected solid, read back from disk, with its slugs.

    Raises
    ------
    FileError
        If it is not there.
    ClaimError
        If its sha256 or its mass properties are others than the report's.
    """
    _, moments, soup = measured_files(claims, folder, job, anatomy.file_to_rotor)
    hidden = hidden_part(claims, job, anatomy, _check_input(claims, folder, job, anatomy), soup)
    return moments + hidden + pressed_in(claims)


def measured_again(claims: Claims, source: Source, job: Job, frame: Array) -> float:
    """Measure the solid from its slices; return how well both ways agree.

    Both would count metal twice that the solid holds twice: that there is none is looked at again too.

    True surfaces are compared with slices of facets laid over them and what these facets hide.
    """
    density = job.crankshaft.density_g_mm3
    one, other = source.moments(density, frame), slice_moments(source.solid.mesh, density, frame)
    needed, way = ROUNDING, "tetrahedra"
    refuse_overlap_exactly(source.solid)
    if source.exact is not None:
        hidden = estimate_chordal_error(source.solid.mesh, density, frame)
        other, way = other + hidden.missing, "true surfaces"
        needed += FACET_BARS * hidden.mass_bar_g / one.mass_g
    found = agreement(one, other)
    if not found <= needed:
        raise ClaimError(
            f"{claims.name}: moments from {way} and from slices differ by {found:.3g} of their size; "
            f"needed {needed:.3g}"
        )
    claims.held += 1
    return found


def size_of(source: Source, crank: Moments) -> float:
    """Return ∫ |r| dm at most: what first moments are rounded against [g·mm]."""
    return crank.mass_g * (source.solid.mesh.diagonal_mm + float(np.abs(source.solid.bounds).max()))


def read_report(path: Path) -> Mapping[str, Any]:
    """Return the values of a report's JSON."""
    try:
        values = json.loads(
            path.read_bytes(),
            parse_float=lambda text: _limited(float(text)),
            parse_int=lambda text: _limited(int(text)),
            parse_constant=_not_a_number,
        )
    except OSError as error:
        raise FileError(f"cannot read the report {path}: {(error.strerror or str(error)).lower()}") from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path} is no JSON: {str(error).splitlines()[0]}") from None
    if not isinstance(values, dict):
        raise FormatError(f"{path} is no report: its JSON is no object")
    return values


def _limited(number: Number) -> Number:
    if abs(number) > LARGEST:
        raise ValueError(f"it holds a number beyond {LARGEST:g}")
    return number


def _not_a_number(word: str) -> float:
    raise ValueError(f"it holds the number {word}")


def claimed_job(claims: Claims) -> Job:
    """Return the job that a report says it ran."""
    raw = given(claims.get("job", dict))
    file = raw.pop("file", "job")
    try:
        return jobs.parse(raw, Path(str(file)), crank_given=True)
    except JobError as error:
        raise FormatError(f"{claims.name}: job: {error}") from None


def given(value: Any) -> Any:
    """Return a described job without what was not given."""
    if isinstance(value, dict):
        return {key: given(item) for key, item in value.items() if item is not None}
    return value


def _frame(claims: Claims) -> Array:
    frame = claims.array("frame.file_to_rotor", (4, 4))
    turn = frame[:3, :3]
    rigid = np.abs(turn.T @ turn - np.eye(3)).max() <= RIGID and np.linalg.det(turn) > 0.0
    if not (rigid and frame[3].tolist() == [0.0, 0.0, 0.0, 1.0]):
        raise ClaimError(f"{claims.name}: frame.file_to_rotor is no rigid motion")
    claims.held += 1
    return frame


def _anatomy(claims: Claims, frame: Array) -> Anatomy:
    """Return the journals and throws that the report names: where bob-weights and planes go."""
    throws = []
    for place, values in enumerate(claims.get("crank.throws", list)):
        part = Claims(claims.name, values)
        pin = _pin(Claims(claims.name, part.get("crankpin", dict)))
        x, y = pin.centre_mm[:2]
        radius, angle = math.hypot(x, y), math.atan2(y, x)
        part.near("crank_radius_mm", radius, radius)
        part.near("angle_deg", _near_turn(math.degrees(angle), part.get("angle_deg", float)), 360.0)
        part.same("number", place + 1)
        claims.held += part.held
        throws.append(Throw(place + 1, radius, angle, pin))
    journals = []
    for place, values in enumerate(claims.get("crank.main_journals", list)):
        pin = _pin(Claims(claims.name, values))
        journals.append(MainJournal(pin.centre_mm, pin.diameter_mm, pin.width_mm, place + 1))
    off = claims.get("crank.journal_misalignment_mm", float)
    return Anatomy(frame, tuple(journals), tuple(throws), (), off)


def _pin(claims: Claims) -> Pin:
    return Pin(
        claims.array("centre_mm", (3,)), claims.get("diameter_mm", float), claims.get("width_mm", float)
    )


def _near_turn(angle_deg: float, claimed_deg: float) -> float:
    """Return the angle in the turn that is nearest to the claim."""
    return (
        angle_deg + 360.0 * round((claimed_deg - angle_deg) / 360.0)
        if math.isfinite(claimed_deg)
        else angle_deg
    )


def _claimed_crank(claims: Claims) -> Moments:
    """Return the crank before correction as the report has it: mass, centre, inertia."""
    mass = float(claims.get("crank.mass_g", float))
    centre = claims.array("crank.centre_of_mass_mm", (3,))
    inertia = 1000.0 * claims.array("crank.inertia_kg_mm2", (3, 3))
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return Moments(mass, mass * centre, second)


def measured_files(
    claims: Claims, folder: Path, job: Job, frame: Array
) -> tuple[Source, Moments, Floats | None]:
    """Read the corrected solid, or the input where nothing was cut, and check what is claimed of the file."""
    crankshaft = job.crankshaft
    key = "outputs.solid"
    if claims.get(key, object) is None:
        source = read(
            input_path(claims, folder),
            crankshaft.unit,
            crankshaft.body,
            pressed_up=not crankshaft.crankpin_in_file,
        )
        claims.same("input.sha256", source.sha256)
        return source, source.moments(crankshaft.density_g_mm3, frame), None
    path = folder / Path(claims.get(f"{key}.file", str)).name
    source = read(path, crankshaft.unit, "all", unite=False)
    claims.same(f"{key}.sha256", source.sha256)
    soup = None
    if source.exact is not None:
        claims.same(f"{key}.triangles", None)
        moments = source.moments(crankshaft.density_g_mm3, frame)
    else:
        claims.same(f"{key}.triangles", source.triangles)
        soup = decode(path.read_bytes(), str(source.format), source.mm_per_unit)
        moments = soup_moments(soup, crankshaft.density_g_mm3, frame)
    check_properties(claims, key, moments, source.volume_mm3)
    return source, moments, soup


def check_assembly(
    claims: Claims, job: Job, tolerance: Tolerance, residual: Unbalance, size_g_mm: float
) -> None:
    """Check the sums of the parts that are put on, in their order."""
    if not job.assembly:
        return
    found = staged_assembly(job, tolerance, residual)
    for part, stage in zip(entries_of(claims, "assembly", len(found)), found, strict=True):
        total = np.array([stage.sum_g_mm.real, stage.sum_g_mm.imag])
        part.near("sum.unbalance_g_mm", total, size_g_mm, MOMENT_ROUNDING)
        part.near("permissible_g_mm", stage.permissible_g_mm, stage.permissible_g_mm)
        part.near("left", np.array([stage.left_g_mm.real, stage.left_g_mm.imag]), size_g_mm, MOMENT_ROUNDING)
        part.same("within", stage.within)
        claims.held += part.held


def check_properties(claims: Claims, key: str, moments: Moments, volume_mm3: float) -> None:
    """Check the mass properties that are claimed of a solid."""
    inertia = moments.inertia_g_mm2 / 1000.0
    reach = float(np.sqrt(np.trace(moments.second_g_mm2) / moments.mass_g))
    claims.near(f"{key}.mass_g", moments.mass_g, moments.mass_g)
    claims.near(f"{key}.volume_mm3", volume_mm3, volume_mm3)
    claims.near(f"{key}.centre_of_mass_mm", moments.centre_mm, reach)
    claims.near(f"{key}.inertia_kg_mm2", inertia, float(np.abs(inertia).max()))
    claims.near(
        f"{key}.polar_inertia_kg_mm2", moments.polar_inertia_g_mm2 / 1000.0, float(np.abs(inertia).max())
    )


Given = tuple[Source, ChordalError | None]
"""The crank's file, and what its facets hide."""


def input_path(claims: Claims, folder: Path) -> Path:
    """Return the crank's file: relative to the report, else where the job found it; its hash is checked."""
    name = Path(claims.get("input.file", str))
    job = claims.get("job", dict)
    crank = (job.get("crankshaft") or {}).get("file")
    places = [folder / name, name]
    if isinstance(crank, str) and isinstance(job.get("file"), str) and not name.is_absolute():
        places.append(Path(job["file"]).parent / crank)
    return next((place for place in places if place.is_file()), places[0])


def _check_input(claims: Claims, folder: Path, job: Job, anatomy: Anatomy) -> Given | None:
    """Check what is claimed of the crank before correction, where its file is still there; return it."""
    path = input_path(claims, folder)
    if claims.get("outputs.solid", object) is not None and not path.is_file():
        claims.warnings.append(f"{path} is not there any more; what is claimed of it was not checked")
        return None
    crankshaft = job.crankshaft
    source = read(path, crankshaft.unit, crankshaft.body, pressed_up=not crankshaft.crankpin_in_file)
    claims.same("input.sha256", source.sha256)
    claims.same("input.triangles", source.triangles)
    density = crankshaft.density_g_mm3
    facets = measured_crank.facets_of(source, density, anatomy, job.balance)
    moments, added = source.moments(density, anatomy.file_to_rotor), Moments.zero()
    if facets is not None:
        added = FacetCorrection.of(facets, job.balance.facet_correction).part(facets.missing)
    check_properties(claims, "crank", moments + added, source.volume_mm3 + added.mass_g / density)
    return source, facets


def hidden_part(
    claims: Claims, job: Job, anatomy: Anatomy, given_in: Given | None, soup: Floats | None
) -> Moments:
    """Check and return what is added for the facets of the corrected solid, loose triangles ``soup``.

    Without the crank's file nobody can tell which surfaces its facets stood for: then it is taken as claimed.
    """
    if claims.get("crank", dict).get("facet_error") is None or not job.balance.facet_correction:
        return Moments.zero()
    key = "crank.facet_error.added"
    if given_in is None:
        return _claimed_added(claims, f"{key}.after") if claims.get(key, object) else Moments.zero()
    source, facets = given_in
    correction = None if facets is None else FacetCorrection.of(facets, True)
    claims.same("crank.facet_error.correction", None if correction is None else correction.verdict)
    if facets is None or correction is None or not correction.mass:
        claims.same(key, None)
        return Moments.zero()
    before = correction.part(facets.missing)
    left = correction.left(facets, anatomy)
    after = before if soup is None or left is None else left(soup)
    for name, found in (("before", before), ("after", after)):
        size = facets.gross_mass_g * source.solid.mesh.diagonal_mm
        claims.near(f"{key}.{name}.mass_g", found.mass_g, facets.gross_mass_g)
        claims.near(f"{key}.{name}.unbalance_g_mm", found.first_g_mm[:2], size)
        reach = size * source.solid.mesh.diagonal_mm
        claims.near(f"{key}.{name}.moment_g_mm2", found.second_g_mm2[:2, 2], reach)
        claims.near(f"{key}.{name}.polar_inertia_kg_mm2", found.polar_inertia_g_mm2 / 1000.0, reach / 1000.0)
    return after


def _claimed_added(claims: Claims, key: str) -> Moments:
    first, second = np.zeros(3), np.zeros((3, 3))
    first[:2] = claims.array(f"{key}.unbalance_g_mm", (2,))
    second[:2, 2] = second[2, :2] = claims.array(f"{key}.moment_g_mm2", (2,))
    second[0, 0] = second[1, 1] = 500.0 * float(claims.get(f"{key}.polar_inertia_kg_mm2", float))
    return Moments(float(claims.get(f"{key}.mass_g", float)), first, second)


# --- what follows from the job ------------------------------------------------------------------------------


def _check_tolerance(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments) -> Tolerance:
    tolerance = rotor_from_job.tolerance_of(job, anatomy, crank)
    claims.near("tolerance.grade_mm_s", tolerance.grade_mm_s, tolerance.grade_mm_s)
    claims.near("tolerance.rotor_mass_g", tolerance.rotor_mass_g, tolerance.rotor_mass_g)
    claims.near("tolerance.permissible_g_mm", tolerance.permissible_g_mm, tolerance.permissible_g_mm)
    claims.same("tolerance.judge", tolerance.judge)
    if "margin" in claims.get("tolerance", dict) or tolerance.margin != "none":
        claims.same("tolerance.margin", tolerance.margin)
    listed = entries_of(claims, "tolerance.planes", len(tolerance.planes))
    for part, plane in zip(listed, tolerance.planes, strict=True):
        part.same("name", plane.name)
        part.near("z_mm", plane.z_mm, max(abs(plane.z_mm), 1.0))
        part.near("permissible_g_mm", plane.permissible_g_mm, plane.permissible_g_mm)
        claims.held += part.held
    return tolerance


def entries_of(claims: Claims, path: str, count: int) -> list[Claims]:
    """Return the entries of a list, each to be checked by itself."""
    values = claims.get(path, list)
    if len(values) != count:
        raise ClaimError(f"{claims.name}: {path} has {len(values)} entries, but {count} were found")
    return [Claims(f"{claims.name}: {path}[{place}]", each) for place, each in enumerate(values, 1)]


def _check_loads(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments) -> Moments:
    """Return bob-weights and attached rotors at the balance factor asked for."""
    factor = rotor_from_job.target_factor(job, anatomy, crank)
    claims.near("balance_factor.target", factor, 1.0)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    for part, load in zip(entries_of(claims, "engine.bob_weights", len(loads)), loads, strict=True):
        part.near("mass_g", load.parts.bob_weight_g(factor), load.parts.bob_weight_g(factor))
        claims.held += part.held
    return bob_weight_moments(loads, factor) + rotor_from_job.attached_moments(job.engine.attached)


def _check_forces(claims: Claims, job: Job, anatomy: Anatomy, cranks: Mapping[str, Moments]) -> None:
    """Check the shaking forces, where the report has them."""
    if claims.values.get("forces") is None:
        return
    speed_rpm = job.balance.service_speed_rad_s / RAD_S_PER_RPM
    claims.near("forces.speed_rpm", speed_rpm, speed_rpm)
    for key, crank in cranks.items():
        found = engine_from_job.shaking(job, anatomy, crank)
        if found is None:
            raise ClaimError(f"{claims.name}: forces: the job does not say where the cylinders stand")
        scale = sum(order.greatest_force_n for order in found.orders) + found.greatest_n
        whole = job.engine.rod_length_mm is not None
        values = force_values(found, all_orders=whole)
        for part, order in zip(
            entries_of(claims, f"forces.{key}.orders", len(values["orders"])), values["orders"], strict=True
        ):
            for name in ("force_x_n", "force_y_n", "greatest_force_n", "forward_n", "backward_n"):
                part.near(name, order[name], scale)
            claims.held += part.held
        for name in ("greatest_n", "greatest_inline_n", "greatest_transverse_n") if whole else ():
            claims.near(f"forces.{key}.{name}", values[name], scale)


def _check_gas_loads(claims: Claims, job: Job, anatomy: Anatomy, source: Source, after: Moments) -> None:
    """Check the loads with gas of the corrected crank; a measured pressure is not kept with a report."""
    if claims.values.get("loads_with_gas") is None or job.cycle is None or job.cycle.measured:
        return
    density = job.crankshaft.density_g_mm3
    values = crank_values(gas_loads(job, anatomy, source.solid, density, after))
    rows = values["main_journals"]
    scale = max(row["greatest_N"] for row in rows)
    for part, row in zip(
        entries_of(claims, "loads_with_gas.after.main_journals", len(rows)), rows, strict=True
    ):
        for name in ("greatest_N", "mean_N"):
            part.near(name, row[name], scale, BAY_ROUNDING)
        claims.held += part.held
    friction = values["friction_mean_N_m"]
    claims.near("loads_with_gas.after.friction_mean_N_m", friction, max(friction, 1e-3), BAY_ROUNDING)


def check_unbalance(
    claims: Claims, key: str, found: Unbalance, tolerance: Tolerance, size_g_mm: float
) -> None:
    """Check an unbalance in all its forms: resultant, angle, moment, planes."""
    claims.near(f"{key}.unbalance_g_mm", found.resultant_g_mm, size_g_mm, MOMENT_ROUNDING)
    claims.near(f"{key}.magnitude_g_mm", found.magnitude_g_mm, size_g_mm, MOMENT_ROUNDING)
    claimed = claims.array(f"{key}.unbalance_g_mm", (2,))
    angle = math.degrees(math.atan2(claimed[1], claimed[0]))
    claims.near(f"{key}.angle_deg", _near_turn(angle, claims.get(f"{key}.angle_deg", float)), 360.0)
    places = [plane.z_mm for plane in tolerance.planes]
    span = (max(places) - min(places)) if places else 1.0
    claims.near(f"{key}.moment_g_mm2", found.moment_g_mm2, size_g_mm * max(span, 1.0), MOMENT_ROUNDING)
    vectors: Sequence[Array] = list(found.in_planes(places[0], places[1])) if places else []
    for part, vector in zip(entries_of(claims, f"{key}.planes", len(vectors)), vectors, strict=True):
        part.near("unbalance_g_mm", vector, size_g_mm, MOMENT_ROUNDING)
        part.near("magnitude_g_mm", math.hypot(*vector), size_g_mm, MOMENT_ROUNDING)
        claims.held += part.held


def pressed_in(claims: Claims) -> Moments:
    """Return the slugs, which are not in the file."""
    total = Moments.zero()
    for values in claims.get("corrections", list):
        part = Claims(claims.name, values)
        keys = _keys_of_pressed_in(part)
        if keys is not None:
            total = total + Moments.point(part.get(keys[0], float), part.array(keys[1], (3,)))
    return total


def _keys_of_pressed_in(correction: Claims) -> tuple[str, str] | None:
    """Return the keys of mass and centre of what a correction presses in, if it does."""
    kind = KINDS.get(correction.get("kind", str))
    return None if kind is None else kind.pressed_in


def _check_after(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments, after: Moments) -> None:
    """Check factor and inertia after correction."""
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    attached = rotor_from_job.attached_moments(job.engine.attached)
    for key, moments in (("initial", crank), ("final", after)):
        factor = rotor_from_job.crank_factor(moments, loads, attached)
        if factor is None:
            claims.same(f"balance_factor.{key}", None)
        else:
            claims.near(f"balance_factor.{key}", factor, 10.0)
    change = (after.polar_inertia_g_mm2 - crank.polar_inertia_g_mm2) / 1000.0
    parts = [Claims(claims.name, values) for values in claims.get("corrections", list)]
    if not any(map(_keys_of_pressed_in, parts)):  # its own inertia is not in the report
        claims.near("inertia_change_kg_mm2", change, crank.polar_inertia_g_mm2 / 1000.0)


# --- the error budget ---------------------------------------------------------------------------------------

FROM_THE_FILE = ("facets", "rounding")
"""Causes that only the crank's file can tell."""


def _causes(
    claims: Claims, job: Job, anatomy: Anatomy, crank: Moments, tolerance: Tolerance, given_in: Given | None
) -> uncertainty_budget.UncertaintyBudget:
    """Return what makes the budget; without the crank's file, what the file tells counts as nothing."""
    factor = claims.get("balance_factor.target", float)
    facets, spacing = None, 0.0
    if given_in is not None:
        source, facets = given_in
        spacing = uncertainty_budget.spacing_mm(source)
    nothing = ChordalError.known(Moments.zero())
    return uncertainty_budget.UncertaintyBudget(
        job, anatomy, crank, tolerance, factor, facets or nothing, spacing
    )


def _depth_rates(claims: Claims) -> list[Moments]:
    """Return what a millimetre of depth changes for each correction, as far as an unbalance goes."""
    rates = []
    for place, values in enumerate(claims.get("corrections", list), 1):
        part = Claims(f"{claims.name}: corrections[{place}]", values)
        if values.get("unbalance_per_mm_g_mm") is not None:
            first, second = np.zeros(3), np.zeros((3, 3))
            first[:2] = part.array("unbalance_per_mm_g_mm", (2,))
            second[:2, 2] = part.array("moment_per_mm_g_mm2", (2,))
            rates.append(Moments(0.0, first, second))
    return rates


def _check_doubt(
    claims: Claims,
    key: str,
    causes: uncertainty_budget.UncertaintyBudget,
    bare: Moments,
    rates: list[Moments],
    size_g_mm: float,
) -> Budget | None:
    """Check every share of an uncertainty and their sum; return the budget that the report claims."""
    if claims.get(key, dict).get("uncertainty_g_mm") is None:
        return None
    found = causes.with_depth_rates(bare, rates)
    parts = [Claims(f"{claims.name}: {key}", claims.get(key, dict))]
    parts += entries_of(claims, f"{key}.planes", len(causes.tolerance.planes))
    file_is_there = causes.spacing_mm > 0.0
    columns = []
    for place, part in enumerate(parts):
        shares = part.get("uncertainty_shares_g_mm", dict)
        for cause, share in found.shares.items():
            if cause in FROM_THE_FILE and not file_is_there:
                continue
            value = (share.resultant_g_mm, *share.planes_g_mm)[place]
            part.near(f"uncertainty_shares_g_mm.{cause}", value, size_g_mm, MOMENT_ROUNDING)
        if set(shares) != set(found.shares):
            raise ClaimError(
                f"{part.name}: uncertainty_shares_g_mm lists {', '.join(shares)}; "
                f"needed {', '.join(found.shares)}"
            )
        numbers = [float(part.get(f"uncertainty_shares_g_mm.{cause}", float)) for cause in found.shares]
        part.near("uncertainty_g_mm", math.hypot(*numbers), math.hypot(*numbers))
        columns.append(numbers)
        claims.held += part.held
    try:
        claimed = {
            cause: Share(row[0], tuple(row[1:]))
            for cause, row in zip(found.shares, zip(*columns, strict=True), strict=True)
        }
    except ValueError as error:
        raise ClaimError(f"{claims.name}: {key}.uncertainty_shares_g_mm: {error}") from None
    return Budget(claimed, causes.tolerance.places_mm)


def _verdict(claims: Claims, tolerance: Tolerance, residual: Unbalance, budget: Budget | None) -> bool:
    if tolerance.margin != "none" and budget is None:
        raise ClaimError(
            f"{claims.name}: residual.uncertainty_g_mm is null, "
            f'but balance.margin = "{tolerance.margin}" needs it'
        )
    within = tolerance.is_met_by(residual, budget)
    outcome = claims.get("outcome", str)
    if (outcome != "above_tolerance") != within:
        raise ClaimError(
            f"{claims.name}: outcome is {outcome!r}, but the residual measured is "
            f"{'within' if within else 'above'} tolerance"
        )
    claims.held += 1
    return within
