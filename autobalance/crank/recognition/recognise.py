"""A crankshaft recognised in a solid: axis, main journals, throws, webs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Overrides, Pin, PinHint, Throw, Typed
from autobalance.crank.recognition import given
from autobalance.crank.recognition.bores import bore_runs
from autobalance.crank.recognition.candidates import Views, axis_candidates
from autobalance.crank.recognition.cylinder_runs import (
    CylinderRun,
    bare_cylinder,
    common_axis,
    find_runs,
)
from autobalance.crank.recognition.cylinders import all_cylinders, own_direction, own_layout
from autobalance.crank.recognition.datums import find_datums
from autobalance.crank.recognition.doubts import axis_doubts, journal_doubts, on_surface
from autobalance.crank.recognition.layout import (
    GapError,
    JournalLayout,
    completed,
    layout_with_pins,
    solid_layout,
)
from autobalance.crank.recognition.scan_cylinders import CREDIBLE_MM, RoughMesh, RoughViews
from autobalance.crank.recognition.section_stack import SectionStack, lengthwise, straightened
from autobalance.crank.recognition.through_shaft import clear_of
from autobalance.crank.recognition.typed import NothingThereError, contradictions, typed_and_found
from autobalance.crank.recognition.webs import find_webs, pressed_up_layout
from autobalance.disk_cache import kept
from autobalance.errors import RecognitionError
from autobalance.solid.cad.tessellation import CylinderFace
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness import DRAWN, MIN_TRIANGLES, SCANNED, flat_share
from autobalance.types import Array

SMOOTH_MESH_SHARE = 1e-6
"""A mesh without noise is off smooth surfaces by less than this share of its diagonal."""
WAVED_ROUGHNESS_RATIO = 3.0
"""Vertices of a drawn mesh that was waved are off its surfaces by up to so many times its roughness."""
SLIGHTLY_WAVED = 0.6
"""Share of triangles in one plane with a neighbour: a crank waved by 1 µm has 1/3, drawn ones nearly all."""
SLIGHT_TILT_RAD = 1e-4
"""Sections along an axis that is off by less than this still show the same circles."""


def recognise(
    solid: Solid, overrides: Overrides, cylinders: Sequence[CylinderFace] = (), source_key: str = ""
) -> Anatomy:
    """Return the crankshaft recognised in a solid.

    Parameters
    ----------
    solid : Solid
        In file coordinates [mm]; several bodies where the crankpins are not in the file.
    overrides : Overrides
        The job's own statements; nothing that it states is sought.
    cylinders : sequence of CylinderFace
        The solid's own, where its file keeps them: axis, journals and crankpins are theirs, not fitted.
    source_key : str
        Stands for the file that the solid was read from; empty: it is of none.

    Returns
    -------
    Anatomy

    Raises
    ------
    RecognitionError If something is not found; the message names the job key to set.
    """
    try:
        return kept(
            "anatomy",
            f"{source_key} {overrides!r}" if source_key else "",
            lambda: _recognised(solid, overrides, cylinders),
        )
    except RecognitionError as error:
        raise RecognitionError(_explained(error, solid, overrides, cylinders)) from None


def _explained(
    error: RecognitionError, solid: Solid, overrides: Overrides, cylinders: Sequence[CylinderFace]
) -> str:
    """Return a refusal; where the file contradicts what was typed, with what the file has instead."""
    plain = Overrides(crankpin_in_file=overrides.crankpin_in_file)
    texts: list[str] = []
    if _states_anything(overrides):
        with suppress(RecognitionError):  # then there is nothing to compare with
            texts = contradictions(recognise(solid, plain, cylinders), overrides)
    if not texts:
        end = ". Correct it" if isinstance(error, NothingThereError) else ""
        return given.without_given_keys(str(error), overrides) + end
    if isinstance(error, NothingThereError):
        return f"{error}; {'; '.join(texts)}. Correct it"
    fault = str(error).rpartition("; ")[0] or str(error)
    return f"{fault}; the job contradicts the file: {'; '.join(texts)}. Correct it"


def _states_anything(overrides: Overrides) -> bool:
    stated = (overrides.axis_point_mm, overrides.axis_direction, overrides.crankpins, overrides.main_journals)
    return any(each is not None for each in stated)


def _recognised(solid: Solid, overrides: Overrides, cylinders: Sequence[CylinderFace]) -> Anatomy:
    mesh = solid.mesh
    measured = cache(lambda: RoughMesh.of(mesh))
    flat = 1.0 if cylinders else flat_share(mesh, 0)
    if flat < SCANNED and len(mesh.triangles) >= MIN_TRIANGLES:
        rough = measured()
        if rough.local_mm > SMOOTH_MESH_SHARE * mesh.diagonal_mm:
            return _scanned_or_waved(rough, overrides, flat)
    elif flat < DRAWN and len(mesh.triangles) >= MIN_TRIANGLES:
        found_rough = _rough_if_it_is(measured, overrides, flat)
        if found_rough is not None:
            return found_rough
    found = _as_drawn(mesh, measured, overrides, cylinders, flat)
    if found.scan is not None:
        return _with_grey(found, flat)
    if flat >= SLIGHTLY_WAVED:
        return found
    from autobalance.crank.recognition.scanned import is_rough  # few meshes are that little flat

    return _as_rough_as_it_is(measured(), found, overrides, flat) if is_rough(mesh, found) else found


def _as_drawn(
    mesh: Mesh,
    measured: Callable[[], RoughMesh],
    overrides: Overrides,
    cylinders: Sequence[CylinderFace],
    flat: float,
) -> Anatomy:
    """Return the crank of a mesh whose surfaces are taken for drawn ones, or for a scan's where none is."""
    axis = given.given_axis(overrides)
    if axis is not None and overrides.crankpins is not None and overrides.main_journals is not None:
        return _from_job(mesh, overrides, axis)
    views = Views(mesh)
    try:
        return _with_or_without_pins(overrides, lambda known: _in_any_direction(views, known, cylinders))
    except RecognitionError as refusal:
        if flat >= SLIGHTLY_WAVED or len(mesh.triangles) < MIN_TRIANGLES:
            raise
        reason = refusal
    rough = measured()
    try:
        return _waved(rough, overrides, reason)
    except RecognitionError:
        if flat >= DRAWN:
            raise
    return _as_scanned(rough, overrides)


def _rough_if_it_is(measured: Callable[[], RoughMesh], overrides: Overrides, flat: float) -> Anatomy | None:
    """Return the crank of a mesh that is neither like a scan nor like a drawing; None if it is not rough.

    Sections clear of its waves tell: each face of a rough one would be a hundred levels to a drawing's.
    """
    from autobalance.crank.recognition.scanned import is_rough  # few meshes are that little flat

    with suppress(RecognitionError):
        rough = measured()
        mesh = rough.mesh
        if rough.local_mm <= SMOOTH_MESH_SHARE * mesh.diagonal_mm:
            return None
        with suppress(RecognitionError):
            drawn = _waved(rough, overrides, RecognitionError("not looked for"))
            return _as_rough_as_it_is(rough, drawn, overrides, flat) if is_rough(mesh, drawn) else None
        found = _as_scanned(rough, overrides)
        return _with_grey(found, flat) if is_rough(mesh, found) else None
    return None


def _scanned_or_waved(rough: RoughMesh, overrides: Overrides, flat: float = 0.0) -> Anatomy:
    """Return a rough crank recognised as a scan, else as a drawn one whose vertices were moved."""
    try:
        return _as_scanned(rough, overrides)
    except RecognitionError as refusal:
        if rough.local_mm > CREDIBLE_MM:  # a scan of a v6, decimated: journals were 0.2 mm off as drawn ones
            raise
        reason = refusal
    return _fallen_back(rough, _waved(rough, overrides, reason), overrides, flat, str(reason))


def _as_rough_as_it_is(rough: RoughMesh, drawn: Anatomy, overrides: Overrides, flat: float) -> Anatomy:
    """Return a crank that was recognised as drawn, and whose surface is rough, as a scan if it can be."""
    try:
        found = _as_scanned(rough, overrides)
    except RecognitionError as refusal:
        return _fallen_back(rough, drawn, overrides, flat, str(refusal))
    counted = [(len(each.main_journals), len(each.throws)) for each in (found, drawn)]
    if counted[0] != counted[1]:
        (journals, throws), _ = counted
        reason = f"found {journals} main journals and {throws} throws"
        return _fallen_back(rough, drawn, overrides, flat, reason)
    return _with_grey(found, flat)


def _fallen_back(rough: RoughMesh, drawn: Anatomy, overrides: Overrides, flat: float, reason: str) -> Anatomy:
    """Return a rough crank recognised as drawn with its roughness, and why it was not as a scan."""
    from autobalance.crank.recognition.scanned import rough_as_drawn  # for rough cranks alone

    held = given.given_axis(overrides) is not None
    found = rough_as_drawn(
        rough,
        drawn,
        held,
        f"the surface is rough, and no crank was found in it as in a scan: {reason}; journals, throws and"
        " webs were found as a drawn crank's: compare them with the crank; the roughness counts",
    )
    return _with_grey(found, flat)


def _with_grey(found: Anatomy, flat: float) -> Anatomy:
    """Return a scanned crank with a caution if more of its mesh is flat than of a scan."""
    if found.scan is None or flat < SCANNED:
        return found
    caution = (
        f"{100.0 * flat:.0f} % of its triangles lie in one plane with a neighbour, more than the"
        f" {100.0 * SCANNED:.0f} % of a scan; its journals and crankpins are {found.scan.roughness_mm:.2g} mm"
        " off cylinders: it is measured as a scan"
    )
    return replace(found, scan=replace(found.scan, cautions=(caution, *found.scan.cautions)))


def _waved(rough: RoughMesh, overrides: Overrides, refusal: RecognitionError) -> Anatomy:
    """Return a drawn crank whose vertices were moved a little; raise the error if it is not one."""
    if rough.local_mm <= SMOOTH_MESH_SHARE * rough.mesh.diagonal_mm:
        raise refusal
    views = Views(rough.mesh, WAVED_ROUGHNESS_RATIO * min(rough.local_mm, CREDIBLE_MM))
    try:
        return _with_or_without_pins(overrides, lambda known: _in_any_direction(views, known, ()))
    except RecognitionError:
        raise refusal from None


def _with_or_without_pins(overrides: Overrides, found_with: Callable[[Overrides], Anatomy]) -> Anatomy:
    """Return a crank with its crankpins, or without where the job leaves open whether they exist."""
    if overrides.crankpin_in_file is not None:
        return found_with(overrides)
    try:
        return found_with(replace(overrides, crankpin_in_file=True))
    except RecognitionError as reason:
        try:
            return found_with(replace(overrides, crankpin_in_file=False))
        except RecognitionError as without:
            raise (without if isinstance(reason, GapError) else reason) from None


def _as_scanned(rough: RoughMesh, overrides: Overrides) -> Anatomy:
    """Return the crank of a scan, with its crankpins or without; both are sought in the same sections."""
    views = RoughViews(rough, kept=overrides.crankpin_in_file is None)
    return _with_or_without_pins(overrides, lambda known: _scanned(views, known))


def _scanned(views: RoughViews, overrides: Overrides) -> Anatomy:
    from autobalance.crank.recognition.scanned import rough_directions, scanned_along  # for scans alone

    axis, rough = given.given_axis(overrides), views.rough
    directions = rough_directions(rough) if axis is None else iter([axis[1]])
    refusals: list[tuple[int, RecognitionError]] = []
    for direction in directions:
        try:
            return scanned_along(
                views,
                given.upright(direction),
                axis is not None,
                lambda long, runs: _layout(long, runs, overrides, 0.0),
                lambda long, layout: _anatomy(rough.mesh, long, layout, overrides, 0.0),
                overrides.crankpin_in_file is False,
            )
        except _NotHereError as refusal:
            refusals.append((refusal.progress, refusal.reason))
        except RecognitionError as reason:
            refusals.append((0, reason))
    raise rough.refusal(max(refusals, key=lambda item: item[0])[1])


def _in_any_direction(views: Views, overrides: Overrides, cylinders: Sequence[CylinderFace]) -> Anatomy:
    refusals: list[tuple[int, RecognitionError]] = []
    for direction in _directions(views.mesh, overrides):
        try:
            return _along(views, direction, overrides, cylinders)
        except _NotHereError as refusal:
            refusals.append((refusal.progress, refusal.reason))
    raise max(refusals, key=lambda item: item[0])[1]


class _NotHereError(Exception):
    """Lack of a crank along one direction; ``progress`` is a measure of the search's success."""

    def __init__(self, progress: int, reason: RecognitionError) -> None:
        super().__init__(str(reason))
        self.progress, self.reason = progress, reason


def _directions(mesh: Mesh, overrides: Overrides) -> Iterator[Array]:
    stated_axis = given.given_axis(overrides)
    if stated_axis is not None:
        yield stated_axis[1]
        return
    rows, weight = mesh.sample
    for axis in axis_candidates(weight[:, None] * mesh.area_vectors.take(rows, axis=0)):
        yield given.upright(axis)


def _along(
    views: Views, direction: Array, overrides: Overrides, cylinders: Sequence[CylinderFace]
) -> Anatomy:
    """Return the crank along one direction, which is refined unless the job or the solid fixes it."""
    mesh, rounding = views.mesh, views.rounding_mm
    fixed: object = given.given_axis(overrides)
    own = None if fixed is not None else own_direction(direction, cylinders)
    if own is not None:
        direction, fixed = given.upright(own), own
    for _ in range(3):
        long, runs = views.along(direction)
        layout = _layout(long, runs, overrides, rounding)
        if fixed is not None:
            break
        line = common_axis(long, layout.journals, rounding)
        measured = given.upright(long.turn[:3, :3].T @ line[1])
        tilt = float(np.linalg.norm(measured - direction))
        direction = measured
        if tilt * long.length_mm <= rounding:  # less than the file's own rounding
            if overrides.main_journals is None:
                layout = replace(layout, axis=line[0][:2], settled=True)
            break
        if tilt < SLIGHT_TILT_RAD:
            long, layout = _straightened(mesh, long, layout, direction, overrides, rounding)
            break
    else:
        raise _NotHereError(
            len(layout.journals),
            RecognitionError(
                f"the fit of a common axis through {len(layout.journals)} main journals does not converge. "
                "Set axis_point_mm and axis_direction"
            ),
        )
    if own is not None and overrides.main_journals is None and overrides.crankpins is None:
        layout = own_layout(long, layout, cylinders)
    layout = _on_surface(mesh, long, layout, overrides, rounding)
    return _anatomy(mesh, long, layout, overrides, rounding, cylinders)


def _on_surface(
    mesh: Mesh, long: SectionStack, layout: JournalLayout, overrides: Overrides, rounding: float
) -> JournalLayout:
    """Return a layout whose recognised journals and crankpins agree with their surface."""
    if overrides.main_journals is None and not layout.bored:
        named = [(f"main journal {number}", run) for number, run in enumerate(layout.journals, 1)]
        journals = on_surface(mesh, long, named, rounding, layout.shafts)
        same = all(one is other for one, other in zip(journals, layout.journals, strict=True))
        layout = replace(layout, journals=journals, settled=layout.settled and same)
    if overrides.crankpins is None and overrides.crankpin_in_file is not False:
        named = [(f"crankpin {number}", run) for number, run in enumerate(layout.pins, 1)]
        layout = replace(layout, pins=on_surface(mesh, long, named, rounding))
    return layout


def _straightened(
    mesh: Mesh,
    long: SectionStack,
    layout: JournalLayout,
    direction: Array,
    overrides: Overrides,
    rounding: float,
) -> tuple[SectionStack, JournalLayout]:
    """Return sections and layout turned by a slight tilt, cylinders fitted again, their ends sharp now."""
    straight = straightened(long, mesh, direction)
    if overrides.main_journals is None:
        layout = replace(layout, journals=_tight(straight, layout.journals, rounding))
    if overrides.crankpins is None and overrides.crankpin_in_file is not False:
        layout = replace(layout, pins=_tight(straight, layout.pins, rounding))
    return straight, layout


def _layout(
    long: SectionStack, runs: Sequence[CylinderRun], overrides: Overrides, rounding: float
) -> JournalLayout:
    axis_point = overrides.axis_point_mm
    if axis_point is None and overrides.main_journals:
        axis_point = overrides.main_journals[0].centre_mm
    known_axis = None if axis_point is None else long.placed(axis_point)[:2]
    try:
        if overrides.crankpins is not None:
            pins = _stated(long, overrides.crankpins, runs, "crankpins", rounding)
            near = [run for run in runs if all(_apart(run, pin) for pin in pins)]
            return _with_pins(long, near, pins, known_axis, overrides, runs, rounding)
        layout = (
            solid_layout(long, runs, known_axis, rounding)
            if overrides.crankpin_in_file
            else pressed_up_layout(long, runs, known_axis, rounding)
        )
    except RecognitionError as reason:
        raise _NotHereError(len(runs), reason) from reason
    if overrides.main_journals is not None:
        journals = _stated(long, overrides.main_journals, runs, "main_journals", rounding)
        layout = replace(layout, journals=tuple(sorted(journals, key=lambda run: run.z_mid)), others=())
    return replace(layout, chosen_from=tuple(runs))


def _with_pins(
    long: SectionStack,
    near: Sequence[CylinderRun],
    pins: Sequence[CylinderRun],
    known_axis: Array | None,
    overrides: Overrides,
    runs: Sequence[CylinderRun],
    rounding: float,
) -> JournalLayout:
    pins = sorted(pins, key=lambda run: run.z_mid)
    if overrides.main_journals is not None:
        journals = _stated(long, overrides.main_journals, runs, "main_journals", rounding)
        axis = journals[0].centre if known_axis is None else known_axis
        journals = sorted(journals, key=lambda run: run.z_mid)
        return JournalLayout(axis, tuple(journals), tuple(pins), chosen_from=tuple(runs))
    return replace(layout_with_pins(long, near, pins, known_axis, rounding), chosen_from=tuple(runs))


def _stated(
    long: SectionStack, hints: Sequence[PinHint], runs: Sequence[CylinderRun], key: str, rounding: float
) -> list[CylinderRun]:
    """Return the cylinders or bores of a job's hints."""
    return [given.hinted(long, hint, _known(long, runs, hint, rounding), key) for hint in hints]


def _known(
    long: SectionStack, runs: Sequence[CylinderRun], hint: PinHint, rounding: float
) -> Sequence[CylinderRun]:
    """Return the cylinders by which a hint without its sizes is completed: bare ones and bores."""
    if hint.diameter_mm is not None and hint.width_mm is not None:
        return runs
    return [*runs, *bore_runs(long, rounding)]


def _apart(run: CylinderRun, pin: CylinderRun) -> bool:
    return float(np.linalg.norm(run.centre - pin.centre)) > 0.03 * min(run.radius, pin.radius)


def _from_job(mesh: Mesh, overrides: Overrides, stated_axis: tuple[Array | None, Array]) -> Anatomy:
    """Return the anatomy from a job's own statements; only webs are recognised."""
    rounding = Views(mesh).rounding_mm
    long = lengthwise(mesh, stated_axis[1], rounding)
    runs = find_runs(long, rounding)
    pins = _stated(long, overrides.crankpins or (), runs, "crankpins", rounding)
    journals = _stated(long, overrides.main_journals or (), runs, "main_journals", rounding)
    if not pins:
        raise RecognitionError("crankpins is an empty list; it needs at least one crankpin")
    point = stated_axis[0]
    if point is None:
        raise RecognitionError("axis_direction is given without axis_point_mm or main_journals")
    axis = long.placed(point)[:2]
    layout = JournalLayout(
        axis,
        tuple(sorted(journals, key=lambda run: run.z_mid)),
        tuple(sorted(pins, key=lambda run: run.z_mid)),
        chosen_from=tuple(runs),
    )
    return _anatomy(mesh, long, layout, overrides, rounding)


def _anatomy(
    mesh: Mesh,
    long: SectionStack,
    layout: JournalLayout,
    overrides: Overrides,
    rounding: float,
    cylinders: Sequence[CylinderFace] = (),
) -> Anatomy:
    """Return the numbered anatomy of a layout, measured in its rotor frame."""
    axis = layout.axis
    if overrides.axis_point_mm is not None:
        axis = long.placed(overrides.axis_point_mm)[:2]
    elif overrides.main_journals is None and not layout.settled:
        axis = common_axis(long, layout.journals, rounding)[0][:2]
    layout = replace(layout, axis=axis)
    if overrides.crankpins is not None or overrides.main_journals is not None:
        layout = completed(long, layout)
    first = layout.pins[0]
    arm = first.centre - axis
    crank_radius = float(np.linalg.norm(arm))
    if crank_radius < 1e-6 * long.length_mm:
        raise RecognitionError("crankpin 1 lies on the crank axis; crankpins or axis_point_mm is wrong")
    local = np.eye(4)
    local[0, :2] = arm / crank_radius
    local[1, :2] = [-local[0, 1], local[0, 0]]
    local[:3, 3] = -local[:3, :3] @ np.array([axis[0], axis[1], first.z_mid])
    if layout.shafts and overrides.main_journals is None:
        layout = replace(layout, journals=tuple(part for part, _ in clear_of(layout.journals, layout.pins)))
    here = find_webs(long, layout)
    datums = find_datums(long, axis, layout.journals, here, mesh, local)
    start = first.z_mid
    webs = tuple(replace(web, z_min_mm=web.z_min_mm - start, z_max_mm=web.z_max_mm - start) for web in here)
    if overrides.crankpins is None and overrides.main_journals is None:
        given.refuse_incomplete(layout, webs, first.z_mid)
        given.refuse_unexplained(long, layout, here)
    journals = tuple(
        MainJournal(_place(local, run), 2.0 * run.radius, run.width, number)
        for number, run in enumerate(layout.journals, 1)
    )
    throws = tuple(_throw(local, run, number) for number, run in enumerate(layout.pins, 1))
    told = all_cylinders(long, layout, here, overrides, cylinders, rounding, local)
    typed = typed_and_found(mesh, long, layout, overrides, rounding, local)
    if not typed.is_bored:
        typed = replace(typed, left_out=given.left_out_by_job(long, layout, here, overrides))
    given.refuse_impossible(long, layout, here, overrides.crankpins is not None)
    off = _misalignment(layout, typed)
    found = Anatomy(local @ long.turn, journals, throws, webs, off, datums, cylinders=told, typed=typed)
    doubts = (
        *axis_doubts(found, layout, local),
        *journal_doubts(journals, layout.others, told, local, found.rotor_to_file),
    )
    return replace(found, doubts=doubts)


def _tight(long: SectionStack, runs: Sequence[CylinderRun], rounding: float) -> tuple[CylinderRun, ...]:
    """Return each cylinder fitted again in the final axes, where its ends are sharp."""
    tight = []
    for run in runs:
        pad = 1e-3 * run.radius
        reach = run.z_low - pad, run.z_high + pad
        again = bare_cylinder(long, run.centre, run.radius, reach, 0.9 * run.width, rounding)
        tight.append(run if again is None else again)
    return tuple(tight)


def _place(local: Array, run: CylinderRun) -> Array:
    placed: Array = local[:3, :3] @ np.array([*run.centre, run.z_mid]) + local[:3, 3]
    return placed


def _throw(local: Array, run: CylinderRun, number: int) -> Throw:
    centre = _place(local, run)
    angle = math.atan2(centre[1], centre[0]) % (2.0 * math.pi)
    angle = 0.0 if 2.0 * math.pi - angle < 1e-9 else angle
    return Throw(number, math.hypot(centre[0], centre[1]), angle, Pin(centre, 2.0 * run.radius, run.width))


def _misalignment(layout: JournalLayout, typed: Typed) -> float:
    """Return the largest distance of a main journal from the axis: the file's, if it is typed otherwise."""
    offsets = [float(np.linalg.norm(run.centre - layout.axis)) for run in layout.journals]
    for number, found in enumerate(typed.main_journals or ()):
        if found is not None and found.offset_mm > found.within_mm:
            offsets[number] = float(np.hypot(*found.centre_mm[:2]))
    return max(offsets, default=0.0)
