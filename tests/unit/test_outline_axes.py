"""The axes of an outline on an oblique face: a rotation of z to the face's normal, or refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.correction.faces.trace import axes_of_outline
from autobalance.errors import FormatError

LEAN = math.radians(20.0)
NORMAL = np.array([0.0, math.sin(LEAN), math.cos(LEAN)])
AXES = np.eye(4)
AXES[1:3, 1:3] = [[math.cos(LEAN), math.sin(LEAN)], [-math.sin(LEAN), math.cos(LEAN)]]


def test_a_rotation_to_the_normal_is_taken() -> None:
    assert np.array_equal(axes_of_outline({"outline_to_rotor": AXES.tolist()}, NORMAL), AXES)


@pytest.mark.parametrize(
    "false",
    [
        None,
        "axes",
        [[1.0]],
        np.eye(4).tolist(),
        (2.0 * AXES).tolist(),
        (AXES @ np.diag([-1, 1, 1, 1])).tolist(),
    ],
)
def test_what_is_no_such_rotation_is_refused(false: object) -> None:
    with pytest.raises(FormatError, match="outline_to_rotor"):
        axes_of_outline({"outline_to_rotor": false}, NORMAL)


def test_axes_that_lie_elsewhere_are_refused() -> None:
    moved = AXES.copy()
    moved[0, 3] = 1.0
    with pytest.raises(FormatError, match="outline_to_rotor"):
        axes_of_outline({"outline_to_rotor": moved.tolist()}, NORMAL)
