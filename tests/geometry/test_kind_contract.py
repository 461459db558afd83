"""What every registered kind of correction promises, looked at on one crank of true surfaces."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import autobalance as ab
from autobalance.correction import KINDS, joined, offer
from autobalance.correction.apart import keep_apart
from autobalance.correction.contract import Cut, Envelope
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.relaxing import Otherwise, WiderLimits
from autobalance.crank.anatomy import Overrides
from autobalance.crank.faces import find_faces
from autobalance.crank.recognition.recognise import recognise
from autobalance.declare import decoded, encoded
from autobalance.paper.cuts import cut_row
from autobalance.report.balance import kinds
from autobalance.report.balance.values import dumps
from autobalance.report.display_units import ON_PAPER
from autobalance.report.records.balanced import Cut as ListedCut
from autobalance.report.records.corrections import Correction
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import placed
from autobalance.solid.formats.read import Source, read
from tests.coarse import COARSE, FINE, coarse_facets
from tests.generated import exact
from tests.geometry.test_drill import assert_same, difference

pytestmark = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")

STEEL = 7.85e-3
OF_CUT = 1e-5
"""Share by which planned and cut metal may differ: rounding of sections, clearances of tools."""
OF_FACETS = 5e-3
"""The same between tools of facets and true ones."""
GRAIN_MM = 0.02


@dataclass(frozen=True, eq=False)
class Bench:
    source: Source
    work: Workpiece
    offers: dict[str, Candidates]

    def samples(self, name: str) -> list[Cut]:
        """The first, the middle and the last cut of a kind."""
        cuts = self.offers[name].cuts
        return [cuts[k] for k in sorted({0, len(cuts) // 2, len(cuts) - 1})]

    def metal(self, cut: Cut, depth_mm: float) -> Solid:
        """What a cut takes from the crank, or puts on, rotor frame."""
        body = cut.tool(depth_mm)
        crank = self.work.solid.moved(self.work.anatomy.file_to_rotor)
        return body - crank if cut.adds_metal else body & crank


@pytest.fixture(scope="module")
def crank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("contract") / "crank.step"
    path.write_bytes(exact("v-twin-45").step())
    return path


@pytest.fixture(scope="module")
def bench(crank: Path) -> Bench:
    return bench_of(crank, COARSE, tuple(KINDS))


def bench_of(crank: Path, fineness: Mapping[str, float], names: Sequence[str]) -> Bench:
    """The crank in triangles of a fineness, with what some kinds offer on it."""
    with coarse_facets(fineness):
        source = read(crank, None)
    assert source.surfaces is not None
    anatomy = recognise(source.solid, Overrides(), source.surfaces.cylinders)
    faces = find_faces(source.solid.mesh, anatomy, source.surfaces)
    heavy = np.array([-3000.0, 200.0])
    work = Workpiece(source.solid, anatomy, faces, STEEL, ((-60.0, heavy), (60.0, heavy)), 8.0)
    offers = {name: offer(work, KINDS[name].limits(), 0) for name in names}
    return Bench(source, work, offers)


def depths_of(cut: Cut) -> tuple[float, float]:
    least, most = cut.least_depth_mm, cut.max_depth_mm
    return least + 0.4 * (most - least), most


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_the_effect_is_what_the_cut_solid_loses(bench: Bench, name: str) -> None:
    work = bench.work
    for cut in bench.samples(name):
        for depth in depths_of(cut):
            tool = cut.tool(depth).moved(work.anatomy.rotor_to_file)
            after = work.solid + tool if cut.adds_metal else work.solid - tool
            change = difference(work.solid, after, work.anatomy) + cut.pressed_in(depth)
            assert_same(cut.effect(depth), change, OF_CUT)
            assert len(after.pieces()) == 1


@pytest.mark.parametrize("name", KINDS)
def test_the_rate_is_the_derivative_of_the_effect(bench: Bench, name: str) -> None:
    h = 1e-3
    for cut in bench.samples(name):
        if cut.max_depth_mm - cut.least_depth_mm > 4.0 * h:
            depth = depths_of(cut)[0]
            slope = (cut.effect(depth + h) - cut.effect(depth - h)).scaled(0.5 / h)
            assert_same(cut.rate(depth), slope, 1e-3)
        else:  # whole or not there: the mean slope
            assert_same(
                cut.rate(cut.max_depth_mm).scaled(cut.max_depth_mm), cut.effect(cut.max_depth_mm), 1e-9
            )


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_the_exact_tool_takes_the_same(bench: Bench, crank: Path, name: str) -> None:
    """A shallow cut into a rim loses a share of itself to the crank's own facets: then on finer ones."""
    effect, change = with_either_tool(bench, name)
    if abs(effect.mass_g - change.mass_g) > OF_FACETS * abs(change.mass_g):
        effect, change = with_either_tool(bench_of(crank, FINE, (name,)), name)
    assert_same(effect, change, OF_FACETS)


def with_either_tool(bench: Bench, name: str) -> tuple[Moments, Moments]:
    """What the first cut of a kind does, as planned and by its exact tool on the true surfaces."""
    exact = bench.source.exact
    assert exact is not None
    frame = bench.work.anatomy.file_to_rotor
    cut = bench.samples(name)[0]
    depth = depths_of(cut)[0]
    tool = cut.exact_tool(depth)
    assert tool is not None
    there = placed(tool, bench.work.anatomy.rotor_to_file)
    done = exact.solid.machined([] if cut.adds_metal else [there], [there] if cut.adds_metal else [])
    change = done.moments(STEEL, frame) - exact.solid.moments(STEEL, frame) + cut.pressed_in(depth)
    return cut.effect(depth), change


@pytest.mark.parametrize("name", KINDS)
def test_the_room_encloses_what_is_taken(bench: Bench, name: str) -> None:
    for cut in bench.samples(name):
        corners = bench.metal(cut, cut.max_depth_mm).mesh.vertices
        points = [Envelope(at[None, None], np.zeros((1, 1, 3)), np.zeros(1)) for at in corners[::7]]
        rooms = [cut.envelope, *points]
        most = np.array([cut.max_depth_mm, *np.zeros(len(points))])
        near = keep_apart(rooms, most, np.full(len(rooms), GRAIN_MM), np.minimum(np.arange(len(rooms)), 1))
        assert len(near) == len(points)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_its_cuts_keep_apart_from_every_other_kinds(bench: Bench, name: str) -> None:
    """Where two cuts may both be made, the bodies that they take leave the greater wall between them."""
    mine = bench.offers[name]
    rng = np.random.default_rng(7)
    for other, theirs in bench.offers.items():
        if list(KINDS).index(other) <= list(KINDS).index(name):  # each two kinds once
            continue
        both = joined([mine, theirs])
        limit = {(pair.first, pair.second): pair.most_mm for pair in both.apart}
        assert len(both.apart) >= len(mine.apart) + len(theirs.apart)
        for i, j in near_pairs(both.cuts, len(mine.cuts), rng):
            one, two = both.cuts[i], both.cuts[j]
            most = limit.get((i, j), math.inf)
            depths = [min(cut.max_depth_mm, most) for cut in (one, two)]
            if any(d < max(cut.least_depth_mm, 1e-3) for d, cut in zip(depths, (one, two), strict=True)):
                continue
            wall = max(one.clearance_mm, two.clearance_mm)
            gap = bench.metal(one, depths[0]).gap_mm(bench.metal(two, depths[1]), wall + 1.0)
            assert gap >= wall - GRAIN_MM, (one.label, two.label, most)


def near_pairs(cuts: Sequence[Cut], first: int, rng: np.random.Generator) -> Iterator[tuple[int, int]]:
    """Pairs of cuts of two kinds, those whose metal lies nearest among some."""
    centres = np.array([cut.effect(cut.max_depth_mm).centre_mm for cut in cuts])
    pairs = [(i, j) for i in range(first) for j in range(first, len(cuts))]
    some = rng.permutation(len(pairs))[:400]
    gaps = [float(np.linalg.norm(centres[pairs[k][0]] - centres[pairs[k][1]])) for k in some]
    for place in np.argsort(gaps)[::10][:12]:
        yield pairs[some[place]]


@pytest.mark.parametrize("name", KINDS)
def test_what_is_told_is_complete_and_valid(bench: Bench, name: str) -> None:
    kind = KINDS[name]
    whole = ab.schema("report")
    validator = jsonschema.Draft202012Validator({"$defs": whole["$defs"], "$ref": "#/$defs/correction"})
    for cut in bench.samples(name):
        made = cut.correction(depths_of(cut)[0])
        item = json.loads(dumps(encoded(Correction.of(1, made, bench.work.anatomy))))
        validator.validate(item)
        assert item["kind"] == name
        listed = decoded(ListedCut, item, partly=True)
        for units in ON_PAPER.values():
            line = kind.instruction(item, units)
            assert line
            assert "\n" not in line
            row = cut_row(listed, units)
            angle, z, radius, depth = row[4], row[7], row[6], row[9]
            assert "–" not in (z, radius, depth)
            assert (angle == "–") == kind.is_round_the_rim
        size = "height" if kind.adds_metal else "depth"
        assert kinds.datums([listed, listed]) == [f"{kind.noun}: {size} from {kind.datum}."]
        assert kind.size(item)
        assert cut.label
        assert cut.limit


@pytest.mark.parametrize("name", KINDS)
def test_wider_limits_are_limits(name: str) -> None:
    from dataclasses import replace

    limits = KINDS[name].limits()
    for way in KINDS[name].relaxing(limits):
        if isinstance(way, WiderLimits):
            wider = way.changed(1.0)
            assert replace(limits, **wider) != limits
            assert way.say(wider)
        elif isinstance(way, Otherwise):
            assert replace(limits, **way.changed) != limits
            assert way.text
        else:
            assert getattr(limits, way.key) == way.now
            assert str(way.now + 2) in way.say(2)


def test_a_kind_that_says_too_little_is_refused() -> None:
    from autobalance.correction.contract import Limits
    from autobalance.correction.drill import Drill
    from autobalance.correction.holes.drills import DrillLimits
    from autobalance.correction.kind import Kind
    from autobalance.correction.registry import register

    class Nameless(Drill):
        name = " "

    class Taken(Drill):
        pass

    class Unlimited(Drill):
        name = "unlimited"
        limits = Limits  # type: ignore[assignment]

    class Borrowed(Drill):
        name = "borrowed"

    for kind, message in (
        (Nameless, "its name is ' '"),
        (Taken, "the name 'drill' is taken"),
        (Unlimited, "expected a class derived from Limits"),
        (Borrowed, "the limits DrillLimits are another kind's"),
    ):
        with pytest.raises(TypeError, match=message):
            register(kind())
    with pytest.raises(TypeError, match="abstract"):
        Kind[DrillLimits]()  # type: ignore[abstract]
    assert list(KINDS)[:5] == ["shoulder", "turn", "drill", "slug", "add"]
