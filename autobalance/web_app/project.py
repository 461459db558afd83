"""A project: a folder with plain files that the commands understand; nothing outside it is touched."""

from __future__ import annotations

import hashlib
import re
import secrets
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autobalance.errors import FileError

LONGEST_NAME = 120
JOB = "job.toml"
RUNS = "runs"
RUN_ID = re.compile(r"[0-9a-f]{12}")


class TooLarge(Exception):  # noqa: N818 - what happened, not a fault of the program
    """An upload is larger than allowed."""


@dataclass(frozen=True)
class Project:
    """A folder for uploads, the job, and the results of runs."""

    folder: Path

    @classmethod
    def at(cls, folder: Path) -> Project:
        """Open a project, made where it is missing.

        Raises
        ------
        FileError
            If it cannot be made.
        """
        try:
            (folder / RUNS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                f"cannot make the project {folder}: {(error.strerror or str(error)).lower()}"
            ) from None
        return cls(folder.resolve())

    def file(self, name: str) -> Path | None:
        """Return a file of the project by its plain name; None where there is none, or a link."""
        if not is_plain(name):
            return None
        path = self.folder / name
        return path if path.is_file() and not path.is_symlink() else None

    def files(self) -> list[str]:
        """Return the names of the files, without those that are hidden."""
        return sorted(path.name for path in self.folder.iterdir() if self.file(path.name) is not None)

    def run_folder(self, run: str) -> Path:
        """Return where the results of a run go."""
        return self.folder / RUNS / run

    def result(self, run: str, name: str) -> Path | None:
        """Return a result file of a run; None where there is none, or a link."""
        if not (RUN_ID.fullmatch(run) and is_plain(name)):
            return None
        path = self.run_folder(run) / name
        inside = not self.run_folder(run).is_symlink() and not path.is_symlink()
        return path if inside and path.is_file() else None

    async def keep(self, name: str, body: AsyncIterator[bytes], most_bytes: int) -> dict[str, Any]:
        """Write an upload as it comes in; a taken name gets a number.

        Raises
        ------
        TooLarge
            If it is larger than ``most_bytes``; nothing is kept then.
        """
        waiting = self.folder / f".upload-{secrets.token_hex(6)}.part"
        digest, size = hashlib.sha256(), 0
        try:
            with waiting.open("xb") as stream:
                async for chunk in body:
                    size += len(chunk)
                    if size > most_bytes:
                        raise TooLarge
                    digest.update(chunk)
                    stream.write(chunk)
            target = self._free(name)
            waiting.rename(target)
        finally:
            waiting.unlink(missing_ok=True)
        return {"file": target.name, "bytes": size, "sha256": digest.hexdigest()}

    def _free(self, name: str) -> Path:
        path, number = self.folder / name, 2
        while path.exists() or path.is_symlink():
            path = self.folder / f"{Path(name).stem}-{number}{Path(name).suffix}"
            number += 1
        return path


def is_plain(name: str) -> bool:
    """Tell whether a name is a file's own: no folder, no leading dot, no control character.

    Examples
    --------
    >>> [is_plain(name) for name in ("crank.stl", "../crank.stl", ".hidden", "a/b", "runs", "")]
    [True, False, False, False, False, False]
    """
    reserved = {"", RUNS, "con", "nul", "aux", "prn"}
    return (
        name.lower() not in reserved
        and len(name) <= LONGEST_NAME
        and not name.startswith(".")
        and name.isprintable()
        and not any(each in name for each in '/\\:*?"<>|')
    )
