"""Kinds of files for people, each entered by one line; the table itself loads nothing."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from autobalance.report.output_kind import OutputKind
from autobalance.solid.cad.installed import has_kernel

if TYPE_CHECKING:
    from autobalance.report.material import Material

TOOLS = "tools.step" if has_kernel() else "tools.3mf"
"""Named solids with true surfaces, where the CAD kernel is installed."""
_KINDS: dict[str, OutputKind] = {}
KINDS: Mapping[str, OutputKind] = MappingProxyType(_KINDS)
"""By name, in the order in which they are made."""


def register(kind: OutputKind) -> None:
    """Enter a kind of file.

    Raises
    ------
    ValueError
        If its name, or the name or key of one of its files, is taken.
    """
    names = {*page_names(), *(key for each in _KINDS.values() for key in each.files)}
    for name in (*kind.files, *kind.files.values()):
        if name in names:
            raise ValueError(f"an output of the name {name!r} is there already")
    if kind.name in _KINDS:
        raise ValueError(f"the output kind {kind.name!r} is there already")
    _KINDS[kind.name] = kind


def usual() -> tuple[str, ...]:
    """Return the names of the kinds that are written where nothing is chosen."""
    return tuple(name for name, kind in _KINDS.items() if kind.is_usual)


def to_fill() -> frozenset[str]:
    """Return the keys of files that people write into afterwards."""
    return frozenset(key for kind in _KINDS.values() if kind.is_to_fill for key in kind.files)


def names_to_fill() -> frozenset[str]:
    """Return the names of files that people write into afterwards, and that stay as they are then."""
    return frozenset(name for kind in _KINDS.values() if kind.is_to_fill for name in kind.files.values())


def choices() -> tuple[str, ...]:
    """Return the names that can be chosen: ``json``, which is always written, and the kinds."""
    return ("json", *_KINDS)


def page_names() -> tuple[str, ...]:
    """Return the names of all files that the kinds may write."""
    return tuple(name for kind in _KINDS.values() for name in kind.files.values())


def _page(material: Material) -> dict[str, bytes]:
    from autobalance.report.page.html import page

    picture = material.pictures[0]
    material.notify("writing the page")
    shown = material.shown
    return {
        "html": page(
            material.report,
            shown.body,
            shown.pieces,
            picture,
            shown.note,
            material.choice.units,
            material.surface,
        ).encode()
    }


def _sheet(material: Material) -> dict[str, bytes]:
    from autobalance.report.sheet.sheet import pdf

    choice, report = material.choice, material.report
    return {"pdf": pdf(report, material.drawings, choice.paper, choice.units, choice.date, choice.zero)}


def _certificate(material: Material) -> dict[str, bytes]:
    from autobalance.report.sheet.certificate import certificate

    choice, after = material.choice, material.pictures[1]
    material.notify("writing the certificate")
    return {
        "certificate": certificate(
            material.report, after, choice.paper, choice.units, choice.date, choice.zero
        )
    }


def _card(material: Material) -> dict[str, bytes]:
    from autobalance.report.sheet.bob_card import bob_card

    choice = material.choice
    return {"card": bob_card(material.report, choice.paper, choice.units, choice.date)}


def _hole_list(material: Material) -> dict[str, bytes]:
    from autobalance.report.sheet.hole_list import hole_list

    return {"csv": hole_list(material.report, material.choice.units)}


def _workbook(material: Material) -> dict[str, bytes]:
    from autobalance.report.balance.workbook import xlsx

    material.notify("writing the workbook")
    return {"xlsx": xlsx(material.report)}


def _pictures(material: Material) -> dict[str, bytes]:
    before, after = material.pictures
    return {"png_before": before, "png_after": after}


def _require_ezdxf() -> None:
    from autobalance.report.sheet.dxf import require_ezdxf

    require_ezdxf()


def _drawing(material: Material) -> dict[str, bytes]:
    from autobalance.report.sheet.dxf import dxf

    return {"dxf": dxf(material.report, material.drawings, material.choice.units)}


def _tools(material: Material) -> dict[str, bytes]:
    from autobalance.report.tool_bodies import tool_bodies

    made = any(each["depth_mm"] != 0.0 for each in material.report["corrections"])
    exact = KINDS["tools"].files["tools"].endswith("step")
    return {"tools": tool_bodies(material, exact)} if made else {}


def _reading(material: Material) -> dict[str, bytes]:
    from autobalance.report.shop.reading_template import reading_template

    return {"reading": reading_template(material.report).encode()}


register(OutputKind("html", {"html": "report.html"}, _page))
register(OutputKind("pdf", {"pdf": "sheet.pdf"}, _sheet))
register(OutputKind("xlsx", {"xlsx": "balance.xlsx"}, _workbook))
register(OutputKind("png", {"png_before": "crank-before.png", "png_after": "crank-after.png"}, _pictures))
register(OutputKind("certificate", {"certificate": "certificate.pdf"}, _certificate, is_usual=False))
register(OutputKind("card", {"card": "bob-weights.pdf"}, _card, is_usual=False))
register(OutputKind("csv", {"csv": "holes.csv"}, _hole_list, is_usual=False))
register(OutputKind("dxf", {"dxf": "drawing.dxf"}, _drawing, is_usual=False, require=_require_ezdxf))
register(OutputKind("tools", {"tools": TOOLS}, _tools, is_usual=False))
register(OutputKind("reading", {"reading": "reading.toml"}, _reading, is_to_fill=True))
