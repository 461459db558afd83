"""Strength of a design, and its prediction from analysed designs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from autobalance.balancing.engine_from_job import with_moments, with_solid
from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing import firing_engine
from autobalance.errors import JobError
from autobalance.finite_elements.analysis import facet_nodes, facet_shares, solved
from autobalance.finite_elements.elasticity import STEEL, ElasticBody, ElasticMaterial
from autobalance.finite_elements.modes import modes_of
from autobalance.finite_elements.throws import bodies_of_solid
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.whole_engine import Engine
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Strength of a design: main-bearing loads of the cycle, stress under its largest load, first frequency.


T_MM3_PER_G_MM3 = 1e-6
SURFACE_SHARE = 0.03
"""Largest distance of a faceted pin's surface from its cylinder, as a share of the radius."""


def cycle_of(job: Job, anatomy: Anatomy, moments: Moments, solid: Solid | None) -> CycleAnalysis:
    """Return the cycle of a job's engine: with a crank's solid (file coordinates), or else with its moments.

    Raises
    ------
    JobError
        If the job has no cycle.
    """
    density = job.crankshaft.density_g_mm3

    def engine() -> Engine:
        if solid is None:
            return with_moments(job, anatomy, moments)
        return with_solid(job, anatomy, solid, density, moments)

    speed = job.balance.service_speed_rad_s
    return CycleAnalysis(firing_engine(job, anatomy, speed, engine), speed)


def greatest_main_load_n(cycle: CycleAnalysis) -> float:
    """Return the largest load of any main bearing in a cycle [N]."""
    return max(peak.greatest_n for peak in cycle.peaks(cycle.loads.main_n))


def greatest_pin_loads_n(cycle: CycleAnalysis) -> Array:
    """Return the loads (t, 2) on the crankpins in the crank's frame when one of them is largest [N]."""
    turning = cycle.loads.crankpin_in_crank_frame_n()
    pins = np.stack([turning[list(throw.cylinders)].sum(axis=0) for throw in cycle.firing.throws])
    worst = int(np.linalg.norm(pins, axis=2).max(axis=0).argmax())
    loads: Array = pins[:, worst]
    return loads


def material_of(density_g_mm3: float) -> ElasticMaterial:
    """Return the material steel with a density."""
    return ElasticMaterial(STEEL.young_MPa, STEEL.poisson, density_g_mm3 * T_MM3_PER_G_MM3)


def body_of(rotor_solid: Solid, size_mm: float | None) -> ElasticBody:
    return bodies_of_solid(rotor_solid, size_mm)[0]


def first_frequency_hz(body: ElasticBody, density_g_mm3: float) -> float:
    """Return the first natural frequency of a free crank."""
    return modes_of(body, material_of(density_g_mm3), 1)[0].frequency_hz


def greatest_stress_MPa(
    body: ElasticBody, anatomy: Anatomy, pin_loads_n: Array, density_g_mm3: float
) -> float:
    """Return the largest von Mises stress of a crank held at its main journals and loaded at its crankpins.

    Raises
    ------
    JobError
        If a journal or a crankpin has no surface in the mesh.
    """
    held = np.zeros((body.nodes, 3), dtype=bool)
    for journal in anatomy.main_journals:
        facets = _facets_on(body, journal, journal.z_range_mm, f"main journal {journal.number}")
        held[np.unique(facet_nodes(body, facets))] = True
    force = np.zeros((body.nodes, 3))
    for throw, load in zip(anatomy.throws, pin_loads_n, strict=True):
        near = [
            web
            for web in anatomy.webs
            if abs(0.5 * (web.z_min_mm + web.z_max_mm) - throw.crankpin.centre_mm[2])
            < throw.crankpin.width_mm + (web.z_max_mm - web.z_min_mm)
        ]
        low, high = throw.crankpin.z_range_mm
        reach = min([low, *(w.z_min_mm for w in near)]), max([high, *(w.z_max_mm for w in near)])
        shares = facet_shares(body, _facets_on(body, throw.crankpin, reach, f"crankpin {throw.number}"))
        force[:, :2] += (shares / shares.sum())[:, None] * load
    result = solved(body, material_of(density_g_mm3), held.reshape(-1), force.reshape(-1))
    return float(result.von_mises_MPa.max())


def _facets_on(body: ElasticBody, pin: Pin, z_mm: tuple[float, float], name: str) -> NDArray[np.int64]:
    """Return the boundary facets on a pin's cylinder between two heights."""
    facets = body.mesh.boundary_facets()
    corners = body.mesh.p[:, body.mesh.facets[:, facets]]
    radius = 0.5 * pin.diameter_mm
    off = np.hypot(corners[0] - pin.centre_mm[0], corners[1] - pin.centre_mm[1])
    slack = SURFACE_SHARE * radius
    on = (np.abs(off - radius) < slack).all(axis=0)
    on &= ((corners[2] > z_mm[0] - slack) & (corners[2] < z_mm[1] + slack)).all(axis=0)
    if not on.any():
        raise JobError(
            f"[fem]: the mesh has no surface of {name} (⌀{2 * radius:.4g} mm); choose a smaller size_mm, "
            f"less than {math.tau * radius / 8:.3g}"
        )
    on_face: NDArray[np.int64] = facets[on].astype(np.int64)
    return on_face


# Prediction of a design's finite-element results from those of analysed designs.
#
# A Gaussian process of the logarithm of each value, over the variables as shares of their bounds: a straight
# line with wide prior and a squared exponential. Its length and the noise of the meshes are those that
# predict each design best from all others.


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
