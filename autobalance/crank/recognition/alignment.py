"""Check of main journals for one axis and of webs' ends for one face, with warnings if there is doubt."""

from __future__ import annotations

import math

from autobalance.crank.anatomy import Anatomy

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
