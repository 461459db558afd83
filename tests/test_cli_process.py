"""The program as a process: start-up time, Ctrl-C, closed pipes, both ways in."""

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from autobalance.bundled import bundled_folder
from autobalance.command.main import INTERRUPTED_MESSAGE
from tests import jobs
from tests.coarse import bundled_corners

pytestmark = pytest.mark.usefixtures("cranks_read_once")

HELP_SECONDS = 0.3
CLI = [sys.executable, str(jobs.ROOT / "cli.py")]


def environment(**more: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(jobs.ROOT), **more}


@pytest.mark.timing
@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["balance", "--help"], ["inspect", "--help"]]
)
def test_help_is_quick(arguments: list[str]) -> None:
    """The best of five: the machine may be busy."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run([*CLI, *arguments], check=True, capture_output=True)
        times.append(time.perf_counter() - start)
    assert min(times) < HELP_SECONDS


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from autobalance.command import main; main(['balance', '--help']);"
        "heavy = {'numpy', 'scipy', 'trimesh', 'manifold3d', 'inspect'} & set(sys.modules);"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=environment())


def test_the_list_of_commands_loads_no_paths() -> None:
    """Which would take a tenth of its time."""
    code = (
        "import sys; before = set(sys.modules); from autobalance.command import main; main(['--help']);"
        "assert not {'pathlib', 'json', 'shlex'} & (set(sys.modules) - before), sorted(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=environment())


def test_a_small_crank_is_balanced_without_loading_scipy(tmp_path: Path) -> None:
    """Which takes longer to load than all else that such a crank needs."""
    job = bundled_folder() / "crf250r" / "straight" / "factor-0.28.toml"
    code = (
        "import sys; from autobalance.command import main;"
        f"assert main(['balance', {str(job)!r}, '-o', {str(tmp_path)!r}, '-q', '--no-report']) == 0;"
        "assert 'scipy' not in sys.modules"
    )
    anew = environment(AUTOBALANCE_CACHE_MB="0")
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=anew)


def test_what_libraries_write_on_standard_output_is_not_among_the_results() -> None:
    code = (
        "import os; from autobalance.runtime import own_standard_output;"
        "own_standard_output(); os.write(1, b'a line of the solver'); print('result ·')"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=environment())
    assert done.stdout.decode() == "result ·\n"


def test_the_installed_way_in_and_the_checkouts_are_one_program() -> None:
    outputs = [
        subprocess.run(
            [*way, "--version"], check=True, capture_output=True, text=True, env=environment()
        ).stdout
        for way in (CLI, [sys.executable, "-m", "autobalance"])
    ]
    assert outputs[0] == outputs[1]
    assert outputs[0].startswith("autobalance ")


def job_of(folder: Path, **edits: str) -> Path:
    """Write a bundled job on a crank of few facets: signals and streams are the same on any."""
    job = jobs.bundled_job(folder, **edits)
    jobs.write_stl(folder / "crank.stl", bundled_corners(segments=32))
    return job


STOPPING = """
import os, signal, sys, threading
signal.signal(signal.SIGINT, signal.default_int_handler)  # who runs the tests in the background ignores it
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from autobalance.balancing import loop
from autobalance.command import main

cut = loop.cut_and_measure

def slow(*arguments):
    print("cutting", flush=True)
    for _ in range(200):
        signal.sigtimedwait([], 0.05) if hasattr(signal, "sigtimedwait") else None
    return cut(*arguments)

loop.cut_and_measure = slow
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT to one process needs POSIX")
@pytest.mark.parametrize(("fresh", "sent"), [(True, "SIGINT"), (False, "SIGTERM"), (True, "SIGHUP")])
def test_ctrl_c_in_the_middle_leaves_nothing_half_written(fresh: bool, sent: str, tmp_path: Path) -> None:
    job = job_of(tmp_path)
    output = tmp_path / "out"
    if not fresh:
        output.mkdir()
        (output / "report.json").write_text("of an earlier run")
        (output / "balanced.stl").write_text("of an earlier run")
    before = jobs.folder_state(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-c", STOPPING, "balance", str(job), "-o", str(output)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "cutting\n"  # in the middle of the work
        process.send_signal(getattr(signal, sent))
        _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "interrupted" in errors
    assert "Traceback" not in errors
    assert jobs.folder_state(tmp_path) == before
    assert output.exists() is not fresh


ADVISING = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from autobalance.balancing import offers
from autobalance.command import main
from autobalance.runtime import uninterrupted
from tests.watched import watched

presses = int(sys.argv.pop())

def press(*_):
    with uninterrupted():
        for _ in range(presses):
            os.kill(os.getppid(), signal.SIGINT)
            signal.sigtimedwait([], 0.2)

with watched(offers.relaxations, tell=press):
    code = main()
sys.exit(code)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "sigtimedwait"), reason="SIGINT to one process needs POSIX")
@pytest.mark.parametrize("presses", [0, 1, 2])
def test_ctrl_c_during_advice_ends_the_advice_alone(presses: int, tmp_path: Path) -> None:
    """A second one ends the command."""
    job = job_of(tmp_path, method='"shoulder"\nmax_depth_mm = 0.5')
    output = tmp_path / "out"
    words = ["balance", str(job), "-o", str(output), "--no-report", str(presses)]
    done = subprocess.run(
        [sys.executable, "-c", ADVISING, *words],
        capture_output=True,
        text=True,
        env=environment(),
        timeout=120,
        check=False,
    )
    if presses == 2:
        assert (done.returncode, done.stderr) == (130, f"autobalance: {INTERRUPTED_MESSAGE}\n")
        assert not output.exists()
        return
    assert (done.returncode, done.stderr) == (4, "")
    report = json.loads((output / "report.json").read_text(encoding="utf-8"))
    assert (output / "balanced.stl").is_file()
    stopped = "the search for limits that would suffice was stopped by Ctrl-C" in report["reason"]
    assert stopped == (presses == 1)
    assert bool(report["relaxations"]) == (presses == 0)


HOLDING = """
import ctypes, sys
from autobalance.verbs import balance
from autobalance.command import main
from autobalance.report.files import Staging

true = Staging.commit
library, lock = ctypes.PyDLL(None), ctypes.create_string_buffer(256)
library.pthread_mutex_init(lock, None)

def held(staging):
    print("held", flush=True, file=sys.stderr)
    for _ in range(2):  # the second for ever, the interpreter held: no thread runs, no signal is heard
        library.pthread_mutex_lock(lock)
    true(staging)

Staging.commit = held
sys.exit(main())
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no copies of a process here")
@pytest.mark.parametrize("sent", ["SIGINT", "SIGTERM"])
def test_a_library_that_holds_the_interpreter_is_ended_in_time(sent: str, tmp_path: Path) -> None:
    """In the midst of writing: the folder and the temporary files that it has begun are taken away."""
    job = job_of(tmp_path)
    before = jobs.folder_state(tmp_path)
    command = [sys.executable, "-c", HOLDING, "balance", str(job), "-o", str(tmp_path / "out"), "--no-report"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment()) as process:
        assert process.stderr is not None
        while "held" not in process.stderr.readline():
            pass
        assert any((tmp_path / "out").iterdir())
        start = time.monotonic()
        process.send_signal(getattr(signal, sent))
        rest = process.stderr.read()
        assert process.wait(timeout=30) == 130
        assert time.monotonic() - start < 2.0
    assert rest == "autobalance: interrupted; nothing half-written was left\n"
    assert jobs.folder_state(tmp_path) == before
    assert not (tmp_path / "out").exists()


CRASHING = """
import os, signal, sys
from autobalance.verbs import balance
from autobalance.command import main
from autobalance.balancing import loop

loop.cut_and_measure = lambda *_: os.kill(os.getpid(), signal.SIGSEGV)
sys.exit(main())
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no copies of a process here")
def test_a_command_ends_as_its_work_does(tmp_path: Path) -> None:
    job = job_of(tmp_path)
    command = [sys.executable, "-c", CRASHING, "balance", str(job), "-o", str(tmp_path / "out")]
    assert subprocess.run(command, env=environment(), check=False).returncode == -signal.SIGSEGV


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only there a process can be made to end with its parent")
def test_work_does_not_outlive_a_command_that_was_killed(tmp_path: Path) -> None:
    job = job_of(tmp_path)
    code = HOLDING.replace('print("held",', 'import os; print(f"held {os.getpid()}",')
    command = [sys.executable, "-c", code, "balance", str(job), "-o", str(tmp_path / "out"), "--no-report"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment()) as process:
        assert process.stderr is not None
        while "held" not in (line := process.stderr.readline()):
            pass
        worker = int(line.split()[1])
        assert worker != process.pid
        process.kill()
        process.wait()
        end = time.monotonic() + 5.0
        while Path(f"/proc/{worker}").exists() and time.monotonic() < end:
            time.sleep(0.01)
        assert not Path(f"/proc/{worker}").exists()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a POSIX pipe")
def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    job = job_of(tmp_path)
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as closed:
        done = subprocess.run(
            [*CLI, "balance", str(job), "-o", str(tmp_path / "out"), "--no-report"],
            stdout=closed,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 0
    assert done.stderr == ""
    assert jobs.report_of(tmp_path / "out")["outcome"] == "within_tolerance"


@pytest.mark.slow
def test_a_terminal_without_the_letters(tmp_path: Path) -> None:
    """An ASCII terminal shows "?" for "·"; the report stays whole. No progress shows in a pipe."""
    job = job_of(tmp_path)
    done = subprocess.run(
        [*CLI, "balance", str(job), "-o", str(tmp_path / "out"), "--no-report"],
        capture_output=True,
        check=True,
        env=environment(PYTHONIOENCODING="ascii"),
    )
    assert b"g?mm" in done.stdout
    assert done.stderr == b""
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["outcome"] == "within_tolerance"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
def test_progress_shows_on_a_terminal_only(tmp_path: Path) -> None:
    import pty

    job = job_of(tmp_path)
    command = [*CLI, "balance", str(job), "-o", str(tmp_path / "out"), "--no-report"]
    ours, theirs = pty.openpty()
    subprocess.run(command, stdout=subprocess.PIPE, stderr=theirs, check=True)
    os.close(theirs)
    shown = os.read(ours, 65536)
    os.close(ours)
    assert b"cutting, pass 1" in shown
    assert shown.endswith(b"\x1b[K")  # and is taken away again


@pytest.mark.skipif(os.name == "nt", reason="shells of POSIX close descriptors")
@pytest.mark.parametrize(
    ("command", "streams", "code", "error"),
    [
        ("schema job", ">&-", 0, ""),
        ("schema job", ">/dev/full", 3, "cannot write to standard output: no space left on device"),
        ("inspect --help", ">/dev/full", 3, "cannot write to standard output: no space left on device"),
        ("inspect nope.stl", ">&-", 3, "does not exist"),
        ("inspect nope.stl", "2>&-", 3, ""),
        ("inspect nope.stl", "2>/dev/full", 3, ""),
        ("schema nope", ">&- 2>&-", 2, ""),
        ("nonsense", "2>&-", 2, ""),
    ],
)
def test_streams_that_are_closed_or_full(
    command: str, streams: str, code: int, error: str, tmp_path: Path
) -> None:
    """The exit code is that of the work, or of a result that cannot be printed; never a traceback."""
    if "/dev/full" in streams and not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    called = " ".join(map(shlex.quote, CLI)) + f" {command} {streams}"
    ran = subprocess.run(
        called, shell=True, check=False, capture_output=True, text=True, env=environment(), cwd=tmp_path
    )
    assert ran.returncode == code
    assert error in ran.stderr
    assert "Traceback" not in ran.stderr
    assert list(tmp_path.iterdir()) == []
