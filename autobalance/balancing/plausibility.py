"""Plausibility of a crank and a job, by physics, and the signs of an engine in its crank."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from autobalance import registry
from autobalance.balancing.measured import Crank
from autobalance.balancing.rotor_from_job import crank_factor, hung_on, throw_loads, tolerance_of, total_g
from autobalance.balancing.typed_effects import refuse_density, usual_units
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.job.model import EngineParts, PartWeights
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.parts import factor_direction_g_mm
from autobalance.units import MM_PER, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank


# Signs of an engine in its crank alone: pins that hold two rods, throws that cancel, usual factors.


TWO_RODS_WIDTH = 0.75
"""Smallest width of a crankpin over its diameter for two rods side by side: singles and in-line engines have
0.35 to 0.62 (presets, bundled cranks, gmsh 4a), V8, V12 and V twins 0.79 and more."""
CANCELLED = 1e-3
"""Share of a sum of throws, or of their moments, below which they cancel."""
USUAL_PARTS_G_MM3 = ((0.86e-3, 1.68e-3), (1.29e-3, 1.97e-3))
"""Rotating and reciprocating mass of a rod over the cube of the stroke: those of the bundled CRF 250 R, and
those that four newcomers took for ordinary ones of a stroke of 58 mm."""
USUAL_FACTOR = (0.05, 1.0)
"""Factors that a single may be made for; a crank beyond them is for other parts than the usual ones."""


def holds_two_rods(anatomy: Anatomy) -> bool:
    """Return whether every crankpin is wide enough for two rods side by side."""
    return all(
        throw.crankpin.width_mm >= TWO_RODS_WIDTH * throw.crankpin.diameter_mm for throw in anatomy.throws
    )


def throws_cancel(anatomy: Anatomy) -> bool:
    """Return whether equal masses on all crankpins leave neither a force nor a couple."""
    pins = [
        (throw.crank_radius_mm * cmath.rect(1.0, throw.angle_rad), float(throw.crankpin.centre_mm[2]))
        for throw in anatomy.throws
    ]
    size = sum(abs(pull) for pull, _ in pins)
    middle = sum(z for _, z in pins) / len(pins)
    lever = sum(abs(pull * (z - middle)) for pull, z in pins)
    force = abs(sum(pull for pull, _ in pins))
    couple = abs(sum(pull * (z - middle) for pull, z in pins))
    return force <= CANCELLED * size and couple <= CANCELLED * lever and len(pins) > 1


def own_factors(crank: Crank) -> tuple[float, float] | None:
    """Return the balance factors that a crank of one throw has with usual parts, low and high.

    None where its parts are not usual ones, or are not in the file.
    """
    if not crank.holds_crankpins:
        return None
    (throw,) = crank.anatomy.throws
    x, y = Unbalance.of(crank.moments).resultant_g_mm
    along = complex(x, y) * cmath.rect(1.0, -throw.angle_rad)
    cube = (2.0 * throw.crank_radius_mm) ** 3
    factors = sorted(
        (-along.real / throw.crank_radius_mm - rotating * cube) / (reciprocating * cube)
        for rotating, reciprocating in USUAL_PARTS_G_MM3
    )
    low, high = USUAL_FACTOR
    return (factors[0], factors[1]) if factors[1] > low and factors[0] < high else None


def factor_hint(crank: Crank) -> str:
    """Return a suggestion for the balance factor of a crank, in words."""
    anatomy = crank.anatomy
    if throws_cancel(anatomy):
        return "0: its throws cancel, force and couple"
    if holds_two_rods(anatomy):
        return "0.5 for vee engines of two rods a crankpin"
    if len(anatomy.throws) > 1:
        return "0.5: its throws leave a force or a couple"
    own = own_factors(crank)
    if own is None:
        return "0.25 to 0.65 for a single; a factor above the present one needs added metal"
    low, high = max(own[0], 0.0), min(own[1], 1.0)
    safe = math.floor(10.0 * low) / 10.0
    return (
        f"{safe:.1f}, say: it has {low:.2f} to {high:.2f} with usual parts, and higher than its own needs"
        " metal added"
    )


def layout_name(anatomy: Anatomy, engine: EngineParts) -> str:
    """Return the layout of an engine in words: ``single``, ``in-line 4``, ``V8, cross-plane``.

    Where the job has one rod on each crankpin, the words are those of an in-line engine.
    """
    throws = len(anatomy.throws)
    rods = [engine.of_throw(throw.number).rods for throw in anatomy.throws]
    if throws == 1:
        names = {1: "single", 2: "V twin"}
        return names.get(rods[0], f"{rods[0]} rods on one throw")
    if all(each == 1 for each in rods):
        return f"in-line {throws}"
    if all(each == 2 for each in rods):
        planes = {round(math.degrees(throw.angle_rad) % 180.0 / 15.0) % 12 for throw in anatomy.throws}
        plane = {1: ", flat-plane", 2: ", cross-plane"}.get(len(planes), "") if throws == 4 else ""
        return f"V{sum(rods)}{plane}"
    return f"{throws} throws, {sum(rods)} cylinders"


# Plausibility of a crank and a job: physics, not taste.
#
# Impossible values are refused; odd ones are reported, with the place and the unit that may be meant.


BOB_SHARE = (1e-3, 20.0)
"""Bob-weights over the crank's own mass: no running engine lies outside. Less than the first is refused only
if another unit would make it usual."""
USUAL_BOB_SHARE = (1e-2, 5.0)
MAX_WEIGHT_RATIO = 50.0
"""Largest ratio of two tables of weights: rotating to reciprocating, or a throw's, or the original ones', to
the job's."""
LEAST_G = 1.0
"""Smallest mass that moves with one rod: a model aircraft's engine has more."""
PIN_SHARE = 20.0
"""Largest ratio of a crankpin's weight to that of its bare cylinder, or the reverse."""
USUAL_FACTOR_RANGE = (-1.0, 3.0)
"""Balance factor that a crank may have before, with parts that are meant for it."""
LEAST_ALIKE = 0.01
"""Throws that cancel each other out except for this share of their sum have no meaningful factor."""
INERTIA_SHARE = (0.5, 2.0)
INERTIA_REFUSED = (0.05, 20.0)
"""A rod's inertia over m a b of two masses at its eyes: rods are near 1."""
END_SHARE = (1.2, 5.0)
"""A rod's end on the scale over all that moves with it: odd above, refused above."""
LEAST_SPEED_RPM = 300.0
"""Top speed of an engine with rods; the slowest ships' run at a quarter, whose cranks nobody balances so:
11.000 for eleven thousand was taken for 11."""
USUAL_THOUSANDS_RPM = 25.0
"""Largest speed that may be meant in thousands."""
WIDEST_TOLERANCE = 0.02
"""Share of the reciprocating mass that the permissible unbalance may span without a warning."""
KG_PART_RANGE = 3.0
"""A part below a gram is taken for one in kg if it would be within this many times the parts beside it."""
LIGHT_PARTS = ("clip", "ring", "shim", "seal", "lock", "oil", "washer", "pin_lock")
"""Words of parts that may well weigh less than a gram."""
ROD_RATIO = (2.0, 15.0)
"""A rod's length over the crank radius: engines are at 3 to 6."""


def oddities(job: Job, crank: Crank) -> tuple[str, ...]:
    """Return the oddities of a job for its crank, one line each.

    Raises
    ------
    JobError For impossible values: weights in another unit, a rod of impossible weights, rods beyond the
    mains.

    Notes
    -----
    The oil must have been measured (``with_oil``), where the job fills the crank with it.
    """
    odd = (*_bob_weights(job, crank), *odd_parts(job), *_crankpins(job, crank), *_oil(job))
    odd = (*odd, *_factor(job, crank), *_rod_length(job, crank.anatomy), *_pitch(job, crank.anatomy))
    return (*odd, *_rods(job, crank), *_speed(job), *_tolerance(job, crank), *_of_addons(job, crank.anatomy))


def _of_addons(job: Job, anatomy: Anatomy) -> Iterator[str]:
    """Yield what add-ons find odd in their tables of a job."""
    for table, place in registry.ODDITIES.items():
        if table in job.raw:
            yield from registry.loaded(place)(job, anatomy)


def odd_parts(job: Job) -> tuple[str, ...]:
    """Return the oddities of a job's weights among themselves, one line each.

    Raises
    ------
    JobError For a density that no material has, and for a rod of impossible weights.
    """
    refuse_density(job.crankshaft)
    return (*_unlike_weights(job), *_parts_in_kg(job), *_rod(job))


def odd_alone(job: Job) -> tuple[str, ...]:
    """Return the oddities of a job's weights if no crank is read to compare them with, one line each.

    Raises
    ------
    JobError
        As ``odd_parts``.
    """
    throws = (job.engine.default, *job.engine.by_throw.values())
    heaviest = max(sum(_totals_g(throw.weights).values()) for throw in throws)
    odd = odd_parts(job)
    if 0.0 < heaviest < LEAST_G:
        weights = "the weights of [engine.rotating_g] and [engine.reciprocating_g]"
        odd += (f"{job.path.name}: {weights} add up to {heaviest:.4g} g; are they in kg?",)
    return odd


def _bob_weights(job: Job, crank: Crank) -> Iterator[str]:
    """Compare bob-weights with the crank: in kilograms they are next to nothing, in milligrams heavier."""
    total = sum(load.parts.bob_weight_g(1.0) for load in throw_loads(crank.anatomy, job.engine))
    share = total / crank.moments.mass_g
    if total <= 0.0 or _usual(share):
        return
    finding = (
        f"{job.path.name}: the weights of [engine] add up to {total:.4g} g on a crank of"
        f" {crank.moments.mass_g:.4g} g"
    )
    meant = [f"are they in {unit}" for unit, by in (("kg", 1e3), ("mg", 1e-3)) if _usual(share * by)]
    units = [name for name, by in usual_units(crank.source).items() if _usual(share / by**3)]
    meant += [f"is the crank's unit {' or '.join(units)}"] if units else []
    question = f"; {', or '.join(meant)}?" if meant else ""
    low, high = BOB_SHARE
    if share > high or (share < low and meant):  # of no unit: a rotor without rods, whose keys are required
        raise JobError(f"{finding}; expected {low:g} to {high:g} times that{question}")
    low, high = USUAL_BOB_SHARE
    yield f"{finding}; odd outside {low:g} to {high:g} times that{question}"


def _usual(share: float) -> bool:
    return USUAL_BOB_SHARE[0] <= share <= USUAL_BOB_SHARE[1]


def _oil(job: Job) -> Iterator[str]:
    if job.engine.oil_g_mm3 is not None and not job.engine.oil:
        yield (
            f"{job.path.name}: engine.oil: the crank has no bore or drilling in its crankpins and main"
            " journals to fill; nothing is added"
        )


def _unlike_weights(job: Job) -> Iterator[str]:
    """Compare tables of weights: one may be in kilograms, another in grams."""
    engine = job.engine
    totals = {"engine": _totals_g(engine.default.weights)}
    for number, parts in engine.by_throw.items():
        totals[f"engine.throw[{number}]"] = _totals_g(parts.weights)
    if job.original is not None:
        totals["original"] = _totals_g(job.original)
    seen = set()
    for where, own in totals.items():
        named = [(f"{where}.{role}", total) for role, total in own.items()]
        default = [(f"engine.{role}", total) for role, total in totals["engine"].items()]
        for (name, one), (other, two) in [(named[0], named[1]), *zip(default, named, strict=True)]:
            if (one, two) not in seen and 0.0 < min(one, two) < max(one, two) / MAX_WEIGHT_RATIO:
                yield (
                    f"{job.path.name}: {name} adds up to {one:.4g} g, {other} to {two:.4g} g;"
                    " is one of them in another unit?"
                )
            seen.add((one, two))


def _parts_in_kg(job: Job) -> Iterator[str]:
    """Look for one part in kilograms among others in grams: 0.221 beside 19 and 210 g."""
    engine = job.engine
    tables = {"engine": engine.default.weights}
    tables |= {f"engine.throw[{number}]": parts.weights for number, parts in engine.by_throw.items()}
    if job.original is not None:
        tables["original"] = job.original
    seen = set()
    for where, own in tables.items():
        named = {
            f"{where}.{table}.{name}": weight.mass_g
            for table, parts in (
                ("rotating_g", own.rotating),
                ("reciprocating_g", own.reciprocating),
                ("crankpin_g", own.crankpin),
            )
            for name, weight in parts.items()
        }
        others = [mass for mass in named.values() if mass >= LEAST_G]
        for name, mass in named.items():
            part = name.rpartition(".")[2]
            if not 0.0 < mass < LEAST_G or not others or (part, mass) in seen:
                continue
            fits = min(others) / KG_PART_RANGE <= 1e3 * mass <= max(others) * KG_PART_RANGE
            if fits and not any(word in part.lower() for word in LIGHT_PARTS):
                seen.add((part, mass))
                yield (
                    f"{job.path.name}: {name} is {mass:g} g beside parts of {min(others):.4g} to"
                    f" {max(others):.4g} g; is it in kg ({1e3 * mass:g} g)?"
                )


def _rods(job: Job, crank: Crank) -> Iterator[str]:
    """Look for vee engines whose job does not say that two rods share a crankpin."""
    typed = job.raw.get("engine", {})
    if "rods_per_throw" in typed or "throw" in typed or job.engine.default.rods != 1:
        return
    if holds_two_rods(crank.anatomy) and crank.holds_crankpins:
        pin = crank.anatomy.throws[0].crankpin
        yield (
            f"{job.path.name}: engine.rods_per_throw is missing, so one rod is counted on each crankpin;"
            f" crankpin 1 is {pin.width_mm:.4g} mm wide and {pin.diameter_mm:.4g} mm thick, wide enough for"
            " two: set it to 2 for a vee engine, or to 1"
        )


def _speed(job: Job) -> Iterator[str]:
    """Look for a top speed in thousands."""
    if "balance.speed_rpm" in job.lacks:
        return
    rpm = job.balance.service_speed_rad_s / RAD_S_PER_RPM
    moved = sum(_totals_g(job.engine.default.weights).values())
    if rpm < LEAST_SPEED_RPM and moved > 0.0:
        meant = f"; is it in thousands ({1e3 * rpm:.6g})?" if rpm < USUAL_THOUSANDS_RPM else ""
        yield (
            f"{job.path.name}: balance.speed_rpm is {rpm:.6g}; an engine with connecting rods turns at"
            f" {LEAST_SPEED_RPM:g} or more, and the permissible unbalance grows as the speed falls{meant}"
        )


def _tolerance(job: Job, crank: Crank) -> Iterator[str]:
    """Compare the permissible unbalance with the reciprocating mass that a balance factor shares out."""
    if job.lacks & {"balance.speed_rpm", "balance.grade"}:
        return
    loads, _ = hung_on(job, crank.anatomy)
    along = sum(load.parts.reciprocating_on_throw_g * load.crank_radius_mm for load in loads)
    direction = math.hypot(*factor_direction_g_mm(loads))
    if direction < LEAST_ALIKE * along or not direction:
        return
    try:
        permissible = tolerance_of(job, crank.anatomy, crank.moments).permissible_g_mm
    except JobError:  # without tolerance planes; said where a verdict is asked for
        return
    spans = 2.0 * permissible / direction
    if spans > WIDEST_TOLERANCE:
        yield (
            f"{job.path.name}: the permissible unbalance spans {spans:.2g} of balance factor; a crank within"
            " tolerance may be that far off the factor wanted: check balance.grade and balance.speed_rpm"
        )


def _totals_g(weights: PartWeights) -> dict[str, float]:
    return {"rotating_g": total_g(weights.rotating), "reciprocating_g": total_g(weights.reciprocating)}


def _crankpins(job: Job, crank: Crank) -> Iterator[str]:
    """Compare the weight of a crankpin that is not in the file with its bare cylinder's."""
    for throw in crank.anatomy.throws:
        weight = job.engine.of_throw(throw.number).weights.crankpin.get("crankpin")
        pin = throw.crankpin
        bare = 0.25 * math.pi * pin.diameter_mm**2 * pin.width_mm * crank.density_g_mm3
        if weight is not None and not bare / PIN_SHARE <= weight.mass_g <= bare * PIN_SHARE:
            yield (
                f"{job.path.name}: the crankpin of throw {throw.number} weighs {weight.mass_g:.4g} g, its"
                f" bare cylinder between the webs {bare:.4g} g at the crank's density; is it in another unit?"
            )
            return


def _factor(job: Job, crank: Crank) -> Iterator[str]:
    loads, attached = hung_on(job, crank.anatomy)
    before = crank_factor(crank.moments, loads, attached)
    along = sum(load.parts.reciprocating_on_throw_g * load.crank_radius_mm for load in loads)
    if math.hypot(*factor_direction_g_mm(loads)) < LEAST_ALIKE * along:
        return
    if before is not None and not USUAL_FACTOR_RANGE[0] <= before <= USUAL_FACTOR_RANGE[1]:
        yield (
            f"{job.path.name}: the crank's balance factor before is {before:.4g} with these weights; odd"
            f" outside {USUAL_FACTOR_RANGE[0]:g} to {USUAL_FACTOR_RANGE[1]:g}: check weights, density"
            " and the file's unit"
        )


def _rod(job: Job) -> Iterator[str]:
    """Compare ``[engine.rod]`` with the weights and with itself."""
    rod, engine = job.engine.rod, job.engine
    if rod is None:
        return
    all_g = _totals_g(engine.default.weights)
    yield from _rod_end(job, "big_end_g", rod.big_end_g, "rotating_g", all_g)
    yield from _rod_end(job, "small_end_g", rod.small_end_g, "reciprocating_g", all_g)
    if rod.inertia_g_mm2 is None or engine.rod_length_mm is None or not rod.big_end_g + rod.small_end_g > 0.0:
        return
    whole = ConnectingRod.from_two_scales(rod.big_end_g, rod.small_end_g, engine.rod_length_mm)
    if not whole.two_mass_inertia_g_mm2 > 0.0:
        return
    share = rod.inertia_g_mm2 / whole.two_mass_inertia_g_mm2
    finding = (
        f"{job.path.name}: engine.rod.inertia_kg_mm2 is {rod.inertia_g_mm2 * 1e-3:g}, {share:.3g} times"
        " that of two masses at its eyes"
    )
    if not INERTIA_REFUSED[0] <= share <= INERTIA_REFUSED[1]:
        raise JobError(f"{finding}; expected {INERTIA_REFUSED[0]:g} to {INERTIA_REFUSED[1]:g} times (kg·mm²)")
    if not INERTIA_SHARE[0] <= share <= INERTIA_SHARE[1]:
        yield f"{finding}; rods are near 1"


def _rod_end(job: Job, key: str, end_g: float, table: str, totals_g: Mapping[str, float]) -> Iterator[str]:
    """Compare the weight of a rod's end on the scale with the table of all parts that move with it."""
    all_g = totals_g[table]
    finding = f"{job.path.name}: engine.rod.{key} is {end_g:g}"
    odd, refused = END_SHARE
    if all_g > 0.0 and end_g > refused * all_g:
        end = key.split("_", maxsplit=1)[0]
        raise JobError(f"{finding}, all of engine.{table} {all_g:g} g; the {end} end is a part of that")
    if all_g > 0.0 and end_g > odd * all_g:
        yield f"{finding}, more than all of engine.{table}, {all_g:g} g"


def _rod_length(job: Job, anatomy: Anatomy) -> Iterator[str]:
    """Compare the rod's length with the crank radius."""
    length = job.engine.rod_length_mm
    if length is None:
        return
    radius, (low, high) = anatomy.throws[0].crank_radius_mm, ROD_RATIO
    share = length / radius
    meant = [name for name, mm in MM_PER.items() if mm > 1.0 and low <= share * mm <= high]
    question = f"; is it in {' or '.join(meant)}?" if meant else ""
    finding = f"{job.path.name}: engine.rod_length_mm is {length:g}"
    least = radius + abs(job.engine.layout.offset_mm)
    if length <= least:
        raise JobError(
            f"{job.path.name}: engine: rod length is {length:g} mm; must be more than crank radius and offset"
            f" together, {least:.4g} mm{question}"
        )
    if not low <= share <= high:
        yield (
            f"{finding}, {share:.3g} times the crank radius of {radius:.4g} mm; odd outside"
            f" {low:g} to {high:g} times{question}"
        )


def _pitch(job: Job, anatomy: Anatomy) -> Iterator[str]:
    """Compare the rods' places with their crankpin and the mains beside it."""
    pitch = abs(job.engine.layout.rod_pitch_mm)
    mains = [float(journal.centre_mm[2]) for journal in anatomy.main_journals]
    for throw in anatomy.throws:
        half = 0.5 * pitch * (job.engine.of_throw(throw.number).rods - 1)
        if half == 0.0:
            continue
        z, pin = float(throw.crankpin.centre_mm[2]), throw.crankpin.width_mm
        low = max((main for main in mains if main <= z), default=-math.inf)
        high = min((main for main in mains if main > z), default=math.inf)
        if z - half < low or z + half > high:
            raise JobError(
                f"{job.path.name}: engine.layout.rod_pitch_mm is {pitch:g}; on throw {throw.number} the rods"
                f" would reach beyond the main bearings next to it; its crankpin is {pin:.4g} mm wide"
            )
        if half > 0.5 * pin and math.isfinite(pin):
            yield (
                f"{job.path.name}: engine.layout.rod_pitch_mm is {pitch:g}; on throw {throw.number} rods"
                f" lie outside the crankpin, which is {pin:.4g} mm wide"
            )
