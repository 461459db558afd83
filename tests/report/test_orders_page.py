"""The page of a record in a real browser: curves are drawn, zooming works, no network is asked."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import autobalance as ab
from tests.report.browser import Browser, browser, missing
from tests.signals import TURN, instants, orders_of, ramp, smooth_tacho

pytestmark = pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()} (script/test-tools)")

INK = """const c = document.querySelector(arguments[0]);
const p = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
let n = 0; for (let k = 3; k < p.length; k += 4) n += p[k] > 0; return n / (p.length / 4);"""


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    folder = tmp_path_factory.mktemp("page")
    t = instants(20.0, 5000.0)
    angle = ramp(t, 15.0, 30.0)
    values = orders_of(angle, {1.0: (0.5, 0.3), 2.0: (0.2, -1.0)}) + 0.1 * np.cos(TURN * 50.0 * t)
    record = {"accel_g": values, "tacho_V": smooth_tacho(angle)}
    ab.orders(record, sample_rate=5000.0, tacho="tacho").write(folder)
    with browser(tmp_path_factory.mktemp("profile")) as found:
        found.resize(1250, 1500)
        found.open(folder / "orders.html")
        # curves are drawn with the first frame, which a busy machine shows after the page has loaded
        found.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        yield found


def test_curves_are_drawn_and_nothing_is_asked_for(window: Browser) -> None:
    assert [entry for entry in window.log("browser") if entry["level"] in ("SEVERE", "WARNING")] == []
    assert window.requests() == []
    for curve in ("record", "spectrum"):
        assert window.run(INK, f"canvas[data-curve={curve}]") > 0.01
    assert "order 1 is the strongest" in window.run("return document.querySelector('h1').textContent")


def test_keys_zoom_and_move(window: Browser) -> None:
    span = "const [a, b] = autobalanceOrders.record.range(); return [a, b];"
    assert window.run(span) == pytest.approx([0.0, 20.0])
    window.press("canvas[data-curve=record]", "++")
    first, last = window.run(span)
    assert last - first == pytest.approx(20.0 * 0.36)
    assert 0.5 * (first + last) == pytest.approx(10.0)
    window.press("canvas[data-curve=record]", "0")
    assert window.run(span) == pytest.approx([0.0, 20.0])


def test_no_zoom_leaves_the_record(window: Browser) -> None:
    window.run("autobalanceOrders.spectrum.look(-50, 1e9)")
    first, last = window.run("return autobalanceOrders.spectrum.range()")
    assert first == 0.0
    assert last == pytest.approx(2500.0, rel=1e-3)
    window.run("autobalanceOrders.record.look(3, 3)")
    first, last = window.run("return autobalanceOrders.record.range()")
    assert last - first == pytest.approx(8.0 / 5000.0)
