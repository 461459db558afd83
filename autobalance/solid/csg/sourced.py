"""Common parts and differences of a large solid and small ones, with the source of each surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import manifold3d as m3
import numpy as np
from numpy.typing import NDArray

from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Shared:
    """Result of a boolean of a large and a small solid; its surface is partly the one's or the other's.

    Attributes
    ----------
    solid : Solid
    small : int
        manifold3d's number for the small one's surface.
    """

    solid: Solid
    small: int

    @cached_property
    def surfaces(self) -> tuple[Mesh, NDArray[np.bool_]]:
        """The mesh, and a mark of its triangles (m,) on the surface of the small solid."""
        raw = self.solid._body.to_mesh64()
        ends = np.asarray(raw.run_index, dtype=np.int64) // 3
        lengths = ends[1:] - ends[:-1]
        of_small = np.asarray(raw.run_original_id) == self.small
        vertices = np.asarray(raw.vert_properties, dtype=np.float64).reshape(-1, raw.vert_properties.shape[1])
        mesh = Mesh(vertices[:, :3], np.asarray(raw.tri_verts, dtype=np.int64).reshape(-1, 3))
        return mesh, np.repeat(of_small[: len(lengths)], lengths)

    def simplified(self, by_mm: float) -> Shared:
        """Return the solid with edges merged that are shorter than ``by_mm``; its surface moves by less."""
        return Shared(self.solid.simplified(by_mm), self.small)


def shared_with(first: Solid, tools: Sequence[Solid]) -> list[Shared]:
    """Return the common part of ``first`` and each of some small solids."""
    if not tools:
        return []
    bodies = [tool._body.as_original() for tool in tools]
    reach = first._body ^ m3.Manifold.batch_boolean(bodies, m3.OpType.Add)
    own: dict[int, list[m3.Manifold]] = {body.original_id(): [] for body in bodies}
    for part in reach.decompose():
        raw = part.to_mesh64()
        touched = own.keys() & np.asarray(raw.run_original_id)[np.diff(raw.run_index) > 0]
        if len(touched) != 1:  # solids that touch each other share it, and each has its own share
            return [Shared(Solid(reach ^ body), body.original_id()) for body in bodies]
        own[touched.pop()].append(part)
    return [Shared(Solid(m3.Manifold.compose(parts)), small) for small, parts in own.items()]


def beyond(tool: Solid, solid: Solid) -> Shared:
    """Return the part of a small solid outside of ``solid``."""
    body = tool._body.as_original()
    return Shared(Solid(body - solid._body), body.original_id())
