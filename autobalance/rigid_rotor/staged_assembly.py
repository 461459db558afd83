"""Staged assembly of a shaft: the unbalance of each part, and its correction before the next. mm, g, s.

Vectors across the axis are complex, x + i y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from autobalance.value_classes import dataclass

KeyShare = Literal["none", "half", "full"]

SHARES: Mapping[KeyShare, float] = {"none": 0.0, "half": 0.5, "full": 1.0}
"""Share of the key in the balancing of a shaft or a part."""
CRANK = "crank"
"""Name of the shaft that starts with the crank's own residual."""


@dataclass(frozen=True)
class ShaftKey:
    """A key between shaft and part, and its share in the balancing of each."""

    mass_g: float
    offset_mm: complex
    z_mm: float
    shaft: KeyShare = "half"
    part: KeyShare = "half"

    @property
    def left_over_g_mm(self) -> complex:
        """Return the unbalance by the key: its own times one less both shares.

        Two halves make one key [1]_; a full key in both counts once too much.

        References
        ----------
        .. [1] ISO 21940-32:2012, the half-key convention.
        """
        return self.mass_g * self.offset_mm * (1.0 - SHARES[self.shaft] - SHARES[self.part])


@dataclass(frozen=True)
class Part:
    """A part to be fitted: its own unbalance about its bore, and the distance of the bore from the axis.

    ``moment_g_mm2`` is ∫ z (x + i y) dm of the part's own unbalance about the rotor's z = 0. ``correct_mm``
    are one or two planes in which the sum is corrected before the next part.
    """

    name: str
    shaft: str
    mass_g: float
    z_mm: float
    unbalance_g_mm: complex
    moment_g_mm2: complex
    runout_mm: complex = 0j
    key: ShaftKey | None = None
    correct_mm: tuple[float, ...] = ()
    permissible_g_mm: float | None = None
    speed_ratio: float = 1.0


@dataclass(frozen=True)
class ShaftState:
    """Present state of a shaft: mass, unbalance and its moment about z = 0."""

    mass_g: float
    unbalance_g_mm: complex
    moment_g_mm2: complex


@dataclass(frozen=True)
class Taken:
    """Unbalance removed in a plane."""

    z_mm: float
    unbalance_g_mm: complex


@dataclass(frozen=True)
class AssemblyStage:
    """A fitted part: its contributions, the sum before the correction, and the residual after it."""

    part: Part
    mass_g: float
    runout_g_mm: complex
    key_g_mm: complex
    sum_g_mm: complex
    sum_moment_g_mm2: complex
    permissible_g_mm: float
    corrections: tuple[Taken, ...]
    left_g_mm: complex

    @property
    def within(self) -> bool:
        """Whether the sum before its correction is within the permissible residual unbalance."""
        return abs(self.sum_g_mm) <= self.permissible_g_mm


def assemble(
    crank: ShaftState, parts: Sequence[Part], grade_mm_s: float, service_speed_rad_s: float
) -> tuple[AssemblyStage, ...]:
    """Return the stages of putting parts on their shafts in order.

    Parameters
    ----------
    crank : ShaftState
        The crank with its residual.
    parts : sequence of Part
    grade_mm_s, service_speed_rad_s : float
        A stage's permissible residual unbalance is G m/Ω of the mass so far, or that of the part.

    Examples
    --------
    >>> disc = Part("disc", "crank", 1000.0, 80.0, 20 + 0j, 1600 + 0j, runout_mm=0.01j, correct_mm=(80.0,))
    >>> (stage,) = assemble(ShaftState(2000.0, -5 + 0j, 0j), [disc], 6.3, 600.0)
    >>> stage.sum_g_mm, stage.left_g_mm, round(stage.permissible_g_mm, 3)
    ((15+10j), 0j, 31.5)
    """
    shafts = {CRANK: crank}
    stages = []
    for part in parts:
        stage, shafts[part.shaft] = _put_on(
            shafts.get(part.shaft, ShaftState(0.0, 0j, 0j)), part, grade_mm_s / service_speed_rad_s
        )
        stages.append(stage)
    return tuple(stages)


def _put_on(shaft: ShaftState, part: Part, specific_mm: float) -> tuple[AssemblyStage, ShaftState]:
    runout = part.mass_g * part.runout_mm
    key = 0j if part.key is None else part.key.left_over_g_mm
    key_moment = 0j if part.key is None else part.key.z_mm * key
    mass = shaft.mass_g + part.mass_g
    total = shaft.unbalance_g_mm + part.unbalance_g_mm + runout + key
    moment = shaft.moment_g_mm2 + part.moment_g_mm2 + part.z_mm * runout + key_moment
    permissible = part.permissible_g_mm
    if permissible is None:
        permissible = mass * specific_mm / part.speed_ratio
    corrections = _taken(total, moment, part.correct_mm)
    left = total - sum(each.unbalance_g_mm for each in corrections)
    left_moment = moment - sum(each.z_mm * each.unbalance_g_mm for each in corrections)
    # In two planes everything goes; sums would leave rounding.
    after = (
        ShaftState(mass, 0j, 0j)
        if len(corrections) == 2
        else ShaftState(mass, complex(left), complex(left_moment))
    )
    stage = AssemblyStage(
        part, mass, runout, key, total, moment, permissible, corrections, after.unbalance_g_mm
    )
    return stage, after


def _taken(total: complex, moment: complex, places_mm: tuple[float, ...]) -> tuple[Taken, ...]:
    if not places_mm:
        return ()
    if len(places_mm) == 1:
        return (Taken(places_mm[0], total),)
    first, second = places_mm
    in_first = (second * total - moment) / (second - first)
    return Taken(first, in_first), Taken(second, total - in_first)
