"""Solids with exact surfaces through the CAD kernel: built, measured, cut; needs the extra ``step``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from autobalance.errors import SolidError
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.cad.build import built
from autobalance.solid.cad.kernel import (
    compound,
    explored,
    fused,
    is_valid,
    properties,
    require_kernel,
    shape_bytes,
    shape_of_bytes,
    unified,
)
from autobalance.solid.cad.machining import Taken, machined
from autobalance.solid.cad.surface import Surface
from autobalance.solid.cad.taken import EachTaken, each_taken
from autobalance.solid.cad.tessellation import Facets, bounds_mm, facets, surface_kind, surfaces
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.tool import Tool
from autobalance.types import Array


class ExactSolid:
    """One or several bodies bounded by exact surfaces: planes, cylinders, cones, tori and others.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed.
    SolidError
        If the kernel cannot build the shape, or its result is not valid.
    """

    def __init__(self, shape: Shape) -> None:
        require_kernel()
        self._take(unified(built(shape)), "the CAD kernel could not build the shape exactly")

    @classmethod
    def of(cls, body: Any) -> ExactSolid:
        """Take a body of the CAD kernel, after checking it."""
        solid = cls.__new__(cls)
        solid._take(body, "the CAD kernel finds fault with the solid")
        return solid

    @classmethod
    def of_checked(cls, body: Any) -> ExactSolid:
        """Take a body of the CAD kernel that was checked already."""
        solid = cls.__new__(cls)
        solid._body = body
        return solid

    def __reduce__(self) -> tuple[Callable[..., ExactSolid], tuple[Any, ...]]:
        """Pickle a STEP file: the kernel's bodies stay in their process."""
        return _of_step, (self.step(),)

    def to_plain(self) -> dict[str, Any]:
        """Return the body in the kernel's own binary form, and what is measured on it."""
        return {"body": shape_bytes(self._body), "unit": self._unit, "kinds": self.face_kinds()}

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> ExactSolid:
        """Return the solid of ``to_plain``; the kernel is loaded at the first use of its body."""
        solid = cls.__new__(cls)
        solid.__dict__.update(_data=plain["body"], _unit=plain["unit"], _kinds=dict(plain["kinds"]))
        return solid

    @cached_property
    def _body(self) -> Any:
        """The kernel's body, of a solid that was kept as bytes; others have theirs from the beginning."""
        require_kernel()
        return shape_of_bytes(self.__dict__["_data"])

    def _take(self, body: Any, complaint: str) -> None:
        if not is_valid(body):
            raise SolidError(complaint)
        self._body = body

    @property
    def body(self) -> Any:
        return self._body

    @property
    def volume_mm3(self) -> float:
        return self._unit.mass_g

    @cached_property
    def _unit(self) -> Moments:
        return properties(self._body)

    def moments(self, density_g_mm3: float, frame: Array | None = None) -> Moments:
        """Return the mass moments from the exact surfaces, in ``frame`` (4, 4) if given."""
        moments = self._unit.scaled(density_g_mm3)
        return moments if frame is None else moments.moved(frame)

    @property
    def bounds(self) -> Array:
        """Smallest and largest coordinates (2, 3) [mm], with a little room."""
        return bounds_mm(self._body)

    def face_kinds(self) -> dict[str, int]:
        """Count the faces by their surface: ``plane``, ``cylinder``, ``cone``, ``torus`` and others."""
        return dict(self._kinds)

    @cached_property
    def _kinds(self) -> dict[str, int]:
        return dict(Counter(surface_kind(face) for face in explored(self._body, "FACE")))

    def surfaces(self) -> tuple[Surface, ...]:
        """Return the plane and cylindrical faces."""
        return surfaces(self._body)

    def facets(self) -> Facets:
        """Return triangles whose corners lie on the true surface, and the face of each."""
        return facets(self._body)

    def machined(self, removed: Sequence[Tool], added: Sequence[Tool] = ()) -> ExactSolid:
        """Return the solid with metal added, then other metal removed.

        Raises
        ------
        SolidError
            If the kernel cannot cut it, or it falls apart.
        """
        return self.machined_as_taken(removed, added)[0]

    def machined_as_taken(
        self,
        removed: Sequence[Tool],
        added: Sequence[Tool] = (),
        shares: Sequence[float] | None = None,
    ) -> tuple[ExactSolid, tuple[Taken | None, ...]]:
        """Return the ``machined`` solid and each removing tool's metal, None where its drawing shows that.

        Metal that is on a lowered face is sectioned at the first of ``shares`` of the part's diagonal
        over it that makes a sound cut; see ``clear_shares``.

        Raises
        ------
        SolidError
            As ``machined`` does.
        """
        done = machined(self._body, removed, added, shares)
        return ExactSolid.of(done.body), done.taken

    def each_taken(
        self,
        removed: Sequence[Tool],
        added: Sequence[Tool],
        machined: ExactSolid,
        shares: Sequence[float] | None = None,
    ) -> tuple[tuple[EachTaken, ...], tuple[EachTaken, ...]] | None:
        """Return the metal that each tool took or added on the way to ``machined``; see ``taken``."""
        return each_taken(self._body, removed, added, machined.volume_mm3 - self.volume_mm3, shares)

    def step(self, unit: str = "mm", name: str = "crank") -> bytes:
        """Return a STEP file of the solid, in a unit."""
        from autobalance.solid.cad.step_file import write_step

        return write_step(self._body, unit, name)


def _of_step(data: bytes) -> ExactSolid:
    from autobalance.solid.cad.step_file import read_step_file

    return joined_solids([ExactSolid.of(one.body) for one in read_step_file(data).bodies], apart=True)


def joined_solids(solids: Sequence[ExactSolid], apart: bool = False) -> ExactSolid:
    """Return several solids as one; overlaps count once, and are ruled out by ``apart``."""
    if len(solids) == 1:
        return solids[0]
    bodies = [solid.body for solid in solids]
    return ExactSolid.of(compound(bodies) if apart else fused(bodies))


def are_apart(solids: Sequence[ExactSolid]) -> bool:
    """Return whether the bounding boxes of solids are clear of each other."""
    boxes = [solid.bounds for solid in solids]
    return all(
        bool(np.any(one[0] > other[1]) or np.any(other[0] > one[1]))
        for place, one in enumerate(boxes)
        for other in boxes[:place]
    )
