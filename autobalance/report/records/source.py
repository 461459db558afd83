"""The program and its libraries, and the crank's place in its file."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Annotated, Self

from autobalance.declare import Size, record
from autobalance.types import Array
from autobalance.version import __version__

LIBRARIES = ("numpy", "scipy", "trimesh", "manifold3d")


@record
class Versions:
    """The program and the libraries that made the report."""

    version: str
    numpy: str | None
    scipy: str | None
    trimesh: str | None
    manifold3d: str | None

    @classmethod
    def here(cls) -> Self:
        return cls(version=__version__, **library_versions())


@cache
def library_versions() -> dict[str, str | None]:
    """Return the version of each library that is installed; looking them up reads files."""
    from importlib.metadata import PackageNotFoundError, version

    versions: dict[str, str | None] = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = None
    return versions


@record
class Frame:
    """From file coordinates in mm to the rotor frame."""

    file_to_rotor: Annotated[
        Sequence[Annotated[Sequence[float], Size(4, 4)]] | Array,
        Size(4, 4),
    ]
