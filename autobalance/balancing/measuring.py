"""One pass of the loop: the untouched crank cut to planned depths, and measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING

import numpy as np

from autobalance.balancing.rotor_from_job import Rotor
from autobalance.balancing.web_metal import one_by_one
from autobalance.correction.contract import Correction, Cut
from autobalance.correction.cut import Made, as_taken
from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import RecognitionError, SolidError
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.csg.tool import Tool, placed
from autobalance.solid.formats.read import as_read, source_of
from autobalance.solid.formats.write import Written
from autobalance.solid.mesh.measure import soup_moments
from autobalance.solid.soundness.repair import without_crowds
from autobalance.solid.soundness.validate import without_flakes
from autobalance.types import Array, Floats
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.solid.cad.build import MetalTaken


# Measuring of a cut crank: on the bytes of its file, on its own triangles, or on its true surfaces.


SAME_VOLUME = 1e-9
"""Share by which the volume read back may differ from that of the loose triangles written."""
MAX_SURFACE_DIFFERENCE_SHARE = 0.02
"""Share of the metal moved by which true surfaces and triangles may differ, beyond the facets' error."""
MAX_SUM_DIFFERENCE_SHARE = 5e-3
"""Share of the metal moved by which cuts one by one may differ from all of them together."""
ADD_UP = 1e-3
"""The same share for all cuts as they are listed, beyond the rounding of files."""
DEVIATION_MM = 0.02
"""Distance of facets from true surfaces."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Measurement of a corrected crank (rotor frame), and the bytes of its file if they were measured.

    ``triangles`` is None where the file keeps true surfaces; ``surfaces`` counts these by kind then, and
    ``hidden`` is their excess over the triangles of the same cut. ``added`` is the estimate of the metal that
    facets hide, where that counts. ``taken`` has an entry a cut, or none at all: a correction as measured on
    the metal that its tool took, None where that is the one planned. ``read_back`` is the solid in the file
    with its crumbs, where that was built to be looked at. ``facets`` are those that a reader lays on true
    surfaces: other ones than the cut of the crank's own facets.
    """

    moments: Moments
    triangles: int | None
    data: bytes | None = None
    surfaces: Mapping[str, int] | None = None
    hidden: Moments | None = None
    added: Moments = field(default_factory=Moments.zero)
    taken: tuple[Correction | None, ...] = ()
    read_back: Solid | None = None
    facets: Solid | None = None


Measure = Callable[[Rotor, Solid, Made], Measured]
"""Takes a rotor, its crank as cut (file coordinates [mm]) and the cuts; the verdict is on its result."""


def in_memory(rotor: Rotor, solid: Solid, cut_depths: Made) -> Measured:
    """Measure the solid's own triangles, in double precision."""
    vertices, triangles = solid.mesh.vertices, solid.mesh.triangles
    return _on_triangles(rotor, vertices[triangles], None)


def as_file(format: str, mm_per_unit: float) -> Measure:  # noqa: A002
    """Return the way to measure a solid as a file of this format and unit holds it: its bytes, read back."""

    def measure(rotor: Rotor, solid: Solid, cut_depths: Made) -> Measured:
        written = Written.of(solid.mesh, format, mm_per_unit)
        adds = any(cut.adds_metal for cut, _ in cut_depths)
        measured = _on_triangles(rotor, written.soup, written.data)
        again = None
        if adds or len(written.soup) != solid.triangle_count:
            again = _as_read_back(written, measured.moments.mass_g / rotor.density_g_mm3)
            if adds:
                refuse_lost_crank(rotor, again)
        return replace(measured, read_back=again if written.solid is None else written.solid)

    return measure


def _as_read_back(written: Written, own_mm3: float) -> Solid:
    """Return the solid that a reader makes of the triangles of a file, checked as ``verify`` checks it.

    As many triangles as the solid has, without flakes beside it, are read as that solid: there is nothing
    to look at. Where rounding made triangles collapse, and with added metal, it may be another solid.

    Raises
    ------
    SolidError
        If it is another solid than the one written, or none.
    """
    soup, known = written.soup, written.solid
    if known is None or without_crowds(known.mesh)[1]:
        again = source_of(soup, "mm", "all", unite=False).solid
    else:  # a weld would number its vertices in another order, and build the same of them
        again = as_read(known)
    if abs(again.volume_mm3 - own_mm3) > SAME_VOLUME * own_mm3:
        raise SolidError(
            f"the written solid has {own_mm3:.9g} mm³, but {again.volume_mm3:.9g} mm³ are read back; expected"
            " cuts or added metal that can be distinguished: another face, or less of it"
        )
    return again


def refuse_lost_crank(rotor: Rotor, written: Solid) -> None:
    """Refuse a written solid with added metal in which the crank is lost.

    Metal that is taken off leaves journals and pins alone; added metal may hide them.

    Raises
    ------
    SolidError
        If no crank is found, or one with another number of throws or main journals.
    """
    hints = Overrides(crankpin_in_file=None)
    try:
        before = recognise(rotor.solid, hints)
    except RecognitionError:  # reported before
        return
    try:
        after = recognise(written, hints)
    except RecognitionError as error:
        raise SolidError(f"add: the crank is not found any more in the corrected solid: {error}") from None
    if len(after.throws) != len(before.throws) or len(after.main_journals) != len(before.main_journals):
        raise SolidError(
            f"add: the corrected solid has {len(after.throws)} throws and {len(after.main_journals)} main "
            f"journals, the crank {len(before.throws)} and {len(before.main_journals)}; expected the same"
        )


def _on_triangles(rotor: Rotor, soup: Floats, data: bytes | None) -> Measured:
    """Measure loose triangles (m, 3, 3) [mm]."""
    moments = soup_moments(soup, rotor.density_g_mm3, rotor.anatomy.file_to_rotor)
    added = Moments.zero() if rotor.hidden is None else rotor.hidden(soup)
    return Measured(moments, len(soup), data, added=added)


def on_true_surfaces(rotor: Rotor, in_facets: Solid, cut_depths: Made) -> Measured:
    """Cut the exact solid, write it, and measure it as it is read again; ``in_facets`` is the same cut.

    Raises
    ------
    SolidError
        If the CAD kernel cannot make the cut, or makes another one.
    """
    from autobalance.solid.cad.brep import written_and_read

    exact = rotor.exact
    assert exact is not None  # checked where this way of measuring was chosen
    removed: list[Tool] = []
    added: list[Tool] = []
    removes: list[int] = []
    for number, (cut, depth) in enumerate(cut_depths):
        tool = cut.exact_tool(depth)
        if tool is not None:
            (added if cut.adds_metal else removed).append(placed(tool, rotor.anatomy.rotor_to_file))
            removes += [] if cut.adds_metal else [number]
    machined, took = exact.solid.machined_as_taken(removed, added)
    by_tool = dict(zip(removes, took, strict=True))
    each = exact.solid.each_taken(removed, added, machined)
    data, read_back = written_and_read(exact, machined)
    again = read_back.solid
    if added:
        refuse_lost_crank(rotor, read_back.mesh)
    density, frame = rotor.density_g_mm3, rotor.anatomy.file_to_rotor
    moments, faceted = again.moments(density, frame), in_facets.moments(density, frame)
    hidden = moments - faceted
    drawn = rotor.moments - rotor.added
    hidden_before = drawn - rotor.solid.moments(density, frame)
    cut_g = abs(drawn.mass_g - moments.mass_g)
    if abs(hidden.mass_g - hidden_before.mass_g) > MAX_SURFACE_DIFFERENCE_SHARE * cut_g + abs(
        hidden_before.mass_g
    ):
        raise SolidError(
            f"the CAD kernel leaves {moments.mass_g:.6g} g where {faceted.mass_g:.6g} g were planned; "
            "expected the same cut in both; a mesh of the part can be balanced instead"
        )
    if each is None:
        own = tuple(_as_taken(rotor, one, by_tool.get(number)) for number, one in enumerate(cut_depths))
    else:
        own = one_by_one(rotor, cut_depths, *each)
    if any(own):
        _refuse_contradiction(cut_depths, own, moments - drawn, density)
    return Measured(moments, None, data, again.face_kinds(), hidden, rotor.added, own, facets=read_back.mesh)


def refuse_sum(rotor: Rotor, measured: Measured, corrections: Sequence[Correction]) -> None:
    """Refuse listed corrections whose volumes do not add up to the metal removed.

    Raises
    ------
    SolidError
        If they do not.
    """
    volumes = [each.removed_volume_mm3 for each in corrections]
    drawn = rotor.moments - rotor.added
    before = rotor.solid.volume_mm3 if measured.surfaces is None else drawn.mass_g / rotor.density_g_mm3
    total, removed_mm3 = sum(volumes), before - measured.moments.mass_g / rotor.density_g_mm3
    bounds = np.abs(rotor.solid.bounds)
    near = float(np.spacing(np.float32(bounds.max())))
    near += 0.0 if measured.surfaces is None else DEVIATION_MM  # cuts are listed as the facets have them
    if abs(total - removed_mm3) > ADD_UP * sum(map(abs, volumes)) + near * rotor.solid.area_mm2:
        raise SolidError(
            f"the cuts take {total:.6g} mm³ one by one, but {removed_mm3:.6g} mm³ are gone; "
            "expected cuts that keep clear of each other: other faces, or fewer of them"
        )


def _as_taken(rotor: Rotor, one: tuple[Cut, float], took: MetalTaken | None) -> Correction | None:
    """Return a cut's correction as measured on the metal that its tool took; None where it took none."""
    if took is None or min(took.volume.mass_g, took.floor.mass_g) <= 0.0:
        return None
    cut, depth = one
    change, rate = (
        each.moved(rotor.anatomy.file_to_rotor).scaled(-rotor.density_g_mm3)
        for each in (took.volume, took.floor)
    )
    return as_taken(cut.correction(depth), change, rate, took.floor.mass_g)


def _refuse_contradiction(
    cut_depths: Made, own: Sequence[Correction | None], whole: Moments, density_g_mm3: float
) -> None:
    """Refuse a solid whose edges lie so far off its faces that its cuts do not add up to the metal removed.

    Raises
    ------
    SolidError
        If they do not.
    """
    volumes = [
        (cut.correction(depth) if mine is None else mine).removed_volume_mm3
        for (cut, depth), mine in zip(cut_depths, own, strict=True)
    ]
    total, removed_mm3 = sum(volumes), -whole.mass_g / density_g_mm3
    if abs(total - removed_mm3) > MAX_SUM_DIFFERENCE_SHARE * sum(map(abs, volumes)):
        raise SolidError(
            f"the cuts remove {total:.6g} mm³ singly, but {removed_mm3:.6g} mm³ together: the file's edges "
            "lie off its faces there. Export it with a tighter tolerance, or use a mesh of the part"
        )


# One pass of the loop: the untouched crank cut to planned depths, and measured.


@dataclass(frozen=True, eq=False)
class Pass:
    """A cut crank as it was measured, and the bodies of its cuts (rotor frame).

    ``metal`` is the metal that all of them took of a scanned crank, in the file's axes; None of a drawn one.
    """

    depths_mm: Array
    tools: tuple[Solid, ...]
    solid: Solid
    measured: Measured
    moments: Moments
    residual: Unbalance
    share: float
    metal: Solid | None = None


def cut_and_measure(
    rotor: Rotor,
    tolerance: Tolerance,
    cuts: Sequence[Cut],
    depths_mm: Array,
    measure: Measure,
) -> Pass:
    """Cut the untouched crank to these depths, one a cut, and measure it.

    Raises
    ------
    SolidError
        If the cut cannot be made, or the cut solid is not a crank any more.
    """
    cut_depths = made_cuts(cuts, depths_mm)
    tools = tuple(cut.tool(depth) for cut, depth in cut_depths)
    solid, pressed_in, metal = rotor.solid, Moments.zero(), None
    for adds in (True, False):
        chosen = [tool for tool, (cut, _) in zip(tools, cut_depths, strict=True) if cut.adds_metal == adds]
        if chosen:
            tool = union(chosen).moved(rotor.anatomy.rotor_to_file)
            if adds:
                solid = solid + tool
            elif rotor.anatomy.scan is None:
                solid = solid - tool
            else:
                metal, solid = solid.split(tool)
    solid = without_flakes(solid, rotor.solid)
    for cut, depth in cut_depths:
        pressed_in = pressed_in + cut.pressed_in(depth)
    measured = measure(rotor, solid, cut_depths)
    moments = measured.moments + measured.added + pressed_in
    residual = Unbalance.of(moments + rotor.loads)
    return Pass(depths_mm, tools, solid, measured, moments, residual, tolerance.used_share(residual), metal)


def made_cuts(cuts: Sequence[Cut], depths_mm: Array) -> tuple[tuple[Cut, float], ...]:
    """Return the cuts that are made, each with its depth."""
    return tuple((cut, float(depth)) for cut, depth in zip(cuts, depths_mm, strict=True) if depth > 0.0)
