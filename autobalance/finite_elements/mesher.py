"""Solids become meshes of quadratic tetrahedra, by netgen."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.errors import FileError, SolidError
from autobalance.finite_elements.curvature import curvature_sizes
from autobalance.solid.formats.stl import write_stl
from autobalance.types import Array, Indices

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
