"""Sizes of a drawn crank that would give it a wanted factor or inertia: closed forms, built and measured."""

from __future__ import annotations

import math
from operator import attrgetter

import numpy as np
from scipy.optimize import least_squares

from autobalance.balancing.suggestions.wanted import Aim, Refused, SuggestedChange, Suggestion
from autobalance.crank.anatomy import Anatomy
from autobalance.drawn_cranks.design import Design
from autobalance.drawn_cranks.generate import exact_moments
from autobalance.drawn_cranks.input import with_settings
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import AutobalanceError, JobError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

SEGMENTS = 32
"""Fineness of trials; the moments are extrapolated from it, and compared with the crank's at the same."""
MOST_TRIALS = 5
DIGITS = 3
MAX_RESIDUAL_SHARE = 1e-6
"""Share of the missing product or inertia that a closed form may leave."""
RADIUS, THICKNESS, FAN = (f"counterweight.{key}" for key in ("radius_mm", "thickness_mm", "fan_angle_deg"))
BORE, FLANGE = "crankpin.bore_mm", "flange.diameter_mm"
NAMES = {
    RADIUS: "counterweight radius",
    THICKNESS: "counterweight thickness",
    FAN: "counterweight fan angle",
    BORE: "crankpin bore",
    FLANGE: "flange diameter",
}


def suggested_sizes(design: Design, aim: Aim) -> tuple[list[Suggestion], list[Refused]]:
    """Return the changes of one or two sizes that reach an aim, and those that do not.

    Parameters
    ----------
    design : Design
        The crank as drawn.
    aim : Aim
        With the drawn crank's own moments as its start.
    """
    here = _measured(design)
    suggestions: list[Suggestion] = []
    refused: list[Refused] = []
    for keys in _sets(design, aim):
        kind = "_and_".join(NAMES[key].replace(" ", "_") for key in keys)
        try:
            suggestions.append(_tried(design, aim, keys, kind, here))
        except AutobalanceError as error:
            refused.append(Refused(kind, str(error)))
    return suggestions, refused


def _sets(design: Design, aim: Aim) -> list[tuple[str, ...]]:
    """Return the sizes to change together: one for one wish, two where factor and inertia both count."""
    weights = () if design.counterweight is None else (RADIUS, THICKNESS, FAN)
    bore = (BORE,) if design.crankpin_in_file else ()
    flange = (FLANGE,) if design.flange is not None and aim.wanted.inertia_g_mm2 is not None else ()
    if aim.wanted.inertia_g_mm2 is None:
        return [(key,) for key in (*weights, *bore)]
    if aim.direction is None:
        return [(key,) for key in (*weights, *bore, *flange)]
    alone = [(key,) for key in flange] if aim.wanted.balance_factor is None else []
    pairs = [(RADIUS, FAN), (RADIUS, THICKNESS), (THICKNESS, FAN)] if weights else []
    return [
        *alone,
        *pairs,
        *[(weights[0], key) for key in (*bore, *flange[: len(flange) - len(alone)]) if weights],
    ]


def _measured(design: Design) -> Moments:
    return exact_moments(design, SEGMENTS).moved(crank_anatomy(design).file_to_rotor)


def _tried(design: Design, aim: Aim, keys: tuple[str, ...], kind: str, here: Moments) -> Suggestion:
    """Solve the closed form, build the crank, measure it, and correct the sizes by its shortfall."""
    before = [size_of(design, key) for key in keys]
    levers = _Levers(design, aim, keys)
    carried, first = np.zeros(2), None
    moments, values = here, tuple(before)
    for _ in range(MOST_TRIALS):
        missing = aim.missing(aim.start + (moments - here))
        carried = carried + np.array([missing.product_g_mm, missing.inertia_g_mm2 or 0.0])
        values = levers.solved(carried, aim.wanted.inertia_g_mm2 is not None)
        first = first or values
        moments = _measured(with_settings(design, dict(zip(keys, values, strict=True))))
        if aim.reached(aim.start + (moments - here), 1.0):
            break
    assert first is not None
    changes = tuple(
        SuggestedChange(key, old, closed, new)
        for key, old, closed, new in zip(keys, before, first, values, strict=True)
    )
    text = ", ".join(
        f"{NAMES[each.key]} {each.after:.3f} {_unit(each.key)} instead of {each.before:.3f}"
        for each in changes
    )
    return Suggestion(kind, text, aim.start + (moments - here), changes=changes)


def _unit(key: str) -> str:
    return "°" if key.endswith("_deg") else "mm"


def size_of(design: Design, key: str) -> float:
    """Return a size of a design by its dotted key, ``counterweight.radius_mm``."""
    value = attrgetter(key)(design)
    is_of_web = key == THICKNESS and value is None  # a counterweight as thick as its web
    return float(design.web.thickness_mm if is_of_web else value)


@dataclass(frozen=True, eq=False)
class _Levers:
    """Some sizes of a design and the closed form of their effect on product and inertia."""

    design: Design
    aim: Aim
    keys: tuple[str, ...]

    def solved(self, change: Array, with_inertia: bool) -> tuple[float, ...]:
        """Return the sizes, rounded, that change product and inertia by ``change`` (2,).

        Raises
        ------
        JobError
            If they cannot within their bounds.
        """
        start = np.array([size_of(self.design, key) for key in self.keys])
        low, high = np.array([self._bounds(key) for key in self.keys]).T
        base = self._closed(start)
        rows = [0, 1] if with_inertia and len(self.keys) == 2 else [1 if with_inertia else 0]
        scale = np.maximum(np.abs(base), np.abs(change))[rows] + 1e-9

        def left(x: Array) -> Array:
            residuals: Array = (self._closed(x)[rows] - base[rows] - change[rows]) / scale
            return residuals

        inside = np.clip(start, low + 1e-6 * (high - low), high - 1e-6 * (high - low))
        solution = least_squares(
            left, inside, bounds=(low, high), x_scale=high - low, xtol=1e-15, ftol=1e-15, gtol=1e-15
        )
        if float(np.abs(solution.fun).max()) > MAX_RESIDUAL_SHARE:
            raise JobError(self._short(solution.x, rows, base, change))
        return tuple(round(float(each), DIGITS) for each in solution.x)

    def _short(self, values: Array, rows: list[int], base: Array, change: Array) -> str:
        got = self._closed(values) - base
        sizes = " and ".join(
            f"{NAMES[key]} {value:.1f} {_unit(key)}" for key, value in zip(self.keys, values, strict=True)
        )
        words = [
            f"{got[0]:.0f} of {change[0]:.0f} g·mm",
            f"{got[1] / 1e3:.1f} of {change[1] / 1e3:.1f} kg·mm²",
        ]
        return f"{sizes} would give {' and '.join(words[row] for row in rows)}, as near as it comes"

    def _bounds(self, key: str) -> tuple[float, float]:
        crank = self.design
        web = crank.web
        arm = float((web.hub_radius_mm if web.outline == "pear" else web.disc_radius_mm) or 0.0)
        reach = crank.crank_radius_mm + crank.crankpin.diameter_mm
        return {
            RADIUS: (arm, arm + 3.0 * reach),
            THICKNESS: (web.thickness_mm, web.thickness_mm + 0.499 * crank.main_journal.width_mm),
            FAN: (1.0, 180.0),
            BORE: (0.0, 0.8 * crank.crankpin.diameter_mm),
            FLANGE: (crank.main_journal.diameter_mm, 10.0 * crank.main_journal.diameter_mm),
        }[key]

    def _closed(self, values: Array) -> Array:
        """Return product [g·mm] and inertia [g·mm²] (2,) of counterweights, less bores, and flange."""
        size = {key: size_of(self.design, key) for key in NAMES if _has(self.design, key)}
        size |= dict(zip(self.keys, (float(each) for each in values), strict=True))
        density = self.design.density_kg_m3 * G_PER_MM3_PER_KG_M3
        total = np.zeros(2)
        if self.design.counterweight is not None:
            total += self._sectors(size, density)
        total -= self._bores(size[BORE], density)
        if self.design.flange is not None:
            total[1] += math.pi / 32.0 * density * self.design.flange.thickness_mm * size[FLANGE] ** 4
        return total

    def _sectors(self, size: dict[str, float], density: float) -> Array:
        """Return sectors: ρ T ⅔ sin(A/2)(R³ − r³) and ρ T A/4 (R⁴ − r⁴), of arm and shoulder."""
        crank, weight = self.design, self.design.counterweight
        assert weight is not None
        web = crank.web
        hub = float((web.hub_radius_mm if web.outline == "pear" else web.disc_radius_mm) or 0.0)
        inner = weight.inner_radius_mm or 0.5 * crank.main_journal.diameter_mm + crank.fillet_mm
        angle, radius = math.radians(size[FAN]), size[RADIUS]
        parts = ((web.thickness_mm, hub), (size[THICKNESS] - web.thickness_mm, inner))
        product = sum(t * (radius**3 - r**3) for t, r in parts) * 2.0 / 3.0 * math.sin(0.5 * angle)
        inertia = sum(t * (radius**4 - r**4) for t, r in parts) * 0.25 * angle
        units = [towards for _, towards in self.aim.counterweights()]
        return density * np.array([self.aim.along(units) * product, len(units) * inertia])

    def _bores(self, bore_mm: float, density: float) -> Array:
        """Return bores through crankpin and webs: ρ π d²/4 L at the crank radius."""
        crank = self.design
        length = crank.crankpin.width_mm + 2.0 * crank.web.thickness_mm
        mass = density * 0.25 * math.pi * bore_mm**2 * length
        throws = self.aim.anatomy.throws
        along = self.aim.along(throw.direction for throw in throws)
        inertia = mass * (crank.crank_radius_mm**2 + bore_mm**2 / 8.0) * len(throws)
        return np.array([-mass * crank.crank_radius_mm * along, inertia])


def _has(design: Design, key: str) -> bool:
    return getattr(design, key.partition(".")[0]) is not None


# --- counterweights for a bob-weight on every crankpin ------------------------------------------------------
LEAST_BOB_WEIGHT_SHARE = 1e-6
"""Unbalance of a bob-weight on every pin, as a share of one alone, below which the throws cancel out."""
RADIUS_STEP_MM = 0.1
"""Step in which a fitted radius is rounded up: heavier counterweights can be drilled, lighter ones not."""


def largest_bob_weight_g(design: Design) -> float | None:
    """Return the bob-weight [g] that the counterweights balance, the same on every crankpin.

    Lighter bob-weights leave the counterweights too heavy, which cuts can correct. None if the throws cancel
    each other out, force and couple: then no bob-weight counts.

    Notes
    -----
    The least squares of force and couple, U + W B = 0: of the crank, U, and of one gram on every pin, B. The
    couple is taken about the middle of the crankpins, divided by their distance.
    """
    anatomy = crank_anatomy(design)
    one_gram_each = (Moments.point(1.0, throw.crankpin.centre_mm) for throw in anatomy.throws)
    pins = _force_and_couple(sum(one_gram_each, Moments.zero()), anatomy)
    alone = max(throw.crank_radius_mm for throw in anatomy.throws)
    if float(np.linalg.norm(pins)) < LEAST_BOB_WEIGHT_SHARE * alone:
        return None
    crank = _force_and_couple(exact_moments(design, SEGMENTS).moved(anatomy.file_to_rotor), anatomy)
    return float(-(crank @ pins) / (pins @ pins))


def radius_for_bob_weights_mm(design: Design, most_g: float) -> float:
    """Return the counterweight radius [mm] that balances bob-weights up to ``most_g`` [g] on every crankpin.

    The bob-weight is α + β R³ of a sector's radius R, exactly without a draft: two cranks are built for α and
    β, and each radius found is built and measured. It is rounded up to `RADIUS_STEP_MM`.

    Raises
    ------
    JobError
        If the throws cancel each other out, or no radius beyond the web's own balances it.
    """
    here = size_of(design, RADIUS)
    known = [(here, _balanced(design, here)), (1.1 * here, _balanced(design, 1.1 * here))]
    for _ in range(MOST_TRIALS):
        (r1, w1), (r2, w2) = known[-2:]
        cube = r1**3 + (most_g - w1) * (r2**3 - r1**3) / (w2 - w1)
        steps = math.ceil(round(math.cbrt(max(cube, 0.0)) / RADIUS_STEP_MM, 6))
        radius = round(RADIUS_STEP_MM * steps, DIGITS)
        if radius == r2:  # which was too small by less than a step
            radius = round(r2 + RADIUS_STEP_MM, DIGITS)
        known.append((radius, _balanced(design, radius)))
        if known[-1][1] >= most_g > _closed_g(known[-1], known[-2], radius - 2.0 * RADIUS_STEP_MM):
            return radius
    raise JobError(f"no counterweight radius was found for bob-weights up to {most_g:g} g")


def _closed_g(one: tuple[float, float], other: tuple[float, float], radius_mm: float) -> float:
    """Return the bob-weight of a radius on the line in R³ through two that were built."""
    (r1, w1), (r2, w2) = one, other
    return w1 + (w2 - w1) * (radius_mm**3 - r1**3) / (r2**3 - r1**3)


def _balanced(design: Design, radius_mm: float) -> float:
    found = largest_bob_weight_g(with_settings(design, {RADIUS: radius_mm}))
    if found is None:
        raise JobError("the throws cancel each other out: no bob-weight counts, and no counterweight")
    return found


def _force_and_couple(moments: Moments, anatomy: Anatomy) -> Array:
    """Return force and couple (4,) [g·mm] of moments."""
    places = [float(throw.crankpin.centre_mm[2]) for throw in anatomy.throws]
    middle, apart = 0.5 * (max(places) + min(places)), max(places) - min(places)
    force, product = moments.first_g_mm[:2], moments.second_g_mm2[:2, 2]
    couple = (product - middle * force) / apart if apart else np.zeros(2)
    return np.concatenate([force, couple])
