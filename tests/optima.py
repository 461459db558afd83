"""The least metal of small planning cases, found by trying every set of cuts and stored beside this file.

Half a minute a case: ``python -m tests.optima`` finds them anew and writes ``optima.json``.
"""

from __future__ import annotations

import cmath
import itertools
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from autobalance.correction.kind import Candidates
from autobalance.planning.depths import AIM_SHARE, plan_depths
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from tests.holes import at_planes, holes, tolerance

STORED = Path(__file__).with_name("optima.json")
Case = tuple[Unbalance, Tolerance, Candidates, int]
"""What to correct, what is judged, the cuts at hand and how many of them are tried at most."""


def static_case(seed: int) -> Case:
    """Return a resultant and one web."""
    rng = np.random.default_rng(seed)
    candidates = holes([12.0], [0.0], places=10, max_holes=4, max_depth_mm=9.0)
    angle, size = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(600.0, 1250.0)
    residual = Unbalance(size * np.array([math.cos(angle), math.sin(angle)]), np.zeros(2))
    return residual, tolerance(50.0, "static"), candidates, 4


def two_plane_case(seed: int) -> Case:
    """Return unbalance in two planes and two webs."""
    rng = np.random.default_rng(seed)
    candidates = holes([12.0], [-40.0, 40.0], places=8, max_holes=2, max_depth_mm=16.0)
    angle, size = rng.uniform(0.0, 2.0 * math.pi, 2), rng.uniform(500.0, 900.0, 2)
    a, b = (s * complex(math.cos(t), math.sin(t)) for s, t in zip(size, angle, strict=True))
    return at_planes(a, b), tolerance(50.0), candidates, 4


def few_case(seed: int) -> Case:
    """Return unbalance that few holes correct, some in planes opposed."""
    rng = np.random.default_rng(seed)
    candidates = holes([10.0], [-40.0, 40.0], places=7, max_holes=2)
    size, angle = rng.uniform(100.0, 300.0, 2), rng.uniform(0.0, 2.0 * math.pi, 2)
    a, b = (cmath.rect(s, t) for s, t in zip(size, angle, strict=True))
    return at_planes(a, b), tolerance(30.0), candidates, 4


CASES: dict[str, Callable[[int], Case]] = {
    "static": static_case,
    "two planes": two_plane_case,
    "few": few_case,
}
SEEDS = {"static": (0, 1, 2, 3), "two planes": (0, 1), "few": (0, 2, 3)}


def stored_optimum_g(case: str, seed: int) -> float:
    """Return the least metal of a case as it was found; infinite where no set reaches the aim."""
    value = json.loads(STORED.read_text(encoding="utf-8"))[case][str(seed)]
    return math.inf if value is None else float(value)


def slow_optimum_g(residual: Unbalance, judge: Tolerance, candidates: Candidates, most: int) -> float:
    """Try every set of up to ``most`` cuts that keep apart at any depth; the best exact plan's metal [g]."""
    near = {(pair.first, pair.second) for pair in candidates.apart}
    best = math.inf
    for size in range(1, most + 1):
        for few in itertools.combinations(range(len(candidates.cuts)), size):
            if any(pair in near for pair in itertools.combinations(few, 2)):
                continue
            if any(len(set(rule.members) & set(few)) > rule.most for rule in candidates.counts):
                continue
            cuts = [candidates.cuts[k] for k in few]
            bounds = np.array([c.least_depth_mm for c in cuts]), np.array([c.max_depth_mm for c in cuts])
            plan = plan_depths(
                residual, judge, cuts, bounds_mm=bounds, start_mm=0.5 * (bounds[0] + bounds[1])
            )
            if plan.share <= AIM_SHARE * (1.0 + 1e-6):
                best = min(
                    best, sum(-c.effect(float(d)).mass_g for c, d in zip(cuts, plan.depths_mm, strict=True))
                )
    return best


def main() -> None:
    """Find all optima and store them."""
    found: dict[str, dict[str, float | None]] = {}
    for name, seeds in SEEDS.items():
        for seed in seeds:
            value = slow_optimum_g(*CASES[name](seed))
            found.setdefault(name, {})[str(seed)] = value if math.isfinite(value) else None
    STORED.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
