"""Pull of the drives that take the engine's torque: chains, belts and gears on the crank.

A drive at the pitch radius R takes the torque M = share · T̄ + J_d θ̈: its share of the mean torque, and what
speeds up the inertia behind it with the uneven speed. A chain pulls with both strands towards the driven
shaft, F = |M|/(R cos α) · (1 + s)/(1 − s), s the slack strand's tension over the tight one's. Its sprocket is
a polygon whose lever R cos α rises and falls within ±π/N of each of N teeth, so that F has the order N. Gears
press with M/R against the rotation, and apart with tan of the pressure angle of it.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from autobalance.declare import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, SHARE, Key, Range, Values
from autobalance.engines.cycle.closed_part import hermite
from autobalance.engines.cycle.grid import CycleGrid
from autobalance.engines.cycle.speed import periodic_speed
from autobalance.errors import JobError
from autobalance.running_gear.loads import lever_shares
from autobalance.types import Array, Complex
from autobalance.units import G_MM2_PER_KG_MM2, N_M_PER_G_MM2_S2, N_M_PER_N_MM
from autobalance.value_classes import dataclass

Kind = Literal["chain", "belt", "gear"]
SLACK = Range("must be ≥ 0 and below 1", least=0.0, below=1.0)
ANGLE = Range("must be ≥ 0 and below 60", least=0.0, below=60.0)
ROUNDS = 20
"""Times that pull and friction of the mains, which each depend on the other, are found in turn."""

DRIVE = (
    Key("name", str, "name in reports", default=""),
    Key("kind", Kind, "kind of drive that takes the torque off the crank"),
    Key("z_mm", float, "place along the crank axis", ANY),
    Key("pitch_radius_mm", float, "pitch radius of the wheel on the crank", POSITIVE),
    Key(
        "direction_deg",
        float,
        "direction from the crank axis to the driven shaft in the engine's frame, counter-clockwise from x",
        ANY,
    ),
    Key("teeth", int, "teeth of the wheel on the crank: tooth order, polygon of a chain", COUNTED, None),
    Key("slack_share", float, "tension of the slack strand over the tight one; chain, belt", SLACK, 0.0),
    Key("pressure_angle_deg", float, "working pressure angle; gear", ANGLE, 20.0),
    Key("tooth_share", float, "amplitude at the tooth order over the mean pull; gear", NOT_NEGATIVE, 0.0),
    Key("torque_share", float, "share of the engine's mean torque that it takes", SHARE, 1.0),
    Key("torque_N_m", float, "constant torque that it takes, in place of a share", NOT_NEGATIVE, None,
        usual="`torque_share`"),
    Key("driven_inertia_kg_mm2", float, "inertia behind it, referred to the crank", NOT_NEGATIVE, 0.0),
    Key("inside", bool, "the driven shaft runs in the engine's own block, which takes the pull back",
        default=False),
)  # fmt: skip
"""Keys of a ``[[cycle.drive]]``."""


@dataclass(frozen=True)
class Drive:
    """A chain, belt or gear on the crank: lengths in mm, angles in rad, torque in N·m, inertia in g·mm²."""

    name: str
    kind: Kind
    z_mm: float
    pitch_radius_mm: float
    direction_rad: float
    teeth: int | None
    slack_share: float
    pressure_angle_rad: float
    tooth_share: float
    torque_share: float
    torque_n_m: float | None
    driven_inertia_g_mm2: float
    inside: bool

    def mean_torque_n_m(self, engine_n_m: float) -> float:
        """Return the mean torque that it takes of an engine's mean torque [N·m]."""
        return self.torque_share * engine_n_m if self.torque_n_m is None else self.torque_n_m

    def teeth_factor(self, angle_rad: Array) -> Array:
        """Return the pull over that at the pitch radius (n,) as teeth come in: roller 1 at crank angle 0."""
        if self.teeth is None:
            return np.ones_like(angle_rad)
        if self.kind != "chain":
            return 1.0 + self.tooth_share * np.cos(self.teeth * angle_rad)
        half = math.pi / self.teeth
        result: Array = 1.0 / np.cos(np.mod(angle_rad + half, 2.0 * half) - half)
        return result

    def unit_pull(self, torque_n_m: Array, *, clockwise: bool = False) -> Complex:
        """Return the force on the crank (n,), x + iy, of a torque with all teeth at the pitch radius [N]."""
        toward = cmath.exp(1j * (-self.direction_rad if clockwise else self.direction_rad))
        push = np.asarray(torque_n_m) / (self.pitch_radius_mm * N_M_PER_N_MM)
        if self.kind == "gear":
            apart = np.abs(push) * math.tan(self.pressure_angle_rad)
            return np.asarray(-(1j * push + apart) * toward, dtype=np.complex128)
        both = (1.0 + self.slack_share) / (1.0 - self.slack_share)
        strands: Complex = np.abs(push) * complex(both * toward)
        return strands


def drives_of(listed: Sequence[Values]) -> tuple[Drive, ...]:
    """Return the drives of ``[[cycle.drive]]``.

    Raises
    ------
    JobError
        If they take more torque than there is, or a chain has fewer than three teeth.
    """
    drives = []
    for place, each in enumerate(listed, 1):
        where = f"cycle.drive[{place}]"
        if each["kind"] == "chain" and each["teeth"] is not None and each["teeth"] < 3:
            raise JobError(f"{where}.teeth is {each['teeth']}; a chain's sprocket must have at least 3")
        if each["tooth_share"] and (each["kind"] == "chain" or each["teeth"] is None):
            why = "is the polygon's of a chain" if each["kind"] == "chain" else "needs teeth"
            raise JobError(f"{where}.tooth_share is given; the amplitude at the tooth order {why}")
        drives.append(
            Drive(
                each["name"] or f"{each['kind']} {place}",
                each["kind"],
                each["z_mm"],
                each["pitch_radius_mm"],
                math.radians(each["direction_deg"]),
                each["teeth"],
                each["slack_share"],
                math.radians(each["pressure_angle_deg"]),
                each["tooth_share"],
                each["torque_share"],
                each["torque_N_m"],
                each["driven_inertia_kg_mm2"] * G_MM2_PER_KG_MM2,
                each["inside"],
            )
        )
    shares = sum(each.torque_share for each in drives if each.torque_n_m is None)
    if shares > 1.0 + 1e-9:
        raise JobError(
            f"cycle.drive: the torque_share of all drives is {shares:g}; they must take at most 1 together"
        )
    return tuple(drives)


@dataclass(frozen=True, eq=False)
class DrivePulls:
    """Pulls of an engine's drives over the crank angle.

    Attributes
    ----------
    torque_n_m : (d, n) float
        That each drive takes of the crank [N·m].
    pull_n : (d, n) complex
        Force of each on the crank, x + iy, in the engine's frame as it is computed [N].
    mains_n : (m, n) complex
        What they do to the mains together [N].
    """

    torque_n_m: Array
    pull_n: Complex
    mains_n: Complex


@dataclass(frozen=True, eq=False)
class DrivenCrank:
    """A crank at the speed at which drives pull on it, without them, on the angles of its grid.

    Attributes
    ----------
    grid : CycleGrid
    speed_rad_s : float
    clockwise : bool
        Computed as its mirror image.
    mains_z_mm : tuple of float
        Increasing [mm].
    mains_n : (m, n) complex
        Loads of the mains, x + iy [N].
    main_lever_m : (m,) float
        Friction torque of each main over its load [m].
    torque_n_m : (n,) float
        Of all that drives the crank and has a work by angle: gas, weight, friction of pistons [N·m].
    mean_n_m : float
        Mean torque that all friction but that of the mains leaves [N·m].
    inertia_g_mm2 : (n,) float
        Of all that turns with the crank, what is behind the drives too [g·mm²].
    half_slope_n_m : (n,) float
        Half its slope by the crank angle, the torque of rods and pistons at 1 rad/s [N·m].
    """

    grid: CycleGrid
    speed_rad_s: float
    clockwise: bool
    mains_z_mm: tuple[float, ...]
    mains_n: Complex
    main_lever_m: Array
    torque_n_m: Array
    mean_n_m: float
    inertia_g_mm2: Array
    half_slope_n_m: Array


def drive_pulls(drives: Sequence[Drive], crank: DrivenCrank) -> DrivePulls:
    """Return the pulls of drives on a crank.

    Friction of the mains takes off what drives are left, and their pulls load the mains: both are found in
    turn, until the torque repeats to 1e-13.

    References
    ----------
    Ruckle 2014, Sec. 1.3.6 (after Foale 2007): the varying torque ends as a pulsating chain force and as
    pulsating loads on the engine mountings.
    """
    grid, lever = crank.grid, crank.main_lever_m
    swing = _acceleration_rad_s2(drives, crank) * N_M_PER_G_MM2_S2
    shares = np.stack([lever_shares(each.z_mm, crank.mains_z_mm) for each in drives])
    teeth = np.stack([each.teeth_factor(grid.angle_rad) for each in drives])

    def found(engine_n_m: float) -> DrivePulls:
        torques = np.stack(
            [each.mean_torque_n_m(engine_n_m) + each.driven_inertia_g_mm2 * swing for each in drives]
        )
        pulls = np.stack(
            [
                each.unit_pull(torque, clockwise=crank.clockwise)
                for each, torque in zip(drives, torques, strict=True)
            ]
        )
        at_teeth: Complex = pulls * teeth
        return DrivePulls(torques, at_teeth, shares.T @ at_teeth)

    mean = crank.mean_n_m - float(lever @ grid.mean(np.abs(crank.mains_n)))
    for _ in range(ROUNDS):
        last, pulls = mean, found(mean)
        mean = crank.mean_n_m - float(lever @ grid.mean(np.abs(crank.mains_n + pulls.mains_n)))
        if abs(mean - last) <= 1e-13 * abs(mean):
            break
    return found(mean)


def _acceleration_rad_s2(drives: Sequence[Drive], crank: DrivenCrank) -> Array:
    """Return θ̈ (n,) over the cycle under a constant load; zeros if nothing behind a drive needs it."""
    grid, driving, half_slope = crank.grid, crank.torque_n_m, crank.half_slope_n_m
    if not any(each.driven_inertia_g_mm2 for each in drives):
        return np.zeros(grid.angle_rad.shape)
    work = grid.work_to_even(driving)
    mean = float(work[-1]) / grid.span_rad
    inertia = crank.inertia_g_mm2 * N_M_PER_G_MM2_S2
    count = grid.even_rad.size
    uneven = periodic_speed(
        grid.even_rad, work[:-1] - mean * grid.even_rad, crank.inertia_g_mm2[:count], crank.speed_rad_s
    )
    if uneven is None:
        raise JobError(
            "cycle.drive.driven_inertia_kg_mm2 is given, but the crank would come to a stop within a cycle;"
            " give cycle.flywheel_kg_mm2"
        )
    square = uneven.speed_rad_s**2

    def acceleration(torque: Array, slope: Array, squared: Array, total: Array) -> Array:
        result: Array = (torque - mean - slope * squared) / total
        return result

    # the square of the speed lies on cubics between the even angles
    slope = 2.0 * acceleration(driving[:count], half_slope[:count], square, inertia[:count])
    ends = np.append(grid.even_rad, grid.span_rad)
    table = ends, np.append(square, square[0]), np.append(slope, slope[0])
    squared = hermite(grid.angle_rad, *table)
    return acceleration(driving, half_slope, squared, inertia)


PullOrders = Callable[[float], dict[float, tuple[Complex, Complex]]]
"""Speed [rad/s] → order → force (2,) [N] and its moment Σ z F (2,) [N·m], complex."""


def pull_orders(
    drives: Sequence[Drive],
    mean_torque_n_m: float,
    torque_at: Callable[[float], dict[float, complex]],
    inertia_g_mm2: float,
    *,
    clockwise: bool = False,
) -> PullOrders:
    """Return the orders of the pulls on the block, of drives whose driven shafts are outside of it.

    Parameters
    ----------
    drives : sequence of Drive
    mean_torque_n_m : float
        Of the engine [N·m].
    torque_at : callable
        Speed → order → torque on the crank [N·m]; θ̈ of an order is taken as that over the mean inertia.
    inertia_g_mm2 : float
        Mean of all that turns with the crank, what is behind the drives too [g·mm²].
    """
    outside = [each for each in drives if not each.inside]

    def orders(speed: float) -> dict[float, tuple[Complex, Complex]]:
        total: dict[float, tuple[Complex, Complex]] = {}

        def add(drive: Drive, order: float, amplitude: complex) -> None:
            mean = np.array([drive.mean_torque_n_m(mean_torque_n_m)])
            pull = complex(drive.unit_pull(mean, clockwise=clockwise)[0]) / float(mean[0])
            pull = pull.conjugate() if clockwise else pull
            force = np.array([pull.real, pull.imag]) * amplitude
            old = total.get(order, (np.zeros(2, dtype=complex), np.zeros(2, dtype=complex)))
            total[order] = old[0] + force, old[1] + force * drive.z_mm * N_M_PER_N_MM

        for drive in outside:
            mean = drive.mean_torque_n_m(mean_torque_n_m)
            if mean == 0.0:
                continue
            swung = drive.driven_inertia_g_mm2 / inertia_g_mm2
            if swung:
                for order, torque in torque_at(speed).items():
                    add(drive, order, swung * torque)
            for order, share in tooth_orders(drive).items():
                add(drive, order, share * mean)
        return total

    return orders


TOOTH_POINTS = 512


def tooth_orders(drive: Drive) -> dict[float, float]:
    """Return the first tooth order with its amplitude over the pull at the pitch radius; none without teeth.

    Examples
    --------
    A sprocket of 16 teeth: (1/cos(π/16) − 1) is 2 %, its first harmonic 0.4 times that.

    >>> from dataclasses import replace
    >>> chain = Drive("", "chain", 0.0, 40.0, 0.0, 16, 0.0, 0.0, 0.0, 1.0, None, 0.0, False)
    >>> {order: round(share, 5) for order, share in tooth_orders(chain).items()}
    {16.0: 0.00791}
    """
    if drive.teeth is None:
        return {}
    angle = 2.0 * math.pi / drive.teeth * np.arange(TOOTH_POINTS) / TOOTH_POINTS
    amplitude = abs(np.fft.rfft(drive.teeth_factor(angle))[1]) * 2.0 / TOOTH_POINTS
    return {float(drive.teeth): float(amplitude)} if amplitude > 0.0 else {}
