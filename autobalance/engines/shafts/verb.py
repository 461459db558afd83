"""``shafts``: balance shafts that would cancel orders 1 and 2, and what the job's own leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from autobalance.balancing import engine_from_job
from autobalance.balancing.engine_from_job import (
    balance_shafts,
    moment_reference_mm,
    shaft_ends_mm,
    shafts_beside,
)
from autobalance.engines.forces.answer import orders_table
from autobalance.engines.forces.counterweight import ShaftWeight
from autobalance.engines.shafts.answer import (
    CoupleOfShaft,
    OrdersWith,
    OrdersWithout,
    Proposal,
    RollAmplitude,
    Shaft,
    ShaftsReport,
)
from autobalance.job import JobSource
from autobalance.job.model import BalanceShaftEntry
from autobalance.report.display_units import DisplayUnits
from autobalance.report.files import from_here
from autobalance.report.plots import Drawn, Plots
from autobalance.report.tables import table
from autobalance.running_gear.loads import centrifugal_force_n, whole_turn
from autobalance.running_gear.parts import LEAST_DIRECTION
from autobalance.running_gear.roll import (
    HIGHEST_ORDER,
    highest_order,
    momentum_roll_n_m,
    momentum_roll_orders,
)
from autobalance.running_gear.shafts import (
    BalanceShaft,
    cancelling_shafts,
    counter_rotating_shaft,
    couple_shafts,
    orders_with_shafts,
    place_of_least_moment_mm,
    roll_moment_n_m,
    roll_of_order,
    under_the_pistons,
)
from autobalance.running_gear.whole_engine import Engine, ForceOrder, about
from autobalance.runtime import Progress
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import job_keys, request
from autobalance.verbs.options import place_mm
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.engines.forces.counterweight import ShaftWeight
    from autobalance.engines.shafts.answer import RollAmplitude, Shaft, ShaftsReport
    from autobalance.verbs.crank import Crank


ROLL_ANGLES = 360


@dataclass(frozen=True, eq=False, repr=False)
class ShaftsResult(VerbResult):
    """Orders without and with shafts, and shafts that would cancel them."""

    content: ShaftsReport
    orders: tuple[ForceOrder, ...]
    left: tuple[ForceOrder, ...]

    def text(self, units: str = "metric") -> str:
        """Return tables of orders and shafts."""
        from autobalance.report.display_units import ON_SCREEN

        return shafts_text(self.content, ON_SCREEN[units])

    def plots(self) -> Plots:
        """Return bars of the orders."""
        rpm, shafts = self.content.speed_rpm, bool(self.content.shafts)
        forces = _plots(list(self.orders), list(self.left), rpm, has_shafts=shafts)
        return Plots({**forces, **_roll_plot(self.content)})


@documented
def shafts(
    job: JobSource,
    crank: Crank | None = None,
    *,
    speed_rpm: float | None = None,
    reference_z_mm: float | None = None,
    progress: Progress | None = None,
) -> ShaftsResult:
    """Return balance shafts that would cancel the first and second order, and the residual of the job's.

    Parameters
    ----------
    job : Job, path or dict
        Job file; engine.rod_length_mm is required.
    speed_rpm : float or None
        Crank speed [rpm]; None: the job's balance.speed_rpm.
    reference_z_mm : float or None
        Place on the axis that moments are taken about, z in the rotor frame [mm]; None: the middle of the
        outermost main journals.

    Raises
    ------
    UsageError
        If the speed is not positive, or the place no number.
    AutobalanceError
        For anything wrong with the job or the crank.

    Examples
    --------
    An inline-four asks for Lanchester's pair, at twice its speed:

    >>> import autobalance as ab
    >>> crank = ab.generate("inline-4", segments=24).crank
    >>> job = {"engine": {"rod_length_mm": 140.0, "layout": {"bank_deg": [0.0]},
    ...                   "rotating_g": {"big_end": 300.0}, "reciprocating_g": {"piston": 400.0}},
    ...        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
    ...        "correction": {"method": "drill"}}
    >>> asked = shafts(job, crank).report["proposals"][0]["shafts"]
    >>> [(each["order"], each["sense"], round(each["product_g_mm"])) for each in asked]
    [(2, 'forward', 2707), (2, 'backward', 2707)]
    """
    if reference_z_mm is not None:
        place_mm("--reference-z", reference_z_mm)
    case = request(job, crank, speed_rpm, progress)
    anatomy, speed = case.crank.anatomy, case.speed_rad_s
    engine = engine_from_job.with_moments(case.job, anatomy, case.crank.moments)
    engine = engine_from_job.balanced_to(engine, case.job, anatomy, case.factor)
    reference = moment_reference_mm(anatomy, reference_z_mm)
    bare = engine.orders(speed, HIGHEST_ORDER)
    own = balance_shafts(case.job, reference)
    orders = about(bare, reference)
    turned = shafts_beside(engine, case.job, reference)
    left = about(orders_with_shafts(bare, turned, speed), reference)
    angle = whole_turn(ROLL_ANGLES)
    shafts_roll = roll_moment_n_m(turned, angle, speed)
    pistons_roll = momentum_roll_n_m(engine, angle, speed)
    report = ShaftsReport(
        **job_keys(case.job),
        speed_rpm=case.speed_rpm,
        balance_factor=case.factor,
        moments_about_z_mm=reference,
        without=OrdersWithout(
            orders=orders,
            greatest_roll_n_m=float(abs(pistons_roll).max()),
            roll_orders=_roll_orders(engine, (), speed),
        ),
        proposals=_proposals(bare, engine, speed, shaft_ends_mm(anatomy)),
        shafts=[Shaft.of(shaft, _weights(entry)) for shaft, entry in zip(own, case.job.shafts, strict=True)],
        with_=OrdersWith(
            orders=left,
            greatest_roll_n_m=float(abs(pistons_roll + shafts_roll).max()),
            roll_orders=_roll_orders(engine, turned, speed),
            greatest_shaft_roll_n_m=float(abs(shafts_roll).max()),
        ),
        warnings=case.warnings,
    )
    return ShaftsResult(report, tuple(orders), tuple(left))


def _weights(shaft: BalanceShaftEntry) -> list[ShaftWeight]:
    return [
        ShaftWeight(item.name, item.eccentricity_mm, item.cad_g, item.weighed_g) for item in shaft.weights
    ]


def _proposals(
    orders: list[ForceOrder], engine: Engine, speed: float, ends_mm: tuple[float, float]
) -> list[Proposal]:
    """Return shafts for what is left of orders 1 and 2, force and couple, where more than rounding is.

    Shafts against a force are where they leaves the least of its moment; what is left then is a couple.
    """
    products = [each.reciprocating_g * each.slider_crank.crank_radius_mm for each in engine.cylinders]
    least = LEAST_DIRECTION * centrifugal_force_n(sum(products), speed)
    lever = max(ends_mm[1] - ends_mm[0], *(abs(each.z_mm) for each in engine.cylinders), 1.0)
    reach = max(
        each.slider_crank.crank_radius_mm + each.slider_crank.rod_length_mm for each in engine.cylinders
    )
    rolls = momentum_roll_orders(engine, 2)
    by_order = {order.order: order for order in orders}
    proposals: list[Proposal] = []
    for number, name in ((1.0, "first order"), (2.0, "second order")):
        order = by_order[number]
        if order.greatest_force_n > least:
            z = place_of_least_moment_mm(order)
            roll = complex(rolls[int(number)])
            shafts = [replace(shaft, z_mm=z) for shaft in cancelling_shafts(order, speed)]
            shafts = list(under_the_pistons(shafts, roll, reach))
            proposals.append(_proposal(f"all of the {name}", shafts, engine, speed))
            if number == 1.0 and order.circles_n[1] > least:
                one = [replace(counter_rotating_shaft(order, speed), z_mm=z)]
                one = list(under_the_pistons(one, roll, reach))
                proposals.append(_proposal("its backward part alone", one, engine, speed))
            (order,) = orders_with_shafts([order], shafts, speed)
        if order.greatest_moment_n_m > least * lever * 1e-3:
            pair = couple_shafts(order, speed)
            pair = tuple(each.mirrored() for each in pair) if engine.clockwise else pair
            couples = [CoupleOfShaft.of(shaft, ends_mm) for shaft in pair]
            proposals.append(
                Proposal(
                    what=f"couple of the {name}",
                    shafts=(),
                    couple_shafts=couples,
                    greatest_roll_n_m=_roll_left(engine, [], speed),
                    roll_orders=_roll_orders(engine, (), speed),
                )
            )
    return proposals


def _proposal(what: str, shafts: list[BalanceShaft], engine: Engine, speed: float) -> Proposal:
    """Return a proposal; shafts of a clockwise engine are its mirror image's."""
    shown = [each.mirrored() for each in shafts] if engine.clockwise else shafts
    return Proposal(
        what=what,
        shafts=[Shaft.of(each) for each in shown],
        greatest_roll_n_m=_roll_left(engine, shafts, speed),
        roll_orders=_roll_orders(engine, shafts, speed),
    )


def _roll_orders(engine: Engine, shafts: Sequence[BalanceShaft], speed: float) -> list[RollAmplitude]:
    """Return the orders of the roll of pistons, rods and shafts together, the torque's reaction left out."""
    highest = max([highest_order(engine), *(each.order for each in shafts)])
    rolls = momentum_roll_orders(engine, highest)
    return [
        RollAmplitude(order=n, roll_n_m=abs(complex(rolls[n]) + roll_of_order(shafts, float(n))) * speed**2)
        for n in range(1, highest + 1)
    ]


def _roll_left(engine: Engine, shafts: list[BalanceShaft], speed: float) -> float:
    """Return the largest roll of pistons, rods and shafts together, the torque's reaction left out [N·m]."""
    angle = whole_turn(ROLL_ANGLES)
    roll = momentum_roll_n_m(engine, angle, speed) + roll_moment_n_m(shafts, angle, speed)
    return float(abs(roll).max())


def _plots(orders: list[ForceOrder], left: list[ForceOrder], rpm: float, *, has_shafts: bool) -> Drawn:
    from autobalance.report import plots

    whole = [order.order for order in orders if order.order % 1.0 == 0.0]

    def heights(of: list[ForceOrder]) -> list[float]:
        return [order.greatest_force_n for order in of if order.order % 1.0 == 0.0]

    groups = {"without shafts": heights(orders)}
    if has_shafts:
        groups["with the job's shafts"] = heights(left)
    title = f"Shaking force by order at {rpm:g} rpm"
    return {"shafts-orders": plots.bars(title, "maximum force [N]", whole, groups)}


def _roll_plot(report: ShaftsReport) -> Drawn:
    """Draw the orders of the roll couple without shafts, with the job's and with each proposal, if any."""
    from autobalance.report import plots

    if report.without.greatest_roll_n_m == report.with_.greatest_roll_n_m == 0.0:
        return {}
    cases = {"without shafts": report.without.roll_orders}
    if report.shafts:
        cases["with the job's shafts"] = report.with_.roll_orders
    cases |= {f"with {each.what} cancelled": each.roll_orders for each in report.proposals if each.shafts}
    groups = {name: [each.roll_n_m for each in orders[:HIGHEST_ORDER]] for name, orders in cases.items()}
    title = f"Roll couple on the block by order at {report.speed_rpm:g} rpm, without the torque's reaction"
    orders = [float(each.order) for each in report.without.roll_orders[:HIGHEST_ORDER]]
    return {"shafts-roll-orders": plots.bars(title, "amplitude [N·m]", orders, groups)}


# Balance shafts as lines to read.


LEAST_ROLL = 0.005
"""Amplitude [N·m] from which on an order of the roll is listed."""


def shafts_text(report: ShaftsReport, units: DisplayUnits) -> str:
    """Return the summary of ``shafts``: orders that shake, proposals, and the effect of the job's shafts."""
    parts = [
        f"{from_here(report.job['file'])}: balance shafts at {report.speed_rpm:g} rpm, crank balanced to"
        f" {report.balance_factor:.4f}; moments about z = {report.moments_about_z_mm:.2f} mm",
        "Without shafts\n" + orders_table(report.without.orders),
    ]
    rows = [("Shafts that would cancel", "speed", "sense", "each", "phase", "where")]
    for offer in report.proposals:
        for shaft in offer.shafts:
            rows.append((f"  {offer.what}", *_shaft_cells(shaft, units), _where(shaft, units)))
        for pair in offer.couple_shafts:
            for each in pair.unbalances:
                cells = _turning(pair.order, pair.sense, each.product_g_mm, each.phase_deg, units)
                rows.append((f"  {offer.what}", *cells, f"z {units.of_length(each.z_mm)}"))
    parts.append(table(rows) if len(rows) > 1 else "No order that shafts could cancel is left.")
    if report.shafts:
        rows = [("Shafts of the job", "speed", "sense", "product", "phase", "where")]
        rows += [
            (f"  {number}", *_shaft_cells(shaft, units), _where(shaft, units))
            for number, shaft in enumerate(report.shafts, 1)
        ]
        lines = [table(rows)]
        for shaft in report.shafts:
            for weight in shaft.weights:
                lines.append(_bolted(weight, units))
        lines.append("Residual after the shafts\n" + orders_table(report.with_.orders))
        parts.append("\n".join(lines))
    parts.append(_shafts_roll(report))
    return "\n\n".join(parts)


def _shafts_roll(report: ShaftsReport) -> str:
    """Return the roll couple about the crank axis without shafts, with each proposal, and with the job's."""
    cases = [("without shafts", report.without.greatest_roll_n_m, report.without.roll_orders)]
    cases += [
        (f"with {offer.what} cancelled", offer.greatest_roll_n_m, offer.roll_orders)
        for offer in report.proposals
        if offer.shafts
    ]
    if report.shafts:
        cases.append(("with the job's shafts", report.with_.greatest_roll_n_m, report.with_.roll_orders))
    shown = [each for each in (1, 2, 3, 4) if any(_order(orders, each) >= LEAST_ROLL for *_, orders in cases)]
    head = ("Roll couple on the block, reaction of the torque left out", "maximum")
    rows: list[Sequence[str]] = [(*head, *(f"order {each}" for each in shown))]
    for name, greatest, orders in cases:
        amplitudes = (f"{_order(orders, each):.2f} N·m" for each in shown)
        rows.append((f"  {name}", f"{greatest:.2f} N·m", *amplitudes))
    if report.shafts:
        alone = f"{report.with_.greatest_shaft_roll_n_m:.2f} N·m"
        rows.append(("  the job's shafts alone", alone, *("" for _ in shown)))
    return table(rows)


def _order(orders: Sequence[RollAmplitude], number: int) -> float:
    return next(each.roll_n_m for each in orders if each.order == number)


def _where(shaft: Shaft, units: DisplayUnits) -> str:
    """Return the place of a shaft: along the axis, and beside it where it does not be on it."""
    along = f"z {units.of_length(shaft.z_mm)}"
    x, y = shaft.place_mm
    return along if x == y == 0.0 else f"{along}, x {units.of_length(x)}, y {units.of_length(y)}"


def _shaft_cells(shaft: Shaft, units: DisplayUnits) -> tuple[str, str, str, str]:
    return _turning(shaft.order, shaft.sense, shaft.product_g_mm, shaft.phase_deg, units)


def _turning(
    order: int, sense: str, product_g_mm: float, phase_deg: float, units: DisplayUnits
) -> tuple[str, str, str, str]:
    """Return the cells of an unbalance on a shaft."""
    return f"{order} ×", sense, units.of_unbalance(product_g_mm), f"{phase_deg:.1f}°"


def _bolted(weight: ShaftWeight, units: DisplayUnits) -> str:
    drawn = units.of_mass(weight.cad_g)
    at = units.of_length(weight.eccentricity_mm)
    if weight.weighed_g is None or weight.deviation is None:
        return f"  {weight.name}: {drawn} drawn, not weighed, at {at}"
    return (
        f"  {weight.name}: {drawn} drawn, {units.of_mass(weight.weighed_g)} weighed"
        f" ({100.0 * weight.deviation:+.2f} %), at {at}"
    )
