"""The bench rotor as a solid, as files, and as a drawing with dimensions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.shape import Line, Prism, Revolved, Shape, Without, circle, on_grid, tessellated
from autobalance.test_stands.bench.answer import WrittenRotor
from autobalance.test_stands.bench.rotor import DiscHole, DiscOnShaft
from autobalance.units import KG_PER_G

# Solid of the bench rotor with its holes: disc on a shaft, z along the axis from the shaft's lower end.


PAST_MM = 1.0


def rotor_shape(rotor: DiscOnShaft, holes: Sequence[DiscHole] = ()) -> Shape:
    """Return the exact shape of a rotor; holes go down from the disc's upper face, flat-bottomed."""
    side = rotor.shaft_each_side_mm
    low, high = on_grid(side), on_grid(side + rotor.thickness_mm)
    shaft, disc, end = 0.5 * rotor.shaft_mm, 0.5 * rotor.disc_mm, on_grid(rotor.length_mm)
    corners = [(0.0, 0.0), (shaft, 0.0), (shaft, low), (disc, low), (disc, high), (shaft, high), (shaft, end)]
    if side <= 0.0:
        corners = [(0.0, 0.0), (disc, 0.0), (disc, end)]
    corners.append((0.0, corners[-1][1]))
    profile = tuple(Line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))
    body = Revolved(profile)
    if not holes:
        return body
    return Without(body, tuple(_hole(each, low, high) for each in holes))


def _hole(hole: DiscHole, low: float, high: float) -> Prism:
    place = (hole.radius_mm * math.cos(hole.angle_rad), hole.radius_mm * math.sin(hole.angle_rad))
    bottom = high - hole.depth_mm
    through = bottom <= low
    return Prism(
        circle(0.5 * hole.diameter_mm, place),
        on_grid(low - PAST_MM if through else bottom),
        on_grid(high + PAST_MM),
    )


# The bench rotor as files: STL, STEP where the kernel exists, and a drawing; each solid measured again.


Values = dict[str, Any]
SEGMENTS = 720
"""Corners of a full circle in the STL: its inertia is light by 5e-5."""


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
        from autobalance.solid.cad.files import read_step_file

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


# A drawing of the bench rotor as SVG: from the side and from its end, with dimensions, to scale.


MARGIN, GAP, BELOW = 30.0, 40.0, 42.0
STYLE = (
    "<style>text{font:5px sans-serif;text-anchor:middle}.m{fill:#eee;stroke:#000;stroke-width:.5}"
    ".h{fill:#fff;stroke:#000;stroke-width:.4}.a{stroke:#888;stroke-width:.25;stroke-dasharray:8 2 2 2}"
    ".d{stroke:#000;stroke-width:.2;fill:none}.t{text-anchor:start}</style>"
)


def rotor_drawing(rotor: DiscOnShaft, holes: Sequence[DiscHole]) -> bytes:
    """Return the drawing as SVG, one unit a millimetre."""
    width = rotor.length_mm + GAP + rotor.disc_mm + 2.0 * MARGIN
    height = rotor.disc_mm + BELOW + 2.0 * MARGIN
    middle = MARGIN + 0.5 * rotor.disc_mm
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.1f}mm" height="{height:.1f}mm" '
        f'viewBox="0 0 {width:.1f} {height:.1f}">{STYLE}<rect width="100%" height="100%" fill="#fff"/>',
        *_side(rotor, holes, middle),
        *_end(rotor, holes, MARGIN + rotor.length_mm + GAP + 0.5 * rotor.disc_mm, middle),
        _title(rotor, height),
        "</svg>",
    ]
    return "\n".join(parts).encode()


def _side(rotor: DiscOnShaft, holes: Sequence[DiscHole], y: float) -> list[str]:
    shaft, disc, end = 0.5 * rotor.shaft_mm, 0.5 * rotor.disc_mm, rotor.shaft_each_side_mm
    left, right = MARGIN, MARGIN + rotor.length_mm
    bottom = y + disc
    return [
        _box(left, y - shaft, rotor.length_mm, rotor.shaft_mm),
        _box(left + end, y - disc, rotor.thickness_mm, rotor.disc_mm),
        *(_hidden(each, left + end + rotor.thickness_mm, y, rotor.thickness_mm) for each in holes),
        f'<line class="a" x1="{left - 8:.2f}" y1="{y:.2f}" x2="{right + 8:.2f}" y2="{y:.2f}"/>',
        *_across(left + end, left + end + rotor.thickness_mm, bottom + 10.0, f"t {rotor.thickness_mm:.3f}"),
        *_across(left, left + end, bottom + 10.0, f"L2 {end:.3f}"),
        *_across(left, right, bottom + 22.0, f"L1 {rotor.length_mm:.3f}"),
        *_upright(left - 12.0, y - shaft, y + shaft, f"Ø{rotor.shaft_mm:g}"),
        *_upright(right + 14.0, y - disc, y + disc, f"Ø{rotor.disc_mm:g}"),
    ]


def _hidden(hole: DiscHole, face: float, y: float, thickness: float) -> str:
    height, depth = hole.radius_mm * math.sin(hole.angle_rad), min(hole.depth_mm, thickness)
    top = y - height - 0.5 * hole.diameter_mm
    return (
        f'<rect class="d" stroke-dasharray="2 1" x="{face - depth:.3f}" y="{top:.3f}"'
        f' width="{depth:.3f}" height="{hole.diameter_mm:.3f}"/>'
    )


def _end(rotor: DiscOnShaft, holes: Sequence[DiscHole], x: float, y: float) -> list[str]:
    disc = 0.5 * rotor.disc_mm
    shapes = [
        _circle("m", x, y, disc),
        _circle("m", x, y, 0.5 * rotor.shaft_mm),
        f'<line class="a" x1="{x - disc - 6:.2f}" y1="{y:.2f}" x2="{x + disc + 6:.2f}" y2="{y:.2f}"/>',
        f'<line class="a" x1="{x:.2f}" y1="{y - disc - 6:.2f}" x2="{x:.2f}" y2="{y + disc + 6:.2f}"/>',
    ]
    for number, hole in enumerate(holes):
        at_x = x + hole.radius_mm * math.cos(hole.angle_rad)
        at_y = y - hole.radius_mm * math.sin(hole.angle_rad)
        words = f"Ø{hole.diameter_mm:g} × {hole.depth_mm:g} at R {hole.radius_mm:g}"
        words += f", {math.degrees(hole.angle_rad):g}°"
        shapes.append(_circle("h", at_x, at_y, 0.5 * hole.diameter_mm))
        shapes.append(f'<text x="{x:.2f}" y="{y + disc + 12.0 + 7.0 * number:.2f}">{escape(words)}</text>')
    return shapes


def _title(rotor: DiscOnShaft, height: float) -> str:
    words = (
        f"Rotor, mm: {rotor.mass_g / 1e3:.4f} kg, {rotor.polar_g_mm2 / 1e3:.3f} kg·mm² at "
        f"{rotor.density_g_mm3 * 1e6:g} kg/m³ (without holes)"
    )
    return f'<text class="t" x="{MARGIN:.1f}" y="{height - 8.0:.1f}">{escape(words)}</text>'


def _box(x: float, y: float, width: float, height: float) -> str:
    return f'<rect class="m" x="{x:.3f}" y="{y:.3f}" width="{width:.3f}" height="{height:.3f}"/>'


def _circle(kind: str, x: float, y: float, radius: float) -> str:
    return f'<circle class="{kind}" cx="{x:.3f}" cy="{y:.3f}" r="{radius:.3f}"/>'


def _across(low: float, high: float, y: float, words: str) -> list[str]:
    ends = "".join(f"M{x:.2f} {y - 3:.2f}V{y + 2:.2f}" for x in (low, high))
    path = f"{ends}M{low:.2f} {y:.2f}H{high:.2f}"
    return [
        f'<path class="d" d="{path}"/>',
        f'<text x="{0.5 * (low + high):.2f}" y="{y - 1.5:.2f}">{escape(words)}</text>',
    ]


def _upright(x: float, low: float, high: float, words: str) -> list[str]:
    ends = "".join(f"M{x - 2:.2f} {y:.2f}H{x + 2:.2f}" for y in (low, high))
    place = f"{x - 3.0:.2f}", f"{0.5 * (low + high):.2f}"
    turned = f'transform="rotate(-90 {place[0]} {place[1]})"'
    return [
        f'<path class="d" d="{ends}M{x:.2f} {low:.2f}V{high:.2f}"/>',
        f'<text x="{place[0]}" y="{place[1]}" {turned}>{escape(words)}</text>',
    ]
