"""Link rods on the pins of a master rod: exact kinematics, and what they put on their master.

A link's big end turns on a knuckle pin that the master rod carries. In the link's own axes (X along its
cylinder) the crankpin is at ψ, the master's cylinder at δ, and the master rod leans by β from its own::

    knuckle   k = r (cos ψ, sin ψ) + ρ (cos a, sin a),   a = δ + β(ψ − δ) + γ
    piston    x = k_x + √(l² − (k_y − e)²)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from autobalance.running_gear.slider_crank import KnuckleMotion, Motion, SliderCrank
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

UNIT = SliderCrank(1.0, 4.0)
LOOKED_AT = 720
"""Crank angles between which dead centres are searched for."""
SAMPLES = 4096


@dataclass(frozen=True)
class LinkCrank(SliderCrank):
    """The crank train of a cylinder whose rod hangs on a master rod.

    Attributes
    ----------
    crank_radius_mm, rod_length_mm, offset_mm : float
        Of the crank, the link rod and the link's cylinder [mm].
    master : SliderCrank
        Crank and rod of the master's cylinder.
    master_bank_rad : float
        Direction of the master's cylinder from the link's [rad].
    knuckle_radius_mm : float
        Distance from the crankpin to the knuckle pin [mm].
    knuckle_rad : float
        Of the knuckle pin about the crankpin, from the master rod's axis [rad].

    Examples
    --------
    >>> link = LinkCrank(50.0, 160.0, 0.0, SliderCrank(50.0, 200.0), -2.0944, 40.0, 2.0944)
    >>> round(link.stroke_mm, 3)
    100.374
    """

    master: SliderCrank = UNIT
    master_bank_rad: float = 0.0
    knuckle_radius_mm: float = 0.0
    knuckle_rad: float = 0.0

    def __post_init__(self) -> None:
        reach = self.knuckle_radius_mm + self.crank_radius_mm + abs(self.offset_mm)
        if not 0.0 < self.crank_radius_mm < math.inf:
            raise ValueError(f"crank radius is {self.crank_radius_mm:g} mm; must be > 0")
        if self.knuckle_radius_mm < 0.0:
            raise ValueError(f"knuckle radius is {self.knuckle_radius_mm:g} mm; must be ≥ 0")
        angle = 2.0 * math.pi * np.arange(LOOKED_AT) / LOOKED_AT
        across = self._knuckle(angle)[0].imag - self.offset_mm
        if not float(np.abs(across).max()) < self.rod_length_mm < math.inf:
            raise ValueError(
                f"link rod length is {self.rod_length_mm:g} mm; must be more than the reach of its knuckle"
                f" pin across the cylinder, {float(np.abs(across).max()):.4g} mm of at most {reach:g} mm"
            )

    def mirrored(self) -> SliderCrank:
        """Return the train as a mirror along its cylinder shows it."""
        return replace(
            self,
            offset_mm=0.0 - self.offset_mm,
            master=self.master.mirrored(),
            master_bank_rad=0.0 - self.master_bank_rad,
            knuckle_rad=0.0 - self.knuckle_rad,
        )

    def _knuckle(self, angle: Array) -> tuple[Complex, Complex, Complex]:
        """Return the knuckle pin x + iy and its first two derivatives by the crank angle [mm]."""
        lean = self.master.motion(angle - self.master_bank_rad)
        arm = self.knuckle_radius_mm * np.exp(1j * (self.master_bank_rad + self.knuckle_rad))
        arm = arm * (lean.rod_cosine + 1j * lean.rod_sine)
        pin = self.crank_radius_mm * np.exp(1j * angle)
        first = 1j * pin + 1j * lean.dtilt * arm
        second = -pin + (1j * lean.ddtilt - lean.dtilt**2) * arm
        return np.asarray(pin + arm), np.asarray(first), np.asarray(second)

    def motion(self, angle_rad: Array) -> Motion:
        """Return position, rod angle, knuckle pin and their derivatives by the crank angle, exactly."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        pin, pin_1, pin_2 = self._knuckle(angle)
        length = self.rod_length_mm
        rise = (self.offset_mm - pin.imag) / length
        run = np.sqrt(1.0 - rise * rise)
        tilt_1 = -pin_1.imag / (length * run)
        tilt_2 = (-pin_2.imag / length + rise * tilt_1 * tilt_1) / run
        return Motion(
            x_mm=pin.real + length * run,
            dx_mm=pin_1.real - length * rise * tilt_1,
            ddx_mm=pin_2.real - length * (run * tilt_1 * tilt_1 + rise * tilt_2),
            rod_cosine=run,
            rod_sine=rise,
            dtilt=tilt_1,
            ddtilt=tilt_2,
            crank_cosine=np.cos(angle),
            crank_sine=np.sin(angle),
            knuckle=KnuckleMotion(pin, pin_1, pin_2),
        )

    @cached_property
    def _dead_centres(self) -> tuple[float, float]:
        """Return angles of the piston's farthest and nearest place: top in (−π, π], then bottom after it."""
        from scipy.optimize import brentq

        step = 2.0 * math.pi / LOOKED_AT
        angle = np.asarray(step * np.arange(LOOKED_AT), dtype=np.float64)
        place = self.position_mm(angle)

        def speed(at: float) -> float:
            return float(self.motion(np.array(at)).dx_mm)

        angles = []
        for at in (int(place.argmax()), int(place.argmin())):
            low, high = angle[at] - step, angle[at] + step
            angles.append(float(brentq(speed, low, high, xtol=1e-14, rtol=1e-15)))
        top = (angles[0] + math.pi) % (2.0 * math.pi) - math.pi
        return top, top + (angles[1] - top) % (2.0 * math.pi)

    @property
    def dead_centres_rad(self) -> tuple[float, float]:
        """Crank angles of top dead centre and of the bottom one after it, from the cylinder [rad]."""
        return self._dead_centres

    @property
    def farthest_mm(self) -> float:
        """Distance of the wrist pin from the crank axis at top dead centre [mm]."""
        return float(self.position_mm(np.array(self._dead_centres[0])))

    @property
    def stroke_mm(self) -> float:
        """Travel between the dead centres [mm]."""
        return self.farthest_mm - float(self.position_mm(np.array(self._dead_centres[1])))

    def harmonics(self, highest: int) -> Complex:
        """Return the harmonics of the acceleration over r ω² (highest + 1,), by a Fourier transform."""
        coefficients: Complex = fourier(self.position_mm, highest) * np.arange(highest + 1) ** 2
        return np.asarray(coefficients / self.crank_radius_mm, dtype=np.complex128)

    def lever_mm(self, angle_rad: Array) -> Array:
        """Return the torque about the crank axis of 1 N on the piston towards the crank [N·mm/N].

        From forces: the link pulls the knuckle pin, the master's wall keeps the master rod from turning.
        """
        angle = np.asarray(angle_rad, dtype=np.float64)
        motion, lean = self.motion(angle), self.master.motion(angle - self.master_bank_rad)
        pin = self.crank_radius_mm * np.exp(1j * angle)
        pull = -1.0 - 1j * motion.rod_sine / motion.rod_cosine
        arm = self._knuckle(angle)[0] - pin
        moment = (arm.conj() * pull).imag
        wall = -moment / (self.master.rod_length_mm * lean.rod_cosine)
        whole = pull + wall * 1j * np.exp(1j * self.master_bank_rad)
        return np.asarray((pin.conj() * whole).imag)

    def knuckle_harmonics_mm(self, highest: int) -> Complex:
        """Return the orders (highest + 1, 2) of what turns the knuckle pin beside the crankpin's circle.

        Real part of amplitude × exp(i k ψ) is −(k″ − c″) in the link's axes [mm].
        """

        def beside(angle: Array) -> Complex:
            off: Complex = self._knuckle(angle)[0] - self.crank_radius_mm * np.exp(1j * angle)
            return off

        both = (
            fourier(lambda a: np.asarray(beside(a).real), highest),
            fourier(lambda a: np.asarray(beside(a).imag), highest),
        )
        square = np.arange(highest + 1.0) ** 2
        return np.asarray(np.stack(both, axis=-1) * square[:, None], dtype=np.complex128)


def fourier(function: Callable[[Array], Array], highest: int) -> Complex:
    """Return the complex amplitudes (highest + 1,) of a periodic function of the crank angle."""
    angle = 2.0 * math.pi * np.arange(SAMPLES) / SAMPLES
    values = function(angle)
    return np.asarray(np.fft.rfft(values)[: highest + 1] * (2.0 / SAMPLES), dtype=np.complex128)
