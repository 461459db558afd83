"""Nothing that users meet changes unless it is meant to (``regenerate.py`` stores it anew)."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

import autobalance as ab
from autobalance.command.main import full_parser
from tests.every_command import CALLS, SCHEMAS
from tests.frozen.outputs import differs
from tests.frozen.run import LINES, helps, run_of, write_inputs


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("frozen")
    write_inputs(folder)
    return folder


def check(fresh: dict[str, str]) -> None:
    told = []
    for name, text in fresh.items():
        told += [f"{name}: {line}" for line in differs(name, text)]
    assert not told, "\n".join(told[:60])


def test_every_command_with_json_is_called_here() -> None:
    (commands,) = [each for each in full_parser()._actions if isinstance(each, argparse._SubParsersAction)]
    offered = {
        name
        for name, parser in commands.choices.items()
        if any("--json" in action.option_strings for action in parser._actions)
    }
    assert offered == set(CALLS)


@pytest.mark.parametrize("name", LINES)
def test_a_run_prints_and_writes_as_stored(name: str, folder: Path) -> None:
    texts, report = run_of(name, folder)
    if report:
        command = LINES[name].split()[0]
        schema = ab.schema(SCHEMAS.get(command, command))
        assert [each.message for each in Draft202012Validator(schema).iter_errors(report)] == []
        assert list(report)[:3] == ["schema_version", "autobalance", "command"]
        assert report["command"] == command
    check(texts)


def test_help_and_schemas_are_as_stored() -> None:
    check(helps())
