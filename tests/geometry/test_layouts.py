"""Every kind on cranks of every layout: what is planned is what is cut, and it is within tolerance."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from autobalance import correction
from autobalance.balancing.loop import Result, balance
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import Limits
from autobalance.correction.add import AddLimits
from autobalance.correction.contract import Correction
from autobalance.correction.faces.cut import part_name
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.correction.holes.surface import Axis
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.correction.turn import TurnLimits
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.crank.faces import find_faces
from autobalance.drawn_cranks.design import PRESETS
from autobalance.rigid_rotor.tolerance import Judge, Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.cranks import Shape, make_crank, planned_crank, tilted
from tests.generated import AT_OTHER_ANGLES, generated_crank
from tests.geometry.test_add import web_face
from tests.sweeps import SWEPT, seeds

STEEL = 7.85e-3
PLANNED_METAL = 2e-6
"""Share of the volume by which cut and planned metal may differ."""
BEFORE_STEPS = 0.02
"""Share of the permissible value that a plan with free depths leaves at most, once cut and measured."""
LAYOUTS = {
    "single": (0.0,),
    "inline-3": (0.0, 240.0, 120.0),
    "inline-4": (0.0, 180.0, 180.0, 0.0),
    "inline-6": (0.0, 240.0, 120.0, 120.0, 240.0, 0.0),
    "v8": (0.0, 90.0, 270.0, 180.0),
}
MIRRORED = {"v6": (0.0, 120.0, 240.0), "v12": (0.0, 120.0, 240.0, 240.0, 120.0, 0.0)}
"""Layouts that are those of inline engines the other way round: in sweeps only."""
if SWEPT:
    LAYOUTS |= MIRRORED
GENERATED = [name for name in PRESETS if SWEPT or name not in AT_OTHER_ANGLES]
COARSE = Shape(segments=32)
SLUGS = SlugLimits(diameters_mm=(10.0, 18.0), lengths_mm=(5.0, 8.0, 11.0), max_slugs=8)


def web_faces(solid: Solid, anatomy: Anatomy) -> tuple[Face, ...]:
    return tuple(
        replace(web_face(solid, anatomy, web.number, side), id=f"w{web.number}-{'ab'[side]}")
        for web in anatomy.webs
        for side in (0, 1)
    )


def tolerance(solid: Solid, anatomy: Anatomy, judge: Judge = "dynamic", grade: float = 6.3) -> Tolerance:
    moments = solid.moments(STEEL, anatomy.file_to_rotor)
    first, last = anatomy.main_journals[0], anatomy.main_journals[-1]
    return Tolerance.of(
        grade_mm_s=grade,
        service_speed_rad_s=700.0,
        rotor_mass_g=moments.mass_g,
        z_centre_mm=float(moments.centre_mm[2]),
        planes_z_mm=(float(first.centre_mm[2]), float(last.centre_mm[2])),
        judge=judge,
    )


def rotor_with(solid: Solid, anatomy: Anatomy, wanted: Unbalance, faces: tuple[Face, ...] = ()) -> Rotor:
    """Return the crank with loads that leave just the unbalance wanted."""
    z = anatomy.webs[0].z_min_mm, anatomy.webs[-1].z_max_mm
    missing = wanted - Unbalance.of(solid.moments(STEEL, anatomy.file_to_rotor))
    a, b = missing.in_planes(*z)
    loads = Moments.point(1.0, np.array([*a, z[0]])) + Moments.point(1.0, np.array([*b, z[1]]))
    return Rotor(
        solid, solid.moments(STEEL, anatomy.file_to_rotor), STEEL, anatomy, faces, loads, Moments.zero(), 0.5
    )


def at_end_webs(anatomy: Anatomy, a: Sequence[float], b: Sequence[float]) -> Unbalance:
    return Unbalance.of_planes(np.array([a, b]), anatomy.webs[0].z_min_mm, anatomy.webs[-1].z_max_mm)


def on_counterweights(anatomy: Anatomy, size: float) -> Unbalance:
    """Too much counterweight at both ends, each a few degrees off its throw's line."""
    first, last = anatomy.throws[0].direction, anatomy.throws[-1].direction
    return at_end_webs(
        anatomy, turned(-size * first, 0.1).tolist(), turned(-0.7 * size * last, -0.08).tolist()
    )


def turned(vector: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]]) @ vector


def assert_only_the_plan_is_gone(rotor: Rotor, result: Result) -> None:
    solid = rotor.solid
    assert result.solid is not None
    slack = PLANNED_METAL * solid.volume_mm3
    adds = sum(-c.removed_volume_mm3 for c in result.corrections if c.kind == "add")
    left = (solid & result.solid).volume_mm3
    gone, new = solid.volume_mm3 - left, result.solid.volume_mm3 - left
    planned = sum(c.removed_volume_mm3 for c in result.corrections if c.kind != "add")
    assert new == pytest.approx(adds, abs=slack)
    assert gone == pytest.approx(planned, abs=slack)
    assert len(result.solid.pieces()) == len(solid.pieces())


ONE_KIND = {"drill": DrillLimits(diameters_mm=(10.0,)), "shoulder": ShoulderLimits(), "add": AddLimits()}
EITHER = {"inline-3": "shoulder", "inline-4": "add", "inline-6": "shoulder", "v8": "add"}
"""Of the two kinds that begin at faces, the one tried on a layout of several throws, but for sweeps."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "layout"),
    [
        (kind, layout)
        for kind, layout in product(ONE_KIND, LAYOUTS)
        if SWEPT or kind == "drill" or kind == EITHER.get(layout, kind)
    ],
)
def test_every_layout_in_two_planes(kind: str, layout: str) -> None:
    limits = ONE_KIND[kind]
    solid, anatomy = make_crank(LAYOUTS[layout], COARSE, tilted(0.7, [100.0, -50.0, 30.0]))
    rotor = rotor_with(solid, anatomy, on_counterweights(anatomy, 500.0), web_faces(solid, anatomy))
    judge = tolerance(solid, anatomy)
    result = balance(rotor, judge, [limits], advise=False)
    assert result.outcome == "within_tolerance"
    stepped = isinstance(limits, DrillLimits)
    assert judge.used_share(result.residual) <= (0.5 if stepped else BEFORE_STEPS)
    assert_only_the_plan_is_gone(rotor, result)
    assert {c.kind for c in result.corrections} == {"drill" if stepped else result.corrections[0].kind}


@pytest.mark.slow
def test_a_pure_couple_is_seen_and_drilled_away() -> None:
    solid, anatomy = make_crank(LAYOUTS["inline-4"], COARSE)
    rotor = rotor_with(solid, anatomy, at_end_webs(anatomy, [-400.0, 0.0], [400.0, 0.0]))
    judge = tolerance(solid, anatomy)
    assert judge.permissible_g_mm > 0.0
    result = balance(rotor, judge, [DrillLimits(diameters_mm=(8.0, 10.0))], advise=False)
    assert result.initial.magnitude_g_mm < 1e-6
    assert result.outcome == "within_tolerance"
    assert result.steps
    static = balance(rotor, tolerance(solid, anatomy, "static"), [DrillLimits()])
    assert static.outcome == "already_within_tolerance"


def test_a_transverse_part_is_drilled_off_centre() -> None:
    """Symmetric faces act along the throw's line only; holes reach across it."""
    solid, anatomy = make_crank([0.0], COARSE)
    rotor = rotor_with(solid, anatomy, at_end_webs(anatomy, [-500.0, 200.0], [-500.0, 200.0]))
    judge = tolerance(solid, anatomy)
    result = balance(rotor, judge, [DrillLimits()], advise=False)
    assert result.outcome == "within_tolerance"
    angles = [c.details["angle_deg"] for c in result.corrections]
    assert min(angles) < 175.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "methods",
    [
        [SLUGS],
        [SLUGS, DrillLimits(diameters_mm=(8.0, 10.0))],
        [TurnLimits(), DrillLimits(diameters_mm=(8.0, 10.0))],
        [ShoulderLimits(), DrillLimits(diameters_mm=(8.0, 10.0))],
        [ShoulderLimits(), TurnLimits()],
    ],
    ids=lambda methods: "+".join(type(limits).__name__.removesuffix("Limits").lower() for limits in methods),
)
def test_mixes(methods: list[Limits]) -> None:
    solid, anatomy = planned_crank(replace(COARSE, web_width=24.0), 90.0)
    size = -900.0 if methods == [SLUGS] else 900.0  # slugs alone make a light counterweight heavier
    rotor = rotor_with(solid, anatomy, on_counterweights(anatomy, size), web_faces(solid, anatomy))
    grade = 40.0 if methods == [SLUGS] else 6.3  # slugs come in whole sizes only
    result = balance(rotor, tolerance(solid, anatomy, grade=grade), methods, advise=False)
    assert result.outcome == "within_tolerance"
    assert_only_the_plan_is_gone(rotor, result)
    slugs = sum((c.details["slug_mass_g"] for c in result.corrections if c.kind == "slug"), 0.0)
    assert result.solid is not None
    bare = result.solid.moments(STEEL, anatomy.file_to_rotor)
    assert result.final_moments.mass_g == pytest.approx(bare.mass_g + slugs, abs=1e-6)
    kinds: dict[int | None, set[str]] = {}
    for c in result.corrections:
        kinds.setdefault(c.web, set()).add("bore" if c.kind in ("drill", "slug") else c.kind)
    assert all(len(of_web) == 1 for of_web in kinds.values())


def offer_of(rotor: Rotor, limits: Limits) -> Candidates:
    some = (0.0, np.array([-1.0, 0.0])), (1.0, np.array([-1.0, 0.0]))
    work = Workpiece(rotor.solid, rotor.anatomy, rotor.faces, STEEL, some)
    return correction.offer(work, limits, 0)


def some_feasible_unbalance(candidates: Candidates, rng: np.random.Generator) -> Unbalance:
    """Return what some of the cuts at hand, at depths of their own, would take away exactly."""
    free = set(range(len(candidates.cuts)))
    total = Unbalance(np.zeros(2), np.zeros(2))
    for _ in range(int(rng.integers(4, 9))):
        if not free:
            break
        k = int(rng.choice(sorted(free)))
        cut = candidates.cuts[k]
        depth = rng.uniform(cut.least_depth_mm, cut.max_depth_mm)
        total = total - Unbalance.of(cut.effect(float(depth)))
        near = {pair.second for pair in candidates.apart if pair.first == k}
        near |= {pair.first for pair in candidates.apart if pair.second == k}
        free -= near | {k}
    return total


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(len(GENERATED), 3 * len(GENERATED)))
def test_generated_cranks(seed: int) -> None:
    """Every layout that can be generated, anywhere in space, with an unbalance that holes can take away."""
    rng = np.random.default_rng(seed)
    crank = generated_crank(
        GENERATED[seed % len(GENERATED)], seed=seed, segments=int(rng.choice([16, 24, 37]))
    )
    solid, anatomy = crank.solid, crank.truth
    diameters = ((6.0,), (7.0,), (6.0, 8.0))[seed % 3]
    limits = DrillLimits(diameters_mm=diameters, depth_step_mm=0.0, min_wall_mm=2.0)
    bare = rotor_with(solid, anatomy, Unbalance(np.zeros(2), np.zeros(2)))
    rotor = rotor_with(solid, anatomy, some_feasible_unbalance(offer_of(bare, limits), rng))
    judge = tolerance(solid, anatomy)
    if seed % 2 or SWEPT:
        exact = balance(rotor, judge, [limits], advise=False)
        assert exact.outcome == "within_tolerance"
        assert judge.used_share(exact.residual) <= BEFORE_STEPS
        assert_only_the_plan_is_gone(rotor, exact)
    if not seed % 2 or SWEPT:
        stepped = balance(rotor, judge, [replace(limits, depth_step_mm=0.1)], advise=False)
        assert stepped.outcome == "within_tolerance"
        assert_only_the_plan_is_gone(rotor, stepped)
        for c in stepped.corrections:
            assert c.depth_mm / 0.1 == pytest.approx(round(c.depth_mm / 0.1), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(6, 12))
def test_random_limits_are_never_violated(seed: int) -> None:
    """Walls are measured anew, as the least distance between inflated holes and all the crank's metal."""
    rng = np.random.default_rng(100 + seed)
    layouts = [LAYOUTS[name] for name in ("single", "single", "inline-3", "inline-4")]
    solid, anatomy = make_crank(layouts[seed % 4], COARSE)
    start = float(rng.uniform(0.0, 360.0))
    limits = DrillLimits(
        direction=("radial", "axial")[seed % 2],
        diameters_mm=tuple(rng.uniform(5.0, 9.0, 2).round(1).tolist()),
        point_angle_deg=float(rng.choice([90.0, 118.0, 140.0, 180.0])),
        min_depth_mm=float(rng.uniform(1.0, 3.0)),
        max_depth_mm=float(rng.uniform(6.0, 25.0)),
        depth_step_mm=float(rng.choice([0.0, 0.1, 0.25])),
        max_holes=int(rng.integers(1, 6)),
        min_wall_mm=float(rng.uniform(1.0, 4.0)),
        min_spacing_mm=float(rng.uniform(1.0, 6.0)),
        sectors_deg=((start, start + 300.0),),
    )
    rotor = rotor_with(solid, anatomy, on_counterweights(anatomy, 400.0))
    result = balance(rotor, tolerance(solid, anatomy), [limits], advise=False)
    for web in anatomy.webs:
        assert sum(c.web == web.number for c in result.corrections) <= limits.max_holes
    spaced: list[Solid] = []
    for c in result.corrections:
        assert limits.min_depth_mm - 1e-9 <= c.depth_mm <= limits.max_depth_mm + 1e-9
        assert (c.details["angle_deg"] - start) % 360.0 <= 300.0 + 1e-6
        assert c.details["wall_left_mm"] >= limits.min_wall_mm - 2e-3
        inner = inflated(c, limits.point_angle_deg, limits.min_wall_mm, below_mouth=True)
        if inner is not None:
            assert (inner.moved(anatomy.rotor_to_file) - solid).volume_mm3 < 1e-6 * inner.volume_mm3
        grown = inflated(c, limits.point_angle_deg, 0.5 * limits.min_spacing_mm, below_mouth=False)
        assert grown is not None
        assert all((grown & other).volume_mm3 < 1e-6 for other in spaced)
        spaced.append(grown)


GRAIN_MM = 0.005


def inflated(c: Correction, point_deg: float, by_mm: float, below_mouth: bool) -> Solid | None:
    """Return the points within (just less than) a distance of a hole; below its mouth only, or from it on.

    The mouth may be slanted by 40° and curved; so deep that no part of it reaches, all must be metal.
    """
    a, by = 0.5 * c.details["diameter_mm"], by_mm - GRAIN_MM
    half = math.radians(0.5 * point_deg)
    top = 1.1 * (a + by) if below_mouth else 0.0
    if top >= c.depth_mm:
        return None
    around = np.linspace(0.0, 0.5 * math.pi - half, 9)
    edge = [(a + by * math.cos(t), c.depth_mm + by * math.sin(t)) for t in around]
    around = np.linspace(0.5 * math.pi - half, 0.5 * math.pi, 9)
    tip_mm = c.depth_mm + a / math.tan(half)
    tip = [(by * math.cos(t), tip_mm + by * math.sin(t)) for t in around]
    outline = [(0.0, top), (a + by, top), *edge, *tip[:-1], (0.0, tip_mm + by)]
    body = Solid.revolved(np.array(outline), 96)
    return body.moved(Axis(c.position_mm, np.array(c.details["inward"])).placement)


def test_a_face_has_one_depth_where_that_is_enough_and_its_parts_have_names() -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0, segments=32))
    wanted = at_end_webs(anatomy, [-400.0, 0.0], [-400.0, 0.0])
    rotor = rotor_with(solid, anatomy, wanted, find_faces(solid.mesh, anatomy))
    result = balance(rotor, tolerance(solid, anatomy), [ShoulderLimits()])
    assert result.outcome == "within_tolerance"
    assert [cut.face for cut in result.corrections] == ["w1-a", "w2-b"]
    assert {part_name(cut.details["sector_deg"]) for cut in result.corrections} == {""}
    assert part_name([60.6, 150.6]) == ", its part from 60.6° to 150.6°"
