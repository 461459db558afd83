"""Pages in HTML from the templates in ``assets/templates``."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from autobalance.report.display_units import in_units
from autobalance.report.page_units import (
    PAGE_UNITS,
    heavy_at,
    inertia_unit,
    length,
    mass,
    pointing,
    unbalance,
)
from autobalance.wording import degrees, number

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
