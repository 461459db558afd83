"""A job with a ``[cycle]`` and its crank become an engine that fires."""

from __future__ import annotations

import math
from collections.abc import Callable

from autobalance.balancing.engine_from_job import cylinders as engine_cylinders
from autobalance.balancing.engine_from_job import in_its_sense
from autobalance.crank.anatomy import Anatomy
from autobalance.engines.cycle.chamber import Chamber
from autobalance.engines.cycle.closed_part import Charge
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange, span_rad
from autobalance.engines.cycle.firing import (
    at_once,
    dead_centres_rad,
    even_order,
    firing_as_given,
    firing_in_order,
    intervals_rad,
    is_even,
)
from autobalance.engines.cycle.firing_engine import FiringEngine, ThrowPlace
from autobalance.engines.cycle.heat_release import Wiebe
from autobalance.engines.cycle.model import Cycle, CylinderGas
from autobalance.engines.cycle.trace import Trace
from autobalance.engines.cycle.trace_input import read_trace
from autobalance.engines.cycle.wall_heat import Woschni
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder, Engine


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
    traces: dict[float, Trace] = {}
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
    slider_crank: SliderCrank, gas: CylinderGas, cycle: Cycle, trace: Trace | None, walls: Woschni | None
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


def _trace(job: Job, cycle: Cycle, gas: CylinderGas) -> Trace:
    """Return the trace of the job's file: cut into cycles, shifted, smoothed, set to its level."""
    path = job.path.parent / cycle.trace.file
    angle, pressure = read_trace(path)
    try:
        trace = Trace.cut(angle, pressure, span_rad(cycle.strokes)).shifted(cycle.trace.shift_rad)
        if cycle.trace.smooth_rad > 0.0:
            trace = trace.smoothed(cycle.trace.smooth_rad)
        if cycle.trace.peg == "intake":
            trace = trace.levelled(gas.intake_mpa)
        trace.check_absolute()
    except ValueError as error:
        raise ValueError(f"cycle.trace {cycle.trace.file} {error}") from None
    return trace
