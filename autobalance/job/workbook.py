"""A workbook as a job: sheet ``Job``, one key a row, A its dotted path, B its value."""

from __future__ import annotations

import io
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

from autobalance.errors import JobError
from autobalance.toml_files.document import refuse_deep, set_key, toml_value
from autobalance.toml_files.spreadsheet import sheet_cells
from autobalance.value_classes import dataclass

SHEET = "Job"
HEADING = ("Key", "Value", "Unit", "Meaning")
UNITS_OF_MASS = {"g", "kg", "oz", "lb"}


@dataclass(frozen=True)
class Row:
    """One row: a key with its value, or a heading where the key is empty.

    A row that is not ``active`` is a hint: a comment in TOML, a row without a value in a workbook.
    """

    key: str
    value: Any = None
    unit: str = ""
    meaning: str = ""
    active: bool = True


def read_workbook(path: Path) -> dict[str, Any]:
    """Return the tables of a workbook's sheet ``Job``.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not a workbook, has no such sheet, or a cell is wrong: ``Job!B17``.
    """
    return tables_of_cells(cells_of(path))


def cells_of(path: Path) -> dict[str, tuple[str, Any]]:
    """Return each key with its cell and its value, in the order of the sheet; empty values are left out."""
    shown, formulas = (sheet_cells(path, SHEET, formulas=formulas) for formulas in (False, True))
    heading = shown[0] if shown else ()
    if [str(cell or "").strip() for cell in heading][: len(HEADING)] != list(HEADING):
        raise JobError(f"{path.name}: {SHEET}!A1 to D1 must be {' | '.join(HEADING)}")
    cells: dict[str, tuple[str, Any]] = {}
    for number, (row, raw) in enumerate(zip_longest(shown[1:], formulas[1:], fillvalue=()), 2):
        key, value = str(_at(row, 0) or "").strip(), _at(row, 1)
        if not key:
            continue
        cell = f"{SHEET}!B{number}"
        if key in cells:
            raise JobError(f"{path.name}: {SHEET}!A{number}: {key} is in {cells[key][0]} already")
        written = _at(raw, 1)
        if value is None and isinstance(written, str) and written.startswith("="):
            raise JobError(f"{path.name}: {cell}: {key} is a formula without a stored value")
        cells[key] = (cell, value)
    return cells


def tables_of_cells(cells: Mapping[str, tuple[str, Any]]) -> dict[str, Any]:
    """Return nested tables of dotted keys; keys without a value are left out."""
    values: dict[str, Any] = {}
    for key, (cell, value) in cells.items():
        if value is None or value == "":
            continue
        try:
            set_key(values, key, _plain(value))
        except JobError as error:
            raise JobError(f"{cell}: {error}") from None
    return values


def cell_of(cells: Mapping[str, tuple[str, Any]], message: str) -> str | None:
    """Return the cell of the key that a message is about; that of the longest key it begins with."""
    named = [key for key in cells if message.startswith((f"{key} ", f"{key}[", f"{key}.", f"{key}:"))]
    return cells[max(named, key=len)][0] if named else None


def _at(row: Sequence[Any], column: int) -> Any:
    return row[column] if column < len(row) else None


def _plain(value: Any) -> Any:
    """Return a cell's value as TOML has it: lists and inline tables are TOML text."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 2.0**53:
        return int(value)
    if isinstance(value, str) and value.lstrip().startswith(("[", "{")):
        try:
            refuse_deep(value)
            return tomllib.loads(f"value = {value}")["value"]
        except (ValueError, RecursionError):  # TOMLDecodeError is a ValueError
            return value
    return value


def write_workbook(rows: Iterable[Row]) -> bytes:
    """Return a workbook with one sheet ``Job``."""
    from openpyxl import Workbook
    from openpyxl.styles import Alignment, Font, PatternFill

    book = Workbook()
    sheet = book.active
    sheet.title = SHEET
    sheet.append(HEADING)
    for cell in sheet[1]:
        cell.font = Font(bold=True)
    for row in rows:
        value = row.value if row.active and row.key else None
        sheet.append([row.key, _cell(value), row.unit, row.meaning])
        last = sheet.max_row
        if not row.key:
            sheet.cell(last, 4).font = Font(bold=True)
        elif row.active:
            sheet.cell(last, 2).fill = PatternFill("solid", start_color="FFF6D5")
        sheet.cell(last, 4).alignment = Alignment(wrap_text=True, vertical="top")
    for column, width in zip("ABCD", (38, 26, 10, 90), strict=True):
        sheet.column_dimensions[column].width = width
    sheet.freeze_panes = "A2"
    sheet.page_setup.orientation = "landscape"
    sheet.page_setup.fitToWidth, sheet.page_setup.fitToHeight = 1, 0
    sheet.sheet_properties.pageSetUpPr.fitToPage = True
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def _cell(value: Any) -> Any:
    return toml_value(value) if isinstance(value, list | tuple | Mapping) else value


def rows_of(values: Mapping[str, Any], path: str = "") -> list[Row]:
    """Return the rows of a job's tables; weights with their unit stay in one cell."""
    rows: list[Row] = []
    for key, value in values.items():
        where = f"{path}.{key}" if path else key
        if isinstance(value, Mapping) and not UNITS_OF_MASS & set(value) and not _is_part(value, path):
            rows += rows_of(value, where)
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for place, item in enumerate(value, 1):
                rows += rows_of(item, f"{where}[{place}]")
        else:
            rows.append(Row(where, value))
    return rows


def _is_part(value: Mapping[str, Any], path: str) -> bool:
    """Return whether a table is a weight taken from a solid."""
    return "file" in value and path.endswith("_g")
