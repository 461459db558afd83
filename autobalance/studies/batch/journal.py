"""Journal of a batch on disk: a line a row, and a folder that one batch at a time holds."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated

from autobalance.declare import Count, Named, Ordinal, Sha256, decoded, encoded, record
from autobalance.errors import FileError, file_errors

JOURNAL = "journal.jsonl"
ENDING_S = 1.0
"""Threads of a batch that was killed may still end, and hold its folder, once its process is gone."""


@record
class JournalLine:
    """Journal entry of a finished row."""

    row: Ordinal
    name: str
    exit_code: Count
    fingerprint: Sha256
    try_: Annotated[Ordinal, Named("try")]
    worker: Annotated[str, "of a row that was never begun, or was lost: nobody"]
    started: str
    finished: str
    message: str
    files: Annotated[Mapping[str, Sha256], "sha256 by name"]


def made_folder(folder: Path) -> None:
    """Make a missing folder.

    Raises
    ------
    FileError
        If it cannot be made.
    """
    with file_errors(f"make the folder {folder}"):
        folder.mkdir(parents=True, exist_ok=True)


@contextlib.contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold a folder: the system lets go of it when this process ends, however that comes.

    Raises
    ------
    FileError
        If another process holds it.
    """
    handle = _opened(folder)
    try:
        latest = time.monotonic() + ENDING_S
        while not _locked(handle):
            if time.monotonic() > latest:
                raise FileError(f"{folder} is held by another batch that is running; choose another folder")
            time.sleep(0.02)
        yield
    finally:
        os.close(handle)


def _opened(folder: Path) -> int:
    if os.name == "nt":  # folders cannot be locked there
        return os.open(folder / ".lock", os.O_RDWR | os.O_CREAT)
    return os.open(folder, os.O_RDONLY)


def _locked(handle: int) -> bool:
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def read_journal(folder: Path) -> dict[str, JournalLine]:
    """Return the last whole line of each row, by the row's name; a line that was cut off does not count."""
    path = folder / JOURNAL
    if not path.exists():
        return {}
    with file_errors(f"read {path}"):
        data = path.read_bytes()
    found = (journal_line(text) for text in data.split(b"\n")[:-1])
    return {line.name: line for line in found if line is not None}


def journal_line(text: bytes) -> JournalLine | None:
    """Return a line as it was read; None where it is none of ours, or was changed by hand."""
    try:
        values = json.loads(text)
        line = decoded(JournalLine, values)
    except (ValueError, RecursionError):
        return None
    return line if encoded(line) == values else None


def rewrite_journal(folder: Path, lines: Iterable[JournalLine]) -> None:
    """Replace the journal by these lines, whole or not at all."""
    part = folder / f".{JOURNAL}.part"
    part.write_bytes(b"".join(_bytes(line) for line in lines))
    os.replace(part, folder / JOURNAL)


def append_line(folder: Path, line: JournalLine) -> None:
    """Add a line, and do not return before the disk has it."""
    with (folder / JOURNAL).open("ab") as stream:
        stream.write(_bytes(line))
        stream.flush()
        os.fsync(stream.fileno())


def _bytes(line: JournalLine) -> bytes:
    return json.dumps(encoded(line), ensure_ascii=False, allow_nan=False).encode() + b"\n"
