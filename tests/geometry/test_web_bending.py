"""How the rods bend the webs: sections by closed form, finite elements before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank_dynamics.strength.bending import Bending as BendingRecord
from autobalance.crank_dynamics.strength.bending import bending as bending_of
from autobalance.crank_dynamics.strength.bending import bending_text, weakest_section_MPa
from autobalance.declare import decoded
from autobalance.errors import SolidError
from autobalance.finite_elements import throws
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from tests.cranks import Shape, make_crank
from tests.jobs import whole_job

MOMENT_N_MM, FORCE_N = 50_000.0, 1000.0


def test_the_weakest_section_of_a_bar_is_that_of_a_beam() -> None:
    """A web of 30 × 12 mm, then with a hole of 8 mm through it halfway."""
    _, anatomy = make_crank([0.0], Shape(segments=24))
    throw, web = anatomy.throws[0], anatomy.webs[0]
    low, high = web.z_min_mm, web.z_max_mm
    wide, thick = 30.0, high - low
    bar = Solid.box(np.array([-20.0, -0.5 * wide, low]), np.array([60.0, 0.5 * wide, high]))
    nominal = 6.0 * MOMENT_N_MM / (wide * thick**2) + FORCE_N / (wide * thick)
    assert weakest_section_MPa(bar, throw, web, MOMENT_N_MM, FORCE_N) == pytest.approx(nominal, rel=1e-6)
    hole = Region.circle(4.0, 256, (0.5 * throw.crank_radius_mm, 0.0))
    drilled = bar - Solid.prism(hole, low - 1.0, high + 1.0)
    stress = weakest_section_MPa(drilled, throw, web, MOMENT_N_MM, FORCE_N)
    assert stress == pytest.approx(nominal * wide / (wide - 8.0), rel=1e-3)


def test_balance_shows_stress_before_and_after(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("netgen")
    job = ab.read_job(whole_job(tmp_path, "straight"))  # pressed up: its crankpin is put in
    result = ab.balance(job, fem=True)
    report = result.report
    bending = report["bending"]
    radius = report["crank"]["throws"][0]["crank_radius_mm"]
    assert bending["force_N"] == pytest.approx([395.54 * radius * (15200.0 * np.pi / 30.0) ** 2 * 1e-6])
    assert [each["web"] for each in bending["webs"]] == [1, 2]
    for web in bending["webs"]:  # lower shoulders take nothing from between journal and crankpin
        assert web["after_MPa"] == pytest.approx(web["before_MPa"], rel=1e-6)
    elements = bending["elements"]
    assert elements["failed"] is None
    assert elements["after_MPa"] == pytest.approx(elements["before_MPa"], rel=0.1)  # as the summary says
    nominal = max(each["before_MPa"] for each in bending["webs"])
    assert 0.25 * nominal < elements["before_MPa"] < 2.0 * nominal
    text = bending_text(decoded(BendingRecord, bending))
    assert "throw 1, finite elements" in text
    assert f"{elements['nodes']} nodes" in text

    def fails(*_: object, **__: object) -> None:
        raise SolidError("the mesher ended with exit code -6")

    monkeypatch.setattr(throws, "bodies_of_solid", fails)
    refused = bending_of(result.before.measured, None, bending["force_N"])
    assert isinstance(refused, BendingRecord)
    assert [each.before_MPa for each in refused.webs] == [each["before_MPa"] for each in bending["webs"]]
    assert "no finite elements of throw 1: the mesher ended with exit code -6" in bending_text(refused)
