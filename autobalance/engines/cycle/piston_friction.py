"""Friction of pistons by their side force and of rings by the gas: force, loads and torque by crank angle.

On each piston friction is −sgn(ẋ) f along the cylinder, f = μ(ẋ) |N| + μ_r (F_t + π B h Δp) + c |ẋ|, with N
the wall's force. It acts on the rod as gas does, so that N itself depends on it: N = A + W sgn(ẋ) f. A is the
wall's force without friction, W its change by a unit force along the cylinder: tan of the rod's angle (link
rods push their master aside too). Its torque on the crank is f |x′|, by the work that it takes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property

import numpy as np

from autobalance.declare import ANY, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.engines.cycle.closed_part import Chamber
from autobalance.errors import JobError
from autobalance.running_gear.loads import Loads, lever_shares, loads
from autobalance.running_gear.whole_engine import Engine
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

LARGEST_MU = 1.0
SETTLED = 1e-13
ROUNDS = 200
KNOWN_SPEEDS = 4
"""Speeds whose friction at every angle is kept: some megabytes each."""
M_S_PER_MM_S = 1e-3

PISTON = (
    Key("skirt_mu", float, "friction of the skirt on its wall, by the side force", NOT_NEGATIVE, 0.0),
    Key("boundary_mu", float, "friction of the skirt at zero piston speed; needs `stribeck_speed_m_s`",
        NOT_NEGATIVE, None, usual="`skirt_mu`"),
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


@dataclass(frozen=True, eq=False)
class WallLoads:
    """Forces that press pistons on their walls, by cylinder and crank angle (c, n) [N].

    Attributes
    ----------
    gas_n : (c, n) float
        Force of the gas on each piston.
    steady_n, per_square_n : (c, n) float
        Wall force of gas and weight; of inertia at 1 rad/s.
    """

    gas_n: Array
    steady_n: Array
    per_square_n: Array


@dataclass(frozen=True, eq=False)
class PushedRods:
    """Response of walls and crankpins to 1 N along each cylinder (c, n).

    Attributes
    ----------
    own_n : (c, n) float
        Wall force of the piston itself.
    others_n : (c, c, n) float or None
        Wall force of piston i by a force along cylinder j; None: no rod hangs on another.
    pins_n : (c, 2, n) float
        Load of the crankpin.
    shares : (m, c) float
        Of a load on each crankpin that each main takes.
    """

    own_n: Array
    others_n: Array | None
    pins_n: Array
    shares: Array

    @classmethod
    def of(cls, engine: Engine, mains_z_mm: Sequence[float], angle_rad: Array) -> PushedRods:
        """Return the answers at crank angles (n,) [rad] of an engine without its crank."""
        cylinders = engine.cylinders
        shares = np.stack([lever_shares(each.z_mm, mains_z_mm) for each in cylinders], axis=1)
        pushed = np.ones((len(cylinders), angle_rad.size))
        if all(each.master is None for each in cylinders):
            together = loads(engine, mains_z_mm, 0.0, angle_rad, gas_n=pushed)
            return cls(together.wall_n, None, together.crankpin_n.transpose(0, 2, 1).copy(), shares)
        each_alone = [
            loads(engine, mains_z_mm, 0.0, angle_rad, gas_n=pushed * row[:, None])
            for row in np.eye(len(cylinders))
        ]
        walls = np.stack([each.wall_n for each in each_alone], axis=1)
        own: Array = np.einsum("iin->in", walls).copy()
        pins = np.stack(
            [each.crankpin_n.sum(axis=0) for each in each_alone]
        )  # links and master: one crankpin
        others = walls - own[:, None, :] * np.eye(len(own))[:, :, None]
        return cls(own, others, pins.transpose(0, 2, 1).copy(), shares)

    def walls_n(self, along_n: Array) -> Array:
        """Return the wall forces (c, n) of forces along the cylinders (c, n) [N]."""
        own: Array = self.own_n * along_n
        return own if self.others_n is None else own + np.einsum("ijn,jn->in", self.others_n, along_n)

    def mains_n(self, along_n: Array) -> Array:
        """Return the loads of the mains (m, 2, n) of forces along the cylinders (c, n) [N]."""
        result = np.zeros((len(self.shares), *self.pins_n.shape[1:]))
        for shares, pin_n, force_n in zip(self.shares.T, self.pins_n, along_n, strict=True):
            load = pin_n * force_n
            for main in np.flatnonzero(shares):  # the two beside it
                result[main] += shares[main] * load
        return result

    def at_points(self, points: slice) -> PushedRods:
        """Return the same at some of the angles."""
        others = None if self.others_n is None else self.others_n[..., points]
        own, pins = (
            np.ascontiguousarray(self.own_n[:, points]),
            np.ascontiguousarray(self.pins_n[..., points]),
        )
        return PushedRods(own, others, pins, self.shares)


@dataclass(frozen=True, eq=False)
class PistonFrictionParts:
    """Parts of friction at any speed: wall forces of gas, weight and inertia, and responses to a force.

    Attributes
    ----------
    friction : PistonFriction
    engine : Engine
        Without its crank.
    mains_z_mm : tuple of float
    slope_mm, bend_mm : (c, n) float
        x′ and x″ of the pistons by the crank angle.
    walls : WallLoads
    rods : PushedRods
    rings_n : (c, n) float
        Friction of rings by tension and gas [N].
    piston_g : (c,) float
        Masses of pistons without the rods' small ends.
    """

    friction: PistonFriction
    engine: Engine
    mains_z_mm: tuple[float, ...]
    slope_mm: Array
    bend_mm: Array
    walls: WallLoads
    rods: PushedRods
    rings_n: Array
    piston_g: Array
    known: dict[float, FrictionForces] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        friction: PistonFriction,
        engine: Engine,
        mains_z_mm: tuple[float, ...],
        chambers: Sequence[Chamber],
        angle_rad: Array,
        walls: WallLoads,
    ) -> PistonFrictionParts:
        """Return the parts at crank angles (n,) [rad] of an engine without its crank."""
        motions = [
            each.slider_crank.motion(angle_rad + each.throw_angle_rad - each.bank_rad)
            for each in engine.cylinders
        ]
        around = np.array([math.pi * each.bore_mm for each in chambers])[:, None]
        area = np.array([each.piston_area_mm2 for each in chambers])[:, None]
        pressed = around * friction.ring_height_mm * np.maximum(0.0, walls.gas_n / area)
        return cls(
            friction,
            engine,
            mains_z_mm,
            np.stack([each.dx_mm for each in motions]),
            np.stack([each.ddx_mm for each in motions]),
            walls,
            PushedRods.of(engine, mains_z_mm, angle_rad),
            friction.ring_mu * (friction.ring_tension_n + pressed),
            np.array([each.reciprocating_g - each.small_end_g for each in engine.cylinders]),
        )

    def with_masses_of(self, engine: Engine, walls: WallLoads) -> PistonFrictionParts:
        """Return the parts of an engine that differs by its reciprocating masses alone."""
        piston_g = np.array([each.reciprocating_g - each.small_end_g for each in engine.cylinders])
        return replace(self, engine=engine, walls=walls, piston_g=piston_g, known={})

    def at_points(self, points: slice) -> PistonFrictionParts:
        """Return the same at some of the angles."""

        def some(values: Array) -> Array:
            return np.ascontiguousarray(values[:, points])

        walls = self.walls
        return replace(
            self,
            slope_mm=some(self.slope_mm),
            bend_mm=some(self.bend_mm),
            walls=WallLoads(some(walls.gas_n), some(walls.steady_n), some(walls.per_square_n)),
            rods=self.rods.at_points(points),
            rings_n=some(self.rings_n),
            known={},
        )

    def at(self, speed_rad_s: float) -> FrictionForces:
        """Return the friction at a constant speed."""
        if speed_rad_s not in self.known:
            if len(self.known) >= KNOWN_SPEEDS:  # a sweep asks each speed a few times on end
                self.known.pop(next(iter(self.known)))
            self.known[speed_rad_s] = self._at(speed_rad_s)
        return self.known[speed_rad_s]

    def _at(self, speed_rad_s: float) -> FrictionForces:
        tilt = self._tilt_n_mm(speed_rad_s)
        skirt, rings = self._sizes_n(speed_rad_s)
        along = self._way * (skirt + rings)
        wall = self.bare_walls_n(speed_rad_s) + self.rods.walls_n(along)
        torque = (skirt + rings) * self._steep_mm * N_M_PER_N_MM
        return FrictionForces(skirt, rings, along, wall, torque, tilt * N_M_PER_N_MM)

    def along_n(self, speed_rad_s: float) -> Array:
        """Return friction as forces of gas (c, n) at a constant speed, and nothing else of it [N]."""
        skirt, rings = self._sizes_n(speed_rad_s)
        result: Array = self._way * (skirt + rings)
        return result

    @cached_property
    def _way(self) -> Array:
        """Sign of each piston's motion as the crank turns (c, n)."""
        return np.sign(self.slope_mm)

    @cached_property
    def _steep_mm(self) -> Array:
        """Size of each piston's motion by crank angle (c, n) [mm]."""
        return np.abs(self.slope_mm)

    @cached_property
    def _lean(self) -> Array:
        """Each piston's wall force by 1 N of its friction (c, n)."""
        return self.rods.own_n * self._way

    @cached_property
    def _dry_lean_n(self) -> Array:
        """Each piston's wall force by the friction of its rings without the film's shear (c, n) [N]."""
        return self._lean * self.rings_n

    def bare_walls_n(self, speed_rad_s: float) -> Array:
        """Return the wall forces without friction (c, n) [N]."""
        result: Array = self.walls.steady_n + speed_rad_s**2 * self.walls.per_square_n
        return result

    def _tilt_n_mm(self, speed_rad_s: float) -> Array:
        """Return the moments (c, n) that tilt the pistons about their wrist pins [N·mm]."""
        offset = self.friction.pin_offset_mm
        if not offset:
            return np.zeros_like(self.slope_mm)
        inertia = self.piston_g[:, None] * self.bend_mm * speed_rad_s**2 * N_PER_G_MM_S2
        result: Array = offset * (self.walls.gas_n + inertia)
        return result

    def _sizes_n(self, speed_rad_s: float) -> tuple[Array, Array]:
        """Return the sizes of the skirts' friction and of the rings', (c, n) each [N].

        |N| = |A₁|/(1 − σ W s μ) is exact if no other piston's friction moves its wall force; link rods and
        their master are balanced in turns.
        """
        friction, bare = self.friction, self.bare_walls_n(speed_rad_s)
        mu: Array | float = friction.skirt_mu
        rings, ring_lean = self.rings_n, self._dry_lean_n
        if friction.stribeck_speed_m_s is not None or friction.viscous_n_s_m:
            speed = self._steep_mm * (speed_rad_s * M_S_PER_MM_S)
            mu = mu if friction.stribeck_speed_m_s is None else friction.skirt_mu_at(speed)
            if friction.viscous_n_s_m:
                rings = rings + friction.viscous_n_s_m * speed
                ring_lean = self._lean * rings
        length = friction.skirt_length_mm
        least = None if length is None else 2.0 / length * np.abs(self._tilt_n_mm(speed_rad_s))
        skirt = self._skirts_n(bare + ring_lean, mu, least)
        if self.rods.others_n is None:
            return skirt, rings
        for _ in range(ROUNDS):
            pushed = np.einsum("ijn,jn->in", self.rods.others_n, self._way * (skirt + rings))
            found = self._skirts_n(bare + ring_lean + pushed, mu, least)
            change = float(np.abs(found - skirt).max(initial=0.0))
            skirt = found
            if change <= SETTLED * float(np.abs(bare).max(initial=1.0)):
                break
        return skirt, rings

    def _skirts_n(self, pushed: Array, mu: Array | float, least: Array | None) -> Array:
        """Return the skirts' friction (c, n) with wall forces of everything except their own friction [N]."""
        lean = self._lean * mu
        facing = np.abs(pushed) / (1.0 - np.sign(pushed) * lean)
        if least is not None:  # a tilted piston presses with both ends
            facing = np.maximum(np.abs(pushed + lean * np.maximum(facing, least)), least)
        result: Array = mu * facing
        return result

    def mains_n(self, speed_rad_s: float) -> Complex:
        """Return the loads of the mains (m, n) by friction at a speed, x + iy [N]."""
        mains = self.rods.mains_n(self.at(speed_rad_s).along_n)
        result: Complex = mains[:, 0] + 1j * mains[:, 1]
        return result

    def pin_roll_n_m(self, speed_rad_s: float, *, clockwise: bool) -> Array:
        """Return d m ẍ of all pistons (n,): what they roll the block less than masses on their pins [N·m].

        A piston's mass moves on its own line, ``pin_offset_mm`` beside that of the wrist pin.
        """
        offset = -self.friction.pin_offset_mm if clockwise else self.friction.pin_offset_mm
        bend = (self.piston_g[:, None] * self.bend_mm).sum(axis=0)
        result: Array = offset * bend * speed_rad_s**2 * N_M_PER_G_MM2_S2
        return result

    def loads(self, angle_rad: Array, speed_rad_s: float) -> Loads:
        """Return all loads by friction at a speed, at the angles of its parts."""
        return loads(self.engine, self.mains_z_mm, 0.0, angle_rad, gas_n=self.at(speed_rad_s).along_n)

    def equivalent_inertia_g_mm2(self, angle_rad: Array, speed_rad_s: float) -> Array:
        """Return the inertia that friction adds to the crank, ∂(f |x′|)/∂θ̈ (n,) [g·mm²].

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
            found = mu * (swung + self.rods.walls_n(way * rate))
            change = float(np.abs(found - rate).max(initial=0.0))
            rate = found
            if change <= SETTLED * float(np.abs(swung).max(initial=0.0)):
                break
        torque = (rate * np.abs(self.slope_mm)).sum(axis=0) * N_M_PER_N_MM
        result: Array = torque / N_M_PER_G_MM2_S2
        return result
