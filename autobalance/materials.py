"""Densities of what crankshafts, their parts and their slugs are made of, each with its source."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Final

from autobalance.units import STEEL_KG_M3
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class Material:
    """A material's density.

    Attributes
    ----------
    material : str
    density_kg_m3 : float
        Usual value [kg/m³]; weigh the part where it matters.
    source : str
        Where that is from.
    """

    material: str
    density_kg_m3: float
    source: str


MATERIALS: Final[Mapping[str, Material]] = {
    each.material: each
    for each in (
        Material("steel", STEEL_KG_M3, "EN 1991-1-1, Table A.4: 78.5 kN/m³ for carbon and alloy steels"),
        Material("cast iron", 7200.0, "EN 1561, annex A: grey iron EN-GJL-250"),
        Material("ductile iron", 7100.0, "EN 1563, annex A: nodular iron EN-GJS-400 to -600"),
        Material("aluminium", 2700.0, "EN 1991-1-1, Table A.4: 27.0 kN/m³; piston alloys are near it"),
        Material("titanium", 4430.0, "ASM Handbook, vol. 2: Ti-6Al-4V"),
        Material("magnesium", 1810.0, "ASM Handbook, vol. 2: AZ91"),
        Material("brass", 8500.0, "EN 1991-1-1, Table A.4: 83.0 to 85.0 kN/m³"),
        Material("copper", 8900.0, "EN 1991-1-1, Table A.4: 87.0 to 89.0 kN/m³"),
        Material("lead", 11340.0, "CRC Handbook of Chemistry and Physics"),
        Material("tungsten alloy", 17000.0, "ASTM B777, class 1: 90 % tungsten, 16 850 to 17 250"),
    )
}
"""Materials by name, as a job's ``density`` takes them."""


def density(material: str = "all") -> Material | tuple[Material, ...]:
    """Return the usual density of a material, or of all of them, and where each is from.

    Parameters
    ----------
    material : str
        all, steel, cast iron, ductile iron, aluminium, titanium, magnesium, brass, copper, lead or
        tungsten alloy.

    Raises
    ------
    ValueError
        If it is not in the table.

    References
    ----------
    Each row names its own.

    Examples
    --------
    >>> density("cast iron").density_kg_m3, len(density())
    (7200.0, 10)
    """
    if material == "all":
        return tuple(MATERIALS.values())
    if material not in MATERIALS:
        close = get_close_matches(material, MATERIALS, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else f"; there are {', '.join(MATERIALS)}"
        raise ValueError(f"found material {material!r}{hint}")
    return MATERIALS[material]
