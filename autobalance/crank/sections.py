"""Division of a crank along its axis, and the room that oil fills in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import groupby, pairwise
from typing import Annotated, Literal

import numpy as np

from autobalance.crank.anatomy import Anatomy, Pin, Web
from autobalance.crank.recognition.section_stack import rotated
from autobalance.declare import LAST, NotNegative, derived
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import polygon_area_mm2
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.slicing.slices import WHOLE_SLAB, Slab, SlabPart
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Division of a crank along its axis: journals, crankpins, webs and counterweights with their moments.


Kind = Literal["main journal", "crankpin", "web", "counterweight", "shaft"]

SHOULDER_MARGIN_RATIO = 0.05
"""A journal's metal beside a shoulder that is around it reaches to its radius and this share more."""
ASIDE_SHARE = 1e-5
"""Distance from a face, as a share of the part's diagonal, beyond the face's rounding."""
ROUNDING = 1e-7
"""Corners this near to where a part ends, as a share of the part's diagonal, lie there."""
LEAST_SHARE = 1e-9
"""A part with less than this share of the crank's mass is rounding."""


@dataclass(frozen=True, eq=False)
class Section:
    """One part of a crank: its ``number`` is the journal's, the throw's or the web's; of shaft: 1, 2, ..."""

    kind: Kind
    number: int
    moments: Moments


def sections(solid: Solid, anatomy: Anatomy, density_g_mm3: float) -> tuple[Section, ...]:
    """Return a crank's parts: journals, crankpins, webs, counterweights and the rest of the shaft.

    A web's counterweight is its metal beyond the crank axis, away from its crankpin; fillets and collars
    belong to the web that they are on. The parts add up to the whole.

    Parameters
    ----------
    solid : Solid
        In file coordinates [mm].
    anatomy : Anatomy
    density_g_mm3 : float

    Returns
    -------
    tuple of Section
        In the order of the axis, moments in the rotor frame.

    References
    ----------
    Ruckle 2014, table 2, lists mass, X, Y, Z, WX, WY, CX, CY of such parts.
    """
    cutter = _Cutter.of(solid.mesh, anatomy, density_g_mm3)
    parts: dict[tuple[Kind, int], Moments] = {}

    def add(kind: Kind, number: int, moments: Moments) -> None:
        parts[kind, number] = parts.get((kind, number), Moments.zero()) + moments

    for span in cutter.spans():
        if span.pin is not None:
            kind: Kind = "main journal" if span.pin_is_journal else "crankpin"
            add(kind, span.pin_number, cutter.pin_moments(span))
        if span.web is not None:
            counterweight = Moments.zero()
            if span.web.counterweight:
                counterweight = cutter.web_moments(span, beyond=True)
                add("counterweight", span.web.number, counterweight)
            add("web", span.web.number, cutter.web_moments(span) - counterweight)
        if span.pin is None and span.web is None:
            add("shaft", span.pin_number, cutter.moments(span))
    whole = sum(moments.mass_g for moments in parts.values())
    pieces = [
        Section(kind, number, moments)
        for (kind, number), moments in parts.items()
        if moments.mass_g > LEAST_SHARE * whole
    ]
    return tuple(sorted(pieces, key=lambda part: float(part.moments.centre_mm[2])))


@dataclass(frozen=True)
class WebWeight:
    """A web's counterweight."""

    # m_cw, r′ and m_cw·r′ of the web with it, or of all of them (web None): the product is the first moment
    # away from the crankpin

    web: int | None
    mass_g: NotNegative
    product_g_mm: Annotated[float, LAST]

    @derived
    def radius_mm(self) -> float:
        """Distance of the centre of mass beyond the axis, r′ [mm]."""
        return self.product_g_mm / self.mass_g


def web_weights(parts: Sequence[Section], anatomy: Anatomy) -> tuple[WebWeight, ...]:
    """Return the source's m_cw, r′ and m_cw·r′ of each web with a counterweight; of all for one throw.

    A web with its centre of mass on the crankpin's side has no counterweight: its product would be negative.
    """
    weights = []
    for web in anatomy.webs:
        mine = [p.moments for p in parts if p.kind in ("web", "counterweight") and p.number == web.number]
        if web.counterweight and mine:
            away = away_from_crankpin(web, anatomy)
            product = sum(float(moments.first_g_mm[:2] @ away) for moments in mine)
            weights.append(WebWeight(web.number, sum(moments.mass_g for moments in mine), product))
    if weights and len(anatomy.throws) == 1:
        weights.append(WebWeight(None, sum(w.mass_g for w in weights), sum(w.product_g_mm for w in weights)))
    return tuple(weight for weight in weights if weight.product_g_mm > 0.0)


def counterweight_moments(solid: Solid, anatomy: Anatomy, density_g_mm3: float) -> Moments:
    """Return the moments of the webs that carry counterweights, crankpins and main journals left out.

    Its mass is the source's m_cw, the distance of its centre from the axis r′; rotor frame. A crankpin
    counts as left out over its bare cylinder; where it is drawn in one piece with the webs, the metal in
    the web is the web's.
    """
    cutter = _Cutter.of(solid.mesh, anatomy, density_g_mm3)
    total = Moments.zero()
    for web, group in groupby(cutter.spans(), key=lambda span: span.web):
        if web is not None and web.counterweight:
            total = total + cutter.moments_of_web(list(group))
    return total


@dataclass(frozen=True, eq=False)
class _Span:
    """A stretch of the axis with the owner of its metal; a web's shoulder may be around a journal."""

    low: float
    high: float
    pin: Pin | None = None
    pin_is_journal: bool = False
    pin_number: int = 0
    web: Web | None = None


@dataclass(frozen=True, eq=False)
class _Cutter:
    """A crank in the rotor frame, ready to be measured in stretches."""

    mesh: Mesh
    anatomy: Anatomy
    density_g_mm3: float

    @classmethod
    def of(cls, mesh: Mesh, anatomy: Anatomy, density_g_mm3: float) -> _Cutter:
        """Return a cutter of a mesh in file coordinates."""
        return cls(
            Mesh(rotated(mesh.vertices, anatomy.file_to_rotor), mesh.triangles), anatomy, density_g_mm3
        )

    def spans(self) -> list[_Span]:
        """Return the stretches of the axis, by increasing z, without gaps."""
        low, high = float(self.mesh.bounds[0, 2]), float(self.mesh.bounds[1, 2])
        ends = [low, high]
        for part in (*self.anatomy.main_journals, *(t.crankpin for t in self.anatomy.throws)):
            ends += part.z_range_mm
        for web in self.anatomy.webs:
            ends += [web.z_min_mm, web.z_max_mm]
        marks = np.unique(np.clip(ends, low, high))
        grain = 1e-7 * (high - low)
        marks = marks[np.concatenate([[True], np.diff(marks) > grain])]
        marks[-1] = high
        return self._with_fillets([self._span(float(a), float(b)) for a, b in pairwise(marks)])

    def _span(self, low: float, high: float) -> _Span:
        middle = 0.5 * (low + high)
        span = _Span(low, high)
        for web in self.anatomy.webs:
            if web.z_min_mm < middle < web.z_max_mm:
                span = replace(span, web=web)
        for throw in self.anatomy.throws:
            if throw.crankpin.z_range_mm[0] < middle < throw.crankpin.z_range_mm[1]:
                span = replace(span, pin=throw.crankpin, pin_number=throw.number)
        for journal in self.anatomy.main_journals:
            if journal.z_range_mm[0] < middle < journal.z_range_mm[1]:
                span = replace(span, pin=journal, pin_is_journal=True, pin_number=journal.number)
        return span

    def _with_fillets(self, spans: list[_Span]) -> list[_Span]:
        """Return spans with those between a web and a journal or crankpin in the web, the rest numbered."""
        with_webs: list[_Span] = []
        rest = 0
        for place, span in enumerate(spans):
            if span.pin is not None or span.web is not None:
                with_webs.append(span)
                continue
            beside = [spans[i] for i in (place - 1, place + 1) if 0 <= i < len(spans)]
            webs = [other.web for other in beside if other.web is not None]
            if webs and len(beside) == 2:
                with_webs.append(replace(span, web=webs[0]))
            else:
                rest += 1
                with_webs.append(replace(span, pin_number=rest))
        return with_webs

    def moments(self, span: _Span, part: SlabPart = WHOLE_SLAB) -> Moments:
        """Return the moments of a stretch's metal, or of part of it."""
        return self._layers.moments((span.low, span.high), self.density_g_mm3, part)

    @cached_property
    def _layers(self) -> Slab:
        return Slab(self.mesh.vertices, self.mesh.triangles, ROUNDING * self.mesh.diagonal_mm)

    def pin_moments(self, span: _Span) -> Moments:
        """Return the moments of the journal's or crankpin's metal in a stretch."""
        return self.moments(span) if span.web is None else self._beside_shoulder(span, None)

    def web_moments(self, span: _Span, beyond: bool = False) -> Moments:
        """Return the moments of the web's metal in a stretch, or of its part beyond the axis."""
        assert span.web is not None
        side = away_from_crankpin(span.web, self.anatomy) if beyond else None
        moments = self.moments(span, WHOLE_SLAB if side is None else SlabPart(side=side))
        return moments if span.pin is None else moments - self._beside_shoulder(span, side)

    def moments_of_web(self, spans: Sequence[_Span]) -> Moments:
        """Return the moments of a web's metal in neighbouring stretches, all at once."""
        moments = self.moments(_Span(spans[0].low, spans[-1].high))
        for span in spans:
            if span.pin is not None:
                moments = moments - self._beside_shoulder(span, None)
        return moments

    def _beside_shoulder(self, span: _Span, side: Array | None) -> Moments:
        """Return the moments of a cylinder's metal where a web's shoulder is around it.

        At the stretch's ends lie faces, even except for rounding; the cylinder is measured between them,
        where the shoulder is apart from it, and scaled to the whole stretch.
        """
        assert span.pin is not None
        part = SlabPart(
            span.pin.centre_mm[:2], 0.5 * (1.0 + SHOULDER_MARGIN_RATIO) * span.pin.diameter_mm, side
        )
        aside = min(ASIDE_SHARE * self.mesh.diagonal_mm, 0.1 * (span.high - span.low))
        inner = self.moments(replace(span, low=span.low + aside, high=span.high - aside), part)
        return inner.scaled((span.high - span.low) / (span.high - span.low - 2.0 * aside))


def away_from_crankpin(web: Web, anatomy: Anatomy) -> Array:
    """Return the unit vector (2,) away from the crankpins beside a web."""
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    below = [t for t in anatomy.throws if t.crankpin.centre_mm[2] < middle][-1:]
    above = [t for t in anatomy.throws if t.crankpin.centre_mm[2] > middle][:1]
    beside = [t for t in below + above if not _journal_between(anatomy, middle, t.crankpin)]
    beside = beside or list(anatomy.throws[:1])
    towards = sum((throw.direction for throw in beside), np.zeros(2))
    length = float(np.linalg.norm(towards))
    unit: Array = -(towards / length if length > OPPOSITE_TOLERANCE else beside[0].direction)
    return unit


OPPOSITE_TOLERANCE = 1e-3
"""Crankpins on both sides of a web are opposite each other if their directions add up to less than this."""


def _journal_between(anatomy: Anatomy, z_mm: float, pin: Pin) -> bool:
    low, high = sorted((z_mm, float(pin.centre_mm[2])))
    return any(low < journal.centre_mm[2] < high for journal in anatomy.main_journals)


# The room that oil fills in a crank: bores and drillings of crankpins and main journals.
#
# The crank is closed: each pin by its own outline seen along the axis, each web by its sections without the
# holes in them. Room is the difference between the closed crank and the crank; its pieces that reach into a
# pin count.


SLICE_MM = 1.0
"""Thickness of the slices in which a web's holes are closed."""
SLANT = 1.5
"""Largest sideways shift of a hole within a slice, over its thickness: 56° from the axis."""
OUTLINE_RADII = 1.02
"""Radius within which a pin's own outline is sought, over the pin's radius."""
END = 0.02
"""Share of a pin's length at its ends where webs and fillets may begin."""
BESIDE_MM = 0.1
"""Length of neighbouring metal [mm] that a slice includes, so that none of its faces coincides with a cut."""
LEVEL_MM = 1e-3
"""Height difference [mm] of a triangle's corners up to which it is square to the axis: rounding of files."""
LEAST_FACE_MM2 = 5.0
"""Area of a flat face [mm²] from which on it ends a bore: the bottom of a hole of 2.5 mm."""
INTO_MM = 0.002
"""Overlap of a pin's room with its webs', so that both are one: heights in files are rounded."""
LEAST_MM3 = 0.5
"""A smaller room is a gap between facets of neighbours."""


@dataclass(frozen=True)
class OilRoom:
    """A connected room.

    Attributes
    ----------
    throws, journals : tuple of int
        Numbers of the crankpins and main journals that it reaches into.
    solid : Solid
        The room itself, rotor frame.
    """

    throws: tuple[int, ...]
    journals: tuple[int, ...]
    solid: Solid

    @property
    def filling(self) -> Moments:
        """Moments of the filling at density 1, rotor frame: its mass is the room's volume [mm³]."""
        return self.solid.moments(1.0)


def oil_rooms(solid: Solid, anatomy: Anatomy) -> tuple[OilRoom, ...]:
    """Return the rooms that oil fills, closed at the pins' surfaces and at the ends of bores.

    Parameters
    ----------
    solid : Solid
        The crank, crankpins in it (rotor frame).
    anatomy : Anatomy

    Returns
    -------
    tuple of OilRoom
        In the order of the axis; none in a solid crank.
    """
    pins = [_room_in_pin(solid, anatomy, throw.crankpin) for throw in anatomy.throws]
    journals = [_room_in_pin(solid, anatomy, journal) for journal in anatomy.main_journals]
    rooms = [*pins, *journals, *(_room_in_web(solid, web) for web in anatomy.webs)]
    rooms = [each for each in rooms if not each.is_empty]
    drilled_rooms: list[OilRoom] = []
    for piece in union(rooms).pieces() if rooms else ():
        if piece.volume_mm3 < LEAST_MM3:
            continue
        of_throws = tuple(n for n, pin in enumerate(pins, 1) if _reaches(piece, pin))
        of_journals = tuple(n for n, pin in enumerate(journals, 1) if _reaches(piece, pin))
        if of_throws or of_journals:
            drilled_rooms.append(OilRoom(of_throws, of_journals, piece))
    return tuple(sorted(drilled_rooms, key=lambda room: float(room.filling.centre_mm[2])))


def _reaches(piece: Solid, room: Solid) -> bool:
    return not room.is_empty and (piece & room).volume_mm3 > LEAST_MM3


def _room_in_pin(solid: Solid, anatomy: Anatomy, pin: Pin) -> Solid:
    """Return the hollow within a pin's own outline, from web to web; to its end if there is no web."""
    (low, high), z = pin.z_range_mm, float(pin.centre_mm[2])
    x, y = (float(each) for each in pin.centre_mm[:2])
    slab = solid.above(low + END * (high - low)).below(high - END * (high - low))
    circle = Region.circle(0.5 * OUTLINE_RADII * pin.diameter_mm, 128, (x, y))
    outline = _filled((Solid.prism(circle, low, high) & slab).shadow())
    if outline.is_empty:
        return Solid.nothing()
    below = max((web.z_max_mm - INTO_MM for web in anatomy.webs if web.z_max_mm < z), default=low)
    above = min((web.z_min_mm + INTO_MM for web in anatomy.webs if web.z_min_mm > z), default=high)
    between = solid.above(below - BESIDE_MM).below(above + BESIDE_MM)
    return Solid.prism(outline, below, above) - between


def _room_in_web(solid: Solid, web: Web) -> Solid:
    """Return the holes of a web, closed slice by slice."""
    slab = solid.above(web.z_min_mm - BESIDE_MM).below(web.z_max_mm + BESIDE_MM)
    closed = []
    for low, high in pairwise(_heights_mm(slab, web)):
        section = slab.section(float(0.5 * (low + high)))
        whole = _filled(section)
        holes = (whole - section).grown(SLANT * float(high - low)) & whole
        if not holes.is_empty:
            closed.append(Solid.prism(holes, float(low), float(high)))
    return union(closed) - slab if closed else Solid.nothing()


def _heights_mm(slab: Solid, web: Web) -> Array:
    """Return the ends of a web's slices: its flat faces, where bores end, and steps between them."""
    corners = slab.mesh.corners
    z = corners[:, :, 2]
    level = np.ptp(z, axis=1) < LEVEL_MM
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    heights, number = np.unique(np.round(z[level].mean(axis=1) / LEVEL_MM), return_inverse=True)
    wide = np.bincount(number, areas[level], minlength=len(heights)) > LEAST_FACE_MM2
    inside = LEVEL_MM * heights[wide]
    inside = inside[(inside > web.z_min_mm + BESIDE_MM) & (inside < web.z_max_mm - BESIDE_MM)]
    ends = np.concatenate([[web.z_min_mm], inside, [web.z_max_mm]])
    parts = [np.linspace(a, b, max(2, int(np.ceil((b - a) / SLICE_MM)) + 1))[:-1] for a, b in pairwise(ends)]
    all_heights: Array = np.append(np.concatenate(parts), web.z_max_mm)
    return all_heights


def _filled(region: Region) -> Region:
    """Return a region without its holes: outlines that run clockwise are left out."""
    outer = [line for line in region.polygons if polygon_area_mm2(line) > 0.0]
    return Region.of(outer)
