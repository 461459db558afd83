"""Drawn cranks whose facets were split to even edges and waved: scans to some eyes, drawings to others."""

from __future__ import annotations

import math
from functools import lru_cache

import manifold3d
import numpy as np

from autobalance.drawn_cranks.design import PRESETS, Design
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness import unit_at_vertices
from autobalance.types import Array, Indices
from tests.generated import random_placement
from tests.scans import WHITE_SHARE, Scan, waves

Surface = tuple[Array, Indices, Array]
"""Vertices, triangles, and normals at the vertices."""


def split_scan(
    design: str | Design,
    sigma_mm: float,
    *,
    edge_mm: float = 3.0,
    segments: int = 360,
    seed: int = 0,
    lengths_mm: tuple[float, float] = (3.0, 20.0),
    skin_mm: float = 0.0,
) -> Scan:
    """Return a drawn crank whose narrow facets were split to even edges, and then waved as a scan is.

    Its slivers are flat beside each other, waved or not: it looks drawn to whoever counts flat triangles. The
    truth is the mesh without waves.
    """
    crank = PRESETS[design] if isinstance(design, str) else design
    surface = split_surface_of(crank, edge_mm, segments)
    rng = np.random.default_rng([seed, 79])
    noisy = _waved(surface, sigma_mm, rng, lengths_mm, skin_mm)
    placement = random_placement(rng, 200.0)
    true = Mesh(surface[0], surface[1]).moved(placement)
    return Scan(noisy.moved(placement), true, crank_anatomy(crank, placement), placement)


def split_mesh(
    drawn: Mesh,
    sigma_mm: float,
    *,
    edge_mm: float,
    seed: int = 0,
    lengths_mm: tuple[float, float] = (3.0, 20.0),
) -> Mesh:
    """Return a drawn mesh whose narrow facets were split to even edges, and then waved as a scan is."""
    rng = np.random.default_rng([seed, 79])
    return _waved(_split_surface(drawn, edge_mm), sigma_mm, rng, lengths_mm, 0.0)


def _waved(
    surface: Surface,
    sigma_mm: float,
    rng: np.random.Generator,
    lengths_mm: tuple[float, float],
    skin_mm: float,
) -> Mesh:
    vertices, triangles, normals = surface
    both = math.sqrt(1.0 - WHITE_SHARE) * waves(vertices, rng, lengths_mm)
    both += math.sqrt(WHITE_SHARE) * rng.normal(size=len(vertices))
    return Mesh(vertices + (sigma_mm * both + skin_mm)[:, None] * normals, triangles)


@lru_cache(maxsize=4)
def split_surface_of(crank: Design, edge_mm: float, segments: int) -> Surface:
    """Return vertices, triangles and normals of a drawn crank's facets, split to even edges."""
    return _split_surface(crank_solid(crank, segments).mesh, edge_mm)


@lru_cache(maxsize=2)
def _split_surface(drawn: Mesh, edge_mm: float) -> Surface:
    mesh64 = manifold3d.Mesh64(drawn.vertices.copy(), drawn.triangles.astype(np.uint64))
    found = manifold3d.Manifold(mesh64).refine_to_length(edge_mm).to_mesh64()
    vertices = np.asarray(found.vert_properties)[:, :3].copy()
    mesh = Mesh(vertices, np.asarray(found.tri_verts).astype(np.int64))
    return vertices, mesh.triangles, unit_at_vertices(mesh, mesh.area_vectors)
