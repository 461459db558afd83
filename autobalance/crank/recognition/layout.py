"""Division of a shaft's bare cylinders into main journals and crankpins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.recognition import through_shaft
from autobalance.crank.recognition.bores import bore_runs, bored_arm, pieces_around, shaft_bores, single_web
from autobalance.crank.recognition.cylinder_runs import ROUNDING, SAME_CENTRE, CylinderRun
from autobalance.crank.recognition.datums import shaft_marks
from autobalance.crank.recognition.section_stack import SectionStack, encloses
from autobalance.errors import RecognitionError
from autobalance.types import Array
from autobalance.value_classes import dataclass

MIN_LENGTH_RATIO = 1.3
"""A line of cylinders wins over another when it has this much more shaft, or metal reaches this much farther
beyond it, and neither is so the other way round."""
OUT_OF_LINE = 0.2
"""A cylinder beside the axis by less than this share of the largest crank radius is a main journal out of
line: strokes of one crank do not differ as much."""
WANDER = 0.15
"""Journals of a crank that is bent, or badly drawn, are apart by less than this share of their radius."""
MAX_LISTED_AXES = 4
"""Largest number of possible axes that are listed."""
WEB_REACH = 1.5
"""A web between crankpins of one line reaches farther than this many times their radius."""
SLACK_SHARE = 1e-3
"""Share of their length along the axis that neighbouring cylinders have in common, at least."""


class GapError(RecognitionError):
    """The part is in two along the axis, so that its crankpin is not in the file."""


@dataclass(frozen=True, eq=False)
class JournalLayout:
    """Main journals and crankpins, each by increasing z, in the turned axes; ``axis`` (2,).

    ``settled`` means that the axis is the journals' own, with nothing left to fit. ``chosen_from`` are all
    the bare cylinders; ``others`` is the cylinder that may be meant instead of each journal, None if there is
    no doubt. ``shafts`` are the stretches of a shaft that runs through, next to or within crankpins.
    ``bored`` means that the main journal is a bore for the shaft, ``lone_bores`` that the crankpins are bores
    of one web alone. ``other_axis`` is the cylinder that may be the axis instead; ``axis_setting`` is the
    line of a job that selects it, with an empty text for its place.
    """

    axis: Array
    journals: tuple[CylinderRun, ...]
    pins: tuple[CylinderRun, ...]
    settled: bool = False
    chosen_from: tuple[CylinderRun, ...] = ()
    others: tuple[CylinderRun | None, ...] = ()
    shafts: tuple[CylinderRun, ...] = ()
    bored: bool = False
    lone_bores: bool = False
    other_axis: CylinderRun | None = None
    axis_setting: str = ""

    @classmethod
    def chosen(
        cls, axis: Array, choices: Sequence[through_shaft.JournalChoice], pins: Sequence[CylinderRun]
    ) -> JournalLayout:
        """Return the layout of the main journals that were chosen."""
        journals, others = (tuple(getattr(each, key) for each in choices) for key in ("run", "other"))
        return cls(axis, journals, tuple(pins), others=others)


def crank_axis(
    long: SectionStack, runs: Sequence[CylinderRun], hint: Array | None, wander: float = SAME_CENTRE
) -> list[CylinderRun]:
    """Return the cylinders on the crank axis: the line of cylinders that begins before and ends after others.

    If none does, the crank is overhung. The axis is then the line with more shaft on it and more metal beyond
    it, or the one that is keyed, unless one of these contradicts.

    ``hint`` (2,) is a job's own axis; ``wander`` is the largest distance between cylinders of one line, as a
    share of the radius. Where no line is the axis for certain, journals that wander farther are tried.

    Raises
    ------
    RecognitionError
        If there is no cylinder, or two lines could be the axis.
    """
    lines = _lines(runs, wander)
    if hint is not None:
        for line in lines:
            if float(np.linalg.norm(line[0].centre - hint)) < wander * max(r.radius for r in line):
                return line
        if wander < WANDER:
            return crank_axis(long, runs, hint, WANDER)
        raise RecognitionError(
            f"no main journals on the axis given, among {len(runs)} bare cylinders"
            f"{_list(long, sorted(runs, key=lambda run: float(np.linalg.norm(run.centre - hint))))}. "
            "Set axis_point_mm or main_journals"
        )
    if not lines:
        raise RecognitionError(_no_journal(long, runs))
    lines.sort(key=_span, reverse=True)
    outer = [line for line in lines if all(_encloses(line, other) for other in lines if other is not line)]
    if outer:
        return outer[0]
    dominant = np.flatnonzero(_wins(long, np.array([line[0].centre for line in lines])).all(axis=1))
    keyed = _keyed_lines(long, lines)
    if len(dominant) == 1 and (not keyed or int(dominant[0]) in keyed):
        return lines[int(dominant[0])]
    if len(dominant) != 1 and len(keyed) == 1:
        return lines[keyed[0]]
    if wander < WANDER and len(_lines(runs, WANDER)) < len(lines):
        return crank_axis(long, runs, hint, WANDER)
    raise RecognitionError(
        f"the crank axis is ambiguous, with {len(lines)} lines of cylinders: "
        f"{'; '.join(_described(long, line) for line in lines[:MAX_LISTED_AXES])}. "
        "Set axis_point_mm (--axis-point) to one of these points"
    )


def _keyed_lines(long: SectionStack, lines: Sequence[Sequence[CylinderRun]]) -> list[int]:
    """Return the places of lines with a keyway, a spline or teeth: a shaft's."""
    if long.blur_mm > 0.0:
        return []
    return [place for place, line in enumerate(lines) if any(shaft_marks(long, run) for run in line)]


def _no_journal(long: SectionStack, runs: Sequence[CylinderRun]) -> str:
    """Return a refusal of a part without a bare cylinder, which lists its bores."""
    bores = bore_runs(long, ROUNDING * float(np.abs(long.vertices).max()))
    count = f" but {len(bores)} bore{'s' * (len(bores) > 1)}" if bores else " and no round bore"
    remedy = "Set main_journals"
    if single_web(long, runs, bores, is_web=True) is not None:
        remedy = "Set axis_point_mm (--axis-point) in the shaft's bore, and crankpin_in_file = false"
    return f"no main journals found: the part has no bare cylinder{count}{_list(long, bores)}. {remedy}"


def _described(long: SectionStack, line: Sequence[CylinderRun]) -> str:
    """Return a text on a line of cylinders: number, length, a point of it in the file's coordinates."""
    middle = np.array([*mean_centre(line), 0.5 * (line[0].z_mid + line[-1].z_mid)])
    x, y, z = np.round(long.in_file(middle), 6) + 0.0
    count = f"{len(line)} cylinder{'s' * (len(line) != 1)}"
    return f"{count}, {_span(line):.4g} mm long, through ({x:.6g}, {y:.6g}, {z:.6g}) mm"


def _wins(long: SectionStack, centres: Array) -> NDArray[np.bool_]:
    """Return whether each line of an overhung crank, through ``centres`` (n, 2), beats each other one (n, n).

    There must be no sign against it, and one for it; a line wins over itself.
    """
    beyond, shaft = _beyond(long, centres), _shafts_mm(long, centres)
    ratios = np.stack([shaft[:, None] / np.maximum(shaft, 1e-9), beyond / np.maximum(beyond.T, 1e-9)])
    wins = (ratios.min(axis=0) > 1.0 / MIN_LENGTH_RATIO) & (ratios.max(axis=0) > MIN_LENGTH_RATIO)
    np.fill_diagonal(wins, True)
    dominates: NDArray[np.bool_] = wins
    return dominates


def _shafts_mm(long: SectionStack, centres: Array) -> Array:
    """Return the length (n,) of the part with circles about each line, tapers included."""
    circles = np.array(
        [
            (place, *piece.circle.centre, piece.circle.radius)
            for place, section in enumerate(long.sections)
            for piece in section.pieces
            if piece.circle is not None
        ]
    ).reshape(-1, 4)
    place, radius = circles[:, 0].astype(np.int64), circles[:, 3]
    widths = np.gradient(np.array([section.z_mm for section in long.sections]))
    about = (np.linalg.norm(circles[:, 1:3] - centre, axis=1) < SAME_CENTRE * radius for centre in centres)
    return np.array([widths[np.unique(place[these])].sum() for these in about])


def _beyond(long: SectionStack, centres: Array) -> Array:
    """Return the largest reach of metal beyond each line, seen from each other one [mm] (n, n)."""
    points = np.concatenate([piece.outline for section in long.sections for piece in section.pieces])
    away = centres[:, None] - centres
    away /= np.maximum(np.linalg.norm(away, axis=2, keepdims=True), 1e-12)
    along = np.array([[(points @ direction).max() for direction in row] for row in away])
    reach: Array = along - np.einsum("ijk,ik->ij", away, centres)
    return reach


def _lines(runs: Sequence[CylinderRun], wander: float) -> list[list[CylinderRun]]:
    """Return cylinders by common centre line, except for ``wander``, a share of the lesser radius."""
    lines: list[list[CylinderRun]] = []
    for run in sorted(runs, key=lambda run: -run.width):
        for line in lines:
            if float(np.linalg.norm(line[0].centre - run.centre)) < wander * min(line[0].radius, run.radius):
                line.append(run)
                break
        else:
            lines.append([run])
    return [sorted(line, key=lambda run: run.z_mid) for line in lines]


def _encloses(line: Sequence[CylinderRun], other: Sequence[CylinderRun]) -> bool:
    """Return whether one line of cylinders begins before and ends after another."""
    return (
        line[0].z_mid < min(run.z_low for run in other) and max(run.z_high for run in other) < line[-1].z_mid
    )


def _span(line: Sequence[CylinderRun]) -> float:
    return max(run.z_high for run in line) - min(run.z_low for run in line)


def solid_layout(
    long: SectionStack, runs: Sequence[CylinderRun], given_axis: Array | None, rounding_mm: float = 0.0
) -> JournalLayout:
    """Return main journals and crankpins of a crank whose crankpins are in the file.

    Raises
    ------
    RecognitionError
        If there is no axis, no crankpin, or a cylinder beside the axis is next to a journal.
    """
    arm = _arm(long, runs, given_axis, rounding_mm)
    if arm is not None:
        return arm
    _refuse_lone_web(long, runs, rounding_mm)
    on_axis = crank_axis(long, runs, given_axis)
    _refuse_gap(long)
    axis = mean_centre(on_axis)
    runs = through_shaft.with_eccentrics(
        runs, through_shaft.find_eccentrics(long, on_axis, axis, rounding_mm)
    )
    others = [run for run in runs if all(run is not other for other in on_axis)]
    pins = _crankpins(long, on_axis, others)
    bent = [run for run in others if pins and _is_out_of_line(run, pins, axis)]
    if bent:  # journals that wander: all of them are the axis, and what is left may be crankpins
        on_axis = sorted([*on_axis, *bent], key=lambda run: run.z_mid)
        axis = mean_centre(on_axis)
        others = [run for run in others if all(run is not other for other in bent)]
        pins = _crankpins(long, on_axis, others)
    if not pins:
        raise RecognitionError(_no_crankpin(long, on_axis, others))
    return layout_of(long, on_axis, pins, axis)


def _no_crankpin(long: SectionStack, on_axis: Sequence[CylinderRun], others: Sequence[CylinderRun]) -> str:
    """Return an error that lists the cylinders next to the axis if they are not crankpins."""
    count = f"{len(on_axis)} cylinder{'s' * (len(on_axis) > 1)} on the axis"
    if not others:
        seen = f"{count} and none beside it"
    else:
        seen = (
            f"{count}, {len(others)} beside it{_list(long, others)}, each with other metal on its stretch"
            " between webs, and not held by a web next to a shaft"
        )
    return (
        f"no crankpins found beside the axis: {seen}. "
        "Set crankpins, or crankpin_in_file = false if they are not in the file"
    )


def _list(long: SectionStack, runs: Sequence[CylinderRun]) -> str:
    """Return the sizes and places of the first few cylinders, after a colon; empty without one."""
    listed = ", ".join(cylinder_text(long, run) for run in runs[:MAX_LISTED_AXES])
    more = f" and {len(runs) - MAX_LISTED_AXES} more" if len(runs) > MAX_LISTED_AXES else ""
    return f": {listed}{more}" if runs else ""


def cylinder_text(long: SectionStack, run: CylinderRun) -> str:
    """Return a text on a cylinder: its size, and its middle in the file's coordinates."""
    x, y, z = np.round(long.in_file(np.array([*run.centre, run.z_mid])), 6) + 0.0
    return f"⌀{2.0 * run.radius:.4g} × {run.width:.4g} mm at [{x:.6g}, {y:.6g}, {z:.6g}] mm"


def _refuse_lone_web(long: SectionStack, runs: Sequence[CylinderRun], rounding_mm: float) -> None:
    """Refuse a single web of a built-up crank if the job sets that its crankpin is in the file."""
    if len(_lines(runs, SAME_CENTRE)) > 1:
        return
    web = single_web(long, runs, bore_runs(long, rounding_mm))
    if web is not None:
        raise RecognitionError(
            "no main journals found, only the bores of one web: "
            f"{cylinder_text(long, web.shaft)} and {cylinder_text(long, web.pin)}. "
            "Set crankpin_in_file = false"
        )


def _arm(
    long: SectionStack, runs: Sequence[CylinderRun], given_axis: Array | None, rounding_mm: float
) -> JournalLayout | None:
    """Return the layout of an arm with a bore for the shaft; None without one, or if it is a shaft's half."""
    lines = _lines(runs, SAME_CENTRE)
    if not 1 <= len(lines) <= 2:  # a crankpin's and a boss's
        return None
    if any(_encloses(*both) for both in permutations(lines, 2)):  # a hollow shaft on both sides of a crankpin
        return None
    bores = bore_runs(long, rounding_mm)
    if given_axis is not None:
        bores = [bore for bore in bores if float(np.linalg.norm(bore.centre - given_axis)) < bore.radius]
    arm = bored_arm(long, runs, bores)
    if arm is None or (arm.settled is False and given_axis is None):
        return None
    other = arm.pin if arm.settled is None and given_axis is None else None
    setting = "crankshaft.crankpin_in_file = false"
    return JournalLayout(
        arm.shaft.centre, (arm.shaft,), (arm.pin,), bored=True, other_axis=other, axis_setting=setting
    )


def layout_of(
    long: SectionStack, on_axis: Sequence[CylinderRun], pins: Sequence[CylinderRun], axis: Array
) -> JournalLayout:
    """Return the layout of cylinders on the axis and crankpins, journals chosen clear of the crankpins."""
    parts = through_shaft.clear_of(on_axis, pins)
    choices = through_shaft.journal_choices(long, [part for part, _ in parts] or on_axis, pins, axis)
    chosen = JournalLayout.chosen(axis, choices, pins)
    journals = [next((run for part, run in parts if part is one), one) for one in chosen.journals]
    shafts = through_shaft.shafts_within(long, on_axis, pins, axis)
    return replace(chosen, journals=tuple(journals), shafts=shafts)


def layout_with_pins(
    long: SectionStack,
    runs: Sequence[CylinderRun],
    pins: Sequence[CylinderRun],
    given_axis: Array | None,
    rounding_mm: float,
) -> JournalLayout:
    """Return the layout of a job's own crankpins, with journals chosen among ``runs``, or the shaft's bore.

    Raises
    ------
    RecognitionError
        If there is no axis.
    """
    bore = _shaft_bore(long, runs, pins, given_axis, rounding_mm)
    if bore is not None:
        return JournalLayout(bore.centre, (bore,), tuple(pins), bored=True)
    on_axis = crank_axis(long, runs, given_axis)
    return layout_of(long, on_axis, pins, on_axis[0].centre)


def _shaft_bore(
    long: SectionStack,
    runs: Sequence[CylinderRun],
    pins: Sequence[CylinderRun],
    given_axis: Array | None,
    rounding_mm: float,
) -> CylinderRun | None:
    """Return the bore for the shaft beside a job's one crankpin; None if a cylinder may be the shaft."""
    if len(pins) != 1:
        return None
    bores = [
        bore
        for bore in shaft_bores(bore_runs(long, rounding_mm), runs, pins[0])
        if given_axis is None or float(np.linalg.norm(bore.centre - given_axis)) < bore.radius
    ]
    return bores[0] if bores else None


def completed(long: SectionStack, layout: JournalLayout) -> JournalLayout:
    """Return a layout of a job's own journals and crankpins with the shaft next to them, and bores marked."""
    on_axis = [
        run
        for run in layout.chosen_from
        if float(np.linalg.norm(run.centre - layout.axis)) < SAME_CENTRE * run.radius
    ]
    shafts = layout.shafts or through_shaft.shafts_within(long, on_axis, layout.pins, layout.axis)
    bored = layout.bored or (len(layout.journals) == 1 and _in_web(long, layout.journals[0]))
    lone = layout.lone_bores or (len(layout.pins) == 1 and _in_web(long, layout.pins[0]))
    return replace(layout, shafts=shafts, bored=bored, lone_bores=lone)


def _in_web(long: SectionStack, run: CylinderRun) -> bool:
    """Return whether a cylinder is a bore: metal is all round its middle, but not within."""
    if not run.width > 0.0:
        return False
    return any(
        any(encloses(hole, run.centre) for hole in piece.holes)
        and piece.reach_from(run.centre) > WEB_REACH * run.radius
        for piece in pieces_around(long, run)
    )


def _refuse_gap(long: SectionStack) -> None:
    """Refuse a part that is in two along the axis: nothing but a crankpin can have held it together."""
    empty = next((section.z_mm for section in long.sections if not section.pieces), None)
    if empty is not None:
        raise GapError(
            f"there is no metal {empty:.4g} mm from the middle of the part. "
            "If the file leaves the crankpins out, set crankpin_in_file = false"
        )


def _is_out_of_line(run: CylinderRun, pins: Sequence[CylinderRun], axis: Array) -> bool:
    """Return whether a cylinder a little beside the axis is a bent crank's journal, not a crankpin."""
    throws = [float(np.linalg.norm(pin.centre - axis)) for pin in pins]
    return float(np.linalg.norm(run.centre - axis)) < OUT_OF_LINE * max(throws)


def mean_centre(runs: Sequence[CylinderRun]) -> Array:
    """Return the mean centre (2,) of cylinders, weighted by width."""
    weights = np.array([run.width for run in runs])
    mean: Array = weights @ np.array([run.centre for run in runs]) / weights.sum()
    return mean


def _crankpins(
    long: SectionStack, on_axis: Sequence[CylinderRun], others: Sequence[CylinderRun]
) -> list[CylinderRun]:
    slack = SLACK_SHARE * long.length_mm
    alone = [
        run
        for run in others
        if all(
            through_shaft.shared_mm(run, other) < slack for other in [*on_axis, *others] if other is not run
        )
    ]
    alone = _without_discs(on_axis, alone)
    if not alone:
        alone = through_shaft.pins_beside_shaft(long, on_axis, others, slack)
    low, high = on_axis[0].z_low, on_axis[-1].z_high
    between = [run for run in alone if low < run.z_mid < high]
    axis = mean_centre(on_axis)
    radii = [float(np.linalg.norm(run.centre - axis)) for run in between]
    beside = [
        run
        for run in alone
        if not between or any(abs(np.linalg.norm(run.centre - axis) - r) < SAME_CENTRE * r for r in radii)
    ]
    pins = sorted(beside, key=lambda run: run.z_mid)
    widest: list[CylinderRun] = []
    for run in pins:
        if (
            widest
            and _same_line(widest[-1], run)
            and not any(widest[-1].z_mid < other.z_mid < run.z_mid for other in on_axis)
            and not _web_between(long, widest[-1], run)
        ):
            if run.width > widest[-1].width:
                widest[-1] = run
        else:
            widest.append(run)
    return widest


def _web_between(long: SectionStack, a: CylinderRun, b: CylinderRun) -> bool:
    """Return whether a web parts two cylinders of one line: metal far beyond them, not their collar."""
    between = [section for section in long.sections if a.z_high < section.z_mm < b.z_low]
    pieces = [piece for section in between for piece in section.pieces if encloses(piece.outline, a.centre)]
    return any(
        piece.reach_from(a.centre) > WEB_REACH * a.radius
        and (
            piece.circle is None
            or float(np.linalg.norm(piece.circle.centre - a.centre)) > SAME_CENTRE * piece.circle.radius
        )
        for piece in pieces
    )


def _without_discs(on_axis: Sequence[CylinderRun], others: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return cylinders without round webs beside the axis: discs that hold the crankpin next to them."""
    kept = list(others)
    while True:
        order = sorted([*on_axis, *kept], key=lambda run: run.z_mid)
        discs = [
            disc
            for disc, pin in [*pairwise(order), *((b, a) for a, b in pairwise(order))]
            if any(disc is run for run in kept)
            and any(pin is run for run in kept)
            and not _same_line(disc, pin)
            and through_shaft.holds(disc, pin, disc.centre)
        ]
        if not discs:
            return kept
        kept = [run for run in kept if all(run is not disc for disc in discs)]


def _same_line(a: CylinderRun, b: CylinderRun) -> bool:
    return float(np.linalg.norm(a.centre - b.centre)) < SAME_CENTRE * min(a.radius, b.radius)
