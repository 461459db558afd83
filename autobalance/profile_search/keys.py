"""Every key of a DESIGN.toml beside those of the job that it starts from."""

from __future__ import annotations

from typing import Literal

from autobalance.declare import COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key, Range
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

DIAMETER = Key("diameter_mm", float, "its diameter", POSITIVE)
Z_MM = Key("z_mm", Pair, "from and to, along the axis")
THROW = Key("throw", int, "which throw", COUNTED)
PART_KEYS = (
    Key("webs", tuple[int, ...], "webs of one outline", COUNTED),
    Key("sector_deg", Pair, "free between these angles, from the web's crankpin"),
    Key("hold_radius_mm", float, "metal within stays", POSITIVE, None),
    Key("z_mm", Pair, "ends of one web along the axis", default=None, usual="the web's"),
    Key("thickness_mm", Pair, "smallest and largest thickness", default=None, usual="as it is"),
    Key("points", int, "number of points of the outline's spline", ENOUGH_POINTS, 12),
    Key("symmetric", bool, "whether the outline is symmetric about the crankpin's plane", default=False),
    Key("radius_mm", Pair, "smallest and largest radius of its points", default=None, usual="what fits"),
    Key("min_wall_mm", float, "minimum wall of the part, and around its holes", NOT_NEGATIVE, 3.0),
    Key("min_curvature_radius_mm", float, "smallest radius of curvature of the outline", NOT_NEGATIVE, 2.0),
    Key("draft_deg", float, "draft of its sides, for a forging", DRAFT, 0.0),
    Key("corner_radius_mm", float, "radius of the edges between sides and faces", NOT_NEGATIVE, 0.0),
    Key(
        "holes",
        says="lightening holes through it",
        keys=(Key("centre_mm", Pair, "in the web's own axes, from its crankpin"), DIAMETER),
        many=True,
        default=(),
    ),
    Key(
        "held_points",
        tuple[tuple[int, float], ...],
        "points, from 1, and the radius [mm] they keep",
        default=(),
    ),
    Key(
        "start_points_mm",
        Points,
        "points at the start of the search",
        default=None,
        usual="the outline as it is",
    ),
)
ENVELOPE_KEYS = (
    Key("radius_mm", float, "crankcase about the axis", POSITIVE, None),
    Key("z_mm", Pair, "crankcase along the axis", default=None),
    Key("clearance_mm", float, "clearance to all fixed and moving parts", NOT_NEGATIVE, 1.0),
    Key(
        "piston",
        says="a throw's piston",
        keys=(
            THROW,
            Key("skirt_below_pin_mm", float, "length of its skirt below the wrist pin"),
            Key("half_width_mm", float, "half the width of the skirt", POSITIVE),
            Z_MM,
        ),
        many=True,
        default=(),
    ),
    Key(
        "rod",
        says="a throw's connecting rod",
        keys=(
            THROW,
            Key("big_end_radius_mm", float, "outside radius of the big end", POSITIVE),
            Key("shank_half_width_mm", float, "half the width of the shank", POSITIVE),
            Z_MM,
        ),
        many=True,
        default=(),
    ),
    Key(
        "shaft",
        says="another shaft; round, or with an outline",
        keys=(
            Key("centre_mm", Pair, "position of its axis, rotor frame at crank angle 0"),
            Key("outline_mm", Points, "outline about its axis, three points or more", default=None),
            Key("radius_mm", float, "or its radius", POSITIVE, None),
            Key("ratio", float, "its speed over the crank's", default=-1.0),
            Key("phase_deg", float, "angle of its outline at crank angle 0", default=0.0),
            Z_MM,
        ),
        many=True,
        default=(),
    ),
)
DESIGN_KEYS = (
    Key(
        "counterweight",
        says="metal of some webs that is free",
        keys=PART_KEYS,
        many=True,
        missing="expected at least one",
    ),
    Key(
        "drilling",
        says="oil drillings that are kept open, rotor frame",
        keys=(Key("from_mm", Point, "one end"), Key("to_mm", Point, "the other end"), DIAMETER),
        many=True,
        default=(),
    ),
    Key(
        "target",
        says="limits that the design must keep",
        keys=(
            Key("polar_inertia_kg_mm2", Pair, "smallest and largest inertia about the axis", default=None),
            Key("mass_g", Pair, "smallest and largest mass", default=None),
        ),
        default=FILLED,
    ),
    Key("envelope", says="limits of free metal", keys=ENVELOPE_KEYS, default=FILLED),
    Key(
        "fem",
        says="limits on results of finite elements",
        keys=(
            Key("min_frequency_hz", float, "lowest natural frequency", POSITIVE, None),
            Key("max_stress_MPa", float, "largest stress", POSITIVE, None),
            Key("size_mm", float, "largest edge of the mesh", POSITIVE, None),
            Key("analyses", int, "how many designs are analysed in the search", FOUR, DEFAULT_ANALYSES),
        ),
        default=None,
    ),
    Key(
        "search",
        says="settings of the search",
        keys=(
            Key(
                "objectives",
                tuple[str, ...],
                "quantity to minimise, or with a minus before it to maximise: " + ", ".join(ALL_OBJECTIVES),
                default=("mass_g",),
            ),
            Key("evaluations", int, "designs that are tried", COUNTED, 3000),
            Key("method", Method, '`"cmaes"` takes one objective', default="nsga2"),
            Key("seed", int, "seed of the random numbers", NOT_NEGATIVE, 1),
            Key("population", int, "designs in a generation", FOUR, 40),
            Key("refine", bool, "the best are made better by gradients, their balance kept", default=True),
            Key("designs", int, "number of designs of a front that are written", COUNTED, 10),
        ),
        default=FILLED,
    ),
)
"""Every key of a DESIGN.toml beside those of the job it starts from."""


def design_keys() -> tuple[Key, ...]:
    """Return every key of a design file: the tables of the job that it starts from, and its own."""
    return (*(key for key in job_tables() if key.name in START_TABLES), *DESIGN_KEYS)
