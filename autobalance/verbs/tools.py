"""The bodies of a result's tools, for CAD programs: as triangles, and as exact shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError

if TYPE_CHECKING:
    from autobalance.solid.csg.solid import Solid


@dataclass(frozen=True, eq=False)
class CutTool:
    """The body that a correction subtracts from the crank, or adds to it; file coordinates [mm].

    Attributes
    ----------
    correction : int
        Its place in the report's ``corrections``, from 0.
    kind : str
        As in the report.
    label : str
        ``cut 3: drill ⌀12``.
    adds_metal : bool
    vertices_mm : (n, 3) float
    triangles : (m, 3) int
        Counter-clockwise seen from outside.
    volume_mm3 : float
        Of the body of these triangles, which begins outside of the metal; not of what it takes. The report's
        ``tool_volume_mm3`` is that of the body of ``to_shape()``: with true surfaces, and no wider than a
        lowered face.
    """

    correction: int
    kind: str
    label: str
    adds_metal: bool
    vertices_mm: NDArray[np.float64]
    triangles: NDArray[np.int64]
    volume_mm3: float
    entry: Mapping[str, Any]
    rotor_to_file: NDArray[np.float64]

    def to_shape(self) -> Any:
        """Return the body as a ``TopoDS_Shape`` of OCP with true surfaces, in mm.

        Raises
        ------
        FormatError
            If the CAD kernel is not installed, or the kind does not say its exact body.
        """
        from autobalance.correction import KINDS
        from autobalance.solid.cad.shapes import nothing, shape_of

        if self.entry["depth_mm"] == 0.0:  # a kept cut that is not needed
            return nothing()
        drawn = KINDS[self.kind].drawn(self.entry)
        if drawn is None:
            raise FormatError(f"{self.label}: the kind {self.kind!r} does not say its exact body")
        return shape_of(drawn, self.rotor_to_file)


def tools_of(
    corrections: Sequence[Mapping[str, Any]], bodies: Sequence[Solid], rotor_to_file: NDArray[np.float64]
) -> tuple[CutTool, ...]:
    """Return the tools of a report's ``corrections``, one a correction, in their order.

    ``bodies`` are in file coordinates [mm], to which ``rotor_to_file`` (4, 4) leads.
    """
    from autobalance.correction import KINDS

    return tuple(
        CutTool(
            number,
            str(entry["kind"]),
            str(entry["label"]),
            KINDS[entry["kind"]].adds_metal,
            body.mesh.vertices.copy(),  # the kept ones cannot be written, which manifold3d refuses
            body.mesh.triangles.copy(),
            float(body.volume_mm3),
            entry,
            rotor_to_file,
        )
        for number, (entry, body) in enumerate(zip(corrections, bodies, strict=True))
    )
