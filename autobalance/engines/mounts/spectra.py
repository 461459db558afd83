"""An engine on its mounts: its model, and what its forces shake, order by order."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.declare import NEWTONS
from autobalance.engines.mounts.rigid_body import FrameModes, MountedEngine, read_modes
from autobalance.errors import JobError, file_errors
from autobalance.types import Array, Complex
from autobalance.units import N_PER_G_MM_S2, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

# The engine on its mounts, from a job.


@dataclass(frozen=True)
class MeasuredSpectrum:
    """A report of ``orders`` of a point along an axis: its file as the job names it."""

    point: str
    axis: Literal["x", "y", "z"]
    file: str


@dataclass(frozen=True)
class FrameFile:
    """Modes of a frame: file, unit of length, damping of modes without, largest distance of nodes [mm]."""

    file: str
    unit: Literal["m", "mm"]
    damping_ratio: float
    within_mm: float


@dataclass(frozen=True, eq=False)
class FramePlace:
    """A place of the frame, by its modes' shapes (3, m) there."""

    shapes: Array


@dataclass(frozen=True, eq=False)
class Mounts:
    """The engine on its mounts, speeds (k,) [rad/s], and named places (3,) [mm]; ``on_frame`` names some."""

    engine: MountedEngine
    speeds_rad_s: Array
    points: tuple[tuple[str, Array | FramePlace], ...]
    measured: tuple[MeasuredSpectrum, ...] = ()
    frame: FrameFile | None = None
    on_frame: tuple[str, ...] = ()

    def moves(self, place: Array | FramePlace) -> Array:
        """Return the displacement (3, 6 + m) of a place of the engine, or of the frame, by the unknowns."""
        if isinstance(place, FramePlace):
            return self.engine.frame_moves(place.shapes)
        return self.engine.moves(place)

    def held_by_frame(self, folder: Path) -> Mounts:
        """Return the engine on its flexible frame, whose modes are read; this one without a frame.

        Raises
        ------
        JobError
            If the file has no modes, or no nodes at mounts and points of the frame.
        """
        if self.frame is None:
            return self
        modes = read_modes(folder / self.frame.file, self.frame.unit, self.frame.damping_ratio)
        within = self.frame.within_mm
        at = tuple(
            modes.at(each.at_mm, within, f"mount {number}")
            for number, each in enumerate(self.engine.mounts, 1)
        )
        points = tuple((name, self._on_frame(name, place, modes)) for name, place in self.points)
        engine = replace(self.engine, frame=modes, on_frame=at)
        return replace(self, engine=engine, points=points)

    def _on_frame(self, name: str, place: Array | FramePlace, modes: FrameModes) -> Array | FramePlace:
        """Return a point, by its node if it is on the frame."""
        if name not in self.on_frame or self.frame is None or isinstance(place, FramePlace):
            return place
        return FramePlace(modes.at(place, self.frame.within_mm, f"point {name!r}"))


# Motion of an engine on its mounts by order and axis over the speed, and what each mount lets through.
#
# The orders that `orders` measured at the same points are next to it: amplitudes of velocity or
# acceleration.


AXES: tuple[Literal["x", "y", "z"], ...] = ("x", "y", "z")
LEAST_SHARE = 1e-4
"""Share of the largest amplitude of a place below which an order along an axis is left out."""
M_S2_PER_MM_S2 = 1e-3
M_S2_PER_UNIT = {"g": 9.80665, "m/s2": 1.0, "m/s²": 1.0, "m/s^2": 1.0}
MM_S_PER_UNIT = {"mm/s": 1.0, "m/s": 1e3, "um/s": 1e-3, "µm/s": 1e-3}


@dataclass(frozen=True, eq=False)
class Shaken:
    """An order over the speeds: motion of the centre (k, 6), and the force that shakes the engine (k, 3).

    Linear in the balance factor, as ``motion`` and ``force_g_mm_s2`` are.
    """

    motion: Complex
    force_g_mm_s2: Complex

    def between(self, other: Shaken, factor: float) -> Shaken:
        """Return this order, of factor 0, moved on towards that of factor 1."""
        return Shaken(
            self.motion + factor * (other.motion - self.motion),
            self.force_g_mm_s2 + factor * (other.force_g_mm_s2 - self.force_g_mm_s2),
        )


@dataclass(frozen=True, eq=False)
class AxisOrder:
    """An order along an axis over the speeds (k,), peaks; the phase is the velocity's."""

    order: float
    axis: Literal["x", "y", "z"]
    velocity_mm_s: Array
    phase_deg: Array
    acceleration_m_s2: Array


@dataclass(frozen=True, eq=False)
class PlaceOrders:
    """Orders of a place that move it, by order and axis."""

    name: str
    orders: tuple[AxisOrder, ...]


@dataclass(frozen=True, eq=False)
class MountOrder:
    """An order of a mount's force on the frame over the speeds (k,), peak of its three components together.

    ``transmissibility``: over the force of that order that shakes the engine; None if only couples do.
    """

    order: float
    force_n: Annotated[Array, NEWTONS]
    transmissibility: Array | None


@dataclass(frozen=True, eq=False)
class MountOrders:
    """Orders of a mount's force on the frame."""

    number: int
    orders: tuple[MountOrder, ...]


@dataclass(frozen=True, eq=False)
class StateOrders:
    """Motion of places and forces of mounts by order, of the crank as the file has it or balanced."""

    name: str
    balance_factor: float | None
    places: tuple[PlaceOrders, ...]
    mounts: tuple[MountOrders, ...]


@dataclass(frozen=True)
class MeasuredOrder:
    """A measured order of a point beside the computed ones, at the record's speed; in ``unit``, peak."""

    point: str
    axis: Literal["x", "y", "z"]
    order: float
    speed_rpm: float
    unit: Literal["mm/s", "m/s²"]
    measured: float
    as_the_file_is: float | None
    balanced: float | None

    @property
    def acceleration_m_s2(self) -> float:
        """The measured peak as an acceleration [m/s²]."""
        if self.unit == "m/s²":
            return self.measured
        return self.measured * self.order * self.speed_rpm * RAD_S_PER_RPM * M_S2_PER_MM_S2


def state_orders(
    mounts: Mounts, shaken: Mapping[float, Shaken], name: str, factor: float | None
) -> StateOrders:
    """Return the orders of all places and mounts of a state."""
    held = mounts.engine.mounts
    places: list[tuple[str, Array | FramePlace]] = [("centre", mounts.engine.centre_mm)]
    places += [(f"mount {n}", each.at_mm) for n, each in enumerate(held, 1)]
    return StateOrders(
        name,
        factor,
        tuple(PlaceOrders(each, _axis_orders(mounts, shaken, at)) for each, at in (*places, *mounts.points)),
        tuple(MountOrders(n, _mount_orders(mounts, shaken, n - 1)) for n in range(1, len(held) + 1)),
    )


def _axis_orders(
    mounts: Mounts, shaken: Mapping[float, Shaken], at: Array | FramePlace
) -> tuple[AxisOrder, ...]:
    rows, speeds = mounts.moves(at), mounts.speeds_rad_s[:, None]
    velocities = {order: 1j * order * speeds * (each.motion @ rows.T) for order, each in shaken.items()}
    greatest = max((float(np.abs(each).max()) for each in velocities.values()), default=0.0)
    found = []
    for order, velocity in velocities.items():
        for axis, along in zip(AXES, velocity.T, strict=True):
            size = np.abs(along)
            if size.max() > LEAST_SHARE * greatest:
                acceleration = size * order * mounts.speeds_rad_s * M_S2_PER_MM_S2
                found.append(AxisOrder(order, axis, size, np.degrees(np.angle(along)), acceleration))
    return tuple(found)


def _mount_orders(mounts: Mounts, shaken: Mapping[float, Shaken], place: int) -> tuple[MountOrder, ...]:
    mount = mounts.engine.mounts[place]
    rows = mounts.engine.stretches(place)
    found = []
    sizes = {
        order: np.linalg.norm(
            np.abs(mount.spring_g_s2(order * mounts.speeds_rad_s) * (each.motion @ rows.T)), axis=1
        )
        for order, each in shaken.items()
    }
    greatest = max((float(each.max()) for each in sizes.values()), default=0.0)
    pushes = {order: np.linalg.norm(np.abs(each.force_g_mm_s2), axis=1) for order, each in shaken.items()}
    strongest = max((float(each.max()) for each in pushes.values()), default=0.0)
    for order, size in sizes.items():
        if size.max() <= LEAST_SHARE * greatest:
            continue
        push = pushes[order]
        through = size / push if push.min() > LEAST_SHARE**2 * strongest else None
        found.append(MountOrder(order, size * N_PER_G_MM_S2, through))
    return tuple(found)


def measured_orders(
    mounts: Mounts,
    folder: Path,
    states: Sequence[Callable[[Mounts], Mapping[float, Shaken]]],
) -> tuple[MeasuredOrder, ...]:
    """Return measured orders of points beside the computed ones of both states, at each record's speed.

    Raises
    ------
    JobError
        If a file is not a report of ``orders``, or has no speed or another unit.
    FileError
        If it cannot be read.
    """
    rows: list[MeasuredOrder] = []
    for measured in mounts.measured:
        report = _read(folder / measured.file)
        speed_rpm, unit = _speed_and_unit(report, measured)
        at_speed = replace(mounts, speeds_rad_s=np.array([speed_rpm * RAD_S_PER_RPM]))
        shaken = [state(at_speed) for state in states]
        (place,) = [at for name, at in mounts.points if name == measured.point]
        moves = mounts.moves(place)[AXES.index(measured.axis)]
        for row in report["orders"]:
            if row["amplitude"] is None:
                continue
            order, of_velocity = float(row["order"]), unit in MM_S_PER_UNIT
            rate = order * speed_rpm * RAD_S_PER_RPM
            scale = rate if of_velocity else rate**2 * M_S2_PER_MM_S2
            own = [
                scale * abs(complex(each[order].motion[0] @ moves)) if order in each else None
                for each in shaken
            ]
            amount = row["amplitude"] * (MM_S_PER_UNIT if of_velocity else M_S2_PER_UNIT)[unit]
            rows.append(
                MeasuredOrder(
                    measured.point,
                    measured.axis,
                    order,
                    speed_rpm,
                    "mm/s" if of_velocity else "m/s²",
                    float(amount),
                    *own,
                )
            )
    return tuple(rows)


def _read(path: Path) -> dict[str, Any]:
    with file_errors(f"read the measured orders {path.name}"):
        text = path.read_text(encoding="utf-8")
    try:
        report = json.loads(text)
    except ValueError:
        report = None
    if not isinstance(report, dict) or report.get("command") != "orders":
        raise JobError(f"{path.name} is not a report of orders; write one with autobalance orders --json")
    return report


def _speed_and_unit(report: dict[str, Any], measured: MeasuredSpectrum) -> tuple[float, str]:
    speed = report["speed"]["mean_rpm"]
    if speed is None:
        raise JobError(f"{measured.file} has no speed; give orders --speed-rpm or --tacho")
    channels = {each["name"]: each["unit"] for each in report["record"]["channels"]}
    unit = channels[report["channel"]]
    if unit not in M_S2_PER_UNIT and unit not in MM_S_PER_UNIT:
        known = ", ".join([*M_S2_PER_UNIT, *MM_S_PER_UNIT])
        raise JobError(f"{measured.file} has channel {report['channel']} in {unit}; must be one of {known}")
    return float(speed), str(unit)
