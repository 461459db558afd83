"""Workbooks from anywhere: damaged, far too large, or with one cell in the last corner."""

from __future__ import annotations

import io
import os
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from openpyxl import Workbook

from autobalance.errors import FileError, JobError
from autobalance.job.workbook import Row, read_workbook, write_workbook
from autobalance.studies.batch.input import read_batch_list
from autobalance.toml_files import spreadsheet
from autobalance.toml_files.spreadsheet import sheet_cells

ROWS = [Row("", meaning="Balance"), Row("balance.factor", 0.5), Row("balance.speed_rpm", 9000)]


@pytest.fixture
def book(tmp_path: Path) -> Path:
    path = tmp_path / "job.xlsx"
    path.write_bytes(write_workbook(ROWS))
    return path


def changed(path: Path, part: str, change: Callable[[bytes], bytes]) -> None:
    """Write the workbook again with one part of its archive changed."""
    kept = io.BytesIO()
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(kept, "w", zipfile.ZIP_DEFLATED) as new:
        assert part in old.namelist()
        for name in old.namelist():
            new.writestr(name, change(old.read(name)) if name == part else old.read(name))
    path.write_bytes(kept.getvalue())


def read_or_refused(path: Path) -> str | None:
    """Return what is said of a workbook that is refused; any other error is the test's."""
    try:
        read_workbook(path)
    except JobError as error:
        return str(error)
    return None


SHEET = "xl/worksheets/sheet1.xml"


def test_a_workbook_is_read(book: Path) -> None:
    assert read_workbook(book) == {"balance": {"factor": 0.5, "speed_rpm": 9000}}


@pytest.mark.parametrize(
    ("part", "change"),
    [
        (SHEET, lambda data: data[: len(data) // 2]),
        (SHEET, lambda data: data.replace(b"<row", b"<rov", 3)),
        (SHEET, lambda data: data.replace(b' r="A2"', b' r="?"')),
        (SHEET, lambda data: data.replace(b' s="', b' s="99', 2)),
        (SHEET, lambda _: b"\x00\xff"),
        ("xl/workbook.xml", lambda data: data.replace(b"<sheet ", b"<shoot ")),
        ("xl/workbook.xml", lambda _: b""),
        ("xl/styles.xml", lambda data: data.replace(b"<fonts", b"<fints")),
        ("xl/styles.xml", lambda data: data.replace(b'fontId="0"', b'fontId="x"')),
        ("[Content_Types].xml", lambda _: b"<x/>"),
        ("xl/_rels/workbook.xml.rels", lambda data: data.replace(b"worksheets", b"warksheets")),
    ],
)
def test_what_is_damaged_is_one_line_or_read(book: Path, part: str, change: Callable[[bytes], bytes]) -> None:
    changed(book, part, change)
    said = read_or_refused(book)
    assert said is None or ("job.xlsx" in said and "\n" not in said)


@pytest.mark.parametrize("place", range(60, 5000, 97))
def test_flipped_bytes_are_one_line_or_read(book: Path, place: int) -> None:
    data = bytearray(book.read_bytes())
    data[place % len(data)] ^= 0x55
    book.write_bytes(data)
    said = read_or_refused(book)
    assert said is None or ("job.xlsx" in said and "\n" not in said)


def test_an_archive_whose_packing_is_damaged_is_named(book: Path) -> None:
    data = book.read_bytes()
    at = data.index(b"xl/worksheets/sheet1.xml") + 40
    book.write_bytes(data[:at] + b"\xff" * 40 + data[at + 40 :])
    with pytest.raises(
        JobError, match=r"job\.xlsx is not a sound workbook .*save it again from a spreadsheet"
    ):
        read_workbook(book)


@pytest.mark.parametrize("value", [None, 1.0])
@pytest.mark.parametrize("corner", ["XFD1048576", "B1048576"])
def test_a_cell_in_the_last_corner_costs_nothing(tmp_path: Path, corner: str, value: float | None) -> None:
    work = Workbook()
    sheet = work.active
    sheet.append(["job"])
    sheet.append(["a.toml"])
    sheet[corner].number_format = "0.00"
    sheet[corner] = value
    path = tmp_path / "list.xlsx"
    work.save(path)
    began = time.process_time()
    if value is None:
        assert sheet_cells(path, None) == [("job",), ("a.toml",)]
    else:
        with pytest.raises(JobError, match=r"in row 1048576 or beyond; expected at most 20000 rows"):
            read_batch_list(path)
    assert time.process_time() - began < 3.0  # it took 42 s and 2.4 GB


def test_a_bomb_is_refused_before_it_is_unpacked(book: Path) -> None:
    changed(book, SHEET, lambda data: data + b" " * (spreadsheet.UNPACKED_MOST + 1))
    assert book.stat().st_size < 1 << 20
    with pytest.raises(JobError, match="found a workbook of 64 MB unpacked; expected at most 64 MB"):
        read_workbook(book)


def test_a_file_too_large_is_not_read(book: Path) -> None:
    os.truncate(book, 40 << 20)  # a hole: it takes no room on the disk
    with pytest.raises(JobError, match="found a workbook of 40 MB; expected at most 16 MB"):
        read_workbook(book)


def test_a_file_that_is_gone_is_a_file_error(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"cannot read the workbook .*no such file"):
        sheet_cells(tmp_path / "gone.xlsx", None)
