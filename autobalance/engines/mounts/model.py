"""The engine on its mounts, from a job."""

from __future__ import annotations

from dataclasses import dataclass

from autobalance.engines.mounts.rigid_body import MountedEngine
from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class Mounts:
    """The engine on its mounts, speeds (k,) [rad/s], and named places (3,) [mm]."""

    engine: MountedEngine
    speeds_rad_s: Array
    points: tuple[tuple[str, Array], ...]
