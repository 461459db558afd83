"""Which versions of the libraries that numbers rest on are installed."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from functools import cache

LIBRARIES = ("numpy", "scipy", "trimesh", "manifold3d")
BESIDE = ".dist-info"
"""What the names of folders beside installed libraries end with, after name and version."""


@cache
def library_versions() -> dict[str, str | None]:
    """Return the version of each library, read from the names of folders; None of one not installed.

    Where no folder tells, the standard library is asked; to load what it needs for that takes 50 ms.
    """
    found: dict[str, str] = {}
    for folder in sys.path:
        with suppress(OSError):  # no folder, or not to be read
            for name in os.listdir(folder or os.curdir):
                library, _, version = name.removesuffix(BESIDE).partition("-")
                if library in LIBRARIES and name.endswith(BESIDE):
                    found.setdefault(library, version)
    return {name: found.get(name) or _by_metadata(name) for name in LIBRARIES}


def _by_metadata(name: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return None
