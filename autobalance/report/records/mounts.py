"""The engine on its mounts, as the report of `forces` has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalance.machine_models.mounted_engine import MountedAnalysis
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM

SHAPE_UNKNOWNS = ("x_mm", "y_mm", "z_mm", "about_x_rad", "about_y_rad", "about_z_rad")
"""Of each of ``shapes``, in this order: motion of the centre of mass."""


def mounts_values(analysis: MountedAnalysis) -> dict[str, Any]:
    """Return natural frequencies and shapes, responses by factor, the best factor for each named place."""
    frequencies, shapes = analysis.mounts.engine.modes()
    return {
        "natural_frequencies_hz": _numbers(frequencies / (2.0 * np.pi)),
        "shape_unknowns": list(SHAPE_UNKNOWNS),
        "shapes": [_numbers(shape) for shape in shapes.T],
        "speeds_rpm": _numbers(analysis.mounts.speeds_rad_s / RAD_S_PER_RPM),
        "responses": [
            {
                "factor": each.factor,
                "places": [
                    {
                        "name": place.name,
                        "velocity_rms_mm_s": _numbers(place.velocity_mm_s),
                        "displacement_rms_mm": _numbers(place.displacement_mm),
                    }
                    for place in each.places
                ],
                "mount_force_rms_N": [_numbers(force) for force in each.mount_forces_n],
            }
            for each in analysis.responses
        ],
        "best_factor_for": dict(analysis.best),
    }


def _numbers(values: Array | Sequence[float]) -> list[float]:
    return [float(each) for each in values]
