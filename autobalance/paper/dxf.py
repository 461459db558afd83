"""``drawing.dxf``: each web that is cut as a block in the rotor's x and y, and the section, for CAD."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.errors import FormatError
from autobalance.paper.drawing import MIN_AXIAL_COMPONENT, Drawings, WebDrawing
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import Zero, ZeroChoice, with_design_radii
from autobalance.report.display_units import ON_PAPER, DisplayUnits, UnitSystem
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.solid.csg.region import Polygons
from autobalance.wording import degrees

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.blocklayout import BlockLayout
    from ezdxf.layouts.layout import Modelspace

VERSION = "R2013"
MILLIMETRES = 4
LAYERS = {"OUTLINE": 7, "CUTS": 1, "CENTRE": 5, "DIMENSIONS": 3, "TEXT": 7, "FRAME": 8}
"""Layer → colour index."""
TEXT_MM = 2.5
LINE_STEP = 1.4
"""Distance of two lines of text, in heights of the text."""
GAP_MM = 30.0
FRAME_GAP_MM = 10.0
CENTRE_TYPE = "CENTER"


def require_ezdxf() -> None:
    """Raise FormatError if ezdxf, which writes drawings, is not installed.

    Raises
    ------
    FormatError
        If it is not installed.
    """
    try:
        import ezdxf  # noqa: F401
    except ImportError:
        raise FormatError(
            "a DXF drawing needs ezdxf, which is not installed: pip install 'autobalance[dxf]'"
        ) from None


def dxf(
    report: BalancedReport,
    drawings: Drawings,
    units: UnitSystem = "metric",
    zero: ZeroChoice = "keyway",
) -> bytes:
    """Return the drawing as a DXF file of release 2013; the same input gives the same bytes.

    Coordinates are millimetres, as in its header; with ``inch`` its dimensions are written in inches. Webs
    are in the rotor's x and y; the angle that is written at each cut counts from ``zero``, as on the sheet.

    Raises
    ------
    FormatError
        If ezdxf is not installed.
    """
    require_ezdxf()
    with _untimed():
        shown = with_design_radii(report)
        return _bytes(_document(shown, drawings, ON_PAPER[units], Zero.of(shown, zero)))


@contextmanager
def _untimed() -> Iterator[None]:
    """Keep the time of writing out of files."""
    from ezdxf._options import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _document(report: BalancedReport, drawings: Drawings, u: DisplayUnits, zero: Zero) -> Drawing:
    from ezdxf.filemanagement import new

    document = new(VERSION, setup=True)
    document.header["$INSUNITS"] = MILLIMETRES
    document.header["$MEASUREMENT"] = int(u.is_metric)
    document.header["$DIMLFAC"] = 1.0 / u.mm_per_length
    for name, colour in LAYERS.items():
        document.layers.add(name, color=colour, linetype=CENTRE_TYPE if name == "CENTRE" else "Continuous")
    space, left = document.modelspace(), 0.0
    for web in drawings.webs:
        items = [item for item in report.corrections if web.number in item.all_webs]
        name = f"WEB_{web.number}"
        _web(document.blocks.new(name), web, items, zero)
        shown = [*web.outline, *(each for cuts in web.cuts.values() for each in cuts)]
        title = (
            f"{report.file_name}: web {web.number} seen from +z, x to the right, angles ccw from {zero.name}"
        )
        left = _placed(space, name, shown, title, left, u)
    _section(document.blocks.new("SECTION"), drawings)
    shown = [*drawings.lengthwise, *(each for cuts in drawings.lengthwise_cuts.values() for each in cuts)]
    title = f"{report.file_name}: section y = 0, z to the right, x up"
    left = _placed(space, "SECTION", shown, title, left, u)
    radial = [item for item in report.corrections if _is_radial(item)]
    if radial:
        _rim(space, report, radial, left, u, zero)
    return document


def _is_radial(item: Cut) -> bool:
    return item.hole is not None and abs(item.hole.inward[2]) <= MIN_AXIAL_COMPONENT


def _rim(
    space: Modelspace,
    report: BalancedReport,
    items: Sequence[Cut],
    left: float,
    u: DisplayUnits,
    zero: Zero,
) -> None:
    """Draw radial holes on the rim rolled out, x = radius · angle, y = z, beside the other drawings."""
    radius = max(item.shown_radius_mm for item in items)
    length, start = math.tau * radius, left + FRAME_GAP_MM
    cut_webs = [web for web in report.crank.webs if any(web.number in i.all_webs for i in items)]
    low, high = min(web.z_min_mm for web in cut_webs), max(web.z_max_mm for web in cut_webs)
    for web in cut_webs:
        ends = web.z_min_mm, web.z_max_mm
        corners = [(0.0, ends[0]), (length, ends[0]), (length, ends[1]), (0.0, ends[1])]
        _outlines(space, [np.array(corners) + np.array([start, 0.0])], "OUTLINE")
    for item in items:
        turn = math.radians(zero.ccw(item.angle_deg))
        place = (start + turn * radius, item.z_mm)
        half = 0.5 * item.only_hole.diameter_mm
        space.add_circle(place, half, dxfattribs={"layer": "CUTS"})
        _text(space, str(item.number), (place[0] + half + 0.6, place[1]))
    bottom, top, right = low - FRAME_GAP_MM, high + 14.0, start + length + FRAME_GAP_MM
    frame = np.array([(left, bottom), (right, bottom), (right, top), (left, top)])
    _outlines(space, [frame], "FRAME")
    title = f"{report.file_name}: rim rolled out at radius {u.of_length(radius)}, ccw from {zero.name}, z up"
    _text(space, title, (left + 3.0, high + 9.0))


def _bytes(document: Drawing) -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode("utf-8", "replace")


def _web(block: BlockLayout, web: WebDrawing, items: Sequence[Cut], zero: Zero) -> None:
    """Draw a web in the rotor's x and y, with the direction of the zero."""
    _outlines(block, web.outline, "OUTLINE")
    reach = max((float(np.abs(polygon).max()) for polygon in web.outline), default=10.0) + 5.0
    for start, end in (((-reach, 0.0), (reach, 0.0)), ((0.0, -reach), (0.0, reach))):
        block.add_line(start, end, dxfattribs={"layer": "CENTRE"})
    way = np.array([math.cos(math.radians(zero.angle_deg)), math.sin(math.radians(zero.angle_deg))])
    if zero.angle_deg != 0.0:  # else it is the line of x
        block.add_line((0.0, 0.0), tuple(reach * way), dxfattribs={"layer": "CENTRE"})
    _text(block, f"0° {zero.sign}", tuple((reach + 1.0) * way))
    for item in items:
        _cut(block, item, web.cuts.get(item.number, []), zero)


def _cut(block: BlockLayout, item: Cut, shadow: Polygons, zero: Zero) -> None:
    place = np.array(item.position_mm[:2], dtype=np.float64)
    if item.hole is None:
        _outlines(block, shadow, "CUTS")
    elif abs(item.hole.inward[2]) > MIN_AXIAL_COMPONENT:
        radius = 0.5 * item.hole.diameter_mm
        block.add_circle(tuple(place), radius, dxfattribs={"layer": "CUTS"})
        for along in ((radius + 1.0, 0.0), (0.0, radius + 1.0)):
            block.add_line(tuple(place - along), tuple(place + along), dxfattribs={"layer": "CENTRE"})
    else:
        end = place + item.depth_mm * np.array(item.hole.inward[:2], dtype=np.float64)
        block.add_line(tuple(place), tuple(end), dxfattribs={"layer": "CENTRE"})
    _text(block, str(item.number), tuple(place + 0.6))
    angle = kinds.angle_deg(item)
    if angle is not None:
        below = place + np.array([0.6, 0.6 - LINE_STEP * TEXT_MM])
        _text(block, f"{degrees(zero.ccw(angle))} {zero.sign}", tuple(below))


def _section(block: BlockLayout, drawings: Drawings) -> None:
    """Draw the section with z to the right and x up."""
    _outlines(block, drawings.lengthwise, "OUTLINE")
    if drawings.lengthwise:
        points = np.concatenate(drawings.lengthwise)
        low, high = float(points[:, 0].min()) - 5.0, float(points[:, 0].max()) + 5.0
        block.add_line((low, 0.0), (high, 0.0), dxfattribs={"layer": "CENTRE"})
    for number, polygons in drawings.lengthwise_cuts.items():
        _outlines(block, polygons, "CUTS")
        middle = np.concatenate(polygons).mean(axis=0)
        _text(block, str(number), (float(middle[0]), float(middle[1])))


def _outlines(block: BlockLayout | Modelspace, polygons: Polygons, layer: str) -> None:
    for polygon in polygons:
        places = [(float(x), float(y)) for x, y in polygon]
        block.add_lwpolyline(places, close=True, dxfattribs={"layer": layer})


def _text(block: BlockLayout | Modelspace, text: str, place: Any) -> None:
    block.add_text(text, height=TEXT_MM, dxfattribs={"layer": "TEXT"}).set_placement(place)


def _placed(space: Modelspace, name: str, shown: Polygons, title: str, left: float, u: DisplayUnits) -> float:
    """Insert a block at ``left``, with frame, title and dimensions; return the end of its frame."""
    if not shown:
        return left
    points = np.concatenate(shown)
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    at = left + FRAME_GAP_MM + 15.0 - x0
    space.add_blockref(name, (at, 0.0))
    x0, x1 = x0 + at, x1 + at
    in_inches = {} if u.is_metric else {"dimlfac": 1.0 / u.mm_per_length, "dimdec": u.length_digits}
    for base, p1, p2, angle in (
        ((x0, y0 - 10.0), (x0, y0), (x1, y0), 0.0),
        ((x0 - 10.0, y0), (x0, y0), (x0, y1), 90.0),
    ):
        space.add_linear_dim(
            base=base,
            p1=p1,
            p2=p2,
            angle=angle,
            override=in_inches,
            dxfattribs={"layer": "DIMENSIONS"},
        ).render()
    low, high = (left, y0 - 22.0), (x1 + FRAME_GAP_MM, y1 + 14.0)
    corners = [low, (high[0], low[1]), high, (low[0], high[1])]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "FRAME"})
    _text(space, title, (left + 3.0, y1 + 9.0))
    return float(high[0]) + GAP_MM
