"""Small linear programmes: as good as HiGHS finds, none where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from autobalance.planning.dual_simplex import least_cost

PROGRAMMES = 300


def test_costs_what_highs_finds() -> None:
    rng = np.random.default_rng(5)
    solved = 0
    for _ in range(PROGRAMMES):
        count, rows = int(rng.integers(1, 8)), int(rng.integers(1, 70))
        matrix, cost = rng.normal(size=(rows, count)), rng.normal(size=count)
        least = -rng.choice([0.0, 1.0], size=count)
        endless = (rng.uniform(size=count) < 0.3) & (cost > 0.0)
        greatest = np.where(endless, np.inf, rng.uniform(0.1, 5.0, size=count))
        inside = least + rng.uniform(size=count) * np.minimum(greatest - least, 1.0)
        most = matrix @ inside + rng.choice([-0.1, 0.0, 1.0]) * rng.uniform(size=rows)
        ends = [*zip(least.tolist(), greatest.tolist(), strict=True)]
        expected = linprog(cost, matrix, most, bounds=ends, method="highs")
        found = least_cost(cost, matrix, most, (least, greatest))
        assert (found is None) == (expected.x is None)
        if found is not None:
            solved += 1
            assert (matrix @ found <= most + 1e-9).all()
            assert ((found >= least) & (found <= greatest)).all()
            fewest = float(expected.fun or 0.0)
            assert abs(cost @ found - fewest) <= 1e-8 * (1.0 + abs(fewest))
    assert solved > PROGRAMMES // 2


def test_tells_nearly_equal_columns_apart_as_far_as_it_can() -> None:
    """Cuts that mirror each other but for rounding: dividing by their difference would hide the answer."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        count, rows = int(rng.integers(2, 7)), int(rng.integers(4, 60))
        half, price = rng.normal(size=(rows, count)), rng.uniform(0.0, 0.1, size=count)
        mirrored = half + 1e-9 * rng.normal(size=half.shape)
        matrix = np.hstack([half, mirrored, -np.ones((rows, 1))])
        cost = np.concatenate([price, price * (1.0 + 1e-9 * rng.normal(size=count)), [10.0]])
        most, greatest = rng.uniform(-30.0, 30.0, size=rows), np.append(np.full(2 * count, 3.0), np.inf)
        ends = [*zip(np.zeros(2 * count + 1).tolist(), greatest.tolist(), strict=True)]
        found = least_cost(cost, matrix, most, (np.zeros(2 * count + 1), greatest))
        fewest = float(linprog(cost, matrix, most, bounds=ends, method="highs").fun or 0.0)
        assert found is not None
        assert abs(cost @ found - fewest) <= 1e-8 * (1.0 + abs(fewest))


def test_refuses_an_endless_gain() -> None:
    bounds = np.zeros(1), np.array([np.inf])
    with pytest.raises(ArithmeticError, match="without end"):
        least_cost(np.array([-1.0]), np.array([[0.0]]), np.array([1.0]), bounds)
