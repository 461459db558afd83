"""A job's engine on its mounts: what inertia, gas and balance shafts do to it by factor, order by order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np

from autobalance.declare import ABSENT, HERTZ, LAST, NEWTONS, RPM, UNWRITTEN, Absent, derived
from autobalance.engines.mounts.rigid_body import moment_of_orders, rms
from autobalance.engines.mounts.spectra import (
    FramePlace,
    MeasuredOrder,
    Mounts,
    Shaken,
    StateOrders,
    measured_orders,
    state_orders,
)
from autobalance.running_gear.loads import loads, whole_turn
from autobalance.running_gear.roll import highest_order, momentum_roll_orders
from autobalance.running_gear.shafts import BalanceShaft, orders_with_shafts, roll_of_order
from autobalance.running_gear.whole_engine import Engine
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

ANGLES = 720
FACTOR_SEARCH_RANGE = (-0.5, 1.5)
"""Factors between which the best is looked for: beyond 0 and 1 the crank is under- or overbalanced."""
STEPS = 201
SHAPE_UNKNOWNS = ("x_mm", "y_mm", "z_mm", "about_x_rad", "about_y_rad", "about_z_rad")
Torque = Callable[[float], Mapping[float, complex]]
"""Speed [rad/s] → order → torque that drives the crank, T cos(nθ + φ) as T exp(iφ) [N·m]."""
Pulls = Callable[[float], Mapping[float, tuple[Complex, Complex]]]
"""Speed [rad/s] → order → force (2,) of drives on the block [N] and its moment Σ z F (2,) [N·m]."""


def no_pulls(speed_rad_s: float) -> Mapping[float, tuple[Complex, Complex]]:
    """Return the orders of the pull of no drive."""
    return {}


@dataclass(frozen=True, eq=False)
class PlaceResponse:
    """Motion of a place over the speeds, RMS of all orders: velocity [mm/s], displacement [mm], (k,) each."""

    name: str
    velocity_rms_mm_s: Array
    displacement_rms_mm: Array


@dataclass(frozen=True, eq=False)
class MountedResponse:
    """Response with one balance factor: places, and the RMS force (k,) of each mount on the frame [N]."""

    factor: float
    places: tuple[PlaceResponse, ...]
    mount_force_rms_n: Annotated[tuple[Array, ...], NEWTONS]


@dataclass(frozen=True, eq=False)
class AsTheFileIs:
    """Response with the crank as its file has it; its balance factor is None if its throws have several."""

    balance_factor: float | None
    places: tuple[PlaceResponse, ...]
    mount_force_rms_n: Annotated[tuple[Array, ...], NEWTONS]


@dataclass(frozen=True, eq=False)
class Present:
    """The engine as its file has it, its balance factor, the job's factor and the job's folder."""

    engine: Engine
    own_factor: float | None
    factor: float
    folder: Path


@dataclass(frozen=True, eq=False)
class MountedAnalysis:
    """Natural frequencies and shapes, responses by factor, and the best factor for each named place.

    That is the one of the least largest velocity. ``shape_unknowns`` name the motion of the centre of mass
    in each of ``shapes``. ``as_the_file_is``, ``orders``: of the present crank; orders balanced too.
    """

    mounts: Annotated[Mounts, UNWRITTEN]
    responses: Annotated[tuple[MountedResponse, ...], LAST]
    best_factor_for: Annotated[Mapping[str, float], LAST]
    as_the_file_is: Annotated[AsTheFileIs | Absent, LAST] = ABSENT
    orders: Annotated[tuple[StateOrders, ...], LAST] = ()
    measured: Annotated[tuple[MeasuredOrder, ...], LAST] = ()

    @derived
    def natural_frequencies_rad_s(self) -> Annotated[Array, HERTZ]:
        return self.mounts.engine.modes()[0]

    @derived
    def shape_unknowns(self) -> tuple[str, ...]:
        return SHAPE_UNKNOWNS

    @derived
    def shapes(self) -> tuple[Array, ...]:
        return tuple(self.mounts.engine.modes()[1].T)

    @derived
    def speeds_rad_s(self) -> Annotated[Array, RPM]:
        return self.mounts.speeds_rad_s


def inertia_torque(engine: Engine) -> Torque:
    """Return the torque of rods and pistons on the crank by order, without gas."""
    angle = whole_turn(ANGLES)
    torque = loads(Engine(engine.cylinders), (0.0, 1.0), 1.0, angle).torque_n_m
    spectrum = -np.fft.rfft(torque) * (2.0 / ANGLES)
    highest = highest_order(engine)

    def at(speed: float) -> Mapping[float, complex]:
        return {float(n): complex(spectrum[n]) * speed**2 for n in range(1, highest + 1)}

    return at


def analysed(
    mounts: Mounts,
    at_factor: Callable[[float], Engine],
    torque: Torque,
    factors: Sequence[float],
    shafts: Sequence[BalanceShaft] = (),
    pulls: Pulls = no_pulls,
    present: Present | None = None,
) -> MountedAnalysis:
    """Return the response of an engine on its mounts for balance factors.

    Forces are linear in the factor, so any factor follows from those of 0 and 1. ``shafts`` turn as the
    engine of ``at_factor`` does: mirrored where it is. ``pulls`` are in the frame of the mounts.
    ``present``: the engine as its file has it, and what its orders are compared with.
    """
    ends = [_shaken(mounts, at_factor(factor), torque, shafts, pulls) for factor in (0.0, 1.0)]

    def motions(factor: float) -> dict[float, Shaken]:
        return {order: ends[0][order].between(ends[1][order], factor) for order in ends[0]}

    tried = np.linspace(*FACTOR_SEARCH_RANGE, STEPS)
    best = {}
    for name, place in mounts.points:
        worst = [float(_velocity(mounts, motions(float(f)), place).max()) for f in tried]
        best[name] = float(tried[int(np.argmin(worst))])
    responses = tuple(_response(mounts, factor, motions(factor)) for factor in factors)
    if present is None:
        return MountedAnalysis(mounts, responses, best)

    def as_file(at: Mounts) -> dict[float, Shaken]:
        return _shaken(at, present.engine, torque, shafts, pulls)

    def balanced(at: Mounts) -> dict[float, Shaken]:
        return _shaken(at, at_factor(present.factor), torque, shafts, pulls)

    now = as_file(mounts)
    return MountedAnalysis(
        mounts,
        responses,
        best,
        AsTheFileIs(present.own_factor, *_places_and_forces(mounts, now)),
        (
            state_orders(mounts, now, "as the file is", present.own_factor),
            state_orders(mounts, motions(present.factor), "balanced", present.factor),
        ),
        measured_orders(mounts, present.folder, (as_file, balanced)),
    )


def _shaken(
    mounts: Mounts, engine: Engine, torque: Torque, shafts: Sequence[BalanceShaft], pulls: Pulls
) -> dict[float, Shaken]:
    """Return the centre's motion and the force that shakes it by order over the speeds."""
    speeds = mounts.speeds_rad_s
    highest = max([highest_order(engine), *(each.order for each in shafts)])
    by_order = {each.order: each for each in orders_with_shafts(engine.orders(1.0, highest), shafts, 1.0)}
    momentum = momentum_roll_orders(engine, highest)
    torques = [torque(float(speed)) for speed in speeds]
    pulled = [pulls(float(speed)) for speed in speeds]
    none = np.zeros(2, dtype=np.complex128)
    side = -1.0 if engine.clockwise else 1.0
    mirror = np.array([1.0, side])
    motions = {}
    for number in sorted({*by_order, *(each for row in (*torques, *pulled) for each in row)}):
        square = speeds[:, None] ** 2
        force = np.zeros((len(speeds), 3), dtype=np.complex128)
        moment = np.zeros((len(speeds), 2), dtype=np.complex128)
        # what drives the crank turns the engine the other way
        roll = np.array([-row.get(number, 0.0) for row in torques], dtype=np.complex128)
        if number in by_order:
            force[:, :2] = square * by_order[number].force_n * mirror / N_PER_G_MM_S2
            moment[:] = square * by_order[number].moment_n_m * mirror / N_M_PER_G_MM2_S2
            own = momentum[int(number)] if number.is_integer() else 0.0
            roll += speeds**2 * (own + roll_of_order(shafts, number))
        for row, at_speed in enumerate(pulled):
            of_drives = at_speed.get(number, (none, none))
            force[row, :2] += of_drives[0] / N_PER_G_MM_S2
            moment[row] += of_drives[1] / N_M_PER_G_MM2_S2
        turned = side * roll / N_M_PER_G_MM2_S2
        wrench = mounts.engine.wrench(force, moment_of_orders(moment, turned))
        motions[number] = Shaken(mounts.engine.response(number * speeds, wrench), force)
    return motions


def _velocity(mounts: Mounts, motions: Mapping[float, Shaken], place: Array | FramePlace) -> Array:
    rows = mounts.moves(place)
    speeds = mounts.speeds_rad_s[:, None]
    return rms([order * speeds * (each.motion @ rows.T) for order, each in motions.items()])


def _response(mounts: Mounts, factor: float, motions: Mapping[float, Shaken]) -> MountedResponse:
    return MountedResponse(factor, *_places_and_forces(mounts, motions))


def _places_and_forces(
    mounts: Mounts, motions: Mapping[float, Shaken]
) -> tuple[tuple[PlaceResponse, ...], tuple[Array, ...]]:
    places: list[tuple[str, Array | FramePlace]] = [("centre", mounts.engine.centre_mm)]
    places += [(f"mount {n}", each.at_mm) for n, each in enumerate(mounts.engine.mounts, 1)]
    forces = []
    for place, mount in enumerate(mounts.engine.mounts):
        rows = mounts.engine.stretches(place)
        pushes = [
            mount.spring_g_s2(order * mounts.speeds_rad_s) * (each.motion @ rows.T)
            for order, each in motions.items()
        ]
        forces.append(rms(pushes) * N_PER_G_MM_S2)
    return (
        tuple(
            PlaceResponse(
                name,
                _velocity(mounts, motions, place),
                rms([each.motion @ mounts.moves(place).T for each in motions.values()]),
            )
            for name, place in (*places, *mounts.points)
        ),
        tuple(forces),
    )
