"""Uncertainty of the unbalance: shares by cause and their sum, for the resultant and in two planes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.unbalance import Unbalance

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
