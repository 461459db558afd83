"""Cranks before and after correction, read again from the files of a report."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from autobalance.balancing import measured_crank
from autobalance.balancing.facet_correction import FacetCorrection
from autobalance.balancing.measured import Crank
from autobalance.balancing.web_metal import WebMetal, web_metal
from autobalance.correction import KINDS
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import ClaimError, FileError, FormatError
from autobalance.job import Crankshaft, Job
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.runtime import note_read
from autobalance.solid.chordal_error.estimate import ChordalError, estimate_chordal_error
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import REFUSED_HOLES, Source, read
from autobalance.solid.formats.write import decode
from autobalance.solid.mesh.measure import soup_moments
from autobalance.solid.slicing.independent import agreement, slice_moments, trimesh_moments
from autobalance.solid.soundness.holes import OpenHoles
from autobalance.solid.soundness.validate import refuse_overlap_exactly
from autobalance.types import Array, Floats
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass
from autobalance.verification.claims import ROUNDING, Claims
from autobalance.verification.premises import density_before

FACET_BARS = 3.0
"""Largest difference between true surfaces and slices of facets over them, in error bars of their metal."""


T = TypeVar("T")


class Files:
    """Cache of files and of values computed from them, for several versions of a report."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Any] = {}

    def once(self, key: Hashable, work: Callable[[], T]) -> T:
        """Return the result of ``work``, computed once for each key."""
        if key not in self._known:
            self._known[key] = work()
        value: T = self._known[key]
        return value

    def read(
        self,
        path: Path,
        unit: str | None,
        body: int | str | None,
        pressed_up: bool = False,
        unite: bool | None = None,
        holes: OpenHoles = REFUSED_HOLES,
    ) -> Source:
        key = ("read", str(path), unit, body, pressed_up, unite, holes)
        return self.once(key, lambda: read(path, unit, body, pressed_up=pressed_up, unite=unite, holes=holes))


@dataclass(frozen=True, eq=False)
class OriginalCrank:
    """The crank before correction, recognised and measured; ``bare`` are its moments without hidden metal."""

    crank: Crank
    bare: Moments

    @property
    def source(self) -> Source:
        return self.crank.source

    @property
    def anatomy(self) -> Anatomy:
        """Anatomy as recognised, or as the report has it where only a cut crank exists."""
        return self.crank.anatomy

    @property
    def facets(self) -> ChordalError | None:
        return self.crank.facets


@dataclass(frozen=True, eq=False)
class Left:
    """The crank after correction: moments of its file, and the file's loose triangles if it has any."""

    source: Source
    moments: Moments
    soup: Floats | None
    is_cut: bool

    @property
    def triangles(self) -> int | None:
        """Number of triangles of its file; None where that keeps true surfaces."""
        return None if self.source.exact is not None else self.source.triangles


# --- the corrected solid ------------------------------------------------------------------------------------


def measured_files(claims: Claims, folder: Path, job: Job, frame: Array, files: Files) -> Left:
    """Read the corrected solid, or the input if nothing was cut, and check the claims of its file."""
    crankshaft = job.crankshaft
    key = "outputs.solid"
    if claims.get(key, object) is None:
        source = read_input(files, input_path(claims, folder), crankshaft)
        check_source(claims, "input", source)
        claims.hold(key)
        return Left(source, source.moments(crankshaft.density_g_mm3, frame), None, False)
    named = claims.get(f"{key}.file", str)
    path = folder / Path(named).name
    if path == folder:
        raise FormatError(f"{claims.name}: {key}.file is {named!r}; expected the name of a file beside it")
    source = files.read(path, crankshaft.unit, "all", unite=False)
    claims.same(f"{key}.file", path.name)
    claims.same(f"{key}.sha256", source.sha256)
    soup = None
    if source.exact is not None:
        claims.same(f"{key}.triangles", None)
        moments = source.moments(crankshaft.density_g_mm3, frame)
    else:
        claims.same(f"{key}.triangles", source.triangles)
        name, scale = str(source.format), source.mm_per_unit
        soup = files.once(("soup", str(path)), lambda: decode(path.read_bytes(), name, scale))
        moments = soup_moments(soup, crankshaft.density_g_mm3, frame)
    check_properties(claims, key, moments, source.volume_mm3)
    return Left(source, moments, soup, True)


def measured_solid(claims: Claims, folder: Path, job: Job, anatomy: Anatomy) -> Moments:
    """Return the moments of a report's corrected solid, read back from disk, with its slugs.

    Raises
    ------
    FileError
        If it is missing.
    ClaimError
        If its sha256 or its mass properties are others than the report's.
    """
    files = Files()
    left = measured_files(claims, folder, job, anatomy.file_to_rotor, files)
    crank_before = check_input(claims, folder, job, anatomy, files)
    hidden = hidden_part(claims, job, anatomy, crank_before, left.soup)
    return left.moments + hidden + pressed_in(claims)


def check_properties(claims: Claims, key: str, moments: Moments, volume_mm3: float) -> None:
    inertia = moments.inertia_g_mm2 / 1000.0
    reach = float(np.sqrt(np.trace(moments.second_g_mm2) / moments.mass_g))
    size = float(np.abs(inertia).max())
    claims.near(f"{key}.mass_g", moments.mass_g, moments.mass_g)
    claims.near(f"{key}.volume_mm3", volume_mm3, volume_mm3)
    claims.near(f"{key}.centre_of_mass_mm", moments.centre_mm, reach)
    claims.near(f"{key}.inertia_kg_mm2", inertia, size)
    claims.near(f"{key}.polar_inertia_kg_mm2", moments.polar_inertia_g_mm2 / 1000.0, size)


def measured_again(claims: Claims, source: Source, job: Job, frame: Array) -> float:
    """Measure the solid from its slices, a mesh by trimesh too; return the largest difference.

    Both ways would count overlapping metal twice, so overlap is refused first.

    True surfaces are compared with slices of facets laid over them plus the metal that these facets lack,
    within its error bar. It may lie at the far end, where it counts more in second moments than a mean gram.
    """
    density = job.crankshaft.density_g_mm3
    one, other = source.moments(density, frame), slice_moments(source.solid.mesh, density, frame)
    bound, way = ROUNDING, "tetrahedra"
    refuse_overlap_exactly(source.solid)
    if source.exact is not None:
        hidden = estimate_chordal_error(source.solid.mesh, density, frame)
        other, way = other + hidden.missing, "true surfaces"
        far_mm2 = float((source.solid.mesh.moved(frame).vertices ** 2).sum(axis=1).max())
        mean_mm2 = float(np.trace(one.second_g_mm2)) / one.mass_g
        bound += FACET_BARS * hidden.mass_bar_g / one.mass_g * far_mm2 / mean_mm2
    difference = agreement(one, other)
    if not difference <= bound:
        raise ClaimError(
            f"{claims.name}: moments from {way} and from slices differ by {difference:.3g} of their size; "
            f"expected {bound:.3g}"
        )
    claims.note(f"moments from {way} and from slices", 0.0, difference, bound)
    if source.exact is not None:
        return difference
    by_others = agreement(one, trimesh_moments(source.solid.mesh, density, frame))
    if not by_others <= bound:
        raise ClaimError(
            f"{claims.name}: moments from {way} and by trimesh differ by {by_others:.3g} of their size; "
            f"expected {bound:.3g}"
        )
    claims.note(f"moments from {way} and by trimesh", 0.0, by_others, bound)
    return max(difference, by_others)


def size_of(source: Source, crank: Moments) -> float:
    """Return the upper bound of ∫ |r| dm, the scale of rounding of first moments [g·mm]."""
    return crank.mass_g * (source.solid.mesh.diagonal_mm + float(np.abs(source.solid.bounds).max()))


def pressed_in(claims: Claims) -> Moments:
    """Return the moments of the slugs, which are not in the file."""
    total = Moments.zero()
    for part in claims.entries("corrections"):
        keys = keys_of_pressed_in(part)
        if keys is not None:
            total = total + Moments.point(part.get(keys[0], float), part.array(keys[1], (3,)))
    return total


def check_with_slugs(claims: Claims, after: Moments) -> None:
    """Check mass and centre with the slugs, where a report has them."""
    if "final_with_slugs" in claims.values:
        reach = float(np.sqrt(np.trace(after.second_g_mm2) / after.mass_g))
        claims.near("final_with_slugs.mass_g", after.mass_g, after.mass_g)
        claims.near("final_with_slugs.centre_of_mass_mm", after.centre_mm, reach)


def keys_of_pressed_in(correction: Claims) -> tuple[str, str] | None:
    """Return the keys of mass and centre of a correction's slug; None where it presses none in."""
    kind = KINDS.get(correction.get("kind", str))
    return None if kind is None else kind.pressed_in


def webs_left(files: Files, crank: Crank, after: Solid | None) -> tuple[WebMetal, ...]:
    """Return the metal left in the webs between two solids; both are kept, so that no identity recurs."""
    before = crank.source.solid
    key = ("webs", id(before), id(after), id(crank.anatomy))
    return files.once(key, lambda: (web_metal(before, after, crank.anatomy), crank, after))[0]


# --- the crank as it came -----------------------------------------------------------------------------------


def input_path(claims: Claims, folder: Path, of: str = "input", key: str = "file") -> Path:
    """Return the crank's file: relative to the report, else where the job finds it, else beside the report.

    Beside it lies the crank of a report that was copied elsewhere with its files. Callers check its hash.
    ``of`` is its key in the report, ``key`` that in the job: the crank's own, or its scan's.
    """
    name = Path(claims.get(f"{of}.file", str))
    job = claims.get("job", dict)
    crank = (job.get("crankshaft") or {}).get(key)
    places = [folder / name, name]
    if isinstance(crank, str) and isinstance(job.get("file"), str) and not name.is_absolute():
        places.append((folder / job["file"]).parent / crank)
    solid = claims.get("outputs", dict).get("solid")
    if not (isinstance(solid, dict) and solid.get("file") == name.name):  # a stage cuts the like-named solid
        places.append(folder / name.name)
    return next((place for place in places if place.is_file()), places[0])


def source_before(claims: Claims, folder: Path, job: Job, files: Files) -> Source:
    """Return the crank before a report's cuts, read as the checks read it."""
    crankshaft, path = job.crankshaft, input_path(claims, folder)
    if claims.get("command", str) != "recut":
        return read_input(files, path, crankshaft)
    if not path.is_file():
        path = (folder / claims.get("previous.report", str)).parent / path.name
    untouched = claims.get("input_is_untouched", bool)
    body = crankshaft.body if untouched else "all"
    return files.read(
        path,
        crankshaft.unit,
        body,
        pressed_up=untouched and not crankshaft.crankpin_in_file,
        holes=crankshaft.holes,
    )


def read_input(files: Files, path: Path, crankshaft: Crankshaft) -> Source:
    pressed_up = not crankshaft.crankpin_in_file
    return files.read(path, crankshaft.unit, crankshaft.body, pressed_up=pressed_up, holes=crankshaft.holes)


def check_input(claims: Claims, folder: Path, job: Job, anatomy: Anatomy, files: Files) -> OriginalCrank:
    """Check the claims of the crank before correction; return it.

    Raises
    ------
    FileError
        If its file is missing: what went from it could be claimed at will.
    """
    path = input_path(claims, folder)
    if not path.is_file():
        raise FileError(
            f"{claims.name}: input.file {path} is missing; put the crank that was corrected there or "
            "next to the report, to compare the removed metal"
        )
    crankshaft = job.crankshaft
    source = read_input(files, path, crankshaft)
    check_source(claims, "input", source)
    if path.resolve() == (folder / claims.get("input.file", str)).resolve():
        claims.hold("input.file")
    else:
        _refuse_other_name(claims, path)
        claims.ledger.why_not["input.file"] = f"it was found as {path}"
    hints = crankshaft.overrides
    anatomy_found = files.once(
        ("recognised", id(source), repr(hints)), lambda: measured_crank.recognised(source, hints)
    )
    return check_crank(claims, job, source, anatomy_found, anatomy.file_to_rotor, files)


def _refuse_other_name(claims: Claims, path: Path) -> None:
    """Refuse a file that is missing under the name of another: a copied report keeps its crank's name.

    Raises
    ------
    ClaimError
        If the crank that was found has another name than the report states.
    """
    stated = claims.get("input.file", str)
    if Path(stated).name != path.name:
        raise ClaimError(f"{claims.name}: input.file is {stated!r}, but the job's crank is {path.name!r}")


def check_crank(
    claims: Claims, job: Job, source: Source, anatomy_found: Anatomy, frame: Array, files: Files
) -> OriginalCrank:
    """Check the mass properties of a crank before correction, as it was recognised; return it.

    They are taken in the report's own frame, which was found again where it could be.
    """
    given_density, own = density_before(claims, job), job.crankshaft
    key = (
        "crank",
        id(source),
        given_density,
        repr(own.readings),
        repr(own.scan),
        job.balance.margin,
        job.balance.facet_correction,
    )
    crank = files.once(
        key,
        lambda: measured_crank.measured_source(
            source, anatomy_found, given_density, job.balance, read_as=own
        ),
    )
    density = crank.density_g_mm3
    if abs(density - own.density_g_mm3) > ROUNDING * density:
        claims.near("crank.calibration.density_kg_m3", density / G_PER_MM3_PER_KG_M3, density)
    if crank.mass_pm_g is not None and "mass_pm_g" in claims.get("crank", dict):
        claims.near("crank.mass_pm_g", crank.mass_pm_g, crank.mass_pm_g)
    if source.patches:
        claims.same("input.repairs", list(crank.repairs))
    if crank.weighed is not crank and crank.weighed.source.patches:
        claims.same("input.scan.repairs", list(crank.weighed.repairs))
    bare = source.moments(density, frame)
    added = crank.calibrated
    if crank.facets is not None:
        added = added + crank.correction.part(crank.facets.missing)
    check_properties(claims, "crank", bare + added, source.volume_mm3 + added.mass_g / density)
    return OriginalCrank(crank, bare)


def check_source(claims: Claims, of: str, source: Source) -> None:
    """Check the claims of a file that a run read, at a key of the report."""
    digest = claims.get(f"{of}.sha256", str)
    if digest != source.sha256:
        name = Path(claims.get(f"{of}.file", str)).name
        raise ClaimError(
            f"{claims.name}: {name} is another file than the run read: {of}.sha256 is {digest!r}, but "
            f"{source.sha256!r} was found; balance again, or put the old file back"
        )
    claims.hold(f"{of}.sha256")
    claims.same(f"{of}.triangles", source.triangles)
    claims.same(f"{of}.format", None if source.format is None else source.format.removesuffix("-ascii"))
    claims.same(f"{of}.bodies", source.bodies)
    if not source.patches:  # what those may cost is known of the crank
        claims.same(f"{of}.repairs", list(source.repairs))


def hidden_part(
    claims: Claims, job: Job, anatomy: Anatomy, given_in: OriginalCrank, soup: Floats | None
) -> Moments:
    """Check and return the moments added for the facets of the corrected solid, loose triangles ``soup``."""
    even = given_in.crank.calibrated
    if claims.get("crank", dict).get("facet_error") is None or not job.balance.facet_correction:
        return even
    key = "crank.facet_error.added"
    source, facets = given_in.source, given_in.facets
    correction = None if facets is None else FacetCorrection.of(facets, True)
    claims.same("crank.facet_error.correction", None if correction is None else correction.verdict)
    if facets is None or correction is None or not correction.mass:
        claims.same(key, None)
        return even
    before = correction.part(facets.missing)
    left = correction.left(facets, anatomy)
    whole = given_in.crank.beside is not None  # the scan's facets, which the drawing's cuts leave alone
    after = before if soup is None or left is None or whole else left(soup)
    for name, moments in (("before", before), ("after", after)):
        size = facets.gross_mass_g * source.solid.mesh.diagonal_mm
        claims.near(f"{key}.{name}.mass_g", moments.mass_g, facets.gross_mass_g)
        claims.near(f"{key}.{name}.unbalance_g_mm", moments.first_g_mm[:2], size)
        reach = size * source.solid.mesh.diagonal_mm
        claims.near(f"{key}.{name}.moment_g_mm2", moments.second_g_mm2[:2, 2], reach)
        claims.near(
            f"{key}.{name}.polar_inertia_kg_mm2", moments.polar_inertia_g_mm2 / 1000.0, reach / 1000.0
        )
    return after + even


# --- the other files ----------------------------------------------------------------------------------------


def check_pages(claims: Claims, folder: Path) -> None:
    """Check the sha256 of every other file that the report names.

    Raises
    ------
    FileError
        If one is gone.
    ClaimError
        If one is another.
    """
    for key, entry in claims.get("outputs", dict).items():
        if key == "solid":
            continue
        if key == "solid_holds_slugs":
            claims.same(f"outputs.{key}", False)
            continue
        place = f"outputs.{key}"
        name = claims.get(f"{place}.file", str)
        if not isinstance(entry, dict) or Path(name).name != name:
            raise FormatError(
                f"{claims.name}: {place}.file is {name!r}; expected the name of a file beside it"
            )
        path = folder / name
        if not path.is_file():
            raise FileError(
                f"{path} is missing, but {claims.name} lists it ({place}); put it back, or write the "
                "report again without it (--only)"
            )
        note_read(path)
        claims.same(f"{place}.sha256", hashlib.sha256(path.read_bytes()).hexdigest())
        claims.hold(f"{place}.file")
        claims.ledger.unread[place] = f"{name} is the file that was listed; what it shows was not read"
