"""Read what ``torsion`` asks: a chain of its own, or the tables that a job adds for it. SI units out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from autobalance.dynamics.torsion_chain import TorsionChain
from autobalance.errors import JobError
from autobalance.job.toml.convert import Large
from autobalance.job.toml.keys import FILLED, Key, Values, read, read_document
from autobalance.job.toml.table import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, Rule
from autobalance.rigid_rotor.moments import Array
from autobalance.units import RAD_S_PER_RPM

Formula = Literal["ker_wilson", "carter"]
KG_M2_PER_KG_MM2 = 1e-6
M_PER_MM = 1e-3
KG_PER_G = 1e-3
MPA_PER_GPA = 1e3

POINTS = Rule(lambda x: 2 <= x <= 100000, "must be 2 to 100000")
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
    Key("station", int, "which inertia, from 1", COUNTED),
    Key("order", float, "of the speed", POSITIVE),
    Key("N_m", float, "peak torque", NOT_NEGATIVE),
    Key("phase_deg", float, "φ of N_m cos(order θ + φ)", ANY, 0.0),
)
PENDULUM = (
    Key("order", float, "that it is tuned to", POSITIVE),
    Key("distance_mm", float, "from the crank axis to its pivot", POSITIVE),
    Key("mass_g", float, "mass", POSITIVE),
    Key("station", int, "where it hangs, from 1; nowhere: told, not in the response", COUNTED, None),
)
SHARED = (
    *SPEEDS,
    Key("excitation", says="torques at stations", keys=EXCITATION, many=True, default=()),
    Key("pendulum", says="an absorber in place", keys=PENDULUM, default=None),
)
"""Keys of a chain's file and of a job alike."""
INERTIA = (
    Key("name", str, "what it is", ANY, ""),
    Key("kg_mm2", float, "polar moment of inertia", POSITIVE),
    Key("damping_N_m_s_rad", float, "viscous, to ground", NOT_NEGATIVE, 0.0),
)
SPRING = (
    Key("N_m_rad", Large, "stiffness; 0 parts the chain", NOT_NEGATIVE),
    Key("damping_N_m_s_rad", float, "viscous, beside the spring", NOT_NEGATIVE, 0.0),
    Key("diameter_mm", float, "of a round shaft, for its stress", POSITIVE, None),
)
CHAIN = (
    *SHARED,
    Key("inertia", says="stations in order", keys=INERTIA, many=True),
    Key("spring", says="between one station and the next", keys=SPRING, many=True, default=()),
)
"""Every key of a chain's file."""
DRIVEN = (
    Key("name", str, "what it is", ANY, ""),
    Key("kg_mm2", float, "polar moment of inertia", POSITIVE),
    Key("N_m_rad", Large, "of the shaft between it and the one before", POSITIVE),
    Key("shaft_damping_N_m_s_rad", float, "viscous, beside that shaft", NOT_NEGATIVE, 0.0),
    Key("damping_N_m_s_rad", float, "viscous, to ground", NOT_NEGATIVE, 0.0),
    Key("diameter_mm", float, "of that shaft, for its stress", POSITIVE, None),
)
CRANK = (
    Key("stiffness", Formula, "which formula the results use", ANY, "ker_wilson"),
    Key("shear_modulus_gpa", float, "shear modulus", POSITIVE, 80.0),
    Key("flywheel_kg_mm2", float, "inertia at the last main", NOT_NEGATIVE, 0.0),
    Key("damper_kg_mm2", float, "inertia at the first main", NOT_NEGATIVE, 0.0),
    Key("cylinder_damping_N_m_s_rad", float, "viscous, to ground, of each cylinder", NOT_NEGATIVE, 0.0),
    Key("front", says="before the first main, outwards: a damper's ring", keys=DRIVEN, many=True, default=()),
    Key("train", says="behind the last main, outwards: a driven train", keys=DRIVEN, many=True, default=()),
    Key("fem", bool, "each throw's own metal by finite elements too", default=False),
    Key(
        "fem_size_mm", float, "greatest edge of its last mesh; default some thousand elements", POSITIVE, None
    ),
)
OF_A_JOB = (*SHARED, Key("torsion", says="the crank's own model", keys=CRANK, default=FILLED))
"""Every key that a job adds."""


@dataclass(frozen=True)
class Excitation:
    """A torque at a station (from 0), as a complex number T exp(iφ)."""

    station: int
    order: float
    torque_n_m: complex


@dataclass(frozen=True)
class PendulumAbsorber:
    """A pendulum and the station (from 0) it hangs at, if any."""

    order: float
    distance_m: float
    mass_kg: float
    station: int | None

    @property
    def length_m(self) -> float:
        """R/n²: short enough to be tuned to the order at any speed."""
        return self.distance_m / self.order**2

    @property
    def inertia_kg_m2(self) -> float:
        """M (R + L)²."""
        return self.mass_kg * (self.distance_m + self.length_m) ** 2


@dataclass(frozen=True, eq=False)
class TorsionQuestion:
    """Speeds, torques and absorber."""

    speeds_rad_s: Array
    excitations: tuple[Excitation, ...]
    pendulum: PendulumAbsorber | None


@dataclass(frozen=True, eq=False)
class ChainFile:
    """A chain with what is asked about it; ``filled`` is the file as read, defaults filled in."""

    question: TorsionQuestion
    chain: TorsionChain
    names: tuple[str, ...]
    diameters_m: tuple[float | None, ...]
    filled: Values


@dataclass(frozen=True)
class Driven:
    """An inertia on a shaft of its own, next to the crank or to another such inertia."""

    name: str
    inertia_kg_m2: float
    shaft_n_m_rad: float
    shaft_damping_n_m_s: float
    damping_n_m_s: float
    diameter_m: float | None


@dataclass(frozen=True, eq=False)
class CrankTorsion:
    """What a job says about its crank's torsion."""

    question: TorsionQuestion
    formula: Formula
    shear_modulus_mpa: float
    flywheel_kg_m2: float
    damper_kg_m2: float
    cylinder_damping_n_m_s: float
    front: tuple[Driven, ...]
    train: tuple[Driven, ...]
    fem: bool
    fem_size_mm: float | None
    filled: Values


def read_chain(source: str | Path | Mapping[str, Any]) -> ChainFile:
    """Read a chain's file, or a dict of its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    return read_document(source, "torsion file", CHAIN, _chain)


def _chain(filled: Values) -> ChainFile:
    inertias, springs = filled["inertia"], filled["spring"]
    if len(springs) != len(inertias) - 1:
        raise JobError(
            f"[[spring]] stands {len(springs)} times; {len(inertias)} inertias need {len(inertias) - 1}"
        )
    chain = TorsionChain(
        KG_M2_PER_KG_MM2 * np.array([each["kg_mm2"] for each in inertias]),
        np.array([each["N_m_rad"] for each in springs]),
        np.array([each["damping_N_m_s_rad"] for each in inertias]),
        np.array([each["damping_N_m_s_rad"] for each in springs]),
    )
    diameters = tuple(None if d is None else M_PER_MM * d for d in (s["diameter_mm"] for s in springs))
    names = tuple(each["name"] or f"station {n}" for n, each in enumerate(inertias, 1))
    return ChainFile(_question(filled, len(inertias)), chain, names, diameters, filled)


def crank_torsion(raw: Mapping[str, Any]) -> CrankTorsion:
    """Return what the tables of a job say for ``torsion``, defaults filled in.

    Raises
    ------
    JobError
        If a key is unknown, missing, of the wrong type or impossible.
    """
    filled = read({key.name: raw[key.name] for key in OF_A_JOB if key.name in raw}, OF_A_JOB)
    asked = filled["torsion"]
    return CrankTorsion(
        _question(filled, None),
        asked["stiffness"],
        asked["shear_modulus_gpa"] * MPA_PER_GPA,
        asked["flywheel_kg_mm2"] * KG_M2_PER_KG_MM2,
        asked["damper_kg_mm2"] * KG_M2_PER_KG_MM2,
        asked["cylinder_damping_N_m_s_rad"],
        _driven(asked["front"], "front"),
        _driven(asked["train"], "train"),
        asked["fem"],
        asked["fem_size_mm"],
        filled,
    )


def _driven(found: list[Values], name: str) -> tuple[Driven, ...]:
    return tuple(
        Driven(
            each["name"] or f"{name} {number}",
            each["kg_mm2"] * KG_M2_PER_KG_MM2,
            each["N_m_rad"],
            each["shaft_damping_N_m_s_rad"],
            each["damping_N_m_s_rad"],
            None if each["diameter_mm"] is None else each["diameter_mm"] * M_PER_MM,
        )
        for number, each in enumerate(found, 1)
    )


def _question(filled: Values, stations: int | None) -> TorsionQuestion:
    excitations = []
    for number, each in enumerate(filled["excitation"], 1):
        check_station(f"excitation[{number}].station", each["station"], stations)
        torque = each["N_m"] * np.exp(1j * np.radians(each["phase_deg"]))
        excitations.append(Excitation(each["station"] - 1, each["order"], complex(torque)))
    return TorsionQuestion(_speeds(filled), tuple(excitations), _pendulum(filled["pendulum"], stations))


def check_station(place: str, station: int, stations: int | None) -> None:
    """Refuse a station (from 1) that a chain of so many does not have; None: not known yet.

    Raises
    ------
    JobError
        If it is none.
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


def _pendulum(found: Values | None, stations: int | None) -> PendulumAbsorber | None:
    if found is None:
        return None
    if found["station"] is not None:
        check_station("pendulum.station", found["station"], stations)
    return PendulumAbsorber(
        found["order"],
        found["distance_mm"] * M_PER_MM,
        found["mass_g"] * KG_PER_G,
        None if found["station"] is None else found["station"] - 1,
    )
