"""Chord error of flat facets against the smooth surface they stand for, from the mesh alone.

Neighbouring facets that turn by a little count as chords. Chords of one circle make a cylinder; the volume
between a facet and the cylinder through its corners has a closed form. Smooth facets about the axis of such
a cylinder whose corners lie on one line or one arc of the half-plane through that axis make a cone or a
torus. Smooth facets that are neither count in the error bar alone.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.chordal_error.bars import FLAT, accidents, fitted_bar, loose_bar
from autobalance.solid.chordal_error.look import SMOOTH_RAD, Look, look_at
from autobalance.solid.chordal_error.revolved import (
    IN_QUARTERS,
    SIX_POINTS,
    THREE_POINTS,
    Fitted,
    Lens,
    Revolved,
    lens,
)
from autobalance.solid.chordal_error.scanned_facets import UNBALANCE_SHARE, ScannedFacets
from autobalance.solid.chordal_error.seeds import (
    adopt_cut_facets,
    adopt_parted_facets,
    find_joined,
    find_leftover_cylinders,
)
from autobalance.solid.chordal_error.strips import axes_of, find_cylinders, find_revolved, split_in_bands
from autobalance.solid.mesh.mesh import Mesh, ranked
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

MAX_SAG_WIDTH_RATIO = 0.5 * np.tan(SMOOTH_RAD / 4.0)
"""Sag of a chord at most, as a share of its width."""
MAX_SAG_RATIO = 100.0
"""Metal between facets and a surface over the estimate from their angles, at most: slivers hide much at
small angles, but a surface that was fitted to the wrong facets hundreds of times as much."""
NARROW_SHARE = 0.02
"""Extent across z, as a share of its cylinder's radius, up to which degree 2 is enough over a facet, to 1e-4
of its lens. Along an oil hole, across the crank, it is off by 1e-2 of what facets hide in polar inertia; over
a cone or a torus by 5e-3."""
COARSE_MOST = 2000
"""Triangles of a torus up to which they are integrated in quarters: over two chords of a fillet, 45° each,
degree 4 is 8e-4 off, more than the bar of a sure surface."""


@dataclass(frozen=True, eq=False)
class ChordalError:
    """Chord error: metal beyond the facets, up to the true surface (negative: less), and its error bars.

    Attributes
    ----------
    missing : Moments
        True minus mesh, estimated.
    mass_bar_g, unbalance_bar_g_mm : float
        Error bars of the missing mass and of its first moment across z.
    gross_mass_g, gross_unbalance_g_mm : float
        Sums of the magnitudes of the contributions, which partly cancel.
    sag_mm : float
        Largest distance of a facet from its fitted surface.
    surfaces : int
        Number of surfaces fitted.
    bar_at_mm : (float, float)
        Place of the unbalance's bar along z: means of z and of z², weighted with it.
    bar_share : float
        Share of ``missing`` by which it may be off equally in every plane, of a scan; it is in the bars.
    fitted : Fitted or None
        The surfaces and the planes of their facets, for the facets left after a cut.
    scanned : ScannedFacets or None
        The same of a scan, vertex by vertex.
    """

    missing: Moments
    mass_bar_g: float
    unbalance_bar_g_mm: float
    gross_mass_g: float
    gross_unbalance_g_mm: float
    sag_mm: float
    surfaces: int
    bar_at_mm: tuple[float, float] = (0.0, 0.0)
    fitted: Fitted | None = None
    scanned: ScannedFacets | None = None
    bar_share: float = 0.0

    @classmethod
    def known(cls, missing: Moments) -> ChordalError:
        """Return a chord error known from the true surface itself, without error bar."""
        gross = float(np.hypot(*missing.first_g_mm[:2]))
        return cls(missing, 0.0, 0.0, abs(missing.mass_g), gross, 0.0, 0)

    def left(self, vertices: Array, *, from_file: bool = False) -> ChordalError:
        """Return the error after a cut of a scan that left vertices (k, 3); unchanged for a drawn crank."""
        if self.scanned is None:
            return self
        scanned = self.scanned.left(vertices, from_file=from_file)
        missing = scanned.missing
        of_estimate = UNBALANCE_SHARE * float(np.hypot(*missing.first_g_mm[:2]))
        return replace(
            self,
            missing=missing,
            mass_bar_g=scanned.mass_bar_g,
            unbalance_bar_g_mm=math.hypot(of_estimate, scanned.scatter_g_mm),
        )

    @property
    def scatter_g_mm(self) -> float:
        """Part of the unbalance's bar that does not scale with ``missing`` [g·mm]."""
        if self.bar_share == 0.0:
            return self.unbalance_bar_g_mm
        of_estimate = self.bar_share * self.unbalance_g_mm
        return math.sqrt(max(self.unbalance_bar_g_mm**2 - of_estimate**2, 0.0))

    @property
    def is_sure(self) -> bool:
        """Whether mass and inertia are nearer to the truth with the estimate, even at the end of its bar."""
        return abs(self.missing.mass_g) >= 2.0 * self.mass_bar_g

    @property
    def is_sure_of_unbalance(self) -> bool:
        """Whether the unbalance is nearer to the truth with the estimate, even at the end of its bar."""
        return self.unbalance_g_mm >= 2.0 * self.unbalance_bar_g_mm

    @property
    def unbalance_g_mm(self) -> float:
        """Magnitude of the missing unbalance [g·mm]."""
        return float(np.hypot(*self.missing.first_g_mm[:2]))


def estimate_chordal_error(mesh: Mesh, density_g_mm3: float, frame: Array | None = None) -> ChordalError:
    """Estimate the chord error of a mesh's flat facets against the smooth surface they stand for.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm]; its corners on the true surface.
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float, optional
        From the mesh's coordinates to those the moments are wanted in, z along the crank.

    Returns
    -------
    ChordalError
        Zero if nothing is curved.
    """
    return chordal_error_of(look_at(mesh if frame is None else mesh.moved(frame)), density_g_mm3)


def chordal_error_of(look: Look, density_g_mm3: float) -> ChordalError:
    """Estimate the chord error of a mesh from its `Look`; see ``estimate_chordal_error``."""
    surface_of = np.full(look.count, -1)
    surfaces: list[Revolved] = []
    find_cylinders(look, surfaces, surface_of)
    find_revolved(look, surfaces, surface_of)
    find_leftover_cylinders(look, surfaces, surface_of)  # slower: only what is left
    find_joined(look, surfaces, surface_of, axes_of(look, surfaces, surface_of))
    adopt_cut_facets(look, surfaces, surface_of)
    return _summed(look, surfaces, surface_of, density_g_mm3)


def _summed(look: Look, surfaces: list[Revolved], surface_of: Indices, density_g_mm3: float) -> ChordalError:
    """Integrate between the facets and their surfaces, and add up the error bars."""
    lenses = _lenses(look, surfaces, surface_of, density_g_mm3)
    if adopt_parted_facets(look, surfaces, surface_of):
        lenses = _lenses(look, surfaces, surface_of, density_g_mm3)
    planes, either = accidents(look, surfaces, surface_of, lenses)
    if _split(look, surfaces, surface_of, planes):
        lenses = _lenses(look, surfaces, surface_of, density_g_mm3)
        either = np.append(either, np.zeros(len(surfaces) - len(either), dtype=bool))
    total = Moments.zero()
    gross_mass = gross_unbalance = sag = 0.0
    used = np.unique(surface_of[surface_of >= 0]).tolist()
    for number in used:
        of_piece = lenses[number]
        total = total + of_piece.moments
        gross_mass += of_piece.gross_mass_g
        gross_unbalance += of_piece.gross_unbalance_g_mm
        sag = max(sag, of_piece.sag_mm)
    bar = fitted_bar(look, surfaces, surface_of, lenses, either, density_g_mm3)
    bar = bar + loose_bar(look, surfaces, surface_of, sag, density_g_mm3)
    mean, mean_square = bar.along / (bar.unbalance_g_mm or 1.0)
    return ChordalError(
        total,
        bar.mass_g,
        bar.unbalance_g_mm,
        gross_mass,
        gross_unbalance,
        sag,
        len(used),
        (float(mean), float(mean_square)),
        _fitted(look, surfaces, surface_of, density_g_mm3),
    )


def _lenses(look: Look, surfaces: list[Revolved], surface_of: Indices, density_g_mm3: float) -> list[Lens]:
    """Integrate between the facets and their surfaces; release the faces of false ones."""
    parts = _triangles_of(look, surface_of, len(surfaces))
    lenses = []
    for surface, mine in zip(surfaces, parts, strict=True):
        corners = look.mesh.vertices.take(look.mesh.triangles.take(mine, axis=0), axis=0)
        narrow = not surface.tube_mm and not surface.slope
        narrow = narrow and _extent_mm(corners) <= NARROW_SHARE * surface.r0
        coarse = surface.tube_mm and len(mine) <= COARSE_MOST
        rule = THREE_POINTS if narrow else IN_QUARTERS if coarse else SIX_POINTS
        lenses.append(lens(surface, corners, look.doubled.take(mine, axis=0), density_g_mm3, rule))
    _drop_false(look, parts, lenses, surface_of, density_g_mm3)
    return lenses


def _extent_mm(corners: Array) -> float:
    """Return the largest extent of a triangle (m, 3, 3) along x or y."""
    sides = corners[:, :, :2] - corners[:, (1, 2, 0), :2]
    return float(np.abs(sides).max(initial=0.0))


def _split(look: Look, surfaces: list[Revolved], surface_of: Indices, planes: Flags) -> bool:
    """Take planes for what they are, and a torus through few cones for these; return whether any was one."""
    for number in np.flatnonzero(planes).tolist():
        faces = np.flatnonzero(surface_of == number)
        surface_of[faces] = FLAT
        if not surfaces[number].tube_mm:
            continue
        for fitted, mine in split_in_bands(look, surfaces[number], faces):
            surface_of[mine] = len(surfaces)
            surfaces.append(fitted)
    return bool(planes.any())


def _fitted(look: Look, surfaces: list[Revolved], surface_of: Indices, density_g_mm3: float) -> Fitted:
    """Return the surfaces, and the plane of each face that belongs to one."""
    faces = np.flatnonzero(surface_of >= 0)
    number = surface_of[faces]
    corner = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]], 0]]
    height = np.einsum("ij,ij->i", corner, look.normal[faces])
    return Fitted(tuple(surfaces), look.normal[faces], height, number, look.mesh.diagonal_mm, density_g_mm3)


def _triangles_of(look: Look, surface_of: Indices, surfaces: int) -> list[Indices]:
    """Return the triangles of the faces of each surface."""
    number = surface_of.take(look.face)
    rows = np.flatnonzero(number >= 0)
    number, order = ranked(number.take(rows))
    bounds = np.searchsorted(number, np.arange(surfaces + 1))
    rows = rows.take(order)
    return [rows[begin:end] for begin, end in pairwise(bounds)]


def _drop_false(
    look: Look, parts: list[Indices], lenses: list[Lens], surface_of: Indices, density_g_mm3: float
) -> None:
    """Release the faces of surfaces that were fitted to the wrong ones.

    Some face has more between it and its surface than a chord of its size can have, or all of them together
    have much more than their angles suggest.
    """
    if not any(len(part) for part in parts):
        return
    held = np.bincount(
        look.face.take(np.concatenate(parts)), np.concatenate([one.volumes for one in lenses]), look.count
    )
    thick = held > MAX_SAG_WIDTH_RATIO * look.area_mm2 * look.reach_mm + 1e-300
    mine = surface_of >= 0
    stake = np.bincount(surface_of[mine], look.at_stake[mine], len(parts))
    false = np.array([one.gross_mass_g for one in lenses]) > MAX_SAG_RATIO * density_g_mm3 * stake
    false[surface_of[thick & mine]] = True
    surface_of[mine & false[surface_of]] = -1
