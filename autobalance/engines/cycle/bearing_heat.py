"""Steady temperature of the main bearings: heat of friction leaves through the block and with the oil.

Friction is that of the oil films' orbits (``[cycle.film]``), whose viscosity follows the temperature, or
Coulomb's without them. A film's own flow is that of a short bearing whose journal moves at ė: what leaves
where the pressure is positive, 2 R L |ė − ½ Ω ẑ × e|, its mean over the cycle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from autobalance.balancing.measured import Crank
from autobalance.declare import MM3_S, NewtonMetres, NotNegative, Ordinal, Positive, record
from autobalance.engines.bearings.fed_states import HOTTEST_C, HeatPath, steady_temperature_C
from autobalance.engines.bearings.film import JournalBearing, petroff_moment_N_m
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import FactorMainLoads
from autobalance.engines.cycle.films import Bearings, main_bearings, orbits_of
from autobalance.engines.cycle.model import Cycle, MainHeat, table_of
from autobalance.engines.cycle.section import CycleSection
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.types import Array, Complex
from autobalance.units import M_PER_MM, N_M_PER_N_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

TEMPERATURES = 5
"""Number of temperatures of each main at which all films are followed, at once."""
BEYOND = 1.5
"""Range of the temperatures beyond the balance of a centred journal, over its own rise."""
LEAST_SPAN_K = 10.0
WIDENED = 3
"""Largest number of times that their range is moved up to hold the balance."""


@record
class MainBearingHeat:
    """A main bearing in its steady state; nulls where its film breaks before the heat balances."""

    number: Ordinal
    temperature_C: float | None
    viscosity_Pa_s: Positive | None
    friction_n_m: NewtonMetres | None
    power_W: float | None
    to_block_W: float | None
    to_oil_W: float | None
    flow_m3_s: Annotated[float | None, MM3_S]
    least_film_mm: NotNegative | None
    limit: Literal["no balance"] | None


@record
class CycleHeat:
    """Steady temperatures of the main bearings.

    ``given_friction_N_m`` is the friction at the job's own viscosity. ``energy_error`` is the power that does
    not leave, over all of it. ``interpolation_error`` is the relative error of a friction without one of the
    temperatures at which the films were followed.
    """

    main_journals: Sequence[MainBearingHeat]
    friction_n_m: NewtonMetres | None
    given_friction_n_m: NewtonMetres | None
    power_W: float | None
    energy_error: NotNegative | None
    interpolation_error: NotNegative | None


@dataclass(frozen=True, eq=False)
class HeatedMains:
    """Main bearings at temperatures (k,): friction, flow, minimum film; NaN where a film breaks.

    ``given_N_m`` is the friction of all at the viscosity of the job, ``off`` the largest relative change of a
    friction if one of the temperatures is left out.
    """

    celsius: Array
    moment_N_m: Array
    flow_m3_s: Array
    least_film_m: Array
    given_N_m: float
    off: float
    heat: MainHeat
    speed_rad_s: float

    @property
    def power_W(self) -> Array:
        return self.moment_N_m * self.speed_rad_s

    def path(self, main: int) -> HeatPath:
        """Return the heat path of a main."""
        return _path(self.heat, float(self.flow_m3_s[main]))


def _path(heat: MainHeat, flow_m3_s: float) -> HeatPath:
    carried = 0.0 if heat.supply_C is None else flow_m3_s * heat.oil.density_kg_m3 * heat.heat_capacity_J_kg_K
    return HeatPath(1.0, heat.conductance_W_K, heat.ambient_C, carried, heat.supply_C or 0.0)


def heated_mains(cycle: CycleAnalysis, job: Job, crank: Crank) -> HeatedMains:
    """Return the main bearings at the temperatures at which their heat balances."""
    table = table_of(job)
    assert table.heat is not None
    heat, speed = table.heat, cycle.speed_rad_s
    if table.film is None:
        return _dry(cycle, heat)
    loads = FactorMainLoads.of(cycle.firing)
    films = _Films(
        cycle,
        main_bearings(crank.anatomy, table.film),
        loads.parts.mains_n(speed, loads.parts.crank_n),
        heat,
        table.film.viscosity_pa_s,
    )
    return films.balanced()


def _dry(cycle: CycleAnalysis, heat: MainHeat) -> HeatedMains:
    """Return dry mains: their friction is independent of temperature, and the only oil is the given flow."""
    size = np.hypot(cycle.loads.main_n[..., 0], cycle.loads.main_n[..., 1])
    lever = cycle.firing.friction.main_lever_mm(cycle.firing.main_diameters_mm)
    moments = lever * np.array([float(cycle.grid.mean(each)) for each in size]) * N_M_PER_N_MM
    flow = heat.flow_m3_s or 0.0
    path = _path(heat, flow)
    found = [_constant(path, float(each) * cycle.speed_rad_s) for each in moments]
    celsius = np.array([np.nan if each is None else each for each in found])
    nothing, flows = np.full(len(celsius), np.nan), np.full(len(celsius), flow)
    return HeatedMains(celsius, moments, flows, nothing, float(moments.sum()), 0.0, heat, cycle.speed_rad_s)


def _constant(path: HeatPath, power_W: float) -> float | None:
    """Return the steady temperature under a power that is independent of temperature."""
    return steady_temperature_C(path, lambda _: power_W)


@dataclass(frozen=True, eq=False)
class _Films:
    """Oil films of the mains under their loads (k, n) at any temperatures."""

    cycle: CycleAnalysis
    bearings: Bearings
    force_n: Complex
    heat: MainHeat
    given_Pa_s: float

    @property
    def journals(self) -> list[JournalBearing]:
        sizes = self.bearings.diameter_mm, self.bearings.length_mm, self.bearings.clearance_mm
        return [JournalBearing(*(M_PER_MM * float(each) for each in own)) for own in zip(*sizes, strict=True)]

    def balanced(self) -> HeatedMains:
        """Return the mains where heat made and lost are one.

        The films are followed at a few temperatures of each main, all at once; between them friction, flow
        and film are curves through those points, on which the balance is exact.
        """
        low, high = self._range()
        for _ in range(WIDENED):
            celsius, figures, given = self._at_several(low, high)
            curves = [
                _curves(own, each) for own, each in zip(celsius.T, figures.transpose(2, 0, 1), strict=True)
            ]
            warm = [None if each is None else self._crossing(each) for each in curves]
            above = [each is not None and found is None for each, found in zip(curves, warm, strict=True)]
            if not any(above):
                break
            low, high = np.where(above, high, low), np.where(above, high + 3.0 * (high - low), high)
        found = np.full((4, len(warm)), np.nan)
        off = 0.0
        for main, (curve, own) in enumerate(zip(curves, warm, strict=True)):
            if curve is not None and own is not None:
                found[:, main] = own, *(float(each) for each in curve.at(own))
                off = max(off, curve.off(own))
        celsius_C, moment, flow, least = found
        return HeatedMains(celsius_C, moment, flow, least, given, off, self.heat, self.cycle.speed_rad_s)

    def _range(self) -> tuple[Array, Array]:
        """Return the temperatures between which each main's balance is sought first."""
        heat, speed = self.heat, self.cycle.speed_rad_s
        coldest = heat.ambient_C if heat.supply_C is None else min(heat.ambient_C, heat.supply_C)
        highs = []
        for each in self.journals:
            flow = 0.5 * speed * each.radius_m * each.length_m * each.clearance_m
            path = _path(heat, flow if heat.flow_m3_s is None else heat.flow_m3_s)

            def centred(celsius: float, bearing: JournalBearing = each) -> float:
                return petroff_moment_N_m(bearing, heat.oil.viscosity_Pa_s(celsius), speed) * speed

            warm = steady_temperature_C(path, centred)
            rise = (HOTTEST_C if warm is None else warm) - coldest
            highs.append(coldest + max((1.0 + BEYOND) * rise, LEAST_SPAN_K))
        return np.full(len(highs), coldest), np.minimum(highs, HOTTEST_C)

    def _at_several(self, low: Array, high: Array) -> tuple[Array, Array, float]:
        """Return temperatures (m, k), friction, flow and film there (3, m, k), and the friction as given."""
        share = 0.5 - 0.5 * np.cos(np.pi * np.arange(TEMPERATURES) / (TEMPERATURES - 1))
        celsius = low + share[:, None] * (high - low)
        count = celsius.shape[1]
        oil = self.heat.oil
        viscosity = [oil.viscosity_Pa_s(float(each)) for each in celsius.ravel()]
        figures = self._figures(np.concatenate([viscosity, np.full(count, self.given_Pa_s)]))
        given = float(figures[0, -count:].sum())
        return celsius, figures[:, :-count].reshape(3, *celsius.shape), given

    def _figures(self, viscosity_Pa_s: Array) -> Array:
        """Return friction, flow and minimum film (3, times k) of all mains for each viscosity."""
        times = len(viscosity_Pa_s) // len(self.force_n)
        sizes = self.bearings.diameter_mm, self.bearings.length_mm, self.bearings.clearance_mm
        many = Bearings(*(np.tile(each, times) for each in sizes))
        speed = self.cycle.speed_rad_s
        force = np.tile(self.force_n, (times, 1))
        orbits = orbits_of(self.cycle.firing, force, many, viscosity_Pa_s, speed)
        if self.heat.flow_m3_s is None:
            place = orbits.eccentricity[..., 0] + 1j * orbits.eccentricity[..., 1]
            step = float(orbits.angle_rad[1] - orbits.angle_rad[0])
            moving = (np.roll(place, -1, axis=0) - np.roll(place, 1, axis=0)) / (2.0 * step)
            mean = np.abs(moving - 0.5j * place).mean(axis=0)
            flow = many.diameter_mm * many.length_mm * many.clearance_mm * M_PER_MM**3 * speed * mean
        else:
            flow = np.full(len(viscosity_Pa_s), self.heat.flow_m3_s)
        broken = orbits.contact | (orbits.turns_to_settle == 0)
        return np.where(broken, np.nan, np.stack([orbits.mean_moment_N_m, flow, orbits.least_film_m]))

    def _crossing(self, curves: _Curves) -> float | None:
        """Return the temperature at which heat lost and made are one; None above those of the curves."""

        def excess(celsius: float) -> float:
            moment, flow, _ = curves.at(celsius)
            return _path(self.heat, float(flow)).lost_W(celsius) - float(moment) * self.cycle.speed_rad_s

        low, high = float(curves.celsius[0]), float(curves.celsius[-1])
        if excess(high) < 0.0:
            return None
        return low if excess(low) >= 0.0 else float(brentq(excess, low, high, xtol=1e-12, rtol=1e-14))


@dataclass(frozen=True, eq=False)
class _Curves:
    """Friction, flow and film of one main as a polynomial through their logarithms at temperatures (m,)."""

    celsius: Array
    logs: Array
    """(3, m)"""

    def at(self, celsius: float) -> Array:
        return np.asarray(np.exp(BarycentricInterpolator(self.celsius, self.logs.T)(celsius)))

    def off(self, celsius: float) -> float:
        """Return the relative error of the friction without the second last of the temperatures."""
        if len(self.celsius) < 4:
            return 1.0
        kept = np.arange(len(self.celsius)) != len(self.celsius) - 2
        fewer = _Curves(self.celsius[kept], self.logs[:, kept])
        return abs(float(fewer.at(celsius)[0] / self.at(celsius)[0]) - 1.0)


def _curves(celsius: Array, figures: Array) -> _Curves | None:
    """Return the curves through what is known (3, m) from the coldest on; None of fewer than two points."""
    known = np.isfinite(figures).all(axis=0)
    count = figures.shape[1] if known.all() else int(np.argmin(known))
    return _Curves(celsius[:count], np.log(figures[:, :count])) if count >= 2 else None


def _answer(found: HeatedMains, cycle: CycleAnalysis) -> CycleHeat:
    mains = [_main(found, number) for number in range(len(found.celsius))]
    whole = bool(np.isfinite(found.celsius).all())
    return CycleHeat(
        main_journals=mains,
        friction_n_m=float(found.moment_N_m.sum()) if whole else None,
        given_friction_n_m=found.given_N_m if np.isfinite(found.given_N_m) else None,
        power_W=float(found.power_W.sum()) if whole else None,
        energy_error=_energy_error(found) if whole else None,
        interpolation_error=found.off if whole else None,
    )


def _energy_error(found: HeatedMains) -> float:
    lost = sum(found.path(number).lost_W(float(warm)) for number, warm in enumerate(found.celsius))
    made = float(found.power_W.sum())
    return abs(made - lost) / made if made > 0.0 else 0.0


def _main(found: HeatedMains, number: int) -> MainBearingHeat:
    celsius = float(found.celsius[number])
    least = float(found.least_film_m[number])
    if not np.isfinite(celsius):
        return MainBearingHeat(
            number=number + 1, temperature_C=None, viscosity_Pa_s=None, friction_n_m=None, power_W=None,
            to_block_W=None, to_oil_W=None, flow_m3_s=None, least_film_mm=None,
            limit="no balance",
        )  # fmt: skip
    path = found.path(number)
    return MainBearingHeat(
        number=number + 1,
        temperature_C=celsius,
        viscosity_Pa_s=found.heat.oil.viscosity_Pa_s(celsius),
        friction_n_m=float(found.moment_N_m[number]),
        power_W=float(found.power_W[number]),
        to_block_W=path.conductance_W_K * (celsius - path.ambient_C),
        to_oil_W=path.flow_W_K * (celsius - path.inlet_C),
        flow_m3_s=float(found.flow_m3_s[number]) if path.flow_W_K else None,
        least_film_mm=None if np.isnan(least) else least / M_PER_MM,
        limit=None,
    )


def _text(heat: CycleHeat) -> str:
    rows: list[Sequence[str]] = [
        ("Heat of the main bearings", "temperature", "friction", "power", "to the oil", "minimum film")
    ]
    for each in heat.main_journals:
        name = f"  main journal {each.number}"
        if each.temperature_C is None or each.friction_n_m is None:
            rows.append((f"{name}, {each.limit}", "-", "-", "-", "-", "-"))
            continue
        rows.append(
            (
                name,
                f"{each.temperature_C:.1f} °C",
                f"{each.friction_n_m:.3f} N·m",
                f"{each.power_W:.0f} W",
                f"{each.to_oil_W:.0f} W",
                "-" if each.least_film_mm is None else f"{1e3 * each.least_film_mm:.2f} µm",
            )
        )
    lines = [table(rows)]
    if heat.friction_n_m is not None and heat.given_friction_n_m is not None:
        lines.append(
            f"  all: {heat.friction_n_m:.3f} N·m, {heat.power_W:.0f} W;"
            f" {heat.given_friction_n_m:.3f} N·m at the viscosity of the job"
        )
    return "\n".join(lines)


def _plots(cycle: CycleAnalysis, found: HeatedMains) -> dict[str, Plot]:
    from autobalance.report import plots

    if not np.isfinite(found.celsius).any():
        return {}
    labels = [f"main {number}" for number in range(1, len(found.celsius) + 1)]
    title = f"Steady temperature at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    bars = {"main bearings": found.celsius.tolist()}
    return {"main-temperatures": plots.named_bars(title, ("", "temperature [°C]"), labels, bars)}


def _doubts(cycle: CycleAnalysis, job: Job, found: HeatedMains) -> Iterator[str]:
    lost = [number + 1 for number, each in enumerate(found.celsius) if not np.isfinite(each)]
    if lost:
        numbers = ", ".join(map(str, lost))
        yield (
            f"{job.path.name}: no temperature balances the heat of main journal {numbers}: its film breaks "
            "before, or the heat has no way out; check cycle.heat and cycle.film"
        )


def _wanted(job: Job) -> bool:
    table = job.table(Cycle)
    return table is not None and table.heat is not None


SECTION = CycleSection(CycleHeat, heated_mains, _answer, _text, _plots, _doubts, _wanted)
