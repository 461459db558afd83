"""Analyses that the page offers: what each reads, its options, and what of it is refused."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.browser.analyses import ANALYSES, analyses, example, keywords_of, wrong_request
from autobalance.browser.project import Project
from autobalance.browser.work import _subject
from autobalance.errors import AutobalanceError, UsageError
from autobalance.toml_files.document import toml_of
from tests.web_app import small
from tests.web_app.serving import Served

OFFERED = {each["verb"]: each for each in analyses()}
FILED = [verb for verb, each in ANALYSES.items() if each.schema]


@pytest.fixture
def folder(tmp_path: Path) -> Project:
    project = Project.at(tmp_path / "project")
    (project.folder / "run.csv").write_text("t,accel\n", encoding="utf-8")
    return project


def test_every_verb_of_the_issue_has_a_form_from_its_declarations() -> None:
    assert {"forces", "cycle", "torsion", "rotor", "study", "design", "orders", "bench"} <= set(OFFERED)
    keys = {table["table"]: [key["key"] for key in table["keys"]] for table in OFFERED["rotor"]["tables"]}
    assert {"length_mm", "outer_mm"} <= set(keys["shaft"])
    assert "speed_rpm" in keys[""]
    samples = next(each for each in OFFERED["study"]["options"] if each["key"] == "samples")
    assert (samples["kind"], samples["default"]) == ("number", "10000")
    window = next(each for each in OFFERED["orders"]["options"] if each["key"] == "window")
    assert "flattop" in window["choices"]


def test_a_file_of_several_forms_says_which_of_them_has_a_key() -> None:
    loose = {key["key"]: key for key in OFFERED["bearing"]["tables"][0]["keys"]}
    assert {"dry", "hydrodynamic", "rolling", "squeeze_film"} <= set(loose["kind"]["choices"])
    assert loose["mu"]["of"] == ["dry"]
    assert "of" not in loose["speed_rpm"]


@pytest.mark.parametrize("verb", FILED)
def test_an_example_holds_only_keys_that_have_a_field(verb: str) -> None:
    held = toml_of(example(verb), f"{verb}.toml")
    tables = {table["table"]: table for table in OFFERED[verb]["tables"]}
    fields = {key["key"] for key in tables.get("", {"keys": []})["keys"]}
    assert {name for name, value in held.items() if name not in tables} <= fields


@pytest.mark.parametrize(
    ("verb", "options", "says"),
    [
        ("study", {"samples": "many"}, "samples is 'many'; expected int"),
        ("study", {"samples": True}, "samples is True; expected int"),
        ("study", {"cluster": "tcp://other"}, "study has no option cluster"),
        ("forces", {"factors": [0.5, "half"]}, "expected numbers"),
        ("cycle", {"flexible": 1}, "flexible is 1; expected bool"),
        ("orders", {}, "record is missing"),
        ("orders", {"record": "../run.csv"}, "record must be the name of a file in the project"),
        ("orders", {"record": "run.csv", "window": "round"}, "window is 'round'; expected hann"),
        ("orders", {"record": "run.csv", "band": [1.0]}, "band has 1 entries; expected 2"),
    ],
)
def test_an_option_of_another_kind_is_refused(
    folder: Project, verb: str, options: dict[str, Any], says: str
) -> None:
    with pytest.raises(UsageError, match=says.replace(".", r"\.")):
        keywords_of(verb, options, folder)


def test_options_become_keywords(folder: Project) -> None:
    given = {"record": "run.csv", "speed_rpm": 3000, "band": [100, 2000], "bearing": {"balls": 9}}
    assert keywords_of("orders", given, folder) == {
        **given,
        "record": str(folder.folder / "run.csv"),
        "band": (100, 2000),
    }


def test_no_file_outside_the_project_is_read(folder: Project) -> None:
    """Not by a verb's file either, nor by a job that it names."""
    held = toml_of(example("bearing"), "bearing.toml")
    outside = {"file": {**held, "history": {"file": "/etc/passwd"}}}
    assert "history.file must be" in wrong_request("bearing", outside, folder)
    (folder.folder / "job.toml").write_text('[crankshaft]\nfile = "../crank.stl"\n', encoding="utf-8")
    bench = {"file": {"engine": {"job": "job.toml"}}}
    assert "job.toml: crankshaft.file must be" in wrong_request("bench", bench, folder)
    (folder.folder / "job.toml").write_text('[crankshaft]\nfile = "job.toml"\n', encoding="utf-8")
    assert wrong_request("bench", bench, folder) == ""  # names itself: read once
    assert "the body must be" in wrong_request("rotor", {"job": {}}, folder)


CYCLE = {"bore_mm": 76.8, "compression_ratio": 13.0, "heat_J": 600.0, "firing_order": [1]}
WHOLE: dict[str, Any] = {
    **small.DRILLED,
    "crankshaft": {**small.DRILLED["crankshaft"], "density_pm_kg_m3": 20.0},
    "cycle": CYCLE,
    "strength": {"pin_fillet_mm": 2.0, "material": {"tensile_MPa": 900.0}},
}


def without(tables: dict[str, Any], path: str) -> dict[str, Any]:
    """Return a job without one key; of a table that holds no other, without that."""
    name, _, rest = path.partition(".")
    left = without(tables[name], rest) if rest else {}
    return {**{key: value for key, value in tables.items() if key != name}, **({name: left} if left else {})}


@pytest.mark.parametrize("verb", [verb for verb, each in ANALYSES.items() if each.job and each.needs])
def test_what_the_page_asks_for_is_what_the_verb_refuses_to_do_without(verb: str, tmp_path: Path) -> None:
    small.crank(tmp_path)
    for need in ANALYSES[verb].needs:
        job = without(WHOLE, need.split("|")[0])
        with pytest.raises(AutobalanceError) as refused:
            getattr(ab, verb)(_subject(verb, {"job": job, "file": {}}, tmp_path)[0])
        assert need.split("|")[0].split(".")[1] in str(refused.value)


@pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX")
def test_files_and_records_are_computed_and_drawn(app: Served) -> None:
    time_s = np.arange(0.0, 1.0, 1.0 / 1024)
    rows = [f"{t:.6f},{np.sin(2.0 * np.pi * 50.0 * t):.6f}" for t in time_s]
    app.ask("/api/files?name=run.csv", "\n".join(["t,accel [m/s2]", *rows]).encode())
    app.ask(f"/api/files?name={small.NAME}", small.crank(app.project).read_bytes())
    rotor = app.ask("/api/analyses/rotor").json["tables"]
    kept = app.ask("/api/analyses/rotor", {"tables": {**rotor, "speed_rpm": [0, 3000]}}, "PUT")
    assert "speed_rpm = [0, 3000]" in kept.json["text"]
    assert app.ask("/api/analyses/rotor").json["tables"]["speed_rpm"] == [0, 3000]
    assert app.ask("/api/analyses/rotor?example").json["tables"] == rotor
    assert app.ask("/api/analyses/rotor", {"toml": "speed_rpm ="}, "PUT").status == 400
    assert app.ask("/api/analyses/forces").status == 404
    bench = {**app.ask("/api/analyses/bench").json["tables"], "schedule": {"speeds_rpm": [3000]}}
    runs = {
        "rotor": {"file": kept.json["tables"]},
        "bench": {"file": bench},
        "orders": {"options": {"record": "run.csv", "speed_rpm": 3000}},
        "design": {
            "job": small.job(),
            "file": {
                "counterweight": [{"webs": [1, 2], "sector_deg": [100, 260], "points": 8, "symmetric": True}],
                "search": {"objectives": ["mass_g"], "evaluations": 24, "population": 8, "refine": False},
            },
        },
    }
    ids = {verb: app.ask("/api/runs", {"verb": verb, **asked}).json["id"] for verb, asked in runs.items()}
    for verb, run in ids.items():
        told = app.ended(run)
        assert told["state"] == "done", (verb, told)
        assert any(name.endswith(".svg") for name in told["files"]), (verb, told["files"])
        assert app.ask(f"/api/runs/{run}/report").json["command"] == verb
