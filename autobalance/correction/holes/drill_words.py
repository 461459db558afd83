"""Names of drills, and reasons why those that a job names are not used."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from autobalance.correction.contract import Item
from autobalance.correction.holes.drill_limits import DrillLimits
from autobalance.correction.holes.zones import Zone
from autobalance.crank.anatomy import Anatomy


def called(item: Item) -> str | None:
    """Return the shop's name of the drill of a listed correction; None: it has no name."""
    return item.get("drill")


def no_place(limits: DrillLimits, radii_mm: Sequence[float]) -> tuple[str, ...]:
    """Return a note on each named drill that fits no place."""
    return tuple(
        f"the drill of {diameter:g} mm is not used: no hole of it fits with min_wall_mm = "
        f"{limits.min_wall_mm:g}, min_depth_mm = {limits.min_depth_mm:g}, zone = {limits.zone} and "
        f"max_obliquity_deg = {limits.max_obliquity_deg:g}"
        for diameter in sorted(set(limits.diameters_mm or ()))
        if 0.5 * diameter not in radii_mm
    )


PLACES: Mapping[Zone, str] = {
    "counterweights": "any counterweight",
    "web": "any web's half away from the crankpin",
    "anywhere": "any web",
}


def lacks_counterweights(anatomy: Anatomy) -> bool:
    """Return whether a crank has webs, and none of them a counterweight."""
    return bool(anatomy.webs) and not any(web.counterweight for web in anatomy.webs)


def why_none(limits: DrillLimits, diameters_mm: Sequence[float], seen: bool, anatomy: Anatomy) -> str:
    """Return the reason why no hole fits anywhere, and a remedy."""
    if limits.positions is not None:
        sizes = (
            f"{min(diameters_mm):g} to {max(diameters_mm):g}"
            if len(diameters_mm) > 1
            else f"{diameters_mm[0]:g}"
        )
        return (
            f"drill.positions: no hole of {sizes} mm fits at any of them with min_wall_mm = "
            f"{limits.min_wall_mm:g}, min_depth_mm = {limits.min_depth_mm:g} and max_obliquity_deg = "
            f"{limits.max_obliquity_deg:g}; choose a smaller drill or wall, or other positions"
        )
    zoned = limits.zone != "anywhere"
    if limits.zone == "counterweights" and not any(web.counterweight for web in anatomy.webs):
        return 'drill.zone = "counterweights": no web has a counterweight; zone = "anywhere" takes any web'
    wider = '; zone = "anywhere" takes more of the webs' if zoned else ""
    if not seen:
        sectors = ", ".join(f"[{start:g}, {end:g}]" for start, end in limits.sectors_deg)
        return (
            f"drill.sectors_deg = {sectors}: no web has a surface there that a drill can start on within "
            f"max_obliquity_deg = {limits.max_obliquity_deg:g}{wider}"
        )
    kept = f"min_wall_mm = {limits.min_wall_mm:g} and min_depth_mm = {limits.min_depth_mm:g}"
    where = PLACES[limits.zone]
    if limits.diameters_mm is None:
        thinnest = limits.at_hand_mm[0]
        return (
            f"no drill of the series fits into {where} with {kept}: the thinnest is of {thinnest:g} mm; "
            f"choose a smaller wall or depth{wider}"
        )
    sizes = ", ".join(f"{diameter:g}" for diameter in diameters_mm)
    return (
        f"no hole of {sizes} mm fits into {where} with {kept}; choose a smaller drill, wall or depth{wider}"
    )
