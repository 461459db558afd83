"""Cuts as a hand dragged them, made and measured: other depths and drills, other angles about the axis."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from autobalance.browser.prediction import checked_cuts
from autobalance.errors import JobError
from autobalance.runtime import Notify
from autobalance.types import Array, Values

if TYPE_CHECKING:
    from autobalance.correction.contract import Cut
    from autobalance.job import Job
    from autobalance.rigid_rotor.moments import Moments
    from autobalance.solid.csg.solid import Solid
    from autobalance.solid.csg.tool import Tool


@dataclass(frozen=True, eq=False)
class TurnedCut:
    """A cut, turned about the crank axis: what cutting and measuring ask of a `Cut`."""

    cut: Cut
    motion: Array

    @property
    def adds_metal(self) -> bool:
        """Whether the tool is added to the crank."""
        return self.cut.adds_metal

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to subtract, or to add."""
        return self.cut.tool(depth_mm).moved(self.motion)

    def exact_tool(self, depth_mm: float) -> Tool | None:
        """Return the tool without facets."""
        from autobalance.solid.csg.tool import placed

        tool = self.cut.exact_tool(depth_mm)
        return None if tool is None else placed(tool, self.motion)

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of what is put in."""
        return self.cut.pressed_in(depth_mm).moved(self.motion)


@dataclass(frozen=True)
class Trial:
    """Measured crank, and the bytes of the file on which it was measured; None if there is no file."""

    values: Values
    data: bytes | None


def tried(
    job: Job,
    model: Mapping[str, Any],
    depths_mm: Sequence[Any],
    turns_deg: Sequence[Any],
    notify: Notify,
    diameters_mm: Sequence[Any] = (),
) -> Trial:
    """Cut a job's crank to these depths, turns and drills, and measure what its file holds.

    Parameters
    ----------
    job : Job
        Job of the result whose cuts were dragged.
    model : mapping
        The result's `linear_model`.
    depths_mm, turns_deg : sequence of float
        One a cut.
    notify : callable
        Called with what runs, in a few words.
    diameters_mm : sequence of float or None
        One a cut, None where a hole keeps its own; empty: all do. Walls are not looked at again.

    Returns
    -------
    Trial
        ``values`` with keys as in a report: ``residual``, and ``worst_share``, ``mass_change_g``,
        ``inertia_change_kg_mm2``, ``within_tolerance``.

    Raises
    ------
    JobError
        If they are not as many as cuts, out of their limits, or the job makes other cuts now.
    """
    from autobalance.balancing.cut_pass import cut_and_measure
    from autobalance.balancing.run import measure_of
    from autobalance.declare import encoded
    from autobalance.report.records import balance as records
    from autobalance.studies.study.plan import planned

    depths, turns, diameters = checked_cuts(model, depths_mm, turns_deg, diameters_mm)
    plan = planned(job, notify)
    planned_cuts = plan.result.made
    if [cut.label for cut, _ in planned_cuts] != [each["label"] for each in model["cuts"]]:
        raise JobError("the job makes other cuts by now: balance again, then drag")
    notify("cutting as dragged")
    cuts = [
        cast("Cut", TurnedCut(_of_diameter(cut, diameter), _about_axis(turn)))
        for (cut, _), turn, diameter in zip(planned_cuts, turns, diameters, strict=True)
    ]
    done = cut_and_measure(plan.rotor, plan.tolerance, cuts, np.array(depths), measure_of(plan.crank.source))
    change = done.moments - plan.result.initial_moments
    values = {
        "residual": encoded(records.Unbalance.of(done.residual, plan.tolerance.places_mm)),
        "worst_share": done.share,
        "within_tolerance": done.share <= 1.0,
        "mass_change_g": float(change.mass_g),
        "inertia_change_kg_mm2": float(change.polar_inertia_g_mm2) / 1000.0,
    }
    return Trial(values, done.measured.data)


def _of_diameter(cut: Any, diameter_mm: float | None) -> Any:
    return cut if diameter_mm is None else replace(cut, hole=cut.hole.of_radius(0.5 * diameter_mm))


def _about_axis(turn_deg: float) -> Array:
    cosine, sine = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    motion = np.eye(4)
    motion[:2, :2] = [[cosine, -sine], [sine, cosine]]
    return motion
