"""Every kind of file for people is documented, and a new one is one entry of the table."""

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import get_type_hints

import pytest

import autobalance as ab
from autobalance.command.main import full_parser
from autobalance.report import output_kinds
from autobalance.report.material import FileMaterial
from autobalance.report.output_kinds import KINDS, OutputKind, choices, register
from autobalance.report.records.outputs import Outputs
from tests import jobs

PAGE = Path(__file__).parents[2] / "docs" / "outputs.md"


def undocumented(page: str) -> list[str]:
    """Return the files of kinds that the page's table has no row for."""
    rows = [row for row in page.splitlines() if row.startswith("| `")]
    return [
        file
        for kind in KINDS.values()
        for file in kind.files.values()
        if not any(f"`{file}`" in row and f"`{kind.name}`" in row for row in rows)
    ]


@pytest.fixture
def cuts_csv() -> Iterator[None]:
    register(OutputKind("dro", {"dro": "cuts.csv"}, lambda made: {"dro": _cuts(made)}, is_usual=False))
    yield
    del output_kinds._KINDS["dro"]


def _cuts(made: FileMaterial) -> bytes:
    return "\n".join(f"{cut['kind']},{cut['depth_mm']}" for cut in made.report["corrections"]).encode()


def test_every_kind_is_on_the_page_of_outputs() -> None:
    assert undocumented(PAGE.read_text(encoding="utf-8")) == []


@pytest.mark.usefixtures("cuts_csv")
def test_a_kind_that_is_not_on_the_page_is_noticed() -> None:
    assert undocumented(PAGE.read_text(encoding="utf-8")) == ["cuts.csv"]


def test_every_kind_is_in_the_record_of_the_report() -> None:
    listed = [kind for kind in KINDS.values() if not kind.is_to_fill]
    assert {key for kind in listed for key in kind.files} <= get_type_hints(Outputs).keys()


def test_the_help_and_the_docstring_name_every_kind() -> None:
    commands = next(each.choices for each in full_parser()._actions if each.dest == "command")
    for name in ("balance", "recut"):
        assert ", ".join(choices()) in re.sub(r"\s+", " ", commands[name].format_help())  # type: ignore[index]
    said = ab.BalanceResult.write.__doc__ or ""
    assert all(f"``{name}``" in said for name in choices())


@pytest.mark.usefixtures("cuts_csv")
def test_a_new_kind_is_one_entry(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    report = jobs.balanced(jobs.bundled_job(tmp_path), folder, 0, "--only", "dro")
    data = (folder / "cuts.csv").read_bytes()
    assert data.startswith(b"shoulder,2.")
    assert report["outputs"]["dro"] == {"file": "cuts.csv", "sha256": hashlib.sha256(data).hexdigest()}
    assert jobs.run("verify", folder / "report.json") == 0


def test_a_name_that_is_taken_is_refused() -> None:
    with pytest.raises(ValueError, match=r"'report\.html' is there already"):
        register(OutputKind("page", {"page": "report.html"}, lambda _: {}))
    with pytest.raises(ValueError, match="the output kind 'html' is there already"):
        register(OutputKind("html", {"page": "page.html"}, lambda _: {}))


def test_papers_begin_with_part_and_serial_where_the_job_names_the_part(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path)
    text = job.read_text(encoding="utf-8")
    job.write_text(f'[job]\npart = "V8 / race"\nserial = "001"\n{text}', encoding="utf-8")
    out = tmp_path / "out"
    assert jobs.run("balance", job, "-o", out, "--only", "pdf,certificate,html,reading") == 0
    names = {path.name for path in out.iterdir()}
    papers = {"V8_race-001-sheet.pdf", "V8_race-001-certificate.pdf"}
    assert names == {*papers, "report.html", "reading.toml", "report.json", "balanced.stl"}
    outputs = jobs.report_of(out)["outputs"]
    assert {outputs[key]["file"] for key in ("pdf", "certificate")} == papers
    assert jobs.run("verify", out / "report.json") == 0
    assert jobs.run("sheet", out / "report.json", "-o", tmp_path / "again", "--only", "pdf") == 0
    assert (tmp_path / "again" / "V8_race-001-sheet.pdf").is_file()
    first = (out / "V8_race-001-sheet.pdf").read_bytes()
    assert first.startswith(b"%PDF")
    assert jobs.run("balance", job, "-o", out, "--only", "pdf", "--set", "job.serial=002") == 0
    assert {path.name for path in out.glob("*.pdf")} == {"V8_race-002-sheet.pdf"}
