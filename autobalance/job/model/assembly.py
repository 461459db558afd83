"""The ``[[assembly]]`` tables of a job in mm, g and rad."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from autobalance.job.model.engine import LengthUnit
from autobalance.rigid_rotor.staged_assembly import ShaftKey


@dataclass(frozen=True)
class PartSolid:
    """The solid of a part."""

    file: Path
    unit: LengthUnit | None
    density_g_mm3: float
    turn_rad: float


@dataclass(frozen=True, eq=False)
class AssemblyEntry:
    """A part of the assembly; its own mass and unbalance, or its ``solid`` to measure them on."""

    name: str
    shaft: str
    z_mm: float
    mass_g: float | None
    unbalance_g_mm: complex
    solid: PartSolid | None
    runout_mm: complex
    key: ShaftKey | None
    correct_mm: tuple[float, ...]
    permissible_g_mm: float | None
    speed_ratio: float
    values: Mapping[str, Any] = field(default_factory=dict)
