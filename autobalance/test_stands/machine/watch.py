"""``autobalance machine --watch`` and ``--wizard``: readings as they come."""

from __future__ import annotations

import cmath
import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import FileError, UsageError, file_errors
from autobalance.job.reading import Convention
from autobalance.report.reading_template import UMAR_G_MM, URR_PERCENT
from autobalance.toml_files.document import toml_value
from autobalance.units import wrapped_deg
from autobalance.wording import degrees

if TYPE_CHECKING:
    from autobalance.test_stands.machine.answer import MachineReport
    from autobalance.test_stands.machine.line import Watched


# ``autobalance machine --watch``: lines as they come, the vector large, the settled one to ``recut``.


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


# ``autobalance machine --wizard``: a machine's smallest residual by three readings and an index test.


REPEATED_READINGS = 3
INDEX_DEG = (0.0, 180.0)
READING_FORMAT = 'amount [g·mm] and angle [deg], as "35.2 191": '


def wizard() -> int:
    """Ask for readings of one plane, and print the keys of ``[reading]`` that follow."""
    from autobalance.command.console import say
    from autobalance.report.reading_template import UMAR_G_MM, URR_PERCENT
    from autobalance.theory.machines import machine_accuracy

    say(
        f"Typical of a hard-bearing machine: urr_percent = {URR_PERCENT:g}, umar_g_mm = "
        f"{UMAR_G_MM:g}.\n"
        "One plane is read; remove the rotor and mount it again between readings."
    )
    repeated = [
        _typed_reading(f"reading {n} of {REPEATED_READINGS}, {READING_FORMAT}")
        for n in range(1, REPEATED_READINGS + 1)
    ]
    index = [
        _typed_reading(f"crank turned by {turn:g}° on its tooling, {READING_FORMAT}") for turn in INDEX_DEG
    ]
    (sizes, angles), (index_sizes, index_angles) = (zip(*each, strict=True) for each in (repeated, index))
    try:
        accuracy = machine_accuracy(sizes, angles, INDEX_DEG, index_sizes, index_angles)
    except ValueError as error:
        raise UsageError(f"the readings give no figures: {error}") from None
    say(
        f"tooling and mandrel: {accuracy.tooling_g_mm:.2f} g·mm at {accuracy.tooling_deg:.1f}°; "
        f"the crank alone: {accuracy.crank_g_mm:.2f} g·mm at {accuracy.crank_deg:.1f}°\n\n"
        f"[reading]\nurr_percent = {URR_PERCENT:g}  # usual; not in these readings: see its own test\n"
        f"umar_g_mm = {accuracy.umar_g_mm:.3g}  # by Student's t of {REPEATED_READINGS} readings, 95 %"
    )
    return 0


def _typed_reading(question: str) -> tuple[float, float]:
    try:
        words = input(question).replace(",", ".").split()
        amount, angle = map(float, words)
    except EOFError:
        raise UsageError("--wizard reads from the terminal; there is nothing more to read") from None
    except ValueError:
        raise UsageError("expected two numbers, amount and angle, with a space between") from None
    if amount < 0.0:
        raise UsageError(f"amount is {amount:g}; must be ≥ 0")
    return amount, angle


# A machine's vectors in letters that are read from three metres, and as reading.toml once they settle.


GLYPHS: Mapping[str, tuple[str, ...]] = {
    "0": ("███", "█ █", "█ █", "█ █", "███"),
    "1": (" █ ", "██ ", " █ ", " █ ", "███"),
    "2": ("███", "  █", "███", "█  ", "███"),
    "3": ("███", "  █", "███", "  █", "███"),
    "4": ("█ █", "█ █", "███", "  █", "  █"),
    "5": ("███", "█  ", "███", "  █", "███"),
    "6": ("███", "█  ", "███", "█ █", "███"),
    "7": ("███", "  █", "  █", "  █", "  █"),
    "8": ("███", "█ █", "███", "█ █", "███"),
    "9": ("███", "█ █", "███", "  █", "███"),
    ".": ("  ", "  ", "  ", "  ", "█ "),
    "°": ("██", "██", "  ", "  ", "  "),
    "A": (" █ ", "█ █", "███", "█ █", "█ █"),
    "B": ("██ ", "█ █", "██ ", "█ █", "██ "),
    " ": ("  ", "  ", "  ", "  ", "  "),
}


def big_text(text: str) -> str:
    """Return a text in letters five lines high, each dot two columns wide, without unknown characters.

    Examples
    --------
    >>> print(big_text("1").replace("█", "#"))
      ##
    ####
      ##
      ##
    ######
    """
    known = [GLYPHS[each] for each in text if each in GLYPHS]
    lines = [" ".join(glyph[row] for glyph in known) for row in range(5)]
    return "\n".join("".join(2 * dot for dot in line).rstrip() for line in lines)


def vectors_text(vectors: Mapping[str, complex]) -> str:
    """Return vectors in one line: amount and angle of each plane, in the machine's sense of angles."""
    parts = (
        f"{name or 'resultant'} {abs(each):.1f} g·mm" + _pointing(each, " at ")
        for name, each in vectors.items()
    )
    return "   ".join(parts)


def big_vectors(vectors: Mapping[str, complex]) -> str:
    """Return vectors in large letters, one plane below the other: g·mm and degrees."""
    blocks = (
        big_text(f"{name} {abs(each):.1f}{_pointing(each, '  ')}".strip()) for name, each in vectors.items()
    )
    return "\n\n".join(blocks)


def settled_toml(vectors: Mapping[str, complex], reading: Mapping[str, Any], speed_rpm: float | None) -> str:
    """Return settled vectors as the reading that ``recut`` takes."""
    usual = "usual of a hard-bearing machine in order"
    urr, umar = reading["urr_percent"], reading["umar_g_mm"]
    lines = [
        "# Settled vectors, as the machine wrote them.",
        *([] if speed_rpm is None else [f"speed_rpm = {speed_rpm!r}"]),
        f"urr_percent = {URR_PERCENT}   # {usual}" if urr is None else f"urr_percent = {urr!r}",
        f"umar_g_mm = {UMAR_G_MM}   # {usual}" if umar is None else f"umar_g_mm = {umar!r}",
        f"rotation = {json.dumps(reading['rotation'])}",
        f"zero_deg = {reading['zero_deg']!r}",
        f"reads = {json.dumps(reading['reads'])}",
    ]
    for name, each in vectors.items():
        lines += ["", "[[plane]]", *([f'at = "{name}"'] if name else [])]
        lines += [f"g_mm = {round(abs(each), 6)!r}", f"angle_deg = {round(_degrees(each), 6)!r}"]
    return "\n".join(lines) + "\n"


def _pointing(vector: complex, before: str) -> str:
    """Return the angle of a vector after some text; empty for a vector that is shown as 0.0."""
    return f"{before}{degrees(_degrees(vector), 0)}" if round(abs(vector), 1) else ""


def _degrees(vector: complex) -> float:
    return wrapped_deg(math.degrees(cmath.phase(vector)))


# A machine's reading as the TOML file for ``recut``.


def reading_toml(report: MachineReport) -> str:
    """Return the first reading of ``machine`` as TOML, in the machine's own way of counting angles."""
    reading = report.input["reading"]
    convention = Convention.of(reading)
    lines = [f"# Readings of the {report.input['kind']} machine, seed {report.input['seed']}, first run."]
    if report.serial is not None:
        lines.append(f"serial = {toml_value(report.serial)}")
    if report.input["speed_rpm"] is not None:
        lines.append(f"speed_rpm = {report.input['speed_rpm']!r}")
    if report.bob_weights_g is not None:
        lines.append(f"bob_weights_g = [{', '.join(repr(each) for each in report.bob_weights_g)}]")
    for key, what in (
        ("urr_percent", "unbalance reduction ratio"),
        ("umar_g_mm", "minimum achievable residual"),
    ):
        value = reading[key]
        lines.append(f"# {key}: {what} of the machine, to fill in" if value is None else f"{key} = {value!r}")
    lines += [
        f"rotation = {toml_value(convention.rotation)}",
        f"zero_deg = {convention.zero_deg!r}",
        f"reads = {toml_value(convention.reads)}",
    ]
    for plane in report.runs[0].planes:
        lines += ["", "[[plane]]"]
        if plane.z_mm is not None:
            lines.append(f"z_mm = {plane.z_mm!r}")
        lines += [
            f"g_mm = {plane.g_mm!r}",
            f"angle_deg = {convention.machine_deg(plane.angle_deg)!r}",
        ]
    return "\n".join(lines) + "\n"
