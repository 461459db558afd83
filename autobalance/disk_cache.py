"""What reading a file gave, kept from run to run in the user's cache folder.

An entry is one file, named by the digest of its inputs: the file's content, the request, this program and its
libraries. It is written under a temporary name and renamed. It begins with the digest of its content, and the
value is computed again if that does not fit. What was just computed is made again from the same plain values
and arrays, with a cache or without, so that results are the same to the bit.
"""

from __future__ import annotations

import hashlib
import io
import os
import secrets
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import IO, TypeVar

from autobalance.errors import UsageError
from autobalance.user_folders import cache_folder
from autobalance.value_codec import CodecError, from_bytes, plain_of, to_bytes, value_of, write
from autobalance.version import __version__

LIMIT_VARIABLE = "AUTOBALANCE_CACHE_MB"
USUAL_MB = 1000.0
BYTES_PER_MB = 1e6
ENDING = ".kept"
LIBRARIES = ("numpy", "scipy", "manifold3d", "cadquery-ocp", "cadquery-ocp-novtk", "trimesh")
"""Distributions that reading and recognition compute with."""
TEMPORARY = ".part-"
STALE_S = 3600.0
"""Age from which a temporary file is the leftover of a run that was killed."""
DIGEST = hashlib.sha256
PIECE = 1 << 20
"""Bytes that are copied at once."""
T = TypeVar("T")


def kept(kind: str, key: str, work: Callable[[], T]) -> T:
    """Return the result of ``work``, from the cache where an earlier run left it there.

    Parameters
    ----------
    kind : str
        What it is, as "source".
    key : str
        All that the result depends on beside this program; empty: nothing is kept.
    work : callable

    Raises
    ------
    UsageError
        If ``AUTOBALANCE_CACHE_MB`` is not a number.
    """
    limit = limit_bytes()
    path = None if not key or limit <= 0.0 else _path(kind, key)
    try:
        if path is not None:
            found: T = from_bytes(_read(path))
            return found
    except (OSError, CodecError):  # none there, spoilt, or taken out by another process: read anew
        pass
    plain = plain_of(work())
    if path is not None:
        with _scratch() as stream:
            write(plain, stream)
            _write(path, stream, limit)
    made: T = value_of(plain)
    return made


def _scratch() -> IO[bytes]:
    """Return a temporary file for a value on its way: in memory a large mesh would be there three times."""
    try:
        return tempfile.TemporaryFile()
    except OSError:  # no folder takes one
        return io.BytesIO()


def digest_of(value: object) -> str:
    """Return the digest of a value's content, for keys of what follows from it."""
    return DIGEST(to_bytes(value)).hexdigest()


def limit_bytes() -> float:
    """Return the limit of the cache: ``AUTOBALANCE_CACHE_MB``, else 1 GB; 0 turns it off.

    Raises
    ------
    UsageError
        If it is not a number.
    """
    text = os.environ.get(LIMIT_VARIABLE) or str(USUAL_MB)
    try:
        megabytes = float(text)
    except ValueError:
        raise UsageError(f"{LIMIT_VARIABLE} is {text!r}. Enter a number of MB, 0 for no cache.") from None
    return megabytes * BYTES_PER_MB


@contextmanager
def without_cache() -> Iterator[None]:
    """Turn the cache off inside the block, also in processes that it starts."""
    before = os.environ.get(LIMIT_VARIABLE)
    os.environ[LIMIT_VARIABLE] = "0"
    try:
        yield
    finally:
        if before is None:
            del os.environ[LIMIT_VARIABLE]
        else:
            os.environ[LIMIT_VARIABLE] = before


def _path(kind: str, key: str) -> Path:
    name = DIGEST("\0".join((kind, key, program())).encode("utf-8", "surrogatepass")).hexdigest()
    return cache_folder() / f"{kind}-{name}{ENDING}"


@cache
def program() -> str:
    """Return the identity of this program and its libraries: versions, and the state of its files."""
    root = Path(__file__).parent
    files = sorted(
        (each.relative_to(root).as_posix(), (stat := each.stat()).st_size, stat.st_mtime_ns)
        for folder in READS
        for each in (root / folder).rglob("*.py")
    )
    return repr((__version__, [_version(each) for each in LIBRARIES], files))


READS = ("solid", "crank", "balancing", "rigid_rotor")
"""Folders of the code that reads and recognises: in a checkout it changes without its version."""


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return ""


def _read(path: Path) -> memoryview:
    """Return the content of an entry.

    Raises
    ------
    OSError
        If the entry is missing.
    CodecError
        If it is spoilt.
    """
    whole = memoryview(path.read_bytes())
    size = DIGEST().digest_size
    if DIGEST(whole[size:]).digest() != whole[:size]:
        raise CodecError(f"{path.name} is spoilt")
    with suppress(OSError):
        os.utime(path)  # the oldest go first
    return whole[size:]


def _write(path: Path, stream: IO[bytes], limit: float) -> None:
    """Write an entry whole or not at all; a folder that takes nothing costs time, no result."""
    if stream.seek(0, io.SEEK_END) > limit:
        return
    digest = DIGEST()
    stream.seek(0)
    while piece := stream.read(PIECE):
        digest.update(piece)
    temporary = path.with_name(f"{TEMPORARY}{os.getpid()}-{secrets.token_hex(8)}")
    with suppress(OSError):
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        try:
            with temporary.open("wb") as target:
                target.write(digest.digest())
                stream.seek(0)
                shutil.copyfileobj(stream, target, PIECE)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
        _make_room(path.parent, limit)


def _make_room(folder: Path, limit: float) -> None:
    """Remove the oldest entries until the rest is within the limit, and leftovers of killed runs."""
    entries = []
    for each in folder.iterdir():
        with suppress(OSError):  # another process makes room too
            stat = each.stat()
            if each.name.startswith(TEMPORARY) and time.time() - stat.st_mtime > STALE_S:
                each.unlink()
            elif each.name.endswith(ENDING):
                entries.append((stat.st_mtime_ns, stat.st_size, each))
    held = float(sum(size for _, size, _ in entries))
    for _, size, each in sorted(entries):
        if held <= limit:
            return
        with suppress(OSError):
            each.unlink()
        held -= size
