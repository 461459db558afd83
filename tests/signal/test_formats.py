"""Records from files: what is read, and what each refusal says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat, wavfile

from autobalance.errors import FileError, FormatError
from autobalance.signals.formats import read
from autobalance.signals.record import named
from tests.libraries import uninstalled
from tests.signals import instants, write_csv

RATE = 1000.0
T = instants(2.0, RATE)
X = np.sin(100.0 * T)


def _text(path: Path, separator: str, decimal: str, head: str, end: str = "\n") -> Path:
    rows = (f"{a:.6f}{separator}{b:.9g}".replace(".", decimal) for a, b in zip(T, X, strict=True))
    path.write_text(end.join([head, *rows]), encoding="utf-8", newline="")
    return path


@pytest.mark.parametrize(
    ("separator", "decimal", "head", "end", "unit"),
    [
        (",", ".", "time_s,accel_g", "\n", "g"),
        (",", ".", "time_s,accel [m/s2]", "\r\n", "m/s2"),
        (";", ",", "time_s;accel_mm_s", "\n", "mm/s"),
        ("\t", ".", "time_s\taccel (µm)", "\n", "µm"),
        (",", ".", "# taken on Tuesday\ntime,accel\ns,V", "\n", "V"),
    ],
)
def test_csv(tmp_path: Path, separator: str, decimal: str, head: str, end: str, unit: str) -> None:
    [channel] = read(_text(tmp_path / "r.csv", separator, decimal, head, end)).channels
    assert (channel.name, channel.unit, channel.sample_rate_hz) == ("accel", unit, RATE)
    assert channel.values() == pytest.approx(X, abs=1e-8)


def test_names_and_units() -> None:
    assert named("accel") == ("accel", None)
    assert named("accel_x") == ("accel_x", None)
    assert named("bearing_2_m_s2") == ("bearing_2", "m/s2")
    assert named("x_um") == ("x", "um")
    assert named('"Force [kN]"') == ("Force", "kN")


def test_two_columns_of_one_name_keep_their_headers(tmp_path: Path) -> None:
    record = read(write_csv(tmp_path / "r.csv", {"time_s": T, "probe_V": X, "probe_mm": X}))
    assert [channel.name for channel in record.channels] == ["probe_V", "probe_mm"]
    assert record.channel("probe_mm").unit == "mm"


def test_rate_from_coarse_times(tmp_path: Path) -> None:
    rows = "\n".join(f"{k / 44100:.5f},{v:.6g}" for k, v in enumerate(X))
    (tmp_path / "r.csv").write_text("time_s,accel_g\n" + rows)
    assert read(tmp_path / "r.csv").channels[0].sample_rate_hz == 44100.0


def test_gap_in_time_and_cells_without_a_number(tmp_path: Path) -> None:
    rows = [f"{a:.3f},{b:.6f},note {k}" for k, (a, b) in enumerate(zip(T, X, strict=True))]
    rows[100], rows[200] = "0.100,nan,x", "0.200,,x"
    del rows[500:510]
    (tmp_path / "r.csv").write_text("time_s,accel_g,remark\n" + "\n".join(rows))
    record = read(tmp_path / "r.csv")
    [channel] = record.channels
    holes = np.flatnonzero(np.isnan(channel.values()))
    assert holes.tolist() == [100, 200, *range(500, 510)]
    assert channel.values()[510:] == pytest.approx(X[510:], abs=1e-6)
    assert record.notes == (
        "column 'remark' is text and was left out",
        "gap: 10 samples are missing in 1 places, first after 0.499 s",
    )


def test_record_by_angle(tmp_path: Path) -> None:
    angle = np.arange(0.0, 3600.0, 1.0) + 90.0
    record = read(write_csv(tmp_path / "r.csv", {"angle_deg": angle, "accel_g": np.cos(np.radians(angle))}))
    assert record.samples_per_turn == pytest.approx(360.0)
    assert record.start_angle_deg == 90.0
    # RU-12: 360 samples a turn at 2000 1/min are 12 kHz.
    assert record.at_speed(2000.0).channels[0].sample_rate_hz == pytest.approx(12_000.0)


@pytest.mark.parametrize(
    ("kind", "full"),
    [(np.int16, 32768), (np.uint8, 128), (np.int32, 2**31), (np.float32, 1), (np.float64, 1)],
)
def test_wav(tmp_path: Path, kind: type, full: int) -> None:
    stored = 0.5 * X * full + (128 if kind is np.uint8 else 0)
    wavfile.write(tmp_path / "r.wav", 1000, np.stack([stored, stored], axis=1).astype(kind))
    record = read(tmp_path / "r.wav")
    assert [channel.name for channel in record.channels] == ["1", "2"]
    assert record.channels[1].values() == pytest.approx(0.5 * X, abs=1.0 / full if full > 1 else 1e-7)
    assert record.channels[1].sample_rate_hz == RATE


def test_wav_of_24_bit(tmp_path: Path) -> None:
    values = np.round(0.5 * X * (1 << 23)).astype("<i4")
    raw = values.view(np.uint8).reshape(-1, 4)[:, :3].tobytes()
    head = b"RIFF" + (36 + len(raw)).to_bytes(4, "little") + b"WAVEfmt " + (16).to_bytes(4, "little")
    head += b"".join(
        n.to_bytes(s, "little") for n, s in ((1, 2), (1, 2), (1000, 4), (3000, 4), (3, 2), (24, 2))
    )
    (tmp_path / "r.wav").write_bytes(head + b"data" + len(raw).to_bytes(4, "little") + raw)
    assert read(tmp_path / "r.wav").channels[0].values() == pytest.approx(0.5 * X, abs=2.0**-23)


def test_mat(tmp_path: Path) -> None:
    savemat(
        tmp_path / "r.mat",
        {"fs": RATE, "accel": X, "row": X[None, :], "name": "abc", "square": np.eye(3), "k": 3.0},
    )
    record = read(tmp_path / "r.mat")
    assert sorted(channel.name for channel in record.channels) == ["accel", "row"]
    assert record.channel("row").values() == pytest.approx(X)
    savemat(tmp_path / "n.mat", {"accel": X})
    with pytest.raises(FormatError, match=r"n.mat holds no sample rate; give --sample-rate HZ"):
        read(tmp_path / "n.mat")
    assert read(tmp_path / "n.mat", 500.0).channels[0].sample_rate_hz == 500.0


def test_tdms(tmp_path: Path) -> None:
    nptdms = pytest.importorskip("nptdms")
    properties = {"wf_increment": 1e-3, "unit_string": "g"}
    with nptdms.TdmsWriter(tmp_path / "r.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject("group", "accel", X, properties=properties)])
    [channel] = read(tmp_path / "r.tdms").channels
    assert (channel.name, channel.unit) == ("accel", "g")
    assert channel.sample_rate_hz == pytest.approx(RATE)
    assert channel.values() == pytest.approx(X)


def test_uff58(tmp_path: Path) -> None:
    pyuff = pytest.importorskip("pyuff")
    record: dict[str, Any] = {
        "type": 58, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1,
        "data": X, "x": T,
        "id1": "accel", "rsp_ent_name": "n", "ref_ent_name": "n", "abscissa_spacing": 1, "abscissa_min": 0.0,
        "abscissa_inc": 1e-3, "num_pts": len(X), "ord_data_type": 4, "abscissa_spec_data_type": 17,
        "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 0, "binary": 0,
    }  # fmt: skip
    pyuff.UFF(str(tmp_path / "r.uff")).write_sets(record, "add")
    [channel] = read(tmp_path / "r.uff").channels
    assert channel.name == "accel"
    assert channel.sample_rate_hz == pytest.approx(RATE)
    assert channel.values() == pytest.approx(X)


@pytest.mark.parametrize(
    ("module", "ending", "package"), [("nptdms", "tdms", "npTDMS"), ("pyuff", "uff", "pyuff")]
)
def test_extra_that_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, ending: str, package: str
) -> None:
    uninstalled(monkeypatch, module)
    (tmp_path / f"r.{ending}").write_bytes(b"x")
    with pytest.raises(
        FormatError, match=rf"need {package}, which is not installed: pip install 'autobalance\[signals\]'"
    ):
        read(tmp_path / f"r.{ending}")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("r.csv", b"", "is empty"),
        ("r.csv", b"time_s,accel_g\n", "has a header and no numbers"),
        ("r.csv", b"0.0,1.0\n0.1,2.0\n", "has no header: its first line is numbers"),
        ("r.csv", b"accel_g\n1.0\n2.0\n", "has no column time_s and holds no sample rate"),
        ("r.csv", b"time_s,accel_g\n0,1\n0.1\n", "data row 2 has 1 cells; the header has 2"),
        ("r.csv", b"time_s,accel_g\n0,1\n0.1,1\n0.05,1\n", "the time does not grow in data row 3"),
        ("r.csv", b"time_s,accel_g\n0,1\n1e300,1\n2e300,1\n", r"time steps are 1e\+300 s; expected 1e-12 to"),
        ("r.csv", b"time_s,accel_g\n0,1\n0.1,1\n0.23,1\n0.3,1\n", "time steps are uneven"),
        ("r.csv", b"time_s,accel_g\n0,1\nx,1\n0.2,1\n", "has no time in data row 2"),
        ("r.csv", b"\0\1\2", "is not a text file"),
        ("r.csv", b"angle_deg,accel_g\n0,1\n1,1\n5,1\n", "the angle does not grow in even steps"),
        ("r.wav", b"RIFX....", "is not a WAV file"),
        ("r.wav", b"RIFF\4\0\0\0WAVE", "is a WAV file without samples"),
        ("r.mat", b"not a matlab file at all" * 20, "is not a MATLAB file of version 5"),
        ("r.tdms", b"nonsense, not TDMS", "is not a TDMS file that can be read"),
        ("r.uff", b"nonsense", "holds no channel of numbers|is not a universal file"),
        ("r.dat", b"", "is not a record that can be read"),
    ],
)
def test_refused_with_one_line(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError, match=words) as caught:
        read(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_rates_that_contradict(tmp_path: Path) -> None:
    write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": X})
    with pytest.raises(FormatError, match="has a sample rate of 1000 Hz; --sample-rate is 500"):
        read(tmp_path / "r.csv", 500.0)
    with pytest.raises(FormatError, match="sample rate is -1 Hz"):
        read(tmp_path / "r.csv", -1.0)
    with pytest.raises(FileError, match="no such file"):
        read(tmp_path / "none.csv")
