"""Sheets of random plans: no text over text, no page under a third full but the last."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.paper.sheet import pdf
from autobalance.report.records.balanced import BalancedReport
from tests import pages, plans
from tests.report.test_job_header import headed
from tests.report.test_paper import datums

pytestmark = pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="not installed: poppler-utils (script/test-tools)"
)


@pytest.mark.parametrize("seed", range(8))
def test_pages_are_filled_and_no_text_lies_over_another(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.choice([1, 2, 6, 9, 20, 46, 90]))
    kinds = tuple(rng.choice(plans.KINDS, size=int(rng.integers(1, 4)), replace=False))
    report = headed(1) if seed % 2 else plans.plan(1)
    report["corrections"] = plans.plan(count, kinds, seed=seed)["corrections"]
    if seed % 3 == 0:
        report["crank"]["datums"] = datums(30.0, 90.0)
    paper: Any = rng.choice(["A4", "Letter"])
    units: Any = rng.choice(["metric", "inch"])
    path = tmp_path / "sheet.pdf"
    path.write_bytes(pdf(BalancedReport.read(report), plans.drawings_of(report), str(paper), str(units)))  # type: ignore[arg-type]
    assert pages.faults(path) == []


def test_a_fault_is_found(tmp_path: Path) -> None:
    from reportlab.pdfgen.canvas import Canvas

    path = tmp_path / "faulty.pdf"
    canvas = Canvas(str(path), pagesize=(595.0, 842.0))
    canvas.drawString(100.0, 700.0, "over")
    canvas.drawString(105.0, 702.0, "text")
    canvas.showPage()
    canvas.drawString(100.0, 400.0, "last")
    canvas.showPage()
    canvas.save()
    said = pages.faults(path)
    assert len(said) == 2
    assert "text over text" in said[0]
    assert "% full" in said[1]
