"""Firing order and angles of an engine, and of a job."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from autobalance.balancing.engine_from_job import cylinders as engine_cylinders
from autobalance.balancing.engine_from_job import in_its_sense
from autobalance.crank.anatomy import Anatomy
from autobalance.engines.cycle.closed_part import Chamber, Charge, Wiebe
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange, span_rad
from autobalance.engines.cycle.firing_engine import FiringEngine, ThrowPlace
from autobalance.engines.cycle.model import Cycle, CylinderGas
from autobalance.engines.cycle.trace import PressureTrace, read_trace
from autobalance.engines.cycle.wall_heat import Woschni
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder, Engine

# Firing angle of each cylinder: from a firing order, or checked against given angles.


SLACK_RAD = math.radians(0.01)
"""A dead centre so little before angle 0 counts as at it."""
ROUNDING_RAD = 1e-9
"""An angle so near to 0 is 0."""
EVEN_RAD = math.radians(1.0)
"""Largest difference of intervals that count as even: an offset moves dead centres by less."""
LARGEST_MISS_RAD = math.radians(10.0)
"""Largest distance of a given firing angle from its cylinder's dead centre."""


def dead_centres_rad(cylinders: Sequence[Cylinder]) -> list[float]:
    """Return the crank angle in [0, 2π) of each cylinder's top dead centre [rad].

    The crankpin of a cylinder leads its direction by θ + throw angle − bank.
    """
    return [
        _first_turn(each.slider_crank.dead_centres_rad[0] + each.bank_rad - each.throw_angle_rad)
        for each in cylinders
    ]


def _first_turn(angle_rad: float) -> float:
    return _in_cycle(angle_rad, 2.0 * math.pi)


def firing_in_order(tops_rad: Sequence[float], order: Sequence[int], span_rad: float) -> list[float]:
    """Return the firing angles that keep an order with the least sum of squared intervals.

    Parameters
    ----------
    tops_rad : sequence of float
        A top dead centre of each cylinder [rad].
    order : sequence of int
        Every cylinder's number once, from 1; the first named fires in the first turn.
    span_rad : float
        Of the cycle, 4π or 2π [rad].

    Returns
    -------
    list of float
        By cylinder [rad].

    Raises
    ------
    ValueError
        If the order misses or repeats a cylinder, or no dead centres keep it.

    Examples
    --------
    >>> flat = [0.0, math.pi, math.pi, 0.0]
    >>> [round(math.degrees(each)) for each in firing_in_order(flat, [1, 3, 4, 2], 4.0 * math.pi)]
    [0, 540, 180, 360]
    """
    count = len(tops_rad)
    if sorted(order) != list(range(1, count + 1)):
        missing = sorted(set(range(1, count + 1)) - set(order))
        lacks = f"misses {', '.join(map(str, missing))}" if missing else "names a cylinder twice"
        raise ValueError(f"is {list(order)} and {lacks}; must name each of {count} cylinders once")
    start = _first_turn(tops_rad[order[0] - 1])
    # Least sum so far and the angles that give it, by the last angle; one or two places for each cylinder.
    paths: dict[float, tuple[float, list[float]]] = {0.0: (0.0, [0.0])}
    for number in order[1:]:
        after = _first_turn(tops_rad[number - 1] - start)
        places = [after + turn * 2.0 * math.pi for turn in range(round(span_rad / (2.0 * math.pi)))]
        paths = {place: best for place in places if (best := _best_path(paths, place)) is not None}
    if not paths:
        raise ValueError(
            f"is {list(order)}; no dead centres of these cylinders follow each other so in a cycle of"
            f" {math.degrees(span_rad):g}°"
        )
    _, angles = min((cost + (span_rad - place) ** 2, angles) for place, (cost, angles) in paths.items())
    fired_at = [0.0] * count
    for number, angle in zip(order, angles, strict=True):
        fired_at[number - 1] = start + angle
    return [_in_cycle(angle, span_rad) for angle in fired_at]


def _best_path(
    paths: dict[float, tuple[float, list[float]]], place: float
) -> tuple[float, list[float]] | None:
    before = [
        (cost + (place - last) ** 2, [*angles, place])
        for last, (cost, angles) in paths.items()
        if place >= last - 2.0 * SLACK_RAD
    ]
    return min(before) if before else None


def _in_cycle(angle_rad: float, span_rad: float) -> float:
    angle = (angle_rad + SLACK_RAD) % span_rad - SLACK_RAD
    return 0.0 if abs(angle) < ROUNDING_RAD else angle  # and never -0.0


def intervals_rad(fired_rad: Sequence[float], span_rad: float) -> list[float]:
    """Return the crank angles from each firing to the next, from the first on [rad]."""
    angles = sorted(fired_rad)
    return [after - before for before, after in zip(angles, [*angles[1:], angles[0] + span_rad], strict=True)]


def is_even(fired_rad: Sequence[float], span_rad: float) -> bool:
    """Return whether all intervals between firings are equal."""
    wanted = span_rad / len(fired_rad)
    return all(abs(each - wanted) <= EVEN_RAD for each in intervals_rad(fired_rad, span_rad))


def at_once(fired_rad: Sequence[float], span_rad: float) -> list[tuple[int, int]]:
    """Return the pairs of cylinders, from 1, that fire together."""
    pairs = []
    for one, here in enumerate(fired_rad, 1):
        for other, there in enumerate(fired_rad[one:], one + 1):
            apart = (there - here + 0.5 * span_rad) % span_rad - 0.5 * span_rad
            if abs(apart) <= EVEN_RAD:
                pairs.append((one, other))
    return pairs


def even_order(tops_rad: Sequence[float], span_rad: float, first: int) -> list[int] | None:
    """Return an order, from a cylinder on, that fires at even intervals; None where none does.

    Parameters
    ----------
    tops_rad : sequence of float
        A top dead centre of each cylinder [rad].
    span_rad : float
        Of the cycle [rad].
    first : int
        Number of the cylinder that it begins with, from 1.
    """
    count = len(tops_rad)
    step = span_rad / count
    start = tops_rad[first - 1]
    order, left = [first], set(range(1, count + 1)) - {first}
    for place in range(1, count):
        wanted = _first_turn(start + place * step)
        near = [
            number
            for number in sorted(left)
            if abs((tops_rad[number - 1] - wanted + math.pi) % (2.0 * math.pi) - math.pi) <= EVEN_RAD
        ]
        if not near:
            return None
        order.append(near[0])
        left.remove(near[0])
    return order


def firing_as_given(tops_rad: Sequence[float], given_rad: Sequence[float], span_rad: float) -> list[float]:
    """Return given firing angles, each brought to its cylinder's dead centre.

    Raises
    ------
    ValueError
        If there is not one for each cylinder, or one lies more than 10° from a dead centre.
    """
    if len(given_rad) != len(tops_rad):
        raise ValueError(f"has {len(given_rad)} angles; expected one for each of {len(tops_rad)} cylinders")
    angles: list[float] = []
    for number, (top, angle) in enumerate(zip(tops_rad, given_rad, strict=True), 1):
        off = (angle - top + math.pi) % (2.0 * math.pi) - math.pi
        if abs(off) > LARGEST_MISS_RAD:
            raise ValueError(
                f"has {math.degrees(angle):g}° for cylinder {number}, whose top dead centres lie at"
                f" {math.degrees(top):g}° and every 360° from it"
            )
        angles.append(_in_cycle(angle - off, span_rad))
    return angles


# A job with a ``[cycle]`` and its crank become an engine that fires.


def firing_engine(
    job: Job, anatomy: Anatomy, speed_rad_s: float, engine: Callable[[], Engine]
) -> FiringEngine:
    """Return the firing engine of a job.

    Parameters
    ----------
    job : Job
        With a ``[cycle]``.
    anatomy : Anatomy
        Of its crank.
    speed_rad_s : float
        At which heat goes through the walls and drives pull; of no matter without either [rad/s].
    engine : callable
        Returns cylinders and crank; called once the job is known to have a cycle and enough main bearings.

    Raises
    ------
    JobError
        If the job has no ``[cycle]``, no rod length, or a cycle that this engine cannot have.
    """
    table = check_cycle(job)
    mains = sorted(anatomy.main_journals, key=lambda pin: float(pin.centre_mm[2]))
    if len(mains) < 2:
        raise JobError(
            f"{job.path.name}: the crank has {len(mains)} main journal{'s' * (len(mains) != 1)}; its loads"
            " need at least two (crankshaft.main_journals names them)"
        )
    mover, throws = engine(), _throws(job, anatomy)
    try:
        return FiringEngine(
            mover,
            throws,
            tuple(float(pin.centre_mm[2]) for pin in mains),
            tuple(pin.diameter_mm for pin in mains),
            _cycles(job, table, mover, speed_rad_s),
            tuple(_firing_rad(table, mover.cylinders, throws, job.engine.clockwise)),
            table.flywheel_g_mm2,
            table.friction,
            table.gravity,
            table.drives,
            speed_rad_s,
            table.piston,
        )
    except JobError:  # has named the job and the key
        raise
    except ValueError as error:
        raise JobError(f"{job.path.name}: {error}") from None


def check_cycle(job: Job) -> Cycle:
    """Return the ``[cycle]`` of a job that can have one.

    Raises
    ------
    JobError
        If it is missing, or the rod length that it needs.
    """
    cycle = job.table(Cycle)
    if cycle is None:
        raise JobError(f"{job.path.name}: [cycle] is missing; it needs bore_mm, compression_ratio and heat_J")
    if job.engine.rod_length_mm is None:
        raise JobError(f"{job.path.name}: engine.rod_length_mm is missing; the cycle needs it")
    return cycle


def odd_firing(job: Job, anatomy: Anatomy) -> tuple[str, ...]:
    """Return a warning of a firing order of four strokes that fires unevenly where another fires evenly.

    Two cylinders that fire at once are named. Orders that cannot be kept are refused elsewhere.
    """
    cycle = job.table(Cycle)
    if cycle is None or cycle.strokes != 4 or cycle.firing_order is None or job.engine.rod_length_mm is None:
        return ()
    try:
        cylinders = in_its_sense(job, Engine(engine_cylinders(job, anatomy))).cylinders
        fired = _firing_rad(cycle, cylinders, _throws(job, anatomy), job.engine.clockwise)
    except (JobError, ValueError):
        return ()
    span, tops = span_rad(cycle.strokes), dead_centres_rad(cylinders)
    better = even_order(tops, span, cycle.firing_order[0])
    pairs = [" and ".join(map(str, pair)) for pair in at_once(fired, span)]
    if not pairs and (better is None or is_even(fired, span)):
        return ()
    what = f": cylinders {', '.join(pairs)} fire at once" if pairs else " fires unevenly"
    remedy = "" if better is None else f"; {better} fires evenly"
    return (f"{job.path.name}: cycle.firing_order {list(cycle.firing_order)}{what}{remedy}",)


def _throws(job: Job, anatomy: Anatomy) -> tuple[ThrowPlace, ...]:
    places: list[ThrowPlace] = []
    first = 0
    for throw in anatomy.throws:
        rods = job.engine.of_throw(throw.number).rods
        numbers = tuple(range(first, first + rods))
        angle = 0.0 - throw.angle_rad if job.engine.clockwise else throw.angle_rad
        places.append(ThrowPlace(angle, float(throw.crankpin.centre_mm[2]), numbers))
        first += rods
    return tuple(places)


def _firing_rad(
    cycle: Cycle, cylinders: tuple[Cylinder, ...], throws: tuple[ThrowPlace, ...], clockwise: bool
) -> list[float]:
    tops, span = dead_centres_rad(cylinders), span_rad(cycle.strokes)
    if cycle.firing_rad is not None:
        with_key = "cycle.firing_deg"
        try:
            return firing_as_given(tops, cycle.firing_rad, span)
        except ValueError as error:
            raise ValueError(f"{with_key} {error}") from None
    if cycle.firing_order is None:
        if len(tops) > 1 and cycle.strokes == 4:
            raise ValueError(
                f"cycle.firing_order is missing; {len(tops)} cylinders need it, or cycle.firing_deg"
            )
        return tops
    try:
        fired = firing_in_order(tops, cycle.firing_order, span)
        _refuse_even_backwards(cycle, cylinders, clockwise, fired)
        return fired
    except _OtherSenseError:
        raise
    except ValueError as error:
        other = _other_sense(cycle, cylinders, clockwise) or _other_banks(cycle, tops, throws)
        raise ValueError(f"cycle.firing_order {error}{other}") from None


class _OtherSenseError(ValueError):
    """An order that fires evenly in the other sense of turning alone."""


def _refuse_even_backwards(
    cycle: Cycle, cylinders: tuple[Cylinder, ...], clockwise: bool, fired_rad: list[float]
) -> None:
    """Refuse an order of four strokes that fires evenly only in an engine which turns the other way.

    Such an order can be kept, with uneven intervals that nobody means: an in-line three of [1, 2, 3] that
    turns counter-clockwise would fire at 0, 120 and 600°.
    """
    assert cycle.firing_order is not None
    span = span_rad(cycle.strokes)
    if cycle.strokes != 4 or len(cylinders) < 3 or is_even(fired_rad, span):
        return
    turned = dead_centres_rad(Engine(cylinders).mirrored().cylinders)
    first, *rest = cycle.firing_order
    backwards = (first, *reversed(rest))
    try:
        there = firing_in_order(turned, cycle.firing_order, span)
        here = firing_in_order(dead_centres_rad(cylinders), backwards, span)
    except ValueError:
        return
    if is_even(there, span) and is_even(here, span):
        now, other = ("cw", "ccw") if clockwise else ("ccw", "cw")
        gaps = ", ".join(f"{math.degrees(each):.4g}" for each in intervals_rad(fired_rad, span))
        raise _OtherSenseError(
            f"cycle.firing_order is {list(cycle.firing_order)}, whose intervals are {gaps}°; this order fires"
            f' evenly with engine.turns = "{other}" (the crank turns "{now}" now, seen from +z), and'
            f' {list(backwards)} with "{now}"; if the intervals are meant, give cycle.firing_deg'
        )


def _other_sense(cycle: Cycle, cylinders: tuple[Cylinder, ...], clockwise: bool) -> str:
    """Return a remedy for an order that fits an engine which turns the other way; else nothing.

    Backwards, the same order fits an engine that turns backwards.
    """
    assert cycle.firing_order is not None
    span = span_rad(cycle.strokes)
    turned = dead_centres_rad(Engine(cylinders).mirrored().cylinders)
    first, *rest = cycle.firing_order
    backwards = (first, *reversed(rest))
    try:
        firing_in_order(turned, cycle.firing_order, span)
        firing_in_order(dead_centres_rad(cylinders), backwards, span)
    except ValueError:
        return ""
    now, other = ("cw", "ccw") if clockwise else ("ccw", "cw")
    return (
        f'; this order fits engine.turns = "{other}" (the crank turns "{now}" now, seen from +z), and'
        f' {list(backwards)} fits "{now}"'
    )


def _other_banks(cycle: Cycle, tops_rad: list[float], throws: tuple[ThrowPlace, ...]) -> str:
    """Return a remedy for an order that fits with each throw's cylinders exchanged; else nothing."""
    assert cycle.firing_order is not None
    exchanged = {
        number + 1: other + 1
        for each in throws
        for number, other in zip(each.cylinders, reversed(each.cylinders), strict=True)
    }
    order = [exchanged[number] for number in cycle.firing_order if number in exchanged]
    try:
        firing_in_order(tops_rad, order, span_rad(cycle.strokes))
    except ValueError:
        return ""
    return (
        "; this order fits with the cylinders of each throw numbered the other way round"
        f" (engine.layout.bank_deg), and {order} fits as they are"
    )


def _cycles(job: Job, cycle: Cycle, engine: Engine, speed_rad_s: float) -> tuple[CylinderCycle, ...]:
    count = len(engine.cylinders)
    for number in cycle.by_cylinder:
        if number > count:
            raise ValueError(
                f"cycle.cylinder number {number}: the engine has {count} cylinder{'s' * (count != 1)}"
            )
    walls = None if cycle.woschni_wall_k is None else Woschni(cycle.woschni_wall_k, speed_rad_s)
    traces: dict[float, PressureTrace] = {}
    by_gas: dict[tuple[SliderCrank, CylinderGas], CylinderCycle] = {}
    for number, cylinder in enumerate(engine.cylinders, 1):
        gas = cycle.of_cylinder(number)
        key = cylinder.slider_crank, gas
        if key not in by_gas:
            if gas.model == "trace" and gas.intake_mpa not in traces:
                traces[gas.intake_mpa] = _trace(job, cycle, gas)
            trace = traces.get(gas.intake_mpa) if gas.model == "trace" else None
            try:
                by_gas[key] = _cylinder_cycle(cylinder.slider_crank, gas, cycle, trace, walls)
            except ValueError as error:
                raise ValueError(f"cycle, cylinder {number}: {error}") from None
    return tuple(
        by_gas[cylinder.slider_crank, cycle.of_cylinder(number)]
        for number, cylinder in enumerate(engine.cylinders, 1)
    )


def _cylinder_cycle(
    slider_crank: SliderCrank,
    gas: CylinderGas,
    cycle: Cycle,
    trace: PressureTrace | None,
    walls: Woschni | None,
) -> CylinderCycle:
    chamber = Chamber(slider_crank, gas.bore_mm, gas.compression_ratio)
    if gas.crankcase_mm3 is not None and gas.crankcase_mm3 <= chamber.swept_mm3:
        raise ValueError(
            f"crankcase_volume_cm3 is {gas.crankcase_mm3 / 1e3:g}; the piston sweeps"
            f" {chamber.swept_mm3 / 1e3:g} cm³, and it must be more"
        )
    exchange = GasExchange(
        cycle.strokes,
        gas.intake_mpa,
        gas.exhaust_mpa,
        gas.crankcase_mpa,
        gas.intake_closes_rad,
        gas.exhaust_opens_rad,
        gas.crankcase_mm3,
    )
    charge = Charge(gas.intake_mpa, gas.intake_k, gas.gamma, gas.gamma_per_k)
    if trace is not None:
        return CylinderCycle.measured(chamber, exchange, charge, trace)
    heat = None
    if gas.heat_n_mm is not None:
        heat = Wiebe(gas.start_rad, gas.duration_rad, gas.wiebe_a, gas.wiebe_n, gas.heat_n_mm)
    return CylinderCycle.modelled(chamber, exchange, charge, heat, walls)


def _trace(job: Job, cycle: Cycle, gas: CylinderGas) -> PressureTrace:
    """Return the trace of the job's file: cut into cycles, shifted, smoothed, set to its level."""
    path = job.path.parent / cycle.trace.file
    angle, pressure = read_trace(path)
    try:
        trace = PressureTrace.cut(angle, pressure, span_rad(cycle.strokes)).shifted(cycle.trace.shift_rad)
        if cycle.trace.smooth_rad > 0.0:
            trace = trace.smoothed(cycle.trace.smooth_rad)
        if cycle.trace.peg == "intake":
            trace = trace.levelled(gas.intake_mpa)
        trace.check_absolute()
    except ValueError as error:
        raise ValueError(f"cycle.trace {cycle.trace.file} {error}") from None
    return trace
