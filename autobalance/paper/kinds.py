"""Papers of a run, its drawing, its lists: they load nothing before they are made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.report.output_kinds import OutputKind
from autobalance.report.reportlab_alone import load_reportlab

if TYPE_CHECKING:
    from autobalance.report.material import FileMaterial


def _sheet(material: FileMaterial) -> dict[str, bytes]:
    load_reportlab()
    from autobalance.paper.sheet import pdf

    choice, report = material.choice, material.balanced
    return {
        "pdf": pdf(
            report, material.drawings, choice.paper, choice.units, choice.date, choice.zero, choice.done
        )
    }


def _certificate(material: FileMaterial) -> dict[str, bytes]:
    load_reportlab()
    from autobalance.paper.certificate import certificate

    choice, after = material.choice, material.pictures[1]
    material.notify("writing the certificate")
    return {
        "certificate": certificate(
            material.balanced, after, choice.paper, choice.units, choice.date, choice.zero
        )
    }


def _card(material: FileMaterial) -> dict[str, bytes]:
    load_reportlab()
    from autobalance.paper.bob_card import bob_card

    choice = material.choice
    return {"card": bob_card(material.balanced, choice.paper, choice.units, choice.date)}


def _hole_list(material: FileMaterial) -> dict[str, bytes]:
    from autobalance.paper.sheet import hole_list

    return {"csv": hole_list(material.balanced, material.choice.units)}


def _workbook(material: FileMaterial) -> dict[str, bytes]:
    from autobalance.paper.workbook import xlsx

    material.notify("writing the workbook")
    return {"xlsx": xlsx(material.balanced)}


def _require_ezdxf() -> None:
    from autobalance.paper.dxf import require_ezdxf

    require_ezdxf()


def _drawing(material: FileMaterial) -> dict[str, bytes]:
    from autobalance.paper.dxf import dxf

    return {"dxf": dxf(material.balanced, material.drawings, material.choice.units, material.choice.zero)}


SHEET = OutputKind("pdf", {"pdf": "sheet.pdf"}, _sheet, is_paper=True)
WORKBOOK = OutputKind("xlsx", {"xlsx": "balance.xlsx"}, _workbook, is_paper=True)
CERTIFICATE = OutputKind(
    "certificate", {"certificate": "certificate.pdf"}, _certificate, is_usual=False, is_paper=True
)
CARD = OutputKind("card", {"card": "bob-weights.pdf"}, _card, is_usual=False, is_paper=True)
HOLE_LIST = OutputKind("csv", {"csv": "holes.csv"}, _hole_list, is_usual=False, is_paper=True)
DRAWING = OutputKind(
    "dxf", {"dxf": "drawing.dxf"}, _drawing, is_usual=False, require=_require_ezdxf, is_paper=True
)
