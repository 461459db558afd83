"""Pages in HTML from the templates in ``assets/templates``: their numbers and rows."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from autobalance.report.display_units import (
    PAGE_UNITS,
    heavy_at,
    in_units,
    inertia_unit,
    length,
    mass,
    pointing,
    shown,
    unbalance,
)
from autobalance.types import Values
from autobalance.wording import at, degrees, number, signed

# Pages in HTML from the templates in ``assets/templates``.


SOURCE = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
"""Content-Security-Policy: a page may load nothing but its own contents."""


def rendered(template: str, **values: Any) -> str:
    """Return a template of ``assets/templates`` with values, in the units of `PAGE_UNITS`.

    Texts among the values are escaped, except ``markupsafe.Markup``.
    """
    return _environment().get_template(template).render(units=PAGE_UNITS.get(), **values)


@cache
def _environment() -> Environment:
    folder = str(resources.files("autobalance.report") / "assets" / "templates")
    environment = Environment(
        loader=FileSystemLoader(folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {
        "source": SOURCE,
        "style": style,
        "script": script,
        "number": number,
        "degrees": degrees,
        "heavy_at": heavy_at,
        "pointing": pointing,
        "length": length,
        "mass": mass,
        "unbalance": unbalance,
        "inertia_unit": inertia_unit,
    }
    environment.filters |= {"in_units": lambda text: in_units(text, PAGE_UNITS.get()), "data": data}
    return environment


@cache
def style(name: str) -> Markup:
    """Return a style sheet of ``assets`` for a page."""
    return Markup(_asset(name))


@cache
def script(name: str) -> Markup:
    """Return a script of ``assets`` that cannot end its own element."""
    return Markup(_asset(name).replace("</script", r"<\/script"))


def data(values: Any) -> Markup:
    """Return values as JSON that cannot end the script element around it."""
    text = json.dumps(values, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))


def _asset(name: str) -> str:
    return (resources.files("autobalance.report") / "assets" / name).read_text(encoding="utf-8")


# Numbers of a page, each with its path in the report.


def cell(report: Values, path: str, digits: int = 2) -> Markup:
    """Return a table cell with a number of the report and its path there."""
    value, digits = shown(at(report, path), path, digits)
    return Markup('<td data-path="{}" data-digits="{}">{}</td>').format(path, digits, number(value, digits))


def span(report: Values, path: str, digits: int = 2, sign: bool = False, style: str = "") -> Markup:
    """Return a number of the report with its path there."""
    value, digits = shown(at(report, path), path, digits)
    text = signed(value, digits) if sign else number(value, digits)
    named = Markup(' class="{}"').format(style) if style else ""
    return Markup('<span{} data-path="{}" data-digits="{}">{}</span>').format(named, path, digits, text)


# The rows of the page's table of forces.


NEGLIGIBLE_ORDER = 0.05
"""Forces [N] and moments [N·m] of orders below it would show as 0.0, and are left out."""
FORCES = {
    "greatest_n": "Maximum force [N]",
    "greatest_inline_n": "Largest force along x, N",
    "greatest_transverse_n": "Largest force along y, N",
}
ORDER_FORCES = {
    "force_x_n": "along x, N",
    "force_y_n": "along y, N",
    "greatest_force_n": "maximum [N]",
    "greatest_moment_n_m": "maximum moment [N·m]",
}


def force_rows(report: Values) -> list[tuple[str, str]]:
    """Return path and name of each force that has values before and after, without orders that are zero."""
    forces = report.get("forces") or {}
    if not all(isinstance(forces.get(state), Mapping) for state in ("before", "after")):
        return []
    return [(path, name) for path, name in _rows(forces["before"]) if _is_shown(forces, path)]


def _is_shown(forces: Mapping[str, Any], path: str) -> bool:
    before, after = at(forces, f"before.{path}"), at(forces, f"after.{path}")
    if before is None or after is None:
        return False
    return not path.startswith("orders.") or max(abs(before), abs(after)) >= NEGLIGIBLE_ORDER


def _rows(forces: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, name in FORCES.items():
        if key in forces:
            yield key, name
    for k, order in enumerate(forces.get("orders", [])):
        for key, name in ORDER_FORCES.items():
            yield f"orders.{k}.{key}", f"Order {order['order']:g}: {name}"


# Page of a command without a separate page: its printed text, with its table and plots.


def summary_page(title: str, text: str, is_good: bool, table: str = "", plots: Sequence[str] = ()) -> bytes:
    """Return a page in HTML.

    Parameters
    ----------
    title : str
        Title of the browser's window.
    text : str
        What the command prints: its first three lines, up to the first empty one, head the page.
    is_good : bool
        Show the verdict in the colour of a good one.
    table : str
        Table in HTML above the text.
    plots : sequence of str
        Plots as SVG.
    """
    head, _, rest = text.partition("\n\n")
    first, *lines = head.split("\n")
    drawn = [Markup(svg[max(svg.find("<svg"), 0) :]) for svg in plots]
    page = rendered(
        "summary.html",
        title=title,
        headline=first,
        lines=lines,
        is_good=is_good,
        table=Markup(table),
        plots=drawn,
        text=rest,
    )
    return page.encode()
