"""Good results of every kind and format are believed by every verb: a handful, and those once refused."""

import random
import re
from pathlib import Path

import pytest

from autobalance.verbs.verify import verify
from tests import jobs
from tests.coarse import HALF_FINE, coarse_facets
from tests.good_results import KINDS, MESHES, faults, good_job, recut_faults

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
FALLEN = (2104593779, 738223255, 55918810, 376288791)
"""A turned rim with a flap on it; a face that ends at an earlier cut's step, a like wall on another web; a
strip at a turned rim of which a boolean drops the end; a film beside a second stage's hole, all slivers."""


@pytest.mark.parametrize(("kind", "ending"), list(zip(KINDS, MESHES, strict=True)))
def test_a_good_result_is_believed(kind: str, ending: str, tmp_path: Path) -> None:
    draw = random.Random(f"{kind} as {ending}")
    good = good_job(tmp_path, draw, kind, ending, "single")
    assert faults(good, draw) == []
    assert jobs.report_of(tmp_path / "out")["corrections"]


@pytest.mark.parametrize("seed", FALLEN)
def test_a_good_result_that_was_refused_is_believed(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    assert faults(good_job(tmp_path, draw), draw) == []


def test_a_further_stage_of_a_step_file_with_slugs_is_believed(tmp_path: Path) -> None:
    draw = random.Random(13)
    good = good_job(tmp_path, draw, "slug", "step", "single")
    text = good.job.read_text(encoding="utf-8")
    good.job.write_text(text.replace("[8.0, 10.0, 12.0]", "[10.0, 12.0]"), encoding="utf-8")
    with coarse_facets(HALF_FINE), jobs.without_advice():
        assert jobs.run("balance", good.job, "-o", tmp_path / "out", "--no-report") in (0, 4)
        first = jobs.report_of(tmp_path / "out")
        assert recut_faults(tmp_path / "out", first, draw) == []
    second = jobs.report_of(tmp_path / "out" / "stage-2")
    assert [each["kind"] for each in first["corrections"]] == ["slug", "slug"]
    assert [each["kind"] for each in second["corrections"]] == ["slug", "slug"]


def test_loads_with_gas_of_a_step_file_are_those_of_the_written_file(tmp_path: Path) -> None:
    """Of several mains, with bores for slugs: the planner's own facets differ by 2e-5 from a reader's."""
    draw = random.Random(5)
    good = good_job(tmp_path, draw, "slug", "step", "parallel-twin-360")
    text = re.sub(r"grade = \S+", "grade = 6.3", good.job.read_text(encoding="utf-8"))
    cycle = "bore_mm = 70.0\ncompression_ratio = 10.0\nheat_J = 500.0\nfiring_order = [1, 2]\n"
    text = text if "[cycle]" in text else text.replace("[balance]", f"[cycle]\n{cycle}[balance]")
    good.job.write_text(text, encoding="utf-8")
    with coarse_facets(HALF_FINE), jobs.without_advice():  # of the usual facets it takes four times as long
        assert jobs.run("balance", good.job, "-o", tmp_path / "out", "--no-report") in (0, 4)
        held = verify(tmp_path / "out" / "report.json")
    assert held.holds
    assert held.warnings == ()
    assert jobs.report_of(tmp_path / "out")["corrections"]
    loads = [each for each in held.claims if each.name.startswith("loads_with_gas.after.main_journals")]
    assert len(loads) >= 8
    for each in loads:
        assert each.measured == pytest.approx(each.value, rel=1e-9), each.name
