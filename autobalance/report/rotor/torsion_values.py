"""Results of a torsional chain as JSON values: kg·mm², Hz, mrad, N·m, MPa."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.dynamics.torsion_chain import (
    TorsionChain,
    TorsionMode,
    TorsionResponse,
    holzer_table,
    shear_stress_pa,
    torsion_modes,
)
from autobalance.rigid_rotor.moments import Array
from autobalance.units import RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.machine_models.throw_twist import ThrowTwist
    from autobalance.machine_models.torsion_from_job import CrankChain

Values = dict[str, Any]
KG_MM2_PER_KG_M2 = 1e6
PA_PER_MPA = 1e6
MRAD_PER_RAD = 1e3
TWO_PI = 2.0 * np.pi


def model_values(
    chain: TorsionChain, names: Sequence[str], ker_wilson: Array | None = None, carter: Array | None = None
) -> Values:
    """Return the chain; the formulas are those of a crank, None for a chain of its own."""
    return {
        "stations": list(names),
        "inertias_kg_mm2": [float(each) for each in KG_MM2_PER_KG_M2 * chain.inertias_kg_m2],
        "stiffness_N_m_rad": [float(each) for each in chain.springs_n_m_rad],
        "ker_wilson_N_m_rad": None if ker_wilson is None else [float(each) for each in ker_wilson],
        "carter_N_m_rad": None if carter is None else [float(each) for each in carter],
        "fem_N_m_rad": None,
    }


def metal_values(made: CrankChain, twists: Sequence[ThrowTwist] | None) -> Values:
    """Return the springs and frequencies that the throws' own metal gives; None where it is not known."""
    known = [each.stiffness for each in twists or () if each.stiffness is not None]
    if twists is None or len(known) < len(twists):
        return {"springs": None, "fem_natural_frequencies_hz": None}
    chain = made.with_throws([each.n_m_rad for each in known])
    return {
        "springs": [float(each) for each in chain.springs_n_m_rad],
        "fem_natural_frequencies_hz": [mode.frequency_rad_s / TWO_PI for mode in torsion_modes(chain)],
    }


def twist_values(twist: ThrowTwist | None) -> Values:
    """Return what finite elements said of a throw."""
    found = None if twist is None else twist.stiffness
    return {
        "fem_N_m_rad": None if found is None else found.n_m_rad,
        "fem_error_N_m_rad": None if found is None else found.error_n_m_rad,
        "fem_levels_N_m_rad": None if found is None else list(found.levels_n_m_rad),
        "fem_nodes": None if found is None else found.nodes,
        "fem_note": None if twist is None else twist.reason,
    }


def mode_values(chain: TorsionChain, modes: Iterable[TorsionMode]) -> list[Values]:
    """Return modes with Holzer's table at each, where the chain hangs together."""
    whole = chain.rigid_modes == 1
    return [
        {
            "frequency_hz": mode.frequency_rad_s / TWO_PI,
            "shape": [float(each) for each in mode.shape],
            "nodes": mode.nodes,
            "holzer": _holzer(chain, mode.frequency_rad_s) if whole else None,
        }
        for mode in modes
    ]


def _holzer(chain: TorsionChain, frequency_rad_s: float) -> list[Values]:
    return [
        {
            "inertia_kg_mm2": KG_MM2_PER_KG_M2 * row.inertia_kg_m2,
            "angle_rad": _finite(row.angle_rad),
            "inertia_torque_N_m": _finite(row.inertia_torque_n_m),
            "torque_N_m": _finite(row.torque_n_m),
            "twist_rad": _finite(row.twist_rad),
        }
        for row in holzer_table(chain, frequency_rad_s)
    ]


def _finite(value: float | None) -> float | None:
    """Return None for what grew over all numbers: behind a spring of nearly no stiffness."""
    return value if value is not None and math.isfinite(value) else None


def critical_values(
    modes: Iterable[TorsionMode], orders: Iterable[float], speeds_rad_s: Array
) -> list[Values]:
    """Return the speeds in range at which an order meets a natural frequency, ascending."""
    low, high = float(speeds_rad_s[0]), float(speeds_rad_s[-1])
    frequencies = [mode.frequency_rad_s for mode in modes]
    met = [(w / order, order, w) for order in orders for w in frequencies if low <= w / order <= high]
    return [
        {"order": float(order), "frequency_hz": w / TWO_PI, "speed_rpm": speed / RAD_S_PER_RPM}
        for speed, order, w in sorted(met)
    ]


def response_values(
    order: float, speeds_rad_s: Array, found: TorsionResponse, diameters_m: Sequence[float | None]
) -> Values:
    """Return the response to one order over the speeds; None where a speed has no steady response."""
    angles = MRAD_PER_RAD * np.abs(found.angles_rad)
    torques = np.abs(found.torques_n_m)
    twists = MRAD_PER_RAD * np.abs(np.diff(found.angles_rad, axis=1))
    return {
        "order": float(order),
        "points": [
            {
                "speed_rpm": float(speed) / RAD_S_PER_RPM,
                "angle_mrad": _known(angle),
                "torque_N_m": _known(torque),
                "twist_mrad": _known(twist),
                "stress_MPa": _stress(torque, diameters_m),
            }
            for speed, angle, torque, twist in zip(speeds_rad_s, angles, torques, twists, strict=True)
        ],
    }


def _known(values: Array) -> list[float | None]:
    return [float(each) if np.isfinite(each) else None for each in values]


def _stress(torques: Array, diameters_m: Sequence[float | None]) -> list[float | None]:
    return [
        None
        if outer is None or not np.isfinite(torque)
        else float(shear_stress_pa(torque, outer)) / PA_PER_MPA
        for torque, outer in zip(torques, diameters_m, strict=True)
    ]
