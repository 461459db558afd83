"""From plan to paper an engine and its mirror image that turns the other way: y negated, all else equal."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pypdf import PdfReader

import autobalance as ab
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid

Values = dict[str, Any]
Pair = tuple[Path, list[list[Values]]]
MIRROR = np.array([1.0, -1.0])


def crank_file(folder: Path, mirrored: bool) -> None:
    mesh = crank_solid(PRESETS["single"], 32).mesh
    vertices, triangles = np.array(mesh.vertices), np.array(mesh.triangles)
    vertices[:, 1] += np.where(vertices[:, 1] > 25.0, 1.0, 0.0)
    if mirrored:
        vertices, triangles = vertices * [1, -1, 1], triangles[:, ::-1]
    folder.mkdir()
    ab.crank_from_mesh(vertices, triangles, density_kg_m3=7850).write(folder / "crank.stl")


def stages(folder: Path, mirrored: bool) -> list[Values]:
    """Return the reports of a balance, of what a machine reads then, and of a further stage."""
    crank_file(folder, mirrored)
    sign = -1.0 if mirrored else 1.0
    job = {
        "crankshaft": {"file": str(folder / "crank.stl"), "unit": "mm", "density_kg_m3": 7850.0},
        "engine": {
            "rod_length_mm": 120.0,
            "rotating_g": {"big_end": 180.0},
            "reciprocating_g": {"piston": 330.0},
            "layout": {"bank_deg": sign * 20.0, "offset_mm": sign * 2.0},
            "turns": "cw" if mirrored else "ccw",
            "attached": [
                {"name": "sprocket", "mass_g": 300.0, "unbalance_g_mm": [40.0, sign * 90.0], "z_mm": 70.0}
            ],
        },
        "balance": {"factor": 0.5, "grade": 40.0, "speed_rpm": 5000},
        "correction": {"method": "drill", "drill": {"diameters_mm": [10.0]}},
    }
    balanced = ab.balance(ab.Job.from_dict(job))
    balanced.write(folder / "out", only=("json", "pdf", "card"))
    report = folder / "out" / "report.json"
    machine = {
        "kind": "hard",
        "speed_rpm": 600,
        "reading": {"urr_percent": 95.0, "umar_g_mm": 2.0},
        "rotor": {"report": str(report)},
        "unbalance": [{"z_mm": 20.0, "g_mm": 350.0, "angle_deg": sign * 160.0}],
    }
    read = ab.machine(machine)
    read.write(folder)
    again = ab.recut(report, folder / "reading.toml")
    again.write(folder / "stage-2", only=("json", "pdf", "card"))
    assert ab.verify(folder / "stage-2" / "report.json").holds
    return [balanced.report, read.report, again.report]


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Pair:
    folder = tmp_path_factory.mktemp("turning")
    return folder, [stages(folder / name, name == "cw") for name in ("ccw", "cw")]


NEGATED = re.compile(r"^(angle|start|end|bank|skew)_deg$")
VECTORS = re.compile(
    r"(^|_)(unbalance(_change|_per_mm)?_g_mm|moment(_per_mm)?_g_mm2|position_mm|inward|entry_mm|"
    r"centre(_of_mass)?_mm)$"
)
OWN: tuple[str, ...] = (
    "input",
    "outputs",
    "seconds",
    "job",
    "frame",
    "previous",
    "stages",
    "faces",
    "warnings",
)
OWN += ("inertia_kg_mm2",)


def mirrored_values(one: object, other: object, place: str = "") -> None:
    """Assert that reports are alike, vectors with y negated, angles turned about 0."""
    key = place.rpartition(".")[2]
    if isinstance(one, dict):
        assert isinstance(other, dict)
        assert one.keys() == other.keys(), place
        for name, value in one.items():
            if name not in OWN:
                mirrored_values(value, other[name], f"{place}.{name}")
    elif isinstance(one, list):
        assert isinstance(other, list)
        assert len(one) == len(other), place
        if VECTORS.search(key):
            wanted = np.array(one) * [1.0, -1.0, 1.0][: len(one)]
            size = 1.0 + float(np.abs(wanted).max())
            assert other == pytest.approx(wanted.tolist(), rel=1e-9, abs=1e-6 * size), place
        elif "file_" not in key and "triangles" not in key:
            for number, (a, b) in enumerate(zip(one, other, strict=True)):
                mirrored_values(a, b, f"{place}[{number}]")
    elif isinstance(one, float) and NEGATED.search(key):
        assert isinstance(other, float)
        assert abs(math.remainder(one + other, 360.0)) < 1e-4, place
    elif isinstance(one, float):
        assert other == pytest.approx(one, rel=1e-6, abs=1e-5), place


def test_a_plan_a_reading_and_a_further_stage_are_mirrored(pair: Pair) -> None:
    _, (one, other) = pair
    balance, _, recut = one
    assert balance["corrections"]
    assert recut["corrections"]
    for here, there in zip(one, other, strict=True):
        mirrored_values({**here, "planes": []}, {**there, "planes": []})


def test_sheets_and_cards_say_how_the_engine_turns(pair: Pair) -> None:
    folder, _ = pair
    said = "In the engine the crank turns clockwise"
    for stage in ("out", "stage-2"):
        for name in ("sheet.pdf", "bob-weights.pdf"):
            texts = [words(folder / sense / stage / name) for sense in ("ccw", "cw")]
            assert said not in texts[0]
            assert said in texts[1]


def words(path: Path) -> str:
    return " ".join(" ".join(page.extract_text() for page in PdfReader(path).pages).split())
