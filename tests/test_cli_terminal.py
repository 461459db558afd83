"""On a terminal results have tables and colours; anywhere else they are plain text, byte for byte."""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from autobalance.command import terminal
from autobalance.report.tables import DRAWN_BY, has_heading, plain_table, table
from tests import jobs

pytestmark = pytest.mark.usefixtures("cranks_read_once")

pytest.importorskip("rich")
ESCAPE = re.compile(r"\x1b\[[0-9;]*m")
ROWS = [("Part", "mass"), ("  rod", "95.04 g"), ("  piston [alu]", "158.00 g")]
SCRIPT = """
import sys
from autobalance.command import main
code = main(sys.argv[1:])
assert sys.stdout.isatty() or "rich" not in sys.modules
sys.exit(code)
"""


def piped(*arguments: str | Path) -> str:
    words = [str(argument) for argument in arguments]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *words], capture_output=True, text=True, encoding="utf-8", check=True
    )
    return done.stdout


def on_a_terminal(*arguments: str | Path, **environment: str) -> str:
    """Run the command with a pseudo-terminal for its standard output."""
    import pty

    main, sub = pty.openpty()
    words = [str(argument) for argument in arguments]
    variables = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "100", **environment}
    command = [sys.executable, "-c", SCRIPT, *words]
    with subprocess.Popen(command, stdout=sub, stderr=subprocess.PIPE, env=variables) as process:
        os.close(sub)
        data = b""
        while True:
            try:
                chunk = os.read(main, 65536)
            except OSError:  # the other end is closed
                break
            if not chunk:
                break
            data += chunk
        assert process.wait() == 0
    os.close(main)
    return data.decode("utf-8").replace("\r\n", "\n")


@pytest.fixture
def job(tmp_path: Path) -> Path:
    return jobs.pin_job(tmp_path)


def words_of(text: str) -> list[str]:
    return re.findall(r"[^\s─━╺╸]+", ESCAPE.sub("", text))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
def test_a_terminal_shows_the_same_words_in_colour_and_a_pipe_gets_plain_text(job: Path) -> None:
    plain = piped("parts", job)
    assert "\x1b" not in plain
    shown = on_a_terminal("parts", job)
    assert "\x1b[" in shown
    assert words_of(shown) == words_of(plain)
    assert on_a_terminal("parts", job, TERM="dumb") == plain
    assert on_a_terminal("parts", job, "--json", "-") == piped("parts", job, "--json", "-")


class Terminal(io.StringIO):
    """A standard output that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_tables_are_plain_unless_the_command_line_draws_them(monkeypatch: pytest.MonkeyPatch) -> None:
    assert table(ROWS) == plain_table(ROWS)
    assert table(ROWS).splitlines()[1] == "  rod            95.04 g"
    monkeypatch.setenv("TERM", "xterm-256color")
    with contextlib.redirect_stdout(Terminal()), terminal.drawn_tables():
        drawn = table(ROWS)
    assert DRAWN_BY.get() is None
    assert "\x1b[" in drawn
    assert words_of(drawn) == words_of(table(ROWS))
    assert "[alu]" in drawn  # brackets are no markup


def test_a_heading_is_a_row_above_rows_that_are_set_in() -> None:
    assert has_heading(ROWS)
    assert not has_heading(ROWS[1:])
    assert not has_heading([("Mass", "1 g"), ("Length", "2 mm")])


def test_verdicts_have_their_colour(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    terminal.show("WITHIN TOLERANCE\nNOT WITHIN TOLERANCE\nABOVE TOLERANCE: 50 [g·mm]")
    good, bad, worse = capsys.readouterr().out.splitlines()
    assert "\x1b[1;32m" in good
    assert "\x1b[1;31m" in bad
    assert "32m" not in bad
    assert "\x1b[1;31m" in worse
    assert "[g·mm]" in worse
