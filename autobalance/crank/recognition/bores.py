"""Round holes along the crank axis, and cranks whose shaft is not in the file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from autobalance.crank.recognition.circles import corners_of, distances, following
from autobalance.crank.recognition.cylinder_runs import (
    LEAST_WIDTH,
    SAME_CENTRE,
    CylinderRun,
    Link,
    run_of_chain,
)
from autobalance.crank.recognition.datums import shaft_marks
from autobalance.crank.recognition.section_stack import CrossSection, SectionPiece, SectionStack, encloses
from autobalance.crank.recognition.through_shaft import shared_mm
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Round holes along the crank axis.


MAX_CROSSING = 2.0
"""Drillings that meet a bore hide its circle over at most so many of its radii, slanting ones too ..."""
LEAST_OPEN = 0.9
"""... and leave it open to at least this share of its radius."""
WALL_LEFT = 1.02
"""Largest distance from the middle of a bore, in radii, to the remaining wall next to a bore across."""


def bore_runs(long: SectionStack, rounding_mm: float) -> list[CylinderRun]:
    """Return the round holes along the axis, by increasing z."""
    chains: list[list[Link]] = []
    for place, section in enumerate(long.sections):
        for piece in section.pieces:
            for bore in piece.bores:
                here = Link(place, bore.centre, bore.radius)
                for chain in reversed(chains):
                    if here.continues(chain[0], piece.rough_mm) and _follows(long, chain[-1], here):
                        chain.append(here)
                        break
                else:
                    chains.append([here])
    runs = [_bore(long, chain, rounding_mm) for chain in chains]
    return sorted((run for run in runs if run is not None), key=lambda run: run.z_mid)


def _follows(long: SectionStack, last: Link, here: Link) -> bool:
    """Return whether a hole continues from one section to another: drillings that meet it may lie between."""
    between = long.sections[last.place + 1 : here.place]
    gap = long.sections[here.place].z_mm - long.sections[last.place].z_mm
    if here.place == last.place or (between and gap > MAX_CROSSING * here.radius):
        return False
    return all(_is_open(section, here) for section in between)


def _is_open(section: CrossSection, bore: Link) -> bool:
    """Return whether a section has a hole about a bore's middle that is at least as wide, but not round."""
    return _is_cut_open(section, bore) or any(
        not circles
        and encloses(hole, bore.centre)
        and float(distances(hole, bore.centre).min()) > LEAST_OPEN * bore.radius
        for piece in section.pieces
        for hole, circles in zip(piece.holes, piece.bores_of_holes, strict=True)
    )


def _is_cut_open(section: CrossSection, bore: Link) -> bool:
    """Return whether a part of a bore's wall is left, but no hole: a bore across cut the metal around it."""
    if any(encloses(piece.outline, bore.centre) for piece in section.pieces):
        return False
    nearest = min((float(distances(p.outline, bore.centre).min()) for p in section.pieces), default=0.0)
    return LEAST_OPEN * bore.radius < nearest < WALL_LEFT * bore.radius


def _bore(long: SectionStack, chain: Sequence[Link], rounding_mm: float) -> CylinderRun | None:
    if long.blur_mm == 0.0:
        return run_of_chain(long, chain, rounding_mm, 0.0)
    low, high = (long.sections[link.place].z_mm for link in (chain[0], chain[-1]))
    centre = np.median([link.centre for link in chain], axis=0)
    return CylinderRun(centre, float(np.median([link.radius for link in chain])), low, high)


# Cranks whose shaft is not in the file: an arm with its crankpin, one web of a built-up crank drawn alone.
#
# The bore for the shaft is the axis then. A keyway or spline, the length and size of two cylinders or bores
# and the counterweight decide which is the shaft's and which the crankpin's. If these decide nothing, or do
# not agree, it is a doubt.


MIN_BORE_RATIO = 0.3
"""A bore is a shaft's or a crankpin's from this share of the other one's size on, else for a bolt or oil."""
SHAFT_LENGTH_RATIO = 1.7
"""A shaft is this many times as long as the crankpin's bore next to it is deep. Half a pressed-up motocross
crank has 2.0. A pump's arm has a crankpin 1.4 times as long as the shaft's bore, and metal far beyond it."""
REACH_RATIO = 1.3
"""A counterweight makes metal beyond the shaft reach this many times as far as that beyond the crankpin."""
SIZE_RATIO = 1.3
"""The shaft's bore is this many times as wide as the other."""
THIRD_RATIO = 0.9
"""A third bore is smaller than this share of the second one, else it is not certain which two are meant."""
THROUGH_SHARE = 0.5
"""Bores of one web share at least this much of the shorter one."""
ARC_ROUND = 2e-3
"""Corners of an arc about a bore are equally far from it except for this share."""
MAX_FACET_RATIO, MIN_ARC_FACETS = 0.8, 3
"""Largest length of its facets as a share of its radius, and minimum number: a plate's edges are long."""
MIN_ARC_RAD = 0.7
"""A hub, a boss or a rim goes round a bore by at least this angle."""
END_RATIO = 1.2
"""A crankpin's free end, its head or thread included, is at most this many times as wide as itself."""
MIN_WAIST_RATIO = 0.9
"""Halfway between its bores a web is at least this share as wide as at the narrower end; a connecting rod's
shank is narrower."""


@dataclass(frozen=True, eq=False)
class BoredWeb:
    """A web with a bore: what is taken for the axis, what for the crankpin, and whether that is certain.

    ``settled`` is True if signs agree on this reading, False if they agree on the other one, None if they say
    nothing or contradict each other.
    """

    shaft: CylinderRun
    pin: CylinderRun
    settled: bool | None

    @property
    def exchanged(self) -> BoredWeb:
        """The same web, shaft and crankpin the other way round."""
        return BoredWeb(self.pin, self.shaft, None if self.settled is None else not self.settled)


def bored_arm(
    long: SectionStack, runs: Sequence[CylinderRun], bores: Sequence[CylinderRun]
) -> BoredWeb | None:
    """Return an arm with a bore for the shaft, and a cylinder beside it as its crankpin; None without one.

    The cylinder and others in line with it are all that stand out, and on one side of the arm only; except
    for bosses around the bore.
    """
    for bore in _by_size(bores):
        beside = [run for run in runs if _apart(run, bore) > SAME_CENTRE * run.radius]
        if not beside or len(beside) < len([run for run in runs if not _is_boss(run, bore)]):
            continue
        stub = max(beside, key=lambda run: run.width)
        in_line = all(_apart(run, stub) < SAME_CENTRE * stub.radius for run in beside)
        sides = {run.z_mid > bore.z_mid for run in beside}
        clear = all(shared_mm(run, bore) < THROUGH_SHARE * min(run.width, bore.width) for run in beside)
        free = _ends_free(long, bore, beside)
        if in_line and clear and free and len(sides) == 1 and bore.radius >= MIN_BORE_RATIO * stub.radius:
            return BoredWeb(bore, stub, _arm_signs(long, bore, stub, beside))
    return None


def _ends_free(long: SectionStack, bore: CylinderRun, beside: Sequence[CylinderRun]) -> bool:
    """Return whether no second web holds cylinders away from a bore: nothing but their own end follows."""
    low, high = min(run.z_low for run in beside), max(run.z_high for run in beside)
    up = beside[0].z_mid > bore.z_mid
    beyond = [section for section in long.sections if (section.z_mm > high if up else section.z_mm < low)]
    widest = max(run.radius for run in beside)
    return all(
        piece.reach_from(beside[0].centre) <= END_RATIO * widest
        for section in beyond
        for piece in section.pieces
    )


def _arm_signs(
    long: SectionStack, bore: CylinderRun, stub: CylinderRun, beside: Sequence[CylinderRun]
) -> bool | None:
    """Return whether keyway, or counterweight and length, say that the bore is the shaft's, or is not."""
    unkeyed = _shape_signs(long, bore, stub, beside)
    keyed = _keyed_sign(
        bool(shaft_marks(long, bore, bore=True)), any(shaft_marks(long, run) for run in beside)
    )
    return unkeyed if keyed is None else _agreed([keyed, unkeyed])


def _keyed_sign(first: bool, second: bool) -> bool | None:
    """Return whether the first of two alone is keyed to a shaft, or the second alone; None for neither."""
    return first if first is not second else None


def _agreed(signs: Iterable[bool | None]) -> bool | None:
    """Return the common result of signs that decide; None if they contradict each other or decide nothing."""
    told = {sign for sign in signs if sign is not None}
    return told.pop() if len(told) == 1 else None


def _shape_signs(
    long: SectionStack, bore: CylinderRun, stub: CylinderRun, beside: Sequence[CylinderRun]
) -> bool | None:
    """Return whether counterweight and length agree that the bore is the shaft's, or that it is not."""
    length = max(run.z_high for run in beside) - min(run.z_low for run in beside)
    is_long = length >= SHAFT_LENGTH_RATIO * bore.width
    opposite = _sign(
        _reach_beyond(long, bore, stub) / max(_reach_beyond(long, stub, bore), 1e-9), REACH_RATIO
    )
    if len(beside) > 1 and opposite is not True:  # a shaft has steps
        return False
    return None if opposite is is_long else opposite


def single_web(
    long: SectionStack, runs: Sequence[CylinderRun], bores: Sequence[CylinderRun], is_web: bool = False
) -> BoredWeb | None:
    """Return the bores of one web, drawn alone: the shaft's and the crankpin's; None if it is not such a web.

    A plate with more bores of a size is not a web. Nor is one with a waist, as a connecting rod has, nor one
    without a hub, boss or rim about a bore, as a bracket. A job's ``is_web`` overrides this.
    """
    ordered = _by_size(bores)
    if len(ordered) < 2:
        return None
    one, other = ordered[:2]
    if other.radius < MIN_BORE_RATIO * one.radius or (
        len(ordered) > 2 and ordered[2].radius > THIRD_RATIO * other.radius
    ):
        return None
    same_web = shared_mm(one, other) >= THROUGH_SHARE * min(one.width, other.width)
    if not same_web or _has_shaft(runs, one, other) or _has_waist(long, one, other):
        return None
    if not (is_web or any(_has_arc(long, bore) for bore in (one, other))):
        return None
    reach = _reach_beyond(long, one, other) / max(_reach_beyond(long, other, one), 1e-9)
    size = one.radius / other.radius
    mass = _sign(reach, REACH_RATIO)
    keyed = _keyed_sign(*(bool(shaft_marks(long, bore, bore=True)) for bore in (one, other)))
    agreed = _agreed([mass, _sign(size, SIZE_RATIO) if keyed is None else keyed])
    is_first = next((sign for sign in (keyed, mass, agreed) if sign is not None), True)
    shaft, pin = (one, other) if is_first else (other, one)
    return BoredWeb(shaft, pin, None if agreed is None else True)


def shaft_bores(
    bores: Sequence[CylinderRun], runs: Sequence[CylinderRun], pin: CylinderRun
) -> list[CylinderRun]:
    """Return the bores that may be the shaft's beside a known crankpin, largest first.

    There are no such bores if a shaft sticks out, or two bores are of a size: it is not certain which is
    meant.
    """
    beside = [
        bore
        for bore in _by_size(bores)
        if _apart(bore, pin) > pin.radius and bore.radius >= MIN_BORE_RATIO * pin.radius
    ]
    if not beside or (len(beside) > 1 and beside[1].radius > THIRD_RATIO * beside[0].radius):
        return []
    others = [run for run in runs if _apart(run, pin) > SAME_CENTRE * pin.radius]
    return beside if all(_is_boss(run, beside[0]) or _is_boss(run, pin) for run in others) else []


def _by_size(bores: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return bores by falling radius, without the rings of chamfers."""
    deep = [bore for bore in bores if bore.width >= LEAST_WIDTH * bore.radius]
    return sorted(deep, key=lambda bore: -bore.radius)


def _sign(ratio: float, clear: float) -> bool | None:
    """Return whether a ratio speaks for the first of two, or for the second; None for neither."""
    return True if ratio > clear else False if ratio < 1.0 / clear else None


def _has_shaft(runs: Sequence[CylinderRun], one: CylinderRun, other: CylinderRun) -> bool:
    """Return whether a cylinder is more than a web's rim or a boss around one of its bores."""
    return any(not (_is_boss(run, one) or _is_boss(run, other)) for run in runs)


def _is_boss(run: CylinderRun, bore: CylinderRun) -> bool:
    """Return whether a cylinder is the rim or a boss around a bore; one longer than its radius is a shaft."""
    return (
        _apart(run, bore) < SAME_CENTRE * run.radius and bore.radius < run.radius and run.width < run.radius
    )


def _has_arc(long: SectionStack, bore: CylinderRun) -> bool:
    """Return whether part of the outline around a bore's middle is an arc about it."""
    for piece in pieces_around(long, bore):
        corners = corners_of(piece.outline, piece.grain_mm) - bore.centre
        after = following(corners)
        away, step = np.hypot(*corners.T), np.linalg.norm(after - corners, axis=1)
        same = np.abs(following(away) - away) < ARC_ROUND * away
        arc = same & (step < MAX_FACET_RATIO * away) & (away > (1.0 + ARC_ROUND) * bore.radius)
        for radius in away[arc]:
            on = arc & (np.abs(away - radius) < ARC_ROUND * radius)
            angle = float(2.0 * np.arcsin(0.5 * step[on] / away[on]).sum())
            if np.count_nonzero(on) >= MIN_ARC_FACETS and angle > MIN_ARC_RAD:
                return True
    return False


def pieces_around(long: SectionStack, *bores: CylinderRun) -> list[SectionPiece]:
    """Return the pieces that hold bores in the middlemost section that has them: a bore across may cut it."""
    low, high = max(bore.z_low for bore in bores), min(bore.z_high for bore in bores)
    held = [
        (section, pieces)
        for section in long.sections
        if low < section.z_mm < high
        and (
            pieces := [
                piece
                for piece in section.pieces
                if all(encloses(piece.outline, bore.centre) for bore in bores)
            ]
        )
    ]
    middle = 0.5 * (low + high)
    return min(held, key=lambda item: abs(item[0].z_mm - middle), default=(None, []))[1]


def _has_waist(long: SectionStack, one: CylinderRun, other: CylinderRun) -> bool:
    """Return whether metal between two bores is narrower than at both: the shank of a connecting rod."""
    pieces = pieces_around(long, one, other)
    if not pieces:
        return False
    widths = [
        _width_across(pieces, one.centre + share * (other.centre - one.centre), other.centre - one.centre)
        for share in (0.0, 0.5, 1.0)
    ]
    return widths[1] < MIN_WAIST_RATIO * min(widths[0], widths[2])


def _width_across(pieces: Sequence[SectionPiece], point: Array, along: Array) -> float:
    """Return the width of a section through a point (2,), square to a direction (2,)."""
    unit = along / np.linalg.norm(along)
    across: list[float] = []
    for piece in pieces:
        local = (piece.outline - point) @ np.array([[unit[0], -unit[1]], [unit[1], unit[0]]])
        after = following(local)
        crossing = (local[:, 0] > 0.0) != (after[:, 0] > 0.0)
        a, b = local[crossing], after[crossing]
        across += (a[:, 1] - a[:, 0] * (b[:, 1] - a[:, 1]) / (b[:, 0] - a[:, 0])).tolist()
    return max(across) - min(across) if across else 0.0


def _apart(a: CylinderRun, b: CylinderRun) -> float:
    return float(np.linalg.norm(a.centre - b.centre))


def _reach_beyond(long: SectionStack, here: CylinderRun, other: CylinderRun) -> float:
    """Return the reach of metal beyond one cylinder, seen from another [mm]."""
    away = (here.centre - other.centre) / max(_apart(here, other), 1e-12)
    pieces = dict.fromkeys(piece for section in long.sections for piece in section.pieces)
    return max(float(((piece.outline - here.centre) @ away).max()) for piece in pieces)
