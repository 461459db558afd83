"""Keys of a job for ``torsion``: speeds, torques, gears, branches, couplings, dampers. SI units out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from autobalance.crank_dynamics.torsion.model import (
    Branch,
    Coupling,
    CrankTorsion,
    Damper,
    DamperKind,
    Driven,
    Excitation,
    Formula,
    PendulumAbsorber,
    SpeedRamp,
    TorsionQuestion,
    TrainParts,
)
from autobalance.crank_dynamics.torsion.train import GearPair
from autobalance.declare import ANY, COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key, Large, Range, Values
from autobalance.errors import JobError
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.toml_files.keys import read
from autobalance.types import Array
from autobalance.units import KG_M2_PER_KG_MM2, KG_PER_G, M_PER_MM, MPA_PER_GPA, RAD_S_PER_RPM

# Keys of gears, branches, couplings and dampers of a torsional train, and their values. SI units out.


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


# Keys of a job for ``torsion``: speeds, torques, an absorber, the crank's own model. SI units out.


POINTS = Range("must be 2 to 100000", least=2, most=100000)
SPEEDS = (
    Key(
        "speed_rpm",
        float | tuple[float, float],
        "a speed, or the lowest and highest",
        POSITIVE,
        (500.0, 6000.0),
    ),
    Key("points", int, "speeds in a range", POINTS, 101),
)
EXCITATION = (
    Key("station", int, "number of the inertia, from 1", COUNTED),
    Key("order", float, "order of the speed", POSITIVE),
    Key("N_m", float, "peak torque", NOT_NEGATIVE),
    Key("phase_deg", float, "φ of N_m cos(order θ + φ)", ANY, 0.0),
)
PENDULUM = (
    Key("order", float, "order that it is tuned to", POSITIVE),
    Key("distance_mm", float, "distance from the crank axis to the pivot", POSITIVE),
    Key("mass_g", float, "mass", POSITIVE),
    Key(
        "station",
        int,
        "number of the inertia that carries it, from 1; default: listed, not in the response",
        COUNTED,
        None,
    ),
)
RUN_UP = (
    Key("from_rpm", float, "speed at the start", POSITIVE),
    Key("to_rpm", float, "speed at the end; a lower one runs down", POSITIVE),
    Key("ramp_rpm_s", float, "rate of the speed [rpm/s]", POSITIVE),
)
SHARED = (
    *SPEEDS,
    Key("excitation", says="torques at stations", keys=EXCITATION, many=True, default=()),
    Key("pendulum", says="an absorber in place", keys=PENDULUM, default=None),
    Key("run_up", says="vibration over time through a ramp of the speed", keys=RUN_UP, default=None),
    *TRAIN,
)
"""Keys of a chain's file that a job has too."""
DAMPING_RATIO = Key(
    "damping_ratio",
    float,
    "share of critical damping in every mode; default 0.01, and 0 where a damper is given",
    Range("must be 0 or more and below 1", least=0.0, below=1.0),
    None,
)
DRIVEN = (
    Key("name", str, "name of the inertia", ANY, ""),
    Key("kg_mm2", float, "polar moment of inertia", POSITIVE),
    Key("N_m_rad", Large, "stiffness of the shaft between it and the one before", POSITIVE),
    Key("shaft_damping_N_m_s_rad", float, "viscous, beside that shaft", NOT_NEGATIVE, 0.0),
    Key("damping_N_m_s_rad", float, "viscous, to ground", NOT_NEGATIVE, 0.0),
    Key("diameter_mm", float, "diameter of that shaft, for its stress", POSITIVE, None),
)
CRANK = (
    Key("stiffness", Formula, "formula that the results use", ANY, "ker_wilson"),
    Key("shear_modulus_gpa", float, "shear modulus", POSITIVE, 80.0),
    Key("flywheel_kg_mm2", float, "inertia at the last main; default that of [cycle]", NOT_NEGATIVE, 0.0),
    Key("damper_kg_mm2", float, "inertia at the first main", NOT_NEGATIVE, 0.0),
    Key("cylinder_damping_N_m_s_rad", float, "viscous, to ground, of each cylinder", NOT_NEGATIVE, 0.0),
    DAMPING_RATIO,
    Key("front", says="before the first main, outwards: a damper's ring", keys=DRIVEN, many=True, default=()),
    Key("train", says="behind the last main, outwards: a driven train", keys=DRIVEN, many=True, default=()),
    Key("fem", bool, "each throw's own metal by finite elements too", default=False),
    Key(
        "fem_size_mm", float, "largest edge of its last mesh; default some thousand elements", POSITIVE, None
    ),
)
OF_TORSION_ALONE = ("speed_rpm", "points", "excitation", "pendulum", "run_up")
OF_A_JOB = tuple(
    replace(key, verbs="torsion" if key.name in OF_TORSION_ALONE else "torsion, strength")
    for key in (*SHARED, Key("torsion", says="the crank's own model", keys=CRANK, default=FILLED))
)
"""Every key that a job adds."""


def _made(read: TablesRead) -> CrankTorsion:
    return torsion_of({key.name: read.values[key.name] for key in OF_A_JOB}, read.raw)


def _filled(_: AddonTables, __: TablesRead, torsion: CrankTorsion) -> Values:
    return torsion.filled


TABLES = AddonTables(OF_A_JOB, _made, needs=tuple(key.name for key in OF_A_JOB), filled=_filled)


def crank_torsion(raw: Mapping[str, Any]) -> CrankTorsion:
    """Return the tables of a job for ``torsion``, defaults filled in.

    Raises
    ------
    JobError
        If a key is unknown, missing, of the wrong type or impossible.
    """
    return torsion_of(read({key.name: raw[key.name] for key in OF_A_JOB if key.name in raw}, OF_A_JOB), raw)


def torsion_of(filled: Values, raw: Mapping[str, Any]) -> CrankTorsion:
    """Return the crank's torsion from the values of a job's tables; ``raw`` has its other flywheel.

    Raises
    ------
    JobError
        If they are impossible.
    """
    values = filled["torsion"]
    values["flywheel_kg_mm2"] = _flywheel_kg_mm2(raw, values["flywheel_kg_mm2"])
    return CrankTorsion(
        question_of(filled, None),
        values["stiffness"],
        values["shear_modulus_gpa"] * MPA_PER_GPA,
        values["flywheel_kg_mm2"] * KG_M2_PER_KG_MM2,
        values["damper_kg_mm2"] * KG_M2_PER_KG_MM2,
        values["cylinder_damping_N_m_s_rad"],
        _driven(values["front"], "front"),
        _driven(values["train"], "train"),
        values["fem"],
        values["fem_size_mm"],
        filled,
    )


def _flywheel_kg_mm2(raw: Mapping[str, Any], own: float) -> float:
    """Return the one flywheel of ``[torsion]`` and ``[cycle]``."""
    masses = [
        float(raw[table]["flywheel_kg_mm2"])
        for table in ("torsion", "cycle")
        if "flywheel_kg_mm2" in raw.get(table, {})
    ]
    if len(masses) == 2 and masses[0] != masses[1]:
        raise JobError(
            f"torsion.flywheel_kg_mm2 is {masses[0]:g} and cycle.flywheel_kg_mm2 {masses[1]:g}; expected one"
            " flywheel: leave one of them out"
        )
    return masses[0] if masses else own


def _driven(tables: list[Values], name: str) -> tuple[Driven, ...]:
    return tuple(
        Driven(
            each["name"] or f"{name} {number}",
            each["kg_mm2"] * KG_M2_PER_KG_MM2,
            each["N_m_rad"],
            each["shaft_damping_N_m_s_rad"],
            each["damping_N_m_s_rad"],
            None if each["diameter_mm"] is None else each["diameter_mm"] * M_PER_MM,
        )
        for number, each in enumerate(tables, 1)
    )


def question_of(filled: Values, stations: int | None) -> TorsionQuestion:
    """Return the questions about a chain of so many stations; None: not known yet."""
    excitations = []
    for number, each in enumerate(filled["excitation"], 1):
        check_station(f"excitation[{number}].station", each["station"], stations)
        torque = each["N_m"] * np.exp(1j * np.radians(each["phase_deg"]))
        excitations.append(Excitation(each["station"] - 1, each["order"], complex(torque)))
    return TorsionQuestion(
        _speeds(filled),
        tuple(excitations),
        _pendulum(filled["pendulum"], stations),
        train_parts(filled),
        filled["torsion"]["damping_ratio"],
        _run_up(filled["run_up"]),
    )


def check_station(place: str, station: int, stations: int | None) -> None:
    """Refuse a station (from 1) that a chain of so many does not have; None: not known yet.

    Raises
    ------
    JobError If it is not such a file.
    """
    if stations is not None and station > stations:
        raise JobError(f"{place} is {station}; there are {stations} stations")


def _speeds(filled: Values) -> Array:
    speed = filled["speed_rpm"]
    if not isinstance(speed, tuple):
        return np.array([speed * RAD_S_PER_RPM])
    if not speed[0] < speed[1]:
        raise JobError(f"speed_rpm is [{speed[0]:g}, {speed[1]:g}]; the first must be the lower one")
    return np.asarray(np.linspace(speed[0], speed[1], filled["points"]) * RAD_S_PER_RPM)


def _run_up(values: Values | None) -> SpeedRamp | None:
    if values is None:
        return None
    if values["from_rpm"] == values["to_rpm"]:
        raise JobError(f"run_up.to_rpm is {values['to_rpm']:g}, as from_rpm; enter another speed")
    return SpeedRamp(*(RAD_S_PER_RPM * values[key] for key in ("from_rpm", "to_rpm", "ramp_rpm_s")))


def _pendulum(values: Values | None, stations: int | None) -> PendulumAbsorber | None:
    if values is None:
        return None
    if values["station"] is not None:
        check_station("pendulum.station", values["station"], stations)
    return PendulumAbsorber(
        values["order"],
        values["distance_mm"] * M_PER_MM,
        values["mass_g"] * KG_PER_G,
        None if values["station"] is None else values["station"] - 1,
    )
