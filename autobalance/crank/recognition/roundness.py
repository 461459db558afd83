"""Roundness of journals and crankpins, with a warning of oval ones."""

from __future__ import annotations

import math

import numpy as np

from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

OVAL_SHARE = 2e-3
"""Largest less smallest diameter, as a share of it, up to which a journal is round: ground ones are to
1e-4, and a mesh that was scaled by mistake is out by percents."""
OVAL_MM = 0.02
"""... or up to this [mm], if that is more: of pins thinner than 10 mm."""
NEAR_SHARE = 0.05
"""Largest distance of a journal's own corner from its radius, as a share of it."""
LEAST_CORNERS, MOST_GAP_RAD = 8, 0.5 * math.pi
ROUNDS = 12
"""Fits, each without the corners that are farthest off the last: those of oil holes and keyways lie inside
on chords, those of other surfaces beside it outside."""
ON_IT = 1e-4
"""Share of the radius within which all corners lie on the fit."""


def ovality_warning(anatomy: Anatomy, mesh: Mesh) -> str | None:
    """Return a warning of the most oval journal or crankpin, None if all are round; ``mesh`` in file axes."""
    corners = np.ascontiguousarray(mesh.moved(anatomy.file_to_rotor).vertices.T)
    pins: list[tuple[str, Pin]] = [
        *((f"main journal {pin.number}", pin) for pin in anatomy.main_journals),
        *((f"the crankpin of throw {throw.number}", throw.crankpin) for throw in anatomy.throws),
    ]
    oval_mm = [(_oval_mm(corners, pin), name, pin) for name, pin in pins]
    most, name, pin = max(oval_mm, key=lambda each: each[0] / each[2].diameter_mm)
    rough = 0.0 if anatomy.scan is None else 2.0 * anatomy.scan.roughness_mm
    if most <= max(OVAL_SHARE * pin.diameter_mm, OVAL_MM, rough):
        return None
    return (
        f"{name} is oval: its diameters differ by {most:.3g} mm ({most / pin.diameter_mm:.1%}); a round one "
        "was expected; the crank is measured as it is, but look whether the file was stretched along one axis"
    )


def _oval_mm(corners: Array, pin: Pin) -> float:
    """Return largest less smallest diameter of a cylinder, of a mesh's ``corners`` (3, n).

    It is fitted: r = R + a₁ cos(φ − α₁) + a₂ cos 2(φ − α₂).
    """
    low, high = pin.z_range_mm
    radius = 0.5 * pin.diameter_mm
    slack = 1e-3 * (high - low)
    rows = np.flatnonzero((corners[2] >= low - slack) & (corners[2] <= high + slack))
    x, y = (column.take(rows) - middle for column, middle in zip(corners, pin.centre_mm[:2], strict=False))
    r = np.hypot(x, y)
    mine = np.abs(r - radius) <= NEAR_SHARE * radius
    angle, r = np.arctan2(y[mine], x[mine]), r[mine]
    for _ in range(ROUNDS):
        gaps = np.diff(np.sort(angle), append=angle.min(initial=0.0) + 2.0 * math.pi)
        if len(r) < LEAST_CORNERS or gaps.max() > MOST_GAP_RAD:
            return 0.0
        columns = [np.ones(len(r)), *(f(k * angle) for k in (1, 2) for f in (np.cos, np.sin))]
        rows = np.stack(columns, axis=1)
        fit = np.linalg.lstsq(rows, r, rcond=None)[0]
        off = r - rows @ fit
        oval_mm = 4.0 * math.hypot(*fit[3:].tolist())
        if np.abs(off).max() <= ON_IT * radius:
            return oval_mm
        kept = np.abs(off) < 0.5 * np.abs(off).max()
        angle, r = angle[kept], r[kept]
    return oval_mm if oval_mm > float(np.ptp(off)) else 0.0
