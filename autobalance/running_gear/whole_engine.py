"""Whole engines: any number of cylinders on any crank, and what shakes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, TypeVar

import numpy as np

from autobalance.declare import UNWRITTEN, Angle, NotNegative, Ordinal, Positive, derived, record
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.articulated import LinkCrank
from autobalance.running_gear.parts import Parts
from autobalance.running_gear.slider_crank import Motion, SliderCrank
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM, N_PER_G_MM_S2, wrapped_deg
from autobalance.value_classes import dataclass

# Whole engines: any number of cylinders on any crank, and what shakes them, order by order.
#
# The engine's frame is the rotor's at crank angle θ = 0: z is the crank axis, the crank turns from x towards
# y. Firing order does not affect inertia forces. A moment of forces is given as Σ z F (about z = 0), a
# vector in the direction of the forces, as unbalance moments are. It rocks the engine about the axis at
# right angles to it.


Generic = TypeVar("Generic", Array, Complex)
MIRROR = np.array([1.0, -1.0])
"""Angle of a vector (x, y) in the x–z plane."""


@dataclass(frozen=True)
class Cylinder:
    """A cylinder with its piston and rod, and the throw that it works on.

    Attributes
    ----------
    slider_crank : SliderCrank
    rotating_g, reciprocating_g : float
        Of its rod and piston [g].
    throw_angle_rad : float
        Of its crankpin in the rotor frame [rad].
    bank_rad : float
        Direction from the crank axis to the cylinder in the engine's frame, from x towards y [rad].
    z_mm : float
        Place of its rod on the crank axis [mm].
    small_end_g : float
        Share of ``reciprocating_g`` that belongs to the rod, so that the wrist pin does not carry it [g].
    couple_inertia_g_mm2 : float
        Inertia of the rod that its two masses miss, I − m a b [g·mm²].
    master : int or None
        Number from 0 of the cylinder whose rod carries this one's on a knuckle pin.
    """

    slider_crank: SliderCrank
    rotating_g: float
    reciprocating_g: float
    throw_angle_rad: float = 0.0
    bank_rad: float = 0.0
    z_mm: float = 0.0
    small_end_g: float = 0.0
    couple_inertia_g_mm2: float = 0.0
    master: int | None = None

    def __post_init__(self) -> None:
        Parts(self.rotating_g, self.reciprocating_g, 0.0)  # refuses negative masses
        if not 0.0 <= self.small_end_g <= self.reciprocating_g:
            raise ValueError(
                f"the rod's small end weighs {self.small_end_g:g} g; must be between 0 and the reciprocating"
                f" mass, {self.reciprocating_g:g} g"
            )

    @property
    def crankpin_direction(self) -> Array:
        """Unit vector (2,) from the crank axis to the crankpin in the rotor frame."""
        return np.array([math.cos(self.throw_angle_rad), math.sin(self.throw_angle_rad)])

    @property
    def direction(self) -> Array:
        """Unit vector (2,) along the cylinder, away from the crank, in the engine's frame."""
        return np.array([math.cos(self.bank_rad), math.sin(self.bank_rad)])

    def in_engine(self, vectors: Generic) -> Generic:
        """Return vectors (..., 2) of the cylinder's axes in the engine's frame."""
        cosine, sine = self.direction
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)

    def bob_weight_product_g_mm(self, factor: float) -> float:
        """Return (m_rot + f m_rec) r of this cylinder alone [g·mm]."""
        return (self.rotating_g + factor * self.reciprocating_g) * self.slider_crank.crank_radius_mm


@dataclass(frozen=True, eq=False)
class CrankUnbalance:
    """Unbalance (2,) [g·mm] and mass of a piece of the crank at ``z_mm``, in the rotor frame.

    The mass is 0 where it is not known; only the crank's weight needs it.
    """

    unbalance_g_mm: Array
    z_mm: float
    mass_g: float = 0.0


@dataclass(frozen=True, eq=False)
class ForceOrder:
    """Force and moment of one order: real part of amplitude times exp(i order θ).

    ``force_n`` (2,) complex along x and y; ``moment_n_m`` (2,) complex, Σ z F about z = 0.
    """

    order: NotNegative
    force_n: Annotated[Complex, UNWRITTEN]
    moment_n_m: Annotated[Complex, UNWRITTEN]

    @property
    def circles_n(self) -> tuple[float, float]:
        """Radii of the forward and the backward rotating part of the force [N]."""
        return _circles(self.force_n)

    @property
    def moment_circles_n_m(self) -> tuple[float, float]:
        """Radii of the forward and the backward rotating part of the moment [N·m]."""
        return _circles(self.moment_n_m)

    @derived
    def force_x_n(self) -> NotNegative:
        """Amplitude along x [N]."""
        return float(abs(self.force_n[0]))

    @derived
    def force_y_n(self) -> NotNegative:
        """Amplitude along y [N]."""
        return float(abs(self.force_n[1]))

    @derived
    def greatest_force_n(self) -> NotNegative:
        """Largest magnitude over a turn [N]."""
        return sum(_circles(self.force_n))

    @derived
    def forward_n(self) -> NotNegative:
        """Radius of the force's part that turns with the crank [N]."""
        return _circles(self.force_n)[0]

    @derived
    def backward_n(self) -> NotNegative:
        """Radius of the force's part that turns against the crank [N]."""
        return _circles(self.force_n)[1]

    @derived
    def moment_x_n_m(self) -> NotNegative:
        """Amplitude of Σ z Fx [N·m]."""
        return float(abs(self.moment_n_m[0]))

    @derived
    def moment_y_n_m(self) -> NotNegative:
        """Amplitude of Σ z Fy [N·m]."""
        return float(abs(self.moment_n_m[1]))

    @derived
    def greatest_moment_n_m(self) -> NotNegative:
        """Largest magnitude over a turn [N·m]."""
        return sum(_circles(self.moment_n_m))


def about(orders: Sequence[ForceOrder], z_mm: float) -> list[ForceOrder]:
    """Return orders with their moments about another place of the axis, M − z F; forces stay."""
    return [
        replace(order, moment_n_m=order.moment_n_m - z_mm * N_M_PER_N_MM * order.force_n) for order in orders
    ]


def _circles(amplitude: Complex) -> tuple[float, float]:
    x, y = amplitude
    return float(abs(x + 1j * y)) / 2.0, float(abs(x - 1j * y)) / 2.0


@dataclass(frozen=True, eq=False)
class Engine:
    """Cylinders on a crank.

    Attributes
    ----------
    cylinders : tuple of Cylinder
    crank : tuple of CrankUnbalance
        All that turns with the crank, rods left out: counterweights, crankpins, what is bolted on.
    polar_inertia_g_mm2 : float
        Of all that turns with the crank, rods left out, about the crank axis [g·mm²].
    clockwise : bool
        Whether this is the mirror image of an engine that turns clockwise, seen from +z.
    """

    cylinders: tuple[Cylinder, ...]
    crank: tuple[CrankUnbalance, ...] = ()
    polar_inertia_g_mm2: float = 0.0
    clockwise: bool = False

    def mirrored(self) -> Engine:
        """Return the engine as a mirror in its x–z plane shows it, in which it turns the other way.

        Everything here turns counter-clockwise; an engine that turns clockwise is computed as its mirror
        image, and y components are turned back where they are shown (``shown``).
        """
        cylinders = tuple(
            replace(
                each,
                slider_crank=each.slider_crank.mirrored(),
                throw_angle_rad=0.0 - each.throw_angle_rad,
                bank_rad=0.0 - each.bank_rad,
            )
            for each in self.cylinders
        )
        crank = tuple(replace(each, unbalance_g_mm=each.unbalance_g_mm * MIRROR) for each in self.crank)
        return Engine(cylinders, crank, self.polar_inertia_g_mm2, not self.clockwise)

    def shown(self, vectors: Array) -> Array:
        """Return vectors (..., 2) of this engine's computation in the engine's own frame."""
        return vectors * MIRROR if self.clockwise else vectors

    @property
    def rotating(self) -> Unbalance:
        """Unbalance of the crank with the rotating parts of its rods."""
        points = [(piece.unbalance_g_mm, piece.z_mm) for piece in self.crank]
        points += [
            (cylinder.bob_weight_product_g_mm(0.0) * cylinder.crankpin_direction, cylinder.z_mm)
            for cylinder in self.cylinders
        ]
        return _summed(points)

    def with_counterweights(self, factor: float) -> Engine:
        """Return this engine with a crank that is balanced throw by throw for a balance factor.

        Each crankpin has its counterweight in its own plane, opposite.
        """
        crank = tuple(
            CrankUnbalance(
                -cylinder.bob_weight_product_g_mm(factor) * cylinder.crankpin_direction, cylinder.z_mm
            )
            for cylinder in self.cylinders
        )
        return replace(self, crank=crank)

    def orders(self, speed_rad_s: float, highest: int = 8) -> list[ForceOrder]:
        """Return force and moment of the orders ½, 1, 1½ … ``highest``.

        Half orders are zero: inertia repeats every turn. They are in the list because gas does not.
        """
        force, moment = self._amplitudes(highest)
        square = speed_rad_s**2
        nothing = np.zeros(2, dtype=np.complex128)
        orders: list[ForceOrder] = []
        for order in range(1, highest + 1):
            orders.append(ForceOrder(order - 0.5, nothing, nothing))
            orders.append(
                ForceOrder(
                    float(order),
                    force[order] * square * N_PER_G_MM_S2,
                    moment[order] * square * N_M_PER_G_MM2_S2,
                )
            )
        return orders

    def _amplitudes(self, highest: int) -> tuple[Complex, Complex]:
        """Force and moment over ω² by order, (highest + 1, 2) each [g·mm, g·mm²]."""
        force = np.zeros((highest + 1, 2), dtype=np.complex128)
        moment = np.zeros_like(force)
        order = np.arange(highest + 1)
        for cylinder in self.cylinders:
            product = cylinder.reciprocating_g * cylinder.slider_crank.crank_radius_mm
            phase = np.exp(1j * order * (cylinder.throw_angle_rad - cylinder.bank_rad))
            share = product * cylinder.slider_crank.harmonics(highest) * phase
            share = share[:, None] * cylinder.direction
            if isinstance(cylinder.slider_crank, LinkCrank):
                beside = cylinder.slider_crank.knuckle_harmonics_mm(highest) * phase[:, None]
                share = share + cylinder.rotating_g * cylinder.in_engine(beside)
            force += share
            moment += cylinder.z_mm * share
        rotating = self.rotating
        force[1] += _turning(rotating.resultant_g_mm)
        moment[1] += _turning(rotating.moment_g_mm2)
        return force, moment

    def moment_n_m(self, angle_rad: Array, speed_rad_s: float, z_mm: float = 0.0) -> Array:
        """Return the moment Σ (z − z₀) F (..., 2) about a place of the axis, all orders [N·m]."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        total = _turned(self.rotating.moment_about_g_mm2(z_mm), angle)
        for cylinder in self.cylinders:
            motion = cylinder.slider_crank.motion(angle + cylinder.throw_angle_rad - cylinder.bank_rad)
            force = (cylinder.reciprocating_g * motion.ddx_mm)[..., None] * cylinder.direction
            total -= (cylinder.z_mm - z_mm) * (force + _beside_the_crankpin(cylinder, motion))
        result: Array = total * speed_rad_s**2 * N_M_PER_G_MM2_S2
        return result

    def force_n(self, angle_rad: Array, speed_rad_s: float) -> Array:
        """Return the force (..., 2) that shakes the engine, all orders, at constant speed [N]."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        total = _turned(self.rotating.resultant_g_mm, angle)
        for cylinder in self.cylinders:
            motion = cylinder.slider_crank.motion(angle + cylinder.throw_angle_rad - cylinder.bank_rad)
            total -= (cylinder.reciprocating_g * motion.ddx_mm)[..., None] * cylinder.direction
            total -= _beside_the_crankpin(cylinder, motion)
        result: Array = total * speed_rad_s**2 * N_PER_G_MM_S2
        return result


def _beside_the_crankpin(cylinder: Cylinder, motion: Motion) -> Array | float:
    """Return m_rot (k″ − c″) of a link's big end (..., 2), which is off the crankpin's circle; else 0."""
    if motion.knuckle is None:
        return 0.0
    radius = cylinder.slider_crank.crank_radius_mm
    off = motion.knuckle.second + radius * (motion.crank_cosine + 1j * motion.crank_sine)
    return cylinder.rotating_g * cylinder.in_engine(np.stack([off.real, off.imag], axis=-1))


def _summed(points: Sequence[tuple[Array, float]]) -> Unbalance:
    resultant = sum((unbalance for unbalance, _ in points), np.zeros(2))
    moment = sum((z * unbalance for unbalance, z in points), np.zeros(2))
    return Unbalance(resultant, moment)


def _turning(vector: Array) -> Complex:
    """Complex amplitudes (2,) of a vector that turns with the crank."""
    both = complex(vector[0], vector[1])
    return np.array([both, -1j * both])


def _turned(vector: Array, angle_rad: Array) -> Array:
    """Vector (2,) of the rotor frame in the engine's frame at every crank angle (..., 2)."""
    turned = complex(vector[0], vector[1]) * np.exp(1j * angle_rad)
    return np.stack([turned.real, turned.imag], axis=-1)


def inline(
    throw_angles_rad: Sequence[float],
    pitch_mm: float,
    slider_crank: SliderCrank,
    parts: Parts,
) -> Engine:
    """Return an inline engine; cylinders at equal pitch about z = 0, the crank not yet balanced.

    Examples
    --------
    >>> four = inline([0.0, math.pi, math.pi, 0.0], 90.0, SliderCrank(43.0, 140.0), Parts(500.0, 450.0, 0.0))
    >>> [round(order.greatest_force_n) for order in four.orders(600.0) if order.order in (1.0, 2.0)]
    [0, 8770]
    """
    return vee(throw_angles_rad, pitch_mm, [0.0], slider_crank, parts)


def vee(
    throw_angles_rad: Sequence[float],
    pitch_mm: float,
    banks_rad: Sequence[float],
    slider_crank: SliderCrank,
    parts: Parts,
    rod_pitch_mm: float = 0.0,
) -> Engine:
    """Return an engine with one cylinder of each bank on every throw; inline for one bank.

    Parameters
    ----------
    throw_angles_rad : sequence of float
        Of each crankpin in the rotor frame, along increasing z [rad].
    pitch_mm : float
        From throw to throw [mm].
    banks_rad : sequence of float
        Directions of the cylinders, −π/4 and π/4 for a 90° V [rad].
    slider_crank, parts
        Of every cylinder; ``parts.crankpin_g`` is of every throw.
    rod_pitch_mm : float
        From rod to rod on one crankpin [mm].
    """
    if not throw_angles_rad or not banks_rad:
        raise ValueError("throw angles and bank angles are missing; an engine needs at least one of each")
    first = -0.5 * pitch_mm * (len(throw_angles_rad) - 1)
    first_rod = -0.5 * rod_pitch_mm * (len(banks_rad) - 1)
    cylinders: list[Cylinder] = []
    crank: list[CrankUnbalance] = []
    for number, angle in enumerate(throw_angles_rad):
        z = first + number * pitch_mm
        direction = np.array([math.cos(angle), math.sin(angle)])
        crank.append(CrankUnbalance(parts.crankpin_g * slider_crank.crank_radius_mm * direction, z))
        cylinders += [
            Cylinder(
                slider_crank,
                parts.rotating_g,
                parts.reciprocating_g,
                throw_angle_rad=angle,
                bank_rad=bank,
                z_mm=z + first_rod + rod * rod_pitch_mm,
            )
            for rod, bank in enumerate(banks_rad)
        ]
    return Engine(tuple(cylinders), tuple(crank))


# Strokes and dead centres of an engine's cylinders, and the counterweight that its first order asks for.


@record
class DeadCentres:
    """Stroke of a cylinder and where its piston turns; crank angles count in the sense of turning."""

    number: Ordinal
    stroke_mm: Positive
    top_dead_centre_deg: Angle
    bottom_dead_centre_deg: Angle


@record
class FirstOrderCounterweight:
    """Unbalance of the crank against the forward first order, and the backward part that stays.

    Of rods and pistons alone; the angle is that of the counterweight on the crank.
    """

    product_g_mm: NotNegative
    angle_deg: Angle
    backward_g_mm: NotNegative


def dead_centres(engine: Engine) -> list[DeadCentres]:
    """Return stroke and dead centres of each cylinder."""
    centres = []
    for number, each in enumerate(engine.cylinders, 1):
        lead = each.bank_rad - each.throw_angle_rad
        top, bottom = (wrapped_deg(math.degrees(at + lead)) for at in each.slider_crank.dead_centres_rad)
        centres.append(
            DeadCentres(
                number=number,
                stroke_mm=each.slider_crank.stroke_mm,
                top_dead_centre_deg=top,
                bottom_dead_centre_deg=bottom,
            )
        )
    return centres


def first_order_counterweight(engine: Engine) -> FirstOrderCounterweight:
    """Return the counterweight for the forward first order of an engine's rods and pistons."""
    order = Engine(engine.cylinders).orders(1.0, 1)[-1].force_n / N_PER_G_MM_S2
    forward, backward = 0.5 * (order[0] + 1j * order[1]), 0.5 * (order[0] - 1j * order[1])
    angle = math.degrees(math.atan2(forward.imag, forward.real))
    return FirstOrderCounterweight(
        product_g_mm=float(abs(forward)),
        angle_deg=wrapped_deg(180.0 + (-angle if engine.clockwise else angle)),
        backward_g_mm=float(abs(backward)),
    )
