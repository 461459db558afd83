"""Cells of a workbook, read within limits: a small file can stand for gigabytes."""

from __future__ import annotations

import io
import re
import struct
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from autobalance.errors import JobError, file_errors, refuse_pipe
from autobalance.runtime import note_read

PACKED_MOST: Final = 16 << 20
UNPACKED_MOST: Final = 64 << 20
"""Bytes: a workbook of 20 000 rows of 40 cells has some 30 MB. Of a bomb of 1.5 MB came 4.6 GB."""
ROWS_MOST: Final = 20_000
COLUMNS_MOST: Final = 200
FAR_ROW: Final = re.compile(rb'<(?:\w+:)?row\b[^>]*?\br="(\d{5,7})"')
VALUE: Final = re.compile(rb"<(?:\w+:)?(?:v|is)\b")
DAMAGE_ERRORS: Final = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    SyntaxError,  # ParseError, and lxml's own where it is installed
    EOFError,
    ArithmeticError,
    AttributeError,
    LookupError,
    NotImplementedError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)
"""Errors from the library for a workbook whose archive, XML, styles or numbers are damaged."""


def sheet_cells(path: Path, sheet: str | None, *, formulas: bool = False) -> list[tuple[Any, ...]]:
    """Return the rows of a sheet, down to the last with a value.

    Parameters
    ----------
    path : Path
        A workbook (.xlsx, .xlsm).
    sheet : str or None
        Its name; None takes the first.
    formulas : bool
        Give formulas as they are written, not the values that were stored with them.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not a sound workbook, has no such sheet, or is larger than a job or a list can be.
    """
    with file_errors(f"read the workbook {path}"):
        refuse_pipe(path)
        note_read(path)
        if path.stat().st_size > PACKED_MOST:
            raise JobError(_too_large(path, f"{path.stat().st_size / 2**20:.0f} MB", PACKED_MOST))
        data = path.read_bytes()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
            if unpacked > UNPACKED_MOST:
                raise JobError(_too_large(path, f"{unpacked / 2**20:.0f} MB unpacked", UNPACKED_MOST))
            _refuse_far_rows(path, archive)
        return _rows(path, data, sheet, formulas)
    except DAMAGE_ERRORS as error:
        if isinstance(error, JobError):
            raise
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise JobError(
            f"{path.name} is not a sound workbook ({reason[:200]}); save it again from a spreadsheet program"
        ) from None


def _rows(path: Path, data: bytes, sheet: str | None, formulas: bool) -> list[tuple[Any, ...]]:
    from openpyxl import load_workbook

    # read-only: cells come as they stand in the file, and an empty million of rows costs no memory
    book = load_workbook(io.BytesIO(data), read_only=True, data_only=not formulas)
    names: Sequence[str] = [one.title for one in book.worksheets]
    if not names or (sheet is not None and sheet not in names):
        sheets = ", ".join(names) or "none"
        raise JobError(
            f"{path.name} has no sheet {sheet or ''!r} (there are: {sheets}); `autobalance init` writes one"
        )
    page = book[sheet if sheet is not None else names[0]]
    page.reset_dimensions()  # what the file says of its size need not be so
    rows: list[tuple[Any, ...]] = []
    for number, row in enumerate(page.iter_rows(values_only=True, max_row=ROWS_MOST), start=1):
        last = max((k + 1 for k, cell in enumerate(row) if cell is not None), default=0)
        if last > COLUMNS_MOST:
            raise JobError(
                f"{path.name}: found a value in row {number}, column {last}; expected at most "
                f"{COLUMNS_MOST} columns"
            )
        if last:
            rows += [()] * (number - 1 - len(rows))
            rows.append(tuple(row[:last]))
    return rows


def _refuse_far_rows(path: Path, archive: zipfile.ZipFile) -> None:
    """Refuse values in rows beyond the limit: the library would fill a million rows to get there."""
    for name in archive.namelist():
        if not name.startswith("xl/worksheets/") or not name.endswith(".xml"):
            continue
        data = archive.read(name)
        for row in FAR_ROW.finditer(data):
            if int(row[1]) > ROWS_MOST and VALUE.search(data, row.end()):
                raise JobError(
                    f"{path.name}: found a value in row {int(row[1])} or beyond; "
                    f"expected at most {ROWS_MOST} rows"
                )


def _too_large(path: Path, size: str, most: int) -> str:
    return f"{path.name}: found a workbook of {size}; expected at most {most >> 20} MB"
