"""Reading of files to checked solids, in mm, in the file's axes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from autobalance.disk_cache import kept
from autobalance.errors import BodiesError, FormatError, OverlapError, SolidError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.difference import united
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.gltf import file_bytes
from autobalance.solid.formats.raw import Raw
from autobalance.solid.formats.registry import FOREIGN_CAD, FORMATS, format_of, kind_of
from autobalance.solid.mesh.mesh import Mesh, in_space_order, weld, without_collapsed
from autobalance.solid.soundness.bodies import bodies_of, chosen_bodies
from autobalance.solid.soundness.holes import ClosedHole, OpenHoles, filled
from autobalance.solid.soundness.repair import MAX_MOVED_SHARE, solid_of, volume_change
from autobalance.solid.soundness.validate import check_solid, refuse_overlap
from autobalance.types import Array, Floats
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.solid.cad.brep import Exact
    from autobalance.solid.cad.files import CadFile
    from autobalance.solid.cad.tessellation import Surfaces

FARTHEST_MM = 1e7
"""Largest coordinate: ten kilometres leave no digit for a crank, and products would overflow."""

How = tuple[str, str | None, int | str | None, bool, bool | None, OpenHoles]
"""Format, unit, body, pressed_up, unite and holes, as ``read`` takes them."""
REFUSED_HOLES = OpenHoles()
"""Default treatment of holes: a mesh that is open for more than small plane holes is not a solid."""


@dataclass(frozen=True, eq=False)
class Source:
    """A crank as its file gives it.

    Attributes
    ----------
    solid : Solid
        Checked, outward, in the file's coordinates [mm].
    format : str or None
        Format for ``encode`` and ``decode``, unless the surfaces are exact; None: it is of no file.
    mm_per_unit : float
        Millimetres in one unit of the file.
    sha256 : str
        Of the file's bytes, in hexadecimal.
    triangles : int
        In the file, before anything was repaired.
    bodies : int
        In the file, before one was chosen.
    repairs : tuple of str
        Repairs of the mesh, one line each.
    exact : Exact or None
        The solid with its true surfaces, where the format keeps them; ``solid`` is only tessellated then.
    in_memory_file : bytes or None
        The file that a shape in memory could have come in; None if there is one, or for a mesh.
    step_mm : float
        Between two coordinates that the file can distinguish at its far end, by its digits or its numbers;
        0 where that follows from ``format`` alone.
    patches : tuple of ClosedHole
        Holes that were closed.
    key : str
        Stands for file, and how it was read, in the cache; empty for a solid of no file.
    """

    solid: Solid
    format: str | None
    mm_per_unit: float
    sha256: str
    triangles: int
    bodies: int
    repairs: tuple[str, ...]
    exact: Exact | None = None
    step_mm: float = 0.0
    in_memory_file: bytes | None = None
    patches: tuple[ClosedHole, ...] = ()
    key: str = ""

    @property
    def surfaces(self) -> Surfaces | None:
        """The solid's own planes and cylinders, where the format keeps them."""
        return None if self.exact is None else self.exact.surfaces

    @property
    def volume_mm3(self) -> float:
        """Volume [mm³], inside the true surfaces where they are known."""
        return self.solid.volume_mm3 if self.exact is None else self.exact.solid.volume_mm3

    def moments(self, density_g_mm3: float, frame: Array | None = None) -> Moments:
        """Return the mass moments, in ``frame`` (4, 4) if given, from the true surfaces where known."""
        solid = self.solid if self.exact is None else self.exact.solid
        return solid.moments(density_g_mm3, frame)


def read(
    path: Path,
    unit: str | None,
    body: int | str | None = None,
    pressed_up: bool = False,
    unite: bool | None = None,
    holes: OpenHoles = REFUSED_HOLES,
) -> Source:
    """Read a solid from a file, check it, and report its repairs.

    Parameters
    ----------
    path : Path
        Its ending names the format.
    unit : str or None
        mm, cm, m or inch; required if the format carries no unit, and an error if it carries another.
    body : int or str or None
        Which body, numbered from 1 by falling volume, or its name where the format has names; "all" unites
        them, overlaps counting once.
    pressed_up : bool
        Whether the file may hold one body for each half of a crank; all are taken.
    unite : bool, optional
        Whether metal that counts twice is to count once instead of being refused; unless set, with
        ``body`` "all".

    Raises
    ------
    FileError
        If the file is missing, is a folder or cannot be read.
    FormatError
        If it breaks its format, or its unit is not known.
    SolidError
        If the mesh is open, bounds nothing, overlaps itself, or holds several bodies and none was chosen.
    """
    name, _ = _format(path)
    how = name, unit, body, pressed_up, unite, holes
    try:
        return _kept_source(path, how)
    except (FormatError, SolidError) as error:
        raise _named(path, error) from None


def _kept_source(path: Path, how: How) -> Source:
    """Return the solid of a file, from the cache where its bytes were read before in the same way."""
    whole = [file_bytes(path)]
    sha256 = _sha256(whole[0])
    key = repr((sha256, *how))
    name, unit, body, pressed_up, unite, holes = how
    made: list[Mesh] = []

    def work() -> Source:
        # one by one: *how would hold the file's bytes in a tuple while the solid is built
        source = source_of_bytes(whole.pop(), name, unit, body, pressed_up, unite, holes, sha256)
        if source.exact is None:
            made.append(source.solid.mesh)
        return source

    found = replace(kept("source", key, work), key=key)
    for mesh in made:
        found.solid.mesh.take_over(mesh)
    return found


def source_of_bytes(
    data: bytes,
    name: str,
    unit: str | None,
    body: int | str | None = None,
    pressed_up: bool = False,
    unite: bool | None = None,
    holes: OpenHoles = REFUSED_HOLES,
    sha256: str = "",
) -> Source:
    """Return the checked solid of the bytes of a file of the format ``name``; the rest is as for ``read``.

    ``sha256`` is their digest where it is known.
    """
    kind = FORMATS[name]
    digest = sha256 or _sha256(data)
    if kind.read_exact is not None:
        return source_of_cad(kind.read_exact(data), digest, name, unit, body, pressed_up)
    with np.errstate(all="ignore"):  # numbers that overflow are refused with those that are not finite
        raw = kind.read(data)
    mm_per_unit = _mm_per_unit(raw.unit, raw.mm_per_unit, unit, name)
    triangles, written_as, step_mm = len(raw.soup), kind_of(name, data), mm_per_unit * _step(raw)
    mesh, notes = _welded(raw, mm_per_unit)
    del data, raw  # the solid takes many times their memory: not at the same time
    mesh, patches = filled(mesh, holes)
    solid, bodies, repairs = _solid(mesh, body, pressed_up, unite is not False, step_mm)
    unites = body == "all" if unite is None else unite
    solid, changed = _checked(solid, bool(repairs) or bodies > 1, unites, patches)
    return Source(
        solid=solid,
        format=written_as,
        mm_per_unit=mm_per_unit,
        sha256=digest,
        triangles=triangles,
        bodies=bodies,
        repairs=(*notes, *repairs, *changed),
        step_mm=step_mm,
        patches=patches,
    )


def every_source(data: bytes, name: str, unit: str | None) -> list[Source]:
    """Return each checked body in the bytes of a mesh's file of the format ``name``, by falling volume."""
    with np.errstate(all="ignore"):  # as in ``source_of_bytes``
        raw = FORMATS[name].read(data)
    mm_per_unit = _mm_per_unit(raw.unit, raw.mm_per_unit, unit, name)
    mesh, notes = _welded(raw, mm_per_unit)
    solid, repairs = solid_of(mesh, mm_per_unit * _step(raw), MAX_MOVED_SHARE)
    bodies, turned = bodies_of(solid)
    doubtful = bool(repairs or turned) or len(bodies) > 1
    facts = Source(
        solid=solid,
        format=kind_of(name, data),
        mm_per_unit=mm_per_unit,
        sha256=_sha256(data),
        triangles=len(raw.soup),
        bodies=len(bodies),
        repairs=(*notes, *repairs, *turned),
        step_mm=mm_per_unit * _step(raw),
    )
    return [replace(facts, solid=_checked(body.solid, doubtful, unite=False)[0]) for body in bodies]


def source_of(
    soup: Floats,
    unit: str,
    body: int | str | None = None,
    pressed_up: bool = False,
    unite: bool | None = None,
    holes: OpenHoles = REFUSED_HOLES,
) -> Source:
    """Return the checked solid of a mesh in memory, as ``read`` does of a file's.

    Parameters
    ----------
    soup : (m, 3, 3) float
        Corners of its triangles, in ``unit``.
    unit, body, pressed_up, unite
        As for ``read``.

    Raises
    ------
    FormatError
        If a number is not finite, or the unit is not known.
    SolidError
        If the mesh is open, bounds nothing, or holds several bodies and none was chosen.
    """
    raw = Raw(soup)
    mm_per_unit = _mm_per_unit(raw.unit, raw.mm_per_unit, unit, "mesh")
    mesh, notes = _welded(raw, mm_per_unit)
    mesh, patches = filled(mesh, holes)
    solid, bodies, repairs = _solid(mesh, body, pressed_up, unite is not False, mm_per_unit * _step(raw))
    unites = body == "all" if unite is None else unite
    solid, changed = _checked(solid, bool(repairs) or bodies > 1, unites, patches)
    return Source(
        solid=solid,
        format=None,
        mm_per_unit=mm_per_unit,
        sha256=_sha256(np.ascontiguousarray(soup).tobytes()),
        triangles=len(soup),
        bodies=bodies,
        repairs=(*notes, *repairs, *changed),
        patches=patches,
    )


def _named(path: Path, error: FormatError | SolidError) -> FormatError | SolidError:
    """Return an error of the same kind with the file's path before its message."""
    text = f"{path}: {error}"
    if isinstance(error, BodiesError):
        return BodiesError(text, error.bodies)
    return OverlapError(text, error.volume_mm3) if isinstance(error, OverlapError) else type(error)(text)


def _checked(
    solid: Solid, doubtful: bool, unite: bool, patches: Sequence[ClosedHole] = ()
) -> tuple[Solid, list[str]]:
    """Return a solid that passed the final checks, and a note if it had to be united for that.

    Patches of ragged rims may fold by less than their uncertainty.
    """
    try:
        check_solid(solid, doubtful)
    except OverlapError as error:
        if error.volume_mm3 <= sum(patch.volume_pm_mm3 for patch in patches):
            return solid, []
        if not unite:
            raise
    else:
        return solid, []
    now = united(solid)
    check_solid(now, doubtful=True)
    change = volume_change(solid.volume_mm3, now.volume_mm3)
    return now, [f"the solid overlapped itself: united, so that all of its metal counts once; {change}"]


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def source_of_cad(
    file: CadFile, sha256: str, name: str, unit: str | None, body: int | str | None, pressed_up: bool = False
) -> Source:
    """Return the checked solid of a CAD file whose bytes have the digest; the rest is as for ``read``."""
    from autobalance.solid.cad.brep import exact_of
    from autobalance.solid.cad.files import in_unit

    carried = None if file.unit is None else MM_PER[file.unit]
    mm_per_unit = _mm_per_unit(file.unit, carried, unit, name)
    if file.unit is None:
        file = in_unit(file, str(unit))
    exact = exact_of(file, body, pressed_up)
    return Source(
        solid=exact.mesh,
        format=name,
        mm_per_unit=mm_per_unit,
        sha256=sha256,
        triangles=exact.triangles,
        bodies=exact.bodies,
        repairs=exact.repairs,
        exact=exact,
    )


def _format(path: Path) -> tuple[str, Format]:
    kind = format_of(path)
    if kind is None and path.suffix.lower() in FOREIGN_CAD:
        raise FormatError(f"{path} is a file of a CAD program; export STEP from it")
    if kind is None:
        known = " ".join(f".{ending}" for ending in FORMATS)
        raise FormatError(f"{path}: the ending '{path.suffix}' is not known; expected one of {known}")
    return kind.name, kind


def _mm_per_unit(unit: str | None, carried: float | None, unit_asked: str | None, name: str) -> float:
    """Return the length of a file's unit [mm]: of the one that it carries, or else of the one requested."""
    known = ", ".join(MM_PER)
    if unit_asked is not None and unit_asked not in MM_PER:
        raise FormatError(f"the unit '{unit_asked}' is not known; expected one of {known}")
    if carried is not None:
        if unit_asked is not None and MM_PER[unit_asked] != carried:
            raise FormatError(
                f"the file is in {unit}, the unit given is {unit_asked}; leave it out or correct it"
            )
        return carried
    if unit_asked is None:
        raise FormatError(f"{name.upper()} carries no unit; expected unit = one of {known}")
    return MM_PER[unit_asked]


def _step(raw: Raw) -> float:
    """Return the step between coordinates at the far end of a file, in its unit."""
    number = raw.soup.dtype.type
    reach = number(max(abs(float(raw.soup.min())), abs(float(raw.soup.max()))))
    return max(raw.step, float(np.spacing(reach)))


def _welded(raw: Raw, mm_per_unit: float) -> tuple[Mesh, list[str]]:
    """Return the triangles of a file with shared vertices [mm], and notes on the welding."""
    soup = raw.soup
    distinct, number = weld(soup.reshape(-1, 3))
    farthest = mm_per_unit * max(abs(float(distinct.min())), abs(float(distinct.max())))
    if farthest > FARTHEST_MM:
        raise FormatError(
            f"a corner lies {farthest:.3g} mm from the file's origin; expected at most {FARTHEST_MM:g} mm; "
            "is the unit right?"
        )
    triangles = without_collapsed(number.reshape(-1, 3))
    mesh = Mesh(distinct.astype(np.float64) * mm_per_unit, triangles)
    notes = []
    if raw.vertices is not None and len(distinct) < raw.vertices:
        notes.append(f"exact weld: {raw.vertices} vertices became {len(distinct)}")
    if len(triangles) < len(soup):
        notes.append(f"{len(soup) - len(triangles)} collapsed triangles dropped")
    return in_space_order(mesh), notes


def _solid(
    mesh: Mesh, body: int | str | None, pressed_up: bool, unite: bool, step_mm: float
) -> tuple[Solid, int, list[str]]:
    """Return the solid wanted, the number of bodies in the mesh, and the repairs."""
    try:
        solid, notes = solid_of(mesh, step_mm, MAX_MOVED_SHARE)
    except SolidError:
        _refuse_overlap_beneath(mesh, step_mm)
        raise
    chosen, bodies, changes = chosen_bodies(solid, body, pressed_up, unite)
    return chosen, bodies, notes + changes


def _refuse_overlap_beneath(mesh: Mesh, step_mm: float) -> None:
    """Refuse a mesh with holes for its overlap, if it has any: that would be left with its holes filled."""
    try:
        solid, _ = solid_of(mesh, step_mm)
    except SolidError:
        return
    refuse_overlap(solid)


def as_read(solid: Solid) -> Solid:
    """Return the checked solid that a reader obtains from a file of a solid's own triangles, all bodies.

    Raises
    ------
    SolidError
        As for ``source_of``.
    """
    whole, bodies, repairs = chosen_bodies(solid, "all", pressed_up=False, unite=False)
    return _checked(whole, bool(repairs) or bodies > 1, unite=False)[0]
