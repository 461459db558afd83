"""A column's header: the channel's name and its unit."""

from __future__ import annotations

import re

UNITS = {
    **dict.fromkeys(("g", "gn", "G"), "g"),
    **dict.fromkeys(("m/s2", "m/s²", "m/s^2", "m/s**2", "m_s2", "ms2", "ms-2"), "m/s²"),
    **dict.fromkeys(("mm/s2", "mm/s²", "mm/s^2", "mm_s2"), "mm/s²"),
    **dict.fromkeys(("mm/s", "mm_s"), "mm/s"),
    **dict.fromkeys(("m/s", "m_s"), "m/s"),
    **dict.fromkeys(("um", "µm", "μm", "micron"), "µm"),
    **{
        text: text
        for text in ("mm", "m", "V", "mV", "A", "mA", "Pa", "kPa", "bar", "N", "kN", "Nm", "s", "ms")
    },
    **{
        text: text
        for text in ("us", "Hz", "rpm", "deg", "rad", "C", "K", "N_m", "rad_s", "rad/s", "lbf", "ips")
    },
    "volt": "V",
    "volts": "V",
    "in/s": "in/s",
}
"""Units in the spellings after the last ``_`` → one spelling."""

BRACKETS = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]$")


def named(header: str) -> tuple[str, str | None]:
    """Return a channel's name and its unit, None without one.

    Examples
    --------
    >>> named("accel_g"), named("accel [m/s2]"), named("gearbox_accel_m_s2"), named("accel_x")
    (('accel', 'g'), ('accel', 'm/s2'), ('gearbox_accel', 'm/s2'), ('accel_x', None))
    """
    text = header.strip().strip('"').strip()
    bracketed = BRACKETS.match(text)
    if bracketed and bracketed[1]:
        return bracketed[1].strip(), bracketed[2] or None
    pieces = text.split("_")
    for count in (2, 1):
        unit = "_".join(pieces[-count:])
        if len(pieces) > count and unit in UNITS:
            return "_".join(pieces[:-count]), unit.replace("_", "/") if count == 2 and "s" in unit else unit
    return text, None


def spelled(unit: str | None) -> str | None:
    """Return the standard spelling of a unit; an unknown unit is unchanged."""
    return None if unit is None else UNITS.get(unit, unit)
