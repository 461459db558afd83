"""The crank and the removed metal for pages and pictures, as fine as a screen shows and no finer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from autobalance.report.balance import kinds
from autobalance.report.metal import Piece, pieces_of
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh

VIEW_TRIANGLES = 100_000
"""Triangles above which a crank is shown decimated."""
FINEST_VIEW = 4e-5
"""Share of a solid's size up to which edges are merged first: a twentieth of a pixel of a wide screen."""
MERGED_ROUGHNESS_RATIO = 3.0
"""Multiple of a scan's roughness up to which edges are merged first: finer steps merge almost no edges."""
PIECES_TRIANGLES = 50_000
"""The same for all removed metal; the two limits keep the page below 5 MB."""


@dataclass(frozen=True, eq=False)
class Shown:
    """The view of a run, in file coordinates [mm].

    ``body`` is the corrected crank, ``pieces`` the metal of the corrections, ``note`` the words for a view
    with fewer triangles than the crank has.
    """

    body: Mesh
    pieces: Sequence[Piece]
    note: str | None

    @classmethod
    def of(
        cls,
        report: Mapping[str, Any],
        before: Solid,
        after: Solid | None,
        tools: Sequence[Solid],
        most: int = VIEW_TRIANGLES,
    ) -> Shown:
        """Return the view of a crank before and after (None: nothing was cut), and of the tool bodies.

        A crank of more than ``most`` triangles is decimated before it is cut for the view: cutting it once
        more as it is would take longer than balancing it.
        """
        first = max(
            FINEST_VIEW * before.mesh.diagonal_mm,
            MERGED_ROUGHNESS_RATIO * report["crank"].get("roughness_mm", 0.0),
        )
        crank = coarse_solid(before, most, first)
        pieces = pieces_of(report, crank, tools)
        left = before if after is None else after
        cut = after if after is not None and crank is before else _cut(report, crank, tools)
        body = coarse_solid(cut, most, first)
        note = None
        if body.triangle_count < left.triangle_count:
            note = (
                f"The view shows {body.triangle_count:,} of {left.triangle_count:,} triangles; "
                "every number is of all of them."
            ).replace(",", "\u202f")
        return cls(body.mesh, coarse_pieces(report, pieces, before.mesh.diagonal_mm), note)


def coarse_solid(solid: Solid, most: int, step: float) -> Solid:
    """Return a solid of at most ``most`` triangles; if it has more, decimated by ``step`` [mm] or more."""
    coarse = solid
    while coarse.triangle_count > most and step < solid.mesh.diagonal_mm:
        coarse = coarse.simplified(step)
        step *= 2.0
    return coarse


def coarse_pieces(
    report: Mapping[str, Any], pieces: Sequence[Piece], size_mm: float, most: int = PIECES_TRIANGLES
) -> Sequence[Piece]:
    """Return the removed metal for the page's view, simplified while it has more than ``most`` triangles."""
    step, coarse = 1e-5 * size_mm, pieces
    while sum(len(piece.mesh.triangles) for piece in coarse) > most and step < 1e-3 * size_mm:
        coarse = [
            piece.simplified(step, kinds.adds_metal(report["corrections"][piece.correction]))
            for piece in pieces
        ]
        step *= 4.0
    return coarse


def _cut(report: Mapping[str, Any], crank: Solid, tools: Sequence[Solid]) -> Solid:
    """Return a crank after all corrections, metal added first and then removed."""
    for adds in (True, False):
        chosen = [
            tool
            for tool, item in zip(tools, report["corrections"], strict=True)
            if kinds.adds_metal(item) == adds
        ]
        if chosen:
            crank = crank + union(chosen) if adds else crank - union(chosen)
    return crank
