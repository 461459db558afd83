"""A cycle at one speed: torque and its orders, uneven speed, loads of every pin and bearing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.engines.cycle.grid import CycleGrid
from autobalance.engines.cycle.load_figures import LoadPeak, TorqueOrder
from autobalance.engines.cycle.speed import (
    UnevenSpeed,
    flywheel_needed_g_mm2,
    periodic_speed,
)
from autobalance.running_gear.loads import Loads
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM
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
