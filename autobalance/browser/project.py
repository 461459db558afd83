"""A project: a folder with plain files that the commands understand; nothing outside it is touched."""

from __future__ import annotations

import contextlib
import hashlib
import re
import secrets
import shutil
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from autobalance.errors import FileError, file_errors
from autobalance.value_classes import dataclass

# A project: a folder with plain files that the commands understand; nothing outside it is touched.


LONGEST_NAME = 120
JOB = "job.toml"
RUNS = "runs"
APP_FOLDER = ".app"
"""Files that the page needs besides those of the commands: meshes for its view, runs' states."""
STATE = "run.json"
"""File of a run: its verb, its request, its start and its end."""
ABOVE_EXIT_CODE = 4
"""Exit code of a run whose result is above tolerance."""
RUN_ID = re.compile(r"[0-9a-f]{12}")
UPLOAD_PREFIX = ".upload-"


class TooLarge(Exception):  # noqa: N818 - what happened, not a fault of the program
    """An upload is larger than allowed."""


@dataclass(frozen=True)
class Project:
    """A folder for uploads, the job, and the results of runs."""

    folder: Path

    @classmethod
    def at(cls, folder: Path) -> Project:
        """Open a project, made where it is missing; uploads that were cut off go.

        Raises
        ------
        FileError
            If it cannot be made, or leads out of itself.
        """
        with file_errors(f"make the project {folder}"):
            for room in (folder / RUNS, folder / APP_FOLDER):
                room.mkdir(parents=True, exist_ok=True)
                if room.is_symlink():
                    raise FileError(f"{room} is a link; a project's own folders must be in it")
            for left in folder.glob(f"{UPLOAD_PREFIX}*"):
                left.unlink()
        return cls(folder.resolve())

    def file(self, name: str) -> Path | None:
        """Return a file of the project by its plain name; None if it is missing or a link."""
        if not is_plain(name):
            return None
        path = self.folder / name
        return path if path.is_file() and not path.is_symlink() else None

    def files(self) -> list[str]:
        """Return the names of the files, without those that are hidden."""
        return sorted(path.name for path in self.folder.iterdir() if self.file(path.name) is not None)

    def run_folder(self, run: str) -> Path:
        """Return the folder of a run's results: the files of its command and nothing else."""
        return self.folder / RUNS / run

    def own_folder(self, run: str) -> Path:
        """Return the folder of the page's own files of a run."""
        return self.folder / APP_FOLDER / run

    def as_named(self, message: str) -> str:
        """Return a message that names the project's files as people do: without where they lie here."""
        folder = re.escape(str(self.folder))
        return re.sub(rf"{folder}/(?:{RUNS}|{re.escape(APP_FOLDER)})/[0-9a-f]{{12}}/|{folder}/", "", message)

    def forget(self, run: str) -> None:
        """Take all files of a run away."""
        for folder in (self.run_folder(run), self.own_folder(run)):
            shutil.rmtree(folder, ignore_errors=True)

    def result(self, run: str, name: str) -> Path | None:
        """Return a result file of a run; None if it is missing or a link."""
        return _inside(self.run_folder(run), run, name)

    def own(self, run: str, name: str) -> Path | None:
        """Return one of the page's own files of a run; None if it is missing."""
        return _inside(self.own_folder(run), run, name)

    @property
    def job_text(self) -> str:
        """The text of the job; empty without a job."""
        path = self.file(JOB)
        return "" if path is None else path.read_text(encoding="utf-8", errors="replace")

    @property
    def job_version(self) -> str:
        """Fingerprint of the job's text: a request to save a job names the version that was changed."""
        return hashlib.sha256(self.job_text.encode("utf-8", "surrogatepass")).hexdigest()

    def write_job(self, text: str) -> None:
        """Keep the text of the job."""
        self.write_text(JOB, text)

    def write_text(self, name: str, text: str) -> None:
        """Keep the text of a file of the project; whole, and never through a link."""
        self.write_bytes(name, text.encode())  # an error of the text leaves no file behind

    def write_bytes(self, name: str, data: bytes) -> None:
        """Keep a file of the project; whole, and never through a link."""
        waiting = self.folder / f"{UPLOAD_PREFIX}{secrets.token_hex(6)}.part"
        waiting.write_bytes(data)
        waiting.replace(self.folder / name)

    async def keep(
        self, name: str, body: AsyncIterator[bytes], most_bytes: int, apart: str | None = None
    ) -> dict[str, Any]:
        """Write an upload as it comes in. A taken name gets a number; ``apart``: with others of this id.

        Raises
        ------
        TooLarge
            If it is larger than ``most_bytes``; nothing is kept then.
        """
        folder = self.folder if apart is None else self.own_folder(apart)
        folder.mkdir(parents=True, exist_ok=True)
        waiting = self.folder / f"{UPLOAD_PREFIX}{secrets.token_hex(6)}.part"
        digest, size = hashlib.sha256(), 0
        try:
            with waiting.open("xb") as stream:
                async for chunk in body:
                    size += len(chunk)
                    if size > most_bytes:
                        raise TooLarge
                    digest.update(chunk)
                    stream.write(chunk)
            target = free(folder, name)
            waiting.rename(target)
        finally:
            waiting.unlink(missing_ok=True)
        return {"file": target.name, "bytes": size, "sha256": digest.hexdigest()}

    def copied(self, source: Path) -> str:
        """Copy a file in; return its name here: its own, unless another file has that.

        Raises
        ------
        FileError
            If it cannot be read.
        """
        with file_errors(f"copy {source}"):
            data = source.read_bytes()
            name = source.name if is_plain(source.name) else f"file{source.suffix.lower()}"
            here = self.file(name)
            if here is not None and here.read_bytes() == data:
                return name
            target = free(self.folder, name)
            target.write_bytes(data)
        return target.name


def free(folder: Path, name: str) -> Path:
    """Return the file of a name in a folder, or of the first with a number that is not taken."""
    path, number = folder / name, 2
    while path.exists() or path.is_symlink():
        path = folder / f"{Path(name).stem}-{number}{Path(name).suffix}"
        number += 1
    return path


def _inside(folder: Path, run: str, name: str) -> Path | None:
    if not (RUN_ID.fullmatch(run) and is_plain(name)):
        return None
    path = folder / name
    with contextlib.suppress(OSError):
        if not folder.is_symlink() and not path.is_symlink() and path.is_file():
            return path
    return None


def is_plain(name: str) -> bool:
    """Return whether a name is a file's own: no folder, no leading dot, no control character.

    Examples
    --------
    >>> [is_plain(name) for name in ("crank.stl", "../crank.stl", ".hidden", "a/b", "runs", "")]
    [True, False, False, False, False, False]
    """
    reserved = {"", RUNS, "con", "nul", "aux", "prn"}
    return (
        name.strip().lower() not in reserved
        and len(name.encode()) <= LONGEST_NAME
        and not name.startswith(".")
        and name.isprintable()
        and not any(each in name for each in '/\\:*?"<>|')
    )


# Files that a job, or a file beside it, names: all must be in the project.


FILE_KEYS = ("file", "scan_file", "trace", "logo")
"""Keys of a job that name a file."""


def named_files(values: Any, keys: tuple[str, ...] = FILE_KEYS, path: str = "") -> list[tuple[str, Any]]:
    """Return every file that a job, or another file, names under one of ``keys``, with where it does."""
    files: list[tuple[str, Any]] = []
    if isinstance(values, dict):
        for key, value in values.items():
            where = f"{path}.{key}" if path else str(key)
            is_name = key in keys and not isinstance(value, dict | list)
            files += [(where, value)] if is_name else named_files(value, keys, where)
    elif isinstance(values, list):
        for place, item in enumerate(values, 1):
            files += named_files(item, keys, f"{path}[{place}]")
    return files
