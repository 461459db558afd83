"""Where each correction of a report is said to be: angle, z, entry, feed, and what of it verify believes."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pypdf import PdfReader

import autobalance as ab
from tests import mixed_kinds
from tests.web_app import small

ROUNDING = 1e-9


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mixed")
    result = ab.balance(ab.read_job(mixed_kinds.mixed_job(folder, 6)))
    result.write(folder / "out", only=("json",))
    return folder / "out"


def report_of(folder: Path) -> dict[str, Any]:
    values: dict[str, Any] = json.loads((folder / "report.json").read_text("utf-8"))
    return values


def test_angle_and_z_are_those_of_the_position(written: Path) -> None:
    items = report_of(written)["corrections"]
    assert len({item["kind"] for item in items}) >= 2
    for item in items:
        x, y, z = item["position_mm"]
        turn, radius = math.radians(item["angle_deg"]), math.hypot(x, y)
        assert 0.0 <= item["angle_deg"] < 360.0
        np.testing.assert_allclose([radius * math.cos(turn), radius * math.sin(turn)], [x, y], atol=1e-9)
        assert item["z_mm"] == z


def test_holes_begin_at_their_entry_and_others_are_where_their_metal_is(written: Path) -> None:
    for item in report_of(written)["corrections"]:
        place = np.array(item["position_mm"])
        if item["kind"] in {"drill", "slug"}:
            assert item["entry_radius_mm"] == pytest.approx(math.hypot(*place[:2]), rel=ROUNDING)
            assert np.linalg.norm(item["inward"]) == pytest.approx(1.0, rel=ROUNDING)
            assert item["point_angle_deg"] == pytest.approx(180.0 if item["kind"] == "slug" else 118.0)
        else:
            assert math.hypot(*place[:2]) == pytest.approx(item["radius_mm"], rel=ROUNDING)
        if item["kind"] == "slug":  # its slug ends where the full diameter does
            end = place + (item["depth_mm"] - 0.5 * item["length_mm"]) * np.array(item["inward"])
            np.testing.assert_allclose(end, item["slug_centre_mm"], atol=1e-6)


def test_verify_agrees_with_the_places_told(written: Path) -> None:
    assert ab.verify(written / "report.json").holds


@pytest.mark.parametrize("key", ["angle_deg", "entry_radius_mm", "z_mm", "inward"])
def test_verify_refuses_a_place_that_does_not_agree(written: Path, key: str, tmp_path: Path) -> None:
    values = report_of(written)
    hole = next(item for item in values["corrections"] if "inward" in item)
    hole[key] = [0.0, 0.0, 2.0] if key == "inward" else hole[key] + 0.01
    spoilt = written / f"{key}.json"
    spoilt.write_text(json.dumps(values), encoding="utf-8")
    with pytest.raises(ab.AutobalanceError, match=r"corrections\[\d+\]"):
        ab.verify(spoilt)


def test_a_pad_is_added_with_a_height_under_its_own_heading_wherever_it_is_shown(tmp_path: Path) -> None:
    small.crank(tmp_path)
    limits = {"method": "add"}
    job = small.job(balance={"factor": 0.9, "grade": 16.0, "speed_rpm": 6000.0}, correction=limits)
    result = ab.balance(ab.Job.from_dict(job, folder=tmp_path))
    pads = result.report["corrections"]
    assert [pad["depth_mm"] < 0.0 for pad in pads] == [True, True]
    height, mass = f"{-pads[0]['depth_mm']:.3f}", f"{-pads[0]['removed_mass_g']:.2f}"
    lines = [" ".join(line.split()) for line in result.text().splitlines()]
    assert "Metal to add web angle height metal on radius z" in lines
    assert not any(line.startswith("Cuts to make") for line in lines)
    assert any("2 pads of 4.09 mm" in line and "261.15 g added" in line for line in lines)
    result.write(tmp_path / "out", only=("pdf", "html"))
    words = "\n".join(each.extract_text() for each in PdfReader(tmp_path / "out" / "sheet.pdf").pages)
    assert "Metal to add: 2 pads" in words
    assert "Cuts: 2" not in words
    row = next(line.split() for line in words.splitlines() if line.split()[:2] == ["1", "Pad"])
    assert (row[-2], row[-1]) == (height, mass)
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "What was added: 2 pads" in page
    table = page.partition('aria-label="Added metal"')[2].partition("</table>")[0]
    assert f"<td>{height}</td><td>{mass}</td>" in table
    assert "−" not in re.sub(r"<small>.*?</small>", "", table)
