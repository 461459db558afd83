"""The density of a material: a number, or the material's name."""

from __future__ import annotations

from typing import Any, Literal

from autobalance.declare import POSITIVE, REQUIRED, Key
from autobalance.materials import MATERIALS

Material: Any = Literal[tuple(MATERIALS)]


def density_keys(of: str, default: Any = REQUIRED) -> tuple[Key, Key]:
    """Return the two keys; their value is the number alone (``typed_units``)."""
    return (
        Key("density_kg_m3", float, f"density of {of}", POSITIVE, default, instead="density"),
        Key(
            "density",
            Material,
            f"material of {of}, in place of the density; `autobalance calc density` lists the sources",
            default=None,
        ),
    )
