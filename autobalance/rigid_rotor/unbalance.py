"""Moments of a rotor, its unbalance, and the uncertainty of both."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

# Mass moments about a fixed origin: the currency of the program.
#
# Moments add and subtract with the solids they belong to, so nothing here divides by a mass until
# a centre is requested, and a body minus itself is simply zero.


@dataclass(frozen=True, eq=False)
class Moments:
    """Mass, first and second moments of a body about the origin of its frame.

    Attributes
    ----------
    mass_g : float
        ∫ dm [g].
    first_g_mm : (3,) float
        ∫ r dm [g·mm].
    second_g_mm2 : (3, 3) float
        ∫ r rᵀ dm, symmetric [g·mm²]. Its off-diagonals are +∫ x y dm, not products of inertia.
    """

    mass_g: float
    first_g_mm: Array
    second_g_mm2: Array

    @classmethod
    def zero(cls) -> Moments:
        return cls(0.0, np.zeros(3), np.zeros((3, 3)))

    @classmethod
    def point(cls, mass_g: float, position_mm: Array) -> Moments:
        """Return the moments of a point mass [g] at ``position_mm`` (3,) [mm]."""
        position = np.asarray(position_mm, dtype=np.float64)
        return cls(mass_g, mass_g * position, mass_g * np.outer(position, position))

    def __add__(self, other: Moments) -> Moments:
        return Moments(
            self.mass_g + other.mass_g,
            self.first_g_mm + other.first_g_mm,
            self.second_g_mm2 + other.second_g_mm2,
        )

    def __sub__(self, other: Moments) -> Moments:
        return self + other.scaled(-1.0)

    def scaled(self, factor: float) -> Moments:
        """Return the moments of the same body with its density multiplied by ``factor``."""
        return Moments(factor * self.mass_g, factor * self.first_g_mm, factor * self.second_g_mm2)

    def moved(self, placement: Array) -> Moments:
        """Return the moments after the body is moved by a rigid motion.

        Parameters
        ----------
        placement : (4, 4) float
            Homogeneous matrix from the old coordinates to the new, rotation and shift [mm].

        Returns
        -------
        Moments
            About the origin of the new coordinates.
        """
        turn, shift = placement[:3, :3], placement[:3, 3]
        first = turn @ self.first_g_mm
        cross = np.outer(first, shift)
        second = turn @ self.second_g_mm2 @ turn.T + cross + cross.T + self.mass_g * np.outer(shift, shift)
        return Moments(self.mass_g, first + self.mass_g * shift, second)

    @property
    def centre_mm(self) -> Array:
        """Centre of mass (3,) [mm]; raises ZeroDivisionError for a massless body."""
        if self.mass_g == 0.0:
            raise ZeroDivisionError("a body without mass has no centre of mass")
        return self.first_g_mm / self.mass_g

    @property
    def polar_inertia_g_mm2(self) -> float:
        """Mass moment of inertia about the z axis, ∫ (x² + y²) dm [g·mm²]."""
        return float(self.second_g_mm2[0, 0] + self.second_g_mm2[1, 1])

    @property
    def inertia_g_mm2(self) -> Array:
        """Inertia tensor (3, 3) about the origin, off-diagonals −∫ x y dm [g·mm²]."""
        inertia: Array = np.trace(self.second_g_mm2) * np.eye(3) - self.second_g_mm2
        return inertia


# Unbalance of a rotor that turns about z, as a resultant with its moment or as two vectors in two planes.


@dataclass(frozen=True, eq=False)
class Unbalance:
    """Resultant unbalance and moment unbalance about the plane z = 0.

    Attributes
    ----------
    resultant_g_mm : (2,) float
        U = ∫ (x, y) dm [g·mm].
    moment_g_mm2 : (2,) float
        P = ∫ z (x, y) dm, about z = 0 [g·mm²]. A couple only where the resultant is zero.
    of_moments : Moments or None
        The moments that it is of; None for sums and readings. Another axis needs the mass as well.
    """

    resultant_g_mm: Array
    moment_g_mm2: Array
    of_moments: Moments | None = None

    @classmethod
    def of(cls, moments: Moments) -> Unbalance:
        return cls(moments.first_g_mm[:2].copy(), moments.second_g_mm2[:2, 2].copy(), moments)

    @property
    def components(self) -> Array:
        """U and P side by side (4,) [g·mm, g·mm²]."""
        return np.concatenate([self.resultant_g_mm, self.moment_g_mm2])

    @classmethod
    def of_planes(cls, plane_unbalance_g_mm: Array, z_a_mm: float, z_b_mm: float) -> Unbalance:
        """Return the unbalance of two vectors (2, 2) [g·mm] that act at z_a and z_b."""
        a, b = plane_unbalance_g_mm
        return cls(a + b, z_a_mm * a + z_b_mm * b)

    def __add__(self, other: Unbalance) -> Unbalance:
        return Unbalance(
            self.resultant_g_mm + other.resultant_g_mm,
            self.moment_g_mm2 + other.moment_g_mm2,
        )

    def __sub__(self, other: Unbalance) -> Unbalance:
        return self + other.scaled(-1.0)

    def scaled(self, factor: float) -> Unbalance:
        return Unbalance(factor * self.resultant_g_mm, factor * self.moment_g_mm2)

    def moment_about_g_mm2(self, z_mm: float) -> Array:
        """Return the moment unbalance (2,) about the plane at ``z_mm`` [g·mm²]: P − z U."""
        return self.moment_g_mm2 - z_mm * self.resultant_g_mm

    def in_planes(self, z_a_mm: float, z_b_mm: float) -> Array:
        """Return the equivalent unbalance vectors in two planes (dynamic unbalance).

        U_A = (z_B U − P)/(z_B − z_A), U_B = (P − z_A U)/(z_B − z_A).

        Parameters
        ----------
        z_a_mm, z_b_mm : float
            Places of the planes on the axis; they must differ [mm].

        Returns
        -------
        (2, 2) float
            One row a plane, A first [g·mm].

        Raises
        ------
        ValueError
            If the planes coincide.

        References
        ----------
        ISO 21940-11:2016, 4.5: representations of the unbalance of a rigid rotor.

        Examples
        --------
        >>> Unbalance(np.array([10.0, 20.0]), np.array([0.0, 0.0])).in_planes(-30.0, 10.0).tolist()
        [[2.5, 5.0], [7.5, 15.0]]
        """
        span = z_b_mm - z_a_mm
        if span == 0.0:
            raise ValueError(f"both planes are at z = {z_a_mm:g} mm; they must differ")
        a = (z_b_mm * self.resultant_g_mm - self.moment_g_mm2) / span
        return np.stack([a, self.resultant_g_mm - a])

    @property
    def magnitude_g_mm(self) -> float:
        """Length of the resultant [g·mm]."""
        return math.hypot(*self.resultant_g_mm)

    @property
    def angle_rad(self) -> float:
        """Direction of the resultant, the heavy side, in [0, 2π) from x towards y [rad]."""
        angle = math.atan2(self.resultant_g_mm[1], self.resultant_g_mm[0])
        return angle % (2.0 * math.pi) % (2.0 * math.pi)  # twice: −1e-17 % 2π is 2π itself

    @property
    def angle_deg(self) -> float:
        """Direction of the resultant, the heavy side, in [0, 360)."""
        return wrapped_deg(math.degrees(self.angle_rad))


# Uncertainty of the unbalance: shares by cause and their sum, for the resultant and in two planes.


ONE_SIDED = 1.645 / 1.960
"""The 95 % quantile of one side over that of both, of normal errors."""

Places = tuple[float, float] | None
"""Positions of tolerance planes A and B along the axis [mm], or None."""


@dataclass(frozen=True)
class Share:
    """Uncertainty of the resultant from one cause, and in planes A and B, if there are any.

    Attributes
    ----------
    resultant_g_mm : float
        Finite, ≥ 0 [g·mm].
    planes_g_mm : tuple of float
        The same in planes A and B, or empty [g·mm].

    Raises
    ------
    ValueError
        If a value is negative or not finite.
    """

    resultant_g_mm: float
    planes_g_mm: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for value in (self.resultant_g_mm, *self.planes_g_mm):
            if not 0.0 <= value < math.inf:
                raise ValueError(f"a share is {value:g} g·mm; must be finite and not negative")

    @classmethod
    def none(cls, places: Places) -> Share:
        """Return a share of zero."""
        return cls(0.0, () if places is None else (0.0, 0.0))

    @classmethod
    def of(cls, change: Moments, places: Places) -> Share:
        """Return the share of a change of the moments that may be present or not."""
        unbalance = Unbalance.of(change)
        planes = () if places is None else unbalance.in_planes(*places)
        return cls(unbalance.magnitude_g_mm, tuple(math.hypot(*vector) for vector in planes))

    def __add__(self, other: Share) -> Share:
        """Return the sum of two shares in the worst directions."""
        pairs = zip(self.planes_g_mm, other.planes_g_mm, strict=True)
        return Share(self.resultant_g_mm + other.resultant_g_mm, tuple(a + b for a, b in pairs))


def root_sum(shares: Sequence[Share], places: Places) -> Share:
    """Return the root of the sum of squares of independent shares."""
    if not shares:
        return Share.none(places)
    planes = zip(*(share.planes_g_mm for share in shares), strict=True)
    return Share(
        math.hypot(*(share.resultant_g_mm for share in shares)), tuple(math.hypot(*each) for each in planes)
    )


@dataclass(frozen=True)
class Budget:
    """Uncertainty of the unbalance, by cause.

    Attributes
    ----------
    shares : mapping
        Uncertainty of the unbalance from each cause alone.
    places : (float, float) or None
        Positions of the planes of the shares [mm].
    unstated : tuple of str
        Causes without a stated uncertainty; they count as zero.
    """

    shares: Mapping[str, Share]
    places: Places = None
    unstated: tuple[str, ...] = ()

    @property
    def total(self) -> Share:
        """Root of the sum of squares, as in independent causes.

        References
        ----------
        JCGM 100:2008 (GUM), 5.1.2. Two points are ours: the shares are half-widths of about 95 %, not
        standard deviations, and an unknown cause is left out.
        """
        return root_sum(list(self.shares.values()), self.places)

    @property
    def total_g_mm(self) -> float:
        """Uncertainty of the resultant [g·mm]."""
        return self.total.resultant_g_mm


def facets_share(
    missing: Moments, bar_g_mm: Moments, corrected: bool, places: Places, bar_share: float = 0.0
) -> Share:
    """Return the share of the facets: the error bar alone where the estimate is corrected for, else both.

    ``bar_g_mm`` is the error bar of the estimate, as a mass along the axis: its mass is the bar of the
    resultant [g·mm], its moments are that bar times z and z². Beside it ``bar_share`` of the estimate itself
    may be off, in each plane.
    """
    bar = Share(bar_g_mm.mass_g, _on_levers(bar_g_mm, places))
    if bar_share:
        bar = root_sum([bar, Share.of(missing.scaled(bar_share), places)], places)
    return bar if corrected else Share.of(missing, places) + bar


def facets_beside_skin(facets: Share, scan: Share) -> Share:
    """Return the facets' share, raised so that its root sum with the scan's covers their common bias.

    Facets always lack metal, and so does a thin surface offset. A bias and one side of a normal error add up,
    to facets + 0.84 scan (GUM, F.2.4.5), if that is more than the root of their squares.
    """
    pairs = zip(_values(facets), _values(scan), strict=True)
    resultant, *planes = (
        math.sqrt(max(bias**2, (bias + ONE_SIDED * skin) ** 2 - skin**2)) for bias, skin in pairs
    )
    return Share(resultant, tuple(planes))


def _values(share: Share) -> tuple[float, ...]:
    return (share.resultant_g_mm, *share.planes_g_mm)


def rounding_share(body: Moments, spacing_mm: float, places: Places) -> Share:
    """Return the share of coordinates rounded to ``spacing_mm``.

    Every point lies within half a spacing of where it was, and so does the centre of mass: an upper bound,
    since the errors of many points cancel. In a plane, points that are off along the axis count too.
    """
    half = 0.5 * spacing_mm
    share = displacement_share(body, half, places)
    if places is None:
        return share
    radial = math.sqrt(max(body.mass_g * body.polar_inertia_g_mm2, 0.0)) / abs(places[1] - places[0])
    return Share(share.resultant_g_mm, tuple(plane + half * radial for plane in share.planes_g_mm))


def displacement_share(body: Moments, most_mm: float, places: Places) -> Share:
    """Return the unbalance's share for a body whose slices may each lie off the axis by up to ``most_mm``.

    Specific unbalance is distance from the axis; the axis itself may lie elsewhere by as much.
    """
    levers = _on_levers(body, places)
    return Share(most_mm * body.mass_g, tuple(most_mm * lever for lever in levers))


def _on_levers(body: Moments, places: Places) -> tuple[float, ...]:
    """Return upper bounds of ∫ |w| dm for planes A and B, w the share of a force at z that the plane carries.

    ∫ |w| dm ≤ √(m ∫ w² dm), by Cauchy and Schwarz; ∫ w² dm follows from the moments.
    """
    if places is None:
        return ()
    first, second = float(body.first_g_mm[2]), float(body.second_g_mm2[2, 2])
    span = places[1] - places[0]
    squares = (second - 2.0 * far * first + far * far * body.mass_g for far in reversed(places))
    return tuple(math.sqrt(max(body.mass_g * square, 0.0)) / abs(span) for square in squares)


def along_the_axis(amount: float, amount_z: float, amount_z2: float) -> Moments:
    """Return the moments of an amount spread along the axis, from itself, its ∫ z and its ∫ z²."""
    first, second = np.zeros(3), np.zeros((3, 3))
    first[2], second[2, 2] = amount_z, amount_z2
    return Moments(amount, first, second)
