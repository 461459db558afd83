"""Beam elements with the exact static shapes of their section as functions.

The four nodal functions are the deflections of the unloaded element under displacements of its ends:
of a uniform section the classical Timoshenko (or Euler) element, of a cone its exact counterpart. With
``degree`` d > 0 the responses, ends held, to transverse loads and distributed moments that run as
polynomials of degree < d are added. The stiffness between nodes is exact either way; the degree
sets the accuracy of inertia inside the element: frequencies converge as h^(2d + 2), h² to h⁴ for the
classical element.

Along an element: V = S (w′ − ψ) the shear force, M = EI ψ′ the bending moment,
V′ = −q, M′ = −V − m under a load q and a distributed moment m.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from autobalance.crank_dynamics.rotor.beam_rotor import BeamTheory, ShaftSection, cowper_shear_factor
from autobalance.types import Array

POINTS = 16
"""Points of Gauss's rule along an element: exact for every product of a uniform element's functions."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """Pieces (n) of shaft for the elements, with their section at Gauss's points (n, POINTS)."""

    length_m: Array
    bending_stiffness_n_m2: Array
    shear_flexibility_per_n: Array
    line_mass_kg_m: Array
    line_inertia_kg_m: Array

    @property
    def shear(self) -> bool:
        """Whether shear and rotary inertia count."""
        return bool(self.shear_flexibility_per_n.any())


@dataclass(frozen=True, eq=False)
class Elements:
    """Matrices (n, f, f) of beam elements in one plane and their functions at Gauss's points (n, f, POINTS).

    Of the f functions the first four belong to deflection and rotation at the start and the end.
    ``gyroscopic`` is the matrix of the polar inertia.
    """

    mass: Array
    stiffness: Array
    gyroscopic: Array
    deflection: Array
    rotation: Array


@lru_cache(maxsize=1)
def gauss() -> tuple[Array, Array, Array]:
    """Return Gauss's points and weights on 0..1, and the matrix of integrals from 0 to each point."""
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    legendre = np.polynomial.legendre.legvander(points, POINTS - 1)
    integrals = np.stack(
        [
            np.polynomial.legendre.legval(points, np.polynomial.legendre.legint(row, lbnd=-1))
            for row in np.eye(POINTS)
        ],
        axis=1,
    )
    return 0.5 * (points + 1.0), 0.5 * weights, 0.5 * integrals @ np.linalg.inv(legendre)


def stretch_of(section: ShaftSection, shares: Array, beam: BeamTheory) -> Stretch:
    """Return the pieces of a section between ``shares`` (n + 1,) of its length.

    Raises
    ------
    ValueError
        If ``shares`` do not ascend.
    """
    if not np.all(np.diff(shares) > 0.0):
        raise ValueError("the ends of beam elements must ascend along the shaft")
    at = shares[:-1, None] + np.diff(shares)[:, None] * gauss()[0]
    outer, inner = section.diameters_m(at)
    area, second = np.pi / 4.0 * (outer**2 - inner**2), np.pi / 64.0 * (outer**4 - inner**4)
    factor = section.shear_factor or cowper_shear_factor(section.poissons_ratio, inner / outer)
    flexibility = 1.0 / (factor * section.shear_modulus_pa * area)
    thin = 0.0 if beam == "euler" else 1.0
    return Stretch(
        np.diff(shares) * section.length_m,
        section.youngs_modulus_pa * second,
        thin * flexibility,
        section.density_kg_m3 * area,
        thin * section.density_kg_m3 * second,
    )


def elements_of(stretch: Stretch, degree: int) -> Elements:
    length = stretch.length_m[:, None, None]
    moment, shear = _static_states(stretch, degree)
    deflection, rotation, moment, shear = _with_ends_apart(stretch, *_deflected(stretch, moment, shear))
    weights = gauss()[1] * stretch.length_m[:, None]

    def product(left: Array, right: Array, factor: Array) -> Array:
        scaled: Array = np.einsum("efq,eq,egq->efg", left, weights * factor, right, optimize=True)
        return scaled

    rotary = product(rotation, rotation, stretch.line_inertia_kg_m)
    stiffness = product(moment, moment, 1.0 / stretch.bending_stiffness_n_m2)
    if stretch.shear:
        stiffness = stiffness + product(shear, shear, stretch.shear_flexibility_per_n)
    scale = _bubble_scale(stiffness, length[:, 0, 0])
    both = scale[:, :, None] * scale[:, None, :]
    return Elements(
        (product(deflection, deflection, stretch.line_mass_kg_m) + rotary) * both,
        stiffness * both,
        2.0 * rotary * both,
        deflection * scale[:, :, None],
        rotation * scale[:, :, None],
    )


def _bubble_scale(stiffness: Array, length_m: Array) -> Array:
    """Return factors (n, f) that give each inner function the stiffness of an end's deflection."""
    diagonal: Array = np.einsum("eff->ef", stiffness)
    scale = np.ones(diagonal.shape)
    scale[:, 4:] = np.sqrt(diagonal[:, :1] / diagonal[:, 4:])
    return scale


def _static_states(stretch: Stretch, degree: int) -> tuple[Array, Array]:
    """Return bending moments and shear forces (n, f, POINTS) of the basic static states.

    In turn: two rigid motions, a constant shear force, a constant moment, transverse loads Pₖ,
    distributed moments Pₖ balanced by a transverse load, Pₖ Legendre's polynomials.
    """
    points, _, cumulate = gauss()
    length = stretch.length_m[:, None]
    zero, one = np.zeros((len(length), POINTS)), np.ones((len(length), POINTS))
    shear = [zero, zero, one, zero]
    moment = [zero, zero, -length * points, one]
    for k in range(degree):
        load = np.polynomial.legendre.legval(2.0 * points - 1.0, np.eye(degree)[k])
        force = -length * (cumulate @ load)
        shear.append(force)
        moment.append(-length * (force @ cumulate.T))
    if stretch.shear:
        for k in range(degree):
            load = np.polynomial.legendre.legval(2.0 * points - 1.0, np.eye(degree)[k])
            shear.append(-load * one)
            moment.append(zero)
    return np.stack(moment, axis=1), np.stack(shear, axis=1)


def _deflected(stretch: Stretch, moment: Array, shear: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return deflection, rotation, moment and shear of the states, and the motions at the end (n, 2, f)."""
    _, weights, cumulate = gauss()
    length = stretch.length_m[:, None, None]
    curvature = moment / stretch.bending_stiffness_n_m2[:, None, :]
    rotation = length * (curvature @ cumulate.T)
    rotation[:, 1] += 1.0
    slope = rotation + shear * stretch.shear_flexibility_per_n[:, None, :]
    deflection = length * (slope @ cumulate.T)
    deflection[:, 0] += 1.0
    end_rotation = length[:, 0] * (curvature @ weights)
    end_rotation[:, 1] += 1.0
    end_deflection = length[:, 0] * (slope @ weights)
    end_deflection[:, 0] += 1.0
    return deflection, rotation, moment, shear, np.stack([end_deflection, end_rotation], axis=1)


def _with_ends_apart(
    stretch: Stretch, deflection: Array, rotation: Array, moment: Array, shear: Array, end: Array
) -> tuple[Array, Array, Array, Array]:
    """Return the states combined so that each of the first four moves one end only, and the others none."""
    count = deflection.shape[1]
    values = np.zeros((len(end), 4, count))
    values[:, 0, 0] = values[:, 1, 1] = 1.0
    values[:, 2:] = end
    # rows scaled alike, for the 4 × 4 solution: rotation × length is a deflection
    scale = np.stack([np.ones_like(stretch.length_m), stretch.length_m] * 2, axis=1)[:, :, None]
    mix = np.zeros((len(end), count, count))
    mix[:, :4, :4] = np.linalg.solve(scale * values[:, :, :4], scale * np.eye(4))
    mix[:, 4:, 4:] = np.eye(count - 4)
    if count > 4:
        mix[:, :4, 4:] = -np.linalg.solve(scale * values[:, :, :4], scale * values[:, :, 4:])
    turned = np.swapaxes(mix, 1, 2)
    return turned @ deflection, turned @ rotation, turned @ moment, turned @ shear


def interpolation(shares: Array) -> Array:
    """Return the matrix (POINTS, n) from values at Gauss's points to ``shares`` (n,) of an element."""
    points = gauss()[0]
    at = np.polynomial.legendre.legvander(2.0 * shares - 1.0, POINTS - 1)
    return np.asarray(
        (at @ np.linalg.inv(np.polynomial.legendre.legvander(2.0 * points - 1.0, POINTS - 1))).T
    )
