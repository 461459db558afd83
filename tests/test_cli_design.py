"""The command ``design``: profiles searched, the balance met exactly by what is written."""

from __future__ import annotations

import json
import pickle
import tomllib
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.balancing.measured_crank import measure_crank
from autobalance.command import main
from autobalance.declare import encoded
from autobalance.errors import FileError, JobError
from autobalance.finite_elements.throws import bodies_of_solid
from autobalance.profile_search import strength
from autobalance.profile_search import written as solids
from autobalance.profile_search.answer import SearchFigures, infeasible_reason, remedies, step_notes
from autobalance.profile_search.candidates import (
    JudgedDesign,
    SearchResult,
    chosen,
    front,
    judged,
    with_refined,
)
from autobalance.profile_search.envelope import Amounts
from autobalance.profile_search.free_metal import FreeMetal, free_metal
from autobalance.profile_search.input import load_design
from autobalance.profile_search.level_sets import CLOSENESS_STEPS, begun, level_set_for_balance, level_sets
from autobalance.profile_search.problem import MAX_SHARE, Problem
from autobalance.profile_search.search import Generation, judged_start, searched
from autobalance.profile_search.verb import design
from autobalance.profile_search.written import design_step, free_body, with_profiles
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.runtime import Stopwatch
from autobalance.solid.cad import installed
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.files import read_step_file
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.studies.workers import Done, Work
from tests.coarse import roughen
from tests.cranks import Shape, make_crank
from tests.watched import calls_of

pytestmark = pytest.mark.usefixtures("cranks_read_once")

DESIGN = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine]
rod_length_mm = 115.0
[engine.rotating_g]
rod = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 9000
[[counterweight]]
webs = [1, 2]
sector_deg = [110, 250]
points = 7
hold_radius_mm = 29.0
symmetric = true
[envelope]
radius_mm = 64.0
piston = [{ throw = 1, skirt_below_pin_mm = 18.0, half_width_mm = 30.0, z_mm = [-30, 30] }]
[search]
objectives = ["mass_g", "polar_inertia_kg_mm2"]
evaluations = 36
population = 12
designs = 2
"""
CIRCLE = (
    DESIGN.replace("110, 250", "125, 235")
    .replace("points = 7", "points = 11")
    .replace("symmetric = true", "symmetric = true\nradius_mm = [29, 80]")
)
CIRCLE = CIRCLE[: CIRCLE.index("[envelope]")] + (
    '[search]\nobjectives = ["polar_inertia_kg_mm2"]\nevaluations = 12\npopulation = 6\n'
)


@pytest.fixture(scope="module")
def crank() -> bytes:
    return drawn(24)


@pytest.fixture(scope="module")
def rounder() -> bytes:
    """A crank whose circles are round enough to measure."""
    return drawn(48)


def drawn(segments: int) -> bytes:
    solid, _ = make_crank([0.0], Shape(segments=segments))
    return encode(solid.mesh, "stl", 1.0)


@pytest.fixture(scope="module", autouse=True)
def rough_plot() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        roughen(patch)
        yield


def written(folder: Path, text: str, crank: bytes) -> str:
    (folder / "crank.stl").write_bytes(crank)
    (folder / "design.toml").write_text(text, "utf-8")
    return str(folder / "design.toml")


def problem_of(folder: Path, text: str, crank: bytes) -> Problem:
    job = load_design(Path(written(folder, text, crank)))
    measured = measure_crank(job.start.crankshaft, Stopwatch())
    return Problem.of(job, measured, free_metal(job, measured))


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, crank: bytes) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("design")
    return folder, design(written(folder, DESIGN, crank), folder / "out", workers=1).report


def test_what_is_written_meets_the_balance(
    found: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, report = found
    assert report["outcome"] == "found"
    for each in report["designs"]:
        assert each["residual"]["worst_share"] <= 0.01
        assert all(constraint["margin"] >= 0.0 for constraint in each["constraints"])
        job = folder / "out" / "designs" / each["id"] / "job.toml"
        capsys.readouterr()
        assert main(["balance", str(job), "-o", str(folder / each["id"]), "--no-report", "--json", "-"]) == 0
        balanced = json.loads(capsys.readouterr().out)
        assert balanced["outcome"] == "already_within_tolerance"
        assert balanced["crank"]["mass_g"] == pytest.approx(each["objectives"]["mass_g"], rel=1e-9)
    best = report["designs"][[each["id"] for each in report["designs"]].index(report["best"]["mass_g"])]
    assert best["objectives"]["mass_g"] < report["start"]["objectives"]["mass_g"] - 20.0
    assert set(report["front"]) <= {each["id"] for each in report["designs"]}
    assert (folder / "out" / "front.svg").stat().st_size > 0
    assert (folder / "out" / "designs" / report["front"][0] / "picture.png").stat().st_size > 0


def test_the_step_file_has_spline_surfaces_and_the_same_balance(found: tuple[Path, dict[str, Any]]) -> None:
    folder, report = found
    best = report["designs"][0]
    job = tomllib.loads((folder / "out" / "designs" / best["id"] / "job.toml").read_text("utf-8"))
    step = folder / "out" / "designs" / best["id"] / "crank.step"
    assert sum(1 for line in step.read_text("utf-8").splitlines() if "B_SPLINE_CURVE" in line) >= 4
    source = read(step, None, "all")
    problem = problem_of(folder, DESIGN, (folder / "crank.stl").read_bytes())
    density = 1e-6 * job["crankshaft"]["density_kg_m3"]
    moments = source.moments(density, problem.crank.anatomy.file_to_rotor)
    residual = problem.residual(moments)
    assert problem.tolerance(moments).used_share(residual) <= 0.01
    assert moments.mass_g == pytest.approx(best["objectives"]["mass_g"], rel=5e-6)
    assert report["notes"] == []


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("counterweights.step", "finds fault with the facets of the held metal"),
        ("crank.stl", "autobalance[step]"),
    ],
)
def test_why_there_is_no_whole_step_file_is_said(file: str, said: str) -> None:
    (note,) = step_notes([file])
    assert said in note


def held_error(free: FreeMetal, solid: Solid, amounts: Amounts) -> float:
    """Return the change of the held volume in a design's solid, as a share."""
    added = Solid.nothing()
    for web in free.webs:
        part = web.part
        added = added + free_body(free, web, amounts.radii_mm[part], amounts.thickness_mm[part])
    return (solid - free.region - added).volume_mm3 / free.held.volume_mm3 - 1.0


def test_held_metal_is_found_again(tmp_path: Path, crank: bytes) -> None:
    problem = problem_of(tmp_path, DESIGN, crank)
    free = problem.free
    for radius in (33.0, 60.0):
        amounts = Amounts((np.full(7, radius),), (None,))
        solid = with_profiles(free, amounts.radii_mm, amounts.thickness_mm)
        assert abs(held_error(free, solid, amounts)) < 1e-6
        area = free.profiles[0].moments(np.full(7, radius))[0].area_mm2
        assert solid.volume_mm3 == pytest.approx(free.held.volume_mm3 + 2.0 * 18.0 * area, rel=5e-6)


EXTRAS = (
    "symmetric = true\nthickness_mm = [14.0, 18.0]\ndraft_deg = 4.0\ncorner_radius_mm = 3.0\n"
    "holes = [{ centre_mm = [-44.0, 0.0], diameter_mm = 9.0 }]\n"
)
DRILLING = "[[drilling]]\nfrom_mm = [-20.0, 0.0, 38.0]\nto_mm = [-45.0, 20.0, 38.0]\ndiameter_mm = 5.0\n"


def test_draft_corners_holes_and_drillings_count_as_they_are_made(tmp_path: Path, crank: bytes) -> None:
    text = DESIGN.replace("symmetric = true\n", EXTRAS).replace("[envelope]", DRILLING + "[envelope]")
    problem = problem_of(tmp_path, text, crank)
    variables = np.array([52.0, 55.0, 54.0, 57.0, 15.0])
    amounts = problem.amounts(variables)
    solid = with_profiles(problem.free, amounts.radii_mm, amounts.thickness_mm)
    assert abs(held_error(problem.free, solid, amounts)) < 1e-6
    made, slopes = problem.moments(variables)
    cut = solid.moments(problem.crank.density_g_mm3)
    assert made.mass_g == pytest.approx(cut.mass_g, rel=2e-6)
    assert made.first_g_mm == pytest.approx(cut.first_g_mm, rel=1e-4, abs=0.5)
    assert made.polar_inertia_g_mm2 == pytest.approx(cut.polar_inertia_g_mm2, rel=1e-5)
    sharp = problem_of(tmp_path, text.replace("corner_radius_mm = 3.0\n", ""), crank)
    slopes = sharp.moments(variables)[1]
    for place, unit in enumerate(np.eye(5)):
        more, less = (sharp.moments(variables + sign * 1e-4 * unit)[0] for sign in (1.0, -1.0))
        assert slopes[place, 4] == pytest.approx((more.mass_g - less.mass_g) / 2e-4, rel=1e-6)
        inertia = (more.polar_inertia_g_mm2 - less.polar_inertia_g_mm2) / 2e-4
        assert slopes[place, 5] == pytest.approx(inertia, rel=1e-6)
    exact = properties_of_step(problem, variables)
    assert exact.mass_g == pytest.approx(cut.mass_g, rel=1e-5)
    assert exact.first_g_mm == pytest.approx(cut.first_g_mm, rel=1e-3, abs=1.0)


def properties_of_step(problem: Problem, variables: Any) -> Moments:
    """Return the moments of a design's STEP file (rotor frame)."""
    amounts, drillings = problem.amounts(variables), problem.design.drillings
    name, step = design_step(problem.free, problem.crank, amounts, drillings)
    assert name == "crank.step"
    bodies = [ExactSolid.of(one.body) for one in read_step_file(step).bodies]
    total = Moments.zero()
    for body in bodies:
        total = total + body.moments(problem.crank.density_g_mm3, problem.crank.anatomy.file_to_rotor)
    return total


def best_of(problem: Problem) -> JudgedDesign:
    """Return the best of a search with one objective, before it is written."""
    every = with_refined(searched(problem, [], lambda _: None))
    return min(every.candidates, key=lambda each: (each.violation, each.objectives[0]))


@pytest.mark.parametrize("method", ["nsga2", "cmaes"])
def test_a_circle_is_found_where_a_circle_is_best(tmp_path: Path, crank: bytes, method: str) -> None:
    """Least inertia about the axis for a given ∫ x dm: metal where r² < λ|x|, a circle through the axis."""
    text = CIRCLE.replace("population", f'method = "{method}"\npopulation')
    problem = problem_of(tmp_path, text, crank)
    best = best_of(problem)
    profile = problem.free.profiles[0]
    (radii,) = problem.amounts(best.variables).radii_mm
    outline = profile.basis(np.linspace(0.0, 1.0, 50)) @ profile.control_points_mm(radii)
    across = (outline**2).sum(axis=1) / -outline[:, 0]
    assert across == pytest.approx(np.full(50, across.mean()), rel=2e-3)
    assert best.violation == 0.0


def test_a_planted_optimum_is_found(tmp_path: Path, crank: bytes) -> None:
    """Of designs with three radii, looked at all over a grid, none is lighter than what is found."""
    text = DESIGN.replace("points = 7", "points = 5").replace(', "polar_inertia_kg_mm2"', "")
    problem = problem_of(tmp_path, text, crank)
    low, high = problem.bounds.T
    lightest = np.inf
    for one in np.linspace(low[0], high[0], 5):
        for other in np.linspace(low[1], high[1], 5):
            candidate = judged(problem, np.array([one, other, 0.5 * (low[2] + high[2])]))
            if candidate.violation <= 0.0:
                lightest = min(lightest, float(candidate.objectives[0]))
    assert best_of(problem).objectives[0] <= lightest + 0.01


def test_free_metal_of_the_start_against_the_envelope_is_told(tmp_path: Path, rounder: bytes) -> None:
    """The rim of 62 mm meets a skirt that hangs to 115 − 30 − 24 = 61 mm from the axis at the bottom."""
    text = DESIGN.replace("skirt_below_pin_mm = 18.0", "skirt_below_pin_mm = 24.0")
    problem = problem_of(tmp_path, text.replace("110, 250", "120, 240"), rounder)
    start = encoded(judged_start(problem))
    assert start["feasible"] is False
    (piston,) = [each for each in start["violations"] if each["constraint"] == "clearance to piston 1"]
    assert (piston["by"], piston["unit"]) == (pytest.approx(2.0, abs=0.02), "mm")
    assert piston["at_deg"] == pytest.approx(180.0, abs=10.0)
    assert np.hypot(*piston["at_mm"][:2]) == pytest.approx(62.0, abs=0.05)
    assert start["fit_error_mm"] < 0.2


CYCLE = """[cycle]
bore_mm = 76.8
compression_ratio = 13.0
heat_J = 900.0
"""


@pytest.mark.slow
def test_loads_stress_and_frequency_are_those_of_the_solid(
    tmp_path: Path, rounder: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = partial(bodies_of_solid, share_of_radius=0.6)
    monkeypatch.setattr(strength, "bodies_of_solid", coarse)
    text = DESIGN.replace('"mass_g", "polar_inertia_kg_mm2"', '"greatest_main_load_N", "greatest_stress_MPa"')
    text = text.replace("[search]", CYCLE + "[fem]\nsize_mm = 14.0\nmin_frequency_hz = 9e4\n[search]")
    problem = problem_of(tmp_path, text, rounder)
    light, heavy = (problem.moments(np.full(4, radius))[0] for radius in (45.0, 60.0))
    loads = [problem.objectives(each, {})["greatest_main_load_N"] for each in (light, heavy)]
    assert loads[0] != pytest.approx(loads[1], rel=1e-3)
    solid = with_profiles(problem.free, [np.full(7, 60.0)], [None])
    strengths = problem.strengths(heavy, solid)
    assert strengths["first_frequency_hz"] == pytest.approx(FINE_HZ, rel=0.02)
    assert 10.0 < strengths["greatest_stress_MPa"] < 100.0
    found = problem.objectives(heavy, strengths, solid)
    assert found["greatest_main_load_N"] == pytest.approx(loads[1], rel=1e-2)
    assert found["greatest_stress_MPa"] == strengths["greatest_stress_MPa"]
    (limit,) = problem.of_strengths(strengths)
    assert limit.margin == strengths["first_frequency_hz"] - 9e4


FINE_HZ = 1811.9
"""First frequency of the same solid on a mesh of 6 mm."""


class Heavier(Problem):
    """Finite elements in closed form: a design is as stiff as it is heavy."""

    def strengths(self, moments: Moments, solid: Solid) -> dict[str, float]:
        """Return 1 Hz for each gram, and 1 MPa for each kg·mm²."""
        found = {
            "first_frequency_hz": moments.mass_g,
            "greatest_stress_MPa": 1e-3 * moments.polar_inertia_g_mm2,
        }
        return {name: found[name] for name in self.strengths_wanted}


Limited = tuple[Problem, SearchResult, list[Generation]]


class Sent:
    """Workers that get each task as bytes, and end the last first."""

    def run(self, work: Work, tasks: Sequence[Any]) -> Iterator[Done]:
        """Yield the end of each task."""
        for number, task in reversed(list(enumerate(tasks))):
            yield Done(number, work(pickle.loads(pickle.dumps(task))), "", 1)


@pytest.fixture(scope="module")
def limited(
    tmp_path_factory: pytest.TempPathFactory, crank: bytes
) -> tuple[Problem, SearchResult, list[Generation]]:
    """A search for the lightest design of at least 2840 Hz, that is 2840 g; without the limit 2820 g."""
    text = DESIGN.replace(', "polar_inertia_kg_mm2"', "").replace("designs = 2", "designs = 1")
    text = text.replace("[search]", "[fem]\nmin_frequency_hz = 2840\nanalyses = 12\n[search]")
    plain = problem_of(tmp_path_factory.mktemp("limited"), text, crank)
    problem = Heavier(plain.design, plain.crank, plain.free, plain.loads, plain.factor, plain.neighbours)
    kept: list[Generation] = []
    return problem, searched(problem, [], kept.append), kept


def test_a_limit_by_finite_elements_is_kept_by_the_search(
    limited: Limited,
) -> None:
    _, found, generations = limited
    assert [len(generation.analysed) for generation in generations] == [6, 3, 3]
    answer = chosen(with_refined(found))
    assert answer.kept
    (best,) = answer.designs
    assert 2840.0 <= best.moments.mass_g < 2845.0
    assert {each.name for each in best.constraints} >= {"first frequency", "residual"}
    told = answer.told_errors["first_frequency_hz"]
    assert told < 0.005
    values = encoded(SearchFigures.of(found, answer))["finite_elements"]
    assert values["analysed_in_search"] == 12
    assert told <= values["expected_errors"]["first_frequency_hz"] < 0.05
    assert values["analysed_when_written"] == len(answer.found.analysed) - 12 >= 1
    assert values["errors_when_written"]["first_frequency_hz"] == told


def test_a_search_with_finite_elements_goes_on_and_is_the_same_by_workers(
    limited: Limited,
) -> None:
    problem, found, generations = limited
    lines = [json.loads(json.dumps(generation.line())) for generation in generations]
    again: list[Generation] = []
    other = searched(problem, [Generation.of_line(line) for line in lines[:2]], again.append, Sent())
    assert [generation.line() for generation in again] == lines[2:]
    for one, two in zip(found.candidates, other.candidates, strict=True):
        assert (one.objectives == two.objectives).all()
        assert one.violation == two.violation


def test_a_stress_that_nothing_loads_is_refused(tmp_path: Path, crank: bytes) -> None:
    text = DESIGN.replace("[search]", "[fem]\nmax_stress_MPa = 200\n[search]")
    with pytest.raises(JobError, match=r"\[cycle\] is missing"):
        design(written(tmp_path, text, crank), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_two_workers_give_the_same_files(found: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    folder, _ = found
    design(folder / "design.toml", tmp_path / "two", workers=2)
    for file in ("search.jsonl", "front.svg", "designs/d01/crank.stl", "designs/d01/crank.step"):
        assert (tmp_path / "two" / file).read_bytes() == (folder / "out" / file).read_bytes()


def test_a_search_that_was_stopped_goes_on_to_the_same_end(
    found: tuple[Path, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, report = found
    lines = (folder / "out" / "search.jsonl").read_text("utf-8").splitlines(keepends=True)
    assert len(lines) == report["search"]["generations"] == 3
    (folder / "again").mkdir()
    (folder / "again" / "search.jsonl").write_text("".join(lines[:2]) + lines[2][:40], "utf-8")
    again = design(folder / "design.toml", folder / "again", workers=1).report
    assert {**again, "seconds": 0} == {**report, "seconds": 0}
    assert (folder / "again" / "search.jsonl").read_text("utf-8").splitlines(keepends=True) == lines
    other = folder / "other.toml"
    other.write_text(DESIGN.replace("evaluations = 36", "evaluations = 5\nrefine = false"), "utf-8")
    with pytest.raises(FileError, match="another design's search; choose another folder, or --fresh"):
        design(other, folder / "again", workers=1)
    monkeypatch.setattr(installed, "has_kernel", lambda: False)  # nobody looks at the last STEP file
    assert len(design(other, folder / "again", fresh=True, workers=1).report["designs"]) == 1
    assert len((folder / "again" / "search.jsonl").read_text("utf-8").splitlines()) == 1


@pytest.fixture
def no_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write no STEP file of a design: it takes as long as the search."""
    monkeypatch.setattr(installed, "has_kernel", lambda: False)


@pytest.mark.usefixtures("no_kernel")
def test_no_design_that_keeps_everything_says_what_to_release(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], crank: bytes
) -> None:
    text = DESIGN.replace("[envelope]", "[target]\nmass_g = [1000.0, 1500.0]\n[envelope]")
    text = text.replace("evaluations = 36", "evaluations = 12\nrefine = false").replace(
        "designs = 2", "designs = 1"
    )
    assert main(["design", written(tmp_path, text, crank), "-o", str(tmp_path / "out"), "--json", "-"]) == 4
    report = json.loads(capsys.readouterr().out)
    assert report["outcome"] == "infeasible"
    assert "breaks mass_g greatest (1500 g) by" in report["reason"]
    assert (tmp_path / "out" / "designs" / "d01" / "crank.stl").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("radius_mm = 64.0", "radius_mm = 40.0", r"held metal is .* mm beyond 40 mm, at \("),
        ("110, 250", "100, 250", "symmetric needs its middle at 0 or 180"),
        ("points = 7", "holes = [{ centre_mm = [-31, 0], diameter_mm = 8 }]", "reaches into held metal"),
        ("points = 7", "draft_deg = 40", "draft_deg is 40; must be 0 to 30"),
        ("webs = [1, 2]", "webs = [1, 5]", "names 5; the crank has webs 1 to 2"),
        ("points = 7", "points = 3", "must be ≥ 4"),
        (
            "points = 7",
            "start_points_mm = [[-8, 45], [-50, -10], [-50, 10], [-8, -45], [-7, -45]]",
            "start_points_mm cross",
        ),
        ('"mass_g", ', '"mass", ', "names 'mass'"),
        ("symmetric", "symetric", "unknown key"),
    ],
)
def test_an_impossible_design_is_refused(tmp_path: Path, crank: bytes, old: str, new: str, said: str) -> None:
    with pytest.raises(JobError, match=said):
        design(written(tmp_path, DESIGN.replace(old, new), crank), tmp_path / "out")
    assert not (tmp_path / "out").exists()


LIGHT = (
    DESIGN[: DESIGN.index("[envelope]")].replace("110, 250", "95, 265").replace("points = 7", "points = 12")
)
SEARCH = "[envelope]\nradius_mm = 64.0\n[search]\nobjectives = {}\nevaluations = 60\n"


def least_free_metal_g(problem: Problem) -> float:
    """The least that any outline takes, in closed form.

    Metal begins at the hold radius h and ends at the envelope R. A ray at φ from the counterweight's middle
    that is filled to ρ adds (ρ² − h²) / 2 of area and cos φ (ρ³ − h³) / 3 of product, so that it is worth
    filling to R or not at all: a sector of half angle a, whose product is 2 sin a (R³ − h³) / 3.
    """
    held = problem.free.held_moments
    unbalance = float(np.linalg.norm(problem.residual(held).resultant_g_mm))
    h, r = problem.free.profiles[0].hold_radius_mm, problem.design.envelope.radius_mm or 0.0
    per_mm2 = 2.0 * problem.crank.density_g_mm3 * problem.free.thickness_mm(0)  # of two webs
    half = np.arcsin(unbalance / per_mm2 / (2.0 * (r**3 - h**3) / 3.0))
    return held.mass_g + per_mm2 * (r**2 - h**2) * float(half)


def test_the_least_metal_is_near_the_sector_that_theory_says_is_best(tmp_path: Path, rounder: bytes) -> None:
    """It stood 12.7 % above it, of the free metal."""
    problem = problem_of(tmp_path, LIGHT + SEARCH.format('["mass_g"]'), rounder)
    best = min(each.objectives[0] for each in kept(with_refined(searched(problem, [], no_file))))
    held, least = problem.free.held_moments.mass_g, least_free_metal_g(problem)
    assert least - held <= best - held <= 1.03 * (least - held)


def test_a_front_begins_at_the_least_metal_and_trades_it_for_inertia(tmp_path: Path, rounder: bytes) -> None:
    """It was a single design, 6.8 % and more above the least."""
    text = LIGHT + SEARCH.format('["mass_g", "polar_inertia_kg_mm2"]')
    problem = problem_of(tmp_path, text, rounder)
    good = kept(with_refined(searched(problem, [], no_file)))
    best = [good[number] for number in front(good)]
    mass, inertia = np.array([each.objectives for each in best]).T
    held, least = problem.free.held_moments.mass_g, least_free_metal_g(problem)
    assert mass.min() - held <= 1.03 * (least - held)
    assert len(best) >= 3
    assert inertia[mass.argmin()] - inertia.min() > 2.0
    assert mass[inertia.argmin()] - mass.min() > 5.0


def test_points_that_gather_too_near_are_left_where_they_are(tmp_path: Path, crank: bytes) -> None:
    """One of four ways to gather ten points leaves them no radius: the search ended in a traceback."""
    text = LIGHT.replace("points = 12", "points = 10") + SMALL_SEARCH.replace("64.0", "60.0")
    problem = problem_of(tmp_path, text, crank)
    assert chosen(with_refined(searched(problem, [], no_file))).kept


def test_gathered_control_points_keep_the_outline_off_the_hold_radius(tmp_path: Path, crank: bytes) -> None:
    plain = problem_of(tmp_path, LIGHT + SEARCH.format('["mass_g"]'), crank)
    level = level_sets(plain)
    for close in CLOSENESS_STEPS:
        problem, _ = begun(plain, level, close)
        profile, low = problem.free.profiles[0], problem.bounds[:, 0]
        outline = profile.outline_mm(problem.amounts(low).radii_mm[0])
        assert np.linalg.norm(outline, axis=1).min() >= profile.hold_radius_mm - 1e-6


def kept(findings: SearchResult) -> list[JudgedDesign]:
    return [each for each in findings.candidates if each.violation <= 0.0]


def no_file(_generation: Generation) -> None:
    """Keep nothing."""


COUPLE = (
    '[[engine.attached]]\nname = "flywheel"\nmass_g = 1000.0\nunbalance_g_mm = [-400.0, 0.0]\nz_mm = 60.0\n'
)


SMALL_SEARCH = SEARCH.format('["mass_g"]').replace(
    "evaluations = 60", "evaluations = 4\npopulation = 4\ndesigns = 1"
)


def test_webs_of_one_profile_that_cannot_take_a_couple_are_told_what_helps(
    tmp_path: Path, crank: bytes
) -> None:
    text = (
        LIGHT.replace("points = 12", "points = 8").replace("[balance]", COUPLE + "[balance]") + SMALL_SEARCH
    )
    problem = problem_of(tmp_path, text, crank)
    least_violated = solids.written(problem, problem.start)
    reason = infeasible_reason(least_violated, lambda: remedies(problem))
    assert "would meet it, tried: a separate profile for each web" in reason
    assert "envelope.radius_mm" not in reason
    one = text[text.index("[[counterweight]]") : text.index("[envelope]")]
    two = one.replace("webs = [1, 2]", "webs = [1]") + one.replace("webs = [1, 2]", "webs = [2]")
    helped = problem_of(tmp_path, text.replace(one, two), crank)
    level = level_set_for_balance(helped)
    assert level is not None
    plain, (variables,) = begun(helped, [level], CLOSENESS_STEPS[-1])
    assert solids.written(plain, variables).used_share <= MAX_SHARE < least_violated.used_share


@pytest.mark.usefixtures("no_kernel")
def test_where_nothing_that_is_tried_helps_it_says_so(tmp_path: Path, crank: bytes) -> None:
    heavy = COUPLE.replace("-400.0", "-90000.0")
    text = LIGHT.replace("[balance]", heavy + "[balance]") + SMALL_SEARCH + "refine = false\n"
    with calls_of(solids._written_design) as made:
        report = design(written(tmp_path, text, crank), workers=1).report
    assert report["outcome"] == "infeasible"
    assert "none of these meets it, tried: a separate profile" in report["reason"]
    assert "envelope.radius_mm = 80" in report["reason"]
    assert len(made) == 2  # a solid that comes no nearer is not made again and again
