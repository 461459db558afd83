"""Calibration: a factor, or a sensor's sensitivity as on its data sheet."""

from __future__ import annotations

import math
import re

from autobalance.errors import FormatError
from autobalance.signals.header import spelled

SENSITIVITY = re.compile(r"^\s*([-+.\deE]+)\s*(mV|V)\s*/\s*\(?\s*([^()]+?)\s*\)?\s*$")
VOLTS = {"mV": 1e-3, "V": 1.0}


def calibration_factor(name: str, value: float | str, unit: str | None) -> tuple[float, str | None]:
    """Return a channel's calibration factor and its new unit, None where the unit stays.

    Examples
    --------
    >>> calibration_factor("accel", "100 mV/g", "V"), calibration_factor("accel", "2.5", None)
    ((10.0, 'g'), (2.5, None))
    """
    if isinstance(value, str):
        match = SENSITIVITY.match(value)
        if match:
            size = _number(name, match[1]) * VOLTS[match[2]]
            volts = VOLTS.get(spelled(unit) or "V", 1.0)
            return volts / size, match[3]
    return _number(name, value), None


def _number(name: str, factor: float | str) -> float:
    try:
        value = float(factor)
    except ValueError:
        raise FormatError(
            f"calibration of {name!r} is {factor!r}; must be a factor, or a sensitivity as in 100mV/g"
        ) from None
    if not math.isfinite(value) or value == 0.0:
        raise FormatError(f"calibration of {name!r} is {factor}; must be a number other than 0")
    return value
