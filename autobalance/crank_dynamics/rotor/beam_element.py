"""Beam elements with the exact static shapes of their section, and the division of a shaft into them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from autobalance.crank_dynamics.rotor.beam_rotor import (
    BeamRotor,
    BeamTheory,
    ShaftSection,
    cowper_shear_factor,
)
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Beam elements with the exact static shapes of their section as functions.
#
# The four nodal functions are the deflections of the unloaded element under displacements of its ends:
# of a uniform section the classical Timoshenko (or Euler) element, of a cone its exact counterpart. With
# ``degree`` d > 0 the responses, ends held, to transverse loads and distributed moments that run as
# polynomials of degree < d are added. The stiffness between nodes is exact either way; the degree
# sets the accuracy of inertia inside the element: frequencies converge as h^(2d + 2), h² to h⁴ for the
# classical element.
#
# Along an element: V = S (w′ − ψ) the shear force, M = EI ψ′ the bending moment,
# V′ = −q, M′ = −V − m under a load q and a distributed moment m.


POINTS = 16
"""Points of Gauss's rule along an element: exact for every product of a uniform element's functions."""


@dataclass(frozen=True, eq=False)
class ShaftPieces:
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


def stretch_of(section: ShaftSection, shares: Array, beam: BeamTheory) -> ShaftPieces:
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
    return ShaftPieces(
        np.diff(shares) * section.length_m,
        section.youngs_modulus_pa * second,
        thin * flexibility,
        section.density_kg_m3 * area,
        thin * section.density_kg_m3 * second,
    )


def elements_of(stretch: ShaftPieces, degree: int) -> Elements:
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
    scale = _bubble_scale(stiffness)
    both = scale[:, :, None] * scale[:, None, :]
    return Elements(
        (product(deflection, deflection, stretch.line_mass_kg_m) + rotary) * both,
        stiffness * both,
        2.0 * rotary * both,
        deflection * scale[:, :, None],
        rotation * scale[:, :, None],
    )


def _bubble_scale(stiffness: Array) -> Array:
    """Return factors (n, f) that give each inner function the stiffness of an end's deflection."""
    diagonal: Array = np.einsum("eff->ef", stiffness)
    scale = np.ones(diagonal.shape)
    scale[:, 4:] = np.sqrt(diagonal[:, :1] / diagonal[:, 4:])
    return scale


def _static_states(stretch: ShaftPieces, degree: int) -> tuple[Array, Array]:
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


def _deflected(stretch: ShaftPieces, moment: Array, shear: Array) -> tuple[Array, Array, Array, Array, Array]:
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
    stretch: ShaftPieces, deflection: Array, rotation: Array, moment: Array, shear: Array, end: Array
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


# Division of a shaft into beam elements, as many as the required accuracy needs.


CLASSICAL_DEGREE = 0
"""Degree of elements in a number set by the user."""
REFINED_DEGREE = 3
"""Degree of elements in a number set by the accuracy."""
PHASE_PER_ELEMENT = 2.0
"""Largest wave number × length [rad] of a refined element with about 1e-6 of error in frequency."""
MERGED_SECTION_SHARE = 1e-6
"""Share of a section within which a division moves to the bearing, disc or probe beside it."""


@dataclass(frozen=True, eq=False)
class RotorMesh:
    """Nodes (n + 1,) of a divided shaft and its elements, one group for each section."""

    nodes_m: Array
    groups: tuple[Elements, ...]
    first_nodes: tuple[int, ...]
    length_m: tuple[Array, ...]

    def node_at(self, z_m: float) -> int:
        """Return the node nearest to a place."""
        return int(np.argmin(np.abs(self.nodes_m - z_m)))


def mesh_of(
    rotor: BeamRotor,
    stations_m: Array,
    top_frequency_rad_s: float,
    degree: int = REFINED_DEGREE,
    finer: float = 1.0,
) -> RotorMesh:
    """Divide a rotor's shaft, with a node at each station.

    Parameters
    ----------
    rotor : BeamRotor
    stations_m : (k,) float
        Places that must be nodes [m].
    top_frequency_rad_s : float
        Highest frequency of interest; sections without a number of elements get as many as it needs.
    degree : int
        Of the elements in a number set by the accuracy.
    finer : float
        Factor on their number.
    """
    groups, lengths, firsts, nodes = [], [], [], [np.zeros(1)]
    count = 0
    for start, section in zip(rotor.section_ends_m[:-1], rotor.sections, strict=True):
        shares = _shares(
            section, (stations_m - start) / section.length_m, top_frequency_rad_s, finer, rotor.beam
        )
        stretch = stretch_of(section, shares, rotor.beam)
        groups.append(elements_of(stretch, CLASSICAL_DEGREE if section.elements else degree))
        lengths.append(stretch.length_m)
        firsts.append(count)
        count += len(shares) - 1
        nodes.append(start + shares[1:] * section.length_m)
    return RotorMesh(np.concatenate(nodes), tuple(groups), tuple(firsts), tuple(lengths))


def _shares(
    section: ShaftSection, stations: Array, top_rad_s: float, finer: float, beam: BeamTheory
) -> Array:
    """Return the ends of the elements as shares 0 to 1 of a section."""
    inner = np.unique(stations[(stations > MERGED_SECTION_SHARE) & (stations < 1.0 - MERGED_SECTION_SHARE)])
    inner = inner[np.concatenate([[True], np.diff(inner) > MERGED_SECTION_SHARE])] if len(inner) else inner
    if section.elements:
        even = np.linspace(0.0, 1.0, section.elements + 1)
        near = np.abs(even[:, None] - inner[None, :]).min(axis=1, initial=np.inf) <= MERGED_SECTION_SHARE
        near[[0, -1]] = False
        return np.sort(np.concatenate([even[~near], inner]))
    ends = np.concatenate([[0.0], inner, [1.0]])
    phase = wave_number_per_m(section, top_rad_s, beam) * section.length_m * np.diff(ends)
    counts = np.maximum(1, np.ceil(finer * np.maximum(phase, _cone_phase(section, ends)) / PHASE_PER_ELEMENT))
    parts = [np.linspace(a, b, int(n) + 1)[:-1] for a, b, n in zip(ends[:-1], ends[1:], counts, strict=True)]
    return np.concatenate([*parts, [1.0]])


def _cone_phase(section: ShaftSection, ends: Array) -> Array:
    """Return smallest phases for steep cones, whose diameter may at most double along an element."""
    outer, inner = section.diameters_m(ends)
    wall = outer - inner
    doubled = [np.abs(np.diff(np.log2(each))) for each in (outer, wall)]
    return np.asarray(PHASE_PER_ELEMENT * np.maximum(*doubled))


def wave_number_per_m(section: ShaftSection, frequency_rad_s: float, beam: BeamTheory) -> float:
    """Return the wave number of bending waves on the thinnest part of a section."""
    outer, inner = section.diameters_m(np.array([0.0, 1.0]))
    thin = int(np.argmin(outer**2 + inner**2))
    area = np.pi / 4.0 * (outer[thin] ** 2 - inner[thin] ** 2)
    second = np.pi / 64.0 * (outer[thin] ** 4 - inner[thin] ** 4)
    factor = section.shear_factor or cowper_shear_factor(
        section.poissons_ratio, inner[thin : thin + 1] / outer[thin]
    )
    bending = section.youngs_modulus_pa * second
    shear = float(np.squeeze(factor)) * section.shear_modulus_pa * area
    if beam == "euler":
        return float((section.density_kg_m3 * area * frequency_rad_s**2 / bending) ** 0.25)
    density, square = section.density_kg_m3, frequency_rad_s**2
    a, b = bending * shear, (shear * second + bending * area) * density * square
    c = (density * second * square - shear) * density * area * square
    return float(np.sqrt((b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)))
