"""Messages of wrong input in one file, each with the input that makes it: to be read in one go.

``python -m tests.golden.messages`` stores them again; then read the difference. The tests of each message say
why its input is wrong; here is only how it reads.
"""

from __future__ import annotations

import contextlib
import copy
import io
import tempfile
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import autobalance as ab
from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import AutobalanceError
from autobalance.job import read as job
from tests import jobs
from tests.geometry.test_recognise_refused import NO_CRANKS
from tests.unit import test_bearing_file, test_fed_bearing_file, test_job

STORED = Path(__file__).with_name("messages.txt")
COMMAND_LINES = (
    *("blance", "zzz", "balance a.toml b.toml", "verify", "inspect missing.stl"),
    *("inspect missing.stl --unit yard", "balance missing.toml", "generate octopus -o crank.stl"),
    *("grade --mass 2 --speed-rpm 9000", "calc kinetic", "schema octopus", "study missing.toml --samples 0"),
    *("recut missing.json missing.toml", "init", "sheet missing.json -o out", "jobs missing"),
)
"""Wrong command lines, typed in an empty folder."""


def said(call: Callable[[], object]) -> str:
    """Return the message of a call that is refused."""
    try:
        call()
    except AutobalanceError as error:
        return str(error)
    raise AssertionError("nothing was refused")


def changed(before: Mapping[str, Any], after: Mapping[str, Any], place: str = "") -> Iterator[str]:
    """Yield the keys of a job that another one sets otherwise or lacks."""
    for key in {**before, **after}:
        here = f"{place}{key}"
        old, new = before.get(key), after.get(key)
        if key not in after:
            yield f"without {here}"
        elif isinstance(old, dict) and isinstance(new, dict):
            yield from changed(old, new, f"{here}.")
        elif key not in before or repr(old) != repr(new):
            text = repr(new)
            yield f"{here} = {text if len(text) < 100 else text[:97] + '...'}"


def job_messages() -> Iterator[tuple[str, str]]:
    for edit, _ in test_job.WRONG.values():
        raw = test_job.good()
        edit(raw)
        fresh = copy.deepcopy(raw)
        yield (
            "; ".join(changed(test_job.good(), raw)),
            said(partial(job.parse, fresh, Path("job.toml"))),
        )


def bearing_messages() -> Iterator[tuple[str, str]]:
    for module in (test_bearing_file, test_fed_bearing_file):
        for table in module.BAD.values():
            yield "; ".join(changed({}, table)), said(partial(ab.bearing, copy.deepcopy(table)))


def recognition_messages() -> Iterator[tuple[str, str]]:
    for name, solid in NO_CRANKS.items():
        for in_file in (None, False):
            hint = "" if in_file is None else "; crankpin_in_file = false"
            yield name + hint, said(partial(recognise, solid, Overrides(crankpin_in_file=in_file)))


def command_messages() -> Iterator[tuple[str, str]]:
    for line in COMMAND_LINES:
        printed = io.StringIO()
        with (
            tempfile.TemporaryDirectory() as folder,
            contextlib.chdir(folder),
            contextlib.redirect_stderr(printed),
            contextlib.redirect_stdout(io.StringIO()),
        ):
            code = jobs.run(*line.split())
        told = printed.getvalue().strip().rpartition("\n")[2]  # without the usage, which follows the width
        yield f"autobalance {line}", f"{told} (exit code {code})"


def all_messages() -> str:
    """Return the text of the stored file: a section for each kind of input."""
    sections = {
        "Command lines": command_messages(),
        "Recognition: parts that are not cranks": recognition_messages(),
        "Jobs: changes of a good job": job_messages(),
        "Bearing files": bearing_messages(),
    }
    lines = []
    for title, rows in sections.items():
        lines += [title, "=" * len(title), ""]
        for given, message in rows:
            lines += [given, *(f"    {line}" for line in message.splitlines()), ""]
    return "\n".join(lines)


if __name__ == "__main__":
    STORED.write_text(all_messages(), encoding="utf-8")
