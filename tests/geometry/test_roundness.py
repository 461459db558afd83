"""Journals that are oval: named with their ovality, on any mesh; round ones never are."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from autobalance.crank.recognition.alignment import ovality_warning
from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import drawn
from tests.jobs import report_of, run

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850
[engine.reciprocating_g]
piston = 400
[balance]
factor = 0.4
grade = 4000
speed_rpm = 300
[correction]
method = "drill"
"""


def stretched(name: str, segments: int, times: float) -> Mesh:
    mesh = drawn(preset(name), segments).mesh
    return Mesh(mesh.vertices * [times, 1.0, 1.0], mesh.triangles)


@pytest.mark.parametrize("segments", [12, 24, 64])
@pytest.mark.parametrize("name", ["single", "pressed-up-single-no-pin", "v-twin-45", "inline-3"])
def test_only_oval_journals_are_named(name: str, segments: int) -> None:
    """On coarse meshes too, where corners of oil holes and keyways lie far inside of the circle."""
    anatomy = crank_anatomy(preset(name))
    assert ovality_warning(anatomy, stretched(name, segments, 1.0)) is None
    for share in (0.005, 0.02):
        said = ovality_warning(anatomy, stretched(name, segments, 1.0 + share))
        found = re.search(r"differ by ([\d.]+) mm \(([\d.]+)%\)", str(said))
        assert found is not None
        assert float(found[2]) == pytest.approx(100.0 * share, abs=0.1)


@pytest.mark.usefixtures("cranks_read_once")
def test_inspect_and_balance_warn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = stretched("v-twin-45", 24, 1.003)
    (tmp_path / "crank.stl").write_bytes(encode(mesh, "stl", 1.0))
    assert run("inspect", tmp_path / "crank.stl", "--unit", "mm", "--json", "-") == 0
    printed = capsys.readouterr()
    (told,) = (each for each in json.loads(printed.out)["warnings"] if "oval" in each)
    assert "is oval: its diameters differ by 0.11" in told
    assert told in printed.err
    (tmp_path / "job.toml").write_text(JOB, encoding="utf-8")
    assert run("balance", tmp_path / "job.toml", "-o", tmp_path / "out", "--no-report") in (0, 4)
    assert any("is oval" in each for each in report_of(tmp_path / "out")["warnings"])
    assert "is oval" in capsys.readouterr().err


def test_a_crank_far_from_round_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "crank.stl").write_bytes(encode(stretched("v-twin-45", 48, 1.02), "stl", 1.0))
    assert run("inspect", tmp_path / "crank.stl", "--unit", "mm") == 3
    assert "has no bare cylinder" in capsys.readouterr().err


def test_a_journal_with_few_corners_is_not_judged() -> None:
    anatomy = crank_anatomy(preset("single"))
    assert ovality_warning(anatomy, Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))) is None
