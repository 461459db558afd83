"""Results of a beam rotor as JSON values: mm, rpm, Hz, µm and degrees; None where a thing does not apply."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalance.dynamics.balancing_procedures import Advice
from autobalance.dynamics.beam_rotor import BeamRotor
from autobalance.dynamics.critical_speeds import CriticalSpeed
from autobalance.dynamics.rotor_preparation import PreparedRotor
from autobalance.dynamics.run_up import Motion
from autobalance.dynamics.unbalance_response import Orbits, Sag
from autobalance.dynamics.whirl_modes import WhirlMode
from autobalance.types import Array, Complex
from autobalance.units import RAD_S_PER_RPM

Values = dict[str, Any]
MM_PER_M = 1e3
UM_PER_M = 1e6
G_MM_PER_KG_M = 1e6
ORBIT = ("x_um", "x_phase_deg", "y_um", "y_phase_deg", "major_um", "minor_um")


def mm(z_m: float) -> float:
    """Return a place in mm, without the last digits that the way through metres left."""
    return round(MM_PER_M * float(z_m), 9)


def phase_deg(value: complex) -> float:
    """Return φ of A exp(iφ) in (−180, 180]; 0 of nothing."""
    if value == 0.0:
        return 0.0
    degrees = float(np.degrees(np.angle(value)))
    return 180.0 if degrees <= -180.0 else degrees


def mass_values(ready: PreparedRotor) -> Values:
    """Return mass, its centre, and how the rotor was divided."""
    mass, moment = ready.rotor.mass_and_moment()
    return {
        "mass_kg": mass,
        "centre_of_mass_mm": MM_PER_M * moment / mass,
        "elements": ready.elements,
        "rigid_body_modes": ready.reduced.rigid_body_modes,
    }


def critical_values(criticals: Sequence[CriticalSpeed]) -> Values:
    """Return critical speeds, bare and with whirl and decrement."""
    rows = [
        {
            "speed_rpm": each.speed_rad_s / RAD_S_PER_RPM,
            "whirl": each.whirl,
            "log_decrement": each.log_decrement,
        }
        for each in criticals
    ]
    return {"critical_speeds_rpm": [row["speed_rpm"] for row in rows], "criticals": rows}


def campbell_row(speed_rad_s: float, modes: Sequence[WhirlMode]) -> Values:
    """Return a speed with its modes, without shapes."""
    return {"speed_rpm": speed_rad_s / RAD_S_PER_RPM, "modes": [_mode(each) for each in modes]}


def _mode(mode: WhirlMode) -> Values:
    return {
        "frequency_hz": mode.frequency_rad_s / (2.0 * np.pi),
        "log_decrement": mode.log_decrement,
        "whirl": mode.whirl,
    }


def mode_values(ready: PreparedRotor, modes: Sequence[WhirlMode]) -> list[Values]:
    """Return modes with their shapes, the greatest amplitude 1 with phase 0."""
    return [{**_mode(each), "shape": _shape(ready, each.vector)} for each in modes]


def _shape(ready: PreparedRotor, vector: Complex) -> list[Values]:
    matrices = ready.matrices
    x, y = matrices.deflections(vector)
    both = np.concatenate([x, y])
    greatest = both[int(np.argmax(np.abs(both)))]
    if greatest != 0.0:
        x, y = x / greatest, y / greatest
    return [
        {
            "z_mm": mm(z),
            "x": float(abs(a)),
            "y": float(abs(b)),
            "x_phase_deg": phase_deg(complex(a)),
            "y_phase_deg": phase_deg(complex(b)),
        }
        for z, a, b in zip(matrices.shape_z_m, x, y, strict=True)
    ]


def response_values(probes_m: Sequence[float], orbits: Orbits) -> list[Values]:
    """Return the orbits at each probe over the speeds; None where a speed has no steady response."""
    major, minor = orbits.major_m, orbits.minor_m
    return [
        {
            "z_mm": mm(z),
            "points": [
                _orbit(float(speed), complex(x), complex(y), float(a), float(b))
                for speed, x, y, a, b in zip(
                    orbits.speeds_rad_s,
                    orbits.x_m[:, at],
                    orbits.y_m[:, at],
                    major[:, at],
                    minor[:, at],
                    strict=True,
                )
            ],
        }
        for at, z in enumerate(probes_m)
    ]


def _orbit(speed_rad_s: float, x: complex, y: complex, major: float, minor: float) -> Values:
    row: Values = {"speed_rpm": speed_rad_s / RAD_S_PER_RPM}
    if not np.isfinite([x, y]).all():
        return {
            **row,
            **dict.fromkeys(("x_um", "x_phase_deg", "y_um", "y_phase_deg", "major_um", "minor_um")),
        }
    return {
        **row,
        "x_um": UM_PER_M * abs(x),
        "x_phase_deg": phase_deg(x),
        "y_um": UM_PER_M * abs(y),
        "y_phase_deg": phase_deg(y),
        "major_um": UM_PER_M * major,
        "minor_um": UM_PER_M * minor,
    }


def sag_values(rotor: BeamRotor, found: Sag | None) -> Values:
    """Return deflection and the bearings' forces on the shaft under gravity; None where nothing holds it."""
    if found is None:
        reactions = [{"z_mm": mm(each.z_m), "x_N": None, "y_N": None} for each in rotor.bearings]
        return {"deflections": [], "reactions": reactions}
    return {
        "deflections": [
            {"z_mm": mm(z), "x_um": UM_PER_M * float(x), "y_um": UM_PER_M * float(y)}
            for z, (x, y) in zip(found.z_m, found.deflection_m, strict=True)
        ],
        "reactions": [
            {"z_mm": mm(each.z_m), "x_N": float(x), "y_N": float(y)}
            for each, (x, y) in zip(rotor.bearings, found.reactions_n, strict=True)
        ],
    }


def correction_values(planes_m: Sequence[float], added_kg_m: Complex) -> list[Values]:
    """Return the unbalance to add in each plane."""
    return [
        {"z_mm": mm(z), "g_mm": G_MM_PER_KG_M * float(abs(each)), "angle_deg": phase_deg(complex(each))}
        for z, each in zip(planes_m, added_kg_m, strict=True)
    ]


def advice_values(found: Advice) -> Values:
    """Return the balancing procedures that fit the service speed."""
    return {
        "behaviour": found.behaviour,
        "reason": found.reason,
        "planes": found.planes,
        "standard": "ISO 21940-12",
        "procedures": [
            {"letter": each.letter, "name": each.name, "low_speed": each.low_speed}
            for each in found.procedures
        ],
    }


def run_up_values(probes_m: Sequence[float], motion: Motion) -> list[Values]:
    """Return the motion of each probe while the speed changes, and its greatest."""
    speeds = motion.speed_rad_s / RAD_S_PER_RPM
    return [
        {
            "z_mm": mm(z),
            "greatest_um": UM_PER_M * float(motion.greatest_m[at]),
            "at_s": float(motion.greatest_at_s[at]),
            "at_rpm": float(np.interp(motion.greatest_at_s[at], motion.time_s, speeds)),
            "points": _points(motion.time_s, speeds, motion.x_m[:, at], motion.y_m[:, at]),
        }
        for at, z in enumerate(probes_m)
    ]


def _points(times: Array, speeds: Array, x_m: Array, y_m: Array) -> list[Values]:
    return [
        {"time_s": float(t), "speed_rpm": float(n), "x_um": UM_PER_M * float(x), "y_um": UM_PER_M * float(y)}
        for t, n, x, y in zip(times, speeds, x_m, y_m, strict=True)
    ]
