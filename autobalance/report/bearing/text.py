"""A bearing's report as lines for people; every number is taken from the report."""

from __future__ import annotations

from autobalance.types import Values

SHOWN_ROWS = 12
NAMES = {
    "dry": "Dry journal bearing",
    "hydrodynamic": "Hydrodynamic journal bearing",
    "rolling": "Rolling bearing",
    "squeeze_film": "Squeeze film between flat plates",
}
SMALL_ANGLE_MU = 0.2


def bearing_text(report: Values) -> str:
    lines = [NAMES[report["kind"]]]
    if report["limit"]:
        lines.append("Limit: the film breaks (eccentricity ratio above 0.99); values beyond it are left out")
    lines += _friction(report)
    lines += _load(report) + _oil(report["oil"]) + _film(report) + _parts(report["parts"])
    lines += _plates(report) + _orbit(report["orbit"]) + _rows(report["rows"])
    return "\n".join(lines)


def _line(name: str, value: float | None, unit: str, digits: int = 4) -> list[str]:
    return [] if value is None else [f"  {name:<34}{value:.{digits}g} {unit}".rstrip()]


def _friction(report: Values) -> list[str]:
    friction, row = report["friction"], report["rows"][0]
    if report["kind"] == "squeeze_film":
        return []
    lines = [f"Friction at {row['speed_rpm']:.6g} 1/min"]
    lines += _line("moment", friction["moment_N_m"], "N·m")
    lines += _line("power", friction["power_W"], "W")
    lines += _line("moment over load and radius", friction["coefficient"], "")
    lines += _line("moment by the small angle", friction["small_angle_N_m"], "N·m")
    lines += _line("coefficient of friction μ", friction["mu"], "")
    lines += _line("μ by the small angle", friction["mu_small_angle"], "")
    lines += _line("μ by the load of life", friction["mu_equivalent"], "(for comparison only)")
    small = friction["mu_small_angle"]
    if small is not None and small >= 1.0:
        lines.append("  No Coulomb friction gives this torque: part of it does not come from the load")
    mu = friction["mu"]
    if mu is not None and mu > SMALL_ANGLE_MU:
        lines.append("  μ is above 0.2: the small-angle form is out of its range")
    return lines


def _load(report: Values) -> list[str]:
    load = report["load"]
    if load is None:
        return []
    lines = ["Load over a turn"]
    lines += _line("mean of |F|, for friction", load["mean_N"], "N")
    lines += _line("cubic mean", load["cubic_mean_N"], "N")
    lines += _line("equivalent, for life", load["equivalent_N"], "N")
    lines += _line("f_m", load["f_m"], "")
    return lines + _line("attitude angle", report["attitude_angle_deg"], "°")


def _oil(oil: Values) -> list[str]:
    lines = _line("dynamic viscosity", oil["viscosity_Pa_s"], "Pa·s")
    lines += _line("kinematic viscosity", oil["kinematic_mm2_s"], "mm²/s")
    lines += _line("temperature", oil["temperature_C"], "°C") + _line("outlet", oil["outlet_C"], "°C")
    return ["Oil", *lines] if lines else []


def _film(report: Values) -> list[str]:
    film = report["film"]
    if film is None:
        return []
    lines = _line("load", film["load_N"], "N") + _line("eccentricity ratio", film["eccentricity_ratio"], "")
    lines += _line("attitude angle", film["attitude_angle_deg"], "°")
    lines += _line("Sommerfeld number", film["sommerfeld"], "")
    lines += _line("least film", film["least_film_mm"], "mm")
    lines += _line("greatest pressure", film["greatest_pressure_MPa"], "MPa")
    lines += _line("side flow", film["side_flow_mm3_s"], "mm³/s")
    lines += _line("Petroff's moment", report["petroff_N_m"], "N·m")
    for name, unit in (("stiffness_N_m", "N/m"), ("damping_N_s_m", "N·s/m")):
        if film[name] is not None:
            cells = ", ".join(f"{cell:.4g}" for row in film[name] for cell in row)
            lines.append(f"  {name.split('_', maxsplit=1)[0] + ' xx, xy, yx, yy':<34}{cells} {unit}")
    if film["critical_mass_kg"] is not None:
        lines += _line("oil whirl of a rigid rotor above", film["critical_mass_kg"], "kg on this bearing")
        lines += _line("at this share of the speed", film["whirl_ratio"], "")
    elif film["stiffness_N_m"] is not None:
        lines.append("  no mass of a rigid rotor makes the oil whirl")
    return ["Film", *lines] if lines else []


def _parts(parts: Values | None) -> list[str]:
    if parts is None:
        return []
    names = {"load_free_N_m": "load-free", "load_N_m": "of the load"}
    lines = [_line(names.get(key, key.removesuffix("_N_m")), value, "N·m") for key, value in parts.items()]
    return ["Parts of one bearing's moment", *(line for each in lines for line in each)]


def _plates(report: Values) -> list[str]:
    if report["stiffness_N_m"] is None:
        return []
    return [
        *_line("stiffness 3 W/H", report["stiffness_N_m"], "N/m"),
        *_line("damping, uniform pressure (source)", report["damping_source_N_s_m"], "N·s/m"),
        *_line("damping by Reynolds' equation", report["damping_N_s_m"], "N·s/m"),
    ]


def _orbit(orbit: Values | None) -> list[str]:
    if orbit is None:
        return []
    if orbit["least_film_mm"] is None:
        return ["Film through the cycle: it breaks"]
    lines = ["Film through the cycle"]
    lines += _line("least film", orbit["least_film_mm"], "mm") + _line("at", orbit["at_deg"], "°")
    lines += _line("greatest eccentricity ratio", orbit["greatest_eccentricity_ratio"], "")
    lines += _line("mean friction moment", orbit["mean_friction_N_m"], "N·m")
    if orbit["turns_to_settle"] is None:
        return [*lines, "  It does not repeat from cycle to cycle; the numbers are those of the last one"]
    return [*lines, f"  {'repeats after':<34}{orbit['turns_to_settle']} turns"]


def _rows(rows: list[Values]) -> list[str]:
    if len(rows) < 2:
        return []
    lines = ["Speed [1/min]   Moment [N·m]"]
    for row in rows[:SHOWN_ROWS]:
        moment = "the film breaks" if row["moment_N_m"] is None else f"{row['moment_N_m']:.4g}"
        lines.append(f"  {row['speed_rpm']:<14.6g}{moment}")
    more = len(rows) - SHOWN_ROWS
    return [*lines, f"  and {more} more speeds"] if more > 0 else lines
