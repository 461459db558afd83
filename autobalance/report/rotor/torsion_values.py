"""Results of a torsional chain as JSON values: kg·mm², Hz, mrad, N·m, MPa."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.dynamics.torsion_chain import (
    TorsionChain,
    TorsionMode,
    TorsionResponse,
    holzer_table,
    shear_stress_pa,
)
from autobalance.dynamics.torsion_train import TorsionTrain
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.job.model.torsion import PendulumAbsorber
    from autobalance.machine_models.throw_twist import ThrowTwist
    from autobalance.machine_models.torsion_dampers import FittedDamper
    from autobalance.machine_models.torsion_excited import ExcitedTrain
    from autobalance.machine_models.torsion_from_job import CrankChain
    from autobalance.machine_models.torsion_trains import NamedTrain

Values = dict[str, Any]
KG_MM2_PER_KG_M2 = 1e6
PA_PER_MPA = 1e6
MRAD_PER_RAD = 1e3
TWO_PI = 2.0 * np.pi


def model_values(
    chain: TorsionTrain, names: Sequence[str], ker_wilson: Array | None = None, carter: Array | None = None
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


def train_values(named: NamedTrain) -> Values:
    """Return which stations the links join, speeds and values referred to station 1, gears and couplings."""
    train = named.train
    return {
        "links": [[int(a) + 1, int(b) + 1] for a, b in train.links],
        "ratios": [float(each) for each in train.ratios],
        "referred_inertias_kg_mm2": [
            float(each) for each in KG_MM2_PER_KG_M2 * train.referred_inertias_kg_m2
        ],
        "referred_stiffness_N_m_rad": [float(each) for each in train.referred_springs_n_m_rad],
        "gears": [
            {"stations": [g.first + 1, g.second + 1], "ratio": g.ratio, "mesh_N_m_rad": g.mesh_n_m_rad}
            for g in train.gears
        ],
        "couplings": [
            {"station": each.station + 1, "mean_N_m": each.mean_n_m, "N_m_rad": each.n_m_rad}
            for each in named.couplings
        ],
    }


def damping_values(model: ExcitedTrain) -> Values:
    """Return the damping ratio of every mode, and whether the file gives dampers."""
    return {"ratio": model.damping_ratio, "dampers": model.damped}


def pendulum_values(found: PendulumAbsorber | None) -> Values | None:
    """Return an absorber's length and inertia."""
    if found is None:
        return None
    return {"length_mm": 1e3 * found.length_m, "inertia_kg_mm2": 1e6 * found.inertia_kg_m2}


def damper_values(model: ExcitedTrain, fitted: FittedDamper) -> Values:
    """Return a damper as fitted, the rule for one inertia on one spring beside it, and its heat."""
    from autobalance.machine_models.torsion_dampers import heat_w

    damper, rule = fitted.damper, fitted.rule
    inertia, frequency = damper.inertia_kg_m2, fitted.frequency_rad_s
    return {
        "station": damper.station + 1,
        "kind": damper.kind,
        "inertia_kg_mm2": KG_MM2_PER_KG_M2 * inertia,
        "tuned": fitted.tuned,
        "N_m_rad": damper.n_m_rad,
        "N_m_s_rad": damper.n_m_s_rad,
        "greatest_twist_mrad": _mrad(fitted.with_rad),
        "greatest_twist_without_mrad": _mrad(fitted.without_rad),
        "rule": {
            "mass_ratio": rule.mass_ratio,
            "mode_hz": frequency / TWO_PI,
            "frequency_ratio": rule.frequency_ratio or None,
            "damping_ratio": rule.damping_ratio,
            "peak": rule.peak,
            "N_m_rad": rule.n_m_rad(inertia, frequency) or None,
            "N_m_s_rad": rule.n_m_s_rad(inertia, frequency),
        },
        "heat_W": [
            {"speed_rpm": float(speed) / RAD_S_PER_RPM, "heat_W": _finite(float(heat))}
            for speed, heat in zip(model.question.speeds_rad_s, heat_w(model, fitted), strict=True)
        ],
    }


def _mrad(value_rad: float | None) -> float | None:
    return None if value_rad is None else MRAD_PER_RAD * value_rad


def metal_values(
    made: CrankChain, twists: Sequence[ThrowTwist] | None, train: Callable[[TorsionChain], ExcitedTrain]
) -> Values:
    """Return the springs and frequencies that the throws' own metal gives; None where it is not known."""
    known = [each.stiffness for each in twists or () if each.stiffness is not None]
    if twists is None or len(known) < len(twists):
        return {"springs": None, "fem_natural_frequencies_hz": None}
    chain = made.with_throws([each.n_m_rad for each in known])
    return {
        "springs": [float(each) for each in chain.springs_n_m_rad],
        "fem_natural_frequencies_hz": [mode.frequency_rad_s / TWO_PI for mode in train(chain).modes()],
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


def mode_values(model: ExcitedTrain, modes: Iterable[TorsionMode]) -> list[Values]:
    """Return modes with Holzer's table at each, where the stations are a chain that hangs together.

    ``twist_mrad`` is the difference along each link for 1 mrad where the amplitude is greatest.
    """
    chain = model.chain if model.chain is not None and model.chain.rigid_modes == 1 else None
    return [
        {
            "frequency_hz": mode.frequency_rad_s / TWO_PI,
            "name": list(model.named.names),
            "shape": [float(each) for each in mode.shape],
            "twist_mrad": [float(each) for each in model.named.train.twists(mode.shape)],
            "nodes": mode.nodes,
            "holzer": None if chain is None else _holzer(chain, mode.frequency_rad_s),
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


def critical_values(model: ExcitedTrain, modes: Sequence[TorsionMode]) -> list[Values]:
    """Return the speeds in range at which an order meets a natural frequency, with the response."""
    speeds = model.question.speeds_rad_s
    low, high = float(speeds[0]), float(speeds[-1])
    met = [
        (mode.frequency_rad_s / order, order, number)
        for order in model.orders
        for number, mode in enumerate(modes)
        if low <= mode.frequency_rad_s / order <= high
    ]
    return [
        {
            "order": float(order),
            "frequency_hz": modes[number].frequency_rad_s / TWO_PI,
            "speed_rpm": speed / RAD_S_PER_RPM,
            "mode": number + 1,
            **_strains(model, order, speed),
            "phase_sum": model.phase_sum(order, modes[number].shape),
        }
        for speed, order, number in sorted(met)
    ]


def _strains(model: ExcitedTrain, order: float, speed_rad_s: float) -> Values:
    """Return the greatest torque and stress at a speed; None where nothing excites the order or damps it."""
    at = np.array([speed_rad_s])
    none: Values = {"torque_N_m": None, "stress_MPa": None}
    if not model.torque_at(order, at).any() or (model.damping_ratio == 0.0 and not model.damped):
        return none
    torques = np.abs(model.response(order, at).torques_n_m[0])
    if not torques.size or not np.isfinite(torques).all():
        return none
    stress = [each for each in _stress(torques, model.named.diameters_m) if each is not None]
    return {"torque_N_m": float(torques.max()), "stress_MPa": max(stress, default=None)}


def response_values(order: float, speeds_rad_s: Array, found: TorsionResponse, named: NamedTrain) -> Values:
    """Return the response to one order over the speeds; None where a speed has no steady response."""
    angles = MRAD_PER_RAD * np.abs(found.angles_rad)
    torques = np.abs(found.torques_n_m)
    first, last = named.train.links.T
    twists = MRAD_PER_RAD * np.abs(found.angles_rad[:, last] - found.angles_rad[:, first])
    return {
        "order": float(order),
        "points": [
            {
                "speed_rpm": float(speed) / RAD_S_PER_RPM,
                "angle_mrad": _known(angle),
                "torque_N_m": _known(torque),
                "twist_mrad": _known(twist),
                "stress_MPa": _stress(torque, named.diameters_m),
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
