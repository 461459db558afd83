"""``autobalance machine --watch``: lines as they come, the vector large, the settled one to ``recut``."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.errors import FileError, UsageError, file_errors

if TYPE_CHECKING:
    from autobalance.test_stands.machine.line import Watched

SERIAL = "serial:"
BAUD = 9600
WAIT_S = 0.1
CLEAR = "\x1b[2J\x1b[H"


def watch(machine_file: str, source: str, folder: str | None, report: str | None, timeout_s: float) -> int:
    """Follow a source until its vectors settle, write the reading and hand it to ``recut``.

    Raises
    ------
    FileError
        If the source cannot be read, or nothing settles in time.
    """
    from autobalance.command.console import say
    from autobalance.report.files import Staging
    from autobalance.test_stands.machine.big_text import settled_toml, vectors_text
    from autobalance.test_stands.machine.line import read_watched

    watched = read_watched(machine_file)
    place = Path(folder or ".") / "reading.toml"
    with Staging([place.parent]) as staging:  # that it can be written is proved before anything is spun
        vectors = _settled(watched, source, timeout_s)
        say(f"settled: {vectors_text(vectors)}")
        staging.add(place, settled_toml(vectors, watched.reading, watched.speed_rpm).encode())
        staging.commit()
    say(f"Written: {place}")
    if report is None:
        return 0
    from autobalance.command.main import main

    return main(["recut", report, str(place)])


def _settled(watched: Watched, source: str, timeout_s: float) -> Mapping[str, complex]:
    """Show vectors as they come; return them once they settled."""
    from autobalance.command.console import say
    from autobalance.test_stands.machine.big_text import big_vectors, vectors_text

    large = sys.stdout.isatty()
    for line in _lines(source, time.monotonic() + timeout_s):
        read = watched.line.vectors(line)
        for plane, vector in read.items():
            watched.settling.add(plane, vector)
        if read:
            latest = {name: each[-1] for name, each in sorted(watched.settling.last.items())}
            say(CLEAR + big_vectors(latest) if large else vectors_text(latest))
        if read and (vectors := watched.settling.settled) is not None:
            return vectors
    raise FileError(f"{source}: {_unsettled(watched, timeout_s)}")


def _unsettled(watched: Watched, timeout_s: float) -> str:
    last = watched.settling.last
    if not last:
        return f"no line in {timeout_s:g} s matches machine.line.pattern; compare both"
    count = watched.settling.count
    return (
        f"the readings did not settle in {timeout_s:g} s ({count} of each plane that agree were expected); "
        "raise machine.line.settled_percent, or spin longer"
    )


def _lines(source: str, until: float) -> Iterator[str]:
    """Yield lines of a file that is written to, or of a serial line, until a time."""
    with ExitStack() as stack:
        if source.startswith(SERIAL):
            read = _serial(source.removeprefix(SERIAL), stack)
        else:
            with file_errors(f"read {source}"):
                file = stack.enter_context(Path(source).open("rb"))
            read = file.readline
        begun = b""
        while time.monotonic() < until:
            part = read()
            begun += part
            if begun.endswith((b"\n", b"\r")):
                yield begun.decode("utf-8", errors="replace").strip()
                begun = b""
            elif not part:
                time.sleep(WAIT_S)


def _serial(device: str, stack: ExitStack) -> Callable[[], bytes]:
    """Return a function that reads a line of a serial device, ``/dev/ttyUSB0`` or ``COM3:19200``."""
    try:
        import serial
    except ModuleNotFoundError:
        raise FileError(
            "serial lines need the extra serial, which is not installed: pip install 'autobalance[serial]'"
        ) from None
    name, colon, baud = device.rpartition(":")
    if not (colon and baud.isdigit()):
        name, baud = device, str(BAUD)
    if not name:
        raise UsageError("--watch serial: names no device; expected serial:DEVICE or serial:DEVICE:BAUD")
    try:
        port = stack.enter_context(serial.Serial(name, int(baud), timeout=WAIT_S))
    except serial.SerialException as error:
        raise FileError(f"cannot read {device}: {error}") from None
    readline: Callable[[], bytes] = port.readline
    return readline
