"""The metal that was removed or added, each piece with its correction: for pictures, not for numbers."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.report.records.balanced import BalancedReport
from autobalance.solid.csg.shape import Shared, beyond, shared_with
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Indices
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class Piece:
    """The metal of one correction, removed or added, in file coordinates [mm].

    ``skin`` (k, 3) are the triangles to colour while the metal is in place, ``floor`` (k, 3) those to colour
    on the corrected crank. Both face outward from its metal and use the vertices of ``mesh``. ``correction``
    counts from 0 in the report's list; ``metal`` is the body itself.
    """

    mesh: Mesh
    skin: Indices
    floor: Indices
    correction: int
    metal: Shared

    @classmethod
    def of(cls, metal: Shared, correction: int, adds: bool) -> Piece:
        """Return the metal that a correction shares with the crank, or that it adds to it."""
        mesh, by_tool = metal.surfaces
        triangles = mesh.triangles[by_tool]
        if adds:
            return cls(mesh, triangles, triangles, correction, metal)
        return cls(mesh, mesh.triangles[~by_tool], triangles[:, ::-1], correction, metal)

    def simplified(self, by_mm: float, adds: bool) -> Piece:
        """Return the piece with edges shorter than ``by_mm`` merged."""
        return Piece.of(self.metal.simplified(by_mm), self.correction, adds)


def pieces_of(report: BalancedReport, before: Solid, tools: Sequence[Solid]) -> list[Piece]:
    """Return the metal of each correction from its tool body, file coordinates."""
    adds = [item.of_kind.adds_metal for item in report.corrections]
    removing = [k for k, added in enumerate(adds) if not added]
    pieces = []
    for k, metal in zip(removing, shared_with(before, [tools[k] for k in removing]), strict=True):
        pieces.append(Piece.of(metal, k, adds=False))
    pieces += [Piece.of(beyond(tools[k], before), k, adds=True) for k, added in enumerate(adds) if added]
    return [piece for piece in pieces if len(piece.mesh.triangles)]
