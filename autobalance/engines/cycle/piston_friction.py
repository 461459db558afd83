"""Friction of pistons by their side force and of rings by the gas: force, loads and torque by crank angle.

On each piston friction is −sgn(ẋ) f along the cylinder, f = μ(ẋ) |N| + μ_r (F_t + π B h Δp) + c |ẋ|, with N
the wall's force. It leans on the rod as gas does, so that N itself depends on it: N = A + W sgn(ẋ) f, where
A is the wall's force without friction and W what a force along the cylinder makes of it (tan of the rod's
angle; link rods push their master aside too). Its torque on the crank is f |x′|, by the work that it takes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from autobalance.declare import ANY, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.engines.cycle.cylinder import CylinderCycle
from autobalance.engines.cycle.weight import WeightLoads
from autobalance.errors import JobError
from autobalance.running_gear.loads import Loads, loads
from autobalance.running_gear.whole_engine import Engine
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM, N_PER_G_MM_S2

LARGEST_MU = 1.0
SETTLED = 1e-13
ROUNDS = 200
M_S_PER_MM_S = 1e-3

PISTON = (
    Key("skirt_mu", float, "friction of the skirt on its wall, by the side force", NOT_NEGATIVE, 0.0),
    Key("boundary_mu", float, "friction of the skirt at zero piston speed; needs `stribeck_speed_m_s`", NOT_NEGATIVE,
        None, usual="`skirt_mu`"),
    Key("stribeck_speed_m_s", float, "speed over which friction falls from `boundary_mu` to `skirt_mu`, "
        "μ = μ_s + (μ_b − μ_s) exp(−|v|/v₀)", POSITIVE, None, usual="Coulomb"),
    Key("viscous_N_s_m", float, "shear of the oil film of skirt and rings over the speed", NOT_NEGATIVE, 0.0),
    Key("ring_mu", float, "friction of the rings", NOT_NEGATIVE, 0.0),
    Key("ring_tension_N", float, "force of all rings' own tension on the wall", NOT_NEGATIVE, 0.0),
    Key("ring_height_mm", float, "height of all rings that gas presses on the wall", NOT_NEGATIVE, 0.0),
    Key("pin_offset_mm", float, "place of the wrist pin beside the piston's centre line: its part of "
        "`engine.layout.offset_mm`", ANY, 0.0),
    Key("skirt_length_mm", float, "distance of the skirt's two ends: a piston that tilts by its pin offset "
        "presses with both", POSITIVE, None),
)  # fmt: skip
"""Keys of ``[cycle.piston]``."""


@dataclass(frozen=True)
class PistonFriction:
    """Friction of every piston: coefficients, N, mm, N·s/m, and the speed of its Stribeck curve [m/s]."""

    skirt_mu: float = 0.0
    boundary_mu: float | None = None
    stribeck_speed_m_s: float | None = None
    viscous_n_s_m: float = 0.0
    ring_mu: float = 0.0
    ring_tension_n: float = 0.0
    ring_height_mm: float = 0.0
    pin_offset_mm: float = 0.0
    skirt_length_mm: float | None = None

    def skirt_mu_at(self, speed_m_s: Array) -> Array:
        """Return the coefficient of the skirt at piston speeds of any sign.

        Examples
        --------
        >>> stribeck = PistonFriction(0.05, 0.15, 1.0)
        >>> stribeck.skirt_mu_at(np.array([0.0, -20.0])).round(6).tolist()
        [0.15, 0.05]
        """
        if self.stribeck_speed_m_s is None or self.boundary_mu is None:
            return np.full(speed_m_s.shape, self.skirt_mu)
        fall = np.exp(-np.abs(speed_m_s) / self.stribeck_speed_m_s)
        result: Array = self.skirt_mu + (self.boundary_mu - self.skirt_mu) * fall
        return result


def piston_friction_of(values: Values | None) -> PistonFriction | None:
    """Return the friction of ``[cycle.piston]``; None without one.

    Raises
    ------
    JobError
        If a coefficient is so large that pistons would jam, or the curve has no speed.
    """
    if values is None:
        return None
    for key in ("skirt_mu", "boundary_mu", "ring_mu"):
        if values[key] is not None and values[key] >= LARGEST_MU:
            raise JobError(f"cycle.piston.{key} is {values[key]:g}; must be below {LARGEST_MU:g}")
    if (values["boundary_mu"] is None) != (values["stribeck_speed_m_s"] is None):
        given, missing = ("boundary_mu", "stribeck_speed_m_s")
        if values["boundary_mu"] is None:
            given, missing = missing, given
        raise JobError(f"cycle.piston.{given} is given without {missing}; a Stribeck curve needs both")
    return PistonFriction(
        values["skirt_mu"],
        values["boundary_mu"],
        values["stribeck_speed_m_s"],
        values["viscous_N_s_m"],
        values["ring_mu"],
        values["ring_tension_N"],
        values["ring_height_mm"],
        values["pin_offset_mm"],
        values["skirt_length_mm"],
    )


@dataclass(frozen=True, eq=False)
class FrictionForces:
    """Friction of pistons at a speed, by cylinder and crank angle (c, n).

    Attributes
    ----------
    skirt_n, rings_n : (c, n) float
        Sizes of friction: of the skirt by its side force, of rings with the film's shear [N].
    along_n : (c, n) float
        Friction as a force of gas: towards the crank where positive [N].
    wall_n : (c, n) float
        Of each piston on its wall, with friction, along the cylinder's direction turned by +90° [N].
    torque_n_m : (c, n) float
        Taken off the crank, positive [N·m].
    tilt_n_m : (c, n) float
        Moment that tilts each piston about its wrist pin, by its pin offset [N·m].
    """

    skirt_n: Array
    rings_n: Array
    along_n: Array
    wall_n: Array
    torque_n_m: Array
    tilt_n_m: Array


class GasForce(Protocol):
    """Gas on the pistons."""

    @property
    def force_n(self) -> Array: ...


class RubbedParts(Protocol):
    """Parts of an engine's loads that press its pistons on their walls."""

    @property
    def gas(self) -> Loads: ...
    @property
    def rods(self) -> Loads: ...
    @property
    def gas_state(self) -> GasForce: ...
    @property
    def weight(self) -> WeightLoads | None: ...


class RubbedEngine(Protocol):
    """An engine that fires, as the friction of its pistons sees it."""

    @property
    def engine(self) -> Engine: ...
    @property
    def mains_z_mm(self) -> tuple[float, ...]: ...
    @property
    def cycles(self) -> tuple[CylinderCycle, ...]: ...


@dataclass(frozen=True, eq=False)
class PistonFrictionParts:
    """What friction needs at any speed: wall forces of gas, weight and inertia, and responses to a force.

    Attributes
    ----------
    friction : PistonFriction
    engine : Engine
        Without its crank.
    mains_z_mm : tuple of float
    slope_mm, bend_mm : (c, n) float
        x′ and x″ of the pistons by the crank angle.
    steady_n, per_square_n : (c, n) float
        Wall force of gas and weight; of inertia at 1 rad/s [N].
    response : (c, c, n) float
        Wall force of cylinder i by a force of 1 N along cylinder j.
    mains : (m, c, n) complex
        Load of a main by the same.
    rings_n : (c, n) float
        Friction of rings by tension and gas [N].
    gas_n : (c, n) float
        Force of the gas [N].
    piston_g : (c,) float
        Masses of pistons without the rods' small ends.
    """

    friction: PistonFriction
    engine: Engine
    mains_z_mm: tuple[float, ...]
    slope_mm: Array
    bend_mm: Array
    steady_n: Array
    per_square_n: Array
    response: Array
    mains: Complex
    rings_n: Array
    gas_n: Array
    piston_g: Array
    known: dict[float, FrictionForces] = field(default_factory=dict)
    known_mains: dict[float, Complex] = field(default_factory=dict)

    @classmethod
    def of(cls, firing: RubbedEngine, parts: RubbedParts, friction: PistonFriction) -> PistonFrictionParts:
        """Return the parts on the angles of the loads."""
        engine, angle = Engine(firing.engine.cylinders), parts.gas.angle_rad
        count = len(engine.cylinders)
        response, mains = [], []
        for number in range(count):
            unit = np.zeros((count, angle.size))
            unit[number] = 1.0
            pushed = loads(engine, firing.mains_z_mm, 0.0, angle, gas_n=unit)
            response.append(pushed.wall_n)
            mains.append(pushed.main_n[..., 0] + 1j * pushed.main_n[..., 1])
        motions = [
            each.slider_crank.motion(angle + each.throw_angle_rad - each.bank_rad)
            for each in engine.cylinders
        ]
        around = np.array([math.pi * cycle.chamber.bore_mm for cycle in firing.cycles])[:, None]
        area = np.array([cycle.chamber.piston_area_mm2 for cycle in firing.cycles])[:, None]
        pressed = around * friction.ring_height_mm * np.maximum(0.0, parts.gas_state.force_n / area)
        weight = 0.0 if parts.weight is None else parts.weight.rods.wall_n
        return cls(
            friction,
            engine,
            firing.mains_z_mm,
            np.stack([each.dx_mm for each in motions]),
            np.stack([each.ddx_mm for each in motions]),
            parts.gas.wall_n + weight,
            parts.rods.wall_n,
            np.stack(response, axis=1),
            np.stack(mains, axis=1),
            friction.ring_mu * (friction.ring_tension_n + pressed),
            parts.gas_state.force_n,
            np.array([each.reciprocating_g - each.small_end_g for each in engine.cylinders]),
        )

    def at(self, speed_rad_s: float) -> FrictionForces:
        """Return the friction at a constant speed."""
        if speed_rad_s not in self.known:
            self.known[speed_rad_s] = self._at(speed_rad_s)
        return self.known[speed_rad_s]

    def _at(self, speed_rad_s: float) -> FrictionForces:
        way, steep = self._way, self._steep_mm
        speed = steep * (speed_rad_s * M_S_PER_MM_S)
        mu = self.friction.skirt_mu_at(speed)
        rings = self.rings_n + self.friction.viscous_n_s_m * np.abs(speed)
        bare = self.steady_n + speed_rad_s**2 * self.per_square_n
        inertia = self.piston_g[:, None] * self.bend_mm * speed_rad_s**2 * N_PER_G_MM_S2
        tilt = self.friction.pin_offset_mm * (self.gas_n + inertia)
        length = self.friction.skirt_length_mm
        least = np.zeros_like(tilt) if length is None else 2.0 * np.abs(tilt) / length
        skirt, wall = self._balanced(bare, way, mu, rings, least)
        size = skirt + rings
        torque = size * steep * N_M_PER_N_MM
        return FrictionForces(skirt, rings, way * size, wall, torque, tilt * N_M_PER_N_MM)

    @cached_property
    def _way(self) -> Array:
        """Sign of each piston's motion as the crank turns (c, n)."""
        return np.sign(self.slope_mm)

    @cached_property
    def _steep_mm(self) -> Array:
        """Size of each piston's motion by crank angle (c, n) [mm]."""
        return np.abs(self.slope_mm)

    @cached_property
    def _own(self) -> Array:
        """Each piston's wall force by a force along it (c, n)."""
        result: Array = np.einsum("iin->in", self.response)
        return result

    def _balanced(
        self, bare: Array, way: Array, mu: Array, rings: Array, least: Array
    ) -> tuple[Array, Array]:
        """Return the skirts' friction and the wall forces that it balances with, (c, n) each [N]."""
        own = self._own
        linked = any(each.master is not None for each in self.engine.cylinders)
        others = self.response - own[:, None, :] * np.eye(len(own))[:, :, None] if linked else None
        skirt = np.zeros_like(bare)
        for _ in range(ROUNDS):
            pushed = bare + own * way * rings
            if others is not None:
                pushed = pushed + np.einsum("ijn,jn->in", others, way * (skirt + rings))
            # |N| = |A₁|/(1 − σ W s μ) is exact if no other piston's friction moves its wall force
            facing = np.abs(pushed) / (1.0 - np.sign(pushed) * own * way * mu)
            found = mu * np.maximum(facing, least)
            wall = pushed + own * way * found
            found = mu * np.maximum(np.abs(wall), least)
            change = float(np.abs(found - skirt).max(initial=0.0))
            skirt = found
            if others is None or change <= SETTLED * float(np.abs(bare).max(initial=1.0)):
                break
        if others is None:
            return skirt, bare + own * way * (skirt + rings)
        return skirt, bare + np.einsum("ijn,jn->in", self.response, way * (skirt + rings))

    def mains_n(self, speed_rad_s: float) -> Complex:
        """Return what friction adds to the mains (m, n) at a speed, x + iy [N]."""
        if speed_rad_s not in self.known_mains:  # key figures ask for each speed once a factor
            along = self.at(speed_rad_s).along_n
            self.known_mains[speed_rad_s] = (self.mains * along[None]).sum(axis=1)
        return self.known_mains[speed_rad_s]

    def pin_roll_n_m(self, speed_rad_s: float, *, clockwise: bool) -> Array:
        """Return d m ẍ of all pistons (n,): what they roll the block less than masses on their pins [N·m].

        A piston's mass moves on its own line, ``pin_offset_mm`` beside that of the wrist pin.
        """
        offset = -self.friction.pin_offset_mm if clockwise else self.friction.pin_offset_mm
        bend = (self.piston_g[:, None] * self.bend_mm).sum(axis=0)
        result: Array = offset * bend * speed_rad_s**2 * N_M_PER_G_MM2_S2
        return result

    def loads(self, angle_rad: Array, speed_rad_s: float) -> Loads:
        """Return what friction adds to all loads at a speed, at the angles of its parts."""
        return loads(self.engine, self.mains_z_mm, 0.0, angle_rad, gas_n=self.at(speed_rad_s).along_n)

    def equivalent_inertia_g_mm2(self, angle_rad: Array, speed_rad_s: float) -> Array:
        """Return what friction adds to the inertia that the crank feels, ∂(f |x′|)/∂θ̈ (n,) [g·mm²].

        References
        ----------
        Guzzomi, Hesterman and Stone 2008, Proc. IMechE D 222(3), 397–414: friction by the side force adds to
        the variable inertia of an engine.
        """
        swung = loads(self.engine, self.mains_z_mm, 0.0, angle_rad, 1.0).wall_n  # by 1 rad/s²
        now = self.at(speed_rad_s)
        way, speed = np.sign(self.slope_mm), self.slope_mm * speed_rad_s * M_S_PER_MM_S
        mu = self.friction.skirt_mu_at(speed) * np.sign(now.wall_n)
        if self.friction.skirt_length_mm is not None:  # a tilted piston's two ends take up the change
            mu = np.where(now.skirt_n > np.abs(mu * now.wall_n) * (1.0 + 1e-12), 0.0, mu)
        rate = np.zeros_like(swung)
        for _ in range(ROUNDS):
            found = mu * (swung + np.einsum("ijn,jn->in", self.response, way * rate))
            change = float(np.abs(found - rate).max(initial=0.0))
            rate = found
            if change <= SETTLED * float(np.abs(swung).max(initial=0.0)):
                break
        torque = (rate * np.abs(self.slope_mm)).sum(axis=0) * N_M_PER_N_MM
        result: Array = torque / N_M_PER_G_MM2_S2
        return result
