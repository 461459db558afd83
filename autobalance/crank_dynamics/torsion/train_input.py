"""Keys of gears, branches, couplings and dampers of a torsional train, and their values. SI units out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from autobalance.crank_dynamics.torsion.train import GearPair
from autobalance.crank_dynamics.torsion.train_model import Branch, Coupling, Damper, DamperKind, TrainParts
from autobalance.declare import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, Key, Large, Range, Values
from autobalance.errors import JobError
from autobalance.units import M_PER_MM

KG_M2_PER_KG_MM2 = 1e-6
NOT_ZERO = Range("must not be 0", apart=1e-6)

INERTIA = (
    Key("name", str, "name of the station", ANY, ""),
    Key("kg_mm2", float, "polar moment of inertia", POSITIVE),
    Key("damping_N_m_s_rad", float, "viscous, to ground", NOT_NEGATIVE, 0.0),
)
SPRING = (
    Key("N_m_rad", Large, "stiffness; 0 parts the chain", NOT_NEGATIVE),
    Key("damping_N_m_s_rad", float, "viscous, beside the spring", NOT_NEGATIVE, 0.0),
    Key("diameter_mm", float, "diameter of a round shaft, for its stress", POSITIVE, None),
)
GEAR = (
    Key("stations", tuple[int, int], "two stations, from 1, that mesh", COUNTED),
    Key("ratio", float, "speed of the second over that of the first; negative: it reverses", NOT_ZERO),
    Key("mesh_N_m_rad", Large, "stiffness of the teeth, at the first; default rigid", POSITIVE, None),
)
BRANCH = (
    Key("from", int, "station, from 1, where the branch begins", COUNTED),
    Key("inertia", says="stations of the branch in order", keys=INERTIA, many=True),
    Key(
        "spring",
        says="springs from that station to the first and on; one fewer if a [[gear]] drives the branch",
        keys=SPRING,
        many=True,
        default=(),
    ),
)
COUPLING = (
    Key("station", int, "the shaft from this station, from 1, to the next is the coupling", COUNTED),
    Key("torque_N_m", tuple[float, ...], "static torques, increasing", ANY),
    Key("twist_rad", tuple[float, ...], "twist at each torque, increasing", ANY),
    Key("mean_N_m", float, "torque it carries; default that of the job's cycle, else 0", ANY, None),
    Key("friction_N_m", float, "dry friction there too; counts in `[run_up]` alone", NOT_NEGATIVE, 0.0),
)
DAMPER = (
    Key("station", int, "number of the inertia that carries it, from 1", COUNTED),
    Key("kind", DamperKind, '"ring" on a spring, or "viscous" in oil'),
    Key("inertia_kg_mm2", float, "inertia of the ring", POSITIVE),
    Key("N_m_rad", Large, "stiffness of a ring's spring", POSITIVE, None),
    Key("N_m_s_rad", float, "viscous damping between station and ring", NOT_NEGATIVE, None),
    Key(
        "tune",
        bool,
        "find stiffness and damping that minimise the largest amplitude over speed_rpm",
        default=False,
    ),
    Key("friction_N_m", float, "dry friction there too; counts in `[run_up]` alone", NOT_NEGATIVE, 0.0),
)
TRAIN = (
    Key("gear", says="gears between stations", keys=GEAR, many=True, default=()),
    Key("branch", says="shafts that leave a station", keys=BRANCH, many=True, default=()),
    Key(
        "coupling",
        says="shafts whose stiffness follows their mean torque",
        keys=COUPLING,
        many=True,
        default=(),
    ),
    Key("damper", says="dampers on stations", keys=DAMPER, many=True, default=()),
)
"""Keys that chains and jobs share."""


def train_parts(filled: Values) -> TrainParts:
    """Return gears, branches, couplings and dampers of a file whose values are filled in.

    Raises
    ------
    JobError
        If one contradicts itself.
    """
    return TrainParts(
        tuple(_gear(number, each) for number, each in enumerate(filled["gear"], 1)),
        tuple(_branch(number, each) for number, each in enumerate(filled["branch"], 1)),
        tuple(_coupling(number, each) for number, each in enumerate(filled["coupling"], 1)),
        tuple(_damper(number, each) for number, each in enumerate(filled["damper"], 1)),
    )


def _gear(number: int, each: Values) -> GearPair:
    first, second = each["stations"]
    if first == second:
        raise JobError(f"gear[{number}].stations is [{first}, {second}]; expected two different stations")
    return GearPair(first - 1, second - 1, each["ratio"], each["mesh_N_m_rad"])


def _branch(number: int, each: Values) -> Branch:
    inertias, springs = each["inertia"], each["spring"]
    if len(springs) not in (len(inertias), len(inertias) - 1):
        raise JobError(
            f"branch[{number}] has {len(springs)} spring tables; {len(inertias)} inertias need"
            f" {len(inertias)}, or {len(inertias) - 1} where a [[gear]] drives the branch"
        )
    return Branch(
        each["from"] - 1,
        tuple(one["name"] or f"branch {number}.{n}" for n, one in enumerate(inertias, 1)),
        KG_M2_PER_KG_MM2 * np.array([one["kg_mm2"] for one in inertias]),
        np.array([one["damping_N_m_s_rad"] for one in inertias]),
        np.array([one["N_m_rad"] for one in springs]),
        np.array([one["damping_N_m_s_rad"] for one in springs]),
        tuple(None if one["diameter_mm"] is None else M_PER_MM * one["diameter_mm"] for one in springs),
    )


def _coupling(number: int, each: Values) -> Coupling:
    torque, twist = each["torque_N_m"], each["twist_rad"]
    place = f"coupling[{number}]"
    if len(torque) < 2 or len(torque) != len(twist):
        raise JobError(
            f"{place} has {len(torque)} torques and {len(twist)} twists; expected two of each or more"
        )
    for name, values in (("torque_N_m", torque), ("twist_rad", twist)):
        if not all(a < b for a, b in pairwise(values)):
            raise JobError(f"{place}.{name} is {list(values)}; expected increasing values")
    return Coupling(
        each["station"] - 1, np.array(torque), np.array(twist), each["mean_N_m"], each["friction_N_m"]
    )


def _damper(number: int, each: Values) -> Damper:
    place, stiffness, damping = f"damper[{number}]", each["N_m_rad"], each["N_m_s_rad"]
    if each["kind"] == "viscous" and stiffness is not None:
        raise JobError(f"{place}.N_m_rad is given; a viscous damper has no spring: leave it out")
    if each["tune"] and (stiffness is not None or damping is not None):
        raise JobError(f"{place}.tune finds stiffness and damping; leave N_m_rad and N_m_s_rad out")
    if not each["tune"] and damping is None:
        raise JobError(f"{place}.N_m_s_rad is missing; give it, or tune = true")
    if not each["tune"] and each["kind"] == "ring" and stiffness is None:
        raise JobError(f"{place}.N_m_rad is missing; give it, or tune = true")
    inertia = KG_M2_PER_KG_MM2 * each["inertia_kg_mm2"]
    return Damper(
        each["station"] - 1, each["kind"], inertia, stiffness, damping, each["tune"], each["friction_N_m"]
    )
