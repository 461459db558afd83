"""Windage of the webs as a part of a cycle's report, which ``[cycle.windage]`` asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.declare import NewtonMetres, NotNegative, Ordinal, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.model import table_of
from autobalance.engines.cycle.section import CycleSection
from autobalance.engines.cycle.windage import Gas, TorqueRange, WebShape, gases_of
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Array
from autobalance.units import M_PER_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

ANGLES = 720
"""Angles at which a web's outline is looked at."""
SPEEDS = 25
"""Speeds of the plot, up to one and a half times the speed of the cycle."""


@record
class WebWindage:
    """Windage of a web, low and high end; ``face_radius_mm``: of the disc with the friction of its faces."""

    number: Ordinal
    face_radius_mm: NotNegative
    thickness_mm: NotNegative
    least_n_m: NewtonMetres
    greatest_n_m: NewtonMetres


@record
class CycleWindage:
    """Windage of all webs: an order of size with its range, and its share of friction and of the torque.

    Shares are null without friction, or without torque of the gas.
    """

    least_n_m: NewtonMetres
    greatest_n_m: NewtonMetres
    least_W: NotNegative
    greatest_W: NotNegative
    of_friction: Sequence[NotNegative] | None
    of_gas_torque: Sequence[NotNegative] | None
    webs: Sequence[WebWindage]


@dataclass(frozen=True, eq=False)
class Webs:
    """Shapes of a crank's webs and what they turn in."""

    shapes: Sequence[WebShape]
    gases: tuple[Gas, Gas]
    gap_m: float | None

    def windage(self, shape: WebShape, speed_rad_s: float) -> TorqueRange:
        """Return the range from the thin gas's low end to the thick one's high end."""
        thin, thick = (shape.windage(gas, speed_rad_s, self.gap_m) for gas in self.gases)
        return TorqueRange(thin.low_N_m, thick.high_N_m)

    def all(self, speed_rad_s: float) -> TorqueRange:
        return sum((self.windage(each, speed_rad_s) for each in self.shapes), TorqueRange(0.0, 0.0))


def webs_in_air(cycle: CycleAnalysis, job: Job, crank: Crank) -> Webs:
    """Return the webs of a crank as their outlines midway of their thickness are."""
    asked = table_of(job).windage
    assert asked is not None
    solid = crank.source.solid.moved(crank.anatomy.file_to_rotor)
    webs = crank.anatomy.webs
    middles = np.array([0.5 * (web.z_min_mm + web.z_max_mm) for web in webs])
    outlines = cross_sections(solid.mesh.vertices, solid.mesh.triangles, middles)
    shapes = [
        WebShape.of_outline(_reach_m(loops), M_PER_MM * (web.z_max_mm - web.z_min_mm))
        for web, loops in zip(webs, outlines, strict=True)
    ]
    return Webs(shapes, gases_of(asked), None if asked.gap_mm is None else M_PER_MM * asked.gap_mm)


def _reach_m(outlines: Sequence[Array]) -> Array:
    """Return the largest radius of outlines at even angles (n,), straight between their corners [m]."""
    reach = np.zeros(ANGLES)
    for outline in outlines:
        ends = np.roll(outline, -1, axis=0)
        steps = np.maximum(2, np.ceil(np.hypot(*(ends - outline).T) / 0.25)).astype(np.int64)
        points = np.concatenate(
            [
                a + np.linspace(0.0, 1.0, int(n))[:, None] * (b - a)
                for a, b, n in zip(outline, ends, steps, strict=True)
            ]
        )
        place = np.floor(np.arctan2(points[:, 1], points[:, 0]) / (2.0 * np.pi) * ANGLES).astype(np.int64)
        np.maximum.at(reach, place % ANGLES, np.hypot(*points.T))
    return M_PER_MM * reach


def _answer(webs: Webs, cycle: CycleAnalysis) -> CycleWindage:
    speed, whole = cycle.speed_rad_s, webs.all(cycle.speed_rad_s)
    friction, gas = cycle.friction_mean_n_m, cycle.firing.gas_mean_n_m
    each = [webs.windage(shape, speed) for shape in webs.shapes]
    return CycleWindage(
        least_n_m=whole.low_N_m,
        greatest_n_m=whole.high_N_m,
        least_W=whole.low_N_m * speed,
        greatest_W=whole.high_N_m * speed,
        of_friction=[whole.low_N_m / friction, whole.high_N_m / friction] if friction > 0.0 else None,
        of_gas_torque=[whole.low_N_m / gas, whole.high_N_m / gas] if gas > 0.0 else None,
        webs=[
            WebWindage(
                number=number,
                face_radius_mm=shape.face_radius_m / M_PER_MM,
                thickness_mm=shape.thickness_m / M_PER_MM,
                least_n_m=own.low_N_m,
                greatest_n_m=own.high_N_m,
            )
            for number, (shape, own) in enumerate(zip(webs.shapes, each, strict=True), 1)
        ],
    )


def _text(found: CycleWindage) -> str:
    lines = [
        f"Windage of the webs, an order of size: {found.least_n_m:.3g} to {found.greatest_n_m:.3g} N·m,"
        f" {_figures(found.least_W)} to {_figures(found.greatest_W)} W"
    ]
    for shares, name in ((found.of_friction, "the friction"), (found.of_gas_torque, "the torque of the gas")):
        if shares is not None:
            lines.append(f"  {100.0 * shares[0]:.2g} to {100.0 * shares[1]:.2g} % of {name}")
    rows: list[Sequence[str]] = [("  Web", "disc of", "minimum", "maximum")]
    for web in found.webs:
        torques = f"{web.least_n_m:.3g} N·m", f"{web.greatest_n_m:.3g} N·m"
        rows.append((f"  {web.number}", f"{web.face_radius_mm:.1f} mm", *torques))
    return "\n".join([*lines, table(rows)])


def _figures(value: float) -> str:
    """Return a number with three digits before or after its point, without powers of ten."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def _plots(cycle: CycleAnalysis, webs: Webs) -> dict[str, Plot]:
    return {"windage": windage_plot("Windage of the webs", webs.all, cycle.speed_rad_s)}


def windage_plot(title: str, range_at: Callable[[float], TorqueRange], speed_rad_s: float) -> Plot:
    """Return a plot of a windage's range by speed [rad/s], up to half as much again as the speed."""
    from autobalance.report import plots

    speeds = np.linspace(0.0, 1.5 * speed_rad_s, SPEEDS)
    found = [range_at(float(speed)) for speed in speeds]
    rpm = speeds / RAD_S_PER_RPM
    curves = [
        plots.Curve("smallest", rpm, np.array([each.low_N_m for each in found])),
        plots.Curve("largest", rpm, np.array([each.high_N_m for each in found])),
    ]
    return plots.lines(title, ("speed [1/min]", "torque [N·m]"), curves)


def _no_doubts(cycle: CycleAnalysis, job: Job, webs: Webs) -> Iterator[str]:
    return iter(())


def _wanted(job: Job) -> bool:
    return table_of(job).windage is not None


SECTION = CycleSection(CycleWindage, webs_in_air, _answer, _text, _plots, _no_doubts, _wanted)
