"""A balancing machine's reading, as judged, its uncertainty, and its likely mistakes."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import LAST, NotNegative, derived
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Budget, Places, Share, Unbalance
from autobalance.types import Array
from autobalance.units import G_MM_PER
from autobalance.value_classes import dataclass

# A balancing machine's reading, as judged: rotor frame, parts not fitted included; its uncertainty.


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


# Likely mistakes of a balancing machine's reading, tested one by one against the numbers.
#
# The change of reading since the stage before, C, should be the effect of that stage's cuts, E. Where both
# differ by more than their uncertainty, each usual mistake is undone in both readings and in the new one
# alone, and the rest of the difference shows whether it explains it.


Cause = Literal["mirrored", "opposite", "turned", "exchanged", "scaled", "bob_weights"]

KEYS: dict[Cause, str] = {
    "mirrored": "rotation",
    "opposite": "reads",
    "turned": "zero_deg",
    "exchanged": "at",
    "scaled": "g_mm",
    "bob_weights": "bob_weights_g",
}
FITTED_CAUSES = ("turned", "scaled", "bob_weights")
"""Causes with a number that is fitted: the difference that they leave counts twice."""
MAX_LEFT = 0.25
"""Share of the difference that a suspect leaves at most."""
LEAST_FACTOR = 1.5
SAME_UNIT = 0.1
"""Logarithm of the difference up to which a factor is that of a unit: a reading is some 10 % off at most."""
SHARE_OF_CUTS = 0.1
"""Share by which the effect of the cuts may differ from the model."""
MAX_DIFFERENCE_SIGMAS = 2.0
"""Uncertainties by which change and cuts may differ."""


@dataclass(frozen=True)
class StageSuspect:
    """A likely mistake in a reading, with the difference that it leaves and its description."""

    cause: Cause
    difference_g_mm: Annotated[NotNegative, LAST]
    left_g_mm: Annotated[NotNegative, LAST]
    says: Annotated[str, LAST]

    @derived
    def key(self) -> str:
        """Key of the reading file that the mistake makes wrong."""
        return KEYS[self.cause]

    @property
    def rank(self) -> float:
        """Difference left, doubled where a number was fitted."""
        return self.left_g_mm * (2.0 if self.cause in FITTED_CAUSES else 1.0)


@dataclass(frozen=True, eq=False)
class ReadingComparison:
    """Two readings and the effect of the cuts between them.

    ``before`` is the reading before the cuts, ``expected`` the model's effect of the cuts; ``per_gram`` is
    the unbalance of 1 g more on every throw.
    """

    now: JudgedReading
    before: JudgedReading
    expected: Unbalance
    per_gram: Unbalance
    places: Places

    def seen(self, unbalance: Unbalance) -> Array:
        """Return the vectors to compare: A and B (2, 2), or the resultant (1, 2) of a static reading."""
        if self.places is None or self.now.static or self.before.static:
            return unbalance.resultant_g_mm[None, :]
        return unbalance.in_planes(*self.places)

    @property
    def difference(self) -> Array:
        """Return C − E."""
        return self.seen(self.now.unbalance - self.before.unbalance - self.expected)

    @property
    def agrees(self) -> bool:
        """Whether change and cuts differ by no more than twice their uncertainty."""
        cuts = SHARE_OF_CUTS * np.linalg.norm(self.seen(self.expected), axis=1)
        doubts = [self._doubts(reading) for reading in (self.now, self.before)]
        allowed = MAX_DIFFERENCE_SIGMAS * np.sqrt(doubts[0] ** 2 + doubts[1] ** 2 + cuts**2)
        return bool((np.linalg.norm(self.difference, axis=1) <= allowed).all())

    def _doubts(self, reading: JudgedReading) -> Array:
        if self.places is None or self.now.static or self.before.static:
            return np.array([reading.share.resultant_g_mm])
        return np.array(reading.share.planes_g_mm)


def suspects(compared: ReadingComparison) -> list[StageSuspect]:
    """Return the mistakes that explain the difference, best first; none where the readings agree."""
    if compared.agrees:
        return []
    difference = float(np.linalg.norm(compared.difference))
    suspect_of: dict[Cause, StageSuspect] = {}
    for cause, left, says in _tried(compared):
        if left <= MAX_LEFT * difference and (cause not in suspect_of or left < suspect_of[cause].left_g_mm):
            suspect_of[cause] = StageSuspect(cause, difference, left, says)
    return sorted(suspect_of.values(), key=lambda each: each.rank)


def _tried(compared: ReadingComparison) -> Iterator[tuple[Cause, float, str]]:
    """Yield causes, the difference left by each and words: undone in both readings, or in the new one."""
    for both in (True, False):
        yield "mirrored", _left(compared, both, _mirrored), "angles count the other way"
        yield "opposite", _left(compared, both, _opposite), "light and heavy side are exchanged"
        if not (compared.now.static or compared.before.static):
            yield "exchanged", _left(compared, both, _exchanged), "planes A and B are exchanged"
        yield from _turned(compared, both)
        yield from _scaled(compared, both)
    yield from _bob_weights(compared)


Undone = Callable[[JudgedReading], list[PlaneReading]]


def _mirrored(reading: JudgedReading) -> list[PlaneReading]:
    """Return the readings with their angles counted the other way from the machine's zero mark."""
    about = cmath.exp(2j * reading.zero_rad)
    return [PlaneReading(each.z_mm, about * each.unbalance_g_mm.conjugate()) for each in reading.planes]


def _opposite(reading: JudgedReading) -> list[PlaneReading]:
    return [PlaneReading(each.z_mm, -each.unbalance_g_mm) for each in reading.planes]


def _exchanged(reading: JudgedReading) -> list[PlaneReading]:
    one, other = reading.planes
    return [PlaneReading(one.z_mm, other.unbalance_g_mm), PlaneReading(other.z_mm, one.unbalance_g_mm)]


def _machine(planes: Sequence[PlaneReading]) -> Unbalance:
    """Return the machine's unbalance from its planes; a static reading has no moment here."""
    total = sum((each.unbalance_g_mm for each in planes), 0j)
    moment = sum(((each.z_mm or 0.0) * each.unbalance_g_mm for each in planes), 0j)
    return Unbalance(vector(total), vector(moment))


def _left(compared: ReadingComparison, both: bool, undo: Undone) -> float:
    now = _machine(undo(compared.now)) + compared.now.off
    before = compared.before.unbalance
    if both:
        before = _machine(undo(compared.before)) + compared.before.off
    return float(np.linalg.norm(compared.seen(now - before - compared.expected)))


def _fit(compared: ReadingComparison, both: bool) -> tuple[Array, Array]:
    """Return X and Y, complex (k,): with a factor on the machine's values, C − E is factor·X − Y."""
    read = _machine(compared.now.planes)
    rest = compared.expected - compared.now.off
    if both:
        read = read - _machine(compared.before.planes)
        rest = rest + compared.before.off
    else:
        rest = rest + compared.before.unbalance
    x, y = compared.seen(read), compared.seen(rest)
    return x[:, 0] + 1j * x[:, 1], y[:, 0] + 1j * y[:, 1]


def _turned(compared: ReadingComparison, both: bool) -> Iterator[tuple[Cause, float, str]]:
    x, y = _fit(compared, both)
    angle = cmath.phase(complex(np.vdot(x, y)))
    left = float(np.linalg.norm(cmath.exp(1j * angle) * x - y))
    yield "turned", left, f"all angles are turned by {math.degrees(angle):.1f}°"


def _scaled(compared: ReadingComparison, both: bool) -> Iterator[tuple[Cause, float, str]]:
    x, y = _fit(compared, both)
    square = float(np.vdot(x, x).real)
    factor = float(np.vdot(x, y).real) / square if square > 0.0 else 0.0
    if factor > LEAST_FACTOR or 0.0 < factor < 1.0 / LEAST_FACTOR:
        left = float(np.linalg.norm(factor * x - y))
        yield (
            "scaled",
            left,
            f"all amounts are {1.0 / factor:.4g} times what they should be{_unit_of(factor)}",
        )


def _unit_of(factor: float) -> str:
    """Return the mistake of units that makes amounts wrong by a factor; empty if none does.

    Examples
    --------
    >>> _unit_of(25.4), _unit_of(1.0 / 720.1)
    (', as if g·in were entered as g·mm', ', as if g·mm were entered as oz·in')
    """
    for unit, g_mm in G_MM_PER.items():
        if g_mm > LEAST_FACTOR and abs(math.log(factor / g_mm)) < SAME_UNIT:
            return f", as if {unit} were entered as g·mm"
        if g_mm > LEAST_FACTOR and abs(math.log(factor * g_mm)) < SAME_UNIT:
            return f", as if g·mm were entered as {unit}"
    return (
        f", as if grams at a radius of {factor:.3g} mm were entered as g·mm" if factor > LEAST_FACTOR else ""
    )


def _bob_weights(compared: ReadingComparison) -> Iterator[tuple[Cause, float, str]]:
    fitted = bob_weight_fit(compared.difference, compared.seen(compared.per_gram))
    if fitted is not None:
        grams, left = fitted
        yield "bob_weights", left, f"each bob-weight fitted is {grams:+.2f} g off its value in the job"


def bob_weight_fit(difference: Array, per_gram: Array) -> tuple[float, float] | None:
    """Return the error of all bob-weights [g] that explains a difference best, and the difference left.

    None if equal bob-weights change nothing.
    """
    square = float((per_gram**2).sum())
    if square <= 1e-12:
        return None
    grams = float((per_gram * difference).sum()) / square
    return grams, float(np.linalg.norm(difference - grams * per_gram))
