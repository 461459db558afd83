"""A crank's solid as the bytes of a file of any format that can hold it."""

from __future__ import annotations

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.read import Source
from autobalance.solid.formats.registry import format_named, name_of_ending
from autobalance.solid.formats.write import encode
from autobalance.units import MM_PER


def encoded(source: Source, ending: str, unit: str | None = None) -> bytes:
    """Return a solid as the bytes of a file.

    Parameters
    ----------
    source : Source
    ending : str
        Of the file, ``.3mf`` say.
    unit : str or None
        mm, cm, m or inch; None: that of the source, or what the format prescribes.

    Raises
    ------
    FormatError If the format or the unit is unknown, or the format keeps true surfaces and the source has
    triangles.
    """
    name = name_of_ending(ending.lower().lstrip("."))
    kind = format_named(name)
    if unit is not None and unit not in MM_PER:
        raise FormatError(f"the unit '{unit}' is not known; expected one of {', '.join(MM_PER)}")
    if kind.exact:
        if source.exact is None:
            raise FormatError(f"a mesh cannot be saved as {ending}; choose .stl, .obj, .ply or .3mf")
        return source.exact.solid.step(unit or source.exact.unit, source.exact.name)
    return encode(source.solid.mesh, name, _mm_per_unit(kind, unit, source.mm_per_unit))


def _mm_per_unit(kind: Format, unit: str | None, own: float) -> float:
    if kind.mm_per_unit is not None:
        if unit is not None and MM_PER[unit] != kind.mm_per_unit:
            its = next(name for name, mm in MM_PER.items() if mm == kind.mm_per_unit)
            raise FormatError(f"{kind.name.upper()} is in {its}, the unit given is {unit}; leave it out")
        return kind.mm_per_unit
    return own if unit is None else MM_PER[unit]
