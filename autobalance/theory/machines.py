"""Accuracy of a balancing machine from its readings: tooling by an index test, scatter by repetition."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

CONFIDENCE = 0.95
"""Two-sided, of Student's t for the scatter of a few readings; many make it 1.96."""


@dataclass(frozen=True)
class IndexTest:
    """Unbalance of crank and tooling in one plane, and the scatter that readings beyond two leave."""

    crank_g_mm: float
    crank_deg: float
    tooling_g_mm: float
    tooling_deg: float
    scatter_g_mm: float | None


@dataclass(frozen=True)
class Repeated:
    """Mean of repeated readings of one plane, their scatter, and the least residual that can be shown."""

    mean_g_mm: float
    mean_deg: float
    scatter_g_mm: float
    umar_g_mm: float


@dataclass(frozen=True)
class MachineAccuracy:
    """Smallest residual of a machine, and the unbalances of crank and tooling."""

    umar_g_mm: float
    crank_g_mm: float
    crank_deg: float
    tooling_g_mm: float
    tooling_deg: float


def machine_accuracy(
    readings_g_mm: Sequence[float],
    readings_deg: Sequence[float],
    turned_deg: Sequence[float],
    index_g_mm: Sequence[float],
    index_deg: Sequence[float],
) -> MachineAccuracy:
    """Return a machine's smallest residual and its tooling's unbalance, by repetition and an index test.

    The smallest residual is a reading's standard deviation times Student's t. The unbalance reduction ratio
    is not in these readings: it shows when a known weight is read and corrected.

    Parameters
    ----------
    readings_g_mm, readings_deg : sequence of float
        Repeated readings, the rotor taken off between them [g·mm, deg].
    turned_deg : sequence of float
        How far the crank was turned on its tooling, for each reading of the index test [deg].
    index_g_mm, index_deg : sequence of float
        The readings of the index test [g·mm, deg].

    Raises
    ------
    ValueError
        If the readings are too few, or the crank's unbalance is no more than the least residual.

    References
    ----------
    ISO 21940-21:2012: Umar, URR; ISO 21940-14:2012: index test.

    Examples
    --------
    >>> turned = [0.0, 180.0]
    >>> found = machine_accuracy([40.0, 41.0, 42.0], [0.0, 0.0, 0.0], turned, [40.0, 20.0], [0.0, 180.0])
    >>> round(found.umar_g_mm, 3), round(found.crank_g_mm, 1), round(found.tooling_g_mm, 1)
    (1.963, 30.0, 10.0)
    """
    least = repeated_readings(readings_g_mm, readings_deg).umar_g_mm
    index = index_test(turned_deg, index_g_mm, index_deg)
    if index.crank_g_mm <= least:
        raise ValueError(
            f"the crank's own unbalance of {index.crank_g_mm:.3g} g·mm is within the scatter of {least:.3g} "
            "g·mm; put a known weight on it"
        )
    return MachineAccuracy(
        least,
        index.crank_g_mm,
        index.crank_deg,
        index.tooling_g_mm,
        index.tooling_deg,
    )


def index_test(
    turned_deg: Sequence[float], readings_g_mm: Sequence[float], readings_deg: Sequence[float]
) -> IndexTest:
    """Separate the unbalance of a crank from that of its tooling, by readings with the crank turned on it.

    In the tooling's frame a reading is T + C e^(iθ), the crank turned by θ. Two readings at 0° and 180° give
    both exactly, T = (R₁ + R₂)/2 and C = (R₁ − R₂)/2. More readings give them by least squares.

    Parameters
    ----------
    turned_deg : sequence of float
        How far the crank was turned on its tooling for each reading [deg].
    readings_g_mm, readings_deg : sequence of float
        What was read, counted from a mark on the tooling [g·mm, deg].

    Raises
    ------
    ValueError
        If there are fewer than two readings, or the crank was never turned.

    References
    ----------
    ISO 21940-14:2012, 180° index.

    Examples
    --------
    >>> found = index_test(turned_deg=[0.0, 180.0], readings_g_mm=[30.0, 10.0], readings_deg=[0.0, 180.0])
    >>> round(found.crank_g_mm, 6), round(found.tooling_g_mm, 6)
    (20.0, 10.0)
    """
    read = _vectors(readings_g_mm, readings_deg)
    turned = np.exp(1j * np.radians(np.asarray(turned_deg, dtype=np.float64)))
    if len(read) != len(turned) or len(read) < 2:
        raise ValueError(f"{len(turned)} angles and {len(read)} readings; expected two or more of each")
    table = np.stack([turned, np.ones(len(turned))], axis=1)
    if np.linalg.cond(table) > 1e6:
        raise ValueError("the crank was not turned on its tooling; turn it by 180° for the second reading")
    solution, *_ = np.linalg.lstsq(table, read)
    crank, tooling = complex(solution[0]), complex(solution[1])
    spare = 2 * (len(read) - 2)
    off = read - table @ np.array([crank, tooling])
    scatter = math.sqrt(float((np.abs(off) ** 2).sum()) / spare) if spare else None
    return IndexTest(abs(crank), _degrees(crank), abs(tooling), _degrees(tooling), scatter)


def repeated_readings(readings_g_mm: Sequence[float], readings_deg: Sequence[float]) -> Repeated:
    """Return the mean of repeated readings, their scatter, and the least residual that they can show.

    The scatter is the standard deviation of x and of y of one reading, both together. The smallest residual
    is the scatter times Student's t of 95 %: 2.78 for three readings, which have four degrees of freedom.

    Parameters
    ----------
    readings_g_mm, readings_deg : sequence of float
        Two or more readings of one plane, the rotor taken off and put on again between them [g·mm, deg].

    Raises
    ------
    ValueError
        If there are fewer than two.

    References
    ----------
    ISO 21940-21:2012, minimum achievable residual unbalance.

    Examples
    --------
    >>> round(repeated_readings(readings_g_mm=[10.0, 11.0, 12.0], readings_deg=[0.0, 0.0, 0.0]).umar_g_mm, 3)
    1.963
    """
    from scipy.special import stdtrit

    read = _vectors(readings_g_mm, readings_deg)
    if len(read) < 2:
        raise ValueError(f"{len(read)} reading; expected two or more")
    mean = complex(read.mean())
    freedom = 2 * (len(read) - 1)
    scatter = math.sqrt(float((np.abs(read - mean) ** 2).sum()) / freedom)
    times = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))
    return Repeated(abs(mean), _degrees(mean), scatter, times * scatter)


def _vectors(sizes_g_mm: Sequence[float], angles_deg: Sequence[float]) -> NDArray[np.complex128]:
    sizes = np.asarray(sizes_g_mm, dtype=np.float64)
    angles = np.radians(np.asarray(angles_deg, dtype=np.float64))
    if sizes.shape != angles.shape:
        raise ValueError(f"{len(sizes)} sizes and {len(angles)} angles; expected as many")
    return np.asarray(sizes * np.exp(1j * angles), dtype=np.complex128)


def _degrees(value: complex) -> float:
    return wrapped_deg(math.degrees(math.atan2(value.imag, value.real)))
