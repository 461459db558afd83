"""Published cases of measured signals: Ruckle's engine on its stand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.signals.analysis import uncertain_ratio
from autobalance.signals.by_angle import Turning
from autobalance.signals.sines import find_sines
from autobalance.signals.sources import UNEXPLAINED, BearingSource, bearing_sources, candidates
from autobalance.signals.speed import crossings, order_lines
from tests.reference.published import check, inputs
from tests.signals import TURN, channel, instants, orders_of


def test_order_frequencies() -> None:
    """RU-10, from the peaks of a record at 2000 1/min; the document cuts them to whole hertz."""
    rpm = inputs("RU-10")["n"]
    orders = (0.5, 1.0, 2.0, 3.0, 4.0, 5.5, 8.0, 10.0)
    angle = TURN * rpm / 60.0 * instants(5.0, 2000.0)
    content = {order: (1.0 / (place + 1), 0.1 * place) for place, order in enumerate(orders)}
    peaks = find_sines(orders_of(angle, content), 2000.0)
    assert len(peaks) == len(orders)
    check("RU-10", {f"o{order:g}": peak.frequency_hz for order, peak in zip(orders, peaks, strict=True)})


def test_crossings() -> None:
    """RU-11: order 4 meets 115 Hz at 1725 1/min, not "around 1800"."""
    given = inputs("RU-11")
    wanted = ((4.0, given["f1"]), (8.0, given["f2"]), (2.0, 60.0), (5.5, 172.0), (10.0, 187.0))
    found = {
        (each.order, each.frequency_hz): each.speed_rpm for each in crossings([f for _, f in wanted], 12.0)
    }
    check("RU-11", {f"o{order:g}_{f:g}": found[order, f] for order, f in wanted})


def test_sampling() -> None:
    """RU-12: 360 values a turn; 15 s at 50 kHz; speeds from 300 to 2000 1/min in steps of 50."""
    rpm = inputs("RU-12")["n"]
    count = round(15.0 * 50e3)
    check(
        "RU-12",
        {
            "fs_angle": 360.0 * rpm / 60.0,
            "max_order_angle": 360.0 / 2.0,
            "N_time": count,
            "df": 50e3 / count,
            "speeds": len(range(300, 2001, 50)),
        },
    )


def test_ratios_of_two_configurations() -> None:
    """RU-13: the ratios come back from two records, with their uncertainty; the levels cannot be m/s²."""
    given = inputs("RU-13")
    t = instants(30.0, 2000.0)
    rng = np.random.default_rng(13)
    course = Turning.steady(2000.0, 30.0)
    lines = []
    for first, second in ((given["a1"], given["a2"]), (given["b1"], given["b2"])):
        values = orders_of(course.angle_rad(t), {1.0: (first, 0.3), 2.0: (second, -1.0)})
        found = order_lines(channel(values + 1e-6 * rng.standard_normal(len(t)), 2000.0), course, 12.0)
        assert found is not None
        lines.append(found)
    for place, name in ((1, "first"), (3, "second")):
        a, b = (complex(each.amplitudes[place]) for each in lines)
        error_a, error_b = (float(each.standard_errors()[place]) for each in lines)
        ratio, doubt = uncertain_ratio(a, b, error_a, error_b)
        assert ratio is not None
        assert doubt is not None
        expected = {"first": given["a1"] / given["b1"], "second": given["a2"] / given["b2"]}[name]
        assert abs(ratio - expected) < 4.0 * doubt < 0.02 * expected
    force = 0.116 * 0.0449 * (2000.0 * math.pi / 30.0) ** 2
    check(
        "RU-13",
        {
            "first": given["a1"] / given["b1"],
            "second": given["a2"] / given["b2"],
            "force_of_116g": force,
            "implied_mass_kg": force / given["b1"],
        },
    )


def test_bearing_order_claim() -> None:
    """RU-14: eleven balls at half speed strike 2.2 and 3.3 times a turn; order 5.5 is unexplained by them."""
    given = inputs("RU-14")
    bearing = BearingSource(round(given["N"]), given["q"], 1.0, 0.0, given["f"])
    found = {"N_f": given["N"] * given["f"], "BPFO": bearing.bpfo, "BPFI": bearing.bpfi}
    check("RU-14", {**found, "sum": bearing.bpfo + bearing.bpfi})
    sources = bearing_sources(bearing)
    assert candidates(5.5, 0.01, sources) == [UNEXPLAINED]
    assert "outer ring" in candidates(2.2, 0.01, sources)[0]


def test_uncertain_ratio_where_there_is_none() -> None:
    assert uncertain_ratio(1.0, 0.0, 0.1, 0.1) == (None, None)
    assert uncertain_ratio(1.0, 2.0, math.nan, 0.1) == (0.5, None)
    assert uncertain_ratio(3.0, 1.0, 0.03, 0.01)[1] == pytest.approx(3.0 * math.hypot(0.01, 0.01))
