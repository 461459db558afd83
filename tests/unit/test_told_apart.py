"""Sentences with a found number and its limit never contradict themselves; statuses are words."""

from __future__ import annotations

import pytest

from autobalance.drawn_cranks.design import PRESETS
from autobalance.errors import JobError
from autobalance.solid.soundness.validate import _told_apart


@pytest.mark.parametrize("limit", [7.66e-5, 0.01, 3.3333333])
@pytest.mark.parametrize("above", [1.0001, 1.003, 1.04, 2.0])
def test_the_found_number_reads_as_above_its_limit(limit: float, above: float) -> None:
    found, most = _told_apart(above * limit, limit)
    assert float(found) > float(most)
    assert float(found) == pytest.approx(above * limit, rel=1e-2)
    assert float(most) == pytest.approx(limit, rel=5e-2)


def test_a_web_of_no_thickness_is_named() -> None:
    from dataclasses import replace

    split = PRESETS["v6-60"]
    with pytest.raises(JobError, match=r"web.between_pins_mm is 0; must be > 0"):
        replace(split, web=replace(split.web, between_pins_mm=0.0))
    single = PRESETS["single"]  # without a second crankpin between main journals there is none
    assert replace(single, web=replace(single.web, between_pins_mm=0.0)).web.between_pins_mm == 0.0
