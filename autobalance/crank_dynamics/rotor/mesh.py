"""Division of a shaft into beam elements, as many as the required accuracy needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.crank_dynamics.rotor.beam_element import Elements, elements_of, stretch_of
from autobalance.crank_dynamics.rotor.beam_rotor import (
    BeamRotor,
    BeamTheory,
    ShaftSection,
    cowper_shear_factor,
)
from autobalance.types import Array

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
