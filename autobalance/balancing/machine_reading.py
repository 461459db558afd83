"""A balancing machine's reading, as judged: rotor frame, parts not fitted included; its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget, Places, Share

CAUSE = "reading"
"""Name of the only cause of a reading's uncertainty."""


@dataclass(frozen=True)
class PlaneReading:
    """Unbalance read in a plane, in the rotor frame (x + i y); ``z_mm`` None: a static reading."""

    z_mm: float | None
    unbalance_g_mm: complex


@dataclass(frozen=True)
class MachineAccuracy:
    """Unbalance reduction ratio (a share) and minimum achievable residual unbalance, as in ISO 21940-21."""

    urr: float
    umar_g_mm: float

    def uncertainty_g_mm(self, read_g_mm: float) -> float:
        """Return √(umar² + ((1 − urr) |reading|)²)."""
        return math.hypot(self.umar_g_mm, (1.0 - self.urr) * read_g_mm)


@dataclass(frozen=True, eq=False)
class JudgedReading:
    """A reading as judged.

    ``unbalance`` counts the parts that the job attaches to the rotor, not those that were on it. ``off`` is
    the difference, ``machine`` the machine's own unbalance, ``share`` its uncertainty in U, A and B.
    ``zero_rad`` is the rotor angle of the machine's zero mark.
    """

    unbalance: Unbalance
    machine: Unbalance
    off: Unbalance
    share: Share
    planes: tuple[PlaneReading, ...]
    zero_rad: float = 0.0

    @property
    def static(self) -> bool:
        """Whether one plane was read."""
        return len(self.planes) == 1

    def budget(self, places: Places) -> Budget:
        return Budget({CAUSE: self.share}, places)


def vector(value: complex) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return x + i y as (2,)."""
    return np.array([value.real, value.imag])


def judged_reading(
    planes: Sequence[PlaneReading],
    accuracy: MachineAccuracy,
    off: Unbalance,
    model: Unbalance,
    places: Places,
    zero_rad: float = 0.0,
) -> JudgedReading:
    """Return a reading as judged.

    Two planes give U and P. One plane gives U; P is that of the model. The planes' readings are independent,
    and their uncertainties are carried by the levers to U and to the tolerance planes.

    Parameters
    ----------
    planes : one or two of PlaneReading
    accuracy : MachineAccuracy
    off : Unbalance
        The job's parts on the rotor less those that were on it.
    model : Unbalance
        The model's at the same stage, as judged.
    places : (float, float) or None
        Tolerance planes A and B [mm].
    """
    doubts = [accuracy.uncertainty_g_mm(abs(each.unbalance_g_mm)) for each in planes]
    resultant = vector(sum((each.unbalance_g_mm for each in planes), 0j))
    if len(planes) == 1:
        moment = model.moment_g_mm2 - off.moment_g_mm2
    else:
        moment = sum((_place(each) * vector(each.unbalance_g_mm) for each in planes), np.zeros(2))
    machine = Unbalance(resultant, moment)
    share = Share(math.hypot(*doubts), () if places is None else _in_planes(planes, doubts, places))
    return JudgedReading(machine + off, machine, off, share, tuple(planes), zero_rad)


def _place(plane: PlaneReading) -> float:
    assert plane.z_mm is not None
    return plane.z_mm


def _in_planes(
    planes: Sequence[PlaneReading], doubts: Sequence[float], places: tuple[float, float]
) -> tuple[float, float]:
    """Return the uncertainties in A and B by U_A = (z_B U − P)/(z_B − z_A), each reading's by its lever."""
    z_A, z_B = places
    span = z_B - z_A
    # A static reading has no part in P.
    at = [0.0] if len(planes) == 1 else [_place(each) for each in planes]
    in_A = math.hypot(*((z_B - z) / span * u for z, u in zip(at, doubts, strict=True)))
    in_B = math.hypot(*((z - z_A) / span * u for z, u in zip(at, doubts, strict=True)))
    return in_A, in_B


def needs_no_cut(reading: JudgedReading, tolerance: Tolerance) -> bool:
    """Return whether a reading is within tolerance less its uncertainty, in everything that is judged."""
    doubts = (reading.share.resultant_g_mm, *reading.share.planes_g_mm)
    rows = tolerance.judged(reading.unbalance)
    return all(row.residual_g_mm <= row.permissible_g_mm - u for row, u in zip(rows, doubts, strict=False))


def machine_cannot_show(accuracy: MachineAccuracy, tolerance: Tolerance) -> str | None:
    """Return the reason why a machine cannot show that a rotor is within tolerance; None where it can."""
    judged = (
        [(f"plane {plane.name}", plane.permissible_g_mm) for plane in tolerance.planes]
        if tolerance.judge == "dynamic"
        else [("the resultant", tolerance.permissible_g_mm)]
    )
    for name, permissible in judged:
        if accuracy.umar_g_mm >= permissible:
            return (
                f"this machine cannot show it: its umar_g_mm of {accuracy.umar_g_mm:.4g} g·mm is not "
                "below the "
                f"permissible {permissible:.4g} g·mm of {name}; choose a finer machine"
            )
    return None
