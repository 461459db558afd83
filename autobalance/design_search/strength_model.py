"""Predict finite-element results of a design from those of designs that were analysed.

A Gaussian process of the logarithm of each value, over the variables as shares of their bounds: a straight
line with wide prior and a squared exponential. Its length and the noise of the meshes are those with which
each design is predicted best from all others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array

LENGTHS = (0.5, 1.0, 2.0, 4.0)
"""Tried, times the root of the number of variables: designs anywhere are about half of that apart."""
NOISES = (1e-6, 1e-3, 1e-1)
"""Variances of what a mesh of its own changes, tried, over that of the values."""
LINE = 10.0
"""Variance of the straight line over that of the values."""
LEAST_ERROR = 1e-3
"""Share that no mesh is better than."""
MOST_ERROR = 0.5
MOST_LOG = 5.0
"""No value is predicted further from the mean than e to this."""


@dataclass(frozen=True, eq=False)
class Analysed:
    """A design analysed by finite elements.

    Attributes
    ----------
    variables : (v,) float
    values : mapping
        By name; empty where its solid could not be meshed.
    """

    variables: Array
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class _Process:
    """One value's process: its mean, length, and the weight (n,) of each known design."""

    mean: float
    length: float
    weights: Array
    inverse: Array
    """Of the covariance of the known designs (n, n), per unit of variance."""
    deviation: float
    """Root of that unit, from how far designs are off when predicted from all others."""
    error: float
    """Root of the mean square of that, as a share."""


@dataclass(frozen=True, eq=False)
class StrengthModel:
    """Predicts strengths of designs that were not analysed.

    Attributes
    ----------
    bounds : (v, 2) float
        Of the variables.
    places : (n, v) float
        Of the known designs, as shares of the bounds.
    processes : mapping
        By the name of the value.
    """

    bounds: Array
    places: Array
    processes: Mapping[str, _Process]

    @classmethod
    def of(cls, bounds: Array, known: Sequence[Analysed]) -> StrengthModel | None:
        """Return the model that analysed designs make; None: too few of them are known."""
        analysed = [each for each in known if each.values]
        if len(analysed) < 2:
            return None
        places = np.stack([_shares(bounds, each.variables) for each in analysed])
        models = {
            name: _process(places, np.log([each.values[name] for each in analysed]))
            for name in analysed[0].values
        }
        return cls(bounds, places, models)

    def predicted(self, variables: Array) -> dict[str, float]:
        """Return what finite elements would find, by name."""
        predicted = {}
        for name, each in self.processes.items():
            off = float((self._row(variables, each.length) * each.weights).sum())
            predicted[name] = float(np.exp(each.mean + min(max(off, -MOST_LOG), MOST_LOG)))
        return predicted

    def errors_at(self, variables: Array) -> dict[str, float]:
        """Return the standard deviation of the predictions for a design, by name, as shares."""
        own = _shares(self.bounds, variables)
        whole = LINE * (1.0 + float((own * own).sum())) + 1.0
        errors = {}
        for name, each in self.processes.items():
            row = self._row(variables, each.length)
            left = whole - float((row * (each.inverse * row).sum(axis=1)).sum())
            errors[name] = min(max(each.deviation * float(np.sqrt(max(left, 0.0))), LEAST_ERROR), MOST_ERROR)
        return errors

    def _row(self, variables: Array, length: float) -> Array:
        """Return the covariance (n,) of a design with the known ones."""
        place = _shares(self.bounds, variables)
        products = (self.places * place).sum(axis=1)
        square = ((self.places - place) ** 2).sum(axis=1)
        covariance: Array = LINE * (1.0 + products) + np.exp(-0.5 * square / length**2)
        return covariance

    @property
    def errors(self) -> dict[str, float]:
        """Root mean square error of the known designs, each predicted from all others; as shares."""
        return {name: each.error for name, each in self.processes.items()}

    def nearest(self, variables: Array) -> float:
        """Return the distance to the nearest known design, in shares of the bounds."""
        place = _shares(self.bounds, variables)
        return float(np.sqrt(((self.places - place) ** 2).sum(axis=1).min()))


def _shares(bounds: Array, variables: Array) -> Array:
    low, high = bounds.T
    shares: Array = (variables - low) / np.where(high > low, high - low, 1.0)
    return shares


def _process(places: Array, logs: Array) -> _Process:
    """Return the process that predicts each known value best from all others."""
    mean = float(logs.mean())
    centred = logs - mean
    scale = float(centred.std()) or 1.0
    products = places @ places.T
    square = ((places[:, None] - places[None]) ** 2).sum(axis=2)
    best: _Process | None = None
    for share in LENGTHS:
        length = share * float(np.sqrt(places.shape[1]))
        smooth = LINE * (1.0 + products) + np.exp(-0.5 * square / length**2)
        for noise in NOISES:
            inverse = np.linalg.inv(smooth + noise * np.eye(len(places)))
            weights = inverse @ (centred / scale)
            left_out = weights / np.diag(inverse)  # each one's error, predicted from the others alone
            error = max(scale * float(np.sqrt((left_out**2).mean())), LEAST_ERROR)
            if best is None or error < best.error:
                deviation = scale * float(np.sqrt((weights**2 / np.diag(inverse)).mean()))
                best = _Process(mean, length, scale * weights, inverse, deviation, error)
    assert best is not None
    return best
