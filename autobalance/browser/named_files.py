"""Files that a job, or a file beside it, names: all must be in the project."""

from __future__ import annotations

from typing import Any

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
