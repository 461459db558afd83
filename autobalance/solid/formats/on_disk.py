"""The bytes of a file on disk."""

from __future__ import annotations

from pathlib import Path

from autobalance.errors import FileError
from autobalance.runtime import note_read


def file_bytes(path: Path) -> bytes:
    """Return the bytes of a solid's file.

    Raises
    ------
    FileError
        If it is missing, no regular file, or cannot be read.
    """
    try:
        if path.is_dir():
            raise FileError(f"{path} is a folder; expected a file")
        if path.exists() and not path.is_file():  # a device or a pipe may never end
            raise FileError(f"{path} is no regular file; expected one on disk")
        note_read(path)
        return path.read_bytes()
    except FileError:
        raise
    except FileNotFoundError:
        raise FileError(f"{path} does not exist") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"{path} cannot be read: {reason}") from None
