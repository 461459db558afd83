"""``sheet.pdf``: what the machinist needs at the machine, drawn in true scale."""

from __future__ import annotations

import functools
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any, Literal

import numpy as np

from autobalance.graphics.words import (
    GRAMS_PER_OUNCE,
    MM_PER_INCH,
    OUTCOMES,
    at,
    degrees,
    file_name,
    number,
    weights,
)
from autobalance.report import kinds
from autobalance.report.drawing import Drawings, WebDrawing
from autobalance.solid.csg.solid import Polygons

Report = Mapping[str, Any]
Paper = Literal["A4", "Letter"]
UnitSystem = Literal["metric", "inch"]

POINTS_PER_MM = 72.0 / 25.4
PAPERS_MM = {"A4": (210.0, 297.0), "Letter": (215.9, 279.4)}
MARGIN_MM = 15.0
POINT_SPACING_MM = 0.3
"""Along an arc of 5 mm radius a chord this long is 0.002 mm off."""
CORNER_RAD = math.radians(4.0)
SCALES = ((1.0, "1:1"), (0.5, "1:2"), (0.2, "1:5"), (0.1, "1:10"), (0.05, "1:20"))
INK, SOFT, RULE, ACCENT, METAL, GONE = "#17191c", "#5d636b", "#c9c9c4", "#1c5d8f", "#e4e6e8", "#b5400f"


@dataclass(frozen=True)
class Units:
    """How the sheet writes lengths, masses and unbalance."""

    length: str
    mass: str
    unbalance: str
    per_mm: float
    per_g: float
    length_digits: int
    mass_digits: int
    unbalance_digits: int

    @property
    def diameter_digits(self) -> int:
        """Of a drill: tenths of a millimetre, or thousandths of an inch as drills are sold."""
        return 1 if self.length == "mm" else 3

    def mm(self, value: float | None, digits: int | None = None) -> str:
        """Return a length."""
        return _plain(
            None if value is None else value * self.per_mm, self.length_digits if digits is None else digits
        )

    def g(self, value: float | None) -> str:
        """Return a mass."""
        return _plain(None if value is None else value * self.per_g, self.mass_digits)

    def g_mm(self, value: float | None) -> str:
        """Return an unbalance."""
        return _plain(None if value is None else value * self.per_g * self.per_mm, self.unbalance_digits)


UNITS: dict[str, Units] = {
    "metric": Units("mm", "g", "g·mm", 1.0, 1.0, 3, 2, 2),
    "inch": Units("in", "oz", "oz·in", 1.0 / MM_PER_INCH, 1.0 / GRAMS_PER_OUNCE, 4, 4, 5),
}


def _plain(value: float | None, digits: int) -> str:
    """Return a number in characters that the PDF's built-in fonts have."""
    return number(value, digits).replace("\u202f", " ").replace("−", "-")


FALLBACK = "DejaVuSans"
"""Font in the package for Latin, Greek and Cyrillic names; the PDF holds the letters used of it."""


def _builtin(text: str) -> bool:
    """Tell whether the PDF's built-in fonts have each character."""
    try:
        text.encode("cp1252")
    except UnicodeEncodeError:
        return False
    return True


@functools.cache
def _letters() -> frozenset[str]:
    """Make the font in the package known to reportlab; return the characters that it has."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    with resources.as_file(resources.files("autobalance.report") / "assets" / "DejaVuSans.ttf") as path:
        font = TTFont(FALLBACK, str(path))
    pdfmetrics.registerFont(font)
    return frozenset(map(chr, font.face.charToGlyph))


def _safe(text: object) -> str:
    """Return a name in characters that the sheet's fonts have; others become question marks."""
    name = "".join(letter if letter.isprintable() else "?" for letter in str(text))
    if _builtin(name):
        return name
    return "".join(letter if letter in _letters() else "?" for letter in name)


def _font(text: str, bold: bool = False, mono: bool = False) -> str:
    """Return the font for a text of ``_safe`` characters."""
    if not _builtin(text):
        return FALLBACK
    return "Courier" if mono else "Helvetica-Bold" if bold else "Helvetica"


def pdf(
    report: Report,
    drawings: Drawings | None,
    paper: Paper = "A4",
    units: UnitSystem = "metric",
    date: str = "",
) -> bytes:
    """Return the shop sheet.

    Parameters
    ----------
    report : mapping
        The report as written to JSON.
    drawings : Drawings or None
        Outlines; None leaves the drawings out.
    paper, units
    date : str
        Printed on each page.

    Returns
    -------
    bytes
        A PDF; the same input gives the same bytes.
    """
    sheet = _Sheet(report, paper, UNITS[units], date)
    _summary_page(sheet, drawings)
    for web in drawings.webs if drawings else ():
        _web_page(sheet, web)
    if any(item.get("inward") and item.get("direction") == "radial" for item in report["corrections"]):
        _rim_page(sheet)
    return sheet.finished()


def _thinned(places: Any) -> Any:
    """Leave out points of a closed outline (k, 2) that a printer cannot show [mm]; corners stay."""
    side = np.roll(places, -1, axis=0) - places
    before = np.roll(side, 1, axis=0)
    turn = np.arctan2(before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0], np.sum(before * side, axis=1))
    walked = np.cumsum(np.hypot(*before.T)) // POINT_SPACING_MM
    kept = (np.abs(turn) > CORNER_RAD) | (walked != np.roll(walked, 1))
    return places[kept] if kept.sum() >= 3 else places


class _Sheet:
    """A PDF page by page, in mm from the upper left corner."""

    def __init__(self, report: Report, paper: Paper, units: Units, date: str) -> None:
        from reportlab.pdfgen.canvas import Canvas

        self.report, self.units, self.date = report, units, date
        self.width, self.height = PAPERS_MM[paper]
        self.buffer = io.BytesIO()
        size = (self.width * POINTS_PER_MM, self.height * POINTS_PER_MM)
        self.canvas = Canvas(self.buffer, pagesize=size, invariant=1, pageCompression=1)
        self.canvas.setTitle(_safe(f"Shop sheet {file_name(report)}"))
        self.canvas.setAuthor(f"autobalance {report['autobalance']['version']}")
        self.page = 0

    @property
    def inner(self) -> float:
        """Width between the margins [mm]."""
        return self.width - 2.0 * MARGIN_MM

    def finished(self) -> bytes:
        self.canvas.showPage()
        self.canvas.save()
        return self.buffer.getvalue()

    def start(self, title: str) -> float:
        """Begin a page with its heading; return where its content may begin."""
        if self.page:
            self.canvas.showPage()
        self.page += 1
        source = self.report["input"]
        self.text(MARGIN_MM, 18.0, title, 15, bold=True)
        self.text(self.width - MARGIN_MM, 15.0, _safe(file_name(self.report)), 9, bold=True, align="right")
        self.text(self.width - MARGIN_MM, 19.0, self.date, 8, SOFT, align="right")
        self.line(MARGIN_MM, 22.0, self.width - MARGIN_MM, 22.0, INK, 0.35)
        foot = self.height - 9.0
        self.text(MARGIN_MM, foot, f"sha256 {source['sha256']}", 6, SOFT, mono=True)
        self.text(
            self.width - MARGIN_MM,
            foot,
            f"autobalance {self.report['autobalance']['version']} · page {self.page}",
            7,
            SOFT,
            align="right",
        )
        return 30.0

    def y(self, down: float) -> float:
        return (self.height - down) * POINTS_PER_MM

    def text(
        self, x: float, down: float, text: str, size: float = 9.0, colour: str = INK, *,
        bold: bool = False, mono: bool = False, align: str = "left",
    ) -> None:  # fmt: skip
        self.canvas.setFont(_font(text, bold, mono), size)
        self.canvas.setFillColor(colour)
        draw = {"left": "drawString", "right": "drawRightString", "centre": "drawCentredString"}[align]
        getattr(self.canvas, draw)(x * POINTS_PER_MM, self.y(down), text)

    def line(
        self,
        x0: float,
        y0: float,
        x1: float,
        y1: float,
        colour: str = RULE,
        width_mm: float = 0.15,
        dash: Sequence[float] = (),
    ) -> None:
        self.canvas.setStrokeColor(colour)
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setDash(*([[d * POINTS_PER_MM for d in dash], 0] if dash else [[], 0]))
        self.canvas.line(x0 * POINTS_PER_MM, self.y(y0), x1 * POINTS_PER_MM, self.y(y1))

    def circle(
        self,
        x: float,
        down: float,
        radius: float,
        colour: str = INK,
        width_mm: float = 0.2,
        fill: str | None = None,
    ) -> None:
        self.canvas.setStrokeColor(colour)
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setDash([], 0)
        if fill:
            self.canvas.setFillColor(fill)
        self.canvas.circle(
            x * POINTS_PER_MM, self.y(down), radius * POINTS_PER_MM, stroke=1, fill=1 if fill else 0
        )

    def badge(self, x: float, down: float, label: object) -> None:
        """Draw a number in a dark disc."""
        self.circle(x, down, 2.4, INK, 0.2, INK)
        self.text(x, down + 1.05, str(label), 8, "#ffffff", bold=True, align="centre")

    def shape(
        self, polygons: Polygons, to_page: Any, fill: str | None, stroke: str, width_mm: float = 0.25
    ) -> Any:
        """Fill and stroke outlines with holes; ``to_page`` takes (k, 2) to (x, down)."""
        path = self.canvas.beginPath()
        for polygon in polygons:
            places = _thinned(to_page(np.asarray(polygon)))
            path.moveTo(places[0, 0] * POINTS_PER_MM, self.y(places[0, 1]))
            for x, down in places[1:]:
                path.lineTo(x * POINTS_PER_MM, self.y(down))
            path.close()
        self.canvas.setStrokeColor(stroke)
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setDash([], 0)
        if fill:
            self.canvas.setFillColor(fill)
        self.canvas.drawPath(path, stroke=1, fill=1 if fill else 0, fillMode=0)
        return path

    def hatch(self, polygons: Polygons, to_page: Any, colour: str = GONE) -> None:
        """Draw metal that goes: an outline and lines at 45 degrees, 2 mm apart."""
        if not polygons:
            return
        places = np.concatenate([to_page(np.asarray(polygon)) for polygon in polygons])
        (left, top), (right, bottom) = places.min(axis=0), places.max(axis=0)
        self.canvas.saveState()
        path = self.canvas.beginPath()
        for polygon in polygons:
            corners = to_page(np.asarray(polygon))
            path.moveTo(corners[0, 0] * POINTS_PER_MM, self.y(corners[0, 1]))
            for x, down in corners[1:]:
                path.lineTo(x * POINTS_PER_MM, self.y(down))
            path.close()
        self.canvas.clipPath(path, stroke=0, fill=0, fillMode=0)
        for start in np.arange(left - (bottom - top), right, 2.0):
            self.line(start, bottom, start + (bottom - top), top, colour, 0.15)
        self.canvas.restoreState()
        self.shape(polygons, to_page, None, colour, 0.3)

    def table(
        self,
        x: float,
        down: float,
        widths: Sequence[float],
        rows: Sequence[Sequence[str]],
        left: int = 1,
        row_mm: float = 5.6,
    ) -> float:
        """Draw rows under a heading row, ``left`` columns aligned left; return where it ends."""
        for k, row in enumerate(rows):
            base, here = down + k * row_mm, x
            for column, (width, cell) in enumerate(zip(widths, row, strict=True)):
                colour, size = (SOFT, 7.5) if k == 0 else (INK, 9.0)
                if column < left:
                    self.text(here, base, cell, size, colour)
                else:
                    self.text(here + width, base, cell, size, colour, align="right")
                here += width
            self.line(
                x, base + 1.7, x + sum(widths), base + 1.7, INK if k == 0 else RULE, 0.2 if k == 0 else 0.12
            )
        return down + len(rows) * row_mm


# --- first page --------------------------------------------------------------------------------------------


def _summary_page(sheet: _Sheet, drawings: Drawings | None) -> None:
    report, u = sheet.report, sheet.units
    down = sheet.start("Shop sheet: balance the crankshaft")
    sheet.text(MARGIN_MM, down, OUTCOMES[report["outcome"]], 12, INK, bold=True)
    tolerance = report["tolerance"]
    graded = f"G {tolerance['grade_mm_s']:g} at {_plain(tolerance['speed_rpm'], 0)} rpm, rotor {u.g(tolerance['rotor_mass_g'])} {u.mass}"
    sheet.text(
        MARGIN_MM,
        down + 5.0,
        f"{graded}. Lengths in {u.length}, masses in {u.mass}, unbalance in {u.unbalance}.",
        8.5,
        SOFT,
    )
    down = _reason_lines(sheet, down + 10.0)
    down = _cut_table(sheet, down + 4.0)
    if drawings and drawings.lengthwise:
        down = _lengthwise(sheet, drawings, down + 6.0)
    half = sheet.inner / 2.0 - 4.0
    left = _tolerance_card(sheet, MARGIN_MM, half, down + 8.0)
    right = _bob_card(sheet, MARGIN_MM + half + 8.0, half, down + 8.0)
    _readings(sheet, max(left, right) + 7.0)


def _reason_lines(sheet: _Sheet, down: float) -> float:
    if not sheet.report.get("reason"):
        return down
    from reportlab.lib.utils import simpleSplit

    reason = _safe(sheet.report["reason"])
    for text in simpleSplit(reason, _font(reason), 9, sheet.inner * POINTS_PER_MM):
        sheet.text(MARGIN_MM, down, text, 9, "#a8231b")
        down += 4.4
    return down + 1.0


def _cut_table(sheet: _Sheet, down: float) -> float:
    """List every correction with its angles in both senses and its depths with and without the point."""
    u, items = sheet.units, sheet.report["corrections"]
    if not items:
        sheet.text(MARGIN_MM, down, "Nothing to cut.", 10)
        return down + 4.0
    rows = [
        [
            "No",
            "Cut",
            "Where",
            "angle ccw",
            "angle cw",
            "z",
            "radius",
            "diameter",
            "depth",
            "with point",
            "mass",
        ]
    ]
    rows += [cut_row(item, u) for item in items]
    widths = [8.0, 23.0, 22.0, 16.0, 16.0, 16.0, 16.0, 15.0, 16.0, 16.0, 16.0]
    down = sheet.table(MARGIN_MM, down, widths, rows, left=3)
    note = "Angles from crankpin 1: ccw counter-clockwise seen from the +z end, cw the other way round (degree wheel from the same end). z from the middle of crankpin 1."
    sheet.text(MARGIN_MM, down + 0.5, note, 7, SOFT)
    for text in kinds.datums(items):
        down += 2.8
        sheet.text(MARGIN_MM, down + 0.5, text, 7, SOFT)
    return down + 3.0


def cut_row(item: Mapping[str, Any], u: Units) -> list[str]:
    """Return what the table tells of a correction: number, kind, place, angles, z, radius, sizes, mass."""
    ccw = kinds.angle_deg(item)
    x, y, z = item["position_mm"]
    return [
        str(item["number"]),
        kinds.noun(item),
        _safe(_where(item)),
        "–" if ccw is None else degrees(ccw),
        "–" if ccw is None else degrees(-ccw),
        u.mm(z, u.length_digits - 1),
        u.mm(math.hypot(x, y), u.length_digits - 1),
        u.mm(item.get("diameter_mm"), u.diameter_digits),
        u.mm(item["depth_mm"]),
        u.mm(_with_point(item)) if item.get("point_mm") else "–",
        u.g(item["removed_mass_g"]),
    ]


def _where(item: Mapping[str, Any]) -> str:
    webs = item.get("webs") or [item.get("web")]
    return " ".join([f"web {', '.join(map(str, webs))}"] + ([str(item["face"])] if item.get("face") else []))


def _with_point(item: Mapping[str, Any]) -> float:
    return float(item["depth_mm"]) + float(item.get("point_mm") or 0.0)


def _tolerance_card(sheet: _Sheet, x: float, width: float, down: float) -> float:
    report, u = sheet.report, sheet.units
    sheet.text(x, down, f"Unbalance, {u.unbalance}", 10, bold=True)
    rows = [["", "before", "after", "permitted"]]
    tolerance = report["tolerance"]
    pairs = [("Resultant", report["initial"], report["residual"], tolerance)]
    for a, b, plane in zip(
        report["initial"]["planes"], report["residual"]["planes"], tolerance["planes"], strict=True
    ):
        pairs.append((f"Plane {plane['name']}, z = {u.mm(plane['z_mm'], u.length_digits - 2)}", a, b, plane))
    rows += [
        [
            _safe(name),
            u.g_mm(a["magnitude_g_mm"]),
            u.g_mm(b["magnitude_g_mm"]),
            u.g_mm(limit["permissible_g_mm"]),
        ]
        for name, a, b, limit in pairs
    ]
    return sheet.table(x, down + 6.0, [width - 54.0, 18.0, 18.0, 18.0], rows)


def _bob_card(sheet: _Sheet, x: float, width: float, down: float) -> float:
    """List the bob-weights to mount: all, and where the real crankpin is fitted, without the pin's own parts."""
    report, u = sheet.report, sheet.units
    sheet.text(x, down, f"Bob-weight on the crankpin, {u.mass}", 10, bold=True)
    rows = [["", "pin not fitted", "pin fitted"]]
    pin = sum(weights(report, "crankpin_g").values())
    in_file = at(report, "job.crankshaft.crankpin_in_file")
    for bob in at(report, "engine.bob_weights") or []:
        without = "–" if in_file in (None, True) and pin == 0.0 else u.g(bob["mass_g"])
        rows.append(
            [f"Throw {bob['throw']}", without, u.g(bob["mass_g"] - (pin if in_file is False else 0.0))]
        )
    return sheet.table(x, down + 6.0, [width - 56.0, 28.0, 28.0], rows)


def _readings(sheet: _Sheet, down: float) -> None:
    u = sheet.units
    if down > sheet.height - 55.0:
        down = sheet.start("Readings after machining")
    sheet.text(MARGIN_MM, down, "Readings after machining", 10, bold=True)
    rows = [
        [
            "Run",
            f"plane A ({u.unbalance})",
            "angle",
            f"plane B ({u.unbalance})",
            "angle",
            "bob-weight",
            "speed",
            "by",
            "date",
        ]
    ]
    rows += [[str(k), "", "", "", "", "", "", "", ""] for k in (1, 2, 3)]
    sheet.table(
        MARGIN_MM,
        down + 6.0,
        [10.0, 30.0, 16.0, 30.0, 16.0, 22.0, 18.0, 18.0, 20.0],
        rows,
        left=9,
        row_mm=7.6,
    )


def _lengthwise(sheet: _Sheet, drawings: Drawings, down: float) -> float:
    """Draw the section through the axis and crankpin 1, what goes hatched, depths dimensioned."""
    points = np.concatenate(drawings.lengthwise)
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    scale, name = _scale(size[0], size[1], sheet.inner, sheet.height * 0.38)
    left = MARGIN_MM + 0.5 * (sheet.inner - scale * size[0])
    top = down + 5.0

    def to_page(places: Any) -> Any:
        return np.stack(
            [left + scale * (places[:, 0] - low[0]), top + scale * (high[1] - places[:, 1])], axis=1
        )

    sheet.text(MARGIN_MM, down, f"Section through the axis and crankpin 1, {name}", 8, SOFT)
    sheet.shape(drawings.lengthwise, to_page, METAL, INK, 0.2)
    for key, polygons in drawings.lengthwise_cuts.items():
        sheet.hatch(polygons, to_page)
        middle = to_page(np.concatenate(polygons)).mean(axis=0)
        sheet.badge(middle[0], middle[1] + 0.5 * scale * np.ptp(np.concatenate(polygons)[:, 1]) + 3.4, key)
    axis = to_page(np.array([[low[0], 0.0], [high[0], 0.0]]))
    sheet.line(axis[0, 0] - 4, axis[0, 1], axis[1, 0] + 4, axis[1, 1], ACCENT, 0.18, (5, 1.2, 1, 1.2))
    sheet.text(axis[1, 0] + 5.0, axis[1, 1] + 1.0, "+z", 8, ACCENT)
    return top + scale * float(size[1]) + (8.0 if drawings.lengthwise_cuts else 0.0)


def _scale(width: float, height: float, room_x: float, room_y: float) -> tuple[float, str]:
    """Return the greatest usual scale at which a drawing fits, and its name."""
    for scale, name in SCALES:
        if scale * width <= room_x and scale * height <= room_y:
            return scale, name
    return SCALES[-1]


# --- a web ---------------------------------------------------------------------------------------------------


def _web_page(sheet: _Sheet, web: WebDrawing) -> None:
    """Draw a web in true scale within a degree wheel, with its corrections, and their numbers below."""
    u = sheet.units
    down = sheet.start(f"Web {web.number}, seen from the +z end")
    points = np.concatenate([*web.outline, *[p for polygons in web.cuts.values() for p in polygons]])
    reach = float(np.hypot(*points.T).max())
    room = min(sheet.inner, sheet.height - 110.0) / 2.0 - 16.0
    scale, name = _scale(reach, reach, room, room)
    cx, cy = sheet.width / 2.0, down + 17.0 + scale * reach

    def to_page(places: Any) -> Any:
        return np.stack([cx - scale * places[:, 1], cy - scale * places[:, 0]], axis=1)

    sheet.text(MARGIN_MM, down, f"Scale {name}. Crankpin 1 up. What goes is hatched.", 8.5, SOFT)
    _wheel(sheet, cx, cy, scale * reach + 5.0)
    sheet.shape(web.outline, to_page, METAL, INK, 0.25)
    items = [
        item for item in sheet.report["corrections"] if web.number in (item.get("webs") or [item.get("web")])
    ]
    for item in items:
        sheet.hatch(web.cuts.get(item["number"], []), to_page)
    for item in items:
        _mark(sheet, item, web, to_page, scale)
    sheet.line(cx - 4, cy, cx + 4, cy, ACCENT, 0.2)
    sheet.line(cx, cy - 4, cx, cy + 4, ACCENT, 0.2)
    bottom = cy + scale * reach + 22.0
    _scale_bar(sheet, scale, bottom)
    rows = [["No", "What to do", f"depth {u.length}", "with point", f"mass {u.mass}"]]
    rows += [
        [
            str(i["number"]),
            _safe(kinds.instruction(i, u)),
            u.mm(i["depth_mm"]),
            u.mm(_with_point(i)) if i.get("point_mm") else "–",
            u.g(i["removed_mass_g"]),
        ]
        for i in items
    ]
    sheet.table(MARGIN_MM, bottom + 9.0, [10.0, sheet.inner - 70.0, 20.0, 20.0, 20.0], rows, left=2)


def _wheel(sheet: _Sheet, cx: float, cy: float, radius: float) -> None:
    """Draw a degree wheel: outside counter-clockwise, inside clockwise, both from crankpin 1."""
    sheet.circle(cx, cy, radius, RULE, 0.15)
    for mark_deg in range(0, 360, 5):
        turn = math.radians(mark_deg)
        s, c = -math.sin(turn), -math.cos(turn)
        long = 2.4 if mark_deg % 30 == 0 else 1.6 if mark_deg % 10 == 0 else 0.9
        sheet.line(
            cx + radius * s, cy + radius * c, cx + (radius + long) * s, cy + (radius + long) * c, SOFT, 0.15
        )
        if mark_deg % 30 == 0:
            sheet.text(
                cx + (radius + 6.4) * s, cy + (radius + 5.6) * c + 1.0, f"{mark_deg}", 8, INK, align="centre"
            )
            sheet.text(
                cx + (radius + 6.4) * s,
                cy + (radius + 5.6) * c + 3.8,
                f"({(360 - mark_deg) % 360})",
                6.5,
                SOFT,
                align="centre",
            )


def _mark(sheet: _Sheet, item: Mapping[str, Any], web: WebDrawing, to_page: Any, scale: float) -> None:
    """Put the number of a correction on the drawing and dimension it."""
    u = sheet.units
    polygons = web.cuts.get(item["number"], [])
    at_mm = np.asarray(item["position_mm"][:2], dtype=np.float64)
    if item.get("diameter_mm") and item.get("direction") == "axial":
        (x, down) = to_page(at_mm[None])[0]
        sheet.circle(x, down, scale * item["diameter_mm"] / 2.0, INK, 0.3)
        sheet.line(x - 2, down, x + 2, down, INK, 0.12)
        sheet.line(x, down - 2, x, down + 2, INK, 0.12)
        text = f"dia {u.mm(item['diameter_mm'], u.diameter_digits)} x {u.mm(item['depth_mm'])}"
    elif item.get("inward"):
        inward = np.asarray(item["inward"][:2])
        (x0, y0), (x1, y1) = to_page(
            np.stack([at_mm - 4.0 * inward / scale, at_mm + _with_point(item) * inward])
        )
        sheet.line(x0, y0, x1, y1, ACCENT, 0.18, (3, 0.8, 0.8, 0.8))
        (x, down) = to_page((at_mm + 0.45 * _with_point(item) * inward)[None])[0]
        text = degrees(item["angle_deg"])
    else:
        centre = np.concatenate(polygons).mean(axis=0) if polygons else at_mm
        (x, down) = to_page(centre[None])[0]
        text = f"{u.mm(item['depth_mm'])} deep"
    sheet.badge(x, down, item["number"])
    wide = 1.7 * len(text) + 2.0
    sheet.canvas.setFillColor("#ffffff")
    sheet.canvas.rect(
        (x + 3.2) * POINTS_PER_MM,
        sheet.y(down + 2.0),
        wide * POINTS_PER_MM,
        4.0 * POINTS_PER_MM,
        stroke=0,
        fill=1,
    )
    sheet.text(x + 4.0, down + 1.1, text, 8, INK)


def _scale_bar(sheet: _Sheet, scale: float, down: float) -> None:
    """Draw a bar to check with a rule that the printer did not scale the page."""
    length = 50.0 if sheet.units.length == "mm" else 2.0 * MM_PER_INCH
    x = MARGIN_MM
    sheet.line(x, down, x + length, down, INK, 0.3)
    for place in (x, x + length):
        sheet.line(place, down - 1.4, place, down + 1.4, INK, 0.3)
    label = "50 mm" if sheet.units.length == "mm" else "2 in"
    sheet.text(
        x + length + 3.0, down + 1.0, f"{label} on paper: check with a rule (print at 100 %)", 7.5, SOFT
    )


# --- rim -----------------------------------------------------------------------------------------------------


def _rim_page(sheet: _Sheet) -> None:
    """Draw the rim unrolled: along the circumference by angle, across by z; wrap it round the crank and mark through."""
    u = sheet.units
    down = sheet.start("Rim, unrolled: wrap round the crank, outside up")
    items = [i for i in sheet.report["corrections"] if i.get("inward") and i.get("direction") == "radial"]
    webs = [w for w in sheet.report["crank"]["webs"] if w["number"] in {i["web"] for i in items}]
    radius = max(math.hypot(*i["position_mm"][:2]) for i in items)
    angles = [i["angle_deg"] % 360.0 for i in items]
    first, last = min(angles) - 20.0, max(angles) + 20.0
    z0, z1 = min(w["z_min_mm"] for w in webs), max(w["z_max_mm"] for w in webs)
    long = math.radians(last - first) * radius
    scale, name = _scale(long, z1 - z0, sheet.inner, sheet.height - 90.0)
    sheet.text(
        MARGIN_MM,
        down,
        f"Scale {name} at radius {u.mm(radius)}. Angle counter-clockwise seen from +z, in brackets clockwise.",
        8.5,
        SOFT,
    )
    left, top = MARGIN_MM + 0.5 * (sheet.inner - scale * long), down + 16.0

    def place(angle: float, z: float) -> tuple[float, float]:
        return left + scale * math.radians(last - angle) * radius, top + scale * (z1 - z)

    for web in webs:
        (xa, ya), (xb, yb) = place(last, web["z_max_mm"]), place(first, web["z_min_mm"])
        corners = np.array([[xa, ya], [xb, ya], [xb, yb], [xa, yb]])
        sheet.shape([corners], lambda p: p, METAL, INK, 0.2)
        sheet.text(xb - 1.5, yb - 1.5, f"web {web['number']}", 7.5, SOFT, align="right")
    for mark_deg in range(math.ceil(first / 10.0) * 10, math.floor(last / 10.0) * 10 + 1, 10):
        x, _ = place(mark_deg, z1)
        sheet.line(x, top - 2.0, x, top + scale * (z1 - z0) + 2.0, RULE, 0.12)
        sheet.text(x, top - 6.2, f"{mark_deg % 360}°", 7.5, INK, align="centre")
        sheet.text(x, top - 3.2, f"({(360 - mark_deg) % 360}°)", 6, SOFT, align="centre")
    for item in items:
        x, y = place(item["angle_deg"] % 360.0, item["position_mm"][2])
        r = scale * item["diameter_mm"] / 2.0
        sheet.circle(x, y, r, GONE, 0.3, "#ffffff")
        sheet.line(x - r - 1.5, y, x + r + 1.5, y, INK, 0.12)
        sheet.line(x, y - r - 1.5, x, y + r + 1.5, INK, 0.12)
        sheet.badge(x + r + 3.0, y - r, item["number"])
    _scale_bar(sheet, scale, top + scale * (z1 - z0) + 12.0)
