"""Unbalance as arrows in the plane across the crank axis: SVG, the zero of the page up, counter-clockwise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.report.page_units import PAGE_UNITS, PAGE_ZERO_DEG, pointing, unbalance
from autobalance.wording import escape

SIZE = 200.0
RADIUS = 74.0
"""Radius of the outer ring, in a plot ``SIZE`` wide."""
NAME_WIDE, NAME_HIGH = 36.0, 11.0
"""Room of a stage's name at its tip."""


def figure(
    title: str, before: Mapping[str, Any], after: Mapping[str, Any], permitted: Mapping[str, Any]
) -> str:
    """Return a figure with two plots: before, at its own scale, and after, at the scale of the limit."""
    limit = permitted["permissible_g_mm"]
    start, end = before["magnitude_g_mm"], after["magnitude_g_mm"]
    left = _plot(before, limit, max(start, limit), "was", "before")
    right = _plot(after, limit, 1.25 * max(end, limit), "is", "after", after.get("uncertainty_g_mm"))
    return (
        f"<figure><figcaption><h3>{title}</h3><span class=soft>{unbalance(start)} → {unbalance(end)} of "
        f"{unbalance(limit)} {PAGE_UNITS.get().unbalance}</span></figcaption><div class=pair>{left}{right}</div></figure>"
    )


def figures(report: Mapping[str, Any]) -> list[str]:
    """Return the figures of a run: of the resultant, and of each tolerance plane."""
    before, after, permitted = report["initial"], report["residual"], report["tolerance"]
    planes = zip(before["planes"], after["planes"], permitted["planes"], strict=True)
    of_planes = [figure(f"Plane {escape(each[2]['name'])}", *each) for each in planes]
    return [figure("Resultant", before, after, permitted), *of_planes]


def stages_figure(
    title: str, points: Sequence[tuple[str, Sequence[float]]], permitted_g_mm: float, days: str = ""
) -> str:
    """Return one plot of vectors in order, each named at its tip, a line from one to the next.

    ``days`` is a line below its title.
    """
    full = max([permitted_g_mm, *(math.hypot(*vector) for _, vector in points)])
    per, middle = RADIUS / full, SIZE / 2.0
    turned = [_from_zero(vector) for _, vector in points]
    tips = [(middle - per * y, middle - per * x) for x, y in turned]  # the zero is up, 90° is left
    path = "L".join(f"{x:.2f} {y:.2f}" for x, y in tips)
    marks = "".join(f'<circle class="tip is" cx="{x:.2f}" cy="{y:.2f}" r="3"/>' for x, y in tips)
    marks += "".join(
        f'<text x="{x:.2f}" y="{y:.2f}">{name}</text>'
        for (name, _), (x, y) in zip(points, _beside(tips), strict=True)
    )
    sizes = [(name, unbalance(math.hypot(*vector)), pointing(vector)) for name, vector in points]
    words = "; ".join(f"stage {name}: {size}{angle}" for name, size, angle in sizes)
    dated = f"<br>{days}" if days else ""
    return f"""<figure><figcaption><h3>{title}</h3><span class=soft>outer ring {unbalance(full)} {PAGE_UNITS.get().unbalance}{dated}</span></figcaption>
<svg viewBox="0 0 {SIZE:g} {SIZE + 8:g}" role="img" aria-label="{words}"><title>{words}</title>
<circle class=grid cx="{middle}" cy="{middle}" r="{RADIUS}"/><path class=grid d="M{middle} {middle - RADIUS}V{middle + RADIUS}M{middle - RADIUS} {middle}H{middle + RADIUS}"/>
<circle class=zone cx="{middle}" cy="{middle}" r="{max(per * permitted_g_mm, 0.8):.2f}"/>{_degrees(middle, middle)}
<path class="vector is" fill="none" d="M{path}"/>{marks}</svg></figure>"""


def _beside(tips: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the places of the names of tips: right of each, lower where another name or numeral is."""
    middle, far = SIZE / 2.0, RADIUS + 12.0
    taken = [
        (middle - 12.0, middle + far),
        (middle - far - 12.0, middle + 4.0),
        (middle + far - 12.0, middle + 4.0),
    ]
    places = []
    for x, y in tips:
        place = (x + 5.0, y + 4.0)
        while any(
            abs(place[0] - left) < NAME_WIDE and abs(place[1] - base) < NAME_HIGH for left, base in taken
        ):
            place = (place[0], place[1] + 2.0)
        taken.append(place)
        places.append(place)
    return places


def _plot(
    vector: Mapping[str, Any], limit: float, full: float, style: str, when: str, doubt: float | None = None
) -> str:
    """Return one polar plot whose outer ring is ``full``."""
    per = RADIUS / full
    x, y = vector["unbalance_g_mm"]
    cx = cy = SIZE / 2.0
    up, left = _from_zero((x, y))
    tip_x, tip_y = cx - per * left, cy - per * up
    size = vector["magnitude_g_mm"]
    caption = f"{when}: {unbalance(size)} {PAGE_UNITS.get().unbalance}{pointing((x, y), 1)}"
    uncertain = (
        f'<circle class=doubt cx="{tip_x:.2f}" cy="{tip_y:.2f}" r="{per * doubt:.2f}"/>' if doubt else ""
    )
    return f"""<svg viewBox="0 0 {SIZE:g} {SIZE + 8:g}" role="img" aria-label="{caption}"><title>{caption}</title>
<circle class=grid cx="{cx}" cy="{cy}" r="{RADIUS}"/><path class=grid d="M{cx} {cy - RADIUS}V{cy + RADIUS}M{cx - RADIUS} {cy}H{cx + RADIUS}"/>
<circle class=zone cx="{cx}" cy="{cy}" r="{max(per * limit, 0.8):.2f}"/>{_degrees(cx, cy)}
<path class="vector {style}" d="M{cx} {cy}L{tip_x:.2f} {tip_y:.2f}"/>{uncertain}<circle class="tip {style}" cx="{tip_x:.2f}" cy="{tip_y:.2f}" r="3.6"/>
<text class=title x="{cx}" y="{SIZE + 4:g}" text-anchor="middle">{when} · {unbalance(size)}{pointing((x, y))}</text></svg>"""


def _from_zero(vector: Sequence[float]) -> tuple[float, float]:
    """Return a vector in axes whose x points to the page's zero."""
    x, y = vector
    turn = math.radians(PAGE_ZERO_DEG.get())
    return x * math.cos(turn) + y * math.sin(turn), y * math.cos(turn) - x * math.sin(turn)


def _degrees(cx: float, cy: float) -> str:
    texts = []
    for degrees in (0, 90, 180, 270):
        turn = math.radians(degrees)
        x, y = cx - (RADIUS + 12.0) * math.sin(turn), cy - (RADIUS + 9.0) * math.cos(turn)
        texts.append(f'<text x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle">{degrees}°</text>')
    return "".join(texts)
