"""All files that a run can write for people, from one report and the solids before and after."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from autobalance.runtime import Notify
from autobalance.solid.csg.solid import Solid

if TYPE_CHECKING:
    from autobalance.report.sheet.drawing import Drawings

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
    told: Notify = lambda _: None,
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
    if wanted & {"html", "pdf", "png", "dxf"}:
        from autobalance.report.page.shown import Shown

        shown = Shown.of(report, before, after, tools)
    if wanted & {"png", "html"}:
        from autobalance.report.pictures.picture import pictures

        told("drawing pictures")
        images = pictures(report, before.mesh, shown.body, shown.pieces)
        if "png" in wanted:
            made["png_before"], made["png_after"] = images
    if "html" in wanted:
        from autobalance.report.page.html import page

        told("writing the page")
        made["html"] = page(report, shown.body, shown.pieces, images[0], shown.note).encode()
    if wanted & {"pdf", "dxf"}:
        from autobalance.report.sheet.drawing import drawings

        told("drawing the shop sheet")
        made |= paper(report, drawings(report, before, shown.pieces), choice)
    if "xlsx" in wanted:
        from autobalance.report.balance.workbook import xlsx

        told("writing the workbook")
        made["xlsx"] = xlsx(report)
    return {key: (name, made[key]) for key, name in FILES.items() if key in made}


def paper(report: Mapping[str, Any], drawn: Drawings, choice: Choice) -> dict[str, bytes]:
    """Return the sheet and the drawing, as far as they are chosen."""
    made: dict[str, bytes] = {}
    if "pdf" in choice.kinds:
        from autobalance.report.sheet.sheet import pdf

        made["pdf"] = pdf(report, drawn, choice.paper, choice.units, choice.date)
    if "dxf" in choice.kinds:
        from autobalance.report.sheet.dxf import dxf

        made["dxf"] = dxf(report, drawn)
    return made
