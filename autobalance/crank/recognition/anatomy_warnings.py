"""Warnings of an anatomy: what could be meant otherwise, and cylinders that are taken for nothing."""

from __future__ import annotations

from autobalance.crank.anatomy import Anatomy, Cylinder, Doubt, Pin
from autobalance.wording import bare, degrees

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
