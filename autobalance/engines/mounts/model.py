"""The engine on its mounts, from a job."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from autobalance.engines.mounts.frame import FrameModes, read_modes
from autobalance.engines.mounts.rigid_body import MountedEngine
from autobalance.types import Array


@dataclass(frozen=True)
class Measured:
    """A report of ``orders`` of a point along an axis: its file as the job names it."""

    point: str
    axis: Literal["x", "y", "z"]
    file: str


@dataclass(frozen=True)
class FrameFile:
    """Modes of a frame: file, unit of length, damping of modes without, largest distance of nodes [mm]."""

    file: str
    unit: Literal["m", "mm"]
    damping_ratio: float
    within_mm: float


@dataclass(frozen=True, eq=False)
class FramePlace:
    """A place of the frame, by its modes' shapes (3, m) there."""

    shapes: Array


@dataclass(frozen=True, eq=False)
class Mounts:
    """The engine on its mounts, speeds (k,) [rad/s], and named places (3,) [mm]; ``on_frame`` names some."""

    engine: MountedEngine
    speeds_rad_s: Array
    points: tuple[tuple[str, Array | FramePlace], ...]
    measured: tuple[Measured, ...] = ()
    frame: FrameFile | None = None
    on_frame: tuple[str, ...] = ()

    def moves(self, place: Array | FramePlace) -> Array:
        """Return the displacement (3, 6 + m) of a place of the engine, or of the frame, by the unknowns."""
        if isinstance(place, FramePlace):
            return self.engine.frame_moves(place.shapes)
        return self.engine.moves(place)

    def held_by_frame(self, folder: Path) -> Mounts:
        """Return the engine on its flexible frame, whose modes are read; this one without a frame.

        Raises
        ------
        JobError
            If the file has no modes, or no nodes at mounts and points of the frame.
        """
        if self.frame is None:
            return self
        modes = read_modes(folder / self.frame.file, self.frame.unit, self.frame.damping_ratio)
        within = self.frame.within_mm
        at = tuple(
            modes.at(each.at_mm, within, f"mount {number}")
            for number, each in enumerate(self.engine.mounts, 1)
        )
        points = tuple((name, self._on_frame(name, place, modes)) for name, place in self.points)
        engine = replace(self.engine, frame=modes, on_frame=at)
        return replace(self, engine=engine, points=points)

    def _on_frame(self, name: str, place: Array | FramePlace, modes: FrameModes) -> Array | FramePlace:
        """Return a point, by its node if it is on the frame."""
        if name not in self.on_frame or self.frame is None or isinstance(place, FramePlace):
            return place
        return FramePlace(modes.at(place, self.frame.within_mm, f"point {name!r}"))
