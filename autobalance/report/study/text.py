"""The words and tables of a study."""

from __future__ import annotations

from autobalance.types import Values


def study_text(values: Values) -> str:
    low, high = values["interval"]
    share, spread = values["probability_within"], values["spread"]
    magnitude = values["percentiles"]["magnitude_g_mm"]
    lines = [
        f"{values['within']} of {values['samples']} cranks are within tolerance: {100 * share:.2f} % "
        f"({100 * low:.2f} to {100 * high:.2f} %)",
        f"as planned {values['nominal']['magnitude_g_mm']:.3f} g·mm, permissible "
        f"{values['tolerance']['permissible_g_mm']:.3f} g·mm",
        f"residual: half below {magnitude['p50']:.3f}, 95 % below {magnitude['p95']:.3f}, "
        f"99 % below {magnitude['p99']:.3f} g·mm",
        f"spread ± {spread['linear_g_mm']:.3f} g·mm by the linear model, "
        f"± {spread['sampled_g_mm']:.3f} g·mm drawn{_check(values['linear_model'])}",
        "",
        "cause                                        ±        share",
    ]
    for cause in values["contributions"]:
        pm = f"{cause['pm']:g} {cause['unit']}"
        lines.append(f"{cause['name']:38s} {pm:>12s} {100 * cause['share']:8.1f} %")
    lines += ["", *_advice(values["advice"])]
    if values["reason"]:
        lines += ["", values["reason"]]
    return "\n".join(lines)


def _check(check: Values) -> str:
    if not check["checked"]:
        return ""
    error = check["greatest_error_g_mm"]
    return f"; {check['checked']} cranks cut and measured: off by {error:.2g} g·mm at most"


def _advice(advice: Values) -> list[str]:
    if advice["reached"]:
        return [f"{100 * advice['target']:g} % are reached."]
    lines = [f"To reach {100 * advice['target']:g} %, one cause alone:"]
    for step in advice["steps"]:
        if step["pm_needed"] is None:
            change = f"not even ±0 is enough ({100 * step['probability_within']:.2f} %)"
        else:
            change = f"±{step['pm_needed']:.3g} instead of ±{step['pm_now']:g}"
        lines.append(f"  {step['name']:38s} {change}")
    return lines
