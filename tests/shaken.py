"""Plans whose last digits are off at random, as another processor's linear algebra leaves them.

``AUTOBALANCE_SHAKEN=7 pytest ...`` runs any tests on such plans, of seed 7; `shaken` does so for one test.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from zlib import crc32

import numpy as np
import pytest
from numpy.typing import NDArray

from autobalance.crank.anatomy import Anatomy
from autobalance.crank.recognition import recognise
from autobalance.planning import cut_curves, depths, enumeration, equal_cuts, milp_model, whole_cuts
from autobalance.planning.depths import Plan
from autobalance.types import Array

ULPS = 4
"""By how many of its last digits a number is off, at most."""
TURN_ULP = 2.0**-55
"""Last digit of a turn's small entries: what sums of numbers near 1 leave where nothing should be left."""
LEFT_OVER_MM = 1e-17
"""What a solver may leave of a cut that it does not make."""


@contextmanager
def shaken(seed: int) -> Iterator[None]:
    """Shake the frame, the cuts' effects as planners see them, every step of the depths, and the plans."""
    recognised = recognise._in_any_direction
    effect, step, plan = depths.resultant_and_moment, depths._tangent_step, whole_cuts._chosen_plan

    def by(values: Array, low: int, high: int) -> NDArray[np.int64]:
        """Return whole numbers that equal values get again: a processor errs in the same way each time."""
        return np.random.default_rng([seed, crc32(values.tobytes())]).integers(low, high + 1, values.shape)

    def off(values: Array) -> Array:
        return np.asarray(values + by(values, -ULPS, ULPS) * np.spacing(values))

    def off_effect(*args: Any) -> Array:
        return off(effect(*args))

    def off_step(here: Plan, tolerance: Any, cuts: Any, bounds: tuple[Array, Array], *rest: Any) -> Array:
        wanted = off(step(here, tolerance, cuts, bounds, *rest))
        if rest[0]:  # one depth for all
            wanted = np.full(len(wanted), wanted[0])
        return np.clip(wanted, *bounds)

    def off_plan(*args: Any) -> Plan:
        found = plan(*args)
        left = LEFT_OVER_MM * by(found.depths_mm, 0, 1)
        return replace(found, depths_mm=np.where(found.depths_mm == 0.0, left, off(found.depths_mm)))

    def off_frame(*args: Any) -> Anatomy:
        found = recognised(*args)
        frame, size = found.file_to_rotor.copy(), np.array([1.0, 1.0, 1.0, 1.0])
        size[3] = max(1.0, float(np.abs(frame[:3, 3]).max()))
        frame[:3] += by(frame[:3], -ULPS, ULPS) * TURN_ULP * size
        return replace(found, file_to_rotor=frame)

    changed: list[tuple[Any, str, Callable[..., Any]]] = [
        (recognise, "_in_any_direction", off_frame),
        (depths, "_tangent_step", off_step),
        (whole_cuts, "_chosen_plan", off_plan),
    ]
    for room in (depths, equal_cuts, cut_curves, cut_curves, enumeration, equal_cuts, milp_model):
        if "resultant_and_moment" in vars(room):
            changed.append((room, "resultant_and_moment", off_effect))
    with pytest.MonkeyPatch.context() as patch:
        for place, name, instead in changed:
            patch.setattr(place, name, instead)
        yield
