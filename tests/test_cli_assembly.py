"""``init engine.step``: the crank of an assembly is found, the other parts are offered where they belong."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from autobalance.job.read import load
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.csg.shape import tessellated
from autobalance.solid.mesh.mesh import Mesh
from tests import jobs
from tests.assemblies import PIN, ROD, assembly, engine_parts
from tests.coarse import coarse_facets

needs_kernel = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
STEEL, ALUMINIUM = 7850.0, 2700.0
FILLED = {
    "crankshaft.density_kg_m3": STEEL,
    "engine.rod.density_kg_m3": STEEL,
    "engine.rotating_g.big_end_bearing.density_kg_m3": STEEL,
    "engine.reciprocating_g.piston.density_kg_m3": ALUMINIUM,
    "engine.reciprocating_g.wrist_pin.density_kg_m3": STEEL,
    "engine.reciprocating_g.rings_clips_oil": 12.0,
    "engine.reciprocating_g.Teil-7.density_kg_m3": STEEL,
    "balance.factor": 0.5,
    "balance.grade": 6.3,
    "balance.speed_rpm": 9000,
}


@needs_kernel
def test_one_assembly_is_enough_for_a_whole_job(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("engine.step").write_bytes(assembly(engine_parts()))
    with coarse_facets():
        assert jobs.run("init", "engine.step") == 0
    told = capsys.readouterr().out
    assert all(f"  {key}\n" in f"{told}\n" for key in FILLED)
    assert told.count("\n") == len(FILLED) + 1
    text = Path("engine.toml").read_text("utf-8")
    job = tomllib.loads(text)
    assert job["crankshaft"]["body"] == "Teil-3"
    assert job["engine"]["rod"]["body"] == "Teil-2"
    assert job["engine"]["reciprocating_g"]["piston"]["body"] == "Teil 5"
    assert "# rod_length_mm = 110.0" in text
    assert '# Teil-1 = { file = "engine.step", body = "Teil-1"' in text  # the flywheel: offered, not taken
    with coarse_facets():
        read = load("engine.toml", [f"{key}={value}" for key, value in FILLED.items()])
    weights = read.engine.default.weights
    half, outer, inner = PIN
    pin = math.pi * (outer**2 - inner**2) * 2.0 * half * STEEL * 1e-6
    assert weights.reciprocating["wrist_pin"].mass_g == pytest.approx(pin, rel=1e-9)
    ring = math.pi * (18.0**2 - 16.0**2) * 14.0 * STEEL * 1e-6
    assert weights.rotating["big_end_bearing"].mass_g == pytest.approx(ring, rel=1e-9)
    small = ROD.moments.first_g_mm[0] / ROD.length
    assert weights.reciprocating["connecting_rod_small_end"].mass_g == pytest.approx(small, rel=1e-9)
    assert set(weights.rotating) == {"connecting_rod_big_end", "big_end_bearing"}
    assert read.crankshaft.body == "Teil-3"
    assert read.engine.rod_length_mm == pytest.approx(ROD.length, rel=1e-12)


def mesh_file(path: Path, *names: str) -> None:
    """Write parts of the engine as the bodies of one STL."""
    parts = engine_parts()
    solids = []
    for name in names:
        shape, place = parts[name.rstrip("'")]
        mesh = tessellated(shape, 24).mesh
        aside = 400.0 * name.count("'")
        solids.append(Mesh(mesh.vertices + np.array(place) + (aside, 0.0, 0.0), mesh.triangles))
    jobs.write_stl(path, np.concatenate([solid.corners for solid in solids]))


def test_bodies_without_names_are_told_by_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    mesh_file(tmp_path / "engine.stl", "Teil-2", "Teil-3", "Teil-4")
    assert jobs.run("init", "engine.stl", "--unit", "mm") == 0
    job = tomllib.loads(Path("engine.toml").read_text("utf-8"))
    assert job["crankshaft"]["body"] == 1
    assert job["engine"]["rod"] == {
        "file": "engine.stl",
        "unit": "mm",
        "body": 2,
        "density_kg_m3": "FILL IN",
    }
    assert job["engine"]["reciprocating_g"]["wrist_pin"]["body"] == 3
    assert job["engine"]["reciprocating_g"]["piston"] == "FILL IN"
    assert jobs.run("init", "engine.stl", "--unit", "mm", "-o", "engine.xlsx") == 0
    assert jobs.run("init", "engine.xlsx", "-o", "again.toml") == 0
    again = tomllib.loads(Path("again.toml").read_text("utf-8"))
    assert again["crankshaft"] == job["crankshaft"]
    assert all(again["engine"][key] == job["engine"][key] for key in ("rod", "rotating_g", "reciprocating_g"))


@pytest.mark.parametrize(
    ("bodies", "says"),
    [
        (
            ("Teil-3", "Teil-3'"),
            "bodies 1 and 2 may each be the crank: choose one with --set crankshaft.body=N",
        ),
        (("Teil-2", "Teil-4"), "none of them alone is a crank"),
    ],
)
def test_no_crank_or_two_are_one_line(
    bodies: tuple[str, ...],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    mesh_file(tmp_path / "engine.stl", *bodies)
    assert jobs.run("init", "engine.stl", "--unit", "mm") == 3
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
    assert not Path("engine.toml").exists()
    if "may each be" in says:
        assert jobs.run("init", "engine.stl", "--unit", "mm", "--set", "crankshaft.body=1") == 0
        assert tomllib.loads(Path("engine.toml").read_text("utf-8"))["crankshaft"]["body"] == 1
