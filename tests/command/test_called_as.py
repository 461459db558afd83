"""The commands that the program prints work as printed, however it was called."""

import sys
from pathlib import Path

import pytest

from autobalance.command.console import called_as


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    program = tmp_path / ".venv" / "bin" / "autobalance"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    return program


def test_by_its_path_where_the_environment_is_not_active(
    installed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [str(installed)])
    assert called_as() == ".venv/bin/autobalance"


def test_by_its_name_where_it_is(installed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [str(installed)])
    monkeypatch.setenv("PATH", f"{installed.parent}:/usr/bin:/bin")
    assert called_as() == "autobalance"


@pytest.mark.parametrize(
    ("called", "said"), [("cli.py", "cli.py"), ("/somewhere/__main__.py", "-m autobalance")]
)
def test_as_a_module_or_from_the_checkout(
    called: str, said: str, installed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [called])
    monkeypatch.setattr(sys, "executable", str(installed.with_name("python")))
    assert called_as() == f".venv/bin/python {said}"
