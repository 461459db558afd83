"""The axis of exactly drawn journals is exact, though the rims of their oil holes lie on chords."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import preset
from tests.generated import drawn


@pytest.mark.parametrize("segments", [48, 128])
def test_the_rim_of_an_oil_hole_moves_no_axis(segments: int) -> None:
    """Its vertices lie 0.0045 mm inside the journal; the axis was 0.19 µm off, 0.34 g·mm of a single."""
    found = recognise(drawn(preset("single"), segments), Overrides())
    direction, point = found.rotor_to_file[:3, 2], found.rotor_to_file[:3, 3]
    assert np.abs(direction[:2]).max() < 1e-8
    assert np.abs(point[:2]).max() < 1e-6
