"""Parts of cuts that several kinds share: defaults of cuts that put no metal in, and their listing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from autobalance.correction.contract import Correction, Cut
from autobalance.crank.anatomy import Anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array

Made = Sequence[tuple[Cut, float]]
"""Cuts with their depths [mm]."""


class WithWall(Protocol):
    """Limits with a wall of metal."""

    @property
    def min_wall_mm(self) -> float:
        """Metal to leave [mm]."""
        ...


class EmptyPlace:
    """Cut without other metal put in: defaults for a `Cut` of that sort."""

    limit_is_reach: bool = False
    adds_metal: bool = False

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return zero: no other metal is put in."""
        del depth_mm
        return Moments.zero()


class WalledCut(EmptyPlace):
    """Cut whose clearance is the wall of its limits."""

    limits: WithWall

    @property
    def clearance_mm(self) -> float:
        return self.limits.min_wall_mm


def listed(
    kind: str,
    change: Moments,
    depth_mm: float,
    density_g_mm3: float,
    *,
    web: int | None,
    axis: Array | None = None,
    tool_volume_mm3: float = 0.0,
    face: str | None = None,
    position_mm: Array | None = None,
    **details: Any,
) -> Correction:
    """Return a finished correction; its position is by default the centre of the metal removed or added."""
    return Correction(
        kind=kind,
        face=face,
        web=web,
        position_mm=change.centre_mm if position_mm is None else position_mm,
        depth_mm=depth_mm,
        change=change,
        removed_volume_mm3=-change.mass_g / density_g_mm3,
        details=details,
        axis=axis,
        tool_volume_mm3=tool_volume_mm3,
    )


def as_taken(
    correction: Correction,
    change: Moments,
    rate: Moments | None,
    new_area_mm2: float,
    removed_volume_mm3: float | None = None,
    **details: Any,
) -> Correction:
    """Return a correction as it was measured on the metal that its tool really took.

    Parameters
    ----------
    correction : Correction
        As planned.
    change, rate : Moments
        Of the crank, rotor frame, and the change by one more millimetre of depth; None: as planned.
    new_area_mm2 : float
        Of the new face.
    removed_volume_mm3 : float or None
        None: in proportion to the masses; not so where other metal is pressed in.
    **details
        Other details, listed in place of those planned.
    """
    key, at_centre = "new_face_area_mm2", np.array_equal(correction.position_mm, correction.change.centre_mm)
    if removed_volume_mm3 is None:
        removed_volume_mm3 = correction.removed_volume_mm3 * change.mass_g / correction.change.mass_g
    return replace(
        correction,
        position_mm=change.centre_mm if at_centre else correction.position_mm,
        change=change,
        removed_volume_mm3=removed_volume_mm3,
        details=correction.details | ({key: new_area_mm2} if key in correction.details else {}) | details,
        rate=correction.rate if rate is None else rate,
    )


def metal_within(solid: Solid, anatomy: Anatomy, bodies: Mapping[int, Solid]) -> dict[int, Solid]:
    """Return the metal of a crank in file coordinates within a body of each web, in the rotor frame.

    One boolean with the whole crank for all bodies, in the rotor frame: manifold3d compares boxes along its
    axes, and those around slabs that lie slantwise hold most of a crank.
    """
    if not bodies:
        return {}
    near = solid.moved(anatomy.file_to_rotor) & union(list(bodies.values()))
    return {web: near & body for web, body in bodies.items()}


def on_step(depth_mm: float, step_mm: float, rounding: Callable[[float], float] = round) -> float:
    """Return a depth rounded to the machine's step (``round``, ``math.floor`` or ``math.ceil``)."""
    if step_mm == 0.0:
        return depth_mm
    steps = depth_mm / step_mm
    nearest = round(steps)
    if abs(steps - nearest) > 1e-6:
        nearest = math.floor(steps) if rounding is math.floor else math.ceil(steps)
    return nearest * step_mm
