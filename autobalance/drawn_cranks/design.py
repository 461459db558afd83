"""Description of a crankshaft by its dimensions, the input of ``generate``, and the presets."""

from __future__ import annotations

import difflib
import math
from dataclasses import fields, is_dataclass, replace
from typing import Annotated, Any, Literal

from autobalance.declare import OMITTED, POSITIVE, Count, NotNegative, Positive, Range, Size
from autobalance.errors import JobError
from autobalance.units import STEEL_KG_M3
from autobalance.value_classes import dataclass

Ends = Literal["both", "first"]
WebOutline = Literal["pear", "disc"]
IfPositive = Annotated[float | None, POSITIVE, OMITTED]


@dataclass(frozen=True)
class DrawnShaft:
    """A main journal or crankpin; ``width_mm`` from web to web, fillets included."""

    diameter_mm: Positive
    width_mm: Positive
    bore_mm: NotNegative = 0.0


@dataclass(frozen=True)
class DesignWeb:
    """The arm between journal and crankpin.

    A ``pear`` is the convex hull of a disc of ``hub_radius_mm`` about the crank axis and one of
    ``pin_end_radius_mm`` about the crankpin; a ``disc`` lies about the crank axis.
    """

    thickness_mm: Positive
    outline: WebOutline = "pear"
    pin_end_radius_mm: IfPositive = None
    hub_radius_mm: IfPositive = None
    disc_radius_mm: IfPositive = None
    between_pins_mm: Positive = 8.0


@dataclass(frozen=True)
class DesignCounterweight:
    """A sector of a circle about the crank axis, opposite the crankpin.

    ``thickness_mm`` counts from the web's crankpin side. Thickness beyond the web's stands out on the journal
    side as a shoulder, from ``inner_radius_mm`` on; its straight edges lean by ``draft_deg``, so that it is
    narrower on top.
    """

    radius_mm: Positive
    fan_angle_deg: Annotated[float, Range(above=0, most=180)]
    thickness_mm: IfPositive = None
    inner_radius_mm: IfPositive = None
    draft_deg: NotNegative = 0.0


@dataclass(frozen=True)
class DesignNoseKeyway:
    """A slot along the nose, from its free end."""

    width_mm: Positive
    depth_mm: Positive
    length_mm: Positive


@dataclass(frozen=True)
class DesignNose:
    """The free end at the first main journal: a cylinder, or a taper down to ``end_diameter_mm``."""

    diameter_mm: Positive
    length_mm: Positive
    end_diameter_mm: IfPositive = None
    keyway: Annotated[DesignNoseKeyway | None, OMITTED] = None


@dataclass(frozen=True)
class DesignFlange:
    """The disc at the last main journal, with bolt holes."""

    diameter_mm: Positive
    thickness_mm: Positive
    bolts: Count = 0
    bolt_diameter_mm: NotNegative = 0.0
    bolt_circle_mm: NotNegative = 0.0


@dataclass(frozen=True)
class DesignBay:
    """Crankpins between two main journals: one, or several at separate angles.

    ``counterweights`` holds for its first and last web whether they carry one.
    """

    crankpins_deg: Annotated[tuple[float, ...], Size(1)] = (0.0,)
    counterweights: Annotated[tuple[bool, bool], Size(2, 2)] = (True, True)


@dataclass(frozen=True)
class Design:
    """A crankshaft by its dimensions.

    ``journals = "first"`` leaves the last main journal out: an overhung crank. With ``crankpin_in_file``
    false it is pressed up and drawn without its crankpins, with bores for them in the webs.
    """

    name: str
    stroke_mm: Positive
    main_journal: DrawnShaft
    crankpin: DrawnShaft
    web: DesignWeb
    bays: Annotated[tuple[DesignBay, ...], Size(1)]
    counterweight: Annotated[DesignCounterweight | None, OMITTED] = None
    end_journal_width_mm: IfPositive = None
    fillet_mm: NotNegative = 0.0
    oil_hole_mm: NotNegative = 0.0
    nose: Annotated[DesignNose | None, OMITTED] = None
    flange: Annotated[DesignFlange | None, OMITTED] = None
    journals: Ends = "both"
    crankpin_in_file: bool = True
    density_kg_m3: Positive = STEEL_KG_M3
    segments: Annotated[int, Range(least=8)] = 128

    @property
    def crank_radius_mm(self) -> float:
        """Half the stroke [mm]."""
        return self.stroke_mm / 2.0

    def __post_init__(self) -> None:
        """Refuse an impossible design with its first problem."""
        problems = _size_problems(self) or _fit_problems(self)
        if problems:
            raise JobError(problems[0])


LEAST_SEGMENTS, MOST_SEGMENTS = 8, 4096


def _size_problems(crank: Design) -> list[str]:
    problems = []
    for path, value in _numbers(crank, ""):
        if not math.isfinite(value) or (value < 0.0 and not path.startswith("bays.")):
            problems.append(f"{path} is {value:g}; must be finite and not negative")
    positive = {
        "stroke_mm": crank.stroke_mm,
        "density_kg_m3": crank.density_kg_m3,
        "main_journal.diameter_mm": crank.main_journal.diameter_mm,
        "main_journal.width_mm": crank.main_journal.width_mm,
        "crankpin.diameter_mm": crank.crankpin.diameter_mm,
        "crankpin.width_mm": crank.crankpin.width_mm,
        "web.thickness_mm": crank.web.thickness_mm,
    }
    if any(len(bay.crankpins_deg) > 1 for bay in crank.bays):
        positive["web.between_pins_mm"] = crank.web.between_pins_mm
    problems += [f"{path} is {value:g}; must be > 0" for path, value in positive.items() if not value > 0.0]
    if not LEAST_SEGMENTS <= crank.segments <= MOST_SEGMENTS:
        problems.append(f"segments is {crank.segments}; must be {LEAST_SEGMENTS} to {MOST_SEGMENTS}")
    if not crank.bays or not all(bay.crankpins_deg for bay in crank.bays):
        problems.append("bays is empty, or a bay has no crankpin; expected at least one of each")
    required = ("pin_end_radius_mm", "hub_radius_mm") if crank.web.outline == "pear" else ("disc_radius_mm",)
    problems += [
        f"web.{key} is needed for the outline {crank.web.outline!r}"
        for key in required
        if getattr(crank.web, key) is None
    ]
    if crank.flange is not None and crank.journals == "first":
        problems.append('flange: it stands on the last main journal, which journals = "first" leaves out')
    if not crank.crankpin_in_file and any(len(bay.crankpins_deg) > 1 for bay in crank.bays):
        problems.append("crankpin_in_file = false needs one crankpin in each bay")
    return problems


def _fit_problems(crank: Design) -> list[str]:
    """Return problems of webs too small for their pins, and of bores that leave no metal."""
    problems = []
    radius, web, fillet = crank.crank_radius_mm, crank.web, crank.fillet_mm
    pin, main = crank.crankpin.diameter_mm / 2.0 + fillet, crank.main_journal.diameter_mm / 2.0 + fillet
    if web.outline == "pear":
        pin_end, hub = float(web.pin_end_radius_mm or 0.0), float(web.hub_radius_mm or 0.0)
        if pin_end < pin:
            problems.append(f"web.pin_end_radius_mm is {pin_end:g}; crankpin and fillet need {pin:g}")
        if hub < main:
            problems.append(f"web.hub_radius_mm is {hub:g}; main journal and fillet need {main:g}")
        if radius <= abs(pin_end - hub):
            problems.append("web: one end of the pear lies inside the other; give outline = 'disc'")
    elif float(web.disc_radius_mm or 0.0) < max(radius + pin, main):
        problems.append(f"web.disc_radius_mm is {web.disc_radius_mm:g}; needs {max(radius + pin, main):g}")
    for name, shaft in (("main_journal", crank.main_journal), ("crankpin", crank.crankpin)):
        if shaft.bore_mm >= shaft.diameter_mm:
            problems.append(f"{name}.bore_mm is {shaft.bore_mm:g}; must be less than its diameter")
        if shaft.width_mm <= 2.0 * fillet:
            problems.append(f"{name}.width_mm is {shaft.width_mm:g}; two fillets leave no cylinder")
    bore = crank.main_journal.bore_mm
    if bore > 0.0 and bore / 2.0 >= radius - crank.crankpin.diameter_mm / 2.0:
        problems.append(f"main_journal.bore_mm is {bore:g}; it reaches into the crankpin")
    return problems + _counterweight_problems(crank)


def _counterweight_problems(crank: Design) -> list[str]:
    size, web = crank.counterweight, crank.web
    if size is None:
        return []
    problems = []
    if not 0.0 < size.fan_angle_deg <= 180.0:
        problems.append(f"counterweight.fan_angle_deg is {size.fan_angle_deg:g}; must be in 0..180")
    arm = float((web.hub_radius_mm if web.outline == "pear" else web.disc_radius_mm) or 0.0)
    if size.radius_mm <= arm:
        problems.append(f"counterweight.radius_mm is {size.radius_mm:g}; the web there has {arm:g} already")
    if size.thickness_mm is not None and size.thickness_mm < web.thickness_mm:
        problems.append(
            f"counterweight.thickness_mm is {size.thickness_mm:g}; at least the web's thickness is needed"
        )
    elif (
        size.thickness_mm is not None
        and 2.0 * (size.thickness_mm - web.thickness_mm) >= crank.main_journal.width_mm
    ):
        problems.append("counterweight.thickness_mm: its shoulder is as wide as the main journal")
    inner = crank.main_journal.diameter_mm / 2.0 + crank.fillet_mm
    if size.inner_radius_mm is not None and not inner < size.inner_radius_mm < size.radius_mm:
        problems.append(
            f"counterweight.inner_radius_mm is {size.inner_radius_mm:g}; "
            f"must be between {inner:g} and {size.radius_mm:g}"
        )
    if not 0.0 <= size.draft_deg < 45.0:
        problems.append(f"counterweight.draft_deg is {size.draft_deg:g}; must be in 0..45")
    return problems


def _numbers(value: Any, path: str) -> list[tuple[str, float]]:
    """Return every number in a description with its dotted name."""
    if is_dataclass(value):
        inner = [(item.name, getattr(value, item.name)) for item in fields(value)]
    elif isinstance(value, tuple):
        inner = [(str(i + 1), item) for i, item in enumerate(value)]
    else:
        return [(path, float(value))] if isinstance(value, int | float) else []
    return [
        numbers for key, item in inner for numbers in _numbers(item, f"{path}.{key}" if path else str(key))
    ]


# --- presets -----------------------------------------------------------------------------------------------
def preset(name: str) -> Design:
    """Return a bundled design.

    Raises
    ------
    JobError
        If there is none of that name.
    """
    if name not in PRESETS:
        close = difflib.get_close_matches(name, PRESETS, n=1)
        meant = f"did you mean {close[0]}? " if close else ""
        raise JobError(f"no preset is called {name!r}; {meant}expected one of {', '.join(PRESETS)}")
    return PRESETS[name]


def _bays(*angles_deg: float) -> tuple[DesignBay, ...]:
    return tuple(DesignBay((angle,)) for angle in angles_deg)


_SINGLE = Design(
    name="single",
    stroke_mm=58.0,
    main_journal=DrawnShaft(30.0, 26.0),
    crankpin=DrawnShaft(32.0, 24.0),
    web=DesignWeb(14.0, "pear", pin_end_radius_mm=20.0, hub_radius_mm=22.0),
    counterweight=DesignCounterweight(52.0, 130.0, thickness_mm=18.0, inner_radius_mm=26.0, draft_deg=10.0),
    bays=_bays(0.0),
    fillet_mm=2.0,
    oil_hole_mm=5.0,
    nose=DesignNose(26.0, 48.0, end_diameter_mm=20.0, keyway=DesignNoseKeyway(5.0, 3.0, 18.0)),
)
_PRESSED = Design(
    name="pressed-up-single",
    stroke_mm=53.8,
    main_journal=DrawnShaft(28.0, 24.0),
    crankpin=DrawnShaft(28.0, 16.0, bore_mm=18.0),
    web=DesignWeb(15.0, "disc", disc_radius_mm=48.0),
    counterweight=DesignCounterweight(51.5, 170.0, thickness_mm=18.0, inner_radius_mm=19.0, draft_deg=14.0),
    bays=_bays(0.0),
    end_journal_width_mm=30.0,
    nose=DesignNose(24.0, 40.0, end_diameter_mm=18.0, keyway=DesignNoseKeyway(4.0, 2.5, 14.0)),
)
_V_TWIN = Design(
    name="v-twin-45",
    stroke_mm=96.8,
    main_journal=DrawnShaft(38.0, 40.0),
    crankpin=DrawnShaft(38.0, 46.0, bore_mm=12.0),
    web=DesignWeb(24.0, "disc", disc_radius_mm=92.0),
    counterweight=DesignCounterweight(100.0, 150.0, thickness_mm=30.0, inner_radius_mm=34.0, draft_deg=7.0),
    bays=_bays(0.0),
    fillet_mm=1.5,
    nose=DesignNose(32.0, 50.0, end_diameter_mm=27.0, keyway=DesignNoseKeyway(6.0, 3.5, 20.0)),
)
_TWIN = Design(
    name="parallel-twin-360",
    stroke_mm=80.0,
    main_journal=DrawnShaft(44.0, 28.0),
    crankpin=DrawnShaft(40.0, 26.0),
    web=DesignWeb(17.0, "pear", pin_end_radius_mm=27.0, hub_radius_mm=31.0),
    counterweight=DesignCounterweight(66.0, 130.0),
    bays=_bays(0.0, 0.0),
    fillet_mm=2.5,
    oil_hole_mm=5.0,
    nose=DesignNose(34.0, 50.0, end_diameter_mm=28.0),
    flange=DesignFlange(76.0, 12.0, bolts=6, bolt_diameter_mm=8.5, bolt_circle_mm=58.0),
)
_INLINE = replace(
    _TWIN,
    name="inline-4",
    stroke_mm=86.0,
    main_journal=DrawnShaft(54.0, 27.0),
    crankpin=DrawnShaft(48.0, 25.0),
    web=DesignWeb(18.0, "pear", pin_end_radius_mm=31.0, hub_radius_mm=35.0),
    counterweight=DesignCounterweight(72.0, 120.0),
    bays=_bays(0.0, 180.0, 180.0, 0.0),
    fillet_mm=2.5,
    nose=DesignNose(38.0, 55.0, end_diameter_mm=32.0, keyway=DesignNoseKeyway(6.0, 3.5, 30.0)),
    flange=DesignFlange(90.0, 14.0, bolts=6, bolt_diameter_mm=10.5, bolt_circle_mm=70.0),
)
_V8 = replace(
    _INLINE,
    name="v8-crossplane",
    stroke_mm=88.4,
    main_journal=DrawnShaft(62.0, 27.0),
    crankpin=DrawnShaft(53.0, 47.0, bore_mm=20.0),
    web=DesignWeb(20.0, "pear", pin_end_radius_mm=34.0, hub_radius_mm=39.0),
    counterweight=DesignCounterweight(86.0, 130.0),
    bays=_bays(0.0, 90.0, 270.0, 180.0),
    flange=DesignFlange(104.0, 14.0, bolts=8, bolt_diameter_mm=10.5, bolt_circle_mm=84.0),
)
_V6 = replace(
    _INLINE,
    name="v6-60",
    main_journal=DrawnShaft(64.0, 27.0),
    crankpin=DrawnShaft(52.0, 23.0),
    web=DesignWeb(16.0, "pear", pin_end_radius_mm=34.0, hub_radius_mm=40.0, between_pins_mm=8.0),
    counterweight=DesignCounterweight(80.0, 120.0),
    flange=DesignFlange(104.0, 14.0, bolts=8, bolt_diameter_mm=10.5, bolt_circle_mm=84.0),
    bays=tuple(DesignBay((base, base + 60.0)) for base in (0.0, 240.0, 120.0)),
)
PRESETS: dict[str, Design] = {
    crank.name: crank
    for crank in (
        _SINGLE,
        _PRESSED,
        replace(_PRESSED, name="pressed-up-single-no-pin", crankpin_in_file=False),
        _V_TWIN,
        _TWIN,
        replace(_INLINE, name="inline-3", bays=_bays(0.0, 240.0, 120.0)),
        _INLINE,
        replace(_INLINE, name="inline-6", bays=_bays(0.0, 240.0, 120.0, 120.0, 240.0, 0.0)),
        _V6,
        _V8,
        replace(_V8, name="v8-flatplane", bays=_bays(0.0, 180.0, 180.0, 0.0)),
        replace(_V8, name="v12-60", bays=_bays(0.0, 240.0, 120.0, 120.0, 240.0, 0.0)),
    )
}
"""The bundled designs by name."""
