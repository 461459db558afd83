"""Seeds of surfaces on a mesh, and the creases between."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from autobalance.solid.chordal_error.look import ON_SURFACE, SMOOTH_RAD, Look, lies_on, tight_mm
from autobalance.solid.chordal_error.revolved import (
    RevolvedSurface,
    Sets,
    circles,
    cylinders,
    cylindrical,
    least_directions,
    lines,
)
from autobalance.solid.chordal_error.strips import IDLE_AXES, MIN_SURE_FACES, AroundAxis, cone, torus
from autobalance.solid.mesh.adjacency import Edges, edges_of
from autobalance.solid.mesh.mesh import Mesh, longest_sides, numbered_components
from autobalance.solid.roughness import spread
from autobalance.types import Array, Flags, Indices

# Cylinders, cones and tori from a few facets at a time: irregular ones, and surfaces that join smoothly.
#
# Corners between smooth facets lie on the true surface except for rounding; a surface through a few of them
# that passes through many others as exactly is not an accident.


LEAST_FACETS = 6
"""Smallest facets of a piece that is tried."""
LEAST_POINTS = 8
"""Corners that a cylinder is fitted to at least; five would make one of any."""
SEEDS = 10
"""Places of a piece that are tried."""
SEED_SIZES = 12, 30
"""Facets that a surface is fitted to at a time."""
PIECES_MOST = 400
"""Most pieces that are tried, those with most at stake."""
POINTS_MOST = 200
"""Corners that a cylinder is fitted to at most."""
ADOPTED_IN_A_ROW = 50
"""Cut facets side by side that are assigned at most, from both ends of a hole's rim: 20 at 256 segments,
where an oil hole opens into a pin's bore of four times its width."""
PARTED_SAGS = 1.5
"""Depth of a facet at most that is assigned to a surface, in sags of the surface's deepest: a flat that is
milled on a shaft has its corners on it, too."""
DEPTHS_MOST = 2000
"""Facets of a surface whose depths are looked at for its deepest."""
MAX_AXIAL_COMPONENT = 0.2
"""Part of a facet's direction along the axis of its cylinder, at most."""
WORTH_SHARE = 0.999
"""Share of all smooth faces' estimate that is tried; the pieces that share the rest are not worth it."""


class Points:
    """The corners at the smooth edges of each face."""

    def __init__(self, look: Look) -> None:
        ends = look.edges.ends[look.smooth].reshape(-1)
        face = np.repeat(np.concatenate(look.pairs), 2)
        real = np.flatnonzero(look.is_corner[np.tile(ends, 2)])
        face, ends = face[real], np.tile(ends, 2)[real]
        order = np.argsort(face, kind="stable")
        self._ends = ends[order]
        self._starts = np.searchsorted(face[order], np.arange(look.count + 1))
        self._vertices = look.mesh.vertices

    def of(self, faces: Indices) -> tuple[Indices, Array]:
        """Return the points of some faces: (row in ``faces``, point (n, 3))."""
        row, number = self._numbers(faces)
        return row, self._vertices[number]

    def _numbers(self, faces: Indices) -> tuple[Indices, Indices]:
        low, high = self._starts[faces], self._starts[faces + 1]
        row = np.repeat(np.arange(len(faces)), high - low)
        within = np.arange(len(row)) - np.repeat(np.cumsum(high - low) - (high - low), high - low)
        return row, self._ends[low[row] + within]

    def distinct(self, faces: Indices, sets: Sets) -> tuple[Array, Indices]:
        """Return distinct points (n, 3) of sets of faces, about ``POINTS_MOST`` each, and their sets (n,)."""
        row, number = self._numbers(faces)
        many = len(self._vertices)
        own = np.unique(sets.number[row] * many + number)
        which, number = own // many, own % many
        size = np.bincount(which, minlength=len(sets.starts))
        within = np.arange(len(own)) - (np.cumsum(size) - size)[which]
        kept = within % np.maximum(1, size // POINTS_MOST)[which] == 0
        points: Array = self._vertices[number[kept]]
        return points, which[kept]


def find_leftover_cylinders(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Fit cylinders of any axis to pieces of smooth facets that no strip of chords showed."""
    points = Points(look)
    tight = tight_mm(look)
    tries = _tries(look, _pieces(look, surface_of))
    for piece, fits in tries.grouped(_cylinders(look, points, tries, tight)):
        left = piece
        for seed, fitted in fits:
            if len(left) < LEAST_FACETS:
                break
            if np.isin(seed, left).all():
                left = _taken(look, points, fitted, left, len(seed), tight, surfaces, surface_of)


def find_joined(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, axes: list[tuple[Array, Array]]
) -> None:
    """Fit cones, tori and cylinders about known axes to parts of pieces in which several join smoothly."""
    points = Points(look)
    tight = tight_mm(look)
    i, j = look.pairs
    idle = 0
    for point, axis in axes:
        free = (surface_of[i] < 0) & (surface_of[j] < 0)
        i, j = i[free], j[free]
        if len(i) == 0 or idle == IDLE_AXES:
            return
        before = len(surfaces)
        faces, patches = AroundAxis.of(look, i, j, point, axis).patches(-1.0, 1.0 - 1e-8)
        tries = _tries(look, _worth(look, np.split(faces, patches.starts[1:])))
        for piece, fits in tries.grouped(_profiles(points, tries, point, axis, tight)):
            left = piece
            for seed, fitted in fits:
                if len(left) < LEAST_FACETS:
                    break
                if np.isin(seed, left).all():
                    left = _taken(look, points, fitted, left, len(seed), tight, surfaces, surface_of)
        idle = 0 if len(surfaces) > before else idle + 1


def adopt_cut_facets(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Assign to sure surfaces the facets beside theirs that a hole's rim cuts, as no fit to a few may say.

    Such a facet has two corners exactly on the surface; the others lie on its own chord, so not outside, nor
    deeper than the surface's deepest. Free facets are taken, and those of surfaces that few others share.
    Slivers without direction part the facets of one chord, which then meet at no angle.
    """
    tight = tight_mm(look)
    i, j = (np.concatenate(pair) for pair in zip(look.pairs, look.parted, strict=True))
    count = np.append(np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces)), 0)
    sure = np.append(count[:-1] >= MIN_SURE_FACES, False)  # the last is none
    unsure = ~sure.take(surface_of) & look.small
    here, there = np.flatnonzero(unsure.take(i)), np.flatnonzero(unsure.take(j))
    both = np.stack([np.append(i[here], j[there]), np.append(j[here], i[there])])
    deepest: dict[int, float] = {}
    fresh = np.ones(look.count, dtype=bool)
    for _ in range(ADOPTED_IN_A_ROW):
        face, source = both[:, fresh.take(both[1])]
        kept = sure[surface_of[source]] & ~sure[surface_of[face]]
        face, source = face[kept], source[kept]
        if len(face) == 0:
            return
        fresh[:] = False
        pairs = np.unique(np.stack([surface_of[source], face]), axis=1)
        sets = Sets.of(pairs[0])
        for start, size in zip(sets.starts.tolist(), sets.sizes.tolist(), strict=True):
            number, mine = int(pairs[0, start]), pairs[1, start : start + size]
            if number not in deepest:
                deepest[number] = _deepest_mm(look, surfaces[number], np.flatnonzero(surface_of == number))
            mine = mine[_cut_from(look, surfaces[number], deepest[number], mine, tight)]
            np.subtract.at(count, surface_of[mine], 1)  # of no surface: the last
            count[number] += len(mine)
            surface_of[mine] = number
            fresh[mine] = True
        sure[:-1] = count[:-1] >= MIN_SURE_FACES


def adopt_parted_facets(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> bool:
    """Assign to sure surfaces the free facets that have all corners exactly on them; return whether any has.

    Where a hole opens into a journal the CAD kernel lays slender triangles from its rim to the ends of the
    journal. They meet at small angles, and hide hundreds of times what these show: their own surface is
    dropped as false. That was 4 % of what the journal hides, and twice the error bar.
    """
    tight = tight_mm(look)
    smooth = np.zeros(look.count, dtype=bool)
    for faces in (*look.pairs, *look.parted):
        smooth[faces] = True
    free = np.flatnonzero(smooth & (surface_of == -1) & look.small)
    count = np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces))
    sure, before = np.flatnonzero(count >= MIN_SURE_FACES), len(free)
    for number in sure[np.argsort(-count[sure], kind="stable")].tolist():
        if len(free) == 0:
            break
        surface, mine = surfaces[number], np.flatnonzero(surface_of == number)
        row, corner = look.corners(free)
        off = np.zeros(len(free))
        np.maximum.at(off, row, np.abs(surface.off(corner)))
        deepest = min(_deepest_mm(look, surface, mine), 0.0)
        deep = surface.off(look.first_middles(free)) < PARTED_SAGS * deepest - tight
        some = free[(off <= tight) & ~deep]
        surface_of[some[lies_on(look, surface, some)]] = number
        free = free[surface_of[free] == -1]
    return len(free) < before


def _deepest_mm(look: Look, surface: RevolvedSurface, faces: Indices) -> float:
    """Return the height of the deepest middle of faces (k,) over a surface; of very many some count."""
    some = faces[:: 1 + len(faces) // DEPTHS_MOST]
    return float(surface.off(look.first_middles(some)).min())


def _cut_from(look: Look, surface: RevolvedSurface, deepest: float, beside: Indices, tight: float) -> Flags:
    """Mark the faces ``beside`` (k,) that are cut from chords of a surface, at most ``deepest`` under it."""
    row, corner = look.corners(beside)
    off = surface.off(corner)
    exact = np.bincount(row, np.abs(off) <= tight, len(beside))
    fits = exact >= 2
    fits[row[(off > tight) | (off < PARTED_SAGS * min(deepest, 0.0) - tight)]] = False
    return np.asarray(fits & lies_on(look, surface, beside))


def _taken(
    look: Look,
    points: Points,
    fitted: RevolvedSurface,
    left: Indices,
    size: int,
    tight: float,
    surfaces: list[RevolvedSurface],
    surface_of: Indices,
) -> Indices:
    """Assign to a surface the faces on it if they are enough for a seed of ``size``; return those left."""
    on = _on(look, points, fitted, left, tight)
    if on.sum() < max(LEAST_FACETS, size // 2):
        return left
    surface_of[left[on]] = len(surfaces)
    surfaces.append(fitted)
    return left[~on]


def _pieces(look: Look, surface_of: Indices) -> list[Indices]:
    """Return the connected pieces of smooth faces without a surface that have most at stake."""
    i, j = look.pairs
    free = (surface_of[i] < 0) & (surface_of[j] < 0) & look.small[i] & look.small[j]
    if not free.any():
        return []
    faces, pairs = np.unique(np.concatenate([i[free], j[free]]), return_inverse=True)
    label = numbered_components(pairs.reshape(2, -1).T, len(faces))[0]
    order = np.argsort(label, kind="stable")
    cuts = np.flatnonzero(np.diff(label[order])) + 1
    return _worth(look, np.split(faces[order], cuts))


def _worth(look: Look, pieces: list[Indices]) -> list[Indices]:
    """Return the pieces at which most is at stake, the largest first."""
    pieces = [piece for piece in pieces if len(piece) >= LEAST_FACETS]
    stake = np.array([float(look.at_stake[piece].sum()) for piece in pieces])
    order = np.argsort(-stake, kind="stable")[:PIECES_MOST]
    beyond = stake.sum() - np.cumsum(stake[order])  # with all the lesser ones
    whole = float(look.at_stake.sum())
    enough = int(np.count_nonzero(beyond + stake[order] > (1.0 - WORTH_SHARE) * whole))
    return [pieces[place] for place in order[:enough].tolist()]


class _Tries:
    """Seeds of pieces: sets of faces that a surface is fitted to, all at once."""

    def __init__(self, pieces: list[Indices], seeds: list[list[Indices]]) -> None:
        self._pieces = pieces
        self._seeds = [seed for some in seeds for seed in some]
        self._owner = np.repeat(np.arange(len(pieces)), [len(some) for some in seeds])
        sizes = np.array([len(seed) for seed in self._seeds], dtype=np.int64)
        self.faces = np.concatenate([*self._seeds, np.zeros(0, dtype=np.int64)])
        self.sets = Sets(np.cumsum(sizes) - sizes, len(self.faces))

    def grouped(
        self, fitted: dict[int, RevolvedSurface]
    ) -> Iterator[tuple[Indices, list[tuple[Indices, RevolvedSurface]]]]:
        """Yield each piece with its seeds that were fitted, by their numbers, and the surfaces."""
        by_piece: dict[int, list[tuple[Indices, RevolvedSurface]]] = {}
        for number, surface in sorted(fitted.items()):
            by_piece.setdefault(int(self._owner[number]), []).append((self._seeds[number], surface))
        for owner, some in by_piece.items():
            yield self._pieces[owner], some


def _tries(look: Look, pieces: list[Indices]) -> _Tries:
    return _Tries(pieces, [_seeds(look, piece) for piece in pieces])


def _seeds(look: Look, piece: Indices) -> list[Indices]:
    """Return the whole piece, then facets near each other at places spread over it."""
    middle = look.first_middles(piece)
    seeds = [piece]
    sizes = [size for size in SEED_SIZES if size < len(piece)]
    if not sizes:
        return seeds
    places = np.unique(np.linspace(0, len(piece) - 1, SEEDS).astype(np.int64))
    for place in places:
        apart = np.square(middle - middle[place]).sum(axis=1)
        near = np.argpartition(apart, sizes[-1] - 1)[: sizes[-1]]
        near = near[np.argsort(apart[near], kind="stable")]
        seeds += [piece[near[:size]] for size in sizes]
    return seeds


def _on(look: Look, points: Points, surface: RevolvedSurface, faces: Indices, tight: float) -> Flags:
    """Mark the faces (k,) that lie on a surface, their points within ``tight``."""
    row, point = points.of(faces)
    worst = np.zeros(len(faces))
    np.maximum.at(worst, row, np.abs(surface.off(point)))
    counts = np.bincount(row, minlength=len(faces)) > 0
    return np.asarray(counts & (worst <= tight) & lies_on(look, surface, faces))


def _cylinders(look: Look, points: Points, tries: _Tries, tight: float) -> dict[int, RevolvedSurface]:
    """Fit a cylinder to the points of each seed; return those that pass through all of them."""
    if len(tries.faces) == 0:
        return {}
    normal = look.normal[tries.faces]
    axis = least_directions(normal, tries.sets)
    lean = np.abs(np.einsum("ij,ij->i", normal, axis[tries.sets.number]))
    some, which = points.distinct(tries.faces, tries.sets)
    count = np.bincount(which, minlength=len(axis))
    tried = np.flatnonzero((tries.sets.most(lean) <= MAX_AXIAL_COMPONENT) & (count >= LEAST_POINTS))
    rows = np.isin(which, tried)
    if not rows.any():
        return {}
    fits_of = cylinders(some[rows], Sets.of(which[rows]), axis[tried], tight, look.mesh.diagonal_mm)
    fits = (fits_of.swept >= ON_SURFACE) & (fits_of.worst_mm <= tight)
    return {
        int(tried[one]): RevolvedSurface(fits_of.point[one], fits_of.axis[one], float(fits_of.radius[one]))
        for one in np.flatnonzero(fits).tolist()
    }


def _profiles(
    points: Points, tries: _Tries, point: Array, axis: Array, tight: float
) -> dict[int, RevolvedSurface]:
    """Return the line or the arc through the profile of each seed, if there is one."""
    if len(tries.faces) == 0:
        return {}
    row, corner = points.of(tries.faces)
    h, r, _ = cylindrical(corner, point, axis)
    number = tries.sets.number[row]
    sets, profile = Sets.of(number), np.stack([r, h], axis=1)
    owner = number[sets.starts]
    straight, round_ = lines(profile, sets), circles(profile, sets)
    is_line = straight.worst_mm <= tight
    is_arc = ~is_line & (round_.worst_mm <= tight) & (round_.radius > 10.0 * tight)
    is_line &= np.abs(straight.direction[:, 1]) > 1e-9
    surfaces = {}
    for one in np.flatnonzero(is_line).tolist():
        surfaces[int(owner[one])] = cone(point, axis, straight.middle[one], straight.direction[one])
    for one in np.flatnonzero(is_arc & np.isfinite(round_.radius)).tolist():
        surfaces[int(owner[one])] = torus(point, axis, round_.centre[one], float(round_.radius[one]))
    return surfaces


# Sharp edges of a part: lines of its mesh, or cut off by triangles that were laid evenly over them.
#
# An edge that is a line of the mesh runs on to where others meet it. Of one that triangles cut off, pieces
# are left that end alone: the corners between them lie on its rounding, or beside it.


FRAYED_SHARE, WHOLE_SHARE = 0.2, 0.1
"""Share of the corners at sharp edges in which one ends alone. From the first on they are cut off: 0.4 to
0.55 of cranks meshed evenly by triangles of 0.7 to 2.5 mm, waved by 0 to 50 µm, decimated too. Up to the
second they are lines: 0.02 of presets at most, 0.06 of v-hacd's crank.off, 0.03 of split facets waved."""
FEW_SHARP = 100
"""Fewer corners at sharp edges show nothing: a crank of smooth blends has four, each the end of an edge."""
HEIGHT_ROUGHNESSES = 5.0
"""Triangles lower than so many times the roughness lean any way: slivers beside slivers look like edges."""
LOOKED_AT = 40_000
"""Vertices of a scan that are looked at: 3 % and more of a crank's lie at its sharp edges."""


def cuts_edges_off(look: Look) -> bool:
    """Return whether the part's sharp edges miss the lines of a mesh without noise."""
    every = np.ones(len(look.mesh.vertices), dtype=bool)
    share = _ending_share(look.edges, look.edges.angle_rad > SMOOTH_RAD, every)
    return share is not None and share > FRAYED_SHARE


def apart_at_sharp_edges(mesh: Mesh, roughness_mm: float) -> Mesh:
    """Return a scan whose triangles share no vertex across a sharp edge, where its edges are lines of it.

    The same triangles in the same order; the mesh itself where it cuts edges off, or shows too few.
    """
    if not _has_whole_edges(mesh, roughness_mm):
        return mesh
    edges = edges_of(mesh)
    sharp = edges.angle_rad > SMOOTH_RAD
    at = np.zeros(len(mesh.vertices), dtype=bool)
    at[edges.ends[sharp]] = True
    corners = np.flatnonzero(at[mesh.triangles].reshape(-1))
    rank = np.zeros(mesh.triangles.size, dtype=np.int64)
    rank[corners] = np.arange(len(corners))
    links = np.concatenate([_joined(mesh, edges, ~sharp & at[end], end) for end in edges.ends.T])
    number, count = numbered_components(rank[links], len(corners))
    vertex = np.zeros(count, dtype=np.int64)
    vertex[number] = mesh.triangles.reshape(-1)[corners]
    triangles = mesh.triangles.reshape(-1).copy()
    triangles[corners] = len(mesh.vertices) + number
    return Mesh(np.concatenate([mesh.vertices, mesh.vertices[vertex]]), triangles.reshape(-1, 3))


def _joined(mesh: Mesh, edges: Edges, kept: Flags, end: Indices) -> Indices:
    """Return the corners (k, 2) of the two triangles beside each of the edges kept, at one of its ends."""
    rows = np.flatnonzero(kept)
    corners = []
    for triangle in (edges.left[rows], edges.right[rows]):
        place = np.argmax(mesh.triangles[triangle] == end[rows, None], axis=1)
        corners.append(3 * triangle + place)
    return np.stack(corners, axis=1)


def _has_whole_edges(mesh: Mesh, roughness_mm: float) -> bool:
    looked = spread(mesh, LOOKED_AT)
    part = Mesh(mesh.vertices, mesh.triangles[looked[mesh.triangles].any(axis=1)])
    edges = edges_of(part)
    known = _heights_mm(part) > HEIGHT_ROUGHNESSES * roughness_mm
    sure = known[edges.left] & known[edges.right]
    looked[edges.ends[~sure]] = False
    share = _ending_share(edges, sure & (edges.angle_rad > SMOOTH_RAD), looked)
    return share is not None and share < WHOLE_SHARE


def _heights_mm(mesh: Mesh) -> Array:
    """Return each triangle's height (m,) over its longest side."""
    longest = longest_sides(mesh.corners)
    height: Array = mesh.doubled_areas / np.where(longest > 0.0, longest, 1.0)
    return height


def _ending_share(edges: Edges, sharp: Flags, looked: Flags) -> float | None:
    """Return the share of the vertices looked at, of those at sharp edges, in which one ends alone.

    None where they are too few.
    """
    meeting = np.bincount(edges.ends[sharp].reshape(-1), minlength=len(looked))[looked]
    corners = int(np.count_nonzero(meeting))
    return None if corners < FEW_SHARP else np.count_nonzero(meeting == 1) / corners
