"""The tutorial of the shop, run as it is printed: its files, its commands, what they print."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from autobalance.command.main import main
from tests import jobs

pytestmark = pytest.mark.usefixtures("cranks_read_once")
PAGE = jobs.ROOT / "docs" / "shop.md"
BLOCK = re.compile(r"```(toml|console)\n(.*?)```", re.DOTALL)


def test_a_v8_from_nothing_to_its_certificate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    text = PAGE.read_text(encoding="utf-8")
    printed, said = "", []
    for kind, block in BLOCK.findall(text):
        if kind == "toml":
            name = re.match(r"# (\S+)", block)
            assert name is not None
            Path(name[1]).write_text(block, encoding="utf-8")
            continue
        for line in block.splitlines():
            if line.startswith("  "):
                said.append(line.strip())
                assert line.strip() in printed, printed
                continue
            with jobs.without_advice():
                code = main(shlex.split(line)[1:])
            printed = capsys.readouterr().out
            assert code == 0, line
    assert len(said) >= 8
    for folder, numbers in (
        ("spin", ("454.30", "75.24", "21.67", "199.00")),
        ("turned", ("283.88", "332.57")),
    ):
        reading = Path(folder, "reading.toml").read_text(encoding="utf-8")
        values = [f"{float(each):.2f}" for each in re.findall(r"^(?:g_mm|angle_deg) = (\S+)", reading, re.M)]
        for number in numbers:
            assert number in values
            assert number in text
    report = json.loads(Path("v8-balanced", "stage-2", "report.json").read_text(encoding="utf-8"))
    assert report["outcome"] == "within_tolerance"
    assert {cut["diameter_mm"] for cut in report["corrections"]} == {12.0}
    assert Path("v8-balanced", "stage-2", "certificate.pdf").read_bytes().startswith(b"%PDF")
    assert Path("v8-balanced", "stage-2", "history.html").is_file()
