"""``ab.influence``: weights that correct a rotor of any kind, from readings with trial weights."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from autobalance.errors import JobError
from autobalance.report.plots import Plots
from autobalance.test_stands.influence.answer import (
    InfluenceReport,
    PlaneCorrection,
    PlaneWeight,
    ResidualReadings,
    SplitWeight,
)
from autobalance.types import Complex
from autobalance.units import wrapped_deg
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.test_stands.influence.input import Trials

LARGEST_CONDITION = 1e4
"""Above it the readings cannot distinguish the planes."""
WARNED_CONDITION = 30.0
NAMED_SHARE = 0.3
"""Share of the weakest combination of weights: planes with at least this are named."""
TARGET_TOLERANCE = 1e-9
"""Relative, by which a residual may pass its target: rounding."""


class InfluenceResult(VerbResult):
    """Influence coefficients, the weights to add and what they leave."""

    content: InfluenceReport

    def files(self) -> Mapping[str, bytes]:
        """Return ``reading.toml`` for ``recut``, the unbalance found, if ``[reading]`` names the planes."""
        from autobalance.test_stands.influence.answer import unbalance_toml

        has_reading = self.content.input["reading"] is not None
        return {"reading.toml": unbalance_toml(self.content).encode()} if has_reading else {}

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 4 where a residual is above the target."""
        return 4 if self.content.outcome == "above_tolerance" else 0

    def text(self, units: str = "metric") -> str:
        """Return the corrections as lines for people."""
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.test_stands.influence.answer import influence_text

        return influence_text(self.content, ON_SCREEN[units])

    def plots(self) -> Plots:
        """Return a polar plot of the readings before and after."""
        from autobalance.test_stands.influence.answer import readings_plot

        return Plots(readings_plot(self.content))


def influence(trials: str | Path | Mapping[str, Any]) -> InfluenceResult:
    """Find the weights that bring readings down, by influence coefficients.

    Parameters
    ----------
    trials : path or dict
        Readings without and with trial weights, a TRIALS.toml. Or its structure.

    Returns
    -------
    InfluenceResult

    Raises
    ------
    JobError
        If a key is wrong, a trial weight changes nothing, or the planes cannot be distinguished.

    Examples
    --------
    >>> result = influence({"initial": [[2.0, 0.0]],
    ...     "trial": [{"plane": 1, "g_mm": 5.0, "angle_deg": 0.0, "readings": [[3.0, 0.0]]}]})
    >>> [round(result.report["corrections"][0][key], 6) for key in ("g_mm", "angle_deg")]
    [10.0, 180.0]
    """
    from autobalance.test_stands.influence.input import read_trials
    from autobalance.toml_files.keys import named_in

    task = read_trials(trials)
    with named_in(trials):
        return InfluenceResult(_report(task))


def _report(task: Trials) -> InfluenceReport:
    from autobalance.test_stands.influence import limited_weights as coefficients

    alpha = coefficients.influence_coefficients(task.initial, task.trials, len(task.planes))
    condition, shares = coefficients.condition(alpha, task.reading_weights)
    close = [str(plane) for plane, share in zip(task.planes, shares, strict=True) if share >= NAMED_SHARE]
    if condition > LARGEST_CONDITION:
        raise JobError(
            f"condition is {condition:.3g}; must be at most {LARGEST_CONDITION:g}: the readings cannot set "
            f"the planes {', '.join(close)} apart; choose other planes, speeds or sensors"
        )
    sums, split, warnings = _weights(task, alpha)
    if condition > WARNED_CONDITION:
        warnings.append(
            f"condition is {condition:.3g}, over {WARNED_CONDITION:g}: the planes {', '.join(close)} have "
            "nearly the same effect on the readings, so errors of reading grow in their weights"
        )
    residual = task.initial + alpha @ sums
    weighted = task.reading_weights * np.abs(residual)
    left = coefficients.left_on_g_mm(task.trials, len(task.planes))
    outcome, reason = _verdict(task, residual)
    return InfluenceReport(
        input=task.values,
        goal=task.goal,
        planes=task.planes,
        influence=[[_reading(value, task) for value in row] for row in alpha],
        condition=condition,
        corrections=[
            _correction(task, number, complex(sums[number]), split[number])
            for number in range(len(task.planes))
        ],
        add_to_left=_add_to_left(task, sums, left),
        initial=[_reading(value, task) for value in task.initial],
        residual=ResidualReadings(
            readings=[_reading(value, task) for value in residual],
            worst=float(weighted.max()),
            rms=float(np.sqrt(np.mean(weighted**2))),
        ),
        outcome=outcome,
        reason=reason,
        warnings=warnings,
    )


def _weights(task: Trials, alpha: Complex) -> tuple[Complex, list[list[SplitWeight] | None], list[str]]:
    """Return each plane's sum, what is fitted where, and what there is to warn of."""
    from autobalance.test_stands.influence.fitted_weights import fitted_weights
    from autobalance.test_stands.influence.limited_weights import limited_weights

    if all(each.free for each in task.fittings):
        limits = np.array([each.limit_g_mm for each in task.fittings])
        sums = limited_weights(alpha, task.initial, task.reading_weights, limits, task.goal)
        return sums, [None] * len(task.planes), []
    weights = fitted_weights(alpha, task.initial, task.reading_weights, task.fittings)
    split = [
        None
        if fitted is None
        else [SplitWeight(angle_deg=_degrees(angle), g_mm=g_mm) for angle, g_mm in sorted(fitted)]
        for fitted in weights.split
    ]
    if not weights.proven:
        short = (
            f"the set found leaves {weights.worst:.4g} at worst; none leaves less than {weights.bound:.4g}; "
            "no time was left for the sets between"
        )
        return weights.sums_g_mm, split, [short]
    return weights.sums_g_mm, split, []


def _correction(
    task: Trials, number: int, weight: complex, split: list[SplitWeight] | None
) -> PlaneCorrection:
    radius = task.radius_mm[number]
    angle = _degrees(float(np.angle(weight)))
    return PlaneCorrection(
        plane=task.planes[number],
        g_mm=abs(weight),
        angle_deg=angle,
        remove_angle_deg=wrapped_deg(angle + 180.0),
        g=None if radius is None else abs(weight) / radius,
        radius_mm=radius,
        split=split,
    )


def _add_to_left(task: Trials, sums: Complex, left: Complex) -> list[PlaneWeight] | None:
    """Return weights to add where the trial weights stay on; None where none were left on."""
    if not any(trial.left_on for trial in task.trials):
        return None
    more = sums - left
    return [
        PlaneWeight(plane=plane, g_mm=abs(weight), angle_deg=_degrees(float(np.angle(weight))))
        for plane, weight in zip(task.planes, more.tolist(), strict=True)
    ]


def _verdict(
    task: Trials, residual: Complex
) -> tuple[Literal["within_tolerance", "above_tolerance"] | None, str | None]:
    if task.target is None:
        return None, None
    sizes = np.abs(residual)
    worst = int(np.argmax(sizes))
    if sizes[worst] <= task.target * (1.0 + TARGET_TOLERANCE):
        return "within_tolerance", None
    limited = any(not each.free or math.isfinite(each.limit_g_mm) for each in task.fittings)
    fix = "wider limits, more places or finer weights" if limited else "more planes, or a higher target"
    return (
        "above_tolerance",
        f"reading {worst + 1} keeps an amplitude of {sizes[worst]:.4g}, over the target of {task.target:g}; "
        f"{fix} would bring it down",
    )


def _reading(value: complex, task: Trials) -> list[float]:
    """Return a reading as amplitude and phase, in the sense in which the file counts phases."""
    written = value.conjugate() if task.phases_opposite else value
    return [abs(written), _degrees(float(np.angle(written)))]


def _degrees(angle_rad: float) -> float:
    """Return an angle in [0, 360)."""
    turned = wrapped_deg(math.degrees(angle_rad))
    return 0.0 if turned >= 360.0 else turned
