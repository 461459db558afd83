"""Metal proposed on counterweights that are too light: each proposal, run as it says, keeps what it says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import autobalance as ab

pytestmark = pytest.mark.usefixtures("cranks_read_once")

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = {loads_g}
[engine.reciprocating_g]
piston = {loads_g}
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 6500
[correction]
method = "drill"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made: Path = tmp_path_factory.mktemp("twin")
    crank = ab.generate("parallel-twin-360", file="crank.stl", settings={"segments": 24})
    (made / "crank.stl").write_bytes(crank.data)
    return made


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loads_g", "is_enough"),
    [(300.0, True), (700.0, False)],
    ids=["a little", "more than the journals leave room for"],
)
def test_metal_proposed_leaves_a_crank_within_tolerance(
    loads_g: float, is_enough: bool, folder: Path
) -> None:
    """Pads beside filleted journals, on a V8 15 to 21 mm high, left no crank; they were proposed."""
    job = folder / "job.toml"
    job.write_text(JOB.format(loads_g=loads_g), encoding="utf-8")
    refused = ab.balance(ab.read_job(job))
    assert refused.outcome == "above_tolerance"
    ways = [
        way
        for way in refused.report["relaxations"]
        if any(change["key"].startswith("correction.add.") for change in way["changes"])
    ]
    assert bool(ways) is is_enough, refused.reason
    for way in ways:
        settings = [f"{change['key']}={json.dumps(change['proposed'])}" for change in way["changes"]]
        got = ab.balance(ab.read_job(job, settings))
        assert got.outcome == "within_tolerance", settings
        put_on_g = -sum(each["removed_mass_g"] for each in got.report["corrections"])
        assert put_on_g == pytest.approx(way["metal_g"], rel=0.01)
