"""When it cannot be done: by how much, in which plane, what limits it, and what would fix it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.correction.kind import Array, Cut
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance


@dataclass(frozen=True, eq=False)
class Shortfall:
    """A residual above the permissible value and what was tried."""

    residual: Unbalance
    tolerance: Tolerance
    per_factor: Unbalance
    factor: float
    cuts: Sequence[Cut]
    depths_mm: Array
    binding: tuple[str, ...]


def explain_shortfall(short: Shortfall, computed: Sequence[str] = (), bound: float = 0.0) -> str:
    """Say by how much, in which plane, what limits it, and what would fix it.

    ``computed`` are changes of the limits that are known to suffice; ``bound`` is the share of the
    permissible value that no plan within the limits gets below, where that is known.
    """
    worst, value, permitted = max(_judged_values(short), key=lambda row: row[1] / row[2])
    text = (
        f"the residual of {worst} is {value:.2f} g·mm, {value - permitted:.2f} g·mm above the permissible "
        f"{permitted:.2f} g·mm"
    )
    if not short.cuts:
        text += "; no face can be lowered on the heavy side"
    elif short.binding:
        text += "; the metal ends at " + ", ".join(short.binding)
    else:
        text += "; none of the cuts at hand acts in the direction that is left"
    if bound > 1.0:
        text += f"; no plan within these limits leaves less than {bound:.3g} times the permissible value"
    enough = "; enough would be: " + ", or ".join(computed) if computed else ""
    return text + enough + "; " + ", or ".join(_fixes(short, estimate=not computed))


def _judged_values(short: Shortfall) -> list[tuple[str, float, float]]:
    rows = [("the resultant", short.residual.magnitude_g_mm, short.tolerance.permissible_g_mm)]
    if short.tolerance.judge == "dynamic":
        a, b = short.tolerance.planes
        for plane, vector in zip((a, b), short.residual.in_planes(a.z_mm, b.z_mm), strict=True):
            rows.append((f"plane {plane.name}", math.hypot(*vector), plane.permissible_g_mm))
    return rows


def _fixes(short: Shortfall, estimate: bool) -> list[str]:
    fixes = []
    factor = reachable_factor(short)
    if factor is not None:
        fixes.append(f"a balance factor of {factor:.4f} can be reached as it is")
    pull = sum(
        abs(float(cut.rate(float(depth)).first_g_mm[:2] @ short.residual.resultant_g_mm))
        for cut, depth in zip(short.cuts, short.depths_mm, strict=True)
        if depth >= cut.max_depth_mm - 1e-6 and cut.max_depth_mm > cut.least_depth_mm
    )
    if estimate and short.binding and pull > 0.0:
        deeper = short.residual.magnitude_g_mm**2 / pull
        if deeper <= 2.0 * float(short.depths_mm.max()):  # farther on the slope tells nothing
            fixes.append(f"about {deeper:.3g} mm more depth where it ends")
    light = math.degrees(short.residual.angle_rad + math.pi) % 360.0
    fixes.append(f"add {short.residual.magnitude_g_mm:.1f} g·mm of metal at {light:.1f}° from throw 1")
    return fixes


def reachable_factor(short: Shortfall) -> float | None:
    """Return the balance factor nearest to the one asked for that the same cuts bring within tolerance."""
    slope = short.per_factor.resultant_g_mm
    size = float(slope @ slope)
    if size == 0.0:
        return None
    exact = short.factor - float(short.residual.resultant_g_mm @ slope) / size
    if not 0.0 <= exact <= 1.0:
        return None
    moved = short.residual + short.per_factor.scaled(exact - short.factor)
    return exact if short.tolerance.used_share(moved) <= 1.0 else None
