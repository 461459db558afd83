"""How often the error bar of the facets covers the truth, over random tessellations of exact cranks.

    python benchmarks/error_bars.py [FILE.step ...] [--count 100] [--seed 7] [--sampled]

Generated cranks, and the STEP files given, are tessellated by the CAD kernel with random chord heights
(5e-5 to 2e-3 of the diagonal) and angles (0.2 to 0.9 rad), as a user's export may be. Of each, what the
facets hide is estimated from the triangles alone and compared with the exact solid: mass, unbalance,
and polar inertia with the mass's bar as far out as the crank reaches. With --sampled surfaces are carried
from a sample of the facets, as in a large mesh.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from autobalance.drawn_cranks.design import preset  # noqa: E402
from autobalance.drawn_cranks.generate import crank_shape  # noqa: E402
from autobalance.solid.cad.brep import ExactSolid  # noqa: E402
from autobalance.solid.cad.files import read_step_file  # noqa: E402
from autobalance.solid.cad.kernel import explored  # noqa: E402
from autobalance.solid.cad.tessellation import _face_triangles  # noqa: E402
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh  # noqa: E402
from autobalance.solid.mesh.measure import mesh_moments  # noqa: E402
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup  # noqa: E402

DRAWN = ("single", "inline-3", "inline-4")
MEASURES = ("mass", "unbalance", "polar inertia")


def tessellated(body: Any, sag_mm: float, turn_rad: float) -> Mesh:
    """Return the kernel's triangles as an STL file keeps them."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools

    BRepTools.Clean_s(body)
    BRepMesh_IncrementalMesh(body, sag_mm, False, turn_rad, False)
    faces = [_face_triangles(face) for face in explored(body, "FACE")]
    return mesh_of_soup(np.concatenate([corners[numbers] for corners, numbers in faces]).astype(np.float32))


def covered(solid: ExactSolid, mesh: Mesh, most: int | None) -> list[bool]:
    """Tell for mass, unbalance and polar inertia whether the bar covers what the estimate is off by."""
    error = chordal_error_of_mesh(mesh, 1.0, most=most)
    left = solid.moments(1.0) - mesh_moments(mesh, 1.0) - error.missing
    reach_mm = float(np.hypot(*mesh.vertices[:, :2].T).max())
    return [
        abs(left.mass_g) <= error.mass_bar_g,
        math.hypot(*left.first_g_mm[:2]) <= error.unbalance_bar_g_mm,
        abs(left.polar_inertia_g_mm2) <= error.mass_bar_g * reach_mm**2,
    ]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--sampled", action="store_true")
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    cranks = {name: ExactSolid(crank_shape(preset(name))) for name in DRAWN}
    for file in arguments.files:
        cranks[file.name] = ExactSolid.of(read_step_file(file.read_bytes()).bodies[0].body)
    held = np.zeros(len(MEASURES), dtype=int)
    for number in range(arguments.count):
        name = list(cranks)[number % len(cranks)]
        low, high = cranks[name].bounds
        sag = float(np.linalg.norm(high - low)) * 10.0 ** rng.uniform(-4.3, -2.7)
        mesh = tessellated(cranks[name].body, sag, rng.uniform(0.2, 0.9))
        found = covered(cranks[name], mesh, 0 if arguments.sampled else None)
        held += found
        if not all(found):
            print(f"missed: {name}, {len(mesh.triangles)} triangles, chord height {sag:.3g} mm: {found}")
    for measure, times in zip(MEASURES, held.tolist(), strict=True):
        print(f"{measure}: covered {times} of {arguments.count}")
    return 0 if (held >= 0.99 * arguments.count).all() else 1


if __name__ == "__main__":
    raise SystemExit(main())
