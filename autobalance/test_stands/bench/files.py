"""The bench rotor as files: STL, STEP where the kernel exists, and a drawing; each solid measured again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import Shape, tessellated
from autobalance.test_stands.bench.answer import WrittenRotor
from autobalance.test_stands.bench.rotor import DiscHole, DiscOnShaft
from autobalance.test_stands.bench.solid import rotor_shape

Values = dict[str, Any]
SEGMENTS = 720
"""Corners of a full circle in the STL: its inertia is light by 5e-5."""
KG_PER_G = 1e-3


def rotor_files(
    rotor: DiscOnShaft, holes: Sequence[DiscHole], wanted_g_mm2: float
) -> tuple[dict[str, bytes], list[WrittenRotor]]:
    """Return the files of a rotor by name, and what each solid among them was measured to have.

    Parameters
    ----------
    rotor : DiscOnShaft
    holes : sequence of DiscHole
        Of the drilled rotor, which has separate files.
    wanted_g_mm2 : float
        Inertia to compare with [g·mm²].
    """
    from autobalance.test_stands.bench.drawing import rotor_drawing

    files: dict[str, bytes] = {}
    measured: list[WrittenRotor] = []
    shapes = {"rotor": rotor_shape(rotor)} | ({"rotor-drilled": rotor_shape(rotor, holes)} if holes else {})
    for name, shape in shapes.items():
        for file, data, moments in _written(name, shape, rotor.density_g_mm3):
            files[file] = data
            measured.append(_measured(file, moments, wanted_g_mm2))
    files["rotor.svg"] = rotor_drawing(rotor, holes)
    return files, measured


def _written(name: str, shape: Shape, density: float) -> list[tuple[str, bytes, Moments]]:
    """Return the files of a solid with the moments that are read back from each."""
    from autobalance.solid.cad.installed import has_kernel
    from autobalance.solid.formats.write import through_file
    from autobalance.solid.mesh.measure import soup_moments

    data, soup = through_file(tessellated(shape, SEGMENTS).mesh, "stl", 1.0)
    files = [(f"{name}.stl", data, soup_moments(soup, density))]
    if has_kernel():
        from autobalance.solid.cad.brep import ExactSolid
        from autobalance.solid.cad.step_file import read_step_file

        step = ExactSolid(shape).step(name=name)
        back = ExactSolid.of(read_step_file(step).bodies[0].body)
        files.append((f"{name}.step", step, back.moments(density)))
    return files


def _measured(file: str, moments: Moments, wanted_g_mm2: float) -> WrittenRotor:
    polar = moments.polar_inertia_g_mm2
    return WrittenRotor(
        file=file,
        mass_kg=KG_PER_G * moments.mass_g,
        inertia_g_mm2=polar,
        inertia_difference_percent=100.0 * (polar / wanted_g_mm2 - 1.0),
        unbalance_g_mm=float(np.hypot(*moments.first_g_mm[:2])),
    )
