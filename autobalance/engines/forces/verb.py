"""``forces``: orders, bearing loads and balance factors of a job's engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing import engine_from_job
from autobalance.declare import ABSENT
from autobalance.engines.cycle.model import Cycle
from autobalance.engines.forces.answer import EngineState, ForcesReport, WithShafts
from autobalance.engines.forces.factor_advice import advise
from autobalance.engines.mounts.spectra import Mounts
from autobalance.errors import JobError, UsageError
from autobalance.job import JobSource
from autobalance.report.plots import Drawn, Plot, Plots
from autobalance.running_gear.loads import whole_turn
from autobalance.running_gear.roll import (
    ANGLES,
    highest_order,
    inertia_loads,
    momentum_roll_n_m,
    roll_of,
    shaking_force,
    turn_loads,
)
from autobalance.running_gear.shafts import orders_with_shafts, roll_moment_n_m
from autobalance.running_gear.whole_engine import Engine, about, dead_centres, first_order_counterweight
from autobalance.runtime import Progress
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.crank_job import is_crank, job_given
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import Request, job_keys, request
from autobalance.verbs.options import place_mm
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.engines.mounts.mounted_engine import MountedAnalysis
    from autobalance.verbs.crank import Crank


@dataclass(frozen=True, eq=False, repr=False)
class ForcesResult(VerbResult):
    """Inertia forces of an engine, with its crank as the file has it and balanced."""

    content: ForcesReport
    found: Request
    engines: dict[str, Engine]
    factors: tuple[float, ...]

    def text(self, units: str = "metric") -> str:
        """Return tables of forces, orders and loads."""
        from autobalance.engines.forces.answer import forces_text

        return forces_text(self.content)

    def plots(self) -> Plots:
        """Return forces over the angle, polar plots and orders."""
        drawn = _plots(self.found, self.engines, self.engines["as the file is"], list(self.factors))
        mounts = self.content.mounts
        return Plots(drawn if mounts is ABSENT else {**drawn, **_mount_plots(mounts)})


FACTORS_ON_MOUNTS = (-0.5, 1.5)
"""Balance factors on mounts: below 0 the crank is underbalanced on purpose, above 1 overbalanced."""


@documented
def forces(
    job: JobSource,
    crank: Crank | None = None,
    *,
    settings: Sequence[str] = (),
    speed_rpm: float | None = None,
    factors: Sequence[float] = (0.0, 0.25, 0.5, 0.75, 1.0),
    transverse_weight: float = 1.0,
    reference_z_mm: float | None = None,
    mounts: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> ForcesResult:
    """Return the inertia forces of an engine: shaking forces by order, pin and bearing loads, each factor.

    Parameters
    ----------
    job : Job, path or dict
        Job file, or a crank file with options for the job's keys; engine.rod_length_mm is required.
    speed_rpm : float or None
        Crank speed [rpm]; None: the job's balance.speed_rpm. Required with a crank file.
    factors : sequence of float
        Balance factors to compare, each 0 to 1; on mounts -0.5 to 1.5, where under- and overbalance mean
        something.
    transverse_weight : float
        Weight of force across cylinder 1 against force along it: ratio of their effects on the mount.
    reference_z_mm : float or None
        Place on the axis that moments are taken about, z in the rotor frame [mm]; None: the middle of the
        outermost main journals.
    mounts : bool
        Compute the engine on its mounts too: `[mounts]` of the job.
    **options
        With a crank file in place of the job, keys of the job as for ``balance``.

    Raises
    ------
    UsageError
        If a number is impossible.
    AutobalanceError
        For anything wrong with the job or the crank.

    Examples
    --------
    First orders of an inline-four cancel, second ones add up:

    >>> import autobalance as ab
    >>> crank = ab.generate("inline-4", segments=24).crank
    >>> job = {"engine": {"rod_length_mm": 140.0, "layout": {"bank_deg": [0.0]},
    ...                   "rotating_g": {"big_end": 300.0}, "reciprocating_g": {"piston": 400.0}},
    ...        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
    ...        "correction": {"method": "drill"}}
    >>> orders = forces(job, crank).report["states"][1]["force"]["orders"]
    >>> {each["order"]: round(each["greatest_force_n"]) for each in orders if each["order"] in (1, 2)}
    {1.0: 0, 2.0: 8548}
    """
    if not 0.0 <= transverse_weight < float("inf"):
        raise UsageError(f"--transverse-weight is {transverse_weight:g}; must be ≥ 0")
    least, most = FACTORS_ON_MOUNTS if mounts else (0.0, 1.0)
    if not all(least <= factor <= most for factor in factors):
        listed = ",".join(f"{factor:g}" for factor in factors)
        raise UsageError(f"--factors is {listed!r}; each must be {least:g} to {most:g}")
    if reference_z_mm is not None:
        place_mm("--reference-z", reference_z_mm)
    if is_crank(job) and speed_rpm is not None:
        options = {**options, "speed_rpm": speed_rpm}
    speed_open = () if speed_rpm is None else ("balance.speed_rpm",)
    case = request(
        job_given("forces", job, options, settings, more_open=speed_open), crank, speed_rpm, progress
    )
    as_file = engine_from_job.as_measured(case.job, case.crank)
    engines = {"as the file is": as_file}
    if case.target is not None:
        engines["balanced"] = engine_from_job.balanced_to(as_file, case.job, case.crank.anatomy, case.target)
    known = (case.present, case.target)
    ends = engine_from_job.shaft_ends_mm(case.crank.anatomy)
    reference = engine_from_job.moment_reference_mm(case.crank.anatomy, reference_z_mm)
    states = [
        _state(name, engine, factor, case, reference)
        for (name, engine), factor in zip(engines.items(), known, strict=False)
    ]
    compared = sorted({*factors, *([] if case.target is None else [case.target])})
    advice = advise(as_file, case.speed_rad_s, compared, transverse_weight, ends, reference)
    report = ForcesReport(
        **job_keys(case.job),
        present=case.present,
        speed_rpm=case.speed_rpm,
        moments_about_z_mm=reference,
        cylinders=dead_centres(as_file),
        first_order_counterweight=first_order_counterweight(as_file),
        roll=roll_of(as_file, case.speed_rad_s),
        states=states,
        factors=advice,
        mounts=_mounted(case, as_file, compared, reference, known[0]) if mounts else ABSENT,
        warnings=case.warnings,
    )
    return ForcesResult(report, case, engines, tuple(compared))


def _mounted(
    case: Request,
    as_file: Engine,
    factors: Sequence[float],
    reference_mm: float,
    own_factor: float | None,
) -> MountedAnalysis:
    """Return the engine on its mounts, by factor; with its balance shafts, and gas if it has a cycle."""
    from autobalance.engines.mounts.mounted_engine import (
        Present,
        Pulls,
        Torque,
        analysed,
        inertia_torque,
        no_pulls,
    )

    held = case.job.table(Mounts)
    if held is None:
        raise JobError(
            f"{case.job.path.name}: [mounts] is missing; --mounts needs the engine's mass and mounts"
        )
    held = held.held_by_frame(case.job.path.parent)
    torque: Torque = inertia_torque(as_file)
    pulls: Pulls = no_pulls
    cycle = case.job.table(Cycle)
    if cycle is not None:
        from autobalance.engines.cycle.analysis import throw_torques
        from autobalance.engines.cycle.drive import pull_orders

        torques = throw_torques(case.job, case.crank)

        def fired(speed: float) -> dict[float, complex]:
            total = torques.at_speed(speed).sum(axis=1)
            return {float(n): complex(each) for n, each in zip(torques.orders, total, strict=True)}

        torque = fired
        pulls = pull_orders(
            cycle.drives, torques.mean_n_m, fired, torques.inertia_g_mm2, clockwise=as_file.clockwise
        )
    return analysed(
        held,
        lambda factor: engine_from_job.balanced_to(as_file, case.job, case.crank.anatomy, factor),
        torque,
        factors,
        engine_from_job.shafts_beside(as_file, case.job, reference_mm),
        pulls,
        Present(as_file, own_factor, case.factor, case.job.path.parent),
    )


def _state(
    name: str, engine: Engine, factor: float | None, case: Request, reference_mm: float
) -> EngineState:
    force = shaking_force(engine, case.speed_rad_s)
    return EngineState(
        name=name,
        balance_factor=factor,
        force=replace(force, orders=tuple(about(force.orders, reference_mm))),
        with_shafts=_with_shafts(engine, case, reference_mm) if case.job.shafts else ABSENT,
        loads=inertia_loads(
            engine, engine_from_job.mains_z_mm(case.crank.anatomy), case.speed_rad_s, reference_mm
        ),
    )


def _with_shafts(engine: Engine, case: Request, reference_mm: float) -> WithShafts:
    """Return the orders and the roll with the job's balance shafts."""
    speed, angle = case.speed_rad_s, whole_turn(ANGLES)
    shafts = engine_from_job.shafts_beside(engine, case.job, reference_mm)
    highest = max([highest_order(engine), *(each.order for each in shafts)])
    orders = orders_with_shafts(engine.orders(speed, highest), shafts, speed)
    roll = momentum_roll_n_m(engine, angle, speed) + roll_moment_n_m(shafts, angle, speed)
    return WithShafts(
        orders=about(orders, reference_mm),
        greatest_roll_besides_torque_n_m=float(abs(roll).max()),
    )


def _mount_plots(mounts: MountedAnalysis) -> Drawn:
    """Draw the velocity of each named place, or of the centre, over the speed by factor."""
    from autobalance.report import plots

    speeds = mounts.speeds_rad_s / RAD_S_PER_RPM
    names = list(mounts.best_factor_for) or ["centre"]
    drawn: dict[str, Plot] = {}
    for number, name in enumerate(names, 1):
        curves = [
            plots.Curve(
                f"factor {row.factor:g}",
                speeds,
                next(place.velocity_rms_mm_s for place in row.places if place.name == name),
            )
            for row in mounts.responses
        ]
        if mounts.as_the_file_is is not ABSENT:
            (now,) = [place for place in mounts.as_the_file_is.places if place.name == name]
            curves.append(plots.Curve("as the file is", speeds, now.velocity_rms_mm_s))
        labels = ("speed [1/min]", "velocity, RMS of all orders [mm/s]")
        drawn[f"mounts-{number}"] = plots.lines(f"On its mounts: {name}", labels, curves)
    return {**drawn, **_order_plots(mounts, names), **_transmission_plots(mounts)}


def _transmission_plots(mounts: MountedAnalysis) -> Drawn:
    """Draw the transmissibility of orders 1 and 2 to each mount over the speed, of the last state."""
    from autobalance.report import plots

    speeds, drawn = mounts.speeds_rad_s / RAD_S_PER_RPM, {}
    for order in (1.0, 2.0):
        curves = [
            plots.Curve(f"mount {mount.number}", speeds, row.transmissibility)
            for state in mounts.orders[-1:]
            for mount in state.mounts
            for row in mount.orders
            if row.order == order and row.transmissibility is not None
        ]
        if curves:
            labels = ("speed [1/min]", "force over the shaking force [-]")
            title = f"Transmissibility of order {order:g}, {mounts.orders[-1].name}"
            drawn[f"mounts-transmissibility-order-{order:g}"] = plots.lines(title, labels, curves)
    return drawn


def _order_plots(mounts: MountedAnalysis, names: Sequence[str]) -> Drawn:
    """Draw the orders 1 and 2 of each place by axis over the speed, before and after, and measured ones."""
    from autobalance.report import plots

    speeds = mounts.speeds_rad_s / RAD_S_PER_RPM
    drawn: dict[str, Plot] = {}
    for number, name in enumerate(names, 1):
        for order in (1.0, 2.0):
            curves = [
                plots.Curve(f"{row.axis}, {state.name}", speeds, row.acceleration_m_s2)
                for state in mounts.orders
                for place in state.places
                if place.name == name
                for row in place.orders
                if row.order == order
            ]
            curves += [
                plots.Curve(
                    f"{row.axis}, measured",
                    np.array([row.speed_rpm]),
                    np.array([row.acceleration_m_s2]),
                    measured=True,
                )
                for row in mounts.measured
                if row.point == name and row.order == order
            ]
            if curves:
                labels = ("speed [1/min]", "acceleration, peak [m/s²]")
                title = f"On its mounts: order {order:g} of {name}"
                drawn[f"mounts-{number}-order-{order:g}"] = plots.lines(title, labels, curves)
    return drawn


def _plots(case: Request, engines: dict[str, Engine], engine: Engine, factors: list[float]) -> Drawn:
    from autobalance.report import plots

    speed = case.speed_rad_s
    at = f"at {case.speed_rpm:g} rpm"
    shaking = {name: shaking_force(each, speed) for name, each in engines.items()}
    angle = next(iter(shaking.values())).angle_rad
    curves = {}
    for name, force in shaking.items():
        curves[f"along cylinder 1, {name}"] = force.force_n[:, 0]
        curves[f"across, {name}"] = engine.shown(force.force_n)[:, 1]
    by_factor = {
        factor: engine.shown(shaking_force(engine.with_counterweights(factor), speed).force_n)
        for factor in factors
    }
    labels = ("force along cylinder 1 [N]", "force across [N]")
    whole = [order.order for order in next(reversed(shaking.values())).orders if order.order % 1.0 == 0.0]
    heights = {
        name: [order.greatest_force_n for order in force.orders if order.order % 1.0 == 0.0]
        for name, force in shaking.items()
    }
    drawn = {
        "force-over-angle": plots.over_angle(f"Shaking force {at}", "force [N]", angle, curves),
        "force-polar": plots.polar(
            f"Shaking force by balance factor {at}",
            labels,
            [
                plots.Curve(f"factor {factor:g}", force[:, 0], force[:, 1])
                for factor, force in by_factor.items()
            ],
        ),
        "orders": plots.bars(f"Shaking force by order {at}", "maximum force [N]", whole, heights),
    }
    mains = engine_from_job.mains_z_mm(case.crank.anatomy)
    if len(mains) < 2:
        return drawn
    name, shown = next(reversed(engines.items()))
    loads = turn_loads(shown, mains, speed)
    axes = ("load along x [N]", "load along y [N]")
    drawn["main-bearings-polar"] = plots.polar(
        f"Main bearings, engine's frame, {at}",
        axes,
        [plots.Curve(f"main {n}", *engine.shown(load).T) for n, load in enumerate(loads.main_n, 1)],
    )
    drawn["wrist-pins-polar"] = plots.polar(
        f"Wrist pins, engine's frame, {at}",
        axes,
        [plots.Curve(f"cylinder {n}", *engine.shown(load).T) for n, load in enumerate(loads.wrist_pin_n, 1)],
    )
    drawn["crankpins-polar"] = plots.polar(
        f"Crankpins, crank's frame, {at}",
        axes,
        [
            plots.Curve(f"cylinder {n}", *engine.shown(load).T)
            for n, load in enumerate(loads.crankpin_in_crank_frame_n(), 1)
        ],
    )
    drawn["torque-over-angle"] = plots.over_angle(
        f"Inertia torque {at}", "torque [N·m]", angle, {name: loads.torque_n_m}
    )
    return drawn
