"""The units in which a shop works, as the default of commands."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from autobalance.errors import AutobalanceError
from autobalance.report.files import earlier_report
from autobalance.toml_files.document import text_of, toml_of
from autobalance.user_folders import shop_file

WRITTEN = ("command", "json", "output", "plots", "series", "picture", "units")
"""Arguments that are not a file to read."""


def fill_in_units(arguments: argparse.Namespace) -> None:
    """Set ``units`` if the command has them and the user requests none."""
    if getattr(arguments, "units", "metric") is not None:
        return
    named = (Path(each) for name, each in vars(arguments).items() if name not in WRITTEN and _is_name(each))
    source = next((path for path in named if path.exists()), None)
    arguments.units = shop_units(source, getattr(arguments, "settings", None) or ())


def _is_name(value: object) -> bool:
    return isinstance(value, str) and "\0" not in value and 0 < len(value) < 4096


def shop_units(source: Path | None, settings: Sequence[str] = ()) -> str:
    """Return the units of ``--set``, else of a job or report, else of the shop's file beside it, else metric.

    Parameters
    ----------
    source : Path or None
        Job, report, crank or folder; None: the working folder.
    settings : sequence of str
        As typed, ``shop.units=inch``.
    """
    said = (each.partition("=") for each in settings)
    set_to = [value.strip().strip("\"'") for key, _, value in said if key.strip() == "shop.units"]
    here = Path() if source is None else source if source.is_dir() else source.parent
    files = [path for path in (source, shop_file(here)) if path is not None]
    found = (*set_to[-1:], *(_units_in(path) for path in files))
    return next((units for units in found if units in ("metric", "inch")), "metric")


def _units_in(path: Path) -> Any:
    """Return ``shop.units`` of a file; None if it is wrong: the command that reads it reports that."""
    if not path.is_file():  # a pipe would be waited for
        return None
    tables: Any = None
    if path.suffix == ".toml":
        try:
            tables = toml_of(text_of(path, "job file"), path.name)
        except AutobalanceError:
            return None
    elif path.suffix == ".json":
        tables = (earlier_report(path) or {}).get("job")
    shop = tables.get("shop") if isinstance(tables, Mapping) else None
    return shop.get("units") if isinstance(shop, Mapping) else None
