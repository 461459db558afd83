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
from autobalance.solid.chordal_error import bars
from autobalance.solid.chordal_error.look import SMOOTH_RAD, Look, look_at, tight_mm
from autobalance.solid.chordal_error.revolved import (
    IN_QUARTERS,
    SIX_POINTS,
    THREE_POINTS,
    Fitted,
    Lens,
    RevolvedSurface,
    lens,
)
from autobalance.solid.chordal_error.samples import find_in_samples
from autobalance.solid.chordal_error.scanned_facets import UNBALANCE_SHARE, ScannedFacets
from autobalance.solid.chordal_error.seeds import (
    adopt_cut_facets,
    adopt_parted_facets,
    find_joined,
    find_leftover_cylinders,
)
from autobalance.solid.chordal_error.strips import (
    axes_of,
    find_cylinders,
    find_revolved,
    split_in_bands,
)
from autobalance.solid.mesh.mesh import CHUNK, Mesh, ranked
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
LENS_MOST, LENS_SAMPLE = 4000, 2000
"""Triangles of a surface up to which each is integrated, and the number of a sample of more."""
STEEP_BESIDE, STEEP_IN_A_ROW = 4, 5
"""Faces of a surface that steep triangles may lie on, at least, and such triangles side by side at most: a
kernel lays one or two from rim to rim of a fillet."""
SPREADS = 2.0
"""Error bar of a sample, in standard errors."""
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


def chordal_error_of(
    look: Look, density_g_mm3: float, *, sampled: bool = False, with_fits: bool = True
) -> ChordalError:
    """Estimate the chord error of a mesh from its `Look`; see ``estimate_chordal_error``.

    With ``sampled`` surfaces are sought in a sample of the facets, and carried from there to all.
    """
    surface_of = np.full(look.count, -1)
    surfaces: list[RevolvedSurface] = []
    if sampled:
        find_in_samples(look, surfaces, surface_of)
    else:
        find_cylinders(look, surfaces, surface_of)
        find_revolved(look, surfaces, surface_of, axes_of(look, surfaces, surface_of))
        find_leftover_cylinders(look, surfaces, surface_of)  # slower: only what is left
        find_joined(look, surfaces, surface_of, axes_of(look, surfaces, surface_of))
        adopt_cut_facets(look, surfaces, surface_of)
    return _summed(look, surfaces, surface_of, density_g_mm3, with_fits)


def _summed(
    look: Look,
    surfaces: list[RevolvedSurface],
    surface_of: Indices,
    density_g_mm3: float,
    with_fits: bool,
) -> ChordalError:
    """Integrate between the facets and their surfaces, and add up the error bars."""
    lenses = _lenses(look, surfaces, surface_of, density_g_mm3)
    before = surface_of.copy()
    if adopt_parted_facets(look, surfaces, surface_of):
        lenses = _lenses(look, surfaces, surface_of, density_g_mm3, (before, lenses))
    angles = bars.largest_angles(look, surfaces, surface_of)
    planes, either = bars.accidents(look, surfaces, surface_of, lenses, angles)
    before = surface_of.copy()
    if _split(look, surfaces, surface_of, planes):
        lenses = _lenses(look, surfaces, surface_of, density_g_mm3, (before, lenses))
        either = np.append(either, np.zeros(len(surfaces) - len(either), dtype=bool))
        angles = bars.largest_angles(look, surfaces, surface_of)
    total = Moments.zero()
    gross_mass = gross_unbalance = sag = 0.0
    used = np.unique(surface_of[surface_of >= 0]).tolist()
    for number in used:
        of_piece = lenses[number]
        total = total + of_piece.moments
        gross_mass += of_piece.gross_mass_g
        gross_unbalance += of_piece.gross_unbalance_g_mm
        sag = max(sag, of_piece.sag_mm)
    bar = bars.fitted_bar(look, surfaces, surface_of, lenses, either, angles, density_g_mm3)
    bar = bar + bars.loose_bar(look, surfaces, surface_of, sag, angles, density_g_mm3)
    bar = bar + _steep_bar(look, surfaces, surface_of, density_g_mm3)
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
        _fitted(look, surfaces, surface_of, density_g_mm3) if with_fits else None,
    )


def _lenses(
    look: Look,
    surfaces: list[RevolvedSurface],
    surface_of: Indices,
    density_g_mm3: float,
    before: tuple[Indices, list[Lens]] | None = None,
) -> list[Lens]:
    """Integrate between the facets and their surfaces; release the faces of false ones.

    Lenses ``before``, with the surface (count,) of each face then, are kept if no face has changed.
    """
    new = np.zeros(len(surfaces) + 2, dtype=bool)
    new[0 if before is None else len(before[1]) : len(surfaces)] = True
    if before is not None:
        changed = np.flatnonzero(surface_of != before[0])
        new[surface_of[changed]] = new[before[0][changed]] = True
    new[len(surfaces) :] = False  # of no surface, and of planes
    parts = _triangles_of(look, surface_of, new[: len(surfaces)])
    lenses: list[Lens] = []
    for number, (surface, mine) in enumerate(zip(surfaces, parts, strict=True)):
        if before is not None and not new[number]:
            lenses.append(before[1][number])
            continue
        rows = mine if len(mine) <= LENS_MOST else mine.take(_spread_rows(len(mine), LENS_SAMPLE))
        corners = look.mesh.vertices.take(look.mesh.triangles.take(rows, axis=0), axis=0)
        narrow = not surface.tube_mm and not surface.slope
        narrow = narrow and _extent_mm(corners) <= NARROW_SHARE * surface.r0
        coarse = surface.tube_mm and len(mine) <= COARSE_MOST
        rule = THREE_POINTS if narrow else IN_QUARTERS if coarse else SIX_POINTS
        one = lens(surface, corners, look.doubled.take(rows, axis=0), density_g_mm3, rule)
        one = one if len(rows) == len(mine) else _of_all(look, one, rows, mine, density_g_mm3)
        lenses.append(replace(one, rows=rows))
    _drop_false(look, [one.rows for one in lenses], lenses, surface_of, density_g_mm3)
    return lenses


def _of_all(look: Look, one: Lens, rows: Indices, every: Indices, density_g_mm3: float) -> Lens:
    """Return the lens over all triangles (m,) of a surface, from one over a sample (k,) of them.

    Over each triangle it is as its area, except for what the sample differs: by its spread the whole is off.
    """
    some, whole = (_of_areas(look, each) for each in (rows, every))
    density = one.moments.mass_g / some.mass_g
    times = whole.mass_g / some.mass_g
    moments = whole.scaled(density) + (one.moments + some.scaled(-density)).scaled(times)
    area = 0.5 * look.mesh.doubled_areas.take(rows)
    apart = density_g_mm3 * one.volumes - abs(density) * area
    middle = look.mesh.vertices.take(look.mesh.triangles.take(rows, axis=0), axis=0).mean(axis=1)
    sure = SPREADS * len(every) / len(rows) * math.sqrt(1.0 - len(rows) / len(every))
    out = np.hypot(middle[:, 0], middle[:, 1])
    spread = (sure * float(np.linalg.norm(apart)), sure * float(np.linalg.norm(apart * out)))
    return replace(
        one,
        moments=moments,
        gross_mass_g=times * one.gross_mass_g,
        gross_unbalance_g_mm=times * one.gross_unbalance_g_mm,
        gross_at=times * one.gross_at,
        spread=spread,
    )


def _of_areas(look: Look, rows: Indices) -> Moments:
    """Return the moments of triangles, their areas [mm²] in place of their masses."""
    axes, total = look.vertices, Moments.zero()
    for begin in range(0, len(rows), CHUNK):
        some = rows[begin : begin + CHUNK]
        corners = axes.take(look.mesh.triangles.take(some, axis=0).T, axis=1)
        middle, area = corners.mean(axis=1), 0.5 * look.mesh.doubled_areas.take(some)
        total = total + Moments(float(area.sum()), middle @ area, (middle * area) @ middle.T)
    return total


def _spread_rows(count: int, some: int) -> Indices:
    """Return ``some`` rows of ``count``, one at random in each of as many stretches."""
    bounds = np.linspace(0, count, some + 1)
    place = bounds[:-1] + np.random.default_rng(some).random(some) * np.diff(bounds)
    return place.astype(np.int64)


def _extent_mm(corners: Array) -> float:
    """Return the largest extent of a triangle (m, 3, 3) along x or y."""
    sides = corners[:, :, :2] - corners[:, (1, 2, 0), :2]
    return float(np.abs(sides).max(initial=0.0))


def _split(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, planes: Flags) -> bool:
    """Take planes for what they are, and a torus through few cones for these; return whether any was one."""
    for number in np.flatnonzero(planes).tolist():
        faces = np.flatnonzero(surface_of == number)
        surface_of[faces] = bars.FLAT
        if not surfaces[number].tube_mm:
            continue
        for fitted, mine in split_in_bands(look, surfaces[number], faces):
            surface_of[mine] = len(surfaces)
            surfaces.append(fitted)
    return bool(planes.any())


def _steep_bar(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, density_g_mm3: float
) -> bars.ErrorBar:
    """Return the error bar of lone triangles that have all corners on a surface beside them.

    They turn by more than a real edge does, or are deeper than other chords. But a CAD kernel lays such ones
    over a fillet at coarse angles, from rim to rim, and beside holes: four fillets of 39 each hid three times
    the error bar. A flat on a shaft has four corners, and is real.
    """
    count = np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces))
    known = np.append(count >= STEEP_BESIDE, [False, False])  # of no surface, and of planes: the last
    open_ = (surface_of == -1) & (look.sizes == 1) & (look.corner_counts == 3)
    ways = look.edges.left, look.edges.right
    rows = np.flatnonzero(open_.take(look.face.take(ways[0])) | open_.take(look.face.take(ways[1])))
    one, other = (look.face.take(way.take(rows)) for way in ways)
    both = np.stack([np.append(one, other), np.append(other, one)])
    both = both[:, open_[both[0]]]
    tight, of = tight_mm(look), surface_of.copy()
    total = bars.ErrorBar(0.0, 0.0, np.zeros(2))
    for _ in range(STEEP_IN_A_ROW):
        face, source = both[:, (of[both[0]] == -1) & known[of[both[1]]]]
        before = np.unique(np.stack([of[source], face]), axis=1)
        found = False
        for number in np.unique(before[0]).tolist():
            mine = before[1, (before[0] == number) & (of[before[1]] == -1)]
            row, corner = look.corners(mine)
            off = np.bincount(row, np.abs(surfaces[number].off(corner)) > tight, len(mine))
            mine = mine[(off == 0) & ~_is_across(look, surfaces[number], mine)]
            of[mine], found = number, found or len(mine) > 0
            rows = look.order.take(look.starts.take(mine))
            corners = look.mesh.vertices.take(look.mesh.triangles.take(rows, axis=0), axis=0)
            held = lens(
                surfaces[number], corners, look.doubled.take(rows, axis=0), density_g_mm3, IN_QUARTERS
            )
            total = total + bars.ErrorBar(
                bars.EITHER_SHARE * held.gross_mass_g,
                bars.EITHER_SHARE * held.gross_unbalance_g_mm,
                bars.EITHER_SHARE * held.gross_at,
            )
        if not found:
            break
    return total


def _is_across(look: Look, surface: RevolvedSurface, faces: Indices) -> Flags:
    """Mark the faces (k,) that lean to a surface by more than a chord may, as the end of a shaft does."""
    normal = surface.normal(look.first_middles(faces))
    along = np.abs(np.einsum("ij,ij->i", normal, look.normal.take(faces, axis=0)))
    return np.asarray(along < np.cos(SMOOTH_RAD))


def _fitted(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, density_g_mm3: float) -> Fitted:
    """Return the surfaces, and the plane of each face that belongs to one."""
    faces = np.flatnonzero(surface_of >= 0)
    number = surface_of[faces]
    corner = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]], 0]]
    height = np.einsum("ij,ij->i", corner, look.normal[faces])
    return Fitted(tuple(surfaces), look.normal[faces], height, number, look.mesh.diagonal_mm, density_g_mm3)


def _triangles_of(look: Look, surface_of: Indices, asked: Flags) -> list[Indices]:
    """Return the triangles of the faces of each surface asked (k,); none of others."""
    wanted = np.append(asked, [False, False])[surface_of]
    rows = np.flatnonzero(wanted.take(look.face))
    number, order = ranked(surface_of.take(look.face.take(rows)))
    bounds = np.searchsorted(number, np.arange(len(asked) + 1))
    rows = rows.take(order)
    return [rows[begin:end] for begin, end in pairwise(bounds)]


def _drop_false(
    look: Look, parts: list[Indices], lenses: list[Lens], surface_of: Indices, density_g_mm3: float
) -> None:
    """Release the faces of surfaces that were fitted to the wrong ones.

    Some face has more between it and its surface than a chord of its size can have, or all of them together
    have much more than their angles suggest. Of a surface of very many a sample, ``parts``, is looked at.
    """
    if not any(len(part) for part in parts):
        return
    face, volume = look.face.take(np.concatenate(parts)), np.concatenate([one.volumes for one in lenses])
    held = np.bincount(face, volume, look.count)
    faces = np.flatnonzero((held > 0.0) & (surface_of >= 0))
    number = surface_of.take(faces)
    held, area = held.take(faces), MAX_SAG_WIDTH_RATIO * look.area_mm2.take(faces)
    thick = (
        held > area * np.sqrt(look.area_mm2.take(faces)) + 1e-300
    )  # no face reaches less than the root of its area
    thick[thick] = held[thick] > area[thick] * look.reach_mm(faces[thick]) + 1e-300
    whole = np.array([one.spread == (0.0, 0.0) for one in lenses])
    some = faces[whole[number]]
    at_stake = look.at_stake.take(some) if whole.all() else look.part(some).at_stake
    stake = np.bincount(surface_of[some], at_stake, len(parts))
    false = whole & (np.array([one.gross_mass_g for one in lenses]) > MAX_SAG_RATIO * density_g_mm3 * stake)
    false[number[thick]] = True
    mine = surface_of >= 0
    surface_of[mine & false[surface_of]] = -1
