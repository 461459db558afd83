"""Job files: what is read, and every way in which one can be wrong."""

import copy
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from autobalance import job
from autobalance.correction import KINDS, registry
from autobalance.correction.add import AddLimits
from autobalance.correction.contract import Limits
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.correction.turn import TurnLimits
from autobalance.declare import decoded
from autobalance.errors import FileError, JobError
from autobalance.job.tables import job_schema
from autobalance.report.balance.zero import FROM_CRANKPIN, cut_rows
from autobalance.report.display_units import ON_SCREEN
from autobalance.report.records.balanced import Cut

Raw = dict[str, Any]
Edit = Callable[[Raw], None]


def good() -> Raw:
    return {
        "crankshaft": {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0},
        "engine": {"rotating_g": {"rod": 95}, "reciprocating_g": {"piston": 158.0, "pin": 27.0}},
        "balance": {"factor": 0.28, "grade": 6.3, "speed_rpm": 15200},
        "correction": {"method": "shoulder"},
    }


def parsed(edit: Edit = lambda _: None) -> job.Job:
    raw = good()
    edit(raw)
    return job.parse(raw, Path("folder/job.toml"))


def put(path: str, value: object) -> Edit:
    """Return an edit that sets a key given with its table path."""

    def edit(raw: Raw) -> None:
        *tables, key = path.split(".")
        for name in tables:
            raw = raw.setdefault(name, {})
        raw[key] = value

    return edit


def drop(path: str) -> Edit:
    def edit(raw: Raw) -> None:
        *tables, key = path.split(".")
        for name in tables:
            raw = raw[name]
        del raw[key]

    return edit


def both(*edits: Edit) -> Edit:
    def edit(raw: Raw) -> None:
        for each in edits:
            each(raw)

    return edit


def test_units_come_in_here() -> None:
    found = parsed()
    assert found.crankshaft.file == Path("folder/crank.stl")
    assert found.crankshaft.density_g_mm3 == pytest.approx(7.85e-3, rel=1e-15)
    assert found.balance.service_speed_rad_s == pytest.approx(15200 * 2 * math.pi / 60, rel=1e-15)
    assert found.engine.default.weights.rotating == {"rod": job.Weight(95.0)}
    assert found.name == "job"


def test_defaults() -> None:
    found = parsed()
    assert found.crankshaft.crankpin_in_file is True
    assert found.crankshaft.body is None
    assert found.engine.default.rods == 1
    assert found.engine.attached == ()
    assert found.balance.judge == "dynamic"
    assert found.balance.rotor_mass_g is None
    assert found.methods == (ShoulderLimits(),)
    assert found.original is None


def test_overrides_are_arrays_in_file_axes() -> None:
    pins = [{"centre_mm": [0, 26.9, 0], "diameter_mm": 28.0, "width_mm": 16}]
    found = parsed(
        both(
            put("crankshaft.axis_point_mm", [1, 2, 3]),
            put("crankshaft.axis_direction", [0, 0, -2.0]),
            put("crankshaft.crankpins", pins),
            put("crankshaft.main_journals", [{"centre_mm": [0, 0, 1]}]),
            put("crankshaft.body", "all"),
        )
    ).crankshaft
    hints = found.overrides
    assert hints.axis_point_mm is not None
    assert hints.axis_direction is not None
    assert hints.axis_point_mm.tolist() == [1.0, 2.0, 3.0]
    assert hints.axis_direction.dtype == np.float64
    assert hints.crankpins is not None
    assert hints.crankpins[0].width_mm == 16.0
    assert hints.main_journals is not None
    assert hints.main_journals[0].diameter_mm is None
    assert found.body == "all"


def test_throws_that_differ_merge_onto_the_engine() -> None:
    engine = parsed(
        put(
            "engine.throw",
            [{"number": 2, "rods": 2, "reciprocating_g": {"piston": 160, "rings": 5}}],
        )
    ).engine
    assert engine.of_throw(1) is engine.default
    second = engine.of_throw(2)
    assert second.rods == 2
    assert {name: part.mass_g for name, part in second.weights.reciprocating.items()} == {
        "piston": 160.0,
        "pin": 27.0,
        "rings": 5.0,
    }
    assert second.weights.rotating == engine.default.weights.rotating


def test_weights_may_carry_what_they_may_be_off() -> None:
    weights = parsed(put("engine.rotating_g", {"rod": {"g": 95.04, "pm": 0.5}, "oil": {"g": 1}})).engine
    assert weights.default.weights.rotating == {"rod": job.Weight(95.04, 0.5), "oil": job.Weight(1.0)}


def test_a_weight_may_be_several_pieces() -> None:
    bolts = {"g": 20, "pm": 0.1, "pieces": 2}
    found = parsed(put("engine.rotating_g", {"bolts": bolts, "nuts": {"oz": 1.0, "pieces": 4}})).engine
    assert found.default.weights.rotating["bolts"] == job.Weight(40.0, 0.2)
    assert found.default.weights.rotating["nuts"].mass_g == pytest.approx(4.0 * 28.349523125, rel=1e-15)
    with pytest.raises(JobError, match=r"rotating_g.bolts.pieces is 0; must be ≥ 1"):
        parsed(put("engine.rotating_g", {"bolts": {"g": 20, "pieces": 0}}))


def test_a_material_stands_for_its_density() -> None:
    by_name = both(drop("crankshaft.density_kg_m3"), put("crankshaft.density", "ductile iron"))
    found = parsed(by_name)
    assert found.crankshaft.density_g_mm3 == pytest.approx(7.1e-3, rel=1e-15)
    assert job.describe(found)["crankshaft"]["density_kg_m3"] == 7100.0
    with pytest.raises(JobError, match=r"crankshaft.density is 'stel'; .* did you mean 'steel'\?"):
        parsed(both(drop("crankshaft.density_kg_m3"), put("crankshaft.density", "stel")))
    with pytest.raises(JobError, match=r"crankshaft.density is given beside density_kg_m3"):
        parsed(put("crankshaft.density", "steel"))


def test_numbers_may_be_typed_with_their_unit() -> None:
    found = parsed(
        both(
            put("balance.factor", "28 %"),
            put("balance.grade", "G 6.3"),
            put("balance.speed_rpm", "15200 rpm"),
        )
    )
    assert found.balance == parsed().balance
    assert job.describe(found)["balance"] == job.describe(parsed())["balance"]
    assert parsed(put("balance.grade", "G6.3")).balance == parsed().balance
    for key, text in (("factor", "128 %"), ("speed_rpm", "-9 rpm"), ("speed_rpm", "9 rpx"), ("grade", "G")):
        with pytest.raises(JobError, match=rf"balance.{key} is "):
            parsed(put(f"balance.{key}", text))


def test_a_weight_may_be_typed_with_its_unit() -> None:
    typed = {"rod": "0.2210 kg", "oil": "7.8 oz", "clip": "40 g"}
    found = parsed(put("engine.rotating_g", typed)).engine.default.weights.rotating
    assert {name: each.mass_g for name, each in found.items()} == pytest.approx(
        {"rod": 221.0, "oil": 7.8 * 28.349523125, "clip": 40.0}, rel=1e-15
    )
    for weight in ("221", "7 lbs", "-7 oz"):
        with pytest.raises(JobError, match=r"engine.rotating_g.rod is "):
            parsed(put("engine.rotating_g", {"rod": weight}))
    with pytest.raises(JobError, match=r"is '221'; must be a number, or with its unit: \"7.8 oz\"$"):
        parsed(put("engine.rotating_g", {"rod": "221"}))
    with pytest.raises(JobError, match=r"rotating_g.rod.g is '7 oz'; must be a number$"):  # ± of what unit?
        parsed(put("engine.rotating_g", {"rod": {"g": "7 oz", "pm": 1.0, "pieces": 2}}))


def test_the_schema_takes_weights_as_the_reader_does() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = job_schema()["properties"]["engine"]["properties"]["rotating_g"]
    jsonschema.validate({"rod": "7.8 oz", "oil": {"oz": 1.0}}, schema)
    for weight in ("221", "-7 oz", {"g": "7 oz"}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"rod": weight}, schema)


def test_one_number_in_place_of_a_list_of_tools_is_taken() -> None:
    def drills(value: object) -> tuple[float, ...] | None:
        table = {"diameters_mm": value}
        found = parsed(both(put("correction.method", "drill"), put("correction.drill", table)))
        limits = found.methods[0]
        assert isinstance(limits, DrillLimits)
        return limits.diameters_mm

    assert drills(8) == drills([8]) == (8.0,)
    assert drills("3/8 in") == (9.525,)
    with pytest.raises(JobError, match=r"diameters_mm is -8; must be > 0"):
        drills(-8)
    with pytest.raises(JobError, match=r"axis_direction is 8; must be a list of 3"):
        parsed(put("crankshaft.axis_direction", 8))


def test_attached_parts() -> None:
    part = {"name": "flywheel", "mass_g": 1200, "unbalance_g_mm": [250, 0.0], "z_mm": 80}
    assert parsed(put("engine.attached", [part])).engine.attached == (
        job.Attached("flywheel", 1200.0, (250.0, 0.0), 80.0),
    )


def test_top_level_limits_serve_the_shoulder_and_its_own_table_goes_first() -> None:
    found = parsed(
        both(
            put("correction.faces", ["w1-a", [0, 1, 2]]),
            put("correction.max_depth_mm", 6),
            put("correction.sector_deg", [120, 240]),
            put("correction.shoulder", {"max_depth_mm": 2.0, "depth_step_mm": 0.1}),
        )
    )
    assert found.methods == (
        ShoulderLimits(
            faces=("w1-a", (0.0, 1.0, 2.0)), sector_deg=(120.0, 240.0), max_depth_mm=2.0, depth_step_mm=0.1
        ),
    )


def test_methods_may_be_mixed() -> None:
    found = parsed(
        both(
            put("correction.method", ["drill", "shoulder"]),
            put("correction.drill", {"diameters_mm": [8, 10.0], "sectors_deg": [[150, 210]], "max_holes": 3}),
        )
    )
    assert found.method_names == ("drill", "shoulder")
    assert found.methods[0] == DrillLimits(
        diameters_mm=(8.0, 10.0), sectors_deg=((150.0, 210.0),), max_holes=3
    )


def test_every_method_is_enough_by_itself() -> None:
    for name, kind in KINDS.items():
        assert parsed(put("correction.method", name)).methods == (kind.limits(),)


def test_added_metal_shares_the_keys_of_the_top_level() -> None:
    found = parsed(both(put("correction.method", ["add", "turn"]), put("correction.max_depth_mm", 2)))
    assert found.methods == (AddLimits(max_depth_mm=2.0), TurnLimits())


def test_original_factor_reads_the_original_parts() -> None:
    found = parsed(
        both(
            put("balance.factor", "original"),
            put("original", {"rotating_g": {"rod": 129.04}, "reciprocating_g": {"piston": 252.12}}),
        )
    )
    assert found.balance.factor is None
    assert found.original is not None
    assert found.original.reciprocating == {"piston": job.Weight(252.12)}


NO_PIN = put("crankshaft.crankpin_in_file", False)
ORIGINAL = put("balance.factor", "original")
FLYWHEEL = {"name": "flywheel", "mass_g": 1, "unbalance_g_mm": [1, 0], "z_mm": 0}
WRONG: dict[str, tuple[Edit, str]] = {
    "unknown table": (put("crankshft", {}), "crankshft is an unknown key; did you mean 'crankshaft'?"),
    "misspelt key": (
        put("crankshaft.densty_kg_m3", 1.0),
        "crankshaft.densty_kg_m3 is an unknown key; did you mean 'density_kg_m3'?",
    ),
    "far key": (put("balance.zebra", 1), "balance.zebra is an unknown key"),
    "table is no table": (put("balance", 3), "balance is 3; must be a table: [balance]"),
    "no crankshaft": (drop("crankshaft"), "crankshaft.file is missing"),
    "no file": (drop("crankshaft.file"), "crankshaft.file is missing"),
    "empty file": (put("crankshaft.file", ""), "crankshaft.file is empty"),
    "file is no text": (put("crankshaft.file", 3), "crankshaft.file is 3; must be a text"),
    "no unit": (drop("crankshaft.unit"), "crankshaft.unit is missing; STL carries no unit"),
    "unit": (put("crankshaft.unit", "inches"), "one of 'mm', 'cm', 'm', 'inch'; did you mean 'inch'?"),
    "density 0": (put("crankshaft.density_kg_m3", 0), "crankshaft.density_kg_m3 is 0; must be > 0"),
    "density < 0": (
        put("crankshaft.density_kg_m3", -7850.0),
        "crankshaft.density_kg_m3 is -7850; must be > 0",
    ),
    "density NaN": (
        put("crankshaft.density_kg_m3", math.nan),
        "density_kg_m3 is nan; must be a finite number",
    ),
    "file with a NUL": (
        put("crankshaft.file", "a\0.stl"),
        "crankshaft.file is 'a\\x00.stl'; must have no NUL",
    ),
    "density ∞": (put("crankshaft.density_kg_m3", math.inf), "density_kg_m3 is inf; must be a finite number"),
    "density beyond": (
        put("crankshaft.density_kg_m3", 1e10),
        "crankshaft.density_kg_m3 is 1e+10; must be at most 1e+09 in size",
    ),
    "density tiny": (
        put("crankshaft.density_kg_m3", 1e-300),
        "crankshaft.density_kg_m3 is 1e-300; must be at least 1e-09",
    ),
    "density off by < 0": (
        put("crankshaft.density_pm_kg_m3", -1),
        "crankshaft.density_pm_kg_m3 is -1; must be ≥ 0",
    ),
    "density off by itself": (
        put("crankshaft.density_pm_kg_m3", 7850.0),
        "crankshaft.density_pm_kg_m3 is 7850; must be < density_kg_m3, 7850",
    ),
    "margin": (
        put("balance.margin", "expand"),
        "balance.margin is 'expand'; must be one of 'none', 'expanded'; did you mean 'expanded'?",
    ),
    "depth step": (
        put("correction.drill", {"depth_step_mm": 5e-324}),
        "correction.drill.depth_step_mm is 4.94066e-324; must be 0 or ≥ 1e-06",
    ),
    "depth tolerance": (
        put("correction.depth_tolerance_mm", -0.1),
        "correction.depth_tolerance_mm is -0.1; must be ≥ 0",
    ),
    "rods beyond": (
        put("engine.rods_per_throw", 10**10),
        "engine.rods_per_throw is 10000000000; must be at most 1e+09 in size",
    ),
    "attached off by < 0": (
        put("engine.attached", [{**FLYWHEEL, "pm_g_mm": -1}]),
        "pm_g_mm is -1; must be ≥ 0",
    ),
    "density absent": (
        drop("crankshaft.density_kg_m3"),
        "crankshaft.density_kg_m3 is missing; it must be > 0",
    ),
    "density text": (put("crankshaft.density_kg_m3", "7850"), "density_kg_m3 is '7850'; must be a number"),
    "density true": (put("crankshaft.density_kg_m3", True), "density_kg_m3 is true; must be a number"),
    "density huge": (
        put("crankshaft.density_kg_m3", 10**400),
        "density_kg_m3 is inf; must be a finite number",
    ),
    "flag": (put("crankshaft.crankpin_in_file", 1), "crankpin_in_file is 1; must be true or false"),
    "axis": (put("crankshaft.axis_direction", [0, 0, 0]), "axis_direction is [0, 0, 0]; must point along"),
    "axis short": (
        put("crankshaft.axis_direction", [0, 1]),
        "axis_direction has 2 entries; must be a list of 3",
    ),
    "point": (put("crankshaft.axis_point_mm", [0, "1", 2]), "axis_point_mm[2] is '1'; must be a number"),
    "pins": (put("crankshaft.crankpins", {}), "crankshaft.crankpins is a table; must be a list of tables"),
    "no pins": (put("crankshaft.crankpins", []), "crankshaft.crankpins is an empty list"),
    "pin key": (
        put("crankshaft.crankpins", [{"center_mm": [0, 0, 0]}]),
        "crankshaft.crankpins[1].center_mm is an unknown key; did you mean 'centre_mm'?",
    ),
    "pin diameter": (
        put("crankshaft.crankpins", [{"centre_mm": [0, 0, 0], "diameter_mm": 0}]),
        "crankshaft.crankpins[1].diameter_mm is 0; must be > 0",
    ),
    "body": (put("crankshaft.body", 0), "crankshaft.body is 0; must be ≥ 1"),
    "body text": (put("crankshaft.body", "al"), "must be a whole number or 'all'; did you mean 'all'?"),
    "rods": (put("engine.rods_per_throw", 0), "engine.rods_per_throw is 0; must be ≥ 1"),
    "rods 1.5": (put("engine.rods_per_throw", 1.5), "rods_per_throw is 1.5; must be a whole number"),
    "rods true": (put("engine.rods_per_throw", True), "rods_per_throw is true; must be a whole number"),
    "stroke": (put("engine.stroke_mm", -53.8), "engine.stroke_mm is -53.8; must be > 0"),
    "rod length": (put("engine.rod_length_mm", 0), "engine.rod_length_mm is 0; must be > 0"),
    "weight": (put("engine.rotating_g.rod", -1), "engine.rotating_g.rod is -1; must be ≥ 0"),
    "weight text": (
        put("engine.rotating_g.rod", "95"),
        "engine.rotating_g.rod is '95'; must be a number, or with its unit",
    ),
    "weight table": (put("engine.rotating_g.rod", {"pm": 1}), "engine.rotating_g.rod.g is missing"),
    "weight pm": (put("engine.rotating_g.rod", {"g": 1, "pm": -1}), "rotating_g.rod.pm is -1; must be ≥ 0"),
    "weight key": (
        put("engine.rotating_g.rod", {"g": 1, "pn": 1}),
        "rod.pn is an unknown key; known here: g, pm",
    ),
    "throw number": (put("engine.throw", [{}]), "engine.throw[1].number is missing"),
    "throw twice": (put("engine.throw", [{"number": 1}, {"number": 1}]), "throw[2].number is 1 twice"),
    "throw key": (put("engine.throw", [{"number": 1, "rod": 2}]), "engine.throw[1].rod is an unknown key"),
    "attached": (put("engine.attached", [{"name": "x"}]), "engine.attached[1].mass_g is missing"),
    "pin twice": (put("engine.crankpin_g", {"crankpin": 114.65}), "the crankpin would count twice"),
    "pin of a throw twice": (
        put("engine.throw", [{"number": 1, "crankpin_g": {"crankpin": 1}}]),
        "engine.throw[1].crankpin_g.crankpin is given",
    ),
    "no pin": (NO_PIN, "engine.crankpin_g.crankpin is missing; crankshaft.crankpin_in_file = false"),
    "no original pin": (
        both(
            NO_PIN,
            put("engine.crankpin_g", {"crankpin": 1}),
            ORIGINAL,
            put("original.reciprocating_g", {"piston": 1}),
        ),
        "original.crankpin_g.crankpin is missing",
    ),
    "original absent": (ORIGINAL, '[original] is missing; balance.factor = "original"'),
    "original without pistons": (both(ORIGINAL, put("original", {})), "original.reciprocating_g is missing"),
    "original key": (put("original.rotating", {}), "original.rotating is an unknown key; did you mean"),
    "factor > 1": (put("balance.factor", 1.01), "balance.factor is 1.01; must be 0 to 1"),
    "factor < 0": (put("balance.factor", -0.1), "balance.factor is -0.1; must be 0 to 1"),
    "factor NaN": (put("balance.factor", math.nan), "balance.factor is nan; must be a finite number"),
    "factor text": (put("balance.factor", "orignal"), "a number or 'original'; did you mean 'original'?"),
    "factor absent": (drop("balance.factor"), "balance.factor is missing; it must be 0 to 1"),
    "grade 0": (put("balance.grade", 0), "balance.grade is 0; must be > 0"),
    "grade < 0": (put("balance.grade", -6.3), "balance.grade is -6.3; must be > 0"),
    "grade NaN": (put("balance.grade", math.nan), "balance.grade is nan; must be a finite number"),
    "grade text": (put("balance.grade", "6.3 G"), "balance.grade is '6.3 G'; must be a number"),
    "grade absent": (drop("balance.grade"), "balance.grade is missing"),
    "speed 0": (put("balance.speed_rpm", 0), "balance.speed_rpm is 0; must be > 0"),
    "speed < 0": (put("balance.speed_rpm", -1), "balance.speed_rpm is -1; must be > 0"),
    "speed NaN": (put("balance.speed_rpm", math.nan), "balance.speed_rpm is nan; must be a finite number"),
    "speed absent": (drop("balance.speed_rpm"), "balance.speed_rpm is missing"),
    "judge": (put("balance.judge", "statc"), "'dynamic', 'static'; did you mean 'static'?"),
    "rotor mass": (put("balance.rotor_mass_g", 0), "balance.rotor_mass_g is 0; must be > 0"),
    "planes": (put("balance.tolerance_planes_mm", [40, -40]), "tolerance_planes_mm is [40, -40]; the first"),
    "no correction": (drop("correction"), "[correction] is missing; it needs at least method"),
    "no method": (drop("correction.method"), "correction.method is missing"),
    "method": (put("correction.method", "shouldr"), "did you mean 'shoulder'?"),
    "no methods": (put("correction.method", []), "correction.method is an empty list"),
    "method twice": (put("correction.method", ["drill", "drill"]), "correction.method names 'drill' twice"),
    "faces": (put("correction.faces", "w1-a"), "correction.faces is 'w1-a'; must be 'auto' or a list"),
    "face": (put("correction.faces", [3]), "correction.faces[1] is 3; must be a text or a list of 3"),
    "no faces": (put("correction.faces", []), "correction.faces is an empty list"),
    "sector": (put("correction.sector_deg", [10, 10]), "correction.sector_deg is [10, 10]; its two angles"),
    "sector text": (put("correction.sector_deg", 10), "correction.sector_deg is 10; must be a list of 2"),
    "depth": (put("correction.max_depth_mm", 0), "correction.max_depth_mm is 0; must be > 0"),
    "wall": (put("correction.min_wall_mm", -1), "correction.min_wall_mm is -1; must be ≥ 0"),
    "same depth": (
        put("correction.same_depth", "no"),
        "correction.same_depth is 'no'; must be true or false",
    ),
    "own step": (
        put("correction.shoulder", {"depth_step_mm": -1}),
        "shoulder.depth_step_mm is -1; must be 0 or ≥ 1e-06",
    ),
    "own key": (
        put("correction.shoulder", {"face": 1}),
        "shoulder.face is an unknown key; did you mean 'faces'?",
    ),
    "drill": (
        both(put("correction.method", "drill"), put("correction.drill", {"max_holes": 0})),
        "correction.drill.max_holes is 0; must be ≥ 1",
    ),
    "a drill not asked for": (put("correction.drill", {"max_holes": 0}), "correction.drill.max_holes is 0"),
    "drill direction": (
        put("correction.drill", {"direction": "radially"}),
        "correction.drill.direction is 'radially'; must be one of 'radial', 'axial'; did you mean 'radial'?",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_jobs_name_the_key(name: str) -> None:
    edit, message = WRONG[name]
    with pytest.raises(JobError) as caught:
        parsed(edit)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.fixture
def only_shoulder() -> Iterator[None]:
    """No other kind is registered; afterwards all are, in their order, which lists and ranks follow."""
    kept = dict(KINDS)
    registry._KINDS.clear()
    registry._KINDS["shoulder"] = kept["shoulder"]
    yield
    registry._KINDS.clear()
    registry._KINDS.update(kept)


@pytest.mark.usefixtures("only_shoulder")
def test_a_method_that_is_not_there_says_so() -> None:
    with pytest.raises(JobError, match="'drill'; must be one of 'shoulder', 'listed'"):
        parsed(put("correction.method", ["shoulder", "drill"]))


@dataclass(frozen=True)
class OneAngleLimits(Limits):
    """Limits of a kind that calls one angle what others call two."""

    sector_deg: float = 60.0


def test_a_kind_may_have_one_angle_for_a_sector(monkeypatch: pytest.MonkeyPatch) -> None:
    kind = SimpleNamespace(
        limits=OneAngleLimits, noun="Groove", datum="the rim", extent="depth", adds_metal=False
    )
    monkeypatch.setitem(registry._KINDS, "groove", kind)
    found = parsed(both(put("correction.method", "groove"), put("correction.groove.sector_deg", 60.0)))
    assert found.methods == (OneAngleLimits(60.0),)
    with pytest.raises(JobError, match=r"groove.sector_deg is a list; must be a number"):
        parsed(put("correction.groove.sector_deg", [0.0, 60.0]))


def test_the_summary_takes_one_angle_for_a_sector() -> None:
    cut = {
        "kind": "turn",
        "number": 1,
        "face": None,
        "web": 2,
        "sector_deg": 60.0,
        "depth_mm": 3.0,
        "removed_mass_g": 5.0,
        "radius_mm": 50.0,
        "position_mm": [50.0, 0.0, 1.0],
    }
    row = cut_rows(
        "Cuts to make", [decoded(Cut, cut, partly=True)], ON_SCREEN["metric"], FROM_CRANKPIN
    ).splitlines()[1]
    assert row.split()[:6] == ["1.", "turn", "2", "–", "3", "mm"]


def test_a_format_that_carries_its_unit_needs_none() -> None:
    assert parsed(both(put("crankshaft.file", "crank.3mf"), drop("crankshaft.unit"))).crankshaft.unit is None


TEXTS: dict[str, tuple[bytes, str]] = {
    "syntax": (b"[crankshaft]\nfile = \n", r"job.toml is not valid TOML: .*line 2"),
    "twice": (b"[balance]\n[balance]\n", r"job.toml is not valid TOML: .*line 2"),
    "not text": (b"\xff\xfe\x00", r"job.toml is not UTF-8 text: byte 0 is 0xff"),
    "nested": (b"a = " + b"[" * 100_000, r"job.toml is not usable TOML|job.toml is not valid TOML"),
    "endless number": (b"a = " + b"9" * 5000, r"job.toml is not usable TOML"),
    "key": (b"[balanc]\n", r"job.toml: balanc is an unknown key; did you mean 'balance'\?"),
    "empty": (b"", r"job.toml: crankshaft.file is missing"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_wrong_texts_name_the_file(name: str, tmp_path: Path) -> None:
    text, message = TEXTS[name]
    path = tmp_path / "job.toml"
    path.write_bytes(text)
    with pytest.raises(JobError, match=message) as caught:
        job.load(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["absent.toml", ".", "nul\0.toml"])
def test_a_job_that_cannot_be_read(name: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot read the job"):
        job.load(tmp_path / name)


def test_a_byte_order_mark_is_no_error(tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    text = Path("fixtures/crf250r/drafted/factor-0.28.toml").read_bytes()
    path.write_bytes(b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n"))
    assert job.load(path).balance.factor == 0.28


def _without_nulls(value: Any) -> Any:
    """Leave out what was not given."""
    if isinstance(value, dict):
        return {key: _without_nulls(item) for key, item in value.items() if item is not None}
    return value


@pytest.mark.parametrize("folder", ["drafted", "straight"])
@pytest.mark.parametrize("name", ["factor-0.28", "factor-original"])
def test_a_described_job_reads_back_as_itself(folder: str, name: str) -> None:
    found = job.load(Path(__file__).parents[2] / "fixtures" / "crf250r" / folder / f"{name}.toml")
    described = job.describe(found)
    json.dumps(described, allow_nan=False)
    raw = _without_nulls(copy.deepcopy(described))
    assert raw.pop("file") == str(found.path.resolve())
    again = job.parse(raw, found.path)
    assert job.describe(again) == described
    assert again.engine == found.engine
    assert again.balance == found.balance
    assert again.methods == found.methods


def test_all_that_is_wrong_is_said_at_once_whatever_kind_of_wrong_it_is() -> None:
    """Units, types, names and limits are looked at one after the other; none hides the others."""

    def edit(raw: Raw) -> None:
        raw["crankshaft"] |= {"unit": "mmm", "density": "stell"}
        del raw["crankshaft"]["density_kg_m3"]
        raw["engine"]["stroke_mm"] = "60 furlongs"
        raw["engine"]["reciprocating_g"]["piston"] = -3
        raw["balance"] |= {"factor": "50 percent", "grade": "H 6.3", "speed_rpm": "9500 rmp"}
        raw["correction"] = {"method": "drill", "drill": {"point_angle_deg": 10.0}}

    with pytest.raises(JobError) as caught:
        parsed(edit)
    named = [line.split()[0] for line in caught.value.lines]
    assert sorted(named) == [
        "balance.factor",
        "balance.grade",
        "balance.speed_rpm",
        "correction.drill.point_angle_deg",
        "crankshaft.density",
        "crankshaft.unit",
        "engine.reciprocating_g.piston",
        "engine.stroke_mm",
    ]
