"""The public functions: objects in, objects out, nothing written until asked."""

import math
import os
import pickle
import signal
import subprocess
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.bundled import bundled_folder
from tests import jobs
from tests.unit.test_milp import printing_milp

JOB = bundled_folder() / "crf250r" / "drafted" / "factor-0.28.toml"


@pytest.fixture(scope="module")
def coarse_job(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The job on its crank in fewer facets."""
    return jobs.bundled_job(tmp_path_factory.mktemp("job"))


@pytest.fixture(scope="module")
def result(coarse_job: Path) -> ab.BalanceResult:
    return ab.balance(ab.read_job(coarse_job))


@pytest.fixture(scope="module")
def crank(coarse_job: Path) -> ab.Crank:
    file = coarse_job.with_name("crank.stl")
    return ab.read_crank(file, unit="mm", density_kg_m3=7850.0, crankpin_in_file=False)


def without_crank() -> dict[str, Any]:
    raw = {key: value for key, value in ab.read_job(JOB).raw.items() if key != "crankshaft"}
    return {**raw, "crankshaft": {"crankpin_in_file": False}}


def test_a_result_has_the_values_of_its_report(result: ab.BalanceResult) -> None:
    assert result.outcome == result.report["outcome"] == "within_tolerance"
    assert result.reason is None
    assert result.residual.magnitude_g_mm == result.report["residual"]["magnitude_g_mm"]
    assert result.initial.planes[1].name == "B"
    assert result.tolerance.rotor_mass_g == pytest.approx(2700.0, abs=1.5)  # 2699.9 in all its facets
    eccentricity_mm = 6.3 / (15200 * 2.0 * math.pi / 60.0)  # ISO 21940-11, G over the angular speed
    assert result.tolerance.permissible_g_mm == pytest.approx(
        eccentricity_mm * result.tolerance.rotor_mass_g, rel=1e-12
    )
    assert [each.depth_mm for each in result.corrections] == [
        each["depth_mm"] for each in result.report["corrections"]
    ]
    assert result.steps[-1].measured_g_mm == result.residual.magnitude_g_mm
    assert result.measured_on == "file"
    assert "within_tolerance" in repr(result)
    assert "<table>" in result._repr_html_()


def test_the_corrected_crank_is_the_solid_of_the_report(result: ab.BalanceResult) -> None:
    solid = result.report["outputs"]["solid"]
    assert result.crank.mass_g == pytest.approx(solid["mass_g"], rel=1e-9)
    assert result.crank.volume_mm3 == pytest.approx(solid["volume_mm3"], rel=1e-9)
    assert np.allclose(result.crank.inertia_kg_mm2, solid["inertia_kg_mm2"], rtol=1e-9, atol=1e-9)
    assert np.array_equal(result.crank.file_to_rotor, result.before.file_to_rotor)


def test_what_is_written_is_verified(result: ab.BalanceResult, tmp_path: Path) -> None:
    files = result.write(tmp_path / "out", only=("json",))
    assert sorted(path.name for path in files) == ["balanced.stl", "report.json"]
    checked = ab.verify(tmp_path / "out" / "report.json", independent=True)
    assert checked.holds
    assert checked.within_tolerance
    assert len(checked.claims) > 50
    residual = next(each for each in checked.claims if each.name == "residual.magnitude_g_mm")
    assert residual.value == result.residual.magnitude_g_mm
    assert residual.measured == pytest.approx(residual.value, rel=1e-6)
    assert "read from its file again, within" in residual.how
    with pytest.raises(ab.AutobalanceError, match="only names 'doc'"):
        result.write(tmp_path / "other", only=("doc",))
    assert not (tmp_path / "other").exists()


@pytest.mark.slow
def test_a_mesh_is_balanced_in_memory_and_its_files_verified(crank: ab.Crank, tmp_path: Path) -> None:
    mesh = ab.crank_from_mesh(crank.to_trimesh(), density_kg_m3=7850.0, unit="mm", crankpin_in_file=False)
    assert mesh.mass_g == pytest.approx(crank.mass_g, rel=1e-12)
    done = ab.balance(ab.Job.from_dict(without_crank()), crank=mesh)
    assert done.outcome == "within_tolerance"
    assert done.measured_on == "mesh"
    done.write(tmp_path, only=("json",))
    assert ab.verify(tmp_path / "report.json", independent=True).within_tolerance


def test_a_crank_needs_no_trimesh(crank: ab.Crank) -> None:
    again = ab.crank_from_mesh(
        crank.vertices_mm / 25.4, crank.triangles, 7850.0, unit="inch", crankpin_in_file=False
    )
    assert again.mass_g == pytest.approx(crank.mass_g, rel=1e-9)
    with pytest.raises(ab.AutobalanceError, match=r"expected \(m, 3\) rows"):
        ab.crank_from_mesh(crank.vertices_mm)
    with pytest.raises(ab.AutobalanceError, match=r"expected \(n, 3\) numbers"):
        ab.crank_from_mesh(crank.vertices_mm[:, :2], crank.triangles)


def test_a_crank_has_the_fields_of_a_report(crank: ab.Crank) -> None:
    report = ab.inspect(crank).report
    for own, told in zip(crank.main_journals, report["crank"]["main_journals"], strict=True):
        assert (own.number, own.diameter_mm, own.width_mm) == (
            told["number"],
            told["diameter_mm"],
            told["width_mm"],
        )
    assert crank.throws[0].angle_deg == report["crank"]["throws"][0]["angle_deg"]
    assert crank.webs[1].z_max_mm == report["crank"]["webs"][1]["z_max_mm"]
    assert [face.id for face in crank.faces] == [face["id"] for face in report["faces"]]
    assert crank.faces[0].file_centroid_mm.tolist() == report["faces"][0]["file_centroid_mm"]
    assert crank.unbalance.angle_deg == report["initial"]["angle_deg"]
    assert crank.unbalance.moment_g_mm2.tolist() == report["initial"]["moment_g_mm2"]


@pytest.mark.parametrize("ending", ["3mf", "glb", "ply", "off", "obj"])
def test_a_crank_is_written_in_any_format(crank: ab.Crank, ending: str, tmp_path: Path) -> None:
    path = crank.write(tmp_path / f"copy.{ending}")
    unit = None if ending in ("3mf", "glb") else "mm"
    again = ab.read_crank(path, unit=unit, crankpin_in_file=False)
    assert again.mass_g == pytest.approx(crank.mass_g, rel=1e-6)
    with pytest.raises(ab.AutobalanceError, match=r"a mesh cannot be saved as \.step"):
        crank.write(tmp_path / "copy.step")


def test_density_and_crank_are_said_once(crank: ab.Crank) -> None:
    values = without_crank()
    values["crankshaft"]["density_kg_m3"] = 7800.0
    with pytest.raises(ab.AutobalanceError, match="expected the same"):
        ab.balance(ab.Job.from_dict(values), crank=crank)
    with pytest.raises(ab.AutobalanceError, match=r"crankshaft\.file is missing"):
        ab.balance(ab.Job.from_dict(without_crank()))


def test_progress_is_told_and_may_stop(coarse_job: Path) -> None:
    told: list[tuple[str, float]] = []

    class Enough(Exception):  # noqa: N818
        pass

    def progress(words: str, share: float) -> None:
        told.append((words, share))
        if words.startswith("cutting"):
            raise Enough

    with pytest.raises(Enough):
        ab.balance(ab.read_job(coarse_job), progress=progress)
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < shares[-1] < 1.0


def test_two_threads_may_balance_at_once(coarse_job: Path, result: ab.BalanceResult) -> None:
    found: list[float] = []

    def work() -> None:
        found.append(ab.balance(ab.read_job(coarse_job)).residual.magnitude_g_mm)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [result.residual.magnitude_g_mm] * 2


def test_threads_that_plan_holes_print_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """Not even at the descriptor, past Python, where HiGHS prints a line on some processors."""
    crank = ab.generate("single", segments=16).crank
    job = ab.Job.from_dict(
        {
            "engine": {"rotating_g": {"big_end": 134.0}, "reciprocating_g": {"piston": 261.5}},
            "balance": {"factor": 0.5, "grade": 16, "speed_rpm": 9000.0},
            "correction": {"method": "drill", "prefer": "most_inertia_removed"},
        }
    )
    with (
        pytest.MonkeyPatch.context() as patched,
        ThreadPoolExecutor(2) as threads,
    ):
        printing_milp(patched)
        found = [each.outcome for each in threads.map(lambda _: ab.balance(job, crank=crank), range(2))]
    assert found == ["within_tolerance"] * 2
    assert capfd.readouterr().out == ""


def _in_another_process(path: str) -> ab.BalanceResult:
    return ab.balance(ab.read_job(path))


@pytest.mark.slow
def test_results_come_back_from_a_spawned_process(coarse_job: Path, result: ab.BalanceResult) -> None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        other = pool.submit(_in_another_process, str(coarse_job)).result()
    assert other.residual.magnitude_g_mm == result.residual.magnitude_g_mm
    assert other.crank.mass_g == result.crank.mass_g


def test_results_pickle(result: ab.BalanceResult, crank: ab.Crank) -> None:
    again = pickle.loads(pickle.dumps(result))
    assert again.report == result.report
    assert again.crank.mass_g == result.crank.mass_g
    assert pickle.loads(pickle.dumps(crank)).unbalance.magnitude_g_mm == crank.unbalance.magnitude_g_mm


def test_the_process_stays_as_it_was(coarse_job: Path, tmp_path: Path) -> None:
    def state() -> tuple[Any, ...]:
        return (
            os.getcwd(),
            dict(os.environ),
            signal.getsignal(signal.SIGINT),
            signal.getsignal(signal.SIGTERM),
        )

    before = state()
    ab.balance(ab.read_job(coarse_job)).write(tmp_path, only=("json",))
    assert state() == before


def test_import_loads_nothing_heavy() -> None:
    code = "import sys, autobalance as ab; print([m for m in ('numpy', 'trimesh') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"


def test_every_public_name_is_there_and_no_room_is_called_like_a_function() -> None:
    rooms = {path.name.removesuffix(".py") for path in Path(ab.__file__).parent.iterdir()}
    assert ab.__all__ == dir(ab)
    assert not [name for name in ab.__all__ if name.startswith("_") and name != "__version__"]
    for name in ab.PUBLIC:
        assert getattr(ab, name) is not None
    verbs = {name for name in ab.PUBLIC if callable(getattr(ab, name)) and name.islower()}
    assert not verbs & rooms
    with pytest.raises(AttributeError, match="has no attribute 'rebalance'"):
        _ = ab.rebalance
