"""The tables of a DESIGN.toml beside those of the job that it starts from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from autobalance.declare import (
    COUNTED,
    DEGREES,
    FILLED,
    NOT_NEGATIVE,
    POSITIVE,
    InFile,
    Key,
    Named,
    Range,
    keys_of,
)
from autobalance.job.tables import job_tables

Pair = tuple[float, float]
Point = tuple[float, float, float]
Points = tuple[Pair, ...]
Method = Literal["nsga2", "cmaes"]
OBJECTIVES = ("mass_g", "polar_inertia_kg_mm2")
ALL_OBJECTIVES = (*OBJECTIVES, "greatest_main_load_N", "greatest_stress_MPa")
DEFAULT_ANALYSES = 40
LEAST_POINTS = 4
ENOUGH_POINTS = Range(f"must be ≥ {LEAST_POINTS}: the spline is cubic", least=LEAST_POINTS)
FOUR = Range("must be ≥ 4", least=4)
DRAFT = Range("must be 0 to 30", least=0.0, most=30.0)
START_TABLES = ("crankshaft", "engine", "original", "balance", "cycle")
"""Tables of the job that a design starts from."""


@dataclass(frozen=True)
class Hole:
    """A lightening hole through free metal."""

    centre_mm: Annotated[Pair, "centre in the web's own axes, from its crankpin"]
    diameter_mm: Annotated[float, POSITIVE, "diameter"]


@dataclass(frozen=True)
class Drilling:
    """``[[drilling]]``: an oil drilling that is kept open through free metal, rotor frame."""

    from_mm: Annotated[Point, "one end"]
    to_mm: Annotated[Point, "the other end"]
    diameter_mm: Annotated[float, POSITIVE, "diameter"]


@dataclass(frozen=True)
class FreePart:
    """``[[counterweight]]``: the metal of some webs in a sector, beyond a radius.

    ``name`` is its place in the file, for messages. The sector's second angle is the greater one.
    """

    webs: Annotated[tuple[int, ...], COUNTED, "webs of one outline"]
    sector_rad: Annotated[Pair, DEGREES, "free between these angles, from the web's crankpin"]
    hold_radius_mm: Annotated[float | None, POSITIVE, "metal within stays"] = None
    z_mm: Annotated[Pair | None, InFile(usual="the web's"), "ends of one web along the axis"] = None
    thickness_mm: Annotated[Pair | None, InFile(usual="as it is"), "smallest and largest thickness"] = None
    points: Annotated[int, ENOUGH_POINTS, "number of points of the outline's spline"] = 12
    symmetric: Annotated[bool, "whether the outline is symmetric about the crankpin's plane"] = False
    radius_mm: Annotated[
        Pair | None, InFile(usual="what fits"), "smallest and largest radius of its points"
    ] = None
    min_wall_mm: Annotated[float, NOT_NEGATIVE, "minimum wall of the part, and around its holes"] = 3.0
    min_curvature_radius_mm: Annotated[float, NOT_NEGATIVE, "smallest radius of curvature of the outline"] = (
        2.0
    )
    draft_rad: Annotated[float, DEGREES, DRAFT, "draft of its sides, for a forging"] = 0.0
    corner_radius_mm: Annotated[float, NOT_NEGATIVE, "radius of the edges between sides and faces"] = 0.0
    holes: Annotated[tuple[Hole, ...], "lightening holes through it"] = ()
    held_points: Annotated[
        tuple[tuple[int, float], ...], "points, from 1, and the radius [mm] they keep"
    ] = ()
    start_points_mm: Annotated[
        Points | None, InFile(usual="the outline as it is"), "points at the start of the search"
    ] = None
    name: str = ""


@dataclass(frozen=True)
class PistonRoom:
    """``[[envelope.piston]]``: the skirt of a throw's piston."""

    throw: Annotated[int, COUNTED, "which throw"]
    skirt_below_pin_mm: Annotated[float, "length of its skirt below the wrist pin"]
    half_width_mm: Annotated[float, POSITIVE, "half the width of the skirt"]
    z_mm: Annotated[Pair, "first and last place along the axis"]


@dataclass(frozen=True)
class RodRoom:
    """``[[envelope.rod]]``: a throw's connecting rod."""

    throw: Annotated[int, COUNTED, "which throw"]
    big_end_radius_mm: Annotated[float, POSITIVE, "outside radius of the big end"]
    shank_half_width_mm: Annotated[float, POSITIVE, "half the width of the shank"]
    z_mm: Annotated[Pair, "first and last place along the axis"]


@dataclass(frozen=True, kw_only=True)
class ShaftRoom:
    """``[[envelope.shaft]]``: another shaft; ``outline_mm`` is None where it is round."""

    centre_mm: Annotated[Pair, "position of its axis, rotor frame at crank angle 0"]
    outline_mm: Annotated[Points | None, "outline about its axis, three points or more"] = None
    radius_mm: Annotated[float | None, POSITIVE, "or its radius"] = None
    ratio: Annotated[float, "speed divided by the crank speed"] = -1.0
    phase_rad: Annotated[float, DEGREES, "angle of its outline at crank angle 0"] = 0.0
    z_mm: Annotated[Pair, "first and last place along the axis"]


@dataclass(frozen=True)
class Envelope:
    """``[envelope]``: limits of space for free metal."""

    radius_mm: Annotated[float | None, POSITIVE, "crankcase about the axis"] = None
    z_mm: Annotated[Pair | None, "crankcase along the axis"] = None
    clearance_mm: Annotated[float, NOT_NEGATIVE, "clearance to all fixed and moving parts"] = 1.0
    pistons: Annotated[tuple[PistonRoom, ...], Named("piston"), "a throw's piston"] = ()
    rods: Annotated[tuple[RodRoom, ...], Named("rod"), "a throw's connecting rod"] = ()
    shafts: Annotated[tuple[ShaftRoom, ...], Named("shaft"), "another shaft; round, or with an outline"] = ()


@dataclass(frozen=True)
class Target:
    """``[target]``: ranges that the design must keep."""

    polar_inertia_kg_mm2: Annotated[Pair | None, "smallest and largest inertia about the axis"] = None
    mass_g: Annotated[Pair | None, "smallest and largest mass"] = None


@dataclass(frozen=True)
class FemLimits:
    """``[fem]``: limits on a design's finite-element results."""

    min_frequency_hz: Annotated[float | None, POSITIVE, "lowest natural frequency"] = None
    max_stress_MPa: Annotated[float | None, POSITIVE, "largest stress"] = None
    size_mm: Annotated[float | None, POSITIVE, "largest edge of the mesh"] = None
    analyses: Annotated[int, FOUR, "number of designs analysed in the search"] = DEFAULT_ANALYSES


@dataclass(frozen=True)
class SearchOptions:
    """``[search]``: how designs are searched."""

    objectives: Annotated[
        tuple[str, ...],
        "quantity to minimise, or with a minus before it to maximise: " + ", ".join(ALL_OBJECTIVES),
    ] = ("mass_g",)
    evaluations: Annotated[int, COUNTED, "designs that are tried"] = 3000
    method: Annotated[Method, '`"cmaes"` takes one objective'] = "nsga2"
    seed: Annotated[int, NOT_NEGATIVE, "seed of the random numbers"] = 1
    population: Annotated[int, FOUR, "designs in a generation"] = 40
    refine: Annotated[bool, "the best are made better by gradients, their balance kept"] = True
    designs: Annotated[int, COUNTED, "number of designs of a front that are written"] = 10


DESIGN_KEYS = (
    Key(
        "counterweight",
        says="metal of some webs that is free",
        keys=keys_of(FreePart),
        many=True,
        missing="expected at least one",
    ),
    Key(
        "drilling",
        says="oil drillings that are kept open, rotor frame",
        keys=keys_of(Drilling),
        many=True,
        default=(),
    ),
    Key("target", says="limits that the design must keep", keys=keys_of(Target), default=FILLED),
    Key("envelope", says="limits of free metal", keys=keys_of(Envelope), default=FILLED),
    Key("fem", says="limits on results of finite elements", keys=keys_of(FemLimits), default=None),
    Key("search", says="settings of the search", keys=keys_of(SearchOptions), default=FILLED),
)
"""Every key of a DESIGN.toml beside those of the job it starts from."""


def design_keys() -> tuple[Key, ...]:
    """Return every key of a design file: the tables of the job that it starts from, and its own."""
    return (*(key for key in job_tables() if key.name in START_TABLES), *DESIGN_KEYS)
