"""A cycle as lines to read, from its JSON values."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.report.tables import table
from autobalance.types import Values


def cycle_text(report: Values) -> str:
    """Return the summary of ``cycle``: cylinders, torque, speed, loads, and the effect of each factor."""
    blocks = [
        f"{report['input']['file']}: {report['strokes']}-stroke cycle at {report['speed_rpm']:g} rpm",
        _cylinders(report),
        _torque(report),
        _speed(report["speed"]),
        _loads(report["loads"]),
        _factors(report["factors"]),
        _counterweights(report["counterweights"]),
        _key_figures(report["key_figures"]),
    ]
    if report.get("sweep"):
        blocks.append(_sweep(report["sweep"]))
    if report.get("films") is not None:
        blocks.append(_films(report["films"]))
    if report.get("flexible") is not None:
        blocks.append(_flexible(report["flexible"]))
    if report.get("pendulum") is not None:
        blocks.append(_pendulum(report["pendulum"]))
    return "\n\n".join(blocks)


def number(value: float | None, text: str, unit: str = "") -> str:
    """Return a number in a format, with its unit; a dash for None."""
    return "-" if value is None else f"{value:{text}}{unit}"


def _cylinders(report: Values) -> str:
    rows: list[Sequence[str]] = [
        ("Cylinder", "fires at", "work", "imep", "peak", "at", "efficiency", "hottest")
    ]
    for each, fires in zip(report["cylinders"], report["firing_deg"], strict=True):
        efficiency = each["thermal_efficiency"]
        rows.append(
            (
                f"  {each['number']}",
                f"{fires:.1f}°",
                f"{each['work_J']:.1f} J",
                f"{each['imep_bar']:.2f} bar",
                f"{each['peak_pressure_bar']:.1f} bar",
                f"{each['peak_angle_deg']:.1f}°",
                number(None if efficiency is None else 100.0 * efficiency, ".1f", " %"),
                number(each["peak_temperature_K"], ".0f", " K"),
            )
        )
    scatter = report["cylinder"]["imep_scatter_bar"]
    spread = (
        "" if scatter is None else f"\n  imep of the trace's cycles: standard deviation {scatter:.3f} bar"
    )
    return table(rows) + spread


def _torque(report: Values) -> str:
    torque = report["torque"]
    parts = (("gas", "gas_mean_N_m"), ("friction", "friction_mean_N_m"), ("inertia", "inertia_mean_N_m"))
    means = ", ".join(f"{name} {torque[key] + 0.0:.2f}" for name, key in parts)
    lines = [
        f"Torque: mean {torque['mean_N_m']:.2f} N·m ({means}), {torque['least_N_m']:.1f} to"
        f" {torque['greatest_N_m']:.1f} N·m; {report['power_W'] / 1e3:.2f} kW"
    ]
    rows: list[Sequence[str]] = [("  Order", "gas", "inertia", "total", "phase")]
    for order in torque["orders"]:
        cells = [f"{order[key]:.2f} N·m" for key in ("gas_N_m", "inertia_N_m", "total_N_m")]
        rows.append((f"  {order['order']:g}", *cells, f"{order['phase_deg']:.1f}°"))
    return "\n".join([*lines, table(rows)])


def _speed(speed: Values) -> str:
    if speed["fluctuation"] is None:
        first = "Speed: the crank would come to a stop within a cycle; it needs a flywheel"
    else:
        first = (
            f"Speed over the cycle: {speed['least_rpm']:.1f} to {speed['greatest_rpm']:.1f} rpm, fluctuation"
            f" {speed['fluctuation']:.4f}"
        )
    lines = [first]
    if speed["flywheel_needed_kg_mm2"] is not None:
        lines.append(f"  flywheel for the fluctuation wanted: {speed['flywheel_needed_kg_mm2']:.1f} kg·mm²")
    lines.append(
        f"  mean inertia {speed['inertia_mean_kg_mm2']:.1f} kg·mm²; unloaded it gains"
        f" {speed['acceleration_rad_s2']:.0f} rad/s²"
    )
    if speed["run_up"] is not None:
        first_row, last = speed["run_up"][0], speed["run_up"][-1]
        lines.append(
            f"  free run-up from {first_row['speed_rpm']:.0f} to {last['speed_rpm']:.0f} rpm:"
            f" {last['time_s']:.3f} s"
        )
    return "\n".join(lines)


LOADS = (
    ("crankpins", "crankpin"),
    ("big_ends", "big end of cylinder"),
    ("wrist_pins", "wrist pin of cylinder"),
    ("piston_walls", "wall of cylinder"),
    ("main_journals", "main journal"),
)

CARRIED = {"knuckle pin": "knuckle pin of cylinder", "no bearing": "master rod without its links, cylinder"}
"""Names of what carries a rod in an articulated engine."""


def _loads(loads: Values) -> str:
    rows: list[Sequence[str]] = [("Load over the cycle", "greatest", "at", "mean")]
    for key, name in LOADS:
        for row in loads[key]:
            cells = f"{row['greatest_N']:.0f} N", f"{row['at_deg']:.1f}°", f"{row['mean_N']:.0f} N"
            rows.append((f"  {CARRIED.get(row.get('on', ''), name)} {row['number']}", *cells))
    return table(rows)


def _factors(factors: Sequence[Values]) -> str:
    head = ("Balance factor (ideal crank)", "greatest main", "mean main", "friction", "least film")
    rows: list[Sequence[str]] = [head]
    for row in factors:
        rows.append(
            (
                f"  {100.0 * row['factor']:g} %",
                f"{row['greatest_main_N']:.0f} N",
                f"{row['mean_main_N']:.0f} N",
                f"{row['friction_mean_N_m']:.3f} N·m",
                _micrometres(row.get("least_film_mm")),
            )
        )
    return table(rows)


def _sweep(points: Sequence[Values]) -> str:
    head = ("Speed", "factor", "greatest main", "mean main", "friction", "torque", "least film")
    rows: list[Sequence[str]] = [head]
    for row in points:
        rows.append(
            (
                f"  {row['speed_rpm']:.0f} rpm",
                f"{100.0 * row['factor']:g} %",
                f"{row['greatest_main_N']:.0f} N",
                f"{row['mean_main_N']:.0f} N",
                f"{row['friction_mean_N_m']:.3f} N·m",
                f"{row['torque_mean_N_m']:.2f} N·m",
                _micrometres(row["least_film_mm"]),
            )
        )
    return table(rows)


def _counterweights(proposals: Sequence[Values]) -> str:
    head = ("Counterweight of least reaction", "anywhere", "at", "leaves", "opposite", "leaves", "factor")
    rows: list[Sequence[str]] = [head]
    for row in proposals:
        rows.append(
            (
                f"  throw {row['throw']}",
                f"{row['unbalance_g_mm']:.0f} g·mm",
                f"{row['angle_deg']:.1f}°",
                f"{row['greatest_N']:.0f} N",
                f"{row['opposite_g_mm']:.0f} g·mm",
                f"{row['opposite_greatest_N']:.0f} N",
                number(row["opposite_factor"], ".3f"),
            )
        )
    return table(rows)


def _key_figures(figures: Values) -> str:
    rows: list[Sequence[str]] = [("Key figures", "throttle response", "greatest speed", "greatest torque")]
    for key, name in (
        ("factor", "factor"),
        ("inertia", "inertia ×"),
        ("reciprocating_mass", "reciprocating ×"),
    ):
        for row in figures[key]:
            rows.append(
                (
                    f"  {name} {row['factor' if key == 'factor' else 'share']:g}",
                    f"{row['acceleration_rad_s2']:.0f} rad/s²",
                    number(row["greatest_speed_rpm"], ".0f", " rpm"),
                    f"{row['greatest_torque_N_m']:.2f} N·m",
                )
            )
    return table(rows)


def _films(films: Values) -> str:
    rows: list[Sequence[str]] = [("Oil film over the cycle", "least", "at", "eccentricity", "friction")]
    for key, name in (("main_journals", "main journal"), ("big_ends", "big end of cylinder")):
        for row in films[key] or []:
            rows.append(
                (
                    f"  {name} {row['number']}" + (f", {row['limit']}" if row["limit"] else ""),
                    number(
                        None if row["least_film_mm"] is None else 1e3 * row["least_film_mm"], ".2f", " µm"
                    ),
                    number(row["at_deg"], ".0f", "°"),
                    number(row["greatest_eccentricity_ratio"], ".4f"),
                    number(row["mean_friction_N_m"], ".3f", " N·m"),
                )
            )
    return table(rows)


def _flexible(flexible: Values) -> str:
    bare = flexible["without_counterweights"]
    last = () if bare is None else ("without counterweights",)
    films = flexible["main_journals"][0]["stiffness_N_mm"] is None
    head = "Bends, in films" if films else "Bends, on springs"
    rows: list[Sequence[str]] = [(head, "greatest load", "at", "mean", "rigid", "orbit up to", *last)]
    for place, each in enumerate(flexible["main_journals"]):
        rows.append(
            (
                _on(each),
                f"{each['greatest_N']:.0f} N",
                f"{each['at_deg']:.1f}°",
                f"{each['mean_N']:.0f} N",
                f"{each['rigid_greatest_N']:.0f} N",
                f"{each['greatest_orbit_um']:.1f} µm",
                *(() if bare is None else (f"{bare['main_journals'][place]['greatest_N']:.0f} N",)),
            )
        )
    webs: list[Sequence[str]] = [("Web", "throw", "bending moment", *last)]
    for place, each in enumerate(flexible["webs"]):
        others = () if bare is None else (_moments(bare["webs"][place]),)
        webs.append((f"{each['web']}", f"{each['throw']}", _moments(each), *others))
    off = f"Main loads differ by up to {100.0 * flexible['rigid_difference']:.3g} % from a rigid crank's"
    blocks = [f"{table(rows)}\n{off}", table(webs)]
    if flexible["shafts"]:
        shafts: list[Sequence[str]] = [("Twists between", "twist", "torque")]
        for each in flexible["shafts"]:
            twist, torque = each["twist_mrad"], each["torque_N_m"]
            shafts.append(
                (
                    " and ".join(each["between"]),
                    f"{twist[0]:.3f} to {twist[1]:.3f} mrad",
                    f"{torque[0]:.1f} to {torque[1]:.1f} N·m",
                )
            )
        blocks.append(table(shafts))
    return "\n\n".join(blocks)


def _on(main: Values) -> str:
    """Return a main journal with its spring, film or limit."""
    if main["stiffness_N_mm"] is not None:
        return f"main {main['number']}, {main['stiffness_N_mm']:g} N/mm"
    film = "film " + _micrometres(main["least_film_mm"])
    return f"main {main['number']}, {main['limit'] or film}"


def _moments(web: Values) -> str:
    low, high = web["bending_N_m"]
    return f"{low:.1f} to {high:.1f} N·m"


def _micrometres(film_mm: float | None) -> str:
    return number(None if film_mm is None else 1e3 * film_mm, ".2f", " µm")


def _pendulum(figures: Values) -> str:
    mass = number(figures["mass_g"], ".1f", " g")
    return (
        f"Pendulum for order {figures['order']:g}, {figures['path']} path: {figures['length_mm']:.3f} mm long"
        f" on {figures['distance_mm']:g} mm, {mass} for {100.0 * figures['reduction']:g} % of"
        f" {number(figures['torque_N_m'], '.2f')} N·m at {figures['swing_deg']:g}°; its order there is"
        f" {figures['order_at_swing']:.4f}"
    )
