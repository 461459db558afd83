"""Odd cranks with a known anatomy: ends, middles and builds that real cranks have and presets have not.

A crank is put together along z from cylinders on the axis, webs and crankpins, and each part notes where it
is. So the truth is that of the construction, not of a second recogniser.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Overrides, Pin, Throw, Web
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import DesignCounterweight, DesignWeb
from autobalance.drawn_cranks.generate import web_outline
from autobalance.errors import AutobalanceError
from autobalance.solid.csg.shape import (
    Arc,
    Joined,
    Line,
    Outline,
    Placed,
    Point,
    Prism,
    Revolved,
    Shape,
    Without,
    circle,
    on_grid,
    polygon,
    rotated,
    tessellated,
)
from autobalance.solid.formats.read import Source, source_of, source_of_bytes
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.units import MM_PER
from tests.generated import differences, random_placement

Ending = Literal["right", "doubted", "refused", "WRONG"]

SEGMENTS = (24, 36, 48, 64, 96, 160)
UNITS = ("mm", "mm", "mm", "inch", "m", "cm")
STEP_EVERY = 10
"""One crank in so many is a STEP file."""
MIRRORED_EVERY = 5
FILLET_SHARE = 1.0 / 8.0
RADII_MM = (6.0, 160.0)
"""Crank radii: from a model engine's to a ship's auxiliary."""
AXIS_MM = 0.05
"""A doubt names an axis, journal or crankpin that is off by less than this."""
ANGLE_RAD = 1e-9
"""Throw 1 is at 0 but for this rounding."""
FURTHER_BORE_MM = 1.0
"""A bore's tool goes so far beyond the metal."""


# --- what a crank is made of -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Step:
    """A cylinder on the axis, or a taper to ``end_mm`` at the side away from the web; ``main``: a journal."""

    diameter_mm: float
    width_mm: float
    main: bool = False
    end_mm: float | None = None
    thread: bool = False


@dataclass
class Built:
    """A crank along z as it grows: shapes, and the truth about them, in axes of their own [mm].

    ``mains`` and ``pins`` are (x, y, low, high, diameter), ``webs`` (low, high).
    """

    fillet_mm: float = 0.0
    root_mm: float = 1.0
    z_mm: float = 0.0
    parts: list[Shape] = field(default_factory=list)
    tools: list[Shape] = field(default_factory=list)
    mains: list[tuple[float, float, float]] = field(default_factory=list)
    pins: list[tuple[float, float, float, float, float]] = field(default_factory=list)
    webs: list[tuple[float, float]] = field(default_factory=list)

    def along_axis(self, steps: Sequence[Step], web_below: bool, web_above: bool) -> None:
        """Put cylinders on the axis, rooted in the webs beside them, fillets there."""
        z = on_grid(self.z_mm)
        edges: list[Line | Arc] = []
        last = len(steps) - 1
        for number, step in enumerate(steps):
            high = on_grid(z + step.width_mm)
            below = self.fillet_mm if web_below and number == 0 else 0.0
            above = self.fillet_mm if web_above and number == last else 0.0
            if step.main:
                self.mains.append((z + below, high - above, step.diameter_mm))
            edges += _profile(step, (z, high), (below, above))
            z = high
        self.parts.append(Revolved(_closed(edges, *(self.root_mm * w for w in (web_below, web_above)))))
        self.z_mm = z

    def web(self, outline: Outline, thick_mm: float, angle_rad: float) -> None:
        low, high = on_grid(self.z_mm), on_grid(self.z_mm + thick_mm)
        self.parts.append(Prism(rotated(outline, angle_rad), low, high))
        self.webs.append((low, high))
        self.z_mm = high

    def pin(
        self, radius_mm: float, angle_rad: float, diameter_mm: float, wide_mm: float, **ends: bool
    ) -> None:
        """Put a crankpin; ``below`` and ``above`` tell whether a web holds it there."""
        held = ends.get("below", True), ends.get("above", True)
        low, high = on_grid(self.z_mm), on_grid(self.z_mm + wide_mm)
        fillets = tuple(self.fillet_mm * each for each in held)
        edges = _profile(Step(diameter_mm, wide_mm), (low, high), (fillets[0], fillets[1]))
        centre = at(radius_mm, angle_rad)
        self.parts.append(Revolved(_closed(edges, *(self.root_mm * each for each in held)), centre))
        self.pins.append((*centre, low + fillets[0], high - fillets[1], diameter_mm))
        self.z_mm = high

    @property
    def shape(self) -> Shape:
        body = Joined(tuple(self.parts))
        return Without(body, tuple(self.tools)) if self.tools else body


def at(radius_mm: float, angle_rad: float) -> Point:
    return radius_mm * math.cos(angle_rad), radius_mm * math.sin(angle_rad)


def _profile(step: Step, z: tuple[float, float], fillets: tuple[float, float]) -> list[Line | Arc]:
    """Return the edges (r, z) of a cylinder, fillets at its ends, a taper or a thread."""
    (low, high), (below, above) = z, fillets
    radius = 0.5 * step.diameter_mm
    if step.thread:
        turns = max(3, round(step.width_mm / (0.12 * step.diameter_mm)))
        levels = np.linspace(low, high, 2 * turns + 1)
        inner = 0.9 * radius
        corners = [(radius if k % 2 == 0 else inner, float(level)) for k, level in enumerate(levels)]
        return [Line(a, b) for a, b in pairwise(corners)]
    edges: list[Line | Arc] = []
    if below > 0.0:
        edges.append(Arc((radius + below, low + below), below, 1.5 * math.pi, math.pi, FILLET_SHARE, 2))
    end = radius if step.end_mm is None else 0.5 * step.end_mm
    edges.append(Line((radius, low + below), (end, high - above)))
    if above > 0.0:
        edges.append(Arc((radius + above, high - above), above, math.pi, 0.5 * math.pi, FILLET_SHARE, 2))
    return edges


def _closed(edges: Sequence[Line | Arc], root_below: float, root_above: float) -> Outline:
    """Return a profile closed along the axis, its ends sunk into the webs beside it."""
    start, end = edges[0].start, edges[-1].end
    corners: list[Line | Arc] = []
    if root_below > 0.0:
        corners.append(Line((start[0], on_grid(start[1] - root_below)), start))
    for edge in edges:
        if corners and math.dist(corners[-1].end, edge.start) > 1e-9:
            corners.append(Line(corners[-1].end, edge.start))
        corners.append(edge)
    if root_above > 0.0:
        corners.append(Line(end, (end[0], on_grid(end[1] + root_above))))
    bottom, top = (0.0, corners[0].start[1]), (0.0, corners[-1].end[1])
    return (Line(bottom, corners[0].start), *corners, Line(corners[-1].end, top), Line(top, bottom))


# --- the crank's sizes -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sizes:
    """Sizes of a crank's parts [mm], and the outline of its webs: disc, pear, sector or bar."""

    radius: float
    main: float
    main_wide: float
    pin: float
    pin_wide: float
    web: float
    fillet: float
    outline: str

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Sizes:
        radius = float(np.exp(rng.uniform(*np.log(RADII_MM))))
        main, pin = radius * float(rng.uniform(0.7, 1.2)), radius * float(rng.uniform(0.6, 1.0))
        return cls(
            radius=round(radius, 2),
            main=round(main, 1),
            main_wide=round(main * float(rng.uniform(0.5, 0.9)), 1),
            pin=round(pin, 1),
            pin_wide=round(pin * float(rng.uniform(0.5, 0.9)), 1),
            web=round(radius * float(rng.uniform(0.3, 0.6)), 1),
            fillet=float(rng.choice([0.0, 0.0, 0.03])) * round(radius, 0),
            outline=str(rng.choice(["disc", "pear", "sector", "sector", "bar"])),
        )

    @property
    def web_outline(self) -> Outline:
        """The web's outline, its crankpin at +x."""
        return outline_of(self, self.outline)


def outline_of(sizes: Sizes, kind: str) -> Outline:
    pin_end = 0.5 * sizes.pin + sizes.fillet + 0.1 * sizes.radius
    hub = 0.5 * sizes.main + sizes.fillet + 0.12 * sizes.radius
    if abs(hub - pin_end) > 0.9 * sizes.radius:
        pin_end = hub = max(hub, pin_end)
    reach = sizes.radius + pin_end
    if kind == "disc":
        return circle(reach)
    if kind == "bar":
        half = max(hub, pin_end)
        return polygon([(-hub, -half), (reach, -half), (reach, half), (-hub, half)])
    web = DesignWeb(sizes.web, "pear", pin_end_radius_mm=pin_end, hub_radius_mm=hub)
    weight = DesignCounterweight(1.1 * reach, 110.0) if kind == "sector" else None
    return web_outline(web, sizes.radius, weight)


# --- ends, from the web outward ----------------------------------------------------------------------------

End = Callable[[Built, Sizes, np.random.Generator], list[Step]]


def _main(sizes: Sizes, wide: float | None = None) -> Step:
    return Step(sizes.main, sizes.main_wide if wide is None else wide * sizes.main, main=True)


def plain(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    return [_main(sizes)]


def seat_before_stub(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A bearing's seat, and a thinner and longer stub beyond it."""
    stub = Step(sizes.main * float(rng.uniform(0.78, 0.92)), sizes.main * float(rng.uniform(1.1, 1.8)))
    return [_main(sizes, float(rng.uniform(0.4, 0.7))), stub]


def collar(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A ring narrower than 0.15 of its diameter at the web, the seat behind it."""
    wide = sizes.main * float(rng.uniform(1.15, 1.35))
    return [Step(wide, wide * float(rng.uniform(0.06, 0.13))), _main(sizes)]


def undercut_ring(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A wider ring with an undercut behind it, before a seat as thick as the other mains."""
    wide = sizes.main * float(rng.uniform(1.2, 1.35))
    groove = Step(0.92 * sizes.main, 0.05 * sizes.main)
    return [Step(wide, wide * float(rng.uniform(0.17, 0.25))), groove, _main(sizes)]


def wide_shoulder(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A ring between 0.15 and 0.3 of its diameter at the web: what is meant stays open."""
    wide = sizes.main * float(rng.uniform(1.3, 1.55))
    return [Step(wide, wide * float(rng.uniform(0.18, 0.28))), _main(sizes, float(rng.uniform(0.45, 0.6)))]


def thrust_flange(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A thrust ring outside the journal, and a stub."""
    ring = Step(1.3 * sizes.main, 0.1 * sizes.main)
    return [_main(sizes), ring, Step(0.7 * sizes.main, 0.5 * sizes.main)]


def taper(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    small = 0.55 * sizes.main
    cone = Step(0.8 * sizes.main, 1.1 * sizes.main, end_mm=small)
    return [_main(sizes), cone, Step(0.9 * small, 0.4 * sizes.main, thread=bool(rng.random() < 0.5))]


def thread(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    return [
        _main(sizes),
        Step(0.85 * sizes.main, 0.4 * sizes.main),
        Step(0.8 * sizes.main, 0.7 * sizes.main, thread=True),
    ]


def snout(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A front main journal, and a longer snout thinner than it."""
    nose = Step(sizes.main * float(rng.uniform(0.45, 0.68)), sizes.main * float(rng.uniform(0.9, 1.5)))
    return [_main(sizes, float(rng.uniform(0.38, 0.5))), nose]


def flywheel_flange(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    flange = Step(sizes.main * float(rng.uniform(1.5, 1.9)), 0.2 * sizes.main)
    pilot = [Step(0.5 * sizes.main, 0.15 * sizes.main)] if rng.random() < 0.5 else []
    return [_main(sizes), flange, *pilot]


def gear(built: Built, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    """A journal, a gear cut from the solid, a stub; the gear is put on afterwards."""
    return [_main(sizes), Step(1.0 * sizes.main, 0.35 * sizes.main), Step(0.6 * sizes.main, 0.5 * sizes.main)]


ENDS: dict[str, End] = {
    "plain": plain,
    "seat before a stub": seat_before_stub,
    "collar": collar,
    "ring with an undercut": undercut_ring,
    "wide shoulder": wide_shoulder,
    "thrust flange": thrust_flange,
    "taper": taper,
    "thread": thread,
    "snout": snout,
    "snout with a keyway": snout,
    "flywheel flange": flywheel_flange,
    "gear": gear,
}


def _end(name: str, built: Built, sizes: Sizes, rng: np.random.Generator, first: bool) -> None:
    """Put an end of the crank: the first one below all webs, the other above them."""
    steps = ENDS[name](built, sizes, rng)
    start = built.z_mm
    order = steps[::-1] if first else steps
    if first:
        order = [replace(s, diameter_mm=s.end_mm, end_mm=s.diameter_mm) if s.end_mm else s for s in order]
    built.along_axis(order, web_below=not first, web_above=first)
    if name == "gear":
        places = np.cumsum([start, *(step.width_mm for step in order)])
        low, high = (on_grid(float(z)) for z in places[1:3])
        built.parts.append(Prism(_toothed(0.62 * sizes.main, 0.74 * sizes.main, 18), low, high))
    if name == "snout with a keyway":
        radius, deep = 0.5 * steps[-1].diameter_mm, 0.12 * steps[-1].diameter_mm
        far = start if first else built.z_mm
        inner = far + (1.0 if first else -1.0) * 0.5 * steps[-1].width_mm
        low, high = sorted((far + (-1.0 if first else 1.0), inner))
        half = 0.12 * steps[-1].diameter_mm
        slot = polygon(
            [(radius - deep, -half), (2.0 * radius, -half), (2.0 * radius, half), (radius - deep, half)]
        )
        built.tools.append(Prism(rotated(slot, float(rng.uniform(0.0, 6.0))), on_grid(low), on_grid(high)))
    if name == "flywheel flange":
        flange, where = steps[1], built.z_mm if not first else start
        low, high = sorted((where + (-4.0 if first else 4.0) * flange.diameter_mm, where))
        inside = sum(step.width_mm for step in steps[1:]) + 0.0
        low, high = (low, high + inside) if first else (low - inside, high)
        away = 0.5 * (0.5 * flange.diameter_mm + 0.5 * sizes.main)
        size = 0.3 * (0.5 * flange.diameter_mm - 0.5 * sizes.main)
        deep = on_grid(start + sum(s.width_mm for s in steps[1:])) if first else on_grid(built.z_mm - inside)
        ends = (on_grid(start - 1.0), deep) if first else (deep, on_grid(built.z_mm + 1.0))
        for number in range(6):
            built.tools.append(Prism(circle(size, at(away, number * math.pi / 3.0)), *ends))


def _toothed(root: float, tip: float, teeth: int) -> Outline:
    corners = []
    for number in range(teeth):
        for share, size in ((0.0, root), (0.3, tip), (0.5, tip), (0.8, root)):
            corners.append(at(size, (number + share) * 2.0 * math.pi / teeth))
    return polygon(corners)


# --- middles: one stretch between two throws --------------------------------------------------------------


def _middle(name: str, sizes: Sizes, rng: np.random.Generator) -> list[Step]:
    if name == "drive seat":
        seat = Step(
            sizes.main * float(rng.uniform(1.15, 1.4)), sizes.main_wide * float(rng.uniform(1.0, 1.6))
        )
        return [_main(sizes), seat] if rng.random() < 0.5 else [seat, _main(sizes)]
    if name == "collars both sides":
        ring = Step(1.2 * sizes.main, 0.08 * sizes.main)
        return [ring, _main(sizes), ring]
    if name == "unequal mains":
        return [replace(_main(sizes), diameter_mm=sizes.main * float(rng.choice([0.8, 1.15, 1.25])))]
    return [_main(sizes)]


# --- whole cranks ------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class OddCrank:
    """A crank with the truth of its construction.

    ``placement`` (4, 4) takes the construction's axes to the file's, a mirror included; ``open_width``: what
    a bore is the datum of has no width that a drawing states, so widths are not compared.
    """

    seed: int
    kind: str
    what: str
    built: Built
    segments: int
    unit: str
    step: bool
    placement: Array
    open_width: bool = False
    webs_compared: bool = True

    @property
    def shape(self) -> Shape:
        return self.built.shape

    def presented(self, placement: Array, unit: str) -> OddCrank:
        """Return the same crank as a mesh that is placed otherwise, in another unit."""
        return replace(self, placement=placement, unit=unit, step=False)

    def source(self) -> Source:
        """Return the crank as the program reads it from a file."""
        if self.step:
            from autobalance.solid.cad.brep import ExactSolid

            turned = Placed(self.shape, self.placement)
            return source_of_bytes(ExactSolid(turned).step(), "step", None)
        mesh = _placed(_facets(self.shape, self.segments), self.placement)
        soup = (mesh.corners / MM_PER[self.unit]).astype(np.float32)
        return source_of(soup, self.unit)

    def truth(self) -> Anatomy:
        """Return the true anatomy in the rotor frame of the crank as it is placed."""
        direction = self.placement[:3, 2]
        largest = np.abs(direction).max()
        decider = int(np.flatnonzero(np.abs(direction) >= largest - 1e-6)[0])
        up = direction[decider] > 0.0
        pins = sorted(self.built.pins, key=lambda pin: pin[2] + pin[3], reverse=not up)
        first = pins[0]
        arm = math.hypot(*first[:2])
        x = np.array([first[0] / arm, first[1] / arm, 0.0])
        z = np.array([0.0, 0.0, 1.0 if up else -1.0])
        turn = np.stack([x, np.cross(z, x), z])
        if (
            np.linalg.det(self.placement[:3, :3]) < 0.0
        ):  # the file's right-handed frame is a left-handed one here
            turn[1] = -turn[1]
        frame = np.eye(4)
        frame[:3, :3] = turn
        frame[:3, 3] = -turn @ np.array([0.0, 0.0, 0.5 * (first[2] + first[3])])
        throws = [self._throw(frame, pin, number) for number, pin in enumerate(pins, 1)]
        mains = sorted(self.built.mains, key=lambda each: each[0] + each[1], reverse=not up)
        journals = [
            MainJournal(_in(frame, (0.0, 0.0, 0.5 * (low + high))), size, high - low, number)
            for number, (low, high, size) in enumerate(mains, 1)
        ]
        webs = [
            Web(number, min(faces), max(faces), False)
            for number, web in enumerate(sorted(self.built.webs, reverse=not up), 1)
            for faces in [[float(_in(frame, (0.0, 0.0, height))[2]) for height in web]]
        ]
        to_rotor = frame @ np.linalg.inv(self.placement)
        return Anatomy(to_rotor, tuple(journals), tuple(throws), tuple(webs), 0.0)

    def _throw(self, frame: Array, pin: tuple[float, ...], number: int) -> Throw:
        x, y, low, high, size = pin
        centre = _in(frame, (x, y, 0.5 * (low + high)))
        angle = math.atan2(centre[1], centre[0]) % (2.0 * math.pi)
        angle = 0.0 if 2.0 * math.pi - angle < ANGLE_RAD else angle
        return Throw(number, math.hypot(x, y), angle, Pin(centre, size, high - low))


def _in(frame: Array, point: Sequence[float] | Array) -> Array:
    moved: Array = frame[:3, :3] @ np.asarray(point) + frame[:3, 3]
    return moved


@lru_cache(maxsize=32)
def _facets(shape: Shape, segments: int) -> Mesh:
    """Return the facets of a shape, which is looked at in several places."""
    return tessellated(shape, segments).mesh


def _placed(mesh: Mesh, placement: Array) -> Mesh:
    moved = mesh.moved(placement)
    return moved if np.linalg.det(placement[:3, :3]) > 0.0 else moved.flipped()


def _throws(
    built: Built,
    sizes: Sizes,
    rng: np.random.Generator,
    count: int,
    middle: str,
    ends: tuple[str, str],
    pair: Literal["", "split", "flying"] = "",
) -> None:
    """Put a whole crank: end, throws with a journal between them, end; ``pair``: two crankpins a throw."""
    step = {1: 0.0, 2: math.pi, 3: 2.0 * math.pi / 3.0, 4: 0.5 * math.pi}[count]
    start = float(rng.uniform(0.0, 2.0 * math.pi))
    odd = int(rng.integers(max(count - 1, 1)))
    _end(ends[0], built, sizes, rng, first=True)
    for number in range(count):
        angle = start + step * number
        built.web(sizes.web_outline, sizes.web, angle)
        if pair:
            _two_pins(built, sizes, rng, angle, pair)
        else:
            built.pin(sizes.radius, angle, sizes.pin, sizes.pin_wide)
            built.web(sizes.web_outline, sizes.web, angle)
        if number < count - 1:
            built.along_axis(_middle(middle if number == odd else "plain", sizes, rng), True, True)
    _end(ends[1], built, sizes, rng, first=False)


def _two_pins(built: Built, sizes: Sizes, rng: np.random.Generator, angle: float, pair: str) -> None:
    """Put two crankpins at angles of their own, with a flying web between them or without, and the web."""
    apart = math.radians(
        float(rng.choice([18.0, 30.0, 60.0, 90.0, 180.0] if pair == "flying" else [15.0, 22.0, 30.0]))
    )
    apart = (
        min(apart, 2.0 * math.asin(min(0.35 * sizes.pin / sizes.radius, 1.0))) if pair == "split" else apart
    )
    second = angle + apart
    built.pin(sizes.radius, angle, sizes.pin, sizes.pin_wide, above=pair == "flying")
    if pair == "flying":
        thin = 0.5 * sizes.web
        built.root_mm = min(built.root_mm, 0.4 * thin)
        built.web(circle(sizes.radius + 0.5 * sizes.pin + sizes.fillet + 3.0), thin, 0.0)
    built.pin(sizes.radius, second, sizes.pin, sizes.pin_wide, below=pair == "flying")
    built.web(sizes.web_outline, sizes.web, second)


def _inline(kind: str, sizes: Sizes, rng: np.random.Generator) -> tuple[Built, str]:
    """Return a crank of throws between journals, with the oddity of its kind."""
    built = Built(fillet_mm=sizes.fillet, root_mm=on_grid(0.4 * sizes.web))
    count = int(rng.choice([1, 2, 2, 3, 4]))
    quiet = ["plain", "plain", "flywheel flange", "snout", "taper", *ENDS]
    names = [str(rng.choice(quiet)), str(rng.choice(quiet))]
    middle, pair = "plain", ""
    if kind in ENDS:
        place = int(rng.integers(2))
        names[place] = kind
        if kind in ("seat before a stub", "wide shoulder", "collar") and rng.random() < 0.4:
            names[1 - place] = kind
        if kind == "ring with an undercut":  # that no ring is the journal is seen by the others
            count = max(count, 2)
    elif kind == "hollow":  # a bore of half the journal's diameter leaves no snout
        names = [name if name in ("plain", "collar", "thrust flange") else "plain" for name in names]
    elif kind in ("split pins", "flying webs"):
        pair, count = ("split" if kind == "split pins" else "flying"), min(count, 3)
    elif kind in ("drive seat", "collars both sides", "unequal mains"):
        middle, count = kind, max(count, 2)
    _throws(built, sizes, rng, count, middle, (names[0], names[1]), pair)  # type: ignore[arg-type]
    if kind == "hollow":
        _bored(built, sizes)
    return built, f"{count} throws, ends {names[0]}, {names[1]}, middle {middle}, webs {sizes.outline}"


def _bored(built: Built, sizes: Sizes) -> None:
    """Bore crankpins and main journals, through the webs beside them."""
    reach = sizes.web + FURTHER_BORE_MM
    for x, y, low, high, size in built.pins:
        built.tools.append(Prism(circle(0.28 * size, (x, y)), on_grid(low - reach), on_grid(high + reach)))
    room = sizes.radius - 0.5 * sizes.pin - 2.0
    size = min(0.25 * sizes.main, 0.8 * room)
    for low, high, _ in built.mains if size > 1.0 else []:
        built.tools.append(
            Prism(circle(size), on_grid(low - 1.5 * sizes.web), on_grid(high + 1.5 * sizes.web))
        )


def _through(kind: str, sizes: Sizes, rng: np.random.Generator) -> tuple[Built, str]:
    """Return a crank whose shaft runs straight through, its crankpins beside it between webs."""
    shaft = sizes.radius * float(rng.uniform(0.4, 0.7))
    pin = min(sizes.pin, 2.0 * (sizes.radius - 0.5 * shaft) - 6.0)
    sizes = replace(sizes, main=round(shaft, 1), pin=round(pin, 1), fillet=0.0)
    built = Built(root_mm=on_grid(0.4 * sizes.web))
    count = int(rng.choice([1, 1, 2, 3]))
    outline = outline_of(
        sizes, "disc" if kind == "through shaft, discs" else str(rng.choice(["pear", "bar"]))
    )
    start = float(rng.uniform(0.0, 2.0 * math.pi))
    ends = [sizes.main * float(rng.uniform(1.0, 2.5)) for _ in range(2)]
    built.z_mm = on_grid(ends[0])
    built.mains.append((0.0, built.z_mm, sizes.main))
    for number in range(count):
        angle = start + number * 2.0 * math.pi / count
        built.web(outline, sizes.web, angle)
        built.pin(sizes.radius, angle, sizes.pin, sizes.pin_wide)
        built.web(outline, sizes.web, angle)
        wide = ends[1] if number == count - 1 else sizes.main_wide
        built.mains.append((built.z_mm, on_grid(built.z_mm + wide), sizes.main))
        built.z_mm = on_grid(built.z_mm + wide)
    built.parts.append(Prism(circle(0.5 * sizes.main), 0.0, built.z_mm))
    return built, f"{count} throws"


def _eccentrics(kind: str, sizes: Sizes, rng: np.random.Generator) -> tuple[Built, str]:
    """Return eccentrics on a shaft: discs about it, or cylinders that stand beside its middle."""
    shaft = round(float(rng.uniform(8.0, 30.0)), 1)
    count = int(rng.choice([1, 2, 3, 3]))
    if kind == "eccentrics":
        radius = round(shaft * float(rng.uniform(0.12, 0.5)), 2)
        size = round(shaft + 2.0 * radius + shaft * float(rng.uniform(0.2, 0.8)), 1)
    else:
        size = round(shaft * float(rng.uniform(1.0, 1.6)), 1)
        radius = round(0.5 * (shaft + size) - 0.1 * shaft, 2)
    wide = round(size * float(rng.uniform(0.4, 1.4)), 1)
    built = Built()
    start = float(rng.uniform(0.0, 2.0 * math.pi))
    low = 0.0
    for number in range(count + 1):
        stretch = shaft * float(rng.uniform(0.8, 2.0))
        high = on_grid(low + stretch)
        built.mains.append((low, high, shaft))
        low = high
        if number < count:
            high = on_grid(low + wide)
            centre = at(radius, start + number * 2.0 * math.pi / count)
            built.parts.append(Prism(circle(0.5 * size, centre), low, high))
            built.pins.append((*centre, low, high, size))
            low = high
    built.parts.append(Prism(circle(0.5 * shaft), 0.0, low))
    return built, f"{count} eccentrics ⌀{size} at {radius} on ⌀{shaft}"


def _overhung(kind: str, sizes: Sizes, rng: np.random.Generator) -> tuple[Built, str]:
    """Return a shaft with a web at its end and a crankpin on it; or the web with a bore for the shaft."""
    built = Built(fillet_mm=0.0 if kind == "overhung arm" else sizes.fillet, root_mm=on_grid(0.4 * sizes.web))
    angle = float(rng.uniform(0.0, 2.0 * math.pi))
    if kind == "overhung arm":
        sizes = replace(sizes, fillet=0.0, outline=str(rng.choice(["pear", "sector", "bar"])))
        built.web(sizes.web_outline, sizes.web, angle)
        low, high = built.webs[0]
        bore = round(0.8 * sizes.main, 1)
        built.tools.append(Prism(circle(0.5 * bore), low - FURTHER_BORE_MM, high + FURTHER_BORE_MM))
        built.mains.append((low, high, bore))
        what = f"bore ⌀{bore}, web {sizes.outline}"
    else:
        beyond = (
            [Step(0.8 * sizes.main, sizes.main * float(rng.uniform(0.8, 1.6)))] if rng.random() < 0.5 else []
        )
        wide = Step(sizes.main, sizes.main * float(rng.uniform(1.0, 2.0)), main=True)
        built.along_axis([*beyond, wide], False, True)
        built.web(sizes.web_outline, sizes.web, angle)
        what = f"{len(beyond)} stubs, web {sizes.outline}"
    built.pin(sizes.radius, angle, sizes.pin, sizes.pin_wide, above=False)
    return built, what


def _single_web(kind: str, sizes: Sizes, rng: np.random.Generator) -> tuple[Built, str]:
    """Return one web of a built-up crank: a bore for the shaft, one for the crankpin."""
    sizes = replace(sizes, fillet=0.0, outline=str(rng.choice(["disc", "pear", "sector", "sector"])))
    built, angle = Built(), float(rng.uniform(0.0, 2.0 * math.pi))
    built.web(sizes.web_outline, sizes.web, angle)
    low, high = built.webs[0]
    shaft = min(0.8 * sizes.main, 1.1 * sizes.radius)
    pin = min(0.8 * sizes.pin, 2.0 * (sizes.radius - 0.5 * shaft) - 4.0)
    built.mains.append((low, high, round(shaft, 1)))
    built.pins.append((*at(sizes.radius, angle), low, high, round(pin, 1)))
    for centre, size in (((0.0, 0.0), round(shaft, 1)), (at(sizes.radius, angle), round(pin, 1))):
        built.tools.append(Prism(circle(0.5 * size, centre), low - FURTHER_BORE_MM, high + FURTHER_BORE_MM))
    return built, f"bores ⌀{shaft:.1f} and ⌀{pin:.1f}, web {sizes.outline}"


BUILDERS: dict[str, Callable[[str, Sizes, np.random.Generator], tuple[Built, str]]] = {
    **dict.fromkeys([name for name in ENDS if name != "plain"], _inline),
    **dict.fromkeys(
        ["drive seat", "collars both sides", "unequal mains", "split pins", "flying webs", "hollow"], _inline
    ),
    "through shaft, discs": _through,
    "through shaft, webs": _through,
    "eccentrics": _eccentrics,
    "eccentrics beside the shaft": _eccentrics,
    "overhung": _overhung,
    "overhung arm": _overhung,
    "single web": _single_web,
}
KINDS = tuple(BUILDERS)


def odd_crank(seed: int, kind: str | None = None) -> OddCrank:
    """Return the odd crank of a seed: of the kind that is its turn, or of the one asked for."""
    rng = np.random.default_rng(seed)
    name = KINDS[seed % len(KINDS)] if kind is None else kind
    built, what = BUILDERS[name](name, Sizes.drawn(rng), rng)
    placement = random_placement(rng, 200.0)
    mirrored = rng.random() < 1.0 / MIRRORED_EVERY
    if mirrored:
        placement = placement @ np.diag([-1.0, 1.0, 1.0, 1.0])
    step = bool(rng.random() < 1.0 / STEP_EVERY) and not mirrored
    return OddCrank(
        seed=seed,
        kind=name,
        what=what,
        built=built,
        segments=int(rng.choice(SEGMENTS)),
        unit=str(rng.choice(UNITS)),
        step=step,
        placement=placement,
        open_width=name in ("overhung arm", "single web"),
        webs_compared=not name.startswith("eccentrics"),
    )


# --- what came of it ---------------------------------------------------------------------------------------


def faults(odd: OddCrank, found: Anatomy) -> list[str]:
    """Return in what a recognised anatomy is not the true one: place, size and width of every part."""
    true = odd.truth()
    if not odd.webs_compared:
        found, true = replace(found, webs=()), replace(true, webs=())
    wrong = differences(found, true)
    for a, b in zip(found.throws, true.throws, strict=False):
        apart = math.remainder(a.angle_rad - b.angle_rad, 2.0 * math.pi)
        if abs(a.crank_radius_mm - b.crank_radius_mm) > 1e-3 * b.crank_radius_mm:
            wrong.append(f"crank radius {b.number} is {a.crank_radius_mm:.5g}, not {b.crank_radius_mm:.5g}")
        if abs(apart) > 1e-3:
            wrong.append(f"throw {b.number} is at {a.angle_deg:.5g}°, not {b.angle_deg:.5g}°")
    left_out = ["counterweight"] if not odd.open_width else ["counterweight", "width", " z is"]
    return [fault for fault in wrong if not any(each in fault for each in left_out)]


def named(odd: OddCrank, found: Anatomy) -> bool:
    """Return whether the doubts about an anatomy name all in which it is wrong."""
    true = odd.truth()
    across = true.file_to_rotor @ found.rotor_to_file
    about_axis = [doubt for doubt in found.doubts if doubt.about == "axis"]
    if about_axis:
        places = [_in(across, doubt.other.centre_mm) for doubt in about_axis]
        return any(math.hypot(*place[:2]) < AXIS_MM for place in places)
    journals = list(found.main_journals)
    if len(journals) != len(true.main_journals):
        return False
    for doubt in found.doubts:
        if doubt.about == "main_journal":
            chosen, meant, other = (
                journals[doubt.number - 1],
                true.main_journals[doubt.number - 1],
                doubt.other,
            )
            off = [abs(float(each.centre_mm[2] - meant.centre_mm[2])) for each in (chosen, other)]
            if off[1] < off[0]:
                journals[doubt.number - 1] = MainJournal(
                    other.centre_mm, other.diameter_mm, other.width_mm, doubt.number
                )
    return not faults(odd, replace(found, main_journals=tuple(journals)))


def outcome(odd: OddCrank, source: Source | None = None) -> tuple[Ending, str]:
    """Return what comes of recognising a crank, and a line on it."""
    try:
        source = source or odd.source()
        own = source.surfaces.cylinders if source.surfaces is not None else ()
        found = recognise(source.solid, Overrides(crankpin_in_file=None), own)
    except AutobalanceError as error:
        return "refused", str(error)
    wrong = faults(odd, found)
    if not wrong:
        return "right", f"{len(found.doubts)} doubts" if found.doubts else ""
    if named(odd, found):
        return "doubted", "; ".join(wrong[:3])
    return "WRONG", "; ".join(wrong[:4])
