"""Signs of an engine in its crank alone: pins that hold two rods, throws that cancel, usual factors."""

from __future__ import annotations

import cmath
import math

from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Anatomy
from autobalance.job.model import EngineParts
from autobalance.rigid_rotor.unbalance import Unbalance

TWO_RODS_WIDTH = 0.75
"""Smallest width of a crankpin over its diameter for two rods side by side: singles and in-line engines have
0.35 to 0.62 (presets, bundled cranks, gmsh 4a), V8, V12 and V twins 0.79 and more."""
CANCELLED = 1e-3
"""Share of a sum of throws, or of their moments, below which they cancel."""
USUAL_PARTS_G_MM3 = ((0.86e-3, 1.68e-3), (1.29e-3, 1.97e-3))
"""Rotating and reciprocating mass of a rod over the cube of the stroke: those of the bundled CRF 250 R, and
those that four newcomers took for ordinary ones of a stroke of 58 mm."""
USUAL_FACTOR = (0.05, 1.0)
"""Factors that a single may be made for; a crank beyond them is for other parts than the usual ones."""


def holds_two_rods(anatomy: Anatomy) -> bool:
    """Return whether every crankpin is wide enough for two rods side by side."""
    return all(
        throw.crankpin.width_mm >= TWO_RODS_WIDTH * throw.crankpin.diameter_mm for throw in anatomy.throws
    )


def throws_cancel(anatomy: Anatomy) -> bool:
    """Return whether equal masses on all crankpins leave neither a force nor a couple."""
    pins = [
        (throw.crank_radius_mm * cmath.rect(1.0, throw.angle_rad), float(throw.crankpin.centre_mm[2]))
        for throw in anatomy.throws
    ]
    size = sum(abs(pull) for pull, _ in pins)
    middle = sum(z for _, z in pins) / len(pins)
    lever = sum(abs(pull * (z - middle)) for pull, z in pins)
    force = abs(sum(pull for pull, _ in pins))
    couple = abs(sum(pull * (z - middle) for pull, z in pins))
    return force <= CANCELLED * size and couple <= CANCELLED * lever and len(pins) > 1


def own_factors(crank: Crank) -> tuple[float, float] | None:
    """Return the balance factors that a crank of one throw has with usual parts, low and high.

    None where its parts are not usual ones, or are not in the file.
    """
    if not crank.holds_crankpins:
        return None
    (throw,) = crank.anatomy.throws
    x, y = Unbalance.of(crank.moments).resultant_g_mm
    along = complex(x, y) * cmath.rect(1.0, -throw.angle_rad)
    cube = (2.0 * throw.crank_radius_mm) ** 3
    factors = sorted(
        (-along.real / throw.crank_radius_mm - rotating * cube) / (reciprocating * cube)
        for rotating, reciprocating in USUAL_PARTS_G_MM3
    )
    low, high = USUAL_FACTOR
    return (factors[0], factors[1]) if factors[1] > low and factors[0] < high else None


def factor_hint(crank: Crank) -> str:
    """Return a suggestion for the balance factor of a crank, in words."""
    anatomy = crank.anatomy
    if throws_cancel(anatomy):
        return "0: its throws cancel, force and couple"
    if holds_two_rods(anatomy):
        return "0.5 for vee engines of two rods a crankpin"
    if len(anatomy.throws) > 1:
        return "0.5: its throws leave a force or a couple"
    own = own_factors(crank)
    if own is None:
        return "0.25 to 0.65 for a single; a factor above the present one needs added metal"
    low, high = max(own[0], 0.0), min(own[1], 1.0)
    safe = math.floor(10.0 * low) / 10.0
    return (
        f"{safe:.1f}, say: it has {low:.2f} to {high:.2f} with usual parts, and higher than its own needs"
        " metal added"
    )


def layout_name(anatomy: Anatomy, engine: EngineParts) -> str:
    """Return the layout of an engine in words: ``single``, ``in-line 4``, ``V8, cross-plane``.

    Where the job has one rod on each crankpin, the words are those of an in-line engine.
    """
    throws = len(anatomy.throws)
    rods = [engine.of_throw(throw.number).rods for throw in anatomy.throws]
    if throws == 1:
        names = {1: "single", 2: "V twin"}
        return names.get(rods[0], f"{rods[0]} rods on one throw")
    if all(each == 1 for each in rods):
        return f"in-line {throws}"
    if all(each == 2 for each in rods):
        planes = {round(math.degrees(throw.angle_rad) % 180.0 / 15.0) % 12 for throw in anatomy.throws}
        plane = {1: ", flat-plane", 2: ", cross-plane"}.get(len(planes), "") if throws == 4 else ""
        return f"V{sum(rods)}{plane}"
    return f"{throws} throws, {sum(rods)} cylinders"
