"""The optional tables for forces and shafts: read, described, and read back."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

from autobalance import job
from autobalance.balancing import engine_from_job, rotor_from_job
from autobalance.balancing.measured import Crank
from autobalance.balancing.measured_crank import measure_crank
from autobalance.errors import JobError
from autobalance.job.layout import LINK, ROD
from autobalance.running_gear.roll import shaking_force, turn_loads
from autobalance.runtime import Stopwatch
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import generated_crank

if TYPE_CHECKING:
    from autobalance.crank.anatomy import Anatomy

THROW = SimpleNamespace(
    number=1, crank_radius_mm=40.0, angle_rad=0.0, crankpin=SimpleNamespace(centre_mm=(40.0, 0.0, 0.0))
)
RAW: dict[str, Any] = {
    "crankshaft": {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0},
    "engine": {
        "rod_length_mm": 140.0,
        "rods_per_throw": 2,
        "rotating_g": {"rod": 400.0},
        "reciprocating_g": {"piston": 500.0},
        "layout": {"bank_deg": [-45, 45], "rod_pitch_mm": 20, "offset_mm": 1.0},
        "rod": {"big_end_g": 380.0, "small_end_g": 150.0, "inertia_kg_mm2": 1500.0},
        "throw": [{"number": 2, "rods": 1, "bank_deg": 30}],
    },
    "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
    "correction": {"method": "shoulder"},
    "shafts": [
        {"order": 2, "sense": "forward", "product_g_mm": 300.0, "place_mm": [0, 50]},
        {
            "order": 1,
            "sense": "backward",
            "phase_deg": 90,
            "weight": [{"name": "w", "eccentricity_mm": -3.0, "cad_g": 50.0, "weighed_g": 51.0}],
        },
    ],
}


def test_units_come_in_here() -> None:
    found = job.parse(RAW, Path("job.toml"))
    layout = found.engine.layout
    assert layout.bank_rad == pytest.approx((-math.pi / 4, math.pi / 4))
    assert layout.bank_by_throw == {2: (math.radians(30.0),)}
    assert (layout.rod_pitch_mm, layout.offset_mm) == (20.0, 1.0)
    assert found.engine.rod == job.RodOnScales(380.0, 150.0, 1.5e6)
    pair, single = found.shafts
    assert (pair.order, pair.forward, pair.product_g_mm, pair.place_mm) == (2, True, 300.0, (0.0, 50.0))
    assert pair.phase_rad == pytest.approx(math.pi)
    assert single.product_g_mm == pytest.approx(-153.0)
    assert single.phase_rad == pytest.approx(math.pi / 2)


def test_a_plain_job_needs_none_of_it() -> None:
    raw = {key: value for key, value in RAW.items() if key != "shafts"}
    raw["engine"] = {"rotating_g": {"rod": 1.0}, "reciprocating_g": {"piston": 1.0}}
    found = job.parse(raw, Path("job.toml"))
    assert found.engine.layout == job.CylinderLayout()
    assert (found.engine.rod, found.shafts) == (None, ())
    described = job.describe(found)
    assert not {"layout", "rod"} & set(described["engine"])
    assert "shafts" not in described


def given(values: Any) -> Any:
    """Drop the Nones, as a TOML file has none."""
    if isinstance(values, dict):
        return {key: given(value) for key, value in values.items() if value is not None}
    return [given(value) for value in values] if isinstance(values, list) else values


def test_what_changes_bob_weights_names_balance_among_its_verbs() -> None:
    """Link rods have weights of their own, and a rod measured from its solid puts its weights in."""
    layout = {"kind": "articulated", "bank_deg": [0.0]}
    link = {"cylinder": 2, "bank_deg": 72.0, "rod_length_mm": 110.0, "knuckle_radius_mm": 30.0}
    link["knuckle_angle_deg"] = 72.0
    bob_weights: list[float] = []
    for grams in (400.0, 460.0):
        throw = {"number": 1, "rods": 2, "link": [{**link, "rotating_g": grams}]}
        engine = {**RAW["engine"], "layout": layout, "throw": [throw]}
        read = job.Job.from_dict({**RAW, "engine": engine})
        crank = SimpleNamespace(throws=[THROW])
        bob_weights += rotor_from_job.fitted_bob_weights_g(read, cast("Anatomy", crank), 0.5)
    assert bob_weights[1] - bob_weights[0] == pytest.approx(60.0)
    for key in (LINK, ROD):
        assert {"balance", "recut", "compare", "factor"} <= set(key.read_by)


def test_a_described_layout_reads_back_as_itself() -> None:
    described = job.describe(job.parse(RAW, Path("job.toml")))
    raw = given(json.loads(json.dumps(described)))
    raw.pop("file")
    assert job.describe(job.parse(raw, Path("job.toml"))) == described


@pytest.mark.parametrize(
    ("table", "key", "value", "words"),
    [
        ("rod", "inertia_kg_mm2", 0.0, "engine.rod.inertia_kg_mm2 is 0; must be > 0"),
        ("rod", "small_end_g", "150", "engine.rod.small_end_g is '150'; must be a number"),
        ("layout", "bank", 45.0, "engine.layout.bank is an unknown key; did you mean 'bank_deg'?"),
        ("layout", "bank_deg", "v", "engine.layout.bank_deg is 'v'; must be a number or a list"),
    ],
)
def test_what_is_wrong_is_named(table: str, key: str, value: object, words: str) -> None:
    raw = json.loads(json.dumps(RAW))
    raw["engine"][table][key] = value
    with pytest.raises(JobError) as caught:
        job.parse(raw, Path("job.toml"))
    assert words in str(caught.value)


def save(mesh: Mesh, path: Path) -> None:
    """Write a binary STL."""
    record = np.zeros(
        len(mesh.triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    )
    record["corners"] = mesh.corners
    path.write_bytes(bytes(80) + np.uint32(len(record)).tobytes() + record.tobytes())


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> tuple[job.Job, Crank]:
    folder = tmp_path_factory.mktemp("four")
    save(generated_crank("inline-4", segments=24).mesh, folder / "crank.stl")
    raw = {
        **RAW,
        "engine": {key: RAW["engine"][key] for key in ("rod_length_mm", "rotating_g", "reciprocating_g")},
    }
    asked = job.parse(raw, folder / "job.toml")
    return asked, measure_crank(asked.crankshaft, Stopwatch())


def test_the_crank_loads_the_mains_of_its_bays_as_a_whole(four: tuple[job.Job, Crank]) -> None:
    asked, crank = four
    bays = engine_from_job.as_measured(asked, crank)
    whole = engine_from_job.with_moments(asked, crank.anatomy, crank.moments)
    size = 1e-6 * crank.moments.mass_g * crank.anatomy.throws[0].crank_radius_mm
    np.testing.assert_allclose(bays.rotating.resultant_g_mm, whole.rotating.resultant_g_mm, atol=size)
    np.testing.assert_allclose(bays.rotating.moment_g_mm2, whole.rotating.moment_g_mm2, atol=300.0 * size)
    assert len(bays.crank) == 2 * (len(engine_from_job.mains_z_mm(crank.anatomy)) - 1)
    assert bays.polar_inertia_g_mm2 == whole.polar_inertia_g_mm2


def test_an_inline_four_shakes_at_order_two_but_loads_its_middle_main(four: tuple[job.Job, Crank]) -> None:
    asked, crank = four
    mains = engine_from_job.mains_z_mm(crank.anatomy)
    speed = asked.balance.service_speed_rad_s
    bare = engine_from_job.balanced_to(engine_from_job.as_measured(asked, crank), asked, crank.anatomy, 0.0)
    force = shaking_force(bare, speed)
    second = force.orders[3]
    assert second.order == 2.0
    assert second.greatest_force_n > 100.0 * force.orders[1].greatest_force_n
    main = turn_loads(bare, mains, speed).main_n
    greatest = np.hypot(main[..., 0], main[..., 1]).max(axis=1)
    assert int(greatest.argmax()) == len(mains) // 2  # the two middle throws pull together
