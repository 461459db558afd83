"""Generated cranks at random places, with the anatomy they truly have: ground truth for other tests."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.drawn_cranks.design import PRESETS, Design, preset
from autobalance.drawn_cranks.generate import crank_shape, crank_solid, exact_moments
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.types import Array
from autobalance.units import MM_PER

if TYPE_CHECKING:
    import autobalance as ab
    from autobalance.solid.cad.brep import ExactSolid

SEGMENTS = (12, 16, 24, 37, 64, 128, 360, 1000)
REACH_MM = 500.0
AT_OTHER_ANGLES = ("inline-3", "inline-6", "v8-flatplane", "v12-60")
"""Presets with the throws of others, at other angles: where it is all the same, in sweeps only."""


@lru_cache(maxsize=1)
def single_step() -> bytes:
    """Return the STEP file of the preset ``single``, the same bytes for all tests: read once, it is known."""
    import autobalance as ab

    return ab.generate("single", file="crank.step").data


@lru_cache(maxsize=48)
def drawn(design: Design, segments: int) -> Solid:
    """Return a crank as it is drawn, for all tests that ask for it once."""
    return crank_solid(design, segments)


@lru_cache(maxsize=16)
def exact(name: str) -> ExactSolid:
    """Return a preset's crank with true surfaces, built by the CAD kernel once."""
    from autobalance.solid.cad.brep import ExactSolid

    return ExactSolid(crank_shape(preset(name)))


@lru_cache(maxsize=24)
def preset_crank(name: str, segments: int = 32) -> ab.Crank:
    """Return a preset as a crank that was read, for all tests that ask for it once."""
    import autobalance as ab

    mesh = drawn(PRESETS[name], segments).mesh
    return ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850)


@lru_cache(maxsize=16)
def true_moments(name: str) -> Moments:
    """Return the moments of a preset's true surfaces."""
    return exact_moments(preset(name))


@dataclass(frozen=True, eq=False)
class GeneratedCrank:
    """A crank as a file would hold it.

    ``soup`` (m, 3, 3) float32 is what an STL file keeps, in ``unit``; ``mesh`` and ``solid`` are what a
    reader makes of it [mm]; ``truth`` is the anatomy in the rotor frame of that file.
    """

    design: Design
    segments: int
    placement: Array
    unit: str
    soup: np.typing.NDArray[np.float32]
    mesh: Mesh
    truth: Anatomy

    @property
    def solid(self) -> Solid:
        return solid_of(self.mesh)


def solid_of(mesh: Mesh) -> Solid:
    """Return a mesh's solid as a reader does: manifold3d builds its body when that is first cut."""
    closed = Solid.of_closed(mesh)
    return Solid.from_mesh(mesh) if closed is None else closed


def random_placement(rng: np.random.Generator, reach_mm: float = REACH_MM) -> Array:
    """Return a rigid motion (4, 4): any rotation, and a shift of up to ``reach_mm`` along each axis."""
    q = rng.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    placement = np.eye(4)
    placement[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    placement[:3, 3] = rng.uniform(-reach_mm, reach_mm, 3)
    return placement


def generated_crank(
    design: str | Design,
    *,
    seed: int | None = None,
    segments: int | None = None,
    unit: str = "mm",
    placement: Array | None = None,
) -> GeneratedCrank:
    """Return a preset or design as a file in ``unit`` would hold it.

    With a ``seed`` it lies anywhere; ``placement`` (4, 4) says where instead; else on its own axes.
    """
    crank = PRESETS[design] if isinstance(design, str) else design
    crank = replace(crank, segments=segments or crank.segments)
    if placement is None:
        placement = np.eye(4) if seed is None else random_placement(np.random.default_rng(seed))
    scale = MM_PER[unit]
    corners = drawn(crank, crank.segments).mesh.moved(placement).corners
    soup = (corners / scale).astype(np.float32)
    mesh = mesh_of_soup(soup, mm_per_unit=scale)
    return GeneratedCrank(crank, crank.segments, placement, unit, soup, mesh, crank_anatomy(crank, placement))


def differences(found: Anatomy, true: Anatomy, length_mm: float = 0.05) -> list[str]:
    """Say in what a recognised anatomy differs from the true one; empty where it does not.

    The axis must be right to 0.02° and 0.1 % of the crank radius, as must crankpin centres; diameters to
    0.2 %; what lies along the axis to ``length_mm``.
    """
    counts = [[len(part) for part in (a.main_journals, a.throws, a.webs)] for a in (found, true)]
    if counts[0] != counts[1]:
        return [f"journals, throws, webs are {counts[0]}, not {counts[1]}"]
    radius = true.throws[0].crank_radius_mm
    wrong: list[str] = []

    def compare(name: str, here: float, there: float, within: float) -> None:
        if not abs(here - there) <= within:
            wrong.append(f"{name} is {here:.5g}, not {there:.5g}")

    axis, wanted = (a.rotor_to_file[:3, 2] for a in (found, true))
    compare("axis", float(np.degrees(np.arccos(np.clip(axis @ wanted, -1.0, 1.0)))), 0.0, 0.02)
    across = (true.file_to_rotor @ found.rotor_to_file[:, 3])[:2]
    compare("axis position", float(np.linalg.norm(across)), 0.0, 1e-3 * radius)
    for a, b in zip(found.throws, true.throws, strict=True):
        name, off = f"crankpin {b.number}", a.crankpin.centre_mm - b.crankpin.centre_mm
        compare(f"{name} centre", float(np.linalg.norm(off[:2])), 0.0, 1e-3 * radius)
        compare(f"{name} z", a.crankpin.centre_mm[2], b.crankpin.centre_mm[2], length_mm)
        compare(
            f"{name} diameter", a.crankpin.diameter_mm, b.crankpin.diameter_mm, 2e-3 * b.crankpin.diameter_mm
        )
        compare(f"{name} width", a.crankpin.width_mm, b.crankpin.width_mm, length_mm)
    for c, d in zip(found.main_journals, true.main_journals, strict=True):
        compare(f"journal {d.number} z", c.centre_mm[2], d.centre_mm[2], length_mm)
        compare(f"journal {d.number} diameter", c.diameter_mm, d.diameter_mm, 2e-3 * d.diameter_mm)
        compare(f"journal {d.number} width", c.width_mm, d.width_mm, length_mm)
    for e, f in zip(found.webs, true.webs, strict=True):
        compare(f"web {f.number} z_min", e.z_min_mm, f.z_min_mm, length_mm)
        compare(f"web {f.number} z_max", e.z_max_mm, f.z_max_mm, length_mm)
        compare(f"web {f.number} counterweight", e.counterweight, f.counterweight, 0.0)
    return wrong
