"""The loop: measure, plan, cut, measure again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autobalance.correction.kind import Correction
from autobalance.crank.anatomy import Anatomy
from autobalance.rotor.moments import Moments
from autobalance.rotor.unbalance import Unbalance
from autobalance.solid.csg import Solid

Outcome = Literal["within_tolerance", "already_within_tolerance", "above_tolerance"]


@dataclass(frozen=True)
class Step:
    """One pass: what was planned, what was predicted and what was measured on the cut solid.

    ``depths_mm`` has one entry a correction, in the order of the result's corrections; magnitudes are those
    of the resultant [g·mm].
    """

    step: int
    depths_mm: tuple[float, ...]
    predicted_g_mm: float
    measured_g_mm: float


@dataclass(frozen=True, eq=False)
class Result:
    """The end of a balancing run.

    ``initial_moments`` and ``final_moments`` are the bare crank's, in the rotor frame; ``initial`` and
    ``residual`` count bob-weights and attached rotors too, as judged. ``solid`` is the corrected crank in
    file coordinates [mm], ``written`` the bytes of its file, from which the residual was measured; both are
    None when nothing was cut.
    """

    outcome: Outcome
    reason: str | None
    initial: Unbalance
    residual: Unbalance
    initial_moments: Moments
    final_moments: Moments
    corrections: tuple[Correction, ...]
    steps: tuple[Step, ...]
    solid: Solid | None
    written: bytes | None


@dataclass(frozen=True, eq=False)
class Rotor:
    """What is balanced: the crank in file coordinates [mm] and what turns with it.

    ``loads`` are the moments of bob-weights and attached rotors, in the rotor frame.
    """

    solid: Solid
    density_g_mm3: float
    anatomy: Anatomy
    loads: Moments
