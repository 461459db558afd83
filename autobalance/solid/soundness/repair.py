"""Repairs of meshes, from harmless to doubtful; each is reported, and what stays open is refused."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.csg.region import triangulated
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.adjacency import sides_of
from autobalance.solid.mesh.measure import signed_volume_mm3, without_crumbs
from autobalance.solid.mesh.mesh import Mesh, components, hash_numbers, sorted_with_rows, without_collapsed
from autobalance.solid.soundness.holes import (
    doubled_area_vector,
    is_closed,
    open_edges,
    open_holes_text,
    rims,
)
from autobalance.types import Array, Flags, Indices

PLACES_SHOWN = 4
"""Open edges that an error names."""
WELD_SHARE = 1e-7
"""Distance of vertices that are one point, as a share of the diagonal: single precision leaves as much."""
SEAM_STEPS = 10.0
"""Rims that lie on one another within so many steps of the file's digits are a seam, ..."""
SEAM_SHARE = 2e-6
"""... or within this share of the diagonal: a boolean kernel left seams of 0.0001 mm around journals."""
MAX_SPLITS = 50
"""Number of times that triangles at a seam are split, once for each vertex on an edge."""
MAX_MOVED_SHARE = 1e-4
"""A hole that may be filled unasked changes the volume by at most this share: an exporter's wrongly
triangulated face was filled, and the volume moved by 2 %."""
MAX_RIM_DISTANCE_SHARE = 1e-4
"""Largest distance of a rim from its plane, as a share of the diagonal ..."""
FACET_CORNERS = 4
"""... if the rim has no more corners than one facet, or holes are filled on request."""
HOLE_MOST = 0.01
"""Area of a hole that may be filled, as a share of the surface."""


def solid_of(welded: Mesh, step_mm: float = 0.0, most_moved: float = math.inf) -> tuple[Solid, list[str]]:
    """Return the solid of a welded mesh, and notes on its repairs, from harmless to doubtful.

    ``step_mm`` is the step between numbers that the file's digits distinguish; a hole is filled if that moves
    the volume by a share of at most ``most_moved``.

    Pairs of triangles that face each other are cancelled. Copies of a triangle are dropped if that leaves
    fewer open edges, or none. Such a mesh may also hold folded triangles. They are dropped before it is built
    and not after, when it would have to be built again. Only if the mesh is still open, near vertices are
    welded, the winding is made consistent and small plane holes are filled, one after the other.

    Raises
    ------
    SolidError
        If the mesh stays open, bounds nothing or contradicts itself.
    """
    mesh, notes = without_crowds(welded)
    if notes and is_closed(mesh.triangles):
        mesh, dropped = without_crumbs(mesh)
        notes += dropped
    known = Solid.of_closed(mesh)
    if known is not None:
        return known, notes
    try:
        return Solid.from_mesh(mesh), notes
    except SolidError:
        pass
    unfilled = mesh
    for step in (
        partial(_weld_near, step_mm=step_mm),
        _wind_consistently,
        partial(_fill_holes, most_moved=most_moved, step_mm=step_mm),
    ):
        if is_closed(mesh.triangles):
            break
        unfilled = mesh
        mesh, notes_here = step(mesh)
        notes += notes_here
    if not is_closed(mesh.triangles):  # plane holes count as well: not all could be filled
        holes = open_holes_text(unfilled)
        message = open_message(unfilled, open_edges(unfilled.triangles))
        raise SolidError(message + (f"; {holes}" if holes else ""))
    if signed_volume_mm3(mesh) < 0.0:
        notes.append(f"the mesh was inside out: turned round; {_change(mesh, mesh.flipped())}")
        mesh = mesh.flipped()
    return Solid.from_mesh(mesh), notes


def without_crowds(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Leave one triangle or none on the same corners; return the mesh and notes on that."""
    crowd = _crowded(mesh.triangles)
    if not len(crowd):
        return mesh, []
    kept = _unpaired(mesh.triangles, crowd)
    if not kept.any():
        return _single_shell(mesh)
    pairs = (len(kept) - int(kept.sum())) // 2
    if not pairs:
        return _drop_copies(mesh, crowd)
    left = Mesh(mesh.vertices, mesh.triangles[kept])
    cancelled = f"{pairs} pairs of triangles that face each other cancelled; {_change(mesh, left)}"
    single, dropped = _drop_copies(left, (np.cumsum(kept) - 1)[crowd[kept[crowd]]])
    return single, [cancelled, *dropped]


def _single_shell(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Keep one of the shells of a mesh that consists of a solid and its inside-out copy."""
    corners = np.sort(mesh.triangles, axis=1)
    first = np.unique(corners, axis=0, return_index=True)[1]
    wound, _ = _wind_consistently(Mesh(mesh.vertices, mesh.triangles[np.sort(first)]))
    if not is_closed(wound.triangles) or signed_volume_mm3(wound) == 0.0:
        raise SolidError(
            f"the mesh is {len(first)} triangles, each with a copy that faces it: it bounds no volume;"
            " expected a closed surface, each triangle once"
        )
    shell = wound if signed_volume_mm3(wound) > 0.0 else wound.flipped()
    copies = len(mesh.triangles) - len(shell.triangles)
    return shell, [
        f"{copies} triangles dropped that were an inside-out copy of the others; {_change(mesh, shell)}"
    ]


def _crowded(triangles: Indices) -> Indices:
    """Return the rows of triangles that share their three corners with others, and almost no more.

    A symmetric hash of the corners finds them, a hundred times as fast as sorting the corners themselves.
    """
    if len(triangles) == 0:
        return np.zeros(0, dtype=np.int64)
    a, b, c = hash_numbers(np.arange(int(triangles.max()) + 1)).take(triangles).T
    key, rows = sorted_with_rows(a + b + c)
    same = np.flatnonzero(key[1:] == key[:-1])
    return np.unique(rows.take(np.concatenate([same, same + 1])))


def _drop_copies(mesh: Mesh, crowd: Indices) -> tuple[Mesh, list[str]]:
    """Drop equal triangles of a crowd that face the same way, where that opens no edges.

    Such copies would make the metal behind them count twice: the surface of a solid passes any place once.
    """
    some = mesh.triangles.take(crowd, axis=0)
    turned = np.take_along_axis(some, (some.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    first = np.unique(turned, axis=0, return_index=True)[1]
    copies = len(turned) - len(first)
    if not copies:
        return mesh, []
    kept = np.ones(len(mesh.triangles), dtype=bool)
    kept[np.delete(crowd, first)] = False
    single = Mesh(mesh.vertices, mesh.triangles[kept])
    was = len(open_edges(mesh.triangles))
    looked_at = single.triangles if was else mesh.triangles[~kept]  # of a closed mesh, by what went
    left = len(open_edges(looked_at))
    if left and left >= was:
        return mesh, []
    return single, [f"{copies} triangles dropped that were copies of others; {_change(mesh, single)}"]


def _weld_near(mesh: Mesh, step_mm: float) -> tuple[Mesh, list[str]]:
    """Weld what lies on one another at open edges: vertices, and vertices on an edge of another triangle.

    That is within ``WELD_SHARE`` of the diagonal, or a seam's width.
    """
    from scipy.spatial import cKDTree

    notes: list[str] = []
    reaches = WELD_SHARE * mesh.diagonal_mm, max(SEAM_STEPS * step_mm, SEAM_SHARE * mesh.diagonal_mm)
    for reach in reaches:
        loose = np.unique(open_edges(mesh.triangles))
        if len(loose) == 0:
            break
        pairs = cKDTree(mesh.vertices[loose]).query_pairs(reach, output_type="ndarray")
        if len(pairs) == 0:
            continue
        lowest = components(pairs, len(loose))
        number = np.arange(len(mesh.vertices))
        number[loose] = loose[lowest]
        triangles = without_collapsed(number[mesh.triangles])
        joined = int((lowest != np.arange(len(loose))).sum())
        notes.append(f"{joined} vertices welded that lay within {reach:.3g} mm of another")
        dropped = len(mesh.triangles) - len(triangles)
        if dropped:
            notes.append(
                f"{dropped} collapsed triangles dropped; {_change(mesh, Mesh(mesh.vertices, triangles))}"
            )
        mesh, single = without_crowds(Mesh(mesh.vertices, triangles))
        notes += single
    seamed, split = _split_at_vertices(mesh, reaches[-1])
    return (seamed, [*notes, *split]) if split else (mesh, notes)


def _split_at_vertices(mesh: Mesh, reach: float) -> tuple[Mesh, list[str]]:
    """Split triangles whose open edge other open vertices lie on, within a reach: the two rims of a seam."""
    triangles, count = mesh.triangles, 0
    for _ in range(MAX_SPLITS):
        edges = open_edges(triangles)
        if len(edges) == 0:
            break
        split = _split_once(mesh.vertices, triangles, edges, reach)
        if split is None:
            break
        count += len(split) - len(triangles)
        triangles = split
    if not count:
        return mesh, []
    seamed = Mesh(mesh.vertices, triangles)
    text = f"{count} vertices of a seam's rims that lay on an edge welded into it, within {reach:.3g} mm"
    return seamed, [f"{text}; {_change(mesh, seamed)}"]


def _split_once(vertices: Array, triangles: Indices, edges: Indices, reach: float) -> Indices | None:
    """Return triangles, each split once where a loose vertex lies on an open edge of it; None without one."""
    from scipy.spatial import cKDTree

    loose = np.unique(edges)
    tree = cKDTree(vertices[loose])
    ends = vertices[edges]
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    near = tree.query_ball_point(ends.mean(axis=1), 0.5 * length + reach)
    edge = np.repeat(np.arange(len(edges)), [len(places) for places in near])
    vertex_near = loose[np.concatenate([np.asarray(places, dtype=np.int64) for places in near])]
    likely = _hardly_beside(vertices[vertex_near] - ends[edge, 0], along[edge], length[edge], reach)
    onto: dict[tuple[int, int], int] = {}
    for number, vertex in zip(edge[likely].tolist(), vertex_near[likely].tolist(), strict=True):
        start, end = edges[number].tolist()
        if vertex in (start, end) or (start, end) in onto:
            continue
        arm, direction, size = vertices[vertex] - ends[number, 0], along[number], length[number]
        share = float(arm @ direction) / size**2
        aside = float(np.linalg.norm(arm - share * direction))
        if aside <= reach < share * size < size - reach:
            onto[start, end] = vertex
    if not onto:
        return None
    result: list[tuple[int, int, int]] = []
    for a, b, c in triangles.tolist():
        for start, end, third in ((a, b, c), (b, c, a), (c, a, b)):
            vertex = onto.get((start, end), onto.get((end, start), -1))
            if vertex >= 0 and vertex != third:
                result += [(start, vertex, third), (vertex, end, third)]
                break
        else:
            result.append((a, b, c))
    return np.array(result, dtype=np.int64)


def _hardly_beside(arm: Array, along: Array, length: Array, reach: float) -> Flags:
    """Return whether points, seen from the start of an edge each, may lie within reach of its inside.

    All at once, to more than their rounding: a mesh that was torn has hundreds of points near each edge.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (arm * along).sum(axis=1) / length**2
        aside = np.linalg.norm(arm - share[:, None] * along, axis=1)
    slack = 1e-9 * (length + reach)
    no = (
        (aside > reach + slack) | (share * length < reach - slack) | (share * length > length - reach + slack)
    )
    return np.asarray(~no)


def _wind_consistently(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Turn triangles so that neighbours run through their common edge in opposite directions."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    left, right, same = _neighbours(mesh.triangles)
    if not same.any():
        return mesh, []
    count = len(mesh.triangles)
    graph = coo_array((np.where(same, 2, 1), (left, right)), shape=(count, count)).tocsr()
    graph = graph + graph.T
    label = components(np.stack([left, right], axis=1), count)
    turned = np.zeros(count, dtype=bool)
    for part in np.unique(label):
        members = np.flatnonzero(label == part)
        order, before = breadth_first_order(graph, members[0], directed=False)
        for triangle in order[1:]:
            turned[triangle] = turned[before[triangle]] ^ (graph[before[triangle], triangle] == 2)
        if 2 * turned[members].sum() > len(members):  # the greater number keeps its sense
            turned[members] ^= True
    if (turned[left] ^ turned[right] != same).any():
        raise SolidError("the mesh has one side only: its triangles cannot be wound consistently")
    triangles = mesh.triangles.copy()
    triangles[turned] = triangles[turned][:, ::-1]
    wound = Mesh(mesh.vertices, triangles)
    return wound, [f"{int(turned.sum())} triangles turned round to one winding; {_change(mesh, wound)}"]


def _neighbours(triangles: Indices) -> tuple[Indices, Indices, Flags]:
    """Return pairs of triangles at edges that have just two, and whether both run the same way there."""
    sides = sides_of(triangles)
    one, other = sides.of_two
    return one // 3, other // 3, sides.start[one] == sides.start[other]


def _fill_holes(mesh: Mesh, most_moved: float, step_mm: float) -> tuple[Mesh, list[str]]:
    """Fill holes whose rim is one plane loop around little area.

    Unasked, a rim with more corners than a facet must be plane to the file's digits, as a face's is, which
    comes back as it was. Any other may go over several facets of a round surface, a bearing's perhaps, from
    which a plane would take metal.
    """
    area = float(mesh.doubled_areas.sum()) / 2.0
    nearly_flat = MAX_RIM_DISTANCE_SHARE * mesh.diagonal_mm
    flat = min(nearly_flat, max(SEAM_STEPS * step_mm, SEAM_SHARE * mesh.diagonal_mm))
    caps: list[Indices] = []
    for loop in rims(open_edges(mesh.triangles)):
        is_asked = len(loop) <= FACET_CORNERS or math.isinf(most_moved)
        flat_mm = nearly_flat if is_asked else flat
        cap = _cap(mesh.vertices[loop], flat_mm, HOLE_MOST * area)
        if cap is not None and _moved_share(mesh, loop[cap]) <= most_moved:
            caps.append(loop[cap])
    if not caps:
        return mesh, []
    filled = Mesh(mesh.vertices, np.concatenate([mesh.triangles, *caps]))
    return filled, [f"{len(caps)} small plane holes filled; {_change(mesh, filled)}"]


def _moved_share(mesh: Mesh, cap: Indices) -> float:
    """Return the volume between a cap and the mesh's middle, as a share of the mesh's own about it."""
    centred = mesh.vertices - mesh.bounds.mean(axis=0)
    whole = signed_volume_mm3(Mesh(centred, mesh.triangles))
    return abs(signed_volume_mm3(Mesh(centred, cap))) / max(abs(whole), 1e-300)


def _cap(rim: Array, flat_mm: float, area_most_mm2: float) -> Indices | None:
    """Return triangles (k, 3) over the corners of a plane rim, or None if it is not plane or too large."""
    local = rim - rim.mean(axis=0)
    normal = doubled_area_vector(rim)
    size = float(np.linalg.norm(normal))
    if size / 2.0 > area_most_mm2:
        return None
    axes = np.linalg.svd(local, full_matrices=False)[2]
    if np.abs(local @ axes[2]).max() > flat_mm:
        return None
    if axes[:2].shape == (2, 3) and np.cross(axes[0], axes[1]) @ normal < 0.0:
        axes = axes[[1, 0, 2]]
    return triangulated(local @ axes[:2].T).reshape(-1, 3)


def _change(before: Mesh, after: Mesh) -> str:
    return volume_change(signed_volume_mm3(before), signed_volume_mm3(after))


def volume_change(was_mm3: float, now_mm3: float) -> str:
    """Return a note on the volume before and after a repair."""
    return f"volume {was_mm3:.9g} → {now_mm3:.9g} mm³"


def open_message(mesh: Mesh, edges: Indices) -> str:
    """Return one line on the number of open edges and their places."""
    middles = mesh.vertices[edges].mean(axis=1)
    places = ", ".join(f"({x:.6g}, {y:.6g}, {z:.6g})" for x, y, z in middles[:PLACES_SHOWN])
    more = ", ..." if len(middles) > PLACES_SHOWN else ""
    return (
        f"the mesh is open: {len(edges)} edges do not have a triangle on each side;"
        f" expected a closed surface; middles of open edges in the file's coordinates [mm]: {places}{more}"
    )


def without_opposite_pairs(triangles: Indices) -> Indices:
    """Return the triangles without pairs on the same three corners that face each other; they bound nothing.

    Triangles that are equal and face the same way are kept: one of them may close the mesh.
    """
    crowd = _crowded(triangles)
    return triangles[_unpaired(triangles, crowd)] if len(crowd) else triangles


def _unpaired(triangles: Indices, crowd: Indices) -> Flags:
    """Mark the triangles (m,) that no other of the ``crowd`` faces on the same corners."""
    some = triangles.take(crowd, axis=0)
    group = np.unique(np.sort(some, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    sense = np.sign(np.roll(some, -1, axis=1) - some).sum(axis=1)  # ±1 by the parity of the order
    surplus = np.bincount(group, weights=sense)
    used = np.zeros(len(surplus))
    keep = np.ones(len(triangles), dtype=bool)
    for triangle, at in enumerate(group):
        left = used[at] != surplus[at] and sense[triangle] == np.sign(surplus[at])
        used[at] += sense[triangle] if left else 0.0
        keep[crowd[triangle]] = left
    return keep
