"""Questions of a job or a chain's file about torsion, in SI units."""

from __future__ import annotations

import math
from dataclasses import field, replace
from typing import Any, Literal

import numpy as np

from autobalance.crank_dynamics.torsion.chain import TorsionChain
from autobalance.crank_dynamics.torsion.train import GearPair, TorsionTrain
from autobalance.errors import JobError
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Parts of a torsional train, and a chain with these parts as one train. SI units.


# Parts of a torsional train: gears, branches, couplings, dampers. SI units.


DamperKind = Literal["ring", "viscous"]


@dataclass(frozen=True, eq=False)
class Branch:
    """Stations on separate shafts; ``springs`` has one more if the first is connected to ``station``."""

    station: int
    names: tuple[str, ...]
    inertias_kg_m2: Array
    to_ground_n_m_s: Array
    springs_n_m_rad: Array
    across_n_m_s: Array
    diameters_m: tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class Coupling:
    """Static torque over twist of the shaft behind ``station`` (from 0); ``mean_n_m`` None: the cycle's."""

    station: int
    torque_n_m: Array
    twist_rad: Array
    mean_n_m: float | None
    friction_n_m: float = 0.0
    """Dry friction (hysteresis), which counts in a run-up alone."""

    def stiffness_n_m_rad(self, mean_n_m: float) -> float:
        """Return the slope of the characteristic at a mean torque; at a corner the mean of both slopes.

        A characteristic without negative torques holds for both directions; beyond its ends the last slope
        continues.

        Examples
        --------
        >>> two_stages = Coupling(0, np.array([0.0, 10.0, 110.0]), np.array([0.0, 0.1, 0.2]), None)
        >>> [round(two_stages.stiffness_n_m_rad(each)) for each in (-5.0, 10.0, 50.0, 999.0)]
        [100, 550, 1000, 1000]
        """
        torque = abs(mean_n_m) if self.torque_n_m[0] >= 0.0 else mean_n_m
        slopes = np.diff(self.torque_n_m) / np.diff(self.twist_rad)
        last = len(slopes) - 1
        beside = [
            slopes[min(max(int(np.searchsorted(self.torque_n_m, torque, side=side)) - 1, 0), last)]
            for side in ("left", "right")
        ]
        return float(0.5 * sum(beside))


@dataclass(frozen=True)
class Damper:
    """A ring on a station (from 0); ``n_m_rad`` and ``n_m_s_rad`` None where ``tune`` finds them."""

    station: int
    kind: DamperKind
    inertia_kg_m2: float
    n_m_rad: float | None
    n_m_s_rad: float | None
    tune: bool
    friction_n_m: float = 0.0
    """Dry friction between station and ring, which counts in a run-up alone."""


@dataclass(frozen=True, eq=False)
class TrainParts:
    """Gears, branches, couplings and dampers, with which a chain is a train."""

    gears: tuple[GearPair, ...] = ()
    branches: tuple[Branch, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    dampers: tuple[Damper, ...] = ()

    @property
    def plain(self) -> bool:
        """Whether the chain stays a chain."""
        return not (self.gears or self.branches or self.couplings or self.dampers)


# A chain with gears, branches, couplings and dampers becomes one train.


@dataclass(frozen=True)
class CouplingState:
    """The mean torque that a coupling (at ``station``, from 0) carries, its stiffness there, and its link."""

    station: int
    mean_n_m: float
    n_m_rad: float
    link: int


@dataclass(frozen=True, eq=False)
class NamedTrain:
    """A train with the names of its stations and the diameters along its links; and what to doubt of it."""

    train: TorsionTrain
    names: tuple[str, ...]
    diameters_m: tuple[float | None, ...]
    couplings: tuple[CouplingState, ...] = ()
    warnings: tuple[str, ...] = ()


def named_train(
    chain: TorsionChain,
    names: tuple[str, ...],
    diameters_m: tuple[float | None, ...],
    parts: TrainParts,
    mean_behind: tuple[int, float] | None = None,
) -> NamedTrain:
    """Return a chain with everything that makes it a train but dampers; branches' stations follow its own.

    Parameters
    ----------
    chain, names, diameters_m
        The chain that stations are counted on.
    parts : TrainParts
    mean_behind : (station from 0, torque) or None
        Mean torque that an engine gives from that station on [N·m], along the chain, by gears and into
        branches; it changes with the speed.

    Raises
    ------
    JobError
        If a station is missing, a shaft that is a coupling is missing, gears disagree.
    """
    train = NamedTrain(TorsionTrain.of_chain(chain), names, diameters_m)
    for number, branch in enumerate(parts.branches, 1):
        train = _with_branch(train, number, branch, parts)
    count = len(train.names)
    for number, gear in enumerate(parts.gears, 1):
        for station in (gear.first, gear.second):
            if station >= count:
                raise JobError(f"gear[{number}].stations has {station + 1}; there are {count} stations")
    train = replace(train, train=replace(train.train, gears=parts.gears))
    try:
        ratios = train.train.ratios
    except ValueError as error:
        raise JobError(f"gear: {error}") from None
    for number, coupling in enumerate(parts.couplings, 1):
        mean = coupling.mean_n_m
        if mean is None:
            mean = 0.0
            if mean_behind is not None and coupling.station < count:
                source, torque = mean_behind
                way = _way(train.train, source, coupling.station)
                if way:
                    mean = torque / abs(float(ratios[coupling.station] / ratios[source]))
                    train = _doubted(train, number, way)
        train = _with_coupling(train, number, coupling, mean)
    for number, damper in enumerate(parts.dampers, 1):
        if damper.station >= count:
            raise JobError(f"damper[{number}].station is {damper.station + 1}; there are {count} stations")
    return train


def _neighbours(train: TorsionTrain, station: int, source: int) -> set[int]:
    """Return the stations joined to one by a shaft or gears, those in front of ``source`` left out."""
    pairs = [(int(a), int(b)) for a, b in train.links] + [(g.first, g.second) for g in train.gears]
    both = {b for a, b in pairs if a == station} | {a for a, b in pairs if b == station}
    # the chain is numbered through: what is joined to the source from in front of it is the engine
    return {each for each in both if each >= source}


def _way(train: TorsionTrain, source: int, station: int) -> tuple[int, ...]:
    """Return the stations from where an engine gives its torque to a station behind it; empty: none."""
    waiting: list[tuple[int, ...]] = [(source,)]
    seen = {source}
    while waiting:
        way = waiting.pop(0)
        if way[-1] == station:
            return way
        for each in sorted(_neighbours(train, way[-1], source) - seen):
            seen.add(each)
            waiting.append((*way, each))
    return ()


def _doubted(so_far: NamedTrain, number: int, way: tuple[int, ...]) -> NamedTrain:
    """Return a train with a warning where its mean torque could go another way than to a coupling."""
    out = [int(b) for a, b in so_far.train.links if a == way[-1]][:1]
    ahead = [*way[1:], *out]
    forks = [
        here
        for before, here, after in zip((way[0], *way), way, ahead, strict=False)
        if _neighbours(so_far.train, here, way[0]) - {before, after}
    ]
    if not forks:
        return so_far
    text = (
        f"coupling[{number}] is taken to carry all of the engine's mean torque, but the train divides at"
        f" station {forks[0] + 1}; give coupling[{number}].mean_N_m"
    )
    return replace(so_far, warnings=(*so_far.warnings, text))


def _with_branch(so_far: NamedTrain, number: int, branch: Branch, parts: TrainParts) -> NamedTrain:
    train, first = so_far.train, len(so_far.names)
    if branch.station >= first:
        raise JobError(f"branch[{number}].from is {branch.station + 1}; there are {first} stations before it")
    stations = list(range(first, first + len(branch.names)))
    driven = any(gear.first in stations or gear.second in stations for gear in parts.gears)
    hanging = len(branch.springs_n_m_rad) == len(stations)
    if not hanging and not driven:
        raise JobError(
            f"branch[{number}] has no spring from station {branch.station + 1}, and no [[gear]] drives its"
            f" station {first + 1}: give one of both"
        )
    line = [branch.station, *stations] if hanging else stations
    links = np.array([line[:-1], line[1:]], dtype=np.int64).T.reshape(-1, 2)
    return NamedTrain(
        TorsionTrain(
            np.concatenate([train.inertias_kg_m2, branch.inertias_kg_m2]),
            np.concatenate([train.links, links]),
            np.concatenate([train.springs_n_m_rad, branch.springs_n_m_rad]),
            np.concatenate([train.to_ground_n_m_s, branch.to_ground_n_m_s]),
            np.concatenate([train.across_n_m_s, branch.across_n_m_s]),
        ),
        (*so_far.names, *branch.names),
        (*so_far.diameters_m, *branch.diameters_m),
    )


def _with_coupling(so_far: NamedTrain, number: int, coupling: Coupling, mean_n_m: float) -> NamedTrain:
    train = so_far.train
    at = np.flatnonzero(train.links[:, 0] == coupling.station)
    if not at.size:
        raise JobError(
            f"coupling[{number}].station is {coupling.station + 1}; no shaft leads from it to a next station"
        )
    springs = train.springs_n_m_rad.copy()
    springs[at[0]] = coupling.stiffness_n_m_rad(mean_n_m)
    state = CouplingState(coupling.station, mean_n_m, float(springs[at[0]]), int(at[0]))
    return replace(
        so_far, train=replace(train, springs_n_m_rad=springs), couplings=(*so_far.couplings, state)
    )


def with_damper(
    so_far: NamedTrain, number: int, damper: Damper, n_m_rad: float, n_m_s_rad: float
) -> NamedTrain:
    """Return a train with a ring on one of its stations: spring and viscous damper between both."""
    train, ring = so_far.train, len(so_far.names)
    grown = TorsionTrain(
        np.append(train.inertias_kg_m2, damper.inertia_kg_m2),
        np.concatenate([train.links, np.array([[damper.station, ring]], dtype=np.int64)]),
        np.append(train.springs_n_m_rad, n_m_rad),
        np.append(train.to_ground_n_m_s, 0.0),
        np.append(train.across_n_m_s, n_m_s_rad),
        train.gears,
    )
    name = f"damper {number}" if damper.kind == "ring" else f"viscous damper {number}"
    return replace(so_far, train=grown, names=(*so_far.names, name), diameters_m=(*so_far.diameters_m, None))


Formula = Literal["ker_wilson", "carter"]

USUAL_DAMPING_RATIO = 0.01
"""Damping of every mode if the file gives neither a ratio nor a damper, as bare crankshafts have it."""


@dataclass(frozen=True)
class Excitation:
    """A torque at a station (from 0), as a complex number T exp(iφ)."""

    station: int
    order: float
    torque_n_m: complex


@dataclass(frozen=True)
class SpeedRamp:
    """A ramp of the mean speed from one to the other at a rate [rad/s, rad/s²]."""

    from_rad_s: float
    to_rad_s: float
    rate_rad_s2: float

    @property
    def duration_s(self) -> float:
        return abs(self.to_rad_s - self.from_rad_s) / self.rate_rad_s2

    @property
    def acceleration_rad_s2(self) -> float:
        """Rate with its sign: negative of a run-down."""
        return math.copysign(self.rate_rad_s2, self.to_rad_s - self.from_rad_s)

    def speed(self, time_s: Array) -> Array:
        return np.asarray(self.from_rad_s + self.acceleration_rad_s2 * time_s)

    def phase(self, time_s: Array) -> Array:
        return np.asarray(self.from_rad_s * time_s + 0.5 * self.acceleration_rad_s2 * time_s**2)


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
    """Speeds, torques, absorber, parts of a train; ``damping_ratio`` None: as usual."""

    speeds_rad_s: Array
    excitations: tuple[Excitation, ...]
    pendulum: PendulumAbsorber | None
    parts: TrainParts = field(default_factory=TrainParts)
    damping_ratio: float | None = None
    run_up: SpeedRamp | None = None

    def ratio_of_modes(self, damped: bool) -> float:
        """Return the share of critical damping of every mode; ``damped``: dampers take up what swings."""
        if self.damping_ratio is not None:
            return self.damping_ratio
        return 0.0 if damped else USUAL_DAMPING_RATIO


@dataclass(frozen=True)
class Driven:
    """An inertia on a separate shaft, next to the crank or to another such inertia."""

    name: str
    inertia_kg_m2: float
    shaft_n_m_rad: float
    shaft_damping_n_m_s: float
    damping_n_m_s: float
    diameter_m: float | None


@dataclass(frozen=True, eq=False)
class CrankTorsion:
    """A job's keys on its crank's torsion."""

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
    filled: dict[str, Any]
