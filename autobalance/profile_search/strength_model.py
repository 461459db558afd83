"""Prediction of a design's finite-element results from those of analysed designs.

A Gaussian process of the logarithm of each value, over the variables as shares of their bounds: a straight
line with wide prior and a squared exponential. Its length and the noise of the meshes are those that
predict each design best from all others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array

LENGTHS = (0.5, 1.0, 2.0, 4.0)
"""Lengths tried, times the root of the number of variables: designs anywhere are about half of that apart."""
NOISE_VARIANCES = (1e-6, 1e-3, 1e-1)
"""Variances of a mesh's own noise that are tried, relative to the variance of the values."""
LINE_VARIANCE = 10.0
"""Variance of the straight line, relative to that of the values."""
LEAST_ERROR = 1e-3
"""Smallest error of any prediction, as a share: no mesh is better."""
MOST_ERROR = 0.5
MOST_LOG = 5.0
"""Largest distance of a prediction's logarithm from the mean."""


@dataclass(frozen=True, eq=False)
class Analysed:
    """A design analysed by finite elements.

    Attributes
    ----------
    variables : (v,) float
    values : mapping
        Results by name; empty where the solid could not be meshed.
    """

    variables: Array
    values: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class _Process:
    """Gaussian process of one value: its mean, length, and the weight (n,) of each known design."""

    mean: float
    length: float
    weights: Array
    inverse: Array
    """Inverse covariance of the known designs (n, n), per unit of variance."""
    deviation: float
    """Root of the unit of variance, by the errors of designs predicted from all others."""
    error: float
    """Root mean square of these errors, as a share."""


@dataclass(frozen=True, eq=False)
class StrengthModel:
    """Prediction of strengths of designs without an analysis.

    Attributes
    ----------
    bounds : (v, 2) float
        Of the variables.
    places : (n, v) float
        Known designs, as shares of the bounds.
    processes : mapping
        By the name of the value.
    """

    bounds: Array
    places: Array
    processes: Mapping[str, _Process]

    @classmethod
    def of(cls, bounds: Array, known: Sequence[Analysed]) -> StrengthModel | None:
        """Return the model of analysed designs; None: fewer than two of them have values."""
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
        """Return the predicted finite-element results by name."""
        predicted = {}
        for name, each in self.processes.items():
            off = float((self._row(variables, each.length) * each.weights).sum())
            predicted[name] = float(np.exp(each.mean + min(max(off, -MOST_LOG), MOST_LOG)))
        return predicted

    def errors_at(self, variables: Array) -> dict[str, float]:
        """Return the standard deviation of the predictions for a design, by name, as shares."""
        own = _shares(self.bounds, variables)
        whole = LINE_VARIANCE * (1.0 + float((own * own).sum())) + 1.0
        errors = {}
        for name, each in self.processes.items():
            row = self._row(variables, each.length)
            left = whole - float((row * (each.inverse * row).sum(axis=1)).sum())
            errors[name] = min(max(each.deviation * float(np.sqrt(max(left, 0.0))), LEAST_ERROR), MOST_ERROR)
        return errors

    def _row(self, variables: Array, length: float) -> Array:
        """Return the covariances (n,) of a design with the known designs."""
        place = _shares(self.bounds, variables)
        products = (self.places * place).sum(axis=1)
        square = ((self.places - place) ** 2).sum(axis=1)
        covariance: Array = LINE_VARIANCE * (1.0 + products) + np.exp(-0.5 * square / length**2)
        return covariance

    @property
    def errors(self) -> dict[str, float]:
        """Root mean square error of the known designs by name, each predicted from all others; as shares."""
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
    """Return the process with the least error when each known value is predicted from all others."""
    mean = float(logs.mean())
    centred = logs - mean
    scale = float(centred.std()) or 1.0
    products = places @ places.T
    square = ((places[:, None] - places[None]) ** 2).sum(axis=2)
    best: _Process | None = None
    for share in LENGTHS:
        length = share * float(np.sqrt(places.shape[1]))
        smooth = LINE_VARIANCE * (1.0 + products) + np.exp(-0.5 * square / length**2)
        for noise in NOISE_VARIANCES:
            inverse = np.linalg.inv(smooth + noise * np.eye(len(places)))
            weights = inverse @ (centred / scale)
            left_out = weights / np.diag(inverse)  # each one's error, predicted from the others alone
            error = max(scale * float(np.sqrt((left_out**2).mean())), LEAST_ERROR)
            if best is None or error < best.error:
                deviation = scale * float(np.sqrt((weights**2 / np.diag(inverse)).mean()))
                best = _Process(mean, length, scale * weights, inverse, deviation, error)
    assert best is not None
    return best
