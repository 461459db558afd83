"""Check of an anatomy: one axis, one face, roundness; and its warnings."""

from __future__ import annotations

import math

import numpy as np

from autobalance.crank.anatomy import Anatomy, Cylinder, Doubt, Pin
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.wording import bare, degrees

# Check of main journals for one axis and of webs' ends for one face, with warnings if there is doubt.


COAXIAL_SHARE = 1e-4
"""Main journals are coaxial when their centres are off the common axis by less than this share of the
smallest crank radius. Files are rounded to less. The uncertainty of the axis' position is 0.1 %. At a
tenth of it, a crank of 2.6 kg and 27 mm is out of balance by 7 g·mm, about all that G 6.3 permits it at
15 000 rpm."""

BENT_MM = 0.03
"""Run-out from which a crank is called bent: shops straighten from 0.02 to 0.05 mm on."""


def run_outs_mm(anatomy: Anatomy) -> tuple[float, ...]:
    """Return the run-out of each main journal on a dial, were the crank turned about the common axis.

    It is twice the distance of the journal's centre; empty for a drawn crank whose journals are coaxial.
    """
    if anatomy.scan is not None:
        return tuple(each.run_out_mm or 0.0 for each in anatomy.scan.journals)
    if anatomy.journal_misalignment_mm <= _coaxial_mm(anatomy):
        return ()
    return tuple(2.0 * math.hypot(*journal.centre_mm[:2]) for journal in anatomy.main_journals)


def _coaxial_mm(anatomy: Anatomy) -> float:
    return COAXIAL_SHARE * min(throw.crank_radius_mm for throw in anatomy.throws)


def misalignment_warning(anatomy: Anatomy) -> str | None:
    """Return a warning that main journals are out of line, the axis then being their mean; None if not."""
    off = anatomy.journal_misalignment_mm
    within = _coaxial_mm(anatomy)
    if off <= within:
        return None
    bent = _bent(anatomy)
    axis = "the typed axis" if anatomy.typed.is_axis else "their common axis"
    return (
        f"{bent}the main journals are not coaxial: one is {off:.3g} mm off {axis}, more than "
        f"{within:.2g} mm; everything is measured about that axis, which axis_point_mm and axis_direction "
        "(--axis-point, --axis-direction) or main_journals can set"
    )


def _bent(anatomy: Anatomy) -> str:
    """Return a text on a scanned crank whose journals run out by more than noise and wear; empty if none."""
    if anatomy.scan is None:
        return ""
    run_out = run_outs_mm(anatomy)
    worst = max(range(len(run_out)), key=run_out.__getitem__)
    if run_out[worst] < BENT_MM + 6.0 * anatomy.scan.axis_offset_mm:
        return ""
    return f"the crank is bent: main journal {worst + 1} runs out by {run_out[worst]:.3g} mm; "


def step_warnings(anatomy: Anatomy) -> tuple[str, ...]:
    """Return a warning for each end of a scanned crank's webs that may as well be at another face."""
    if anatomy.scan is None:
        return ()
    return tuple(
        f"web {web.number} has a collar beside it: its {name} is taken at {end:.2f} mm, and may be at "
        f"{' or '.join(f'{other:.2f}' for other in others)} mm; its standard error allows for that"
        for web in anatomy.webs  # none beside a drawing, whose webs are taken
        for name, end, others in zip(
            ("z_min_mm", "z_max_mm"),
            (web.z_min_mm, web.z_max_mm),
            anatomy.scan.webs[web.number - 1].other_ends_mm,
            strict=True,
        )
        if others
    )


# Roundness of journals and crankpins, with a warning of oval ones.


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


# Warnings of an anatomy: what could be meant otherwise, and cylinders that are taken for nothing.


NOUNS = {"main_journal": "main journal", "crankpin": "crankpin", "axis": "axis"}


def anatomy_warnings(anatomy: Anatomy) -> tuple[str, ...]:
    """Return a warning for each doubt, and for each cylinder beside the axis that is taken for nothing."""
    beside = (each for each in anatomy.cylinders if each.kind == "outside" and each.role == "none")
    return (*map(_doubt_warning, anatomy.doubts), *map(_beside_warning, beside))


def _doubt_warning(doubt: Doubt) -> str:
    name = f"{NOUNS[doubt.about]}{'' if doubt.about == 'axis' else f' {doubt.number}'}"
    return (
        f"{name} may be another cylinder: {_told(doubt.chosen)} was taken; "
        f"{_told(doubt.other)} may be meant. If it is, enter it in the job or give --set '{doubt.setting}'"
    )


def _beside_warning(cylinder: Cylinder) -> str:
    return (
        f"a cylinder, {_told(cylinder)}, is {bare(cylinder.offset_mm)} mm beside the axis at "
        f"{degrees(cylinder.angle_deg)} and is not a crankpin; it counts as metal only"
    )


def _told(pin: Pin) -> str:
    return f"⌀{bare(pin.diameter_mm)} × {bare(pin.width_mm)} mm at z {bare(float(pin.centre_mm[2]))} mm"
