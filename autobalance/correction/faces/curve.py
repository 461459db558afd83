"""Quantity sampled at some depths and interpolated at all of them, with its integral."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from autobalance.types import Array

NODES = (5, 9)
"""Samples of a piece, and their number where that is too few: every other one must predict those between."""
CHECK_SHARE = 1e-5
"""Permitted error of these predictions, as a share of the largest: all samples are far nearer."""
ROUGH_CHECK_SHARE = 1e-3
"""The same of a rough surface, which no polynomial follows closer; what a cut takes of it is measured."""
SPLITS = 3
"""Largest number of splits of a piece with larger errors, as at a kink."""


@dataclass(frozen=True, eq=False)
class _Rule:
    """A number of samples at Chebyshev's places, from −1 to 1; every other one is a smaller rule's too.

    ``fit`` makes coefficients of samples; ``check`` predicts the samples between every other one from these.
    """

    places: Array
    fit: Array
    check: Array

    @classmethod
    def of(cls, nodes: int) -> _Rule:
        places = -np.cos(np.pi * np.arange(nodes) / (nodes - 1))
        coarse = _fitted(places[::2])
        return cls(places, _fitted(places), chebyshev.chebvander(places[1::2], nodes // 2) @ coarse)


def _fitted(places: Array) -> Array:
    """Return the matrix from samples at as many places to Chebyshev coefficients."""
    fit: Array = np.linalg.inv(chebyshev.chebvander(places, len(places) - 1)).astype(np.float64)
    return fit


_RULES = tuple(_Rule.of(nodes) for nodes in NODES)


@dataclass(frozen=True, eq=False)
class _Piece:
    start: float
    end: float
    value: Array
    """Chebyshev coefficients (k, n) over the piece."""
    integral: Array
    """Chebyshev coefficients of the antiderivative, zero at depth 0."""

    def place(self, depth: float) -> float:
        """Return the place of a depth, from −1 at the start to 1 at the end."""
        return (2.0 * depth - self.start - self.end) / (self.end - self.start)


class DepthCurve:
    """A vector of numbers over the depths from 0 to a largest one, in pieces of Chebyshev polynomials.

    Parameters
    ----------
    sample : callable
        Takes a depth and returns the vector (n,) there; called from shallow to deep within a piece.
    least, most : float
        Depths between which to sample, 0 <= least < most; above ``least`` the first piece continues.
    scale : (n,) float
        Scale of the components' errors.
    breaks : (k,) float
        Depths at which the curve may have a kink.
    share : float
        Permitted error of samples that were left out, as a share of the scale.
    """

    def __init__(
        self,
        sample: Callable[[float], Array],
        least: float,
        most: float,
        scale: Array,
        breaks: Array,
        share: float = CHECK_SHARE,
    ) -> None:
        self._sample, self._permitted = sample, share * scale
        self._breaks = breaks
        self._pieces: list[_Piece] = []
        self._add(least, most, SPLITS)

    def _add(self, start: float, end: float, splits: int) -> None:
        middle, half = 0.5 * (start + end), 0.5 * (end - start)
        sampled: dict[float, Array] = {}
        for rule in _RULES:
            depths = [start, *(middle + half * float(place) for place in rule.places[1:-1]), end]
            sampled |= {depth: self._sample(depth) for depth in depths if depth not in sampled}
            exact = np.stack([sampled[depth] for depth in depths])
            off = np.abs(rule.check @ exact[::2] - exact[1::2])
            if is_close := bool((off <= self._permitted).all()):
                break
        if splits and not is_close:
            inner = self._breaks[np.abs(self._breaks - middle) < 0.5 * half]
            if len(inner):
                middle = float(inner[np.argmin(np.abs(inner - middle))])
            self._add(start, middle, splits - 1)
            self._add(middle, end, splits - 1)
            return
        value = rule.fit @ exact
        integral: Array = half * chebyshev.chebint(value, lbnd=-1.0).astype(np.float64)
        if self._pieces:
            integral[0] += self._pieces[-1].integral.sum(axis=0)  # all the polynomials are 1 at 1
        else:
            integral[0] -= _at(-middle / half, integral)  # nothing at depth zero
        self._pieces.append(_Piece(start, end, value, integral))

    def _piece(self, depth: float) -> _Piece:
        return next((piece for piece in self._pieces if depth <= piece.end), self._pieces[-1])

    def value(self, depth: float) -> Array:
        piece = self._piece(depth)
        return _at(piece.place(depth), piece.value)

    def integral(self, depth: float) -> Array:
        """Return the integral of the vector from zero to a depth."""
        piece = self._piece(depth)
        return _at(piece.place(depth), piece.integral)


def _at(place: float, coefficients: Array) -> Array:
    """Return the values (n,) of Chebyshev series (k, n) at a place from −1 to 1."""
    values: Array = chebyshev.chebvander(np.array([place]), len(coefficients) - 1)[0] @ coefficients
    return values
