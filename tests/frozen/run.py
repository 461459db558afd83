"""Every command on small inputs: what it prints, writes, and says of itself."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from autobalance.command.main import full_parser
from tests import every_command, jobs
from tests.frozen import outputs

LINES = {**every_command.CALLS, **outputs.RUNS}


def write_inputs(folder: Path) -> None:
    """Write what the runs read, two more jobs among it: a drilled one, and one that no cut can balance."""
    every_command.write_inputs(folder)
    text = (folder / "job.toml").read_text(encoding="utf-8")
    drill = text.replace('method = "shoulder"', 'method = "drill"\n[correction.drill]\ndiameters_mm = [8.0]')
    (folder / "drill.toml").write_text(drill, encoding="utf-8")
    light = text.replace("factor = 0.5", "factor = 1.0")
    (folder / "light.toml").write_text(light, encoding="utf-8")


@contextlib.contextmanager
def eighty_columns() -> Iterator[None]:
    """Print inside the block as on a terminal of 80 columns."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "80"
    try:
        yield
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before


def run_of(name: str, folder: Path) -> tuple[dict[str, str], dict[str, Any]]:
    """Run a line in its folder; return texts by name of the stored file, and the report."""
    before = set(folder.rglob("*"))
    line = LINES[name].split()
    has_report = name in every_command.CALLS or line[0] == "torsion"
    path = folder / "frozen-report.json"
    texts: dict[str, str] = {}
    report: dict[str, Any] = {}
    printed = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(printed), eighty_columns():
        code = jobs.run(*line, *(("--json", path.name) if has_report else ()))
    if has_report:
        report = json.loads(path.read_text(encoding="utf-8"))
        path.unlink()
        shown = json.dumps(outputs.without_volatile(report), indent=1, ensure_ascii=False)
        texts[f"{name}.json"] = outputs.stable(shown, folder) + "\n"
    files = [f"== {each}\n{content}".rstrip() for each, content in outputs.written(folder, before)]
    for each in set(folder.rglob("*")) - before:  # the next run meets the folder as this one did
        if each.is_dir():
            shutil.rmtree(each, ignore_errors=True)
        else:
            each.unlink(missing_ok=True)
    said = "\n".join([f"exit code {code}", printed.getvalue().rstrip(), *files])
    texts[f"{name}.txt"] = outputs.stable(said, folder) + "\n"
    return texts, report


def helps() -> dict[str, str]:
    """Return what the program and each command say of themselves, and each schema."""
    parser = full_parser()
    (commands,) = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    listed = [f"{each.dest}: {each.help}" for each in commands._choices_actions]
    texts = {"help.txt": "\n".join([_help(parser), *listed]) + "\n"}
    texts |= {f"help-{name}.txt": _help(each) + "\n" for name, each in sorted(commands.choices.items())}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        jobs.run("schema")
    for name in printed.getvalue().split():
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown):
            jobs.run("schema", name)
        texts[f"schema-{name}.json"] = shown.getvalue()
    return texts


def _help(parser: argparse.ArgumentParser) -> str:
    """Return a command's help in an order and width of our own: argparse's change with Python."""
    lines = [str(parser.description), str(parser.epilog)]
    for each in parser._actions:
        names = ", ".join(each.option_strings) or each.dest
        choices = None if each.choices is None else sorted(map(str, each.choices))
        facts = f"metavar {each.metavar}, nargs {each.nargs}, default {each.default}, choices {choices}"
        lines.append(f"{names}: {each.help} ({facts}, required {each.required})")
    return "\n".join(lines)
