"""The program, the crank's file and its place."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Annotated, Self

from autobalance.declare import ABSENT, INLINE, Absent, Ordinal, Sha256, Size, record
from autobalance.types import Array
from autobalance.version import __version__

if TYPE_CHECKING:
    from autobalance.balancing.record import InputFile

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
class CrankFile:
    """A file that holds a crank."""

    file: Annotated[str | None, "null: made in memory"]
    sha256: Sha256
    format: str | None
    triangles: Ordinal
    bodies: Ordinal
    repairs: Sequence[str]

    @classmethod
    def of(cls, file: InputFile) -> Self:
        return cls(**{key: value for key, value in vars(file).items() if key != "scan"})


@record
class Input:
    """The crank file."""

    own: Annotated[CrankFile, INLINE]
    scan: Annotated[CrankFile, "whose mass and unbalance count, where the drawing is cut"] | Absent = ABSENT

    @classmethod
    def of(cls, file: InputFile) -> Self:
        scan = ABSENT if file.scan is None else CrankFile.of(file.scan)
        return cls(own=CrankFile.of(file), scan=scan)


@record
class Frame:
    """From file coordinates in mm to the rotor frame."""

    file_to_rotor: Annotated[
        Sequence[Annotated[Sequence[float], Size(4, 4)]] | Array,
        Size(4, 4),
    ]
