"""Measured pressures: cycles cut, averaged, shifted, smoothed, levelled; and the files they come in."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from autobalance.engines.cycle.closed_part import Chamber, Charge, Wiebe
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange
from autobalance.engines.cycle.trace import PressureTrace, read_trace
from autobalance.errors import FileError, FormatError
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.types import Array

BAR = 0.1
FOUR, TWO = 4.0 * math.pi, 2.0 * math.pi
BOTTOM = np.radians(np.linspace(-185.0, -175.0, 401))
CHAMBER = Chamber(SliderCrank(43.0, 140.0, 4.0), 86.0, 10.0)
EXCHANGE = GasExchange(4, BAR, 1.1 * BAR, BAR)
CHARGE = Charge(BAR, 330.0, 1.35)
MODEL = CylinderCycle.modelled(CHAMBER, EXCHANGE, CHARGE, Wiebe(-0.2, 0.8, 5.0, 3.0, 9e5), None)


def measured(trace: PressureTrace, exchange: GasExchange = EXCHANGE) -> CylinderCycle:
    return CylinderCycle.measured(CHAMBER, exchange, CHARGE, trace)


def angles(low_deg: float, high_deg: float, step_deg: float = 0.5) -> Array:
    result: Array = np.radians(np.arange(low_deg, high_deg + 1e-9, step_deg))
    return result


def test_a_trace_of_the_model_gives_its_work_back_quadratically() -> None:
    off = []
    for step in (2.0, 1.0, 0.5):
        at = angles(-360.0, 360.0 - step, step)
        off.append(
            abs(
                measured(PressureTrace.cut(at, MODEL.pressure_mpa(at), FOUR)).work_n_mm / MODEL.work_n_mm
                - 1.0
            )
        )
    assert off[-1] < 2e-3
    assert off[0] > off[1] > off[2]


@pytest.mark.parametrize("first_deg", [-360.0, 0.0, -100.0])
@pytest.mark.parametrize("repeated", [False, True])
def test_one_cycle_may_start_anywhere_and_repeat_its_end(first_deg: float, repeated: bool) -> None:
    at = angles(first_deg, first_deg + 720.0 - (0.0 if repeated else 0.5))
    trace = PressureTrace.cut(at, MODEL.pressure_mpa(at), FOUR)
    assert trace.angle_rad.size == 1440
    asked = np.linspace(-6.0, 6.0, 50)
    even = angles(-360.0, 359.5)
    expected = np.interp(asked, even, MODEL.pressure_mpa(even))
    assert measured(trace).pressure_mpa(asked) == pytest.approx(expected, rel=1e-9)
    assert measured(trace).torque_work_n_mm == pytest.approx(measured(trace).work_n_mm, rel=1e-9)


def test_whole_cycles_on_end_are_averaged_and_their_scatter_told() -> None:
    at = angles(-360.0, 4 * 720.0 - 360.5)
    share = np.repeat([0.8, 1.0, 1.3, 0.9], 1440)
    one = MODEL.pressure_mpa(at)
    trace = PressureTrace.cut(at, BAR + share * (one - BAR), FOUR)
    assert trace.pressure_mpa.shape == (4, 1440)
    np.testing.assert_allclose(trace.mean_mpa, BAR + (one[:1440] - BAR), rtol=1e-8)
    alone = [
        measured(PressureTrace.cut(at[:1440], BAR + each * (one[:1440] - BAR), FOUR))
        for each in share[::1440]
    ]
    spread = np.std([each.mean_pressure_mpa() for each in alone])
    assert measured(trace).scatter_mpa() == pytest.approx(float(spread), rel=1e-3)
    assert alone[0].scatter_mpa() is None


def test_the_closed_part_of_a_four_stroke_is_enough() -> None:
    at = angles(-180.0, 180.0)
    found = measured(PressureTrace.cut(at, MODEL.pressure_mpa(at - 1e-6), FOUR))
    assert found.work_n_mm == pytest.approx(MODEL.work_n_mm, rel=1e-3)
    assert found.pumping_work_n_mm == pytest.approx(MODEL.pumping_work_n_mm, rel=5e-2)
    assert found.pressure_mpa(np.radians([190.0, 359.0, 361.0, -190.0])).tolist() == [
        1.1 * BAR, 1.1 * BAR, BAR, BAR,
    ]  # fmt: skip
    assert found.torque_work_n_mm == pytest.approx(found.work_n_mm, rel=1e-9)


def test_shift_level_and_smoothing() -> None:
    at = angles(-360.0, 359.5)
    pressure = MODEL.pressure_mpa(at)
    shifted = PressureTrace.cut(at - math.radians(3.0), pressure, FOUR).shifted(math.radians(3.0))
    assert shifted.at(at) == pytest.approx(pressure, rel=1e-9)
    gauge = PressureTrace.cut(at, pressure - 0.37, FOUR)
    levelled = gauge.levelled(BAR)
    assert np.ptp(levelled.at(at) - pressure) == pytest.approx(0.0, abs=1e-12)
    assert float(levelled.at(np.radians(np.linspace(-185.0, -175.0, 401))).mean()) == pytest.approx(
        BAR, rel=1e-3
    )
    noise = 0.02 * np.random.default_rng(3).standard_normal(at.size)
    smooth = PressureTrace.cut(at, pressure + noise, FOUR).smoothed(math.radians(6.0))
    away = smooth.at(at) - pressure
    closed = np.abs(at) < 3.0  # away from the jump where the exhaust opens
    assert float(away[closed].std()) < 0.5 * float(noise.std())


def test_two_strokes_wrap_the_place_of_the_level() -> None:
    at = angles(-180.0, 179.0, 1.0)
    trace = PressureTrace.cut(at, 2.0 + np.cos(at), TWO).levelled(BAR)
    assert float(trace.at(np.radians(np.linspace(-185.0, -175.0, 401))).mean()) == pytest.approx(
        BAR, rel=1e-4
    )


@pytest.mark.parametrize(
    ("at", "text"),
    [
        (
            np.concatenate([angles(-360.0, 10.0), angles(30.0, 360.0)]),
            "no row between 10° and 30°",
        ),
        (
            angles(-360.0, 200.0),
            "covers 560°, from -360° to 200°; expected whole cycles of 720° or the closed part",
        ),
        (angles(0.0, 360.0), "covers 360°, from 0° to 360°"),
        (angles(0.0, 1100.0), "covers 1100°"),
        (np.array([0.0, 0.1, 0.1, 0.2]), "angles must increase"),
        (np.array([0.0, 0.1]), "has 2 rows"),
    ],
)
def test_traces_that_are_no_cycle_are_refused(at: Array, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        PressureTrace.cut(at, np.ones(at.size), FOUR)


def test_gauge_pressures_are_refused() -> None:
    at = angles(-360.0, 359.5)
    with pytest.raises(ValueError, match="pressures must be absolute, ≥ 0"):
        PressureTrace.cut(at, MODEL.pressure_mpa(at) - 0.2, FOUR).check_absolute()
    part = angles(-172.0, 180.0)
    with pytest.raises(ValueError, match="holds nothing between −185° and −175°"):
        PressureTrace.cut(part, np.ones(part.size), FOUR).levelled(BAR)


# --- files --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("angle", "pressure", "per_rad", "per_mpa"),
    [
        ("angle_deg", "pressure_bar", 180.0 / math.pi, 10.0),
        ("angle_rad", "pressure_kPa", 1.0, 1e3),
        ("angle_deg", "pressure_MPa", 180.0 / math.pi, 1.0),
        ("angle_rad", "pressure_Pa", 1.0, 1e6),
        ("angle_deg", "pressure_psi", 180.0 / math.pi, 145.03773773020923),
    ],
)
def test_any_unit_that_the_header_names(
    tmp_path: Path, angle: str, pressure: str, per_rad: float, per_mpa: float
) -> None:
    at, mpa = np.array([-0.5, 0.0, 0.75]), np.array([0.1, 5.0, 0.2])
    for separator in ",;\t":
        rows = [separator.join(("n", angle, pressure))]
        for a, p in zip(at * per_rad, mpa * per_mpa, strict=True):
            rows.append(separator.join(("x", repr(float(a)), repr(float(p)))))
        file = tmp_path / "p.csv"
        file.write_text("\ufeff" + "\n\n".join(rows) + "\n", "utf-8")
        found = read_trace(file)
        assert found[0] == pytest.approx(at, rel=1e-12)
        assert found[1] == pytest.approx(mpa, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "is empty"),
        ("angle_deg,pressure_bar\n", "a header and no rows"),
        ("angle,pressure_bar\n1,2\n", "expected one of angle_deg, angle_rad"),
        ("angle_deg,pressure\n1,2\n", "one of pressure_bar, pressure_kPa, pressure_MPa, pressure_Pa"),
        ("angle_deg,pressure_bar,pressure_kPa\n1,2,3\n", "has pressure_bar and pressure_kPa"),
        ("angle_deg,pressure_bar\n1,two\n", "line 2 has 'two' in column 2"),
        ("angle_deg,pressure_bar\n1,nan\n", "line 2 has 'nan'"),
        ("angle_deg,pressure_bar\n1\n", "line 2 has '' in column 2"),
    ],
)
def test_files_that_are_no_trace_are_refused(tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "p.csv"
    file.write_text(text, "utf-8")
    with pytest.raises(FormatError, match=reason):
        read_trace(file)


def test_a_trace_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"cannot read the trace .*none.csv: no such file"):
        read_trace(tmp_path / "none.csv")
    (tmp_path / "b.csv").write_bytes(b"angle_deg,\xff\xfe")
    with pytest.raises(FormatError, match="not UTF-8 text at byte 10"):
        read_trace(tmp_path / "b.csv")
