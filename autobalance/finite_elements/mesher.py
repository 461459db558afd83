"""Tetrahedra in a solid: sizes by curvature, rings around fillets."""

from __future__ import annotations

import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.crank.anatomy import Pin
from autobalance.errors import FileError, SolidError
from autobalance.solid.formats.stl import write_stl
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Size of a mesh where a triangulated surface is curved.


SHARPEST_RAD = math.radians(30.0)
"""A steeper edge is a true edge, not a facet of a curved surface; netgen draws the line there too."""
FLATTEST_RAD = 1e-3
MAX_REFINEMENT = 12.0
"""A local size is never less than the mesh's own over this: a fillet of 0.01 mm is not resolved."""
MOST_POINTS = 200_000


def curvature_sizes(
    vertices_mm: Array, triangles: Indices, size_mm: float, share_of_radius: float
) -> tuple[Array, Array]:
    """Return points (k, 3) on curved parts of a surface and the element size (k,) wanted there [mm].

    A facet edge with dihedral angle θ between triangles of altitudes h₁, h₂ over it lies on a surface of
    radius (h₁ + h₂)/(2 θ).

    Parameters
    ----------
    vertices_mm : (n, 3) float
    triangles : (m, 3) int
        Closed and outward.
    size_mm : float
        Size elsewhere [mm].
    share_of_radius : float
        Element size over the radius of curvature.
    """
    edges, pairs = _edges(triangles)
    corners = vertices_mm[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    unit = normals / np.maximum(doubled, 1e-300)[:, None]
    first, second = unit[pairs[:, 0]], unit[pairs[:, 1]]
    angle = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), (first * second).sum(axis=1))
    ends = vertices_mm[edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    altitudes = doubled[pairs].sum(axis=1) / np.maximum(length, 1e-300)
    curved = (angle > FLATTEST_RAD) & (angle < SHARPEST_RAD) & (length > 0.0)
    edge_mm = share_of_radius * altitudes[curved] / (2.0 * angle[curved])
    finer = edge_mm < size_mm
    sizes = np.maximum(edge_mm[finer], size_mm / MAX_REFINEMENT)
    return _along(ends[curved][finer], length[curved][finer], sizes)


def _edges(triangles: Indices) -> tuple[Indices, Indices]:
    """Return each edge's vertices (e, 2) and its two triangles (e, 2)."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    sides.sort(axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    same = (sides[:-1] == sides[1:]).all(axis=1)
    at = np.flatnonzero(same)
    return sides[at], np.column_stack([owner[at], owner[at + 1]])


def _along(ends: Array, length: Array, sizes: Array) -> tuple[Array, Array]:
    """Return points along each edge no further apart than its size, and their sizes."""
    counts = np.ceil(length / sizes).astype(np.int64) + 1
    if counts.sum() > MOST_POINTS:
        counts = np.full(len(sizes), 2)
    row = np.repeat(np.arange(len(sizes)), counts)
    place = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (place / np.maximum(counts[row] - 1, 1))[:, None]
    return ends[row, 0] * (1.0 - share) + ends[row, 1] * share, sizes[row]


# Solids become meshes of quadratic tetrahedra, by netgen.


SHARE_OF_RADIUS = 0.3
"""Size of elements on a curved surface, over its radius: 21 elements a turn, 42 nodes."""
DEFAULT_TETRAHEDRA = 9000
LONGEST_S = 300.0
OUT_OF_TIME = -24
"""Exit code of a process that the system ends for its processor time (SIGXCPU)."""
CORNERS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
"""The corners between which the nodes 4 to 9 of a tetrahedron lie."""


@dataclass(frozen=True, eq=False)
class SurfaceSolid:
    """A closed triangulated surface: vertices (n, 3) [mm], triangles (m, 3), outward."""

    vertices_mm: Array
    triangles: Indices

    @property
    def volume_mm3(self) -> float:
        """Volume inside [mm³]."""
        a, b, c = self.vertices_mm[self.triangles].swapaxes(0, 1)
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0

    @property
    def area_mm2(self) -> float:
        """Surface [mm²]."""
        a, b, c = self.vertices_mm[self.triangles].swapaxes(0, 1)
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


@dataclass(frozen=True, eq=False)
class TetrahedronMesh:
    """Tetrahedra with ten nodes, the middle ones on the true edges.

    Attributes
    ----------
    nodes_mm : (n, 3) float
    tetrahedra : (m, 10) int
        Four corners, then the nodes between those of ``CORNERS``.
    size_mm : float
        Asked for.
    solid_volume_mm3 : float
        Of the solid that was meshed.
    """

    nodes_mm: Array
    tetrahedra: Indices
    size_mm: float
    solid_volume_mm3: float


def default_size_mm(volume_mm3: float, area_mm2: float) -> float:
    """Return an element size that gives some thousand tetrahedra, and two through what is thin.

    A regular tetrahedron of edge h has h³/(6√2); 2 V/A is the thickness of a plate.
    """
    by_count = (6.0 * 2.0**0.5 * volume_mm3 / DEFAULT_TETRAHEDRA) ** (1.0 / 3.0)
    return float(min(by_count, 2.0 * volume_mm3 / area_mm2))


def meshes_of(
    solid: SurfaceSolid | Path,
    size_mm: float | None,
    factors: Sequence[float] = (1.0,),
    share_of_radius: float = SHARE_OF_RADIUS,
    longest_s: float = LONGEST_S,
    finer: tuple[Array, Array] | None = None,
    rough: bool = False,
) -> list[TetrahedronMesh]:
    """Mesh a solid at several sizes.

    Parameters
    ----------
    solid : SurfaceSolid or Path
        Triangles, or a STEP file, whose true surfaces are meshed.
    size_mm : float or None
        Largest edge [mm]; None: ``default_size_mm``.     factors : sequence of float
        Each gives a mesh, of so many times these sizes.
    share_of_radius : float
        Size of elements on a curved surface, over its radius, at most.
    longest_s : float
        Processor time that the mesher has for all of them, where the system limits it [s].
    finer : ((n, 3) float, (n,) float) or None
        Points of a triangulated solid and the size of elements there, for any factor.
    rough : bool
        In half the time: elements that grow faster, moved about less for their shape. Good for stiffness, not
        for stress.

    Raises
    ------
    FileError
        If the mesher is not installed.
    SolidError
        If it fails, or the file holds several solids.
    """
    need_libraries()
    with tempfile.TemporaryDirectory(prefix="autobalance-fem-") as name:
        folder = Path(name)
        if size_mm is None and isinstance(solid, SurfaceSolid):
            size_mm = default_size_mm(solid.volume_mm3, solid.area_mm2)
        order = _order(solid, size_mm, factors, share_of_radius, folder, finer)
        order.values.update(longest_s=longest_s, rough=rough)
        answer = _run(order, folder, longest_s)
        if answer["solids"] not in (None, 1):
            raise SolidError(f"{solid} holds {answer['solids']} solids; expected one")
        volume = solid.volume_mm3 if isinstance(solid, SurfaceSolid) else float(answer["volume_mm3"])
        size = float(answer["size_mm"])
        return [
            _loaded(Path(each["file"]), size * each["factor"], volume, order.shift_mm)
            for each in order.values["meshes"]
        ]


def need_libraries() -> None:
    """Raise FileError, with what to install, unless the mesher and the finite-element library exist."""
    if find_spec("netgen") is None or find_spec("skfem") is None:
        raise FileError(
            "finite elements need netgen-mesher and scikit-fem: pip install 'autobalance[fem]'; the mesher "
            f"has wheels for Linux, macOS and Windows on common processors, and this is {platform.platform()}"
        )


@dataclass(frozen=True, eq=False)
class _Order:
    """Task of the mesher's process; ``shift_mm`` (3,) was taken from the coordinates it sees."""

    values: dict[str, Any]
    shift_mm: Array


def _order(
    solid: SurfaceSolid | Path,
    size_mm: float | None,
    factors: Sequence[float],
    share_of_radius: float,
    folder: Path,
    finer: tuple[Array, Array] | None,
) -> _Order:
    shift = np.zeros(3)
    meshes: list[dict[str, Any]] = [
        {"factor": factor, "sizes": "", "file": str(folder / f"{number}.npz")}
        for number, factor in enumerate(factors)
    ]
    file = solid
    if isinstance(solid, SurfaceSolid):
        assert size_mm is not None
        shift = 0.5 * (solid.vertices_mm.min(axis=0) + solid.vertices_mm.max(axis=0))
        moved = solid.vertices_mm - shift  # float32 is finest about the middle
        file = folder / "solid.stl"
        file.write_bytes(write_stl(moved.astype(np.float32), solid.triangles))
        for mesh in meshes:
            size, share = size_mm * mesh["factor"], share_of_radius * mesh["factor"]
            points, local = curvature_sizes(moved, solid.triangles, size, share)
            if finer is not None:
                points, local = np.vstack([points, finer[0] - shift]), np.append(local, finer[1])
            mesh["sizes"] = _size_file(points, local, folder / f"{Path(mesh['file']).stem}.txt")
    values = {
        "solid": str(file),
        "exact": isinstance(solid, Path),
        "size_mm": size_mm,
        "share_of_radius": share_of_radius,
        "meshes": meshes,
        "answer": str(folder / "answer.json"),
    }
    return _Order(values, shift)


def _size_file(points_mm: Array, sizes_mm: Array, path: Path) -> str:
    """Write netgen's file of local sizes: a count, points with sizes, and a count of lines (none)."""
    rows = np.column_stack([points_mm, sizes_mm])
    lines = "\n".join(" ".join(f"{value:.9g}" for value in row) for row in rows)
    path.write_text(f"{len(rows)}\n{lines}\n0\n", encoding="ascii")
    return str(path)


def _run(order: _Order, folder: Path, longest_s: float) -> dict[str, Any]:
    """Run the mesher's process and return its answer."""
    file = folder / "order.json"
    file.write_text(json.dumps(order.values), encoding="utf-8")
    package = str(Path(__file__).resolve().parents[2])
    paths = os.pathsep.join([package, *filter(None, [os.environ.get("PYTHONPATH")])])
    try:
        done = subprocess.run(
            [sys.executable, "-m", "autobalance.finite_elements.netgen_process", str(file)],
            env={**os.environ, "PYTHONPATH": paths},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=LONGEST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise SolidError(
            f"the mesher did not end within {LONGEST_S:.0f} s; choose a larger size_mm"
        ) from None
    answer = Path(order.values["answer"])
    if done.returncode == OUT_OF_TIME:
        raise SolidError(f"the mesher did not end within {longest_s:.0f} s; choose a larger size_mm")
    if not answer.exists():
        raise SolidError(
            f"the mesher ended with code {done.returncode}; choose another size_mm or a cleaner solid"
        )
    mesh: dict[str, Any] = json.loads(answer.read_text(encoding="utf-8"))
    if mesh["error"] is not None:
        raise SolidError(f"the mesher failed: {mesh['error']}; choose another size_mm or a cleaner solid")
    return mesh


def _loaded(file: Path, size_mm: float, volume_mm3: float, shift_mm: Array) -> TetrahedronMesh:
    if not file.exists():
        raise SolidError(f"the mesher made no mesh of size {size_mm:g} mm; choose another size_mm")
    with np.load(file) as arrays:
        nodes, tetrahedra = arrays["nodes_mm"] + shift_mm, arrays["tetrahedra"]
    used, numbers = np.unique(tetrahedra, return_inverse=True)
    return TetrahedronMesh(nodes[used], numbers.reshape(tetrahedra.shape), size_mm, volume_mm3)


# Fillets as rings of true arcs: how fine a mesh must be on them, and its nodes brought onto them.
#
# Solids are drawn with few facets across a fillet, and a mesher takes facets for edges: elements as long as
# these are miss half of the peak of stress.


MIN_VOLUME_SHARE = 0.2
"""Elements with less than this share of their volume left stay where the mesher put them."""
TRIES = 5
FACES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
EXAMINED_RADIUS_SHARES = (0.05, 0.95)
"""Shares of the radius between which corners of the solid show whether it has the arc."""
OFF_ARC = 0.1
DRAWN_ONTO = (0.6, 1.03)
"""Shares of the radius, from the arc's centre, from where nodes are brought onto it: a chord across all of
it comes to 0.71."""


@dataclass(frozen=True, eq=False)
class FilletRing:
    """The arc of a fillet about a pin: a bare cylinder ends at ``end_mm``, ``sense`` points into the web."""

    centre_mm: Array
    pin_radius_mm: float
    end_mm: float
    sense: float
    radius_mm: float

    @classmethod
    def of(cls, pin: Pin, above: bool, radius_mm: float) -> FilletRing:
        """Return the ring at the end of a pin above it (greater z), or below."""
        low, high = pin.z_range_mm
        centre = np.asarray(pin.centre_mm[:2])
        return cls(centre, 0.5 * pin.diameter_mm, high if above else low, 1.0 if above else -1.0, radius_mm)

    def coordinates(self, places_mm: Array) -> tuple[Array, Array]:
        """Return distances of places (n, 3) out from the pin's surface, and along from its end."""
        out = np.linalg.norm(places_mm[:, :2] - self.centre_mm, axis=1) - self.pin_radius_mm
        return np.asarray(out), self.sense * (places_mm[:, 2] - self.end_mm)

    def is_drawn(self, corners_mm: Array) -> bool:
        """Return whether a solid of these corners (n, 3) has this arc."""
        out, along = (each / self.radius_mm for each in self.coordinates(corners_mm))
        low, high = EXAMINED_RADIUS_SHARES
        inside = (out > low) & (out < high) & (along > low) & (along < high)
        if not inside.any():
            return False
        return float(np.median(np.abs(np.hypot(out[inside] - 1.0, along[inside]) - 1.0))) < OFF_ARC

    def sizes(self, share: float) -> tuple[Array, Array]:
        """Return points (n, 3) on the arc and the element size (n,) there: a share of its radius."""
        size = share * self.radius_mm
        around = np.arange(0.0, 2.0 * math.pi, size / (self.pin_radius_mm + self.radius_mm))
        across = np.linspace(0.0, 0.5 * math.pi, max(3, math.ceil(0.5 * math.pi / share) + 1))
        turn, lean = (each.reshape(-1) for each in np.meshgrid(around, across))
        off = self.pin_radius_mm + self.radius_mm * (1.0 - np.cos(lean))
        points = np.column_stack(
            [
                self.centre_mm[0] + off * np.cos(turn),
                self.centre_mm[1] + off * np.sin(turn),
                self.end_mm + self.sense * self.radius_mm * np.sin(lean),
            ]
        )
        return points, np.full(len(points), size)

    def drawn_onto(self, places_mm: Array, surface: Indices) -> Array:
        """Return places (n, 3) of nodes, those of the surface that are beside the arc brought onto it."""
        moved = places_mm.copy()
        own = places_mm[surface]
        out, along = self.coordinates(own)
        r = self.radius_mm
        far = np.hypot(out - r, along)
        low, high = DRAWN_ONTO
        beside = (out > 0.0) & (out < r) & (along > 0.0) & (along < r) & (far > low * r) & (far < high * r)
        scale = r / far[beside]
        new_out = r + (out[beside] - r) * scale
        arm = own[beside, :2] - self.centre_mm
        length = np.linalg.norm(arm, axis=1, keepdims=True)
        moved[surface[beside], :2] = self.centre_mm + arm / length * (self.pin_radius_mm + new_out)[:, None]
        moved[surface[beside], 2] = self.end_mm + self.sense * along[beside] * scale
        return moved


def on_arcs(mesh: TetrahedronMesh, rings: Sequence[FilletRing]) -> TetrahedronMesh:
    """Return a mesh with the surface nodes of fillets on their true arcs."""
    surface = surface_nodes(mesh)
    places = mesh.nodes_mm
    for ring in rings:
        places = ring.drawn_onto(places, surface)
    before = _volumes(mesh.nodes_mm, mesh.tetrahedra)
    for _ in range(TRIES):
        flat = _volumes(places, mesh.tetrahedra) / before < MIN_VOLUME_SHARE
        if not flat.any():
            return replace(mesh, nodes_mm=places)
        back = np.unique(mesh.tetrahedra[flat])
        places[back] = mesh.nodes_mm[back]
    return mesh


def _volumes(places_mm: Array, elements: Indices) -> Array:
    """Return the signed volume (m,) of elements' corners, those the mesher made all of one sign [mm³]."""
    a, b, c, d = places_mm[elements[:, :4]].swapaxes(0, 1)
    volumes: Array = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0
    return volumes


def surface_nodes(mesh: TetrahedronMesh) -> Indices:
    """Return the numbers of the nodes on a mesh's surface, corners and middles."""
    elements = mesh.tetrahedra
    faces = np.sort(np.concatenate([elements[:, face] for face in FACES]), axis=1)
    owner = np.tile(np.arange(len(elements)), len(FACES))
    which = np.repeat(np.arange(len(FACES)), len(elements))
    _, first, count = np.unique(faces, axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    middle_of = {frozenset(pair): number for number, pair in enumerate(CORNERS, 4)}
    local = np.array(
        [[*face, *(middle_of[frozenset((face[i], face[i - 1]))] for i in range(3))] for face in FACES]
    )
    nodes: Indices = np.unique(elements[owner[outer][:, None], local[which[outer]]]).astype(np.int64)
    return nodes
