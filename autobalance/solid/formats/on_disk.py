"""The bytes of a file on disk."""

from __future__ import annotations

from pathlib import Path

from autobalance.errors import FileError, file_errors, refuse_pipe
from autobalance.runtime import note_read

LARGEST_BYTES = 2 << 30
"""Bytes of a solid's file at most: scanners write some hundred megabytes, and reading takes ten times as much
memory."""


def one_file_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

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
        refuse_pipe(path)
        note_read(path)
        size = path.stat().st_size
        if size > LARGEST_BYTES:
            raise FileError(
                f"{path} has {size / 2**30:.1f} GB; expected at most {LARGEST_BYTES >> 30} GB, "
                "a crank of 40 million triangles: decimate it"
            )
        return path.read_bytes()
