"""Every format through the command line: in, balanced, out, verified; units; several bodies in one file."""

from __future__ import annotations

import json
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.registry import FORMATS
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.units import MM_PER
from tests import jobs
from tests.coarse import bundled_corners
from tests.cranks import Shape, make_crank
from tests.sweeps import SWEPT
from tests.unit.test_solid_stl import ascii_stl

Report = dict[str, Any]
READ_ONLY = ("dae", "3dxml", "xaml")
"""Formats whose corrected solid is a 3MF (`tests/geometry/test_foreign_meshes.py`)."""
MESHES = [name for name, kind in FORMATS.items() if not kind.exact and name not in READ_ONLY]
CARRY = {"3mf": "millimeter", "glb": "m", "gltf": "m"}
IN_METRES = ("glb", "gltf")
"""Formats that carry their unit."""
U_PER_SHARE = 0.011
"""The aim, 1 % of the permissible unbalance, and what rounding to float32 adds."""


@cache
def crank_mesh() -> Mesh:
    """The bundled crank in few facets: the formats differ in how each is written."""
    return mesh_of_soup(bundled_corners("drafted", 64).astype(np.float64))


def job_on(folder: Path, name: str, data: bytes, unit: str | None) -> Path:
    """Write the bundled job with the crank in another format."""
    file = f"crank.{name}"
    job = jobs.bundled_job(folder, file=f'"{file}"', unit=f'"{unit}"' if unit else "")
    (folder / "crank.stl").unlink()
    (folder / file).write_bytes(data)
    return job


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Report:
    folder = tmp_path_factory.mktemp("plain")
    return jobs.computed(job_on(folder, "stl", encode(crank_mesh(), "stl", 1.0), "mm"), folder / "out")


def assert_same_result(report: Report, plain: Report) -> None:
    assert report["outcome"] == "within_tolerance"
    assert report["crank"]["mass_g"] == pytest.approx(plain["crank"]["mass_g"], rel=1e-6)
    assert report["initial"]["magnitude_g_mm"] == pytest.approx(plain["initial"]["magnitude_g_mm"], rel=1e-4)
    assert report["residual"]["magnitude_g_mm"] <= U_PER_SHARE * report["tolerance"]["permissible_g_mm"]
    depths = [cut["depth_mm"] for cut in report["corrections"]]
    assert depths == pytest.approx([cut["depth_mm"] for cut in plain["corrections"]], abs=2e-3)


QUICK = [
    ("stl", "mm"),
    ("stl", "inch"),
    ("obj", "mm"),
    ("ply", "cm"),
    ("off", "m"),
    ("3mf", "mm"),
    ("3mf", "inch"),
    ("glb", "m"),
]
MORE = [
    (name, unit)
    for name in MESHES
    for unit in (() if name in CARRY else ("mm", "cm", "m", "inch"))
    if (name, unit) not in QUICK
]
"""What a sweep adds: units are no format's own where it carries none."""


@pytest.mark.parametrize(("name", "unit"), QUICK + (MORE if SWEPT else []))
def test_in_balanced_out_and_verified(name: str, unit: str, tmp_path: Path, plain: Report) -> None:
    given = None if name in CARRY else unit
    job = job_on(tmp_path, name, encode(crank_mesh(), name, MM_PER[unit]), given)
    report = jobs.computed(job, tmp_path / "out")
    assert_same_result(report, plain)
    assert report["input"]["format"] == name
    assert report["outputs"]["solid"]["file"] == f"balanced.{name}"
    assert jobs.run("verify", tmp_path / "out" / "report.json", "--independent") == 0
    again = FORMATS[name].read((tmp_path / "out" / f"balanced.{name}").read_bytes())
    size = np.ptp(again.soup.reshape(-1, 3), axis=0) * MM_PER[unit]
    assert size == pytest.approx(np.ptp(crank_mesh().vertices, axis=0), rel=1e-5)


def test_ascii_stl(tmp_path: Path, plain: Report) -> None:
    job = job_on(tmp_path, "stl", ascii_stl(np.round(crank_mesh().corners, 4)), "mm")
    report = jobs.computed(job, tmp_path / "out")
    assert_same_result(report, plain)
    by_digits = report["initial"]["uncertainty_shares_g_mm"]["rounding"]
    assert by_digits == pytest.approx(0.5e-4 * report["crank"]["mass_g"], rel=1e-12)
    assert report["input"]["format"] == "stl"
    assert jobs.run("verify", tmp_path / "out" / "report.json", "--independent") == 0
    data = (tmp_path / "out" / "balanced.stl").read_bytes()
    assert data.startswith(b"solid ")  # the kind that came in
    assert len(FORMATS["stl"].read(data).soup) == report["outputs"]["solid"]["triangles"]


@pytest.mark.parametrize("name", [name for name in MESHES if name not in CARRY])
def test_a_unit_is_required_where_the_format_carries_none(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = job_on(tmp_path, name, encode(crank_mesh(), name, 1.0), None)
    assert jobs.run("balance", job) == 3
    assert f"crankshaft.unit is missing; {name.upper()} carries no unit" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "said"), [("3mf", "millimeter"), ("glb", "m")])
def test_another_unit_than_the_file_carries_is_an_error(
    name: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scale = 1000.0 if name in IN_METRES else 1.0
    job = job_on(tmp_path, name, encode(crank_mesh(), name, scale), "inch")
    assert jobs.run("balance", job) == 3
    assert f"the file is in {said}, the unit given is inch" in capsys.readouterr().err
    assert jobs.run("inspect", tmp_path / f"crank.{name}", "--unit", "inch") == 3


@pytest.mark.parametrize("name", MESHES)
def test_inspect_reads_every_format(name: str, tmp_path: Path, plain: Report) -> None:
    path = tmp_path / f"crank.{name.upper()}"  # endings in capitals are endings too
    path.write_bytes(encode(crank_mesh(), name, 1000.0 if name in IN_METRES else 1.0))
    unit = [] if name in CARRY else ["--unit", "mm"]
    assert (
        jobs.run("inspect", path, *unit, "--body", "all", "--no-crankpin", "--json", tmp_path / "r.json") == 0
    )
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert report["crank"]["mass_g"] == pytest.approx(plain["crank"]["mass_g"], rel=1e-6)


# --- several bodies -----------------------------------------------------------------------------------------

BODY_JOB = """
[crankshaft]
file = "crank.{name}"
{unit}
density_kg_m3 = 7850.0
{body}
[engine.rotating_g]
rod = 130.0

[engine.reciprocating_g]
piston = 260.0

[balance]
factor = 0.28
grade = 16
speed_rpm = 9000

[correction]
method = "shoulder"
"""


def joined(meshes: list[Mesh]) -> Mesh:
    """Return meshes as one, each for itself: what overlaps stays double."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, offsets[:-1], strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(triangles))


@pytest.fixture(scope="module")
def whole() -> Solid:
    return make_crank([0.0], Shape(segments=48))[0]


@pytest.fixture(scope="module")
def parts(whole: Solid) -> list[Solid]:
    """The crank cut across into three parts that overlap by 2 mm, like parts pressed up."""
    low, high = whole.bounds
    cuts = np.linspace(low[2], high[2], 4)
    parts = []
    for k in range(3):
        first, last = low.copy(), high.copy()
        first -= 1.0
        last += 1.0
        first[2] = low[2] - 1.0 if k == 0 else cuts[k] - 1.0
        last[2] = high[2] + 1.0 if k == 2 else cuts[k + 1] + 1.0
        parts.append(whole & Solid.box(first, last))
    return parts


def body_job(folder: Path, name: str, mesh: Mesh, body: str) -> Path:
    data = encode(mesh, name, 1000.0 if name in IN_METRES else 1.0)
    (folder / f"crank.{name}").write_bytes(data)
    unit = "" if name in CARRY else 'unit = "mm"'
    job = folder / "job.toml"
    line = f"body = {body}" if body else ""
    job.write_text(BODY_JOB.format(name=name, unit=unit, body=line), encoding="utf-8")
    return job


@pytest.mark.parametrize("name", MESHES)
def test_overlapping_bodies_taken_together_count_once(
    name: str, tmp_path: Path, whole: Solid, parts: list[Solid]
) -> None:
    job = body_job(tmp_path, name, joined([part.mesh for part in parts]), '"all"')
    report = jobs.computed(job, tmp_path / "out")
    assert report["input"]["bodies"] == 3
    assert report["crank"]["volume_mm3"] == pytest.approx(whole.volume_mm3, rel=1e-6)
    assert any("3 bodies united; overlaps of" in text for text in report["input"]["repairs"])
    assert jobs.run("verify", tmp_path / "out" / "report.json", "--independent") == 0


@pytest.mark.parametrize("name", MESHES)
def test_several_bodies_are_listed_by_number_volume_and_size(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: Solid
) -> None:
    aside = Solid.box(np.array([200.0, 0.0, 0.0]), np.array([210.0, 20.0, 30.0]))
    both = joined([aside.mesh, whole.mesh])
    assert jobs.run("balance", body_job(tmp_path, name, both, "")) == 3
    said = capsys.readouterr().err
    assert "the file holds 2 bodies (1: " in said
    assert "2: 6000 mm³, 10 × 20 × 30 mm" in said.replace("5999.99", "6000")  # float32, in metres
    assert "expected body = a number, or 'all' to unite them" in said
    report = jobs.computed(body_job(tmp_path, name, both, "1"), tmp_path / "out")
    assert report["crank"]["volume_mm3"] == pytest.approx(whole.volume_mm3, rel=1e-6)
    assert report["input"]["bodies"] == 2
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0
    capsys.readouterr()
    assert jobs.run("balance", body_job(tmp_path, name, both, "3"), "-o", tmp_path / "none") == 3
    assert "body 3 does not exist; the file holds 2 bodies" in capsys.readouterr().err


def test_touching_bodies_taken_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: Solid
) -> None:
    """Halves that share a face: the face is inside once they are one."""
    low, high = whole.bounds
    middle = np.array([high[0] + 1.0, high[1] + 1.0, 0.5 * (low[2] + high[2])])
    lower = whole & Solid.box(low - 1.0, middle)
    upper = whole - Solid.box(low - 1.0, middle)
    both = joined([lower.mesh, upper.mesh])
    assert jobs.run("balance", body_job(tmp_path, "off", both, "")) == 3
    assert "the file holds 2 bodies" in capsys.readouterr().err
    job = body_job(tmp_path, "off", both, '"all"')
    report = jobs.computed(job, tmp_path / "out")
    assert report["input"]["bodies"] == 2
    assert report["crank"]["volume_mm3"] == pytest.approx(whole.volume_mm3, rel=1e-9)
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0


def test_a_workshop_of_bodies_is_listed_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No crank is sought in all of them together: that would take minutes."""
    bar = Solid.revolved(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 20.0], [0.0, 20.0]]), 60).mesh.corners
    places = [np.array([10.0 * (k % 11), 10.0 * (k // 11), 0.1 * k]) for k in range(115)]
    data = encode(mesh_of_soup(np.concatenate([bar + place for place in places])), "stl", 1.0)
    (tmp_path / "many.stl").write_bytes(data)
    started = time.process_time()
    assert jobs.run("inspect", tmp_path / "many.stl", "--unit", "mm") == 3
    assert time.process_time() - started < 8.0
    said = capsys.readouterr().err
    assert "the file holds 115 bodies (1: 1003" in said
    assert "; and 103 smaller ones); expected body = a number, or 'all' to unite them" in said
    assert "together" not in said
