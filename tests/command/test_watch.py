"""A machine's lines followed until they settle: from a file, and over a pseudo-terminal."""

from __future__ import annotations

import builtins
import os
import re
import threading
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from autobalance.command.main import main
from autobalance.test_stands.machine.watch import GLYPHS, big_text, big_vectors, vectors_text
from tests import jobs

MACHINE = """
speed_rpm = 600.0
[machine.line]
pattern = '(?P<plane>L|R) *= *(?P<amount>[0-9.,]+) *@ *(?P<angle>[0-9.]+)'
planes = ["L", "R"]
settled_readings = 3
[reading]
umar_g_mm = 0.2
rotation = "cw"
"""
LINES = ["starting", "L = 99.0 @ 10", "R = 12,00 @ 40"]
LINES += [line for _ in range(3) for line in ("L = 35.1 @ 191.0", "? noise", "R = 12.05 @ 40.0")]


def machine(folder: Path, text: str = MACHINE) -> str:
    path = folder / "machine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_vectors_settle_and_become_a_reading(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = tmp_path / "lines.txt"
    lines.write_text("\n".join(LINES) + "\n", encoding="utf-8")
    assert main(["machine", machine(tmp_path), "--watch", str(lines), "-o", str(tmp_path / "out")]) == 0
    assert "settled: A 35.1 g·mm at 191°" in capsys.readouterr().out
    reading = tomllib.loads((tmp_path / "out" / "reading.toml").read_text(encoding="utf-8"))
    assert [(each["at"], each["g_mm"], each["angle_deg"]) for each in reading["plane"]] == [
        ("A", pytest.approx(35.1), pytest.approx(191.0)),
        ("B", pytest.approx((12.0 + 2 * 12.05) / 3, abs=1e-6), pytest.approx(40.0)),
    ]
    assert (reading["umar_g_mm"], reading["urr_percent"], reading["rotation"]) == (0.2, 95.0, "cw")


def test_ctrl_c_and_a_folder_that_cannot_be_written_leave_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = tmp_path / "lines.txt"
    lines.write_text("L = 35.1 @ 191.0\n", encoding="utf-8")

    def pressed(_: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(time, "sleep", pressed)
    file = machine(tmp_path)
    assert main(["machine", file, "--watch", str(lines), "-o", str(tmp_path / "out")]) == 130
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert sorted(each.name for each in tmp_path.iterdir()) == ["lines.txt", "machine.toml"]
    (tmp_path / "out").write_text("", encoding="utf-8")
    assert main(["machine", file, "--watch", str(lines), "-o", str(tmp_path / "out")]) == 3  # before any line
    assert "it is a file, not a folder" in capsys.readouterr().err


def test_what_does_not_settle_is_said_with_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = tmp_path / "lines.txt"
    for text, said in (
        ("L = 1 @ 2\n", "did not settle in 0.3 s"),
        ("nothing\n", "no line in 0.3 s matches machine.line.pattern"),
    ):
        lines.write_text(text, encoding="utf-8")
        assert main(["machine", machine(tmp_path), "--watch", str(lines), "--timeout", "0.3"]) == 3
        assert said in capsys.readouterr().err
    assert not (tmp_path / "reading.toml").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed_rpm = 600.0\n", "[machine.line] is missing; expected a pattern"),
        ("[machine.line]\npattern = '(?P<amount>'\n", "is not a pattern"),
        ("[machine.line]\npattern = '(?P<amount>.)'\n", "has the groups amount; expected"),
        (
            "[machine.line]\npattern = '(?P<amount>.)(?P<angle>.)'\nunit = 'furlong'\n",
            "machine.line.unit is 'furlong'; must be one of",
        ),
    ],
)
def test_lines_that_cannot_be_read(
    text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["machine", machine(tmp_path, text), "--watch", str(tmp_path / "lines.txt")]) == 3
    assert said in capsys.readouterr().err


def test_a_source_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["machine", machine(tmp_path), "--watch", str(tmp_path / "none.txt")]) == 3
    assert "cannot read" in capsys.readouterr().err
    assert main(["machine", machine(tmp_path), "--report", "report.json"]) == 2


def test_lines_over_a_pseudo_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("serial")
    control, line = os.openpty()

    def written() -> None:
        for text in LINES:
            os.write(control, f"{text}\r\n".encode())
            time.sleep(0.01)

    writer = threading.Thread(target=written)
    writer.start()
    try:
        source = f"serial:{os.ttyname(line)}:9600"
        code = main(["machine", machine(tmp_path), "--watch", source, "-o", str(tmp_path), "--timeout", "10"])
    finally:
        writer.join()
        os.close(control)
        os.close(line)
    assert code == 0
    assert "settled: A 35.1 g·mm at 191°   B 12.0 g·mm at 40°" in capsys.readouterr().out


def test_the_settled_reading_goes_on_to_recut(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path)
    with jobs.without_advice():
        jobs.computed(job, tmp_path / "done")
    lines = tmp_path / "lines.txt"
    lines.write_text(3 * "L = 0.0 @ 0\nR = 0.1 @ 90\n", encoding="utf-8")
    report = str(tmp_path / "done" / "report.json")
    arguments = ["machine", machine(tmp_path), "--watch", str(lines), "-o", str(tmp_path), "--report", report]
    capsys.readouterr()
    assert main(arguments) == 0
    assert re.search(r"^WITHIN TOLERANCE, .*\n.*: nothing to cut$", capsys.readouterr().out, re.MULTILINE)


def test_large_vectors_have_a_glyph_for_every_sign() -> None:
    text = big_vectors({"A": 35.1 + 0.0j, "B": 0.0 + 12.0j})
    assert len(text.splitlines()) == 11
    assert {len(row) for glyph in GLYPHS.values() for row in glyph} <= {2, 3}
    assert all(len({len(row) for row in glyph}) == 1 for glyph in GLYPHS.values())


def test_nothing_points_nowhere() -> None:
    assert vectors_text({"A": 0.04 + 0.0j, "B": -2.0 + 0.0j}) == "A 0.0 g·mm   B 2.0 g·mm at 180°"
    assert big_vectors({"A": 1e-3j}) == big_text("A 0.0")


def test_the_wizard_computes_from_readings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed: Iterator[str] = iter(["40 0", "41 0", "42,0 0", "40 0", "20 180"])
    monkeypatch.setattr(builtins, "input", lambda _: next(typed))
    assert main(["machine", machine(tmp_path), "--wizard"]) == 0
    out = capsys.readouterr().out
    assert "tooling and mandrel: 10.00 g·mm at 0.0°" in out
    assert "urr_percent = 95  # usual; not in these readings" in out
    assert "umar_g_mm = 1.96" in out
    assert "urr_percent = 95, umar_g_mm = 0.5" in out
    monkeypatch.setattr(builtins, "input", lambda _: "much")
    assert main(["machine", machine(tmp_path), "--wizard"]) == 2
    assert "expected two numbers" in capsys.readouterr().err
