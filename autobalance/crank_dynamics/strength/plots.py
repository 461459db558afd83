"""Plots of the strength of fillets: stress over the cycle, and safety by fillet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalance.crank_dynamics.strength.answer import StrengthAtSpeed
from autobalance.crank_dynamics.strength.fillets_from_job import FilletCycle
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.report.plot_files import Plot
from autobalance.units import RAD_S_PER_RPM

Plots = dict[str, Plot]


def strength_plots(
    cycle: CycleAnalysis, fillets: Sequence[FilletCycle], sweep: Sequence[StrengthAtSpeed] = ()
) -> Plots:
    """Return the stress of the least safe fillet over the cycle, the safety of all, the least over speeds."""
    from autobalance.report import plots

    known = [each for each in fillets if each.fatigue.safety.gough_pollard is not None]
    if not known:
        return {}
    least = min(known, key=lambda each: each.fatigue.safety.gough_pollard or 0.0)
    bending = least.cost_of_cuts * (
        least.factors.bending * least.bending_MPa - least.factors.shear * least.shear_MPa
    )
    torsion = least.cost_of_cuts * least.factors.torsion * least.torsion_MPa
    curves = {
        "bending": cycle.grid.even(bending),
        "torsion": cycle.grid.even(torsion),
        "von Mises": cycle.grid.even(np.sqrt(bending**2 + 3.0 * torsion**2)),
    }
    at = f"at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    title = f"Stress in the {least.place} fillet of web {least.web} {at}"
    span = 180 * cycle.firing.strokes
    drawn: Plots = {
        "fillet-stress": plots.over_angle(title, "local stress [MPa]", cycle.grid.even_rad, curves, span)
    }
    for place in ("crankpin", "journal"):
        rows = [each for each in fillets if each.place == place]
        if rows:
            names = [f"web {row.web}" for row in rows]
            heights = {
                "Gough and Pollard": [row.fatigue.safety.gough_pollard or 0.0 for row in rows],
                "Goodman": [row.fatigue.safety.goodman or 0.0 for row in rows],
            }
            labels = (f"{place} fillet", "safety")
            drawn[f"{place}-safety"] = plots.named_bars(
                f"Safety of the {place} fillets {at}", labels, names, heights
            )
    known_at = [each for each in sweep if each.least is not None]
    if len(known_at) > 1:
        speeds = np.array([each.speed_rpm for each in known_at])
        least_safe = np.array([each.least.gough_pollard for each in known_at if each.least is not None])
        curves_by_speed = [plots.Curve("Gough and Pollard", speeds, least_safe)]
        with_rule = [each for each in sweep if each.m53_factor is not None]
        if len(with_rule) > 1:
            rule = np.array([(each.speed_rpm, each.m53_factor) for each in with_rule])
            curves_by_speed.append(plots.Curve("IACS UR M53, at least 1.15", *rule.T))
        labels = ("speed [1/min]", "safety")
        drawn["safety-over-speed"] = plots.lines("Minimum safety of the fillets", labels, curves_by_speed)
    return drawn
