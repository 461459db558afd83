"""Moves and commands of a program, before a post writes them in the machine's dialect."""

from __future__ import annotations

from dataclasses import dataclass

from autobalance.machining.input import CuttingTool


@dataclass(frozen=True)
class Note:
    """A comment."""

    text: str


@dataclass(frozen=True)
class Change:
    """Another tool, its speed, and the height that it comes to first."""

    tool: CuttingTool
    rpm: float
    safe_mm: float


@dataclass(frozen=True)
class Index:
    """The rotary axis turns to an angle: unclamp, turn, clamp."""

    angle_deg: float


@dataclass(frozen=True)
class Go:
    """A straight move to what is given; ``feed`` None: in rapid."""

    x: float | None = None
    y: float | None = None
    z: float | None = None
    a: float | None = None
    feed: float | None = None


@dataclass(frozen=True)
class Bore:
    """A drilling cycle at a place; ``peck_mm`` 0: in one go."""

    x: float
    y: float
    bottom: float
    retract: float
    feed: float
    peck_mm: float


@dataclass(frozen=True)
class Unclamp:
    """The rotary axis is freed to turn under a cutter."""


@dataclass(frozen=True)
class Clamp:
    """The rotary axis is held again."""


@dataclass(frozen=True)
class Retreat:
    """Back to the safe height, spindle and coolant off."""

    safe_mm: float


Block = Note | Change | Index | Go | Bore | Unclamp | Clamp | Retreat
