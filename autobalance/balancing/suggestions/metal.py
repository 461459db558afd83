"""Bores, heavy metal and turned rims that would give a solid crank a wanted factor or inertia.

Amounts are closed forms (mass at a radius, depth of a bore). Each is then cut from the solid in memory, the
removed metal is measured, and the depth is corrected by the closed form's error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from autobalance.balancing.suggestions.wanted import (
    Aim,
    Missing,
    Refused,
    SuggestedBore,
    SuggestedChange,
    Suggestion,
)
from autobalance.crank.anatomy import Web
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import tessellated
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.csg.tool import ring
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.wording import angle_deg

WALL_MM = 3.0
"""Metal left between a bore and the web's outline, journals and crankpins."""
FLOOR_MM = 2.0
"""Metal left under a blind bore."""
DIAMETERS_MM = (4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 28.0, 32.0, 36.0, 40.0)
HEAVY_G_MM3 = 17.0e-3
"""Sintered tungsten."""
SEGMENTS = 64
MIDDLE_LINE_SHARE = 0.05
"""Distance from the middle line, as a share of its radius, within which a place is moved onto it."""
LEAST_SIN = 0.05
"""Half of the fan angle's sine below which a rim is turned all round and nothing is gained."""
MOST_TRIALS = 4
DIGITS = 2


def suggested_metal(
    solid: Solid, density_g_mm3: float, aim: Aim, *, turned: bool = True
) -> tuple[list[Suggestion], list[Refused]]:
    """Return the bores, heavy metal in bores, and turned rims that reach an aim, and those that do not.

    Parameters
    ----------
    solid : Solid
        The crank in the rotor frame [mm].
    density_g_mm3 : float
    aim : Aim
    turned : bool
        Whether turning the rims is asked, too.
    """
    webs = [_CounterweightWeb.of(solid, web, towards, aim) for web, towards in aim.webs()]
    suggestions: list[Suggestion] = []
    refused: list[Refused] = []
    ways: tuple[tuple[str, Callable[[], Suggestion]], ...] = (
        ("hole", lambda: _bored(webs, aim, density_g_mm3, 0.0)),
        ("weight", lambda: _bored(webs, aim, density_g_mm3, HEAVY_G_MM3)),
        ("rim", lambda: _turned(webs, aim, density_g_mm3)),
    )
    for kind, way in ways if turned else ways[:2]:
        try:
            if not webs:
                raise CorrectionError("no web carries a counterweight that counts")
            suggestions.append(way())
        except CorrectionError as error:
            refused.append(Refused(kind, str(error)))
    return suggestions, refused


@dataclass(frozen=True, eq=False)
class _CounterweightWeb:
    """A web's metal, its widest section, the direction (2,) of its crankpin, and circles to keep clear of."""

    web: Web
    towards: Array
    metal: Solid
    section: Region
    spared: tuple[tuple[float, float, float], ...]
    journal_above: bool

    @classmethod
    def of(cls, solid: Solid, web: Web, towards: Array, aim: Aim) -> _CounterweightWeb:
        metal = solid.above(web.z_min_mm).below(web.z_max_mm)
        heights = web.z_min_mm + (web.z_max_mm - web.z_min_mm) * (0.1 + 0.2 * np.arange(5))
        section = max((metal.section(float(z)) for z in heights), key=lambda region: region.area_mm2)
        pins = [*aim.anatomy.main_journals, *(throw.crankpin for throw in aim.anatomy.throws)]
        spared = tuple(
            {
                (float(p.centre_mm[0]), float(p.centre_mm[1]), 0.5 * p.diameter_mm)
                for p in pins
                if _near(p, web)
            }
        )
        middle = 0.5 * (web.z_min_mm + web.z_max_mm)
        nearest = min(aim.anatomy.throws, key=lambda t: abs(float(t.crankpin.centre_mm[2]) - middle))
        return cls(web, towards, metal, section, spared, middle > float(nearest.crankpin.centre_mm[2]))

    def places(self, diameter_mm: float, side: float) -> list[Array]:
        """Return one place (2,), or two in mirror, far out on the crankpin's side (1) or away (−1).

        Where there is no room beside the crankpin, its own middle is one.
        """
        half = 0.5 * diameter_mm
        free = self.section.grown(-(half + WALL_MM))
        for x, y, radius in self.spared:
            free = free - Region.circle(radius + half + WALL_MM, 2 * SEGMENTS, (x, y))
        corners = np.concatenate([*free.polygons, np.zeros((0, 2))])
        along = corners @ (side * self.towards)
        if not (len(corners) and along.max() > half):
            return self._in_crankpin(half) if side > 0.0 else []
        best = corners[int(along.argmax())]
        onto = float(best @ self.towards) * self.towards
        mirrored = 2.0 * onto - best
        if float(np.linalg.norm(best - onto)) <= max(half, MIDDLE_LINE_SHARE * float(np.linalg.norm(best))):
            return [onto] if free.grown(1e-3).contains(onto[None])[0] else []
        if not free.grown(1e-2).contains(mirrored[None])[0]:
            return []
        return [best, mirrored]

    def _in_crankpin(self, half_mm: float) -> list[Array]:
        x, y, radius = max(self.spared, key=lambda circle: float(np.array(circle[:2]) @ self.towards))
        place = np.array([x, y])
        return [place] if float(place @ self.towards) > radius > half_mm + WALL_MM else []

    def column(self, place: Array, diameter_mm: float) -> tuple[float, float]:
        """Return z at both ends of the metal under a bore [mm]; equal without metal."""
        bore = self.metal & _cylinder(place, diameter_mm, self.web.z_min_mm - 1.0, self.web.z_max_mm + 1.0)
        if bore.is_empty:
            return self.web.z_min_mm, self.web.z_min_mm
        low, high = (float(z) for z in bore.bounds[:, 2])
        return low, high


def _near(pin: object, web: Web) -> bool:
    low, high = pin.z_range_mm  # type: ignore[attr-defined]
    slack = web.z_max_mm - web.z_min_mm
    return bool(high > web.z_min_mm - slack and low < web.z_max_mm + slack)


def _cylinder(place: Array, diameter_mm: float, low: float, high: float) -> Solid:
    """Return a prism with the area of a round cylinder."""
    turn = 2.0 * math.pi / SEGMENTS
    radius = 0.5 * diameter_mm * math.sqrt(turn / math.sin(turn))
    return Solid.prism(Region.circle(radius, SEGMENTS, (float(place[0]), float(place[1]))), low, high)


# --- bores ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Seat:
    """A web, and the places of its bores of one diameter on one side.

    A gram there has the product ``arm_mm`` (its distance along the throw) and the inertia ``square_mm2``.
    """

    web: _CounterweightWeb
    places: tuple[Array, ...]
    diameter_mm: float
    side: float
    room_mm: float

    @property
    def arm_mm(self) -> float:
        """Distance from the axis along the throw [mm]."""
        return abs(float(self.places[0] @ self.web.towards))

    @property
    def square_mm2(self) -> float:
        """Square of the radius of gyration about the crank axis [mm²]."""
        return float(self.places[0] @ self.places[0]) + self.diameter_mm**2 / 8.0

    def mass_per_mm(self, density_g_mm3: float) -> float:
        """Return the mass of all its bores per millimetre of depth."""
        return len(self.places) * density_g_mm3 * 0.25 * math.pi * self.diameter_mm**2


def _bored(webs: Sequence[_CounterweightWeb], aim: Aim, density: float, heavy: float) -> Suggestion:
    """Return the bores, empty or with heavy metal, that reach the aim, of the smallest diameter that fits."""
    effect = heavy - density
    missing = aim.missing(aim.start)
    kind, reason = ("weight" if heavy else "hole"), ""
    for diameter in DIAMETERS_MM:
        seats = {side: _seats(webs, diameter, side) for side in (-1.0, 1.0)}
        try:
            depths = _depths(seats, aim, missing, effect)
        except _NoRoomError as error:
            reason = reason or str(error)  # of larger ones there is none either
            continue
        except CorrectionError as error:
            reason = str(error)
            continue
        return _with_trials(kind, seats, depths, aim, density, heavy)
    raise CorrectionError(reason)


def _seats(webs: Sequence[_CounterweightWeb], diameter_mm: float, side: float) -> list[_Seat]:
    seats = []
    for web in webs:
        places = web.places(diameter_mm, side)
        if places:
            low, high = web.column(places[0], diameter_mm)
            if high - low > FLOOR_MM:
                seats.append(_Seat(web, tuple(places), diameter_mm, side, high - low - FLOOR_MM))
    return seats


Seats = dict[float, list[_Seat]]


class _NoRoomError(CorrectionError):
    """No bore of a diameter fits on a side."""


def _depths(seats: Seats, aim: Aim, missing: Missing, effect_g_mm3: float) -> dict[float, float]:
    """Return the depth of the bores on each side, the same on every web: a mass at a radius, and its length.

    Products a (away from the crankpin) and b (on its side): s (a − b) = P, s (a j_a + b j_b) = J.

    Raises
    ------
    CorrectionError
        If metal of that sign cannot do it, or not at this diameter.
    """
    sign = 1.0 if effect_g_mm3 > 0.0 else -1.0
    verb = "added" if sign < 0.0 else "taken away"
    product, inertia = sign * missing.product_g_mm, missing.inertia_g_mm2
    needs = {-1.0: max(product, 0.0), 1.0: max(-product, 0.0)}
    if inertia is not None:
        if not (seats[-1.0] and seats[1.0]):
            raise _NoRoomError("there is no room for bores on both sides of the axis; expected both")
        j = {side: _mean_square_over_arm(seats[side]) for side in (-1.0, 1.0)}
        away = (sign * inertia + product * j[1.0]) / (j[-1.0] + j[1.0])
        needs = {-1.0: away, 1.0: away - product}
        if min(needs.values()) < -1e-9 * max(map(abs, needs.values())):
            raise CorrectionError(f"metal would have to be {verb}")
    depths = {}
    for side, amount in needs.items():
        if amount <= 0.0:
            continue
        mine = seats[side]
        where = "away from the crankpin" if side < 0.0 else "on the crankpin's side"
        if not mine:
            raise _NoRoomError(f"no bore of {DIAMETERS_MM[0]:g} mm or more fits {where}")
        per_mm = sum(each.mass_per_mm(abs(effect_g_mm3)) * each.arm_mm * _share(each, aim) for each in mine)
        room = min(each.room_mm for each in mine)
        depths[side] = amount / per_mm
        if depths[side] > room:
            raise CorrectionError(
                f"the largest bores that fit {where}, {mine[0].diameter_mm:g} mm, would have to be "
                f"{depths[side]:.1f} mm deep; there are {room:.1f} mm"
            )
    if not depths:
        raise CorrectionError("nothing is missing")
    return depths


def _share(seat: _Seat, aim: Aim) -> float:
    return 1.0 if aim.direction is None else float(seat.web.towards @ aim.direction)


def _mean_square_over_arm(seats: Sequence[_Seat]) -> float:
    return float(np.mean([each.square_mm2 / each.arm_mm for each in seats]))


def _with_trials(
    kind: str, seats: Seats, depths: dict[float, float], aim: Aim, density: float, heavy: float
) -> Suggestion:
    """Cut the bores, measure, correct the depths, until the aim is reached."""
    first, tried, bores = dict(depths), aim.start, list[SuggestedBore]()
    for _ in range(MOST_TRIALS):
        depths = {side: round(depth, DIGITS) for side, depth in depths.items()}
        change, bores = _cut(seats, depths, first, density, heavy)
        tried = aim.start + change
        if aim.reached(tried, 1.0):
            break
        more = _more(seats, aim, aim.missing(tried), heavy - density, tuple(depths))
        depths = {
            side: min(max(depth + more[side], 0.01), *(each.room_mm for each in seats[side]))
            for side, depth in depths.items()
        }
    words = "; ".join(_words(bores, side, seats, kind) for side in depths)
    return Suggestion(kind, words, tried, bores=tuple(bores))


def _more(
    seats: Seats, aim: Aim, missing: Missing, effect: float, sides: tuple[float, ...]
) -> dict[float, float]:
    """Return the additional depth [mm] of the bores on each side for the missing product and inertia."""
    rows = []
    for side in sides:
        grams = [(each, each.mass_per_mm(effect)) for each in seats[side]]
        product = sum(-side * mass * each.arm_mm * _share(each, aim) for each, mass in grams)
        rows.append((product, sum(mass * each.square_mm2 for each, mass in grams)))
    matrix, target = np.array(rows).T, np.array([missing.product_g_mm, missing.inertia_g_mm2 or 0.0])
    if missing.inertia_g_mm2 is None or len(sides) == 1:
        keep = 0 if missing.inertia_g_mm2 is None or aim.direction is not None else 1
        matrix, target = matrix[keep : keep + 1], target[keep : keep + 1]
    amounts = np.linalg.lstsq(matrix, target, rcond=None)[0]
    return {side: float(each) for side, each in zip(sides, amounts, strict=True)}


def _cut(
    seats: Seats, depths: dict[float, float], first: dict[float, float], density: float, heavy: float
) -> tuple[Moments, list[SuggestedBore]]:
    """Return the change of the moments, measured on the metal that the bores meet, and the bores."""
    total, bores = Moments.zero(), []
    for side, depth in depths.items():
        for seat in seats[side]:
            web = seat.web
            for place in seat.places:
                low, high = web.column(place, seat.diameter_mm)
                start, end = (high, high - depth) if web.journal_above else (low, low + depth)
                tool = _cylinder(place, seat.diameter_mm, min(start, end), max(start, end))
                metal = tool & web.metal
                change = metal.moments(1.0).scaled(heavy - density)
                total = total + change
                bores.append(
                    SuggestedBore(
                        web.web.number, seat.diameter_mm, depth, first[side], float(np.linalg.norm(place)),
                        angle_deg(place), start, abs(change.mass_g),
                    )
                )  # fmt: skip
    return total, bores


def _words(bores: Sequence[SuggestedBore], side: float, seats: Seats, kind: str) -> str:
    webs = {each.web.web.number for each in seats[side]}
    one = next(bore for bore in bores if bore.web in webs and _side_of(bore, seats) == side)
    count = len(seats[side][0].places)
    filled = "" if kind == "hole" else " filled with tungsten"
    where = "away from the crankpin" if side < 0.0 else "on the crankpin's side"
    return (
        f"{count} bore{'s' * (count > 1)}{filled} {one.diameter_mm:g} × {one.depth_mm:.2f} mm "
        f"at radius {one.radius_mm:.2f} mm {where} in each of {len(webs)} web{'s' * (len(webs) > 1)}, "
        f"{one.mass_g:.2f} g each"
    )


def _side_of(bore: SuggestedBore, seats: Seats) -> float:
    turn = math.radians(bore.angle_deg)
    place = bore.radius_mm * np.array([math.cos(turn), math.sin(turn)])
    web = next(each.web for group in seats.values() for each in group if each.web.web.number == bore.web)
    return 1.0 if float(place @ web.towards) > 0.0 else -1.0


# --- turned rims -----------------------------------------------------------------------------------------


def _turned(webs: Sequence[_CounterweightWeb], aim: Aim, density: float) -> Suggestion:
    """Return the suggested radius of all counterweights, turned: R′³ = R³ − 3 P/(2 ρ T sin(A/2))."""
    missing = aim.missing(aim.start)
    outlines = [each.web.outline for each in webs if each.web.outline is not None]
    if len(outlines) < len(webs):
        raise CorrectionError("the rim of a counterweight was not recognised")
    if missing.inertia_g_mm2 is not None:
        raise CorrectionError("turning changes factor and inertia together; one size cannot meet two wishes")
    per_cube = [
        density * 2.0 / 3.0 * math.sin(0.5 * min(o.fan_angle_rad, 2.0 * math.pi)) * o.thickness_mm
        for o in outlines
    ]
    if min(per_cube) < LEAST_SIN * density * outlines[0].thickness_mm:
        raise CorrectionError("the rim goes all round: turning it takes from both sides")
    if missing.product_g_mm >= 0.0:
        raise CorrectionError("metal would have to be added")
    weight = sum(c * aim.along([each.towards]) for c, each in zip(per_cube, webs, strict=True))
    start = min(o.rim_radius_mm for o in outlines)
    radius, first, tried = start, None, aim.start
    for _ in range(MOST_TRIALS):
        left = aim.missing(tried).product_g_mm
        cube = radius**3 + left / weight
        if not cube > (0.5 * start) ** 3:
            raise CorrectionError(f"turned to {0.5 * start:.1f} mm, half its radius, it would not be enough")
        radius = round(cube ** (1.0 / 3.0), DIGITS)
        first = first or radius
        tried = aim.start - _beyond(webs, radius, start, density)
        if aim.reached(tried, 1.0):
            break
    assert first is not None
    change = SuggestedChange("rim_radius_mm", start, first, radius)
    return Suggestion(
        "rim",
        f"all counterweights turned to {radius:.2f} mm from {start:.2f} mm in radius",
        tried,
        (change,),
    )


def _beyond(webs: Sequence[_CounterweightWeb], radius: float, rim: float, density: float) -> Moments:
    cut = [
        each.metal & tessellated(ring(radius, 2.0 * rim, each.web.z_min_mm, each.web.z_max_mm), 4 * SEGMENTS)
        for each in webs
    ]
    return union(cut).moments(density)
