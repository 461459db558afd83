"""Options follow from the signature and the docstring of the function that a command calls."""

import argparse
import inspect
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import pytest

import autobalance
from autobalance.command.help_groups import OTHERS, grouped
from autobalance.command.main import full_parser
from autobalance.command.verb import Verb
from autobalance.registry import VERBS as COMMANDS
from autobalance.verbs.declaration import REQUIRED, parameters_of
from tests import jobs


def _verb(name: str) -> Verb | None:
    """Return a command that follows from a function; None for one that has its own options."""
    listed = COMMANDS[name]
    if not listed.command:
        return Verb(f"{listed.function}:{name}")
    place, _, among_others = listed.command.partition(":")
    return getattr(import_module(f"autobalance.{place}"), among_others or "VERB", None)


VERBS: dict[str, Verb] = {name: verb for name in COMMANDS if (verb := _verb(name)) is not None}
FUNCTIONS = [name for name in autobalance.PUBLIC if name[0].islower()]


@pytest.mark.parametrize("name", VERBS)
def test_what_is_read_from_the_source_is_the_functions_signature(name: str) -> None:
    module, function = VERBS[name].function.split(":")
    found = getattr(import_module(f"autobalance.{module}"), function)
    real = {
        each.name: (
            each.annotation.removesuffix(" | None"),
            REQUIRED if each.default is inspect.Parameter.empty else each.default,
        )
        for each in inspect.signature(found).parameters.values()
        if each.kind is not inspect.Parameter.VAR_KEYWORD
    }
    declared = parameters_of(VERBS[name].function)
    assert {each.name: (each.type, each.default) for each in declared.values()} == real


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_parameter_of_a_public_function_is_documented_in_its_order(name: str) -> None:
    function = getattr(autobalance, name)
    doc = inspect.getdoc(function) or ""
    section = doc.partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    heads = [line.partition(" : ")[0] for line in section.splitlines() if line[:1] not in ("", " ")]
    documented = [each.strip("*") for head in heads for each in head.split(", ")]
    assert documented == list(inspect.signature(function).parameters)


def test_choices_are_those_of_the_program() -> None:
    from autobalance.signals.record import COSINES
    from autobalance.signals.spectra import Quantity
    from autobalance.units import MM_PER

    orders = parameters_of("signals.verb:orders")
    assert set(orders["window"].choices) == set(COSINES)
    assert set(orders["quantity"].choices) == set(get_args(Quantity))
    for verb in VERBS.values():
        choices = parameters_of(verb.function).get("unit")
        assert choices is None or not choices.choices or choices.choices == tuple(MM_PER)


def test_the_help_of_all_commands_loads_no_numpy() -> None:
    code = "import sys; from autobalance.command.main import full_parser; full_parser().format_help()"
    code += "; raise SystemExit(any(name in sys.modules for name in ('numpy', 'scipy')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_says_what_it_sets_and_its_default(name: str) -> None:
    commands: Any = next(each.choices for each in full_parser()._actions if each.dest == "command")
    if COMMANDS[name].command:
        assert f"autobalance {name}" in commands[name].epilog.partition("examples:\n")[2]
    for action in commands[name]._actions:
        words = action.help
        assert words, action.dest
        assert words[0] not in "(-", words
        assert "`" not in words, words
        assert not re.search(r"\. \S", words), f"two sentences: {words}"
        if action.option_strings and action.nargs != 0 and not action.required:
            assert words.endswith(")"), words
            assert "(default: " in words, words
        if action.option_strings and action.required:
            assert words.endswith(" (required)"), words


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("study", "JOB", "--samples", "0"), "samples is 0; must be ≥ 1"),
        (("study", "JOB", "--exact", "-1"), "exact is -1"),
        (("study", "JOB", "--workers", "0"), "workers is 0; must be ≥ 1"),
        (("batch", "JOB", "-o", "out", "--workers", "0"), "workers is 0; must be ≥ 1"),
        (("parts", "JOB", "--set", "balance.factor"), "--set 'balance.factor' is not KEY=VALUE"),
        (("inspect", "JOB", "--set", "=3"), "--set '=3' is not KEY=VALUE"),
    ],
)
def test_options_out_of_range_are_wrong_use(
    arguments: tuple[str, ...], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.pin_job(tmp_path)
    if arguments[0] == "batch":
        job = tmp_path
    assert jobs.run(*(job if word == "JOB" else word for word in arguments)) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_alone_it_shows_the_ways_in_and_each_is_a_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run() == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    lines = [line.split("   ")[0].split()[1:] for line in printed.err.splitlines()[1:]]
    assert {line[0] for line in lines} >= {"inspect", "init", "balance", "verify", "generate", "demo", "app"}
    for line in lines:
        full_parser().parse_args(line)


def test_every_public_verb_is_known_to_type_checkers() -> None:
    source = Path(autobalance.__file__).read_text(encoding="utf-8")
    for name, module in autobalance.PUBLIC.items():
        assert f"from autobalance.{module} import {name} as {name}\n" in source


def test_the_help_lists_every_command_once_by_what_people_want() -> None:
    groups = grouped(COMMANDS)
    assert sorted(name for names in groups.values() for name in names) == sorted(COMMANDS)
    assert OTHERS not in groups
    text = full_parser().format_help()
    headings = [line for line in text.splitlines() if line in groups]
    assert headings == list(groups)
    assert text.index("  balance ") < text.index("At the balancing machine\n") < text.index("  recut ")


def test_the_most_used_options_of_balance_fit_on_a_screen() -> None:
    (commands,) = (each for each in full_parser()._actions if isinstance(each, argparse._SubParsersAction))
    command = commands.choices["balance"]
    first = command.format_help().partition("most used options:\n")[2].partition("\n\n")[0]
    assert len(first.splitlines()) <= 24
    rest = command.format_help().partition("more options:\n")[2]
    assert "--output" in first
    assert "--paper" not in first
    assert "--paper" in rest
