"""Staging of files, which appear whole and together; and files of an earlier run."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import secrets
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any

from autobalance.errors import FileError, file_errors
from autobalance.runtime import note_begun, to_clean, uninterrupted, was_read

# Staging of files, which appear whole and together or not at all.
#
# Everything is written under temporary names in the folders it belongs to; the last step renames. A run that
# fails or is interrupted before that leaves the old files.


NAME_LETTERS = 40
"""Letters of a file's name that its temporary name keeps."""
LEFT_OVER = re.compile(
    r"\..{1,40}\.(?:(?P<machine>[0-9a-f]{8})-)?(?P<process>\d{1,10})-[0-9a-f]{8}\.part", re.DOTALL
)
"""Temporary names, as a killed run leaves them."""
STARTED = 19
"""Place of a process's start in /proc/PROCESS/stat, counted behind its name (proc(5), field 22)."""
CLOCK_S = 1.0
"""Possible difference of the clocks of a disk and of the system."""
OLD_S = 600.0
"""Age at which temporary files of other machines are deleted; writing and renaming take seconds."""


def seen_from(folder: Path, file: Path) -> str:
    """Return a file's path relative to a folder, or absolute where it is on another drive."""
    try:
        return Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return file.resolve().as_posix()


def from_here(file: str | Path) -> str:
    """Return a file's path as it is typed from the working folder, where that is shorter."""
    try:
        return min(str(file), os.path.relpath(file), key=len)
    except ValueError:  # another drive
        return str(file)


class Staging:
    """Files on their way to one or more folders; use as a context manager.

    Parameters
    ----------
    folders : sequence of Path
        Where files will go; made on entry where they are missing, and taken away again if nothing arrives.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = list(folders)
        self._made: list[Path] = []
        self._waiting: list[tuple[Path, Path]] = []
        self._stale: list[Path] = []

    def __enter__(self) -> Staging:
        """Make the folders and prove that they can be written.

        Raises
        ------
        FileError
            If one cannot.
        """
        to_clean.add(self._clean)
        try:
            for folder in self._folders:
                self._make(folder)
                _prove_writable(folder)
                _sweep(folder)
        except BaseException:
            self._clean()
            to_clean.discard(self._clean)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Delete the files that were not put in place."""
        with uninterrupted():
            self._clean()
        to_clean.discard(self._clean)

    def add(self, path: Path, data: bytes) -> None:
        """Write a file under a temporary name; it gets its own with ``commit``.

        Raises
        ------
        FileError
            If it cannot be written, is a folder or a device, is the file of another output, or was read.
        """
        with file_errors(f"write {path}"):
            is_folder, is_device = path.is_dir(), path.exists() and not path.is_file()
        if is_folder:
            raise FileError(f"cannot write {path}: a folder has this name")
        if is_device:  # renaming to /dev/full put a file in its place
            raise FileError(f"cannot write {path}: it is a device; expected a file's name")
        if was_read(path):
            raise FileError(f"{path} would overwrite a file that is read; choose another place")
        if self.writes(path):
            raise FileError(f"two outputs share the path {path}; choose another path for one of them")
        waiting = _temporary(path)
        with file_errors(f"write {path}"):
            self._waiting.append((waiting, path))
            _write_new(waiting, data)

    def writes(self, path: Path) -> bool:
        """Return whether a file of this path waits for its name."""
        return any(path.resolve() == other.resolve() for _, other in self._waiting)

    def remove(self, path: Path) -> None:
        """Remove a file together with ``commit``; a file that is written or was read stays."""
        if not was_read(path) and path not in self._stale:
            self._stale.append(path)

    def commit(self) -> None:
        """Give every file its name and remove the stale ones; a command's Ctrl-C waits until all is done.

        Raises
        ------
        FileError
            If a file cannot be put in place or removed; the old files are back then, as they were.
        """
        with uninterrupted():
            changed: list[tuple[Path, Path | None]] = []
            try:
                for waiting, path in self._waiting:
                    with file_errors(f"write {path}"):
                        changed.append((path, _kept_aside(path)))
                        os.replace(waiting, path)
                written = {path.resolve() for _, path in self._waiting}
                for path in self._stale:
                    if path.resolve() not in written:
                        with file_errors(f"remove {path}"):
                            changed.append((path, _kept_aside(path)))
                            path.unlink(missing_ok=True)
            except BaseException:
                _put_back(changed)
                raise
            for _, aside in changed:
                if aside is not None:
                    with contextlib.suppress(OSError):
                        aside.unlink()
            for folder in {path.parent for path in self._stale}.difference(self._folders):
                with contextlib.suppress(OSError):  # it holds something else
                    folder.rmdir()
            self._waiting.clear()
            self._stale.clear()
            self._made.clear()

    def _make(self, folder: Path) -> None:
        missing = [each for each in (folder, *folder.parents) if not each.exists()]
        for each in reversed(missing):
            with file_errors(f"make the folder {folder}"):
                note_begun(each)
                each.mkdir()
            self._made.append(each)
        if not folder.is_dir():
            raise FileError(f"cannot write into {folder}: it is a file, not a folder")

    def _clean(self) -> None:
        for waiting, _ in self._waiting:
            with contextlib.suppress(OSError):
                waiting.unlink()
        for folder in reversed(self._made):
            with contextlib.suppress(OSError):
                folder.rmdir()
        self._waiting.clear()
        self._stale.clear()
        self._made.clear()


def _kept_aside(path: Path) -> Path | None:
    """Keep a file under a temporary name until all others are in place; None if it is missing.

    It is a second link, so that the file is never missing; if the disk has no links, it is renamed.
    """
    if not os.path.lexists(path):
        return None
    aside = _temporary(path)
    note_begun(aside)
    try:
        os.link(path, aside, follow_symlinks=False)
    except (OSError, NotImplementedError):
        os.replace(path, aside)
    return aside


def _put_back(changed: Sequence[tuple[Path, Path | None]]) -> None:
    """Undo the changes of a ``commit`` that failed, the last one first."""
    for path, aside in reversed(changed):
        with contextlib.suppress(OSError):
            if aside is None:
                path.unlink(missing_ok=True)
            else:
                os.replace(aside, path)
                aside.unlink(missing_ok=True)  # two links to one file: replacing left both


def _temporary(path: Path) -> Path:
    """Return a temporary name beside ``path`` that cannot be guessed, so that no link can lie there.

    It is no longer than a file's name may be, and holds machine and process for ``_sweep``.
    """
    return path.with_name(
        f".{path.name[:NAME_LETTERS]}.{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.part"
    )


@cache
def _machine() -> str:
    """Return eight hexadecimal digits for this machine: a folder may be shared by several."""
    import platform
    import zlib

    return f"{zlib.crc32(platform.node().encode()):08x}"


def _sweep(folder: Path) -> None:
    """Delete temporary files of killed runs in a folder: files of no living process.

    Processes of another machine cannot be looked up: their files are deleted when they are old.
    """
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            left = LEFT_OVER.fullmatch(path.name)
            if left is None:
                continue
            with contextlib.suppress(OSError):
                written = path.lstat().st_mtime
                if not _lives(int(left["process"]), written):
                    ours = left["machine"] == _machine()
                    if ours or time.time() - written > OLD_S:
                        path.unlink()


def _lives(process: int, written_s: float) -> bool:
    """Return whether a process that wrote a file is alive; True where that is not known.

    Numbers are given again, in a container at every start: a process that began after the file was written is
    another one.
    """
    if os.name == "nt":  # there, signal 0 would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    began_s = _began_s(process)
    return began_s is None or began_s <= written_s + CLOCK_S


def _began_s(process: int) -> float | None:
    """Return when a process began, as times of files; None where the system does not tell."""
    try:
        words = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()
        since_boot_s = int(words[STARTED]) / os.sysconf("SC_CLK_TCK")
        return time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + since_boot_s
    except (AttributeError, IndexError, OSError, ValueError):
        return None


def _write_new(path: Path, data: bytes) -> None:
    """Write a file that must not exist yet, following no link and overwriting nothing."""
    note_begun(path)
    with path.open("xb") as stream:
        stream.write(data)


def _prove_writable(folder: Path) -> None:
    probe = _temporary(folder / "probe")
    with file_errors(f"write into the folder {folder}"):
        _write_new(probe, b"")
        probe.unlink()


# Files of an earlier run in a folder: those that its report lists and the new run does not write.
#
# They are removed together with the new files' renames. A file that no report of this program lists, or that
# was changed since, is never touched.


MOST_BYTES = 200_000_000
"""Length of a report at most; the longest of a batch has some MB."""


def earlier_report(path: Path) -> Mapping[str, Any] | None:
    """Return the values of a report of this program; None if it is missing or another file."""
    try:
        if not path.is_file() or path.stat().st_size > MOST_BYTES:
            return None
        values = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    ours = isinstance(values, dict) and isinstance(values.get("autobalance"), dict)
    return values if ours and isinstance(values.get("command"), str) else None


def remove_stale(staging: Staging, report: Path, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Let a staging remove the files of the earlier report in the place of a new one.

    Parameters
    ----------
    staging : Staging
        The new files' own, the new report among them.
    report : Path
        Where the new report goes.
    values : mapping
        The new report; the files that it names stay, even if the earlier one lists them.

    Returns
    -------
    tuple of str Listed files that were changed since, which stay, as a warning; empty without any.
    """
    earlier = earlier_report(report)
    if earlier is None:
        return ()
    folder, changed = report.parent, []
    named = {(folder / name).resolve() for name in _names_in(values)}
    for name, digest in listed_outputs(earlier):
        path = folder / name
        if staging.writes(path) or path.resolve() in named or not _is_below(path, folder):
            continue
        if path.is_symlink() or not path.is_file():
            continue
        if hashlib.sha256(path.read_bytes()).hexdigest() == digest:
            staging.remove(path)
        else:
            changed.append(name)
    if not changed:
        return ()
    them = "it" if len(changed) == 1 else "them"
    return (
        f"{folder}: {', '.join(changed)} of the earlier run was changed since and stays; "
        f"this run did not write {them}",
    )


def listed_outputs(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the names and sha256 of the files that a report lists as written beside it."""
    outputs = values.get("outputs")
    for entry in outputs.values() if isinstance(outputs, Mapping) else ():
        if isinstance(entry, Mapping):
            name, digest = entry.get("file"), entry.get("sha256")
            if isinstance(name, str) and name and isinstance(digest, str):
                yield name, digest


def _is_below(path: Path, folder: Path) -> bool:
    return path.resolve() != folder.resolve() and path.resolve().is_relative_to(folder.resolve())


def _names_in(values: Any) -> Iterator[str]:
    """Yield every file that a report names, at any depth."""
    if isinstance(values, Mapping):
        for key, value in values.items():
            if isinstance(value, str) and key in ("file", "report", "crank"):
                yield value
            else:
                yield from _names_in(value)
    elif isinstance(values, list | tuple):
        for each in values:
            yield from _names_in(each)


def refuse_another_run(folder: Path, report: Path) -> None:
    """Refuse a folder whose report of a run is another than the one that files are made of.

    Raises
    ------
    FileError
        If papers of one crank would lie beside the report of another.
    """
    there = folder / report.name
    if there.resolve() != report.resolve() and earlier_report(there) is not None:
        raise FileError(f"{folder} holds {there.name} of another run; choose another folder")
