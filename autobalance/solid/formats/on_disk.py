"""The bytes of a file on disk."""

from __future__ import annotations

from pathlib import Path

from autobalance.errors import FileError, file_errors
from autobalance.runtime import note_read


def file_bytes(path: Path) -> bytes:
    """Return the bytes of a solid's file.

    Raises
    ------
    FileError
        If it is missing, no regular file, or cannot be read.
    """
    with file_errors(f"read {path}"):
        if path.is_dir():
            raise FileError(f"{path} is a folder; expected a file")
        if not path.exists():
            raise FileError(f"{path} does not exist")
        if not path.is_file():  # a device or a pipe may never end
            raise FileError(f"{path} is not a regular file; expected one on disk")
        note_read(path)
        return path.read_bytes()
