"""The page's tables of forces and of bearing loads with gas."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from autobalance.report.page.cells import cell
from autobalance.wording import at, escape, number

Report = Mapping[str, Any]
NOTHING = 0.05
"""Forces [N] and moments [N·m] of orders below it are shown as 0.0, and are left out."""


def forces(report: Report) -> str:
    """Return the forces before and after, once the report has them: one row for each number in both."""
    forces = report.get("forces")
    if not isinstance(forces, Mapping) or not all(
        isinstance(forces.get(k), Mapping) for k in ("before", "after")
    ):
        return ""
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th>'
        f"{cell(report, f'forces.before.{path}', 1)}{cell(report, f'forces.after.{path}', 1)}</tr>"
        for path, name in _force_rows(forces["before"])
        if _is_told(at(report, f"forces.before.{path}"), at(report, f"forces.after.{path}"), path)
    )
    if not rows:
        return ""
    speed = number(report["tolerance"]["speed_rpm"], 0)
    return f"""<section aria-labelledby="h-forces"><h2 id="h-forces">Forces at {speed} rpm</h2>
<p class="lead">Shaking forces in N, moments in N·m. x runs along the first cylinder, y across it.</p>
<div class="scroll"><table><thead><tr><th scope="col"></th><th scope="col">Before</th><th scope="col">After</th></tr></thead>
<tbody>{rows}</tbody></table></div></section>"""


def _is_told(before: float | None, after: float | None, path: str) -> bool:
    """Return whether a row is there in both, and is no order that is zero in both."""
    if before is None or after is None:
        return False
    return not path.startswith("orders.") or max(abs(before), abs(after)) >= NOTHING


def loads_with_gas(report: Report) -> str:
    """Return the loads of the mains with gas, where the job has a cycle."""
    loads = report.get("loads_with_gas")
    if loads is None:
        return ""
    rows = ""
    for k, main in enumerate(loads["after"]["main_journals"]):
        cells = "".join(
            cell(report, f"loads_with_gas.{state}.main_journals.{k}.{key}", 0)
            for key in ("greatest_N", "mean_N")
            for state in ("before", "after")
        )
        rows += f'<tr><th scope="row">Main journal {main["number"]}</th>{cells}</tr>'
    frictions = "".join(
        cell(report, f"loads_with_gas.{state}.friction_mean_N_m", 3) for state in ("before", "after")
    )
    rows += f'<tr><th scope="row">Mean friction, N·m</th><td></td><td></td>{frictions}</tr>'
    speed = number(loads["speed_rpm"], 0)
    return f"""<section aria-labelledby="h-gas"><h2 id="h-gas">Main bearings with gas at {speed} rpm</h2>
<p class="lead">Greatest and mean load over the working cycle, in N.</p>
<div class="scroll"><table><thead><tr><th scope="col"></th><th scope="col">Greatest before</th>
<th scope="col">Greatest after</th><th scope="col">Mean before</th><th scope="col">Mean after</th></tr></thead>
<tbody>{rows}</tbody></table></div></section>"""


def _force_rows(forces: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Return the place of each number that is shown, and its name."""
    for key, name in FORCES.items():
        if key in forces:
            yield key, name
    for k, order in enumerate(forces.get("orders", [])):
        for key, name in ORDER_FORCES.items():
            yield f"orders.{k}.{key}", f"Order {order['order']:g}: {name}"


FORCES = {
    "greatest_n": "Greatest force, N",
    "greatest_inline_n": "Greatest force along x, N",
    "greatest_transverse_n": "Greatest force along y, N",
}
ORDER_FORCES = {
    "force_x_n": "along x, N",
    "force_y_n": "along y, N",
    "greatest_force_n": "greatest, N",
    "greatest_moment_n_m": "greatest moment, N·m",
}
