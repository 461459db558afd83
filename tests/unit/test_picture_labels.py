"""Labels of pictures: beside what they mark, none over another, all inside."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest

from autobalance.report.pictures.zbuffer import draw_labels, placed


@pytest.mark.parametrize("away", [0.0, 30.0])
def test_no_label_lies_over_another_and_all_are_inside(away: float) -> None:
    rng = np.random.default_rng(3)
    marks = [(float(x), float(y)) for x, y in rng.uniform(20.0, 380.0, (25, 2))]
    sizes = [(float(rng.uniform(20.0, 60.0)), 20.0) for _ in marks]
    found = placed(marks, sizes, (400.0, 400.0), away)
    boxes = []
    for label, (wide, high) in zip(found, sizes, strict=True):
        x, y = label.middle
        assert x - 0.5 * wide >= 0.0
        assert x + 0.5 * wide <= 400.0
        assert y - 0.5 * high >= 0.0
        assert y + 0.5 * high <= 400.0
        assert math.dist(label.mark, label.middle) >= away - 1e-9
        boxes.append((x - 0.5 * wide, y - 0.5 * high, x + 0.5 * wide, y + 0.5 * high))
    for one, two in combinations(boxes, 2):
        assert one[0] >= two[2] or two[0] >= one[2] or one[1] >= two[3] or two[1] >= one[3]


def test_a_label_alone_stands_on_its_mark() -> None:
    (label,) = placed([(50.0, 60.0)], [(20.0, 10.0)], (100.0, 100.0))
    assert label.middle == label.mark


def test_letters_of_any_script_are_drawn() -> None:
    blank = np.full((60, 200, 3), 128, dtype=np.uint8)
    drawn = draw_labels(blank, [("w2-A", 100, 30)])
    assert drawn.shape == blank.shape
    assert (drawn == 255).any()
    assert (drawn < 60).any()
