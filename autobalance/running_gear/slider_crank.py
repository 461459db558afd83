r"""The slider-crank: exact motion of the piston, and its harmonics to any order.

Axes: the crank turns counter-clockwise about the origin by θ from the cylinder's direction X. The piston
moves along X, shifted sideways by ``offset_mm`` along Y::

        Y
        |      A (crankpin)
        |     / \___ rod, length l
        |  r /      \___
        |   / θ         \___
        O--+----------------P------> X      P = (x, offset)

x = r cos θ + √(l² − (r sin θ − e)²). An offset of the wrist pin in the piston does the same as one of the
cylinder: only the distance of the wrist pin's path from the crank axis counts.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

SAMPLES = 4096
"""Angles a turn for harmonics of an offset slider-crank; they fall off as λᵏ, so more only add rounding."""


@dataclass(frozen=True)
class SliderCrank:
    """Crank, connecting rod and piston of one cylinder.

    Attributes
    ----------
    crank_radius_mm : float
        Half the stroke if there is no offset [mm].
    rod_length_mm : float
        Between the centres of its eyes [mm].
    offset_mm : float
        Of the wrist pin's path from the crank axis, towards Y [mm].

    Examples
    --------
    >>> crank = SliderCrank(crank_radius_mm=44.9, rod_length_mm=152.0)
    >>> round(crank.ratio, 4), round(crank.stroke_mm, 1)
    (0.2954, 89.8)
    """

    crank_radius_mm: float
    rod_length_mm: float
    offset_mm: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.crank_radius_mm < math.inf:
            raise ValueError(f"crank radius is {self.crank_radius_mm:g} mm; must be > 0")
        least = self.crank_radius_mm + abs(self.offset_mm)
        if not least < self.rod_length_mm < math.inf:
            raise ValueError(
                f"rod length is {self.rod_length_mm:g} mm; must be more than crank radius and offset"
                f" together, {least:g} mm"
            )

    @property
    def ratio(self) -> float:
        """λ = r/l, below 1."""
        return self.crank_radius_mm / self.rod_length_mm

    def position_mm(self, angle_rad: Array) -> Array:
        """Return the distance x of the wrist pin from the crank axis along the cylinder [mm]."""
        return self.motion(angle_rad).x_mm

    def motion(self, angle_rad: Array) -> Motion:
        """Return position, rod angle and their first two derivatives by the crank angle, exactly.

        Parameters
        ----------
        angle_rad : (...) float
            Crank angle from the cylinder's direction [rad].

        Returns
        -------
        Motion
            Arrays of the same shape.

        Examples
        --------
        >>> import numpy as np
        >>> crank = SliderCrank(0.5, 2.0)
        >>> travel = crank.position_mm(np.array(0.0)) - crank.position_mm(np.array(np.pi / 2))
        >>> round(float(travel), 4)  # Hoem & Røsholm 2016, Fig. 2.4
        0.5635
        """
        r, length = self.crank_radius_mm, self.rod_length_mm
        angle = np.asarray(angle_rad, dtype=np.float64)
        cosine, sine = np.cos(angle), np.sin(angle)
        rise = (self.offset_mm - r * sine) / length  # sin β of the rod, from crankpin to wrist pin
        run = np.sqrt(1.0 - rise * rise)  # cos β
        tilt_1 = -(r / length) * cosine / run
        tilt_2 = ((r / length) * sine + rise * tilt_1 * tilt_1) / run
        return Motion(
            x_mm=r * cosine + length * run,
            dx_mm=-r * sine - length * rise * tilt_1,
            ddx_mm=-r * cosine - length * (run * tilt_1 * tilt_1 + rise * tilt_2),
            rod_cosine=run,
            rod_sine=rise,
            dtilt=tilt_1,
            ddtilt=tilt_2,
            crank_cosine=cosine,
            crank_sine=sine,
        )

    @property
    def dead_centres_rad(self) -> tuple[float, float]:
        """Crank angles at which rod and crank are in line: top in [−π/2, π/2], then bottom [rad].

        Examples
        --------
        >>> top, bottom = SliderCrank(44.9, 152.0, 10.0).dead_centres_rad
        >>> round(math.degrees(top), 3), round(math.degrees(bottom), 3)
        (2.911, 185.358)
        """
        r, length, e = self.crank_radius_mm, self.rod_length_mm, self.offset_mm
        return math.asin(e / (length + r)), math.pi + math.asin(e / (length - r))

    @property
    def farthest_mm(self) -> float:
        """Distance of the wrist pin from the crank axis at top dead centre [mm]."""
        return math.sqrt((self.rod_length_mm + self.crank_radius_mm) ** 2 - self.offset_mm**2)

    def mirrored(self) -> SliderCrank:
        """Return the train as a mirror along its cylinder shows it."""
        return SliderCrank(self.crank_radius_mm, self.rod_length_mm, 0.0 - self.offset_mm)

    @property
    def stroke_mm(self) -> float:
        """Travel between the dead centres; more than 2 r with an offset [mm]."""
        r, length, e = self.crank_radius_mm, self.rod_length_mm, self.offset_mm
        return math.sqrt((length + r) ** 2 - e * e) - math.sqrt((length - r) ** 2 - e * e)

    @property
    def greatest_speed_angles_rad(self) -> tuple[float, float]:
        """Crank angles of largest piston speed, on the way down and on the way up [rad].

        The exact zeros of the acceleration. The usual 77° for a rod of twice the stroke is that of two
        harmonics; exact is 76.72°.

        Examples
        --------
        >>> down, up = SliderCrank(1.0, 4.0).greatest_speed_angles_rad
        >>> round(math.degrees(down), 2), round(math.degrees(up), 2)
        (76.72, 283.28)
        """
        from scipy.optimize import brentq

        def acceleration(angle: float) -> float:
            return float(self.motion(np.array(angle)).ddx_mm)

        top, bottom = self.dead_centres_rad
        down = brentq(acceleration, top, bottom, xtol=1e-14)
        up = brentq(acceleration, bottom, top + 2.0 * math.pi, xtol=1e-14)
        return float(down), float(up)

    def harmonics(self, highest: int) -> Complex:
        """Return the harmonics of the acceleration over r ω², at constant speed.

        −ẍ/(r ω²) = Re Σ cₖ exp(i k θ). Without offset c₁ = 1, c₂ = A₂, c₄ = −A₄, c₆ = A₆, … and the other odd
        ones are zero, from the series; with an offset from a Fourier transform of the exact position.

        Parameters
        ----------
        highest : int
            Highest order wanted.

        Returns
        -------
        (highest + 1,) complex
            cₖ at index k; c₀ is zero.
        """
        orders = np.arange(highest + 1)
        if self.offset_mm == 0.0:
            coefficients = np.zeros(highest + 1, dtype=np.complex128)
            coefficients[1:2] = 1.0
            for order in orders[2::2]:
                coefficients[order] = (-1.0) ** (order // 2 + 1) * harmonic_coefficient(
                    int(order), self.ratio
                )
            return coefficients
        samples = max(SAMPLES, 4 * highest)
        position = self.position_mm(2.0 * math.pi * np.arange(samples) / samples)
        spectrum = np.fft.rfft(position)[: highest + 1] * (2.0 / samples)
        result: Complex = spectrum * orders**2 / self.crank_radius_mm
        return result


@dataclass(frozen=True, eq=False)
class Motion:
    """A slider-crank over the crank angle; primes are derivatives by the crank angle.

    At crank speed ω and angular acceleration ω̇ the piston's speed is x′ ω, its acceleration x″ ω² + x′ ω̇.
    The rod leans by β: ``rod_cosine``, ``rod_sine`` are the direction from crankpin to wrist pin.
    """

    x_mm: Array
    dx_mm: Array
    ddx_mm: Array
    rod_cosine: Array
    rod_sine: Array
    dtilt: Array
    ddtilt: Array
    crank_cosine: Array
    crank_sine: Array
    knuckle: KnuckleMotion | None = None


@dataclass(frozen=True, eq=False)
class KnuckleMotion:
    """The pin of a link rod's big end x + iy in its cylinder's axes, with derivatives by the angle [mm]."""

    place: Complex
    first: Complex
    second: Complex


@dataclass(frozen=True)
class SeriesTerm:
    """A term of a harmonic's power series in λ = r/l: an exact fraction."""

    power: int
    numerator: int
    denominator: int

    @property
    def coefficient(self) -> float:
        """The fraction, rounded once."""
        return self.numerator / self.denominator


def harmonic_series(order: int, terms: int = 4) -> tuple[SeriesTerm, ...]:
    """Return the power series of an even order's coefficient in λ, as exact fractions.

    ``A₂ⱼ = 8 j² Σ |C(½, k)| 4⁻ᵏ C(2k, k − j) λ^(2k−1)``, k from j; all are positive.

    Parameters
    ----------
    order : int
        Even, from 2.
    terms : int
        How many.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.1.1 (9/128, printed 9/28).

    Examples
    --------
    >>> [(each.power, each.numerator, each.denominator) for each in harmonic_series(6, 2)]
    [(5, 9, 128), (7, 45, 512)]
    """
    _check_order(order)
    j = order // 2
    series = []
    half = Fraction(1)  # |C(½, k)|
    for k in range(1, j + terms):
        half *= abs(Fraction(1, 2) - (k - 1)) / k
        if k >= j:
            share = 8 * j * j * half * Fraction(math.comb(2 * k, k - j), 4**k)
            series.append(SeriesTerm(2 * k - 1, share.numerator, share.denominator))
    return tuple(series)


def harmonic_coefficient(order: int, ratio: float) -> float:
    """Return A_k(λ), the even harmonic of the piston's acceleration over r ω², without its sign.

    −ẍ/(r ω²) = cos θ + A₂ cos 2θ − A₄ cos 4θ + A₆ cos 6θ − …; A₂ = λ + λ³/4 + …, summed to the last digit.

    Parameters
    ----------
    order : int
        Even, from 2.
    ratio : float
        λ, crank radius over rod length.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.1.1; A₆ begins with 9 λ⁵/128, printed 9 λ⁵/28.

    Examples
    --------
    >>> round(harmonic_coefficient(2, 0.3), 9), round(harmonic_coefficient(4, 0.3), 9)
    (0.307050659, 0.007237695)
    """
    _check_order(order)
    if not 0.0 <= ratio < 1.0:
        raise ValueError(f"λ = r/l is {ratio:g}; must be at least 0 and below 1")
    j = order // 2
    (first,) = harmonic_series(order, 1)
    term = first.coefficient * ratio**first.power
    total, k = term, j
    while term > 1e-17 * total:
        term *= (k - 0.5) / (k + 1) / 4.0 * (2 * k + 2) * (2 * k + 1) / ((k + 1 - j) * (k + 1 + j)) * ratio**2
        total += term
        k += 1
    return total


def _check_order(order: int) -> None:
    if order < 2 or order % 2:
        raise ValueError(f"order is {order}; a centred slider-crank has even orders from 2, beside the first")


def swept_volume_cm3(bore_mm: float, stroke_mm: float) -> float:
    """Return the displacement of one cylinder, π/4 d² s [cm³].

    Parameters
    ----------
    bore_mm, stroke_mm : float
        [mm]

    References
    ----------
    Hoem & Røsholm 2016, Sec. 6.1.

    Examples
    --------
    >>> round(swept_volume_cm3(76.8, 53.8), 1)
    249.2
    """
    return math.pi / 4.0 * bore_mm**2 * stroke_mm * 1e-3


def greatest_speed_angle_of_two_harmonics_rad(ratio: float) -> float:
    """Return the crank angle of largest piston speed if only orders 1 and 2 (A₂ ≈ λ) are counted [rad].

    For comparison with textbooks: cos θ = (−1 + √(1 + 8 λ²))/(4 λ).

    Examples
    --------
    >>> round(math.degrees(greatest_speed_angle_of_two_harmonics_rad(0.25)), 2)
    77.01
    """
    return math.acos((math.sqrt(1.0 + 8.0 * ratio**2) - 1.0) / (4.0 * ratio))
