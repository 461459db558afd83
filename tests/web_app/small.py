"""A crank of a few hundred triangles and its job, for tests of the page: its runs take no time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests import jobs
from tests.cranks import Shape, make_crank
from tests.web_app.serving import Served

NAME = "small.stl"


def crank(folder: Path) -> Path:
    """Write a crank of one throw, drawn with a coarse compass."""
    solid, _ = make_crank([0.0], Shape(segments=24))
    jobs.write_stl(folder / NAME, solid.mesh.corners)
    return folder / NAME


def job(**tables: Any) -> dict[str, Any]:
    """Return a job that two faces of the counterweights can do; tables replace its own."""
    return {
        "crankshaft": {"file": NAME, "unit": "mm", "density_kg_m3": 7850.0},
        "engine": {"rotating_g": {"rod": 400.0}, "reciprocating_g": {"piston": 500.0}},
        "balance": {"factor": 0.5, "grade": 16.0, "speed_rpm": 6000.0},
        "correction": {"method": "shoulder"},
        **tables,
    }


def ran(app: Served, verb: str, asked: dict[str, Any]) -> str:
    """Run something on the small crank, without the page; return its id."""
    answer = app.ask("/api/runs", {"verb": verb, "job": asked})
    assert answer.status == 202, answer.body
    told = app.ended(answer.json["id"])
    assert told["state"] == "done", told
    run: str = told["id"]
    return run


DRILLED = job(
    engine={**job()["engine"], "rod_length_mm": 110.0},
    balance={"factor": 0.25, "grade": 16.0, "speed_rpm": 6000.0},
    correction={"method": "drill", "drill": {"diameters_mm": [12.0, 13.0], "max_holes": 2}},
)
"""Two holes in the counterweights do it."""
