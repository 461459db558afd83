"""Tolerances of cuts: how far a depth, an angle or a place may be off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from autobalance.report.balance import kinds
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.rigid_rotor.tolerance import TolerancePlane
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Tolerances of the cuts, from the effect of each error of a cut on the unbalance.
#
# Usual workshop accuracies are scaled by one factor. If all errors of all cuts are at their limits in the
# worst direction, they use at most half of the unused permissible value. That is the sum of their
# magnitudes, in the resultant and in each judged plane. Independent errors use less: the root of the sum of
# their squares.


ERROR_SHARE = 0.5
"""Share of the unused permissible value for the errors of all cuts together."""
USUAL_ACCURACY = {"angle_deg": 0.25, "position_mm": 0.1, "depth_mm": 0.1, "diameter_mm": 0.05}
"""Usual workshop accuracies, without special care (ISO 2768-1, fine); angles by an indexing head."""
MAX_ACCURACY_RATIO = 4.0
"""Largest factor on the usual accuracy."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances ± of every cut of each kind, and the shares that they use.

    ``by_kind`` has a value for each of angle, position, depth and diameter that the kind has; ``factor`` is
    that of the usual accuracy. ``worst`` and ``independent`` are the shares of the unused permissible value
    that all errors use: each at its limit the worst way round, and as the root of the sum of squares.
    """

    by_kind: Mapping[str, Mapping[str, float]]
    factor: float
    worst: float
    independent: float


def tolerances(report: BalancedReport) -> Tolerances | None:
    """Return the tolerances of a report's cuts; None without cuts or without unused permissible value."""
    items: Sequence[Cut] = report.corrections
    left = _left_g_mm(report)
    if not items or min(left.values()) <= 0.0:
        return None
    planes = report.tolerance.planes if len(left) > 1 else ()
    room = np.array([left["resultant"], *(left[plane.name] for plane in planes)])
    each = [(item.kind, name, effect) for item in items for name, effect in _effects(item, planes).items()]
    usual = np.array([effect for _, _, effect in each]) / room
    factor = min(MAX_ACCURACY_RATIO, ERROR_SHARE / max(float(usual.sum(axis=0).max()), 1e-12))
    by_kind: dict[str, dict[str, float]] = {}
    for kind, name, _ in each:
        by_kind.setdefault(kind, {})[name] = _rounded_down(factor * USUAL_ACCURACY[name])
    used = usual * np.array([[by_kind[kind][name] / USUAL_ACCURACY[name]] for kind, name, _ in each])
    return Tolerances(
        by_kind, factor, float(used.sum(axis=0).max()), float(np.sqrt((used**2).sum(axis=0)).max())
    )


@dataclass(frozen=True)
class HeldAccuracy:
    """Effect of usual workshop accuracies: the error of the resultant from independent errors.

    ``left_g_mm`` is the unused permissible value of the resultant, ``share`` the largest share of the unused
    values that the errors use, over resultant and planes; infinite where none is left.
    """

    off_g_mm: float
    left_g_mm: float
    share: float


def held(report: BalancedReport) -> HeldAccuracy | None:
    """Return the effect of usual accuracies; None without cuts."""
    items: Sequence[Cut] = report.corrections
    if not items:
        return None
    left = _left_g_mm(report)
    planes = report.tolerance.planes if len(left) > 1 else ()
    effects = np.array([effect for item in items for effect in _effects(item, planes).values()])
    off = np.sqrt((effects**2).sum(axis=0))
    room = np.array([left["resultant"], *(left[plane.name] for plane in planes)])
    share = float((off / room).max()) if room.min() > 0.0 else math.inf
    return HeldAccuracy(float(off[0]), left["resultant"], share)


def _left_g_mm(report: BalancedReport) -> dict[str, float]:
    """Return the unused part of each permissible value that is judged."""
    permitted: dict[str, float] = {plane.name: plane.permissible_g_mm for plane in report.tolerance.planes}
    permitted["resultant"] = report.tolerance.permissible_g_mm
    return {name: (1.0 - share) * permitted[name] for name, share in report.tolerance.shares(report.residual)}


def _effects(item: Cut, planes: Sequence[TolerancePlane]) -> dict[str, Array]:
    """Return the effect of the usual error of each quantity on the resultant and the planes [g·mm]."""
    change = np.array(item.unbalance_change_g_mm, dtype=np.float64)
    centre_z = _centre_z_mm(item)
    moved, mass = float(np.hypot(*change)), abs(float(item.removed_mass_g))
    shares = {}
    if kinds.angle_deg(item) is not None and item.face is None:
        shares["angle_deg"] = math.radians(USUAL_ACCURACY["angle_deg"]) * _shared(moved, centre_z, planes)
    if item.hole is not None or (item.pocket is not None and item.pocket.cutter_mm is not None):
        shares["position_mm"] = USUAL_ACCURACY["position_mm"] * np.maximum(
            _shared(mass, centre_z, planes), _shifted(moved, planes)
        )
    shares["depth_mm"] = USUAL_ACCURACY["depth_mm"] * _per_depth(item, centre_z, planes)
    diameter = item.diameter_mm
    if diameter is not None:
        shares["diameter_mm"] = USUAL_ACCURACY["diameter_mm"] * _shared(
            2.0 * moved / diameter, centre_z, planes
        )
    return shares


def _centre_z_mm(item: Cut) -> float:
    """Return the z of the metal of a cut: of a hole half-way down."""
    z = float(item.position_mm[2])
    return z if item.hole is None else z + 0.5 * item.depth_mm * item.hole.inward[2]


def _shared(g_mm: float, z_mm: float, planes: Sequence[TolerancePlane]) -> Array:
    """Return the magnitude of an unbalance at one z in the resultant, and its parts in the planes."""
    if not planes:
        return np.array([g_mm])
    low, high = (float(plane.z_mm) for plane in planes)
    upper = (z_mm - low) / (high - low)
    shares: Array = np.abs(np.array([g_mm, g_mm * (1.0 - upper), g_mm * upper]))
    return shares


def _shifted(g_mm: float, planes: Sequence[TolerancePlane]) -> Array:
    """Return the effect of a millimetre along the axis: none on the resultant, a couple in the planes."""
    if not planes:
        return np.zeros(1)
    low, high = (float(plane.z_mm) for plane in planes)
    couple = g_mm / abs(high - low)
    return np.array([0.0, couple, couple])


def _per_depth(item: Cut, z_mm: float, planes: Sequence[TolerancePlane]) -> Array:
    """Return the effect of a millimetre of depth, from the rates of the report, else on average."""
    rate, moment = item.unbalance_per_mm_g_mm, item.moment_per_mm_g_mm2
    if rate is None or moment is None:
        change = float(np.hypot(*item.unbalance_change_g_mm))
        return _shared(change / max(abs(float(item.depth_mm)), 1e-9), z_mm, planes)
    first, second = np.array(rate, dtype=np.float64), np.array(moment, dtype=np.float64)
    if not planes:
        return np.array([np.hypot(*first)])
    low, high = (float(plane.z_mm) for plane in planes)
    upper = (second - low * first) / (high - low)
    magnitudes: Array = np.array([np.hypot(*first), np.hypot(*(first - upper)), np.hypot(*upper)])
    return magnitudes


def _rounded_down(value: float) -> float:
    """Return a value rounded down to two significant digits."""
    if value <= 0.0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / step + 1e-9) * step


# --- slugs -------------------------------------------------------------------------------------------------

FITS = (
    (3.0, 10, 14, 20), (6.0, 12, 19, 27), (10.0, 15, 23, 32), (18.0, 18, 28, 39),
    (30.0, 21, 35, 48), (50.0, 25, 43, 59), (80.0, 30, 53, 72), (120.0, 35, 71, 93),
)  # fmt: skip
"""ISO 286-2: up to a diameter [mm], the bore's H7 (0 to) and the slug's s6 (from, to) [µm]."""


@dataclass(frozen=True)
class PressFit:
    """A press fit: its name, limits of bore and slug [mm]."""

    name: str
    bore_mm: tuple[float, float]
    slug_mm: tuple[float, float]


def press_fit(diameter_mm: float) -> PressFit:
    """Return the medium press fit H7/s6 of a diameter.

    References
    ----------
    ISO 286-2:2010, tables 2 and 19 (80 to 120 mm: the lesser of its two steps).

    Examples
    --------
    >>> fit = press_fit(20.0)
    >>> [round(value, 3) for value in (*fit.bore_mm, *fit.slug_mm)]
    [20.0, 20.021, 20.035, 20.048]
    """
    row = next((row for row in FITS if diameter_mm <= row[0]), FITS[-1])
    bore, low, high = (value / 1000.0 for value in row[1:])
    return PressFit("H7/s6", (diameter_mm, diameter_mm + bore), (diameter_mm + low, diameter_mm + high))


def retention(item: Cut) -> str:
    """Return the retention of a slug: the load that pulls on it, and the means that hold it."""
    load = None if item.slug is None else item.slug.centrifugal_load_N
    pulled = "" if load is None else f" {load:.0f} N at service speed;"
    if item.direction == "radial":
        hold = "" if load is None else f" prove to hold {2.0 * load:.0f} N outward,"
        return f"press to the seat;{pulled} it pulls the slug out:{hold} weld or peen the mouth over"
    return f"press to the seat;{pulled} the bore's wall carries it; peen the mouth at three places"


# Tolerances of the cuts: usual workshop accuracies, and what they may cost.


READING_ADVICE_SHARE = 0.5
"""Share of the remaining permissible value above which a reading is advised after machining."""


def held_words(held: HeldAccuracy, u: DisplayUnits) -> str:
    """Return the usual workshop accuracies, and the error of the resultant that they allow."""
    keys = ("position_mm", "depth_mm", "diameter_mm")
    position, depth, diameter = (_usual(USUAL_ACCURACY[key], u) for key in keys)
    words = (
        f"Every cut: angle ±{USUAL_ACCURACY['angle_deg']:g}°, position ±{position}, depth ±{depth}, "
        f"diameter ±{diameter}. At these the crank may end up {u.of_unbalance(held.off_g_mm)} off"
    )
    if held.left_g_mm > 0.0:
        words += f"; {u.of_unbalance(held.left_g_mm)} is available"
    return words + (
        ". Check it on the balancing machine and finish by that reading (recut)."
        if held.share > READING_ADVICE_SHARE
        else "."
    )


def _usual(value_mm: float, u: DisplayUnits) -> str:
    """Return a usual accuracy in one digit: 0.1 mm, 0.004 in."""
    return f"{value_mm / u.mm_per_length:.1g} {u.length}"
