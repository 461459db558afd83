"""A flexible frame below the mounts, against two bodies by own matrices, energy, and a frame of no give."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.engines.mounts.rigid_body import Mount, MountedEngine, read_modes
from autobalance.errors import JobError
from tests.reference.test_mounts import preset_single, shaken_job

NODES = [[-250.0, 700.0, 0.0], [-250.0, -650.0, -80.0], [-250.0, -650.0, 80.0], [0.0, 0.0, -300.0]]


def csv_text(modes: list[tuple[float, float, Any]]) -> str:
    lines = ["mode,frequency_hz,damping_ratio,x_mm,y_mm,z_mm,ux,uy,uz"]
    for number, (frequency, damping, shape) in enumerate(modes, 1):
        for node, row in zip(NODES, np.broadcast_to(np.asarray(shape, dtype=float), (4, 3)), strict=True):
            lines.append(",".join(f"{each:.15g}" for each in (number, frequency, damping, *node, *row)))
    return "\n".join(lines) + "\n"


def uff_text(modes: list[tuple[float, float, Any]], modal_mass: float) -> str:
    """Universal file: nodes (2411, metres), and normal modes (55) that are not normalised."""
    lines = ["    -1", "  2411"]
    for number, node in enumerate(NODES, 1):
        lines += [f"{number:10d}{1:10d}{1:10d}{11:10d}"]
        lines += ["".join(f"{each / 1e3:25.16E}" for each in node).replace("E", "D")]
    lines += ["    -1"]
    for place, (frequency, damping, shape) in enumerate(modes, 1):
        lines += ["    -1", "    55", *["NONE"] * 5, "".join(f"{each:10d}" for each in (1, 2, 2, 8, 2, 3))]
        lines += ["".join(f"{each:10d}" for each in (2, 4, 0, place))]
        lines += ["".join(f"{each:13.5E}" for each in (frequency, modal_mass, damping, 0.0))]
        for number, row in enumerate(np.broadcast_to(np.asarray(shape, dtype=float), (4, 3)), 1):
            lines += [f"{number:10d}", "".join(f"{each * math.sqrt(modal_mass):13.5E}" for each in row)]
        lines += ["    -1"]
    return "\n".join(lines) + "\n"


def test_one_mode_is_a_second_body_on_a_spring(tmp_path: Path) -> None:
    """A frame of 30 kg that moves along x alone, on ground at 40 Hz: seven unknowns by own matrices."""
    frame_kg, frame_hz, damping = 30.0, 40.0, 0.03
    (tmp_path / "frame.csv").write_text(
        csv_text([(frame_hz, damping, [1.0 / math.sqrt(frame_kg), 0.0, 0.0])])
    )
    job = shaken_job()
    job["mounts"]["frame"] = {"file": str(tmp_path / "frame.csv")}
    job["mounts"]["point"].append({"name": "rail", "at_mm": NODES[3], "on": "frame"})
    report = ab.forces(job, preset_single(), mounts=True, factors=[0.6]).report["mounts"]
    mounts = job["mounts"]
    centre = np.array(mounts["centre_mm"])
    mass = np.zeros((7, 7))
    mass[:3, :3], mass[6, 6] = np.eye(3) * 145e3, frame_kg * 1e3
    mass[3:6, 3:6] = np.array(mounts["inertia_kg_mm2"]) * 1e3
    stiff = np.zeros((7, 7), dtype=complex)
    stiff[6, 6] = frame_kg * 1e3 * (2.0 * math.pi * frame_hz) ** 2 * (1.0 + 2.0j * damping)
    for each in mounts["mount"]:
        x, y, z = np.array(each["at_mm"]) - centre
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        rows = np.hstack([np.eye(3), turned, [[-1.0], [0.0], [0.0]]])
        stiff += rows.T @ np.diag(np.array(each["k_N_mm"]) * 1e6 * (1.0 + 0.16j)) @ rows
    square = np.linalg.eigvals(np.linalg.solve(mass, stiff.real)).real
    own = np.sort(np.sqrt(square)) / (2.0 * math.pi)
    assert report["natural_frequencies_hz"] == pytest.approx(own, rel=1e-9)
    state = next(each for each in report["orders"] if each["name"] == "balanced")
    rail = next(each for each in state["places"] if each["name"] == "rail")
    crank = preset_single().throws[0].crank_radius_mm
    for row in rail["orders"]:
        assert row["axis"] == "x"
        if row["order"] != 2.0:
            continue
        for place, rpm in enumerate(report["speeds_rpm"]):
            speed = rpm * math.pi / 30.0
            angle = 2.0 * math.pi * np.arange(720) / 720
            x = crank * np.cos(angle) + np.sqrt(120.0**2 - (crank * np.sin(angle)) ** 2)
            second = np.fft.irfft(-(np.arange(361) ** 2) * np.fft.rfft(x), 720) * speed**2
            slope = np.fft.irfft(1j * np.arange(361) * np.fft.rfft(x), 720)
            wrench = np.zeros((720, 7))
            wrench[:, 0] = -330.0 * second
            wrench[:, 3:6] = np.cross(-centre, wrench[:, :3])
            wrench[:, 5] += 330.0 * second * slope
            push = np.fft.rfft(wrench, axis=0)[2] / 360.0
            motion = np.linalg.solve(stiff - (2.0 * speed) ** 2 * mass, push)
            assert row["velocity_mm_s"][place] == pytest.approx(2.0 * speed * abs(motion[6]), rel=1e-5)
    # the best factor is another for the rail than for the bar
    assert set(report["best_factor_for"]) == {"bar", "rail"}


@pytest.mark.parametrize("on_frame", [True, False])
def test_power_that_goes_in_is_what_mounts_and_frame_take(on_frame: bool) -> None:
    """Energy balance to 1e-9: ½ Re(Fᴴ v) = ½ ω Σ η k |stretch|² + ½ ω Σ 2ζ ω_m² |η|²."""
    rng = np.random.default_rng(3)
    from autobalance.engines.mounts.rigid_body import FrameModes

    modes = FrameModes(
        np.array([60.0, 150.0, 400.0]),
        np.array([0.01, 0.03, 0.02]),
        np.array(NODES),
        rng.normal(size=(3, 4, 3)) * 5e-3,
    )
    held = tuple(
        Mount(np.array(at), rng.uniform(1e7, 6e7, 3), 0.07, viscous_g_s=rng.uniform(1e4, 1e5, 3))
        for at in NODES[:3]
    )
    shapes = tuple(modes.at(each.at_mm, 1.0, "a mount") for each in held)
    below = (modes, shapes) if on_frame else ()
    engine = MountedEngine(145e3, np.array([120.0, -60.0, 0.0]), np.diag([9e9, 1.1e10, 1.4e10]), held, *below)
    omega = np.array([30.0, 90.0, 250.0, 700.0])
    wrench = rng.normal(size=(4, 6)) + 1j * rng.normal(size=(4, 6))
    motion = engine.response(omega, wrench)
    power = 0.5 * np.real(np.sum(np.conj(wrench) * 1j * omega[:, None] * motion[:, :6], axis=1))
    taken = np.zeros(4)
    if on_frame:
        lost = 2.0 * modes.damping_ratio * modes.frequency_rad_s**2
        taken = 0.5 * omega * np.sum(lost * np.abs(motion[:, 6:]) ** 2, axis=1)
    for number, mount in enumerate(held):
        stretch = np.abs(motion @ engine.stretches(number).T) ** 2
        taken += 0.5 * omega * np.sum(mount.spring_g_s2(omega).imag * stretch, axis=1)
    assert power == pytest.approx(taken, rel=1e-9)


def test_a_frame_of_no_give_is_the_ground(tmp_path: Path) -> None:
    """Limit: frequencies → ∞."""
    (tmp_path / "frame.csv").write_text(
        csv_text([(1e7, 0.02, [0.1, 0.2, -0.1]), (2e7, 0.02, [0.1, 0.0, 0.3])])
    )
    rigid, framed = shaken_job(), shaken_job()
    framed["mounts"]["frame"] = {"file": str(tmp_path / "frame.csv")}
    one, other = (
        ab.forces(job, preset_single(), mounts=True, factors=[0.6]).report["mounts"]
        for job in (rigid, framed)
    )
    for mine, its in zip(one["responses"][0]["places"], other["responses"][0]["places"], strict=True):
        assert mine["velocity_rms_mm_s"] == pytest.approx(its["velocity_rms_mm_s"], rel=1e-6)
    assert one["best_factor_for"] == other["best_factor_for"]


def test_universal_files_and_tables_say_the_same(tmp_path: Path) -> None:
    modes = [
        (40.0, 0.03, [0.2, 0.0, 0.1]),
        (95.0, 0.0, [[0.1, 0.2, 0.3], [0.0, 0.1, 0.0], [0.3, 0.0, 0.1], [0.2, 0.2, 0.2]]),
    ]
    (tmp_path / "frame.csv").write_text(csv_text([modes[0], (95.0, 0.05, modes[1][2])]))
    (tmp_path / "frame.unv").write_text(uff_text(modes, 2.5))
    table, universal = (read_modes(tmp_path / name, "m", 0.05) for name in ("frame.csv", "frame.unv"))
    assert universal.frequency_rad_s == pytest.approx(table.frequency_rad_s, rel=1e-5)
    assert universal.damping_ratio == pytest.approx(table.damping_ratio)
    assert universal.places_mm == pytest.approx(table.places_mm, abs=1e-9)
    assert universal.shapes == pytest.approx(table.shapes, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("frame.csv", "mode,frequency_hz\n1,40\n", "columns x_mm, y_mm, z_mm, ux, uy, uz are missing"),
        ("frame.unv", "    -1\n  2411\n    -1\n", "no dataset 55"),
        ("frame.csv", csv_text([(40.0, -0.1, [1.0, 0.0, 0.0])]), "negative damping"),
    ],
)
def test_files_that_are_no_modes_are_refused(tmp_path: Path, name: str, text: str, says: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(JobError, match=says):
        read_modes(tmp_path / name, "m", 0.02)


def test_mounts_without_a_node_and_points_without_a_frame_are_refused(tmp_path: Path) -> None:
    (tmp_path / "frame.csv").write_text(csv_text([(40.0, 0.02, [1.0, 0.0, 0.0])]))
    job = shaken_job()
    job["mounts"]["frame"] = {"file": str(tmp_path / "frame.csv")}
    job["mounts"]["mount"][1]["at_mm"] = [-250.0, -650.0, -70.0]
    with pytest.raises(JobError, match=r"no node within 5 mm of mount 2; the nearest is at .*, 10 mm away"):
        ab.forces(job, preset_single(), mounts=True)
    bare = shaken_job()
    bare["mounts"]["point"][0]["on"] = "frame"
    with pytest.raises(JobError, match=r"'bar' is on the frame; .* is missing"):
        ab.forces(bare, preset_single(), mounts=True)
