"""An engine that fires: its loads, torque and friction over the crank angle at any speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from autobalance.engines.cycle.cylinder import CylinderCycle, Strokes
from autobalance.engines.cycle.drive import Drive, DrivenCrank, DrivePulls, drive_pulls
from autobalance.engines.cycle.grid import CycleGrid
from autobalance.engines.cycle.model import NO_FRICTION, Friction
from autobalance.engines.cycle.piston_friction import PistonFriction, PistonFrictionParts, WallLoads
from autobalance.engines.cycle.weight import Gravity, WeightLoads, weight_loads
from autobalance.running_gear.loads import Loads, lever_shares, loads, variable_inertia_g_mm2
from autobalance.running_gear.whole_engine import CrankUnbalance, Engine
from autobalance.types import Array, Complex
from autobalance.units import BAR_PER_MPA, N_M_PER_N_MM, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

NO_WORK = 1e-9
"""Share of peak pressure × swept volume below which work is rounding."""


@dataclass(frozen=True)
class ThrowPlace:
    """A throw: where its crankpin is, and the numbers from 0 of the cylinders that work on it."""

    angle_rad: float
    z_mm: float
    cylinders: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class FiringEngine:
    """An engine with the gas in its cylinders and the bearings that carry its crank.

    Attributes
    ----------
    engine : Engine
        With its crank's pieces of unbalance.
    throws : tuple of ThrowPlace
    mains_z_mm, main_diameters_mm : tuple of float
        By main bearing, increasing z [mm].
    cycles : tuple of CylinderCycle
        By cylinder.
    firing_rad : tuple of float
        Crank angle of each cylinder's firing top dead centre [rad].
    flywheel_g_mm2 : float
        Polar inertia that turns with the crank besides its own [g·mm²].
    friction : Friction
    gravity : Gravity or None
        None: nothing has weight.
    drives : tuple of Drive
    drive_speed_rad_s : float
        Speed at which the drives pull [rad/s].
    piston_friction : PistonFriction or None
        None: pistons have the friction mean pressure alone.
    """

    engine: Engine
    throws: tuple[ThrowPlace, ...]
    mains_z_mm: tuple[float, ...]
    main_diameters_mm: tuple[float, ...]
    cycles: tuple[CylinderCycle, ...]
    firing_rad: tuple[float, ...]
    flywheel_g_mm2: float = 0.0
    friction: Friction = NO_FRICTION
    gravity: Gravity | None = None
    drives: tuple[Drive, ...] = ()
    drive_speed_rad_s: float = 0.0
    piston_friction: PistonFriction | None = None

    @property
    def strokes(self) -> Strokes:
        """Two or four."""
        return self.cycles[0].exchange.strokes

    @cached_property
    def grid(self) -> CycleGrid:
        """Crank angles over a cycle at which everything is computed."""
        jumps = [
            firing + jump
            for cycle, firing in zip(self.cycles, self.firing_rad, strict=True)
            for jump in cycle.jumps_rad
        ]
        return CycleGrid.of(self.cycles[0].span_rad, jumps)

    def gas(self, angle_rad: Array) -> GasState:
        """Return the gas in every cylinder at crank angles (n,) [rad]."""
        volume, pressure, force = (np.zeros((len(self.cycles), angle_rad.size)) for _ in range(3))
        for number, (cycle, firing) in enumerate(zip(self.cycles, self.firing_rad, strict=True)):
            after = angle_rad - firing
            volume[number] = cycle.chamber.volume_mm3(after)
            pressure[number] = cycle.pressure_mpa(after, volume[number])
            above = pressure[number] - cycle.below_mpa(volume[number])
            force[number] = above * cycle.chamber.piston_area_mm2
        return GasState(volume, pressure, force)

    @cached_property
    def parts(self) -> LoadParts:
        """The loads on the grid's angles, gas and inertia apart."""
        parts, friction = LoadParts.of(self, self.grid.angle_rad), self.piston_friction
        if friction is not None:
            rods, chambers = Engine(self.engine.cylinders), [each.chamber for each in self.cycles]
            case = friction, rods, self.mains_z_mm, chambers, self.grid.angle_rad, parts.walls
            parts = replace(parts, pistons=PistonFrictionParts.of(*case))
        return self._pulled(parts)

    def parts_beside(self, firing: FiringEngine) -> LoadParts:
        """Return this engine's parts from those of one that differs by its reciprocating masses alone.

        What gas and places of the rods decide is the same, and it is most of the work.
        """
        given, rods = firing.parts, Engine(self.engine.cylinders)
        moved = loads(rods, self.mains_z_mm, 1.0, self.grid.angle_rad)
        weight = weight_loads_of(self, self.grid.angle_rad)
        parts = LoadParts(given.gas_state, given.gas, moved, given.crank_n, weight)
        if given.pistons is not None:
            parts = replace(parts, pistons=given.pistons.with_masses_of(rods, parts.walls))
        return self._pulled(parts)

    def _pulled(self, parts: LoadParts) -> LoadParts:
        """Return the parts with what the drives pull."""
        if not self.drives:
            return parts
        speed = self.drive_speed_rad_s
        driving = parts.gas.gas_torque_n_m
        driving = driving if parts.weight is None else driving + parts.weight.torque_n_m
        mean = self.gas_mean_n_m - self.mean_pressure_friction_n_m(speed)
        if parts.pistons is not None:
            rubbed = parts.pistons.at(speed).torque_n_m.sum(axis=0)
            driving, mean = driving - rubbed, mean - float(self.grid.mean(rubbed))
        crank = DrivenCrank(
            self.grid,
            speed,
            self.engine.clockwise,
            self.mains_z_mm,
            parts.mains_n(speed, parts.crank_n),
            self.friction.main_lever_mm(self.main_diameters_mm) * N_M_PER_N_MM,
            driving,
            mean,
            self.inertia_g_mm2(self.grid.angle_rad),
            parts.rods.torque_n_m,
        )
        return replace(parts, pulls=drive_pulls(self.drives, crank))

    def inertia_g_mm2(self, angle_rad: Array) -> Array:
        """Return J(θ) of all that moves with the crank (n,) [g·mm²]."""
        turning = self.engine.polar_inertia_g_mm2 + self.flywheel_g_mm2
        turning += sum(each.driven_inertia_g_mm2 for each in self.drives)
        total = np.full(angle_rad.shape, turning)
        for cylinder in self.engine.cylinders:
            motion = cylinder.slider_crank.motion(angle_rad + cylinder.throw_angle_rad - cylinder.bank_rad)
            total += variable_inertia_g_mm2(cylinder, motion)
        return total

    def piston_friction_n_m(self, speed_rad_s: float) -> float:
        """Return the mean torque of the friction mean pressure (Chen and Flynn) and of pistons [N·m]."""
        by_angle = self.piston_friction_by_angle_n_m(speed_rad_s)
        mean = self.mean_pressure_friction_n_m(speed_rad_s)
        return mean if by_angle is None else mean + float(self.grid.mean(by_angle))

    def piston_friction_by_angle_n_m(self, speed_rad_s: float) -> Array | None:
        """Return the torque that pistons take by their side force and rings (n,) [N·m]; None without."""
        pistons = self.parts.pistons
        if pistons is None:
            return None
        result: Array = pistons.at(speed_rad_s).torque_n_m.sum(axis=0)
        return result

    def mean_pressure_friction_n_m(self, speed_rad_s: float) -> float:
        """Return the torque of the friction mean pressure (Chen and Flynn) [N·m]."""
        total = 0.0
        for cycle in self.cycles:
            stroke_m = cycle.chamber.slider_crank.stroke_mm * 1e-3
            peak_bar = cycle.peak[0] * BAR_PER_MPA
            bar = self.friction.mean_pressure_bar(peak_bar, stroke_m * speed_rad_s / math.pi)
            total += bar / BAR_PER_MPA * cycle.chamber.swept_mm3
        return total * N_M_PER_N_MM / self.grid.span_rad

    @property
    def work_n_mm(self) -> float:
        """Work of the gas of all cylinders over a cycle [N·mm]."""
        return sum(cycle.work_n_mm for cycle in self.cycles)

    @property
    def gas_mean_n_m(self) -> float:
        """Mean torque of the gas, from its forces on the crankpins [N·m]."""
        return sum(cycle.torque_work_n_mm for cycle in self.cycles) * N_M_PER_N_MM / self.grid.span_rad

    @property
    def energy_error(self) -> float | None:
        """|∮ torque dθ − Σ work|/Σ|work|; None where the gas does no work except for rounding."""
        size = sum(abs(cycle.work_n_mm) for cycle in self.cycles)
        if size <= NO_WORK * sum(cycle.peak[0] * cycle.chamber.swept_mm3 for cycle in self.cycles):
            return None
        return abs(sum(cycle.torque_work_n_mm for cycle in self.cycles) - self.work_n_mm) / size


@dataclass(frozen=True, eq=False)
class GasState:
    """Volume [mm³], pressure [MPa] and force on the piston [N] of each cylinder, (c, n) each."""

    volume_mm3: Array
    pressure_mpa: Array
    force_n: Array


@dataclass(frozen=True, eq=False)
class LoadParts:
    """Loads over the crank angle in parts that speed and counterweights scale.

    At speed Ω a load is its part of the gas and the weights + Ω² × its part of the rods and pistons; the
    mains carry besides Ω² exp(iθ) × the unbalance of the crank, by levers.

    Attributes
    ----------
    gas_state : GasState
    gas, rods : Loads
        Of the gas alone; of rods and pistons at 1 rad/s, without the crank.
    crank_n : (m,) complex
        What the crank's unbalance does to each main at 1 rad/s and angle 0, x + iy [N].
    weight : WeightLoads or None
        None: nothing has weight.
    pulls : DrivePulls or None
        None: nothing takes torque off the crank.
    pistons : PistonFrictionParts or None
        None: pistons have no friction by angle.
    """

    gas_state: GasState
    gas: Loads
    rods: Loads
    crank_n: Complex
    weight: WeightLoads | None = None
    pulls: DrivePulls | None = None
    pistons: PistonFrictionParts | None = None

    @classmethod
    def of(cls, firing: FiringEngine, angle_rad: Array) -> LoadParts:
        """Return the parts at crank angles (n,) [rad]."""
        rods = Engine(firing.engine.cylinders)
        state = firing.gas(angle_rad)
        return cls(
            state,
            loads(rods, firing.mains_z_mm, 0.0, angle_rad, gas_n=state.force_n),
            loads(rods, firing.mains_z_mm, 1.0, angle_rad),
            pulls_at_mains_n(firing.engine.crank, firing.mains_z_mm),
            weight_loads_of(firing, angle_rad),
        )

    @property
    def walls(self) -> WallLoads:
        """Forces that press the pistons on their walls."""
        steady = self.gas.wall_n if self.weight is None else self.gas.wall_n + self.weight.rods.wall_n
        return WallLoads(self.gas_state.force_n, steady, self.rods.wall_n)

    def at_speed(self, speed_rad_s: float) -> Loads:
        """Return the loads at a constant speed."""
        square = speed_rad_s**2
        names = ("wrist_pin_n", "wall_n", "crankpin_n", "torque_n_m")
        both = [getattr(self.gas, name) + square * getattr(self.rods, name) for name in names]
        if self.weight is not None:  # its torque is told apart from that of inertia
            own = [getattr(self.weight.rods, name) for name in names[:-1]]
            both = [load + weight for load, weight in zip(both, own, strict=False)] + both[-1:]
        if self.pistons is not None:
            rubbed = self.pistons.loads(self.gas.angle_rad, speed_rad_s)
            own = [getattr(rubbed, name) for name in names[:-1]]
            both = [load + added for load, added in zip(both, own, strict=False)] + both[-1:]
        main = self.mains_n(speed_rad_s, self.crank_n)
        main_n = np.stack([main.real, main.imag], axis=-1)
        wrist, wall, crankpin, torque = both
        return Loads(self.gas.angle_rad, wrist, wall, crankpin, main_n, torque, self.gas.gas_torque_n_m)

    def mains_n(self, speed_rad_s: float, crank_n: Complex) -> Complex:
        """Return the loads x + iy of the mains (m, n) with any crank's unbalance (m,) at them [N]."""
        square = speed_rad_s**2
        turned: Complex = self.rod_mains_n + crank_n[:, None] * self._turning
        result: Complex = self.steady_mains_n + square * turned
        return result if self.pistons is None else result + self.pistons.mains_n(speed_rad_s)

    @cached_property
    def _turning(self) -> Complex:
        """Unit vector x + iy (n,) that turns with the crank."""
        result: Complex = np.exp(1j * self.gas.angle_rad)
        return result

    @cached_property
    def steady_mains_n(self) -> Complex:
        """Loads of the mains (m, n) by gas, weight and drives, x + iy [N]."""
        gas = as_complex(self.gas.main_n)
        gas = gas if self.weight is None else gas + self.weight.mains_n
        return gas if self.pulls is None else gas + self.pulls.mains_n

    @cached_property
    def rod_mains_n(self) -> Complex:
        """Loads of the mains (m, n) by rods and pistons at 1 rad/s, x + iy [N]."""
        return as_complex(self.rods.main_n)


def weight_loads_of(firing: FiringEngine, angle_rad: Array) -> WeightLoads | None:
    """Return the loads of weights at crank angles (n,) [rad]; None if nothing has weight."""
    if firing.gravity is None:
        return None
    return weight_loads(firing.engine, firing.gravity, firing.mains_z_mm, angle_rad)


def as_complex(vectors: Array) -> Complex:
    """Return vectors (..., 2) as x + iy (...)."""
    result: Complex = vectors[..., 0] + 1j * vectors[..., 1]
    return result


def pulls_at_mains_n(pieces: Sequence[CrankUnbalance], mains_z_mm: Sequence[float]) -> Complex:
    """Return the forces of unbalances on each main at 1 rad/s, x + iy in the rotor frame (m,) [N]."""
    total = np.zeros(len(mains_z_mm), dtype=np.complex128)
    for piece in pieces:
        total += lever_shares(piece.z_mm, mains_z_mm) * complex(*piece.unbalance_g_mm)
    result: Complex = total * N_PER_G_MM_S2
    return result
