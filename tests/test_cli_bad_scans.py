"""Scans that cannot be balanced: one line that says what was found and what helps, and exit code 3."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from tests import jobs
from tests.scans import Scan, meshed, scan, slab

EDGE_MM = 2.2


def _crank() -> Scan:
    return scan("single", 0.02, edge_mm=EDGE_MM, seed=1)


def _stl(path: Path, mesh: Mesh) -> Path:
    """Write loose triangles as they are, closed or not."""
    rows = np.zeros(len(mesh.triangles), dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    rows["c"] = mesh.corners
    path.write_bytes(bytes(80) + np.uint32(len(rows)).tobytes() + rows.tobytes())
    return path


def _cloud(folder: Path) -> Path:
    points = _crank().mesh.vertices[:5000]
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    path = folder / "cloud.ply"
    path.write_text(head + "\n".join(f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in points) + "\n")
    return path


def _points_of_obj(folder: Path) -> Path:
    path = folder / "cloud.obj"
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in _crank().mesh.vertices[:100]))
    return path


def _placed() -> tuple[Mesh, Array]:
    there = _crank()
    return there.mesh, there.truth.file_to_rotor


def _half_seen(folder: Path) -> Path:
    mesh, frame = _placed()
    middles = mesh.corners.mean(axis=1) @ frame[:3, :3].T + frame[:3, 3]
    return _stl(folder / "half.stl", mesh.part(middles[:, 1] > 0.0))


def _half_closed(folder: Path) -> Path:
    mesh, frame = _placed()
    far = np.full(3, 300.0)
    half = Solid.from_mesh(mesh).moved(frame) & Solid.box(far * [-1.0, 0.0, -1.0], far)
    return _stl(folder / "half.stl", half.mesh)


def _metres(folder: Path) -> Path:
    mesh = _crank().mesh
    return _stl(folder / "metres.stl", Mesh(mesh.vertices / 1000.0, mesh.triangles))


def _stand(points: Array) -> Array:
    upright: Array = np.maximum(np.abs(points[:, 0]) - 30.0, np.abs(points[:, 1]) - 30.0)
    return np.maximum(upright, slab(points[:, 2], 0.0, 20.0))


def _on_a_stand(folder: Path) -> Path:
    crank = _crank().mesh
    box = np.array([[-32.0, -32.0, -2.0], [32.0, 32.0, 22.0]])
    vertices, triangles = meshed(_stand, box, 2.0 * EDGE_MM, np.eye(3), 1)
    both = Mesh(
        np.concatenate([crank.vertices, vertices + np.array([0.0, 0.0, 400.0])]),
        np.concatenate([crank.triangles, triangles + len(crank.vertices)]),
    )
    return _stl(folder / "stand.stl", both)


def _too_rough(folder: Path) -> Path:
    return _stl(folder / "rough.stl", scan("single", 0.5, edge_mm=EDGE_MM, seed=1).mesh)


CASES: dict[str, tuple[Callable[[Path], Path], str, str]] = {
    "point cloud": (_cloud, "holds 5000 points and no triangles: a point cloud", "make a mesh of it"),
    "point cloud as OBJ": (_points_of_obj, "100 points and no triangles: a point cloud", "make a mesh of it"),
    "half a crank, open": (
        _half_seen,
        "the mesh is open",
        "scan it from all sides",
    ),
    "half a crank, closed": (
        _half_closed,
        "of the surface: half a crank, or its stand with it?",
        "Set main_journals",
    ),
    "metres": (_metres, "the crank is 0.152", "is its unit m?"),
    "crank and stand": (_on_a_stand, "the file holds 2 bodies", "expected body = a number"),
    "too rough": (_too_rough, "would do for G ", "scan it again, more finely, or decimate it less"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_scan_that_is_no_use_is_refused_in_one_line(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, found, helps = CASES[name]
    assert jobs.run("inspect", make(tmp_path), "--unit", "mm") == 3
    said = capsys.readouterr().err
    assert said.startswith("autobalance: error: ")
    assert said.count("\n") == 1
    assert found in said
    assert helps in said
