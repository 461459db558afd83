"""Unbalance as arrows in the plane across the crank axis: SVG, the zero of the page up, counter-clockwise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from autobalance.declare import Floats, present
from autobalance.report.display_units import PAGE_UNITS, PAGE_ZERO_DEG, pointing, unbalance
from autobalance.value_classes import dataclass
from autobalance.wording import escape

if TYPE_CHECKING:  # every result loads this module
    from autobalance.report.records.balance import Plane, Tolerance, Unbalance
    from autobalance.report.records.balanced import BalancedReport
    from autobalance.rigid_rotor.tolerance import TolerancePlane

SIZE = 200.0
MIDDLE = SIZE / 2.0
PERMITTED, RIM = 44.0, 66.0
"""Radii of the permitted circle and of the rim, in a polar ``SIZE`` wide."""
RADIUS = 74.0
"""Radius of the outer ring, in a plot ``SIZE`` wide."""
NAME_WIDE, NAME_HIGH = 36.0, 11.0
"""Room of a stage's name at its tip."""


@dataclass(frozen=True)
class Vector:
    """An unbalance in a polar: (x, y) in the rotor frame [g·mm], its name, its uncertainty [g·mm] or None."""

    unbalance_g_mm: tuple[float, float]
    name: str
    uncertainty_g_mm: float | None = None


def drawn(
    permitted_g_mm: float,
    vectors: Sequence[Vector],
    zero_deg: float = 0.0,
    sign: str = "P1",
    expected_g_mm: tuple[float, float] | None = None,
) -> str:
    """Return the polar of page and app: the permitted circle has one size, the zero is up, ccw is left.

    What does not fit ends at the rim with a break mark. The uncertainty is a dotted circle about the tip. A
    reading has a ring where it was expected, and the path from there.

    Parameters
    ----------
    permitted_g_mm : float
    vectors : sequence of Vector
        ``before`` is grey, any other in the accent's colour.
    zero_deg : float
        Angle of the zero, counter-clockwise from crankpin 1 [deg].
    sign : str
        How the zero is written beside 0°.
    expected_g_mm : (2,) float or None
    """
    per, turn = PERMITTED / permitted_g_mm, math.radians(zero_deg)
    marks = "".join(
        f'<text class="p-lab" x="{x:g}" y="{y:g}" text-anchor="middle">{degrees}</text>'
        for degrees, x, y in ((90, 14.0, 105.0), (180, MIDDLE, 192.0), (270, 183.0, 105.0))
    )
    path = ""
    if expected_g_mm is not None:
        x, y = _place(expected_g_mm, per, turn)
        if vectors:
            to_x, to_y = _place(vectors[0].unbalance_g_mm, per, turn)
            path = f'<path class="p-path" d="M{x:.2f} {y:.2f}L{to_x:.2f} {to_y:.2f}"/>'
        path += f'<circle class="p-expected" cx="{x:.2f}" cy="{y:.2f}" r="4"/>'
    return (
        f'<svg viewBox="0 0 {SIZE:g} {SIZE:g}" role="presentation"><circle class="p-ring" cx="{MIDDLE:g}" '
        f'cy="{MIDDLE:g}" r="{RIM:g}"/><path class="p-axis" d="M{MIDDLE:g} {MIDDLE - RIM:g}v{2 * RIM:g}'
        f'M{MIDDLE - RIM:g} {MIDDLE:g}h{2 * RIM:g}"/><circle class="p-ok permitted" cx="{MIDDLE:g}" '
        f'cy="{MIDDLE:g}" r="{PERMITTED:g}"/><text class="p-lab p-zero" x="{MIDDLE:g}" y="22" '
        f'text-anchor="middle">0° {escape(sign)}</text>{marks}{path}'
        f"{''.join(_arrow(each, per, turn) for each in vectors)}</svg>"
    )


def _place(vector: Sequence[float], per: float, turn: float) -> tuple[float, float]:
    """Return a vector's end in the drawing: at the rim where it is longer."""
    angle, length = math.atan2(vector[1], vector[0]) - turn, min(per * math.hypot(*vector), RIM)
    return MIDDLE - length * math.sin(angle), MIDDLE - length * math.cos(angle)


def _arrow(vector: Vector, per: float, turn: float) -> str:
    angle = math.atan2(vector.unbalance_g_mm[1], vector.unbalance_g_mm[0]) - turn
    is_cut = per * math.hypot(*vector.unbalance_g_mm) > RIM
    x, y = _place(vector.unbalance_g_mm, per, turn)

    def at(radius: float, aside: float) -> str:
        across = MIDDLE - radius * math.sin(angle) - aside * math.cos(angle)
        return f"{across:.2f} {MIDDLE - radius * math.cos(angle) + aside * math.sin(angle):.2f}"

    breaks = "".join(f"M{at(RIM - low, 6.0)}L{at(RIM - low + 5.0, -6.0)}" for low in (8.0, 14.0))
    kind, off = ("p-before" if vector.name == "before" else "p-after"), vector.uncertainty_g_mm
    doubt = (
        f'<circle class="p-unc" cx="{x:.2f}" cy="{y:.2f}" r="{min(per * off, RIM):.2f}"/>'
        if off and not is_cut
        else ""
    )
    return (
        f'{doubt}<path class="{kind}" d="M{MIDDLE:g} {MIDDLE:g}L{x:.2f} {y:.2f}{breaks if is_cut else ""}"/>'
        f'<circle class="{kind} tip {escape(vector.name)}" cx="{x:.2f}" cy="{y:.2f}" r="4.5"/>'
    )


def figure(
    title: str,
    before: Unbalance | Plane,
    after: Unbalance | Plane,
    permitted: Tolerance | TolerancePlane,
    sign: str = "P1",
) -> str:
    """Return a figure: before and after in one polar, with their numbers beside it."""
    limit, off = permitted.permissible_g_mm, present(after.uncertainty_g_mm)
    states = [("before", before, None), ("after", after, off)]
    vectors = [
        Vector((each.unbalance_g_mm[0], each.unbalance_g_mm[1]), name, doubt) for name, each, doubt in states
    ]
    said = [f"{name} {_says(each)}" for name, each, _ in states]
    rows = "".join(f"<dt>{name}</dt><dd>{_says(each)}</dd>" for name, each, _ in states)
    unit = PAGE_UNITS.get().unbalance
    more = f"<dt>uncertainty</dt><dd>± {unbalance(off)}</dd>" if off else ""
    return (
        f"<figure><figcaption><h3>{title}</h3><span class=soft>{unit}</span></figcaption><div class=pair>"
        f'<div role="img" aria-label="{title}: {", ".join(said)} of {unbalance(limit)} {unit}">'
        f"{drawn(limit, vectors, PAGE_ZERO_DEG.get(), sign)}</div>"
        f"<dl class=states>{rows}{more}<dt>permitted</dt><dd>{unbalance(limit)}</dd></dl></div></figure>"
    )


def _says(state: Unbalance | Plane) -> str:
    return f"{unbalance(state.magnitude_g_mm)}{pointing(state.unbalance_g_mm, 1)}"


def figures(report: BalancedReport, sign: str = "P1") -> list[str]:
    """Return the figures of a run: of the resultant, and of each tolerance plane.

    ``sign`` is that of the page's zero.
    """
    before, after, permitted = report.initial, report.residual, report.tolerance
    planes = zip(before.planes, after.planes, permitted.planes, strict=True)
    of_planes = [figure(f"Plane {escape(each[2].name)}", *each, sign) for each in planes]
    return [figure("Resultant", before, after, permitted, sign), *of_planes]


def stages_figure(
    title: str, points: Sequence[tuple[str, Floats]], permitted_g_mm: float, days: str = ""
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


def _from_zero(vector: Floats) -> tuple[float, float]:
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
