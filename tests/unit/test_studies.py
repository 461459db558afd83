"""The numbers behind studies: draws, effects, intervals, advice, and where tasks run."""

from __future__ import annotations

import importlib
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from multiprocessing import resource_tracker, util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.errors import FileError, UsageError
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.runtime import interruptible
from autobalance.studies import workers
from autobalance.studies.study import statistics
from autobalance.studies.study.advice import advise, sobol_shares
from autobalance.studies.study.statistics import (
    Draw,
    LinearModel,
    axis_effect,
    contributions,
    effect_of,
    linear_spread_g_mm,
    shift_effect,
    turn_effect,
    wilson_interval,
)
from tests.worker_tasks import square_unless_killed, threads_after

BODY = Moments.point(7.0, np.array([3.0, -2.0, 11.0])) + Moments.point(5.0, np.array([-1.0, 4.0, -6.0]))


# --- draws --------------------------------------------------------------------------------------------------


def test_a_crank_is_the_same_whatever_the_number() -> None:
    few = statistics.deviations(3, "a", 7, 2.0, "normal")
    many = statistics.deviations(3, "a", 9000, 2.0, "normal")
    assert (many[:7] == few).all()
    assert not (statistics.deviations(4, "a", 7, 2.0, "normal") == few).any()
    assert not (statistics.deviations(3, "b", 7, 2.0, "normal") == few).any()


def test_distributions_have_their_spread() -> None:
    normal = statistics.deviations(1, "a", 100_000, 2.0, "normal")
    assert (np.abs(normal) <= 2.0).mean() == pytest.approx(0.95, abs=0.003)
    even = statistics.deviations(1, "a", 100_000, 2.0, "rectangular")
    assert np.abs(even).max() <= 2.0
    assert even.std() == pytest.approx(2.0 / math.sqrt(3.0), rel=0.01)
    vectors = statistics.offsets(1, "a", 100_000, 2.0, "normal")
    assert vectors.var(axis=0).sum() == pytest.approx((2.0 / statistics.Z_95) ** 2, rel=0.02)


def test_a_latin_hypercube_has_one_number_in_each_part() -> None:
    share = statistics.uniform(5, "a", 1000, "latin_hypercube")
    assert (np.sort((share * 1000).astype(int)) == np.arange(1000)).all()


def test_wilsons_interval_is_the_published_one() -> None:
    found = wilson_interval(15, 148)  # Newcombe 1998, table I: 15/148
    assert found == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson_interval(0, 20)[0] == 0.0


# --- effects ------------------------------------------------------------------------------------------------


def moved(body: Moments, motion: Any) -> Any:
    return effect_of(body.moved(motion)) - effect_of(body)


def test_a_shift_changes_what_moving_the_body_does() -> None:
    motion = np.eye(4)
    motion[:3, 3] = 1e-6 * np.array([0.3, 0.5, -0.8])
    found = np.array([0.3, 0.5, -0.8]) @ shift_effect(BODY, np.eye(3))
    assert found == pytest.approx(moved(BODY, motion) / 1e-6, rel=1e-5)


@pytest.mark.parametrize("axis", np.eye(3))
def test_a_turn_changes_what_turning_the_body_does(axis: Any) -> None:
    from scipy.spatial.transform import Rotation

    about, angle = np.array([1.0, 2.0, 3.0]), 1e-6
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(angle * axis).as_matrix()
    motion[:3, 3] = about - motion[:3, :3] @ about
    found = turn_effect(BODY, about, axis[None])[0]
    assert found == pytest.approx(moved(BODY, motion) / angle, rel=1e-4, abs=1e-3)


def test_both_journals_off_together_shift_the_body() -> None:
    both = axis_effect(BODY, (-20.0, 35.0), 0) + axis_effect(BODY, (-20.0, 35.0), 1)
    assert both == pytest.approx(-shift_effect(BODY, np.eye(3)[:2]))


def model_of(*pms: float) -> LinearModel:
    tolerance = Tolerance.of(
        grade_mm_s=6.3,
        service_speed_rad_s=1591.74,
        rotor_mass_g=2700.0,
        z_centre_mm=0.0,
        planes_z_mm=(-40.0, 40.0),
        judge="dynamic",
    )
    effects = [np.array([[10.0, 0.0, 50.0, 0.0]]), np.array([[0.0, 4.0, 0.0, 0.0]])]
    made = [
        Draw(name, name, "g", pm, "normal", effect, 100.0)
        for name, pm, effect in zip("ab", pms, effects, strict=True)
    ]
    return LinearModel(np.zeros(4), made, tolerance)


def test_contributions_sum_to_one_and_the_spread_to_the_root_sum() -> None:
    model = model_of(0.3, 0.5)
    assert linear_spread_g_mm(model.covariance()) == pytest.approx(math.hypot(3.0, 2.0))
    found = contributions(model)
    assert [each.name for each in found] == ["a", "b"]
    assert [each.share for each in found] == [pytest.approx(9.0 / 13.0), pytest.approx(4.0 / 13.0)]
    assert found[0].effect_g_mm == pytest.approx((3.0, 3.0))
    for plane in (0, 1):
        assert sum(each.plane_shares[plane] for each in found if each.plane_shares) == pytest.approx(1.0)


def test_advice_holds_when_it_is_followed() -> None:
    model = model_of(1.2, 0.5)

    def within(made: LinearModel) -> float:
        sampled = {draw.label: draw.sampled(1, 4000, "random") for draw in made.draws}
        return float((made.used_shares(made.states(sampled)) <= 1.0).mean())

    drawn = {draw.label: draw.sampled(1, 4000, "random") for draw in model.draws}
    best, other = advise(model, drawn, 0.95)
    assert (best.name, other.name) == ("a", "b")
    assert other.pm_needed is None
    assert best.pm_needed is not None
    assert within(model) < 0.95 <= within(model_of(best.pm_needed, 0.5)) == best.probability_within
    assert within(model_of(best.pm_needed * 1.02, 0.5)) < 0.95


# --- workers ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("deaths", "lost"), [(2, False), (3, True)])
def test_tasks_of_dead_workers_are_done_by_others(tmp_path: Path, deaths: int, lost: bool) -> None:
    (tmp_path / "deaths").write_text(str(deaths))
    (tmp_path / "marks").mkdir()
    tasks = [(number, str(tmp_path / "marks")) for number in range(5)]
    with workers.workers_of(2) as pool:
        ends = {done.number: done for done in pool.run(square_unless_killed, tasks)}
    assert sorted(ends) == list(range(5))
    assert ends[2].lost is lost
    assert ends[2].attempt == 3
    assert {n: end.value for n, end in ends.items() if not end.lost} == {
        n: n * n for n in range(5) if not (lost and n == 2)
    }


@pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX")
def test_ctrl_c_waits_until_a_worker_that_is_being_started_has_all_it_needs(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Started by halves, it would complain of the other half on the screen."""
    begin, begun = util.spawnv_passfds, []

    def interrupted(*given: Any) -> int:
        begun.append(begin(*given))
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        return begun[-1]

    resource_tracker.ensure_running()
    monkeypatch.setattr(util, "spawnv_passfds", interrupted)
    with interruptible(), pytest.raises(KeyboardInterrupt), workers.workers_of(1, alone=False) as pool:
        next(pool.run(abs, [-1]))
    with pytest.raises(ChildProcessError):  # it was waited for
        os.waitpid(begun[0], 0)
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="a process is kept to a core on Linux alone")
def test_a_worker_works_in_one_thread() -> None:
    """Besides it there is only the one that waits for the parent's end."""
    with workers.workers_of(1, alone=False) as pool:
        (done,) = pool.run(threads_after, [6000])
    assert done.value == 2


def test_no_worker_is_not_enough() -> None:
    with pytest.raises(UsageError, match="workers is 0"), workers.workers_of(0):
        pass


def test_a_cluster_that_is_not_there_is_refused() -> None:
    with (
        pytest.raises(FileError, match=r"did not answer within 0\.5 s"),
        workers.workers_of(None, "tcp://127.0.0.1:9", 0.5),
    ):
        pass


# --- Sobol's shares -----------------------------------------------------------------------------------------


def far_from_zero(nominal: float) -> LinearModel:
    made = model_of(0.3, 0.5)
    static = replace(made.tolerance, planes=(), judge="static")
    return LinearModel(np.array([nominal, 0.0, 0.0, 0.0]), made.draws, static)


def test_shares_of_a_sum_are_those_of_its_terms() -> None:
    found = sobol_shares(far_from_zero(1e4), 1, 1 << 14)  # far out the magnitude is the component along x
    assert found.linear
    shares = {each.name: each for each in found.shares}
    assert (shares["a"].first, shares["a"].total) == pytest.approx((1.0, 1.0), abs=0.02)
    assert (shares["b"].first, shares["b"].total) == pytest.approx((0.0, 0.0), abs=0.02)


def test_shares_of_a_magnitude_are_those_of_quadrature() -> None:
    """At zero |U| = √(a²X² + b²Y²), X and Y normal: its shares by Gauss and Hermite's rule."""
    found = sobol_shares(far_from_zero(0.0), 1, 1 << 15)
    assert not found.linear
    x, weight = np.polynomial.hermite_e.hermegauss(201)
    weight = weight / weight.sum()
    grid = np.hypot(3.0 * x[:, None], 2.0 * x[None, :])
    mean = weight @ grid @ weight
    variance = weight @ (grid**2) @ weight - mean**2
    alone = {"a": weight @ (grid @ weight - mean) ** 2, "b": weight @ (weight @ grid - mean) ** 2}
    for each in found.shares:
        other = "b" if each.name == "a" else "a"
        assert each.first == pytest.approx(alone[each.name] / variance, abs=0.02)
        assert each.total == pytest.approx(1.0 - alone[other] / variance, abs=0.02)


def test_a_worker_without_this_package_can_say_so() -> None:
    cloudpickle: Any = importlib.import_module("cloudpickle")
    sent = repr(cloudpickle.dumps(workers.version_asker()))
    script = (
        "import sys; sys.modules['autobalance'] = None\n"
        f"import cloudpickle\nprint(cloudpickle.loads({sent})())"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "None"
