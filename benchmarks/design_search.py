"""Counterweights of the bundled motocross crank: lightened at its own factor and inertia, in two ways.

One is that of ``autobalance design``: the balance of every design is solved for, the best are refined by
gradients. The other is the usual published one: a genetic algorithm over the same control points, the balance
and the inertia by penalties. Both may ask for the moments of as many designs, each call counted.

    python benchmarks/design_search.py [--calls 6000] [--seeds 3] [--radius 62]
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from autobalance.balancing import rotor_from_job
from autobalance.balancing.measured_crank import measure_crank
from autobalance.profile_search.candidates import judged, with_refined
from autobalance.profile_search.envelope import violation
from autobalance.profile_search.free_metal import free_metal
from autobalance.profile_search.input import parse_design
from autobalance.profile_search.problem import Problem
from autobalance.profile_search.search import searched
from autobalance.runtime import Stopwatch

CRANK = Path(__file__).parents[1] / "fixtures" / "crf250r" / "straight" / "crank.stl"
SAME = 1e-3
"""Share by which the polar inertia may differ."""
WITHIN = 0.01
"""Share of the permissible unbalance that a design may leave, as ``design`` asks."""
PENALTIES = (1e2, 1e3, 1e4)
"""Of a unit of broken constraint [g]; the best of them counts for the published way."""


class Counted(Problem):
    """Counts how often moments are asked for."""

    calls = 0

    def moments(self, variables: Any) -> Any:
        type(self).calls += 1
        return super().moments(variables)


def tables(
    radius_mm: float, factor: float, inertia: tuple[float, float] | None, evaluations: int, seed: int
) -> dict[str, Any]:
    """Return the design's tables."""
    return {
        "crankshaft": {"file": str(CRANK), "unit": "mm", "density_kg_m3": 7850.0, "crankpin_in_file": False},
        "engine": {
            "rotating_g": {"big_end": 134.04},
            "reciprocating_g": {"rest": 261.5},
            "crankpin_g": {"crankpin": 114.65},
        },
        "balance": {"factor": factor, "grade": 6.3, "speed_rpm": 15200},
        "counterweight": [
            {
                "webs": [1, 2], "sector_deg": [90, 270], "points": 11, "hold_radius_mm": 26.0,
                "symmetric": True, "radius_mm": [26.5, radius_mm], "thickness_mm": [10.0, 20.0],
            }
        ],
        "envelope": {"radius_mm": radius_mm},
        **({} if inertia is None else {"target": {"polar_inertia_kg_mm2": list(inertia)}}),
        "search": {"objectives": ["mass_g"], "evaluations": evaluations, "seed": seed},
    }  # fmt: skip


def own_way(problem: Problem) -> tuple[float, float]:
    """Return mass and violation of the best design that ``design`` finds."""
    every = with_refined(searched(problem, [], lambda _: None))
    best = min(every.candidates, key=lambda each: (each.violation, each.objectives[0]))
    return float(best.objectives[0]), best.violation


def published_way(problem: Problem, calls: int, seed: int, penalty: float) -> tuple[float, float, float]:
    """Return mass, share of the permissible unbalance and violation of the least penalised design."""
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    low, high = problem.bounds.T
    best: list[tuple[float, float, float, float]] = []

    class Penalised(ElementwiseProblem):
        def _evaluate(self, x: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
            moments = problem.moments(x)[0]
            residual = problem.residual(moments)
            constraints, _clearances = problem.constraints(x, moments, residual, exact=False)
            share = constraints[0].value
            broken = violation(constraints[1:]) + max(share - WITHIN, 0.0)
            out["F"] = moments.mass_g + penalty * broken
            best.append((float(out["F"]), moments.mass_g, share, violation(constraints[1:])))

    space = Penalised(n_var=len(low), n_obj=1, xl=low, xu=high)
    minimize(space, GA(pop_size=40), ("n_eval", calls), seed=seed, verbose=False)
    return min(best)[1:]


def main() -> None:
    """Measure and print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=6000)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--radius", type=float, default=62.0)
    given = parser.parse_args()
    start = parse_design(tables(given.radius, 0.5, None, 1, 1), Path("design.toml"))
    crank = measure_crank(start.start.crankshaft, Stopwatch())
    loads = rotor_from_job.throw_loads(crank.anatomy, start.start.engine)
    factor = rotor_from_job.crank_factor(crank.moments, loads, rotor_from_job.attached_moments(()))
    assert factor is not None
    inertia = crank.moments.polar_inertia_g_mm2 / 1000.0
    print(f"as it is: {crank.moments.mass_g:.1f} g, {inertia:.1f} kg·mm², factor {factor:.4f}")
    limits = (1.0 - SAME) * inertia, (1.0 + SAME) * inertia
    for seed in range(1, given.seeds + 1):
        evaluations = given.calls // 20
        while True:
            job = parse_design(tables(given.radius, factor, limits, evaluations, seed), Path("design.toml"))
            problem = Counted.of(job, crank, free_metal(job, crank))
            Counted.calls, since = 0, time.process_time()
            mass, broken = own_way(problem)
            if Counted.calls <= given.calls:
                break
            evaluations = int(0.8 * evaluations)
        seconds, calls = time.process_time() - since, Counted.calls
        print(
            f"seed {seed}, design:    {mass:8.1f} g, violation {broken:.3g}; {calls} calls, {seconds:.0f} s"
        )
        for penalty in PENALTIES:
            Counted.calls, since = 0, time.process_time()
            mass, share, broken = published_way(problem, given.calls, seed, penalty)
            seconds = time.process_time() - since
            print(
                f"seed {seed}, published: {mass:8.1f} g, violation {broken:.3g}, unbalance {share:.2f} of "
                f"permissible, penalty {penalty:g}; {Counted.calls} calls, {seconds:.0f} s"
            )
    print(f"the start, its balance solved for: {judged(problem, problem.start).objectives[0]:.1f} g")


if __name__ == "__main__":
    main()
