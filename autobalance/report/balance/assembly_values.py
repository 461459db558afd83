"""The stages of an assembly as JSON values and as lines to read."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.dynamics.staged_assembly import CRANK, AssemblyStage
from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.units import wrapped_deg

Values = dict[str, Any]
Places = tuple[float, float] | None


def assembly_values(
    stages: Sequence[AssemblyStage], places: Places, shown: Callable[[Unbalance, Places, None], Values]
) -> list[Values]:
    """Return the stages as JSON values; ``shown`` makes an unbalance's values."""
    return [_stage(number, each, places, shown) for number, each in enumerate(stages, 1)]


def _stage(
    number: int, stage: AssemblyStage, places: Places, shown: Callable[[Unbalance, Places, None], Values]
) -> Values:
    part = stage.part
    total = Unbalance(_xy(stage.sum_g_mm), _xy(stage.sum_moment_g_mm2))
    return {
        "stage": number,
        "name": part.name,
        "shaft": part.shaft,
        "mass_g": stage.mass_g,
        "part_g_mm": _list(part.unbalance_g_mm),
        "runout_g_mm": _list(stage.runout_g_mm),
        "key_g_mm": _list(stage.key_g_mm),
        "sum": shown(total, places if part.shaft == CRANK else None, None),
        "permissible_g_mm": stage.permissible_g_mm,
        "within": stage.within,
        "corrections": [
            {
                "z_mm": each.z_mm,
                "g_mm": abs(each.unbalance_g_mm),
                "angle_deg": wrapped_deg(math.degrees(cmath.phase(each.unbalance_g_mm))),
            }
            for each in stage.corrections
        ],
        "left": _list(stage.left_g_mm),
    }


def _xy(value: complex) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([value.real, value.imag])


def _list(value: complex) -> list[float]:
    return [value.real, value.imag]


def assembly_text(stages: Sequence[Mapping[str, Any]], units: DisplayUnits) -> str:
    """Return the stages in columns."""
    rows: list[Sequence[str]] = [("Assembly", "mass so far", "sum", "at", "permitted", "", "take out")]
    for each in stages:
        shaft = "" if each["shaft"] == CRANK else f" ({each['shaft']})"
        taken = ", ".join(
            f"{units.of_unbalance(cut['g_mm'])} at {cut['angle_deg']:.1f}°, z {units.of_length(cut['z_mm'])}"
            for cut in each["corrections"]
        )
        rows.append(
            (
                f"  {each['stage']}. {each['name']}{shaft}",
                units.of_mass(each["mass_g"]),
                units.of_unbalance(each["sum"]["magnitude_g_mm"]),
                f"{each['sum']['angle_deg']:.1f}°",
                units.of_unbalance(each["permissible_g_mm"]),
                "within" if each["within"] else "ABOVE",
                taken,
            )
        )
    return table(rows)
