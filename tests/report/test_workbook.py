"""The calculation sheet: its values as written, and as another program recalculates them."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from autobalance.paper.workbook import xlsx
from autobalance.report.records.balanced import BalancedReport
from tests import jobs

needs_office = pytest.mark.skipif(
    shutil.which("soffice") is None, reason="not installed: libreoffice-calc (script/test-tools)"
)
NS = {"m": "http://schemas.openxmlformats.org/spreadsheetml/2006/main"}
ALWAYS = """<?xml version="1.0" encoding="UTF-8"?>
<oor:items xmlns:oor="http://openoffice.org/2001/registry" xmlns:xs="http://www.w3.org/2001/XMLSchema">
<item oor:path="/org.openoffice.Office.Calc/Formula/Load"><prop oor:name="OOXMLRecalcMode" oor:op="fuse">
<value>0</value></prop></item></oor:items>"""


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("book")
    jobs.computed(jobs.bundled_job(folder, "straight"), folder / "out")
    return jobs.report_of(folder / "out")


def lines(path: Path) -> dict[str, list[float | str]]:
    """Return label → values in the order of the sheet."""
    with zipfile.ZipFile(path) as book:
        shared = [
            "".join(node.itertext())
            for node in ElementTree.fromstring(book.read("xl/sharedStrings.xml")).findall("m:si", NS)
        ]
        rows = ElementTree.fromstring(book.read("xl/worksheets/sheet1.xml")).findall(".//m:row", NS)
    found: dict[str, list[float | str]] = {}
    for row in rows:
        cells: dict[str, float | str] = {}
        for cell in row.findall("m:c", NS):
            value = cell.find("m:v", NS)
            if value is None or value.text is None:
                continue
            column = re.sub(r"\d", "", cell.get("r", ""))
            kind = cell.get("t", "n")
            cells[column] = (
                shared[int(value.text)] if kind == "s" else value.text if kind == "str" else float(value.text)
            )
        if "A" in cells and cells.get("B", "") != "":
            found.setdefault(str(cells["A"]), []).append(cells["B"])
    return found


def recalculated(folder: Path, *paths: Path) -> list[dict[str, list[float | str]]]:
    """Return the lines of workbooks as LibreOffice computes them, begun once for all."""
    profile = folder / "profile" / "user"
    profile.mkdir(parents=True)
    (profile / "registrymodifications.xcu").write_text(ALWAYS, encoding="utf-8")
    command = [
        "soffice",
        f"-env:UserInstallation={profile.parent.as_uri()}",
        "--headless",
        "--convert-to",
        "xlsx:Calc MS Excel 2007 XML",
        "--outdir",
        str(folder / "out"),
        *map(str, paths),
    ]
    subprocess.run(command, check=True, capture_output=True, timeout=180)
    return [lines(folder / "out" / path.name) for path in paths]


def test_cached_values_are_the_reports(report: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "b.xlsx").write_bytes(xlsx(BalancedReport.read(report)))
    found = lines(tmp_path / "b.xlsx")
    assert found["m_rot"] == [pytest.approx(134.04)]
    assert found["m_rec"] == [pytest.approx(261.5)]
    assert found["Bob-weight"] == [pytest.approx(report["engine"]["bob_weights"][0]["mass_g"])]
    assert found["Magnitude"] == [
        pytest.approx(report[k]["magnitude_g_mm"], abs=1e-4) for k in ("initial", "residual")
    ]
    for name, k in (("A", 0), ("B", 1)):
        pair = [report[key]["planes"][k]["magnitude_g_mm"] for key in ("initial", "residual")]
        assert found[f"In plane {name}"] == [pytest.approx(value, abs=1e-4) for value in pair]
    assert found["Factor before"] == [pytest.approx(report["balance_factor"]["initial"], abs=1e-6)]
    assert found["Factor after"] == [pytest.approx(report["balance_factor"]["final"], abs=1e-6)]
    assert found["Permissible residual unbalance U_per"] == [
        pytest.approx(report["tolerance"]["permissible_g_mm"])
    ]
    assert found["Verdict"] == ["within tolerance"]
    product = report["counterweight"]["product_g_mm"]
    assert found["m_cw · r′ before"] == [pytest.approx(product["initial"])]
    assert found["m_cw · r′ needed"] == [pytest.approx(product["target"], abs=1e-3)]


@pytest.mark.slow
@needs_office
def test_another_program_finds_the_same_and_follows_a_changed_weight(
    report: dict[str, Any], tmp_path: Path
) -> None:
    (tmp_path / "b.xlsx").write_bytes(xlsx(BalancedReport.read(report)))
    written = lines(tmp_path / "b.xlsx")
    heavier = edited((tmp_path / "b.xlsx"), "piston", 168.0, tmp_path / "changed.xlsx")
    again, found = recalculated(tmp_path / "again", tmp_path / "b.xlsx", heavier)
    for label, values in written.items():
        for mine, theirs in zip(values, again[label], strict=True):
            assert theirs == (mine if isinstance(mine, str) else pytest.approx(mine, rel=1e-9, abs=1e-7)), (
                label
            )
    # the same sheet with a heavier piston, against the program's own arithmetic
    factor, radius = report["balance_factor"]["target"], report["crank"]["throws"][0]["crank_radius_mm"]
    bob = report["engine"]["bob_weights"][0]["mass_g"] + factor * 10.0
    x, y = report["residual"]["unbalance_g_mm"]
    assert found["m_rec"] == [pytest.approx(271.5)]
    assert found["Bob-weight"] == [pytest.approx(bob)]
    assert found["Magnitude"][1] == pytest.approx(((x + factor * 10.0 * radius) ** 2 + y**2) ** 0.5, rel=1e-7)
    assert found["Verdict"] == ["above tolerance"]


def edited(path: Path, label: str, value: float, to: Path) -> Path:
    """Copy a workbook with another number beside a label; every cached value stays as it was."""
    with zipfile.ZipFile(path) as book, zipfile.ZipFile(to, "w") as copy:
        strings = [
            "".join(node.itertext())
            for node in ElementTree.fromstring(book.read("xl/sharedStrings.xml")).findall("m:si", NS)
        ]
        for name in book.namelist():
            data = book.read(name)
            if name == "xl/worksheets/sheet1.xml":
                text = data.decode()
                row = re.search(rf'<c r="A(\d+)"[^>]*t="s"[^>]*><v>{strings.index(label)}</v>', text)
                assert row is not None
                text, count = re.subn(rf'(<c r="B{row[1]}"[^>]*><v>)[^<]*', rf"\g<1>{value}", text)
                assert count == 1
                data = text.encode()
            copy.writestr(name, data)
    return to


def test_a_name_that_looks_like_a_formula_stays_text(report: dict[str, Any], tmp_path: Path) -> None:
    changed = {
        **report,
        "job": {**report["job"], "engine": {**report["job"]["engine"], "rotating_g": {"=1+1": 134.04}}},
    }
    (tmp_path / "b.xlsx").write_bytes(xlsx(BalancedReport.read(changed)))
    assert lines(tmp_path / "b.xlsx")["=1+1"] == [134.04]


def test_the_verdict_counts_the_uncertainty_where_the_job_asks(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, piston="{ g = 158.0, pm = 2.0 }")  # 15 g·mm of 10.7
    text = job.read_text(encoding="utf-8").replace("[balance]\n", '[balance]\nmargin = "expanded"\n')
    job.write_text(text, encoding="utf-8")
    jobs.balanced(job, tmp_path / "out", 4, "--only", "xlsx,json")
    found = lines(tmp_path / "out" / "balance.xlsx")
    report = jobs.report_of(tmp_path / "out")
    for seen, of in [(report["residual"], "the resultant"), (report["residual"]["planes"][0], "plane A")]:
        assert found[f"Uncertainty of {of} in the verdict"] == pytest.approx([seen["uncertainty_g_mm"]])
    assert found["Share of the permissible value used"][0] > 1.4  # type: ignore[operator]
    assert found["Verdict"] == ["above tolerance"]
