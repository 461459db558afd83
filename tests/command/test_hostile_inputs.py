"""Inputs and surroundings that once hung a command, took gigabytes of memory, or spoke between its lines."""

from __future__ import annotations

import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest

from autobalance.command.terminal import shop_units
from autobalance.errors import JobError
from autobalance.toml_files.document import toml_of
from tests import jobs


def command(
    *words: str | Path, flags: tuple[str, ...] = (), **environment: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *flags, "-m", "autobalance", *map(str, words)],
        capture_output=True,
        text=True,
        timeout=240,
        env={**os.environ, **environment},
        check=False,
    )


@pytest.mark.skipif(sys.platform == "win32", reason="named pipes are POSIX")
@pytest.mark.parametrize("words", [("balance",), ("verify",), ("bearing",), ("study",)])
def test_a_pipe_in_place_of_a_file_is_refused(words: tuple[str, ...], tmp_path: Path) -> None:
    pipe = tmp_path / "job.toml"
    os.mkfifo(pipe)
    assert jobs.run(*words, pipe) == 3


def test_the_shop_s_units_are_sought_within_the_limits_of_a_job(tmp_path: Path) -> None:
    """They are read before the job is, so what the job's reader refuses must not reach the parser here."""
    job = tmp_path / "job.toml"
    job.write_text(".".join("a" * 4_000) + ' = 1\n[shop]\nunits = "inch"\n')
    tracemalloc.start()
    try:
        assert shop_units(job) == "metric"
        assert tracemalloc.get_traced_memory()[1] < 2_000_000  # the parser alone takes 64 MB
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "text",
    [
        ".".join("a" * 20_000) + " = 1",
        "[" + ".".join("a" * 20_000) + "]",
        ".".join(['"a.b"'] * 20_000) + " = 1",
        "a = " + "[" * 5_000,
        "a = " + "{b = " * 5_000,
        '# "\n' + ".".join("a" * 20_000) + ' = 1 # "',
        "a = " + "'" * 3 + "\n" + "'" * 3 + "\n" + ".".join("a" * 20_000) + " = 1",
    ],
)
def test_deep_keys_are_refused_before_the_parser_sees_them(text: str) -> None:
    with pytest.raises(JobError, match=r"line [1-4] nests deeper than 32 tables"):
        toml_of(text, "job.toml")


def test_texts_comments_and_lists_may_hold_dots() -> None:
    dots = "." * 400
    rows = ", ".join(["[1.5, 2.5]"] * 200)
    text = f"""# {dots} [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[
a = "{dots}" # it's {dots}
b = '{dots}'
c = [{rows}]
d = \"\"\"
{dots}\"\"\"
"{dots}" = 1
"""
    table = toml_of(text, "job.toml")
    assert table["a"] == table["b"] == table["d"] == dots
    assert table[dots] == 1
    assert len(table["c"]) == 200


def test_no_home_folder_is_needed(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path / "in")
    done = command("balance", job, "-o", tmp_path / "out", "--quiet", HOME=os.devnull)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "sheet.pdf").stat().st_size > 1000


def test_nothing_is_left_open_at_the_end(tmp_path: Path) -> None:
    """Under -X dev Python names what is; -W error makes an error of every other warning."""
    job = jobs.bundled_job(tmp_path / "in")
    flags = ("-X", "dev", "-W", "error")
    done = command("balance", job, "-o", tmp_path / "out", "--quiet", flags=flags)
    assert (done.returncode, done.stderr) == (0, "")


def test_libraries_do_not_log_beside_the_line_of_an_error(tmp_path: Path) -> None:
    """npTDMS warns of a file that was cut off, by a handler of its own."""
    pytest.importorskip("nptdms")
    record = tmp_path / "cut.tdms"
    lead_in = b"TDSm" + (0x0E).to_bytes(4, "little") + (4713).to_bytes(4, "little")
    record.write_bytes(lead_in + (5000).to_bytes(8, "little") + (40).to_bytes(8, "little") + bytes(60))
    done = command("orders", record)
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("autobalance: error: ")
