"""One pass of the loop: the untouched crank cut to planned depths, and measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.balancing.measuring import Measure, Measured
from autobalance.balancing.rotor import Rotor
from autobalance.correction.contract import Cut
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.soundness.boolean_slivers import without_flakes
from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class Pass:
    """A cut crank as it was measured, and the bodies of its cuts (rotor frame).

    ``metal`` is the metal that all of them took of a scanned crank, in the file's axes; None of a drawn one.
    """

    depths_mm: Array
    tools: tuple[Solid, ...]
    solid: Solid
    measured: Measured
    moments: Moments
    residual: Unbalance
    share: float
    metal: Solid | None = None


def cut_and_measure(
    rotor: Rotor,
    tolerance: Tolerance,
    cuts: Sequence[Cut],
    depths_mm: Array,
    measure: Measure,
) -> Pass:
    """Cut the untouched crank to these depths, one a cut, and measure it.

    Raises
    ------
    SolidError
        If the cut cannot be made, or the cut solid is not a crank any more.
    """
    cut_depths = made_cuts(cuts, depths_mm)
    tools = tuple(cut.tool(depth) for cut, depth in cut_depths)
    solid, pressed_in, metal = rotor.solid, Moments.zero(), None
    for adds in (True, False):
        chosen = [tool for tool, (cut, _) in zip(tools, cut_depths, strict=True) if cut.adds_metal == adds]
        if chosen:
            tool = union(chosen).moved(rotor.anatomy.rotor_to_file)
            if adds:
                solid = solid + tool
            elif rotor.anatomy.scan is None:
                solid = solid - tool
            else:
                metal, solid = solid.split(tool)
    solid = without_flakes(solid, rotor.solid)
    for cut, depth in cut_depths:
        pressed_in = pressed_in + cut.pressed_in(depth)
    measured = measure(rotor, solid, cut_depths)
    moments = measured.moments + measured.added + pressed_in
    residual = Unbalance.of(moments + rotor.loads)
    return Pass(depths_mm, tools, solid, measured, moments, residual, tolerance.used_share(residual), metal)


def made_cuts(cuts: Sequence[Cut], depths_mm: Array) -> tuple[tuple[Cut, float], ...]:
    """Return the cuts that are made, each with its depth."""
    return tuple((cut, float(depth)) for cut, depth in zip(cuts, depths_mm, strict=True) if depth > 0.0)
