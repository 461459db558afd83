"""Page, pictures, tools and reading template of a run: they load nothing before they are made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.report.output_kinds import OutputKind
from autobalance.solid.cad.installed import has_kernel

if TYPE_CHECKING:
    from autobalance.report.material import FileMaterial

TOOLS = "tools.step" if has_kernel() else "tools.3mf"
"""Named solids with true surfaces, where the CAD kernel is installed."""


def _page(material: FileMaterial) -> dict[str, bytes]:
    from autobalance.report.page.html import page

    picture = material.pictures[0]
    material.notify("writing the page")
    shown = material.shown
    return {
        "html": page(
            material.balanced,
            shown.body,
            shown.pieces,
            picture,
            shown.note,
            material.choice.units,
            material.surface,
        ).encode()
    }


def _pictures(material: FileMaterial) -> dict[str, bytes]:
    before, after = material.pictures
    return {"png_before": before, "png_after": after}


def _tools(material: FileMaterial) -> dict[str, bytes]:
    from autobalance.report.output_kinds import KINDS
    from autobalance.report.tool_bodies import tool_bodies

    made = any(each.depth_mm != 0.0 for each in material.balanced.corrections)
    exact = KINDS["tools"].files["tools"].endswith("step")
    return {"tools": tool_bodies(material, exact)} if made else {}


def _reading(material: FileMaterial) -> dict[str, bytes]:
    from autobalance.report.reading_template import reading_template

    return {"reading": reading_template(material.balanced).encode()}


PAGE = OutputKind("html", {"html": "report.html"}, _page)
PICTURES = OutputKind("png", {"png_before": "crank-before.png", "png_after": "crank-after.png"}, _pictures)
TOOL_BODIES = OutputKind("tools", {"tools": TOOLS}, _tools, is_usual=False)
READING = OutputKind("reading", {"reading": "reading.toml"}, _reading, is_to_fill=True)
