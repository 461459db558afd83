"""A cycle at one speed: torque and its orders, uneven speed, loads of every pin and bearing."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from autobalance.balancing.engine_from_job import as_measured
from autobalance.balancing.measured import Crank
from autobalance.engines.cycle.firing import firing_engine
from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.engines.cycle.grid import CycleGrid
from autobalance.engines.cycle.load_figures import LoadPeak, TorqueOrder
from autobalance.engines.cycle.speed import UnevenSpeed, flywheel_needed_g_mm2, periodic_speed
from autobalance.job import Job
from autobalance.running_gear.loads import Loads
from autobalance.types import Array, Complex
from autobalance.units import BAR_PER_MPA, N_M_PER_G_MM2_S2, N_M_PER_N_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

HIGHEST_ORDER = 12


def torque_orders(strokes: int) -> Array:
    """Return the orders of a torque: ½ to 12 for four strokes, 1 to 12 for two."""
    step = 0.5 if strokes == 4 else 1.0
    return np.arange(step, HIGHEST_ORDER + 0.5 * step, step)


@dataclass(frozen=True, eq=False)
class CycleAnalysis:
    """A firing engine at a constant speed, on the angles of its grid."""

    firing: FiringEngine
    speed_rad_s: float

    @property
    def grid(self) -> CycleGrid:
        """The crank angles."""
        return self.firing.grid

    @cached_property
    def loads(self) -> Loads:
        """Loads of the crank as it is."""
        return self.firing.parts.at_speed(self.speed_rad_s)

    @cached_property
    def crankpins_n(self) -> Array:
        """Load on each crankpin, of all its rods together (t, n, 2) [N]."""
        return np.stack([self.loads.crankpin_n[list(t.cylinders)].sum(axis=0) for t in self.firing.throws])

    # --- torque ---------------------------------------------------------------------------------------------

    @property
    def gas_n_m(self) -> Array:
        """Torque of the gas (n,) [N·m]."""
        return self.loads.gas_torque_n_m

    @property
    def inertia_n_m(self) -> Array:
        """Torque of rods and pistons on the crank, −½ J′ Ω² (n,) [N·m]."""
        return -self.loads.torque_n_m

    @cached_property
    def friction_n_m(self) -> Array:
        """Friction of main bearings and all the rest, a positive number (n,) [N·m]."""
        size = np.hypot(self.loads.main_n[..., 0], self.loads.main_n[..., 1])
        lever = self.firing.friction.main_lever_mm(self.firing.main_diameters_mm)
        pistons = self.firing.piston_friction_by_angle_n_m(self.speed_rad_s)
        rest = self.firing.mean_pressure_friction_n_m(self.speed_rad_s)
        result: Array = lever @ size * N_M_PER_N_MM + (rest if pistons is None else rest + pistons)
        return result

    @property
    def weight_n_m(self) -> Array | None:
        """Torque of the weights of crank, rods and pistons (n,), whose mean is zero [N·m]; None without."""
        weight = self.firing.parts.weight
        return None if weight is None else weight.torque_n_m

    @property
    def total_n_m(self) -> Array:
        """Gas − friction + inertia + weight (n,) [N·m]."""
        total = self.gas_n_m - self.friction_n_m + self.inertia_n_m
        return total if self.weight_n_m is None else total + self.weight_n_m

    @cached_property
    def friction_mean_n_m(self) -> float:
        """Mean friction torque [N·m]."""
        return float(self.grid.mean(self.friction_n_m))

    @property
    def inertia_mean_n_m(self) -> float:
        """Mean inertia torque, zero except for rounding [N·m]."""
        return float(self.grid.mean(self.inertia_n_m))

    @property
    def mean_n_m(self) -> float:
        """Mean torque at the shaft [N·m]."""
        return self.firing.gas_mean_n_m - self.friction_mean_n_m + self.inertia_mean_n_m

    @cached_property
    def orders(self) -> tuple[TorqueOrder, ...]:
        """Orders of the torque: ½ to 12 for four strokes, 1 to 12 for two."""
        orders = torque_orders(self.firing.strokes)
        gas, inertia, total = (
            self.grid.harmonics(values, orders) for values in (self.gas_n_m, self.inertia_n_m, self.total_n_m)
        )
        phases = [_phase_rad(each) for each in total]
        rows = zip(orders, np.abs(gas), np.abs(inertia), np.abs(total), phases, strict=True)
        return tuple(TorqueOrder(*(float(each) for each in row)) for row in rows)

    # --- speed ----------------------------------------------------------------------------------------------

    @cached_property
    def mean_inertia_g_mm2(self) -> float:
        """Mean of J over the crank angle [g·mm²]."""
        return float(np.mean(self._inertia_g_mm2))

    @cached_property
    def _inertia_g_mm2(self) -> Array:
        return self.firing.inertia_g_mm2(self.grid.even_rad)

    @property
    def _driving_n_m(self) -> Array:
        """Torque of gas and weights (n,) [N·m]."""
        return self.gas_n_m if self.weight_n_m is None else self.gas_n_m + self.weight_n_m

    @cached_property
    def _surplus_work_n_m(self) -> Array:
        """∫(T − its mean) dθ from 0 to each even angle; constant friction and load take the mean away."""
        pistons = self.firing.piston_friction_by_angle_n_m(self.speed_rad_s)
        return self._surplus_n_m(self._driving_n_m if pistons is None else self._driving_n_m - pistons)

    def _surplus_n_m(self, driving_n_m: Array) -> Array:
        work = self.grid.work_to_even(driving_n_m)
        mean = work[-1] / self.grid.span_rad
        result: Array = work[:-1] - mean * self.grid.even_rad
        return result

    @property
    def without_piston_friction(self) -> UnevenSpeed | None:
        """Speed over the cycle if the friction of pistons were its mean at every angle."""
        work = self._surplus_n_m(self._driving_n_m)
        return periodic_speed(self.grid.even_rad, work, self._inertia_g_mm2, self.speed_rad_s)

    @cached_property
    def uneven_speed(self) -> UnevenSpeed | None:
        """Speed over the cycle under a constant load; None where the crank would stop."""
        return self._with_flywheel(0.0)

    def _with_flywheel(self, added_g_mm2: float) -> UnevenSpeed | None:
        inertia = self._inertia_g_mm2 + added_g_mm2
        return periodic_speed(self.grid.even_rad, self._surplus_work_n_m, inertia, self.speed_rad_s)

    def flywheel_needed_g_mm2(self, fluctuation_wanted: float) -> float | None:
        """Return the flywheel, in place of the one there is, for a wanted fluctuation [g·mm²]."""

        def fluctuation(flywheel: float) -> float | None:
            analysis = self._with_flywheel(flywheel - self.firing.flywheel_g_mm2)
            return None if analysis is None else analysis.fluctuation

        return flywheel_needed_g_mm2(fluctuation, fluctuation_wanted)

    @property
    def acceleration_rad_s2(self) -> float:
        """Throttle response: (gas − friction)/J, means, without load [rad/s²]."""
        surplus = self.firing.gas_mean_n_m - self.friction_mean_n_m
        return surplus / (self.mean_inertia_g_mm2 * N_M_PER_G_MM2_S2)

    # --- peaks ----------------------------------------------------------------------------------------------

    def peak(self, load_n: Array) -> LoadPeak:
        """Return largest and mean magnitude of a load (n, 2) or (n,)."""
        size = np.abs(load_n) if load_n.ndim == 1 else np.hypot(load_n[:, 0], load_n[:, 1])
        place = int(np.argmax(size))
        at = float(self.grid.angle_rad[place])
        return LoadPeak(float(size[place]), at, float(self.grid.mean(size)))

    def peaks(self, loads_n: Sequence[Array] | Array) -> tuple[LoadPeak, ...]:
        """Return largest and mean magnitude of each load."""
        return tuple(self.peak(load) for load in loads_n)


def _phase_rad(value: complex) -> float:
    """Angle in (−π, π], zero for zero."""
    angle = float(np.angle(value))
    return np.pi if angle <= -np.pi else angle


# A cycle by angle, one column each, unit in its name.


def series_columns(cycle: CycleAnalysis) -> dict[str, Array]:
    """Return the columns of a series, every ½° from crank angle 0: (1440,) for 4 strokes, (720,) for 2.

    At a jump of the pressure they have the value after it. ``speed_rpm`` is left out where the crank would
    stop.
    """
    columns = {"angle_deg": 0.5 * np.arange(cycle.grid.even_rad.size, dtype=np.float64)}
    columns |= {name: cycle.grid.even(values) for name, values in _columns(cycle)}
    if cycle.uneven_speed is not None:
        columns["speed_rpm"] = cycle.uneven_speed.speed_rad_s / RAD_S_PER_RPM
    return columns


def _columns(cycle: CycleAnalysis) -> Iterator[tuple[str, Array]]:
    state, loads, shown = cycle.firing.parts.gas_state, cycle.loads, cycle.firing.engine.shown
    wall = -1.0 if cycle.firing.engine.clockwise else 1.0
    for number in range(len(cycle.firing.cycles)):
        name = f"c{number + 1}"
        yield f"{name}_volume_cm3", state.volume_mm3[number] * 1e-3
        yield f"{name}_pressure_bar", state.pressure_mpa[number] * BAR_PER_MPA
        yield from _force(f"{name}_wrist_pin", shown(loads.wrist_pin_n[number]))
        yield f"{name}_wall_N", wall * loads.wall_n[number]
        yield from _force(f"{name}_big_end", shown(loads.crankpin_n[number]))
    for number, load in enumerate(cycle.crankpins_n, 1):
        yield from _force(f"crankpin_{number}", shown(load))
    for number, load in enumerate(loads.main_n, 1):
        yield from _force(f"main_{number}", shown(load))
    yield "gas_N_m", cycle.gas_n_m
    yield "inertia_N_m", cycle.inertia_n_m
    yield "friction_N_m", cycle.friction_n_m
    yield "total_N_m", cycle.total_n_m


def _force(name: str, load_n: Array) -> Iterator[tuple[str, Array]]:
    yield f"{name}_x_N", load_n[:, 0]
    yield f"{name}_y_N", load_n[:, 1]


def series_csv(columns: dict[str, Array]) -> bytes:
    """Return columns as a CSV file with a header."""
    text, table = io.StringIO(), np.column_stack(list(columns.values()))
    np.savetxt(text, table, fmt="%.12g", delimiter=",", header=",".join(columns), comments="")
    return text.getvalue().encode()


# Torque orders of a job's cycle, throw by throw: what excites the torsion of its crank.


@dataclass(frozen=True, eq=False)
class ThrowTorques:
    """Orders (k,) of the torque that rods put on each throw, (k, throws) as T exp(iφ) [N·m].

    ``inertia_n_m_s2`` is that of rods and pistons at 1 rad/s; it grows with the square of the speed.
    ``firing_rad`` (cylinders,) are the crank angles at which cylinders fire, ``cylinder_throws`` their throws
    from 0. ``mean_n_m`` is the mean torque of gas minus friction at the job's speed. ``inertia_g_mm2`` is the
    mean inertia of everything that turns with the crank.
    """

    orders: Array
    gas_n_m: Complex
    inertia_n_m_s2: Complex
    firing_rad: Array
    cylinder_throws: tuple[int, ...]
    mean_n_m: float
    inertia_g_mm2: float = 0.0

    def at_speed(self, speed_rad_s: float) -> Complex:
        """Return all of the torque (k, throws) at a speed."""
        return np.asarray(self.gas_n_m + speed_rad_s**2 * self.inertia_n_m_s2)


def throw_torques(job: Job, crank: Crank) -> ThrowTorques:
    """Return the torque orders of a job with a ``[cycle]``: ½ to 12 for four strokes, 1 to 12 for two."""
    speed = job.balance.service_speed_rad_s
    firing = firing_engine(job, crank.anatomy, speed, lambda: as_measured(job, crank))
    orders = torque_orders(firing.strokes)
    radii = [throw.crank_radius_mm for throw in crank.anatomy.throws]
    gas, inertia = (
        np.stack(
            [firing.grid.harmonics(each, orders) for each in torques_on_throws(firing, pins, radii)], axis=1
        )
        for pins in (firing.parts.gas.crankpin_n, firing.parts.rods.crankpin_n)
    )
    throws = sorted((c, number) for number, each in enumerate(firing.throws) for c in each.cylinders)
    mean = firing.gas_mean_n_m - firing.piston_friction_n_m(speed)
    by_cylinder = tuple(number for _, number in throws)
    turning = float(np.mean(firing.inertia_g_mm2(firing.grid.even_rad)))
    return ThrowTorques(orders, gas, inertia, np.array(firing.firing_rad), by_cylinder, mean, turning)


def torques_on_throws(firing: FiringEngine, cylinder_n: Array, radii_mm: list[float]) -> list[Array]:
    """Return the torque (n,) on each throw from the loads (cylinders, n, 2) on its crankpin [N·m]."""
    torques = []
    for throw, radius in zip(firing.throws, radii_mm, strict=True):
        load = cylinder_n[list(throw.cylinders)].sum(axis=0)
        angle = firing.grid.angle_rad + throw.angle_rad
        torque = radius * (np.cos(angle) * load[:, 1] - np.sin(angle) * load[:, 0])
        torques.append(torque * N_M_PER_N_MM)
    return torques
