"""The tutorial of docs/scan.md: its job and its commands as they stand, on a scan of a known crank."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from autobalance.drawn_cranks.design import PRESETS
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import Written
from autobalance.solid.mesh.mesh import Mesh
from tests import jobs
from tests.generated import generated_crank
from tests.scans import Wear, scan, surface_of

PAGE = Path(__file__).resolve().parents[1] / "docs" / "scan.md"
SIGMA_MM, SKIN_MM, EDGE_MM = 0.02, 0.015, 1.8


def _blocks(language: str) -> list[str]:
    text = PAGE.read_text(encoding="utf-8").partition("## What is reported")[0]
    blocks = re.findall(rf"   ```{language}\n(.*?)   ```", text, re.DOTALL)
    return ["\n".join(line.removeprefix("   ") for line in block.splitlines()) for block in blocks]


def test_the_tutorial_leads_from_a_scan_to_a_verdict_that_the_true_crank_keeps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = scan("single", SIGMA_MM, edge_mm=EDGE_MM, seed=4, skin_mm=SKIN_MM)
    drawing = generated_crank("single", segments=64)
    (tmp_path / "scan.stl").write_bytes(Written.of(there.mesh, "stl", 1.0).data)
    (tmp_path / "drawing.stl").write_bytes(Written.of(drawing.mesh, "stl", 1.0).data)
    (job,) = _blocks("toml")
    (tmp_path / "job.toml").write_text(job, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    commands = [line for block in _blocks("sh") for line in block.splitlines()]
    assert [shlex.split(line)[1] for line in commands] == ["inspect", "balance", "verify", "inspect"]
    for line in commands:
        more = ["--only", "json"] if " balance " in line else []
        assert jobs.run(*shlex.split(line)[1:], *more) == 0, line
    assert (tmp_path / "crank.png").stat().st_size > 10_000
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    calibration = report["crank"]["calibration"]
    assert abs(calibration["skin_mm"] - SKIN_MM) < 1.5 * calibration["skin_pm_mm"]
    assert calibration["contradictions"] == []

    # the crank itself, meshed more finely
    vertices, triangles, _ = surface_of(PRESETS["single"], 1.2, Wear(), 0)
    whole = Solid.from_mesh(Mesh(vertices, triangles)).moved(there.placement)
    before, frame = whole.moments(7.85e-3, there.truth.file_to_rotor), there.truth.file_to_rotor
    assert before.mass_g == pytest.approx(report["crank"]["mass_g"], abs=2.0)
    throw = there.truth.throws[0].crankpin.centre_mm[:2]
    u = before.first_g_mm[:2] + (150.0 + 0.6 * 250.0) * throw
    turn = (frame @ np.linalg.inv(np.array(report["frame"]["file_to_rotor"])))[:2, :2]
    off = np.linalg.norm(u - turn @ np.array(report["initial"]["unbalance_g_mm"]))
    assert off < report["initial"]["uncertainty_g_mm"]
