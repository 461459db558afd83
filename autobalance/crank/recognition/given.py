"""A job's own statements on a crank, and the refusal of a layout that no crank has."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations, groupby, pairwise

import numpy as np

from autobalance.crank.anatomy import Overrides, PinHint, Web
from autobalance.crank.recognition.cylinder_runs import SAME_CENTRE, SAME_RADIUS, CylinderRun
from autobalance.crank.recognition.layout import JournalLayout, cylinder_text
from autobalance.crank.recognition.section_stack import CrossSection, SectionPiece, SectionStack
from autobalance.crank.recognition.through_shaft import shared_mm
from autobalance.crank.recognition.webs import MAX_COLLAR_OFFSET_RATIO
from autobalance.errors import RecognitionError
from autobalance.types import Array
from autobalance.value_classes import dataclass

# A job's own statements on a crank: its axis, journals and crankpins.


def without_given_keys(text: str, overrides: Overrides) -> str:
    """Return a refusal that asks for what is missing beside ``main_journals`` or ``crankpins``.

    Recognition is skipped only where both exist; the key that is there is not requested again.
    """
    hints_by_name = {name: getattr(overrides, name) for name in ("main_journals", "crankpins")}
    fault, remedy, advice = text.rpartition(". Set ")
    (there, hints), *more = [(name, hints) for name, hints in hints_by_name.items() if hints is not None] or [
        ("", ())
    ]
    if more or not remedy or not there or there not in advice:
        return text
    missing = [name for name in hints_by_name if name != there]
    if there == "main_journals" and len(hints) < 2 and overrides.axis_direction is None:
        missing.append("axis_direction")
    return f"{fault}. Set {' and '.join(missing)} as well as {there}"


def given_axis(overrides: Overrides) -> tuple[Array | None, Array] | None:
    """Return a job's axis as (point or None, direction), stated or by two main journals; None without."""
    if overrides.axis_direction is not None:
        point = overrides.axis_point_mm
        if point is None and overrides.main_journals:
            point = np.mean([hint.centre_mm for hint in overrides.main_journals], axis=0)
        return point, upright(overrides.axis_direction)
    if overrides.main_journals is not None and len(overrides.main_journals) > 1:
        centres = np.array([hint.centre_mm for hint in overrides.main_journals])
        middle = centres.mean(axis=0)
        direction = np.linalg.svd(centres - middle)[2][0]
        if float(np.ptp(centres @ direction)) > 0.0:
            point = middle if overrides.axis_point_mm is None else overrides.axis_point_mm
            return point, upright(direction)
    return None


def upright(direction: Array) -> Array:
    """Return the unit vector along ``direction`` whose largest component is positive (the frame's rule)."""
    length = float(np.linalg.norm(direction))
    if not (length > 0.0 and math.isfinite(length)):
        raise RecognitionError("axis_direction has no length; it needs three numbers, not all zero")
    unit = np.asarray(direction, dtype=np.float64) / length
    size = np.abs(unit)
    first = int(np.flatnonzero(size >= size.max() - 1e-6)[0])
    return unit if unit[first] > 0.0 else -unit


def hinted(long: SectionStack, hint: PinHint, runs: Sequence[CylinderRun], key: str) -> CylinderRun:
    """Return the cylinder of a job's hint, completed from the one recognised there."""
    centre = long.placed(hint.centre_mm)
    there = [
        run
        for run in runs
        if run.z_low <= centre[2] <= run.z_high
        and float(np.linalg.norm(run.centre - centre[:2])) < 0.1 * run.radius
    ]
    if (hint.diameter_mm is None or hint.width_mm is None) and not there:
        text = ", ".join(f"{value:g}" for value in hint.centre_mm)
        raise RecognitionError(
            f"{key} names a cylinder at [{text}] mm without its diameter or width, and none was found there; "
            "give diameter_mm and width_mm"
        )
    radius = there[0].radius if hint.diameter_mm is None else 0.5 * hint.diameter_mm
    width = there[0].width if hint.width_mm is None else hint.width_mm
    middle = there[0].z_mid if hint.width_mm is None else float(centre[2])
    return CylinderRun(centre[:2], radius, middle - 0.5 * width, middle + 0.5 * width)


# Refusal of a layout that no crank has, or that leaves a cylinder of the file unexplained.


NECK_SIZE_RANGE = (0.7, 1.15)
"""Sizes of journals and crankpins lie between these, as shares of the least and most."""
NECK_WIDTH = 0.1
"""It is at least this long, as a share of the least crankpin's radius."""
ON_AXIS = 0.06
"""A shaft's middle is off the axis by less than this share of its radius: that of seven sides by 0.05."""
LONE_BORE = 0.3
"""A bore in one web alone is a crankpin's from this share of the main journals' diameter on: that of the
bolts in a flange of a crank cut lengthwise has 0.22."""
PASSED_OVER, STEADY = 0.25, 0.015
"""A shaft is a cylinder where its radius changes by less than the second share over more than the first share
of it; fillets and tapers change by more."""
MIN_THROW_WIDTH_MM = 0.5
"""A crankpin is at least so wide: an arm's bore was reported as one of no width ..."""
MIN_THROW_WIDTH_RATIO = 0.2
"""... or so wide for its diameter: public cranks without a unit are read as 1.6 mm long, pins as 0.4 mm."""
MAX_IN_WEB = 0.25
"""A journal or crankpin is within a web over less than this share of its width: fillets of typed ones are."""
MAX_BESIDE_BOSSES = 0.9
"""The same share of a cylinder that is apart from all other metal. Parts on a web's face next to it, as
bosses and bolts, make the web wider and the cylinder not part of it."""
MAX_SHARED = 0.25
"""Two of them share less than this part of the narrower one's width."""
MAX_LISTED = 8
"""Number of cylinders that a refusal lists."""


@dataclass(frozen=True, eq=False)
class _Neck:
    """Neighbouring sections of a cylinder that is neither a main journal nor a crankpin."""

    what: str
    sections: Sequence[CrossSection]

    @property
    def low(self) -> float:
        return self.sections[0].z_mm

    @property
    def high(self) -> float:
        return self.sections[-1].z_mm

    def text(self, layout: JournalLayout) -> str:
        """Return its kind, its length and its place."""
        along = 0.5 * (self.low + self.high) - layout.pins[0].z_mid
        return (
            f"{self.what}, {self.high - self.low:.3g} mm long, {along:.4g} mm from crankpin 1 along the axis"
        )

    @property
    def _middle(self) -> tuple[Array, float]:
        """Middle (2,) of its middle section, and the section's reach from there."""
        return _round(self.sections[len(self.sections) // 2].pieces[0])

    @property
    def diameter_mm(self) -> float:
        return 2.0 * self._middle[1]

    def key(self, layout: JournalLayout) -> str:
        """Return the key of a job that it may belong to: on the crank axis it is a main journal."""
        middle, reach = self._middle
        is_on_axis = float(np.linalg.norm(middle - layout.axis)) < ON_AXIS * reach
        return "main_journals" if is_on_axis else "crankpins"


def refuse_impossible(
    long: SectionStack, layout: JournalLayout, webs: Sequence[Web], typed_pins: bool
) -> None:
    """Refuse impossible cranks: a crankpin of almost no width, a cylinder within a web, two on one stretch.

    ``webs`` are in the layout's z. It holds of typed cylinders as well; but webs begin if the file has no
    surface of a typed crankpin, so that such a crankpin is only compared with the file.

    Raises
    ------
    RecognitionError
        With what was seen, and where.
    """
    names = [(f"main journal {number}", run) for number, run in enumerate(layout.journals, 1)]
    named_pins = [(f"crankpin {number}", run) for number, run in enumerate(layout.pins, 1)]
    for name, run in named_pins:
        if run.width < min(MIN_THROW_WIDTH_MM, MIN_THROW_WIDTH_RATIO * 2.0 * run.radius):
            raise RecognitionError(
                f"{name} would be {cylinder_text(long, run)}, less than {MIN_THROW_WIDTH_MM:g} mm wide;"
                " check the file's unit, or give crankpins with their width_mm"
            )
    bare = [*(() if layout.bored else names), *(() if layout.lone_bores else named_pins)]
    found = [*names, *(() if typed_pins else named_pins)]
    for name, run in (each for each in found if any(each[1] is run for _, run in bare)):
        for web in webs:
            inside = min(run.z_high, web.z_max_mm) - max(run.z_low, web.z_min_mm)
            most = MAX_BESIDE_BOSSES if _is_bare(layout, run) else MAX_IN_WEB
            if run.width > 0.0 and inside > most * run.width:
                raise RecognitionError(
                    f"{name}, {cylinder_text(long, run)}, would be within a web over {inside:.4g} mm;"
                    f" main_journals or crankpins must name a bare cylinder: {_bare_ones(long, layout)}"
                )
    for (name, run), (other_name, other) in combinations(bare, 2):
        if shared_mm(run, other) > MAX_SHARED * min(run.width, other.width) > 0.0:
            raise RecognitionError(
                f"{name}, {cylinder_text(long, run)}, and {other_name}, {cylinder_text(long, other)},"
                " would be on one stretch of the axis; correct main_journals or crankpins, or leave them out"
            )


def _is_bare(layout: JournalLayout, run: CylinderRun) -> bool:
    """Return whether the file has a cylinder apart from all other metal where a run is."""
    return any(
        shared_mm(run, each) > MAX_BESIDE_BOSSES * run.width
        and abs(each.radius - run.radius) < SAME_RADIUS * run.radius
        for each in layout.chosen_from
    )


def _bare_ones(long: SectionStack, layout: JournalLayout) -> str:
    """Return a text on the bare cylinders that a file has."""
    listed = "; ".join(cylinder_text(long, run) for run in layout.chosen_from[:MAX_LISTED])
    more = len(layout.chosen_from) - MAX_LISTED
    return (listed or "the file has none") + (f"; and {more} more" if more > 0 else "")


def refuse_incomplete(layout: JournalLayout, webs: Sequence[Web], shift_mm: float) -> None:
    """Refuse crankpins without a web on both sides; one at an end needs a single web.

    ``webs`` are placed ``shift_mm`` lower than the layout.

    Raises
    ------
    RecognitionError
        If a crankpin between others lacks a web.
    """
    for text in _without_web(layout, webs, shift_mm):
        raise RecognitionError(f"{text}. Set crankpins and main_journals")


def _without_web(layout: JournalLayout, webs: Sequence[Web], shift_mm: float) -> Iterator[str]:
    """Yield a text for each crankpin without a web towards its neighbour."""
    if layout.bored or layout.lone_bores:  # there is one web alone, and it was found by its bores
        return
    order = sorted(
        [(run, 0) for run in layout.journals] + [(run, number) for number, run in enumerate(layout.pins, 1)],
        key=lambda item: item[0].z_mid,
    )
    for (one, first), (other, second) in pairwise(order):
        low, high = one.z_mid - shift_mm, other.z_mid - shift_mm
        if (
            (first or second)
            and not any(low < 0.5 * (w.z_min_mm + w.z_max_mm) < high for w in webs)
            and not _joins(one, other, bool(first), bool(second))
            and not any(shared_mm(shaft, pin) > 0.0 for shaft in layout.shafts for pin in (one, other))
        ):
            number, beside = (first, other) if first else (second, one)
            apart = 0.5 * (one.z_mid + other.z_mid) - layout.pins[0].z_mid
            yield (
                f"throw {number} has no web on one side, {apart:.4g} mm from crankpin 1 along "
                f"the axis, before a cylinder of {2.0 * beside.radius:.4g} mm"
            )


def _joins(one: CylinderRun, other: CylinderRun, is_pin: bool, other_is_pin: bool) -> bool:
    """Return whether two neighbours hold each other without a web: they meet, and one overlaps the other.

    Split crankpins do, and an eccentric on its shaft; a journal that is a disc, wider across than the
    crankpin and than it is long, may be a web.
    """
    apart = float(np.linalg.norm(one.centre - other.centre))
    room = MAX_COLLAR_OFFSET_RATIO * min(one.radius, other.radius)
    if other.z_low - one.z_high > room or apart > one.radius + other.radius - room:
        return False
    if is_pin and other_is_pin:
        return True
    journal, pin = (other, one) if is_pin else (one, other)
    return journal.radius <= pin.radius or journal.width >= 2.0 * journal.radius


def refuse_unexplained(long: SectionStack, layout: JournalLayout, webs: Sequence[Web]) -> None:
    """Refuse a journal or a crankpin that was not recognised as one.

    It refuses a neck within a web (``webs`` are placed as the layout is) and one next to the axis if there is
    no crankpin. It refuses a cylinder between a web and the main journal taken instead of it, such as a
    flange or a gear's seat. A recognised cylinder that is not a crankpin is refused too: one of two pins side
    by side, a bolt's hole.

    Raises
    ------
    RecognitionError With the place, and the key to set.
    """
    if layout.bored:
        return
    for each in (*_necks(long, layout, webs), *_beside(long, layout), *_passed_over(long, layout, webs)):
        raise RecognitionError(
            f"{each.text(layout)}, may be a journal or crankpin out of line with the others."
            " Set main_journals and crankpins"
        )
    _refuse_twins(layout)
    _refuse_bolt_holes(layout)


def left_out_by_job(
    long: SectionStack, layout: JournalLayout, webs: Sequence[Web], overrides: Overrides
) -> tuple[str, ...]:
    """Return the bare cylinders within the webs that a job's own journals or crankpins leave unexplained.

    ``webs`` are placed as the layout is. A cylinder beside the axis, apart from the webs, is listed as one
    that is not a crankpin. A job that names its main journals means no other cylinder beside a web.
    """
    keys = [key for key in ("main_journals", "crankpins") if getattr(overrides, key) is not None]
    if not keys or layout.bored or layout.lone_bores:
        return ()
    named = " and ".join(keys)
    necks = list(_necks(long, layout, webs))
    shafts = [
        each
        for each in _passed_over(long, layout, webs, overrides.main_journals is None)
        if not any(neck.low < each.high and each.low < neck.high for neck in necks)
    ]
    return (
        *(f"{named}: {text}" for text in _without_web(layout, webs, 0.0)),
        *(
            f"{named}: {each.text(layout)} and ⌀{each.diameter_mm:.4g} mm, is not among them and counts as"
            f" metal of the web; add it to {each.key(layout)} if it is one"
            for each in (*necks, *shafts)
        ),
    )


def _necks(long: SectionStack, layout: JournalLayout, webs: Sequence[Web]) -> Iterator[_Neck]:
    """Yield each neck within a web."""
    most = NECK_SIZE_RANGE[1] * max(run.radius for run in (*layout.journals, *layout.pins))
    for web in webs:
        inside = [s for s in long.sections if web.z_min_mm < s.z_mm < web.z_max_mm]
        stretches = [(neck, list(some)) for neck, some in groupby(inside, lambda s: _is_neck(s, most))]
        for neck, sections in stretches[1:-1]:
            if neck:
                yield from _long(layout, sections, f"a neck in web {web.number}")


def _beside(long: SectionStack, layout: JournalLayout) -> Iterator[_Neck]:
    """Yield each cylinder beside the axis that is not at a crankpin."""
    for beside, some in groupby(long.sections, lambda s: _is_beside(s, layout)):
        sections = list(some)
        low, high = sections[0].z_mm, sections[-1].z_mm
        if beside and not any(pin.z_low <= high and low <= pin.z_high for pin in layout.pins):
            yield from _long(layout, sections, "a cylinder beside the axis")


def _refuse_bolt_holes(layout: JournalLayout) -> None:
    """Refuse a crankpin's bore in one web alone that is as thin as a bolt's hole."""
    thinnest = LONE_BORE * min(run.radius for run in layout.journals)
    for pin in layout.pins:
        if (layout.lone_bores or not pin.width > 0.0) and pin.radius < thinnest:
            raise RecognitionError(
                f"the crankpin's bore of {2.0 * pin.radius:.4g} mm is in one web alone and narrower than"
                f" {2.0 * thinnest:.4g} mm, as a bolt's hole. Set crankpins and main_journals"
            )


def _refuse_twins(layout: JournalLayout) -> None:
    """Refuse cylinders with another one beside them at the same height: pins in a plate."""
    for run in (*layout.journals, *layout.pins):
        for other in layout.chosen_from:
            apart = float(np.linalg.norm(other.centre - run.centre)) > run.radius + other.radius
            through = any(_is_part(other, shaft) for shaft in layout.shafts)
            if apart and not through and shared_mm(run, other) > 0.5 * run.width:
                raise RecognitionError(
                    f"two cylinders lie side by side, {2.0 * run.radius:.4g}"
                    f" and {2.0 * other.radius:.4g} mm in diameter, where a crank has one."
                    " Set main_journals and crankpins"
                )


def _is_part(run: CylinderRun, shaft: CylinderRun) -> bool:
    """Return whether a cylinder holds a stretch of a shaft."""
    apart = float(np.linalg.norm(run.centre - shaft.centre))
    return abs(run.radius - shaft.radius) < SAME_RADIUS * run.radius and apart < SAME_CENTRE * run.radius


def _passed_over(
    long: SectionStack, layout: JournalLayout, webs: Sequence[Web], beside_journals: bool = True
) -> Iterator[_Neck]:
    """Yield each cylinder on the axis that is none of those from which journals were chosen.

    One that an end web without a journal seems to hold is a journal that was not recognised; with
    ``beside_journals`` so is one between an outer journal and its web.
    """
    if not webs:
        return
    low, high = -math.inf, math.inf
    if layout.journals[0].z_mid < webs[0].z_min_mm:
        low = layout.journals[0].z_low
    if layout.journals[-1].z_mid > webs[-1].z_max_mm:
        high = layout.journals[-1].z_high
    most = NECK_SIZE_RANGE[1] * max(run.radius for run in (*layout.journals, *layout.pins))
    beside = webs[int(low == -math.inf) : len(webs) - int(high == math.inf)]
    known = [(web.z_min_mm, web.z_max_mm) for web in beside]
    known += [(run.z_low, run.z_high) for run in (*layout.journals, *layout.pins)]
    if beside_journals:
        known += [(run.z_low, run.z_high) for run in layout.chosen_from]
    else:
        begin = webs[0].z_max_mm if low == -math.inf else -math.inf
        known.append((begin, webs[-1].z_min_mm if high == math.inf else math.inf))
    stretch: list[CrossSection] = []
    radius = 0.0
    for section in (*long.sections, None):
        z = math.inf if section is None else section.z_mm
        here = low < z < high and not any(a - long.blur_mm <= z <= b + long.blur_mm for a, b in known)
        reach = _shaft_radius(section, layout.axis, most) if here and section is not None else None
        if reach is None or (stretch and abs(reach - radius) > STEADY * radius):
            if stretch:
                yield from _long(layout, stretch, "a cylinder on the axis beside a web", PASSED_OVER * radius)
            stretch = []
        if reach is not None and section is not None:
            radius = radius if stretch else reach
            stretch.append(section)


def _shaft_radius(section: CrossSection, axis: Array, most_mm: float) -> float | None:
    """Return the radius of a shaft's section on the axis; None if it is none of a journal's size."""
    if len(section.pieces) != 1:
        return None
    middle, reach = _round(section.pieces[0])
    return reach if reach <= most_mm and float(np.linalg.norm(middle - axis)) < ON_AXIS * reach else None


def _long(
    layout: JournalLayout, sections: Sequence[CrossSection], what: str, length_mm: float | None = None
) -> Iterator[_Neck]:
    """Yield a cylinder's sections if it is longer than so much, or than a share of the crankpins' radius."""
    low, high = sections[0].z_mm, sections[-1].z_mm
    if high - low > (NECK_WIDTH * min(pin.radius for pin in layout.pins) if length_mm is None else length_mm):
        yield _Neck(what, sections)


def _is_neck(section: CrossSection, most_mm: float) -> bool:
    """Return whether all of a section lies within a circle of a journal's size."""
    return len(section.pieces) == 1 and _round(section.pieces[0])[1] <= most_mm


def _is_beside(section: CrossSection, layout: JournalLayout) -> bool:
    """Return whether all of a section has a crankpin's size and lies beside the axis; a gap counts too."""
    least = NECK_SIZE_RANGE[0] * min(pin.radius for pin in layout.pins)
    most = NECK_SIZE_RANGE[1] * max(pin.radius for pin in layout.pins)
    rounds = [_round(piece) for piece in section.pieces]
    away = [(float(np.linalg.norm(middle - layout.axis)), reach) for middle, reach in rounds]
    return all(least <= reach <= most and reach < distance for distance, reach in away)


def _round(piece: SectionPiece) -> tuple[Array, float]:
    """Return the middle (2,) of a section's piece, and its reach from there."""
    middle = 0.5 * (piece.outline.min(axis=0) + piece.outline.max(axis=0))
    return middle, piece.reach_from(middle)
