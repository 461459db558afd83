"""All files that a run can write for people, from one report and the solids before and after."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from autobalance.report import kinds
from autobalance.report.metal import Piece, pieces_of
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh

if TYPE_CHECKING:
    from autobalance.report.drawing import Drawings

KINDS = ("html", "pdf", "xlsx", "png", "dxf")
"""What can be chosen; ``report.json`` is always written."""
USUAL = ("html", "pdf", "xlsx", "png")
"""What is written where nothing is chosen; drawings for CAD need an extra."""
FILES = {
    "html": "report.html",
    "pdf": "sheet.pdf",
    "xlsx": "balance.xlsx",
    "dxf": "drawing.dxf",
    "png_before": "crank-before.png",
    "png_after": "crank-after.png",
}
VIEW_TRIANGLES = 100_000
"""The page's view of a finer solid is decimated."""
FINEST_VIEW = 4e-5
"""Share of a solid's size up to which edges are merged first: a twentieth of a pixel of a wide screen."""
PIECES_TRIANGLES = 50_000
"""The same of all removed metal; the two together keep the page below 5 MB."""


@dataclass(frozen=True)
class Choice:
    """Which files, on what paper, in which units, with which date on them."""

    kinds: Collection[str] = USUAL
    paper: Any = "A4"
    units: Any = "metric"
    date: str = ""


def bundle(
    report: Mapping[str, Any],
    before: Solid,
    after: Solid | None,
    tools: Sequence[Solid],
    choice: Choice,
    told: Callable[[str], None] = lambda _: None,
) -> dict[str, tuple[str, bytes]]:
    """Return the chosen files: key in ``outputs`` → name and bytes.

    Parameters
    ----------
    report : mapping
        As written to JSON.
    before, after : Solid
        File coordinates [mm]; ``after`` None where nothing was cut.
    tools : sequence of Solid
        The tool body of each correction, file coordinates.
    choice : Choice
    told : callable
        Told in a few words what runs.
    """
    wanted = set(choice.kinds)
    made: dict[str, bytes] = {}
    if not wanted:
        return {}
    fine = pieces_of(report, before, tools) if wanted & {"html", "pdf", "png", "dxf"} else []
    pieces = coarse_pieces(report, fine, before.mesh.diagonal_mm)
    if wanted & {"png", "html"}:
        from autobalance.report.picture import pictures

        told("drawing pictures")
        body, note = view_of(before if after is None else after)
        images = pictures(report, before.mesh, body, pieces)
        if "png" in wanted:
            made["png_before"], made["png_after"] = images
    if "html" in wanted:
        from autobalance.report.html import page

        told("writing the page")
        made["html"] = page(report, body, pieces, images[0], note).encode()
    if wanted & {"pdf", "dxf"}:
        from autobalance.report.drawing import drawings

        told("drawing the shop sheet")
        made |= paper(report, drawings(report, before, pieces), choice)
    if "xlsx" in wanted:
        from autobalance.report.workbook import xlsx

        told("writing the workbook")
        made["xlsx"] = xlsx(report)
    return {key: (name, made[key]) for key, name in FILES.items() if key in made}


def paper(report: Mapping[str, Any], drawn: Drawings, choice: Choice) -> dict[str, bytes]:
    """Return the sheet and the drawing, as far as they are chosen."""
    made: dict[str, bytes] = {}
    if "pdf" in choice.kinds:
        from autobalance.report.paper.sheet import pdf

        made["pdf"] = pdf(report, drawn, choice.paper, choice.units, choice.date)
    if "dxf" in choice.kinds:
        from autobalance.report.dxf import dxf

        made["dxf"] = dxf(report, drawn)
    return made


def coarse_pieces(
    report: Mapping[str, Any], pieces: Sequence[Piece], size_mm: float, most: int = PIECES_TRIANGLES
) -> Sequence[Piece]:
    """Return the removed metal for the page's view, simplified while it is too fine for a part of a size."""
    step, coarse = 1e-5 * size_mm, pieces
    while sum(len(piece.mesh.triangles) for piece in coarse) > most and step < 1e-3 * size_mm:
        coarse = [
            piece.simplified(step, kinds.adds_metal(report["corrections"][piece.correction]))
            for piece in pieces
        ]
        step *= 4.0
    return coarse


def view_of(solid: Solid, most: int = VIEW_TRIANGLES) -> tuple[Mesh, str | None]:
    """Return a mesh for the page's view, decimated if it is too fine, and what to say of that."""
    mesh = solid.mesh
    count = len(mesh.triangles)
    if count <= most:
        return mesh, None
    step = FINEST_VIEW * mesh.diagonal_mm
    coarse = solid
    while coarse.triangle_count > most and step < mesh.diagonal_mm:
        coarse = coarse.simplified(step)
        step *= 2.0
    shown = coarse.mesh
    note = f"The view shows {len(shown.triangles):,} of {count:,} triangles; every number is of all of them."
    return shown, note.replace(",", "\u202f")
