"""Cranks of equal files are read, recognised and looked at once, where tests are about what follows.

Two bundled cranks stand in hundreds of tests. What reading, recognition and the look at facets return is
frozen and follows from the bytes of the file and the keys of the job: tests can share it, in any order.
Their own tests, and sweeps, do all of it anew.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import pytest

from autobalance.balancing import measured_crank
from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.job import Balance
from autobalance.solid.cad import tessellation
from autobalance.solid.cad.surface import CylinderFace
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source, read
from autobalance.verification import earlier_stage, solids
from tests.sweeps import SWEPT

MOST = 24
"""Results that are kept of each kind: solids of some megabytes."""
T = TypeVar("T")

facets_of = measured_crank.facets_of


class Kept:
    """The latest results, each with what its key stands for, so that no identity is given out again."""

    def __init__(self) -> None:
        self._known: OrderedDict[Hashable, tuple[Any, Any]] = OrderedDict()

    def once(self, key: Hashable, of: object, work: Callable[[], T]) -> T:
        """Return what ``work`` returns, or returned for the same key before."""
        if key not in self._known:
            self._known[key] = of, work()
        self._known.move_to_end(key)
        found: T = self._known[key][1]
        while len(self._known) > MOST:
            self._known.popitem(last=False)
        return found


SOURCES, ANATOMIES, LOOKS = Kept(), Kept(), Kept()


def known(path: Path, unit: str | None, body: int | str | None = None, **how: Any) -> Source:
    """Return what ``read`` returns, or returned for a file of equal bytes before."""
    if not path.is_file():
        return read(path, unit, body, **how)
    fineness = tessellation.SAG_SHARE, tessellation.TURN_RAD
    bytes_now = hashlib.sha256(path.read_bytes()).hexdigest()
    asked = how.get("pressed_up", False), how.get("unite")
    key = (bytes_now, path.suffix.lower(), unit, type(body), body, asked, fineness)
    return SOURCES.once(key, None, lambda: read(path, unit, body, **how))


def _recognise(solid: Solid, overrides: Overrides, cylinders: Sequence[CylinderFace] = ()) -> Anatomy:
    key = id(solid), repr(overrides), tuple(map(id, cylinders))
    return ANATOMIES.once(key, (solid, cylinders), lambda: recognise(solid, overrides, cylinders))


def _facets_of(
    source: Source, density_g_mm3: float, anatomy: Anatomy, asked: Balance | None = None
) -> ChordalError:
    how = None if asked is None else (asked.margin, asked.facet_correction)
    key = id(source), density_g_mm3, id(anatomy), how, measured_crank.FACETS_MOST
    return LOOKS.once(key, (source, anatomy), lambda: facets_of(source, density_g_mm3, anatomy, asked))


@contextmanager
def read_once() -> Iterator[None]:
    """Share what was read; what a test put in its place itself stays there."""
    with pytest.MonkeyPatch.context() as patch:
        for module in () if SWEPT else (measured_crank, solids, earlier_stage):
            if vars(module)["read"] is read:
                patch.setattr(module, "read", known)
        if not SWEPT and vars(measured_crank)["recognise"] is recognise:
            patch.setattr(measured_crank, "recognise", _recognise)
            patch.setattr(measured_crank, "facets_of", _facets_of)
        yield
