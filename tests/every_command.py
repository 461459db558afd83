"""Every command that has a report, on small inputs of a folder of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from runpy import run_path
from typing import Any

import numpy as np

import autobalance as ab
from autobalance.solid.csg.shape import Prism, polygon, tessellated
from autobalance.toml_files.document import toml_text
from tests import jobs
from tests.rods import FlatRod

SAID = run_path(str(jobs.ROOT / "examples" / "every_verb.py"))
SCHEMAS = {"balance": "report", "machine": "machine-report"}
"""Name of the schema of a command's report, where a file that it reads has the command's own."""
BENCH = {"rotor": {"inertia_kg_mm2": 2847.0, "weight_N": 25.0}, "bearing": SAID["DRY"]}
FOUR = {"inertia": [0.2, 0.3, 0.25, 0.9], "spring": [9e4, 8e4, 7e4]}
TRAIN = {
    "speed_rpm": [500.0, 6000.0],
    "points": 5,
    "inertia": [{"name": f"i{n}", "kg_mm2": 1e6 * each} for n, each in enumerate(FOUR["inertia"])],
    "spring": [{"N_m_rad": each, "diameter_mm": 40.0} for each in FOUR["spring"]],
    "excitation": [{"station": 1, "order": 2.0, "N_m": 30.0}],
    "pendulum": {"order": 2.0, "distance_mm": 40.0, "mass_g": 300.0, "station": 2},
    "damper": [{"station": 1, "kind": "viscous", "inertia_kg_mm2": 2e4, "tune": True}],
    "branch": [{"from": 2, "inertia": [{"name": "pump", "kg_mm2": 1e4}], "spring": [{"N_m_rad": 2e4}]}],
}
FILES: Mapping[str, Mapping[str, Any]] = {
    "bearing": {**SAID["DRY"], "load_N": 25.0},
    "bench": BENCH,
    "chain": SAID["CHAIN"],
    "machine": SAID["MACHINE"],
    "reading": SAID["READING"],
    "shaft": SAID["SHAFT"],
    "tool": SAID["TOOL"],
    "train": TRAIN,
    "trials": SAID["TRIALS"],
}


def write_inputs(folder: Path) -> None:
    """Write a crank, jobs, a balanced crank's report, and whatever else a command of ``CALLS`` reads."""
    for name, values in FILES.items():
        (folder / f"{name}.toml").write_text(toml_text(values), encoding="utf-8")
    ab.generate("single", file=folder / "crank.stl", segments=16).write(folder)
    spread = SAID["JOB"].replace("big_end = 134.04", "big_end = { g = 134.04, pm = 0.5 }")
    engine = "[engine]\nrod_length_mm = 104.0\n[engine.rotating_g]"
    job = spread.replace("[engine.rotating_g]", engine)
    (folder / "job.toml").write_text(job, encoding="utf-8")
    (folder / "cycle.toml").write_text(
        f"{job}{toml_text({'cycle': SAID['CYCLE'], 'strength': SAID['STRENGTH']})}", encoding="utf-8"
    )
    jobs.computed(folder / "job.toml", folder / "done")
    (folder / "jobs").mkdir()
    (folder / "jobs" / "job.toml").write_text(job.replace("crank.stl", "../crank.stl"), encoding="utf-8")
    design = {
        "crankshaft": {**SAID["CRANKSHAFT"], "file": "crank.stl"},
        "engine": SAID["PARTS"],
        "balance": SAID["BALANCE"],
        "counterweight": [SAID["FREE"]],
        "envelope": {"radius_mm": 80.0},
        "search": {"objectives": ["mass_g"], "evaluations": 20},
    }
    (folder / "design.toml").write_text(toml_text(design), encoding="utf-8")
    rod = FlatRod(half_width=14.0, big_radius=11.0, small_radius=6.0, beyond_big=18.0, beyond_small=10.0)
    jobs.write_stl(folder / "rod.stl", tessellated(rod.shape, 48).mesh.corners)
    block = Prism(polygon([(0.0, 0.0), (60.0, 0.0), (60.0, 20.0), (0.0, 20.0)]), 0.0, 10.0)
    jobs.write_stl(folder / "block.stl", tessellated(block, 8).mesh.corners)
    time_s = np.arange(4000) / 2000.0
    rows = np.stack([time_s, 0.5 * np.cos(2.0 * np.pi * 25.0 * time_s)], axis=1)
    np.savetxt(folder / "signal.csv", rows, delimiter=",", header="time_s,accel_g", comments="")


CALLS: Mapping[str, str] = {
    "balance": "balance job.toml -o again --no-report",
    "batch": "batch jobs -o rows --workers 1",
    "bearing": "bearing bearing.toml",
    "bench": "bench bench.toml",
    "calc": "calc swept_volume_cm3 bore_mm=76.8 stroke_mm=53.8",
    "compare": "compare job.toml",
    "cycle": "cycle cycle.toml",
    "design": "design design.toml -o designs --workers 1",
    "fem": "fem block.stl --unit mm --modes 1 --size-mm 30",
    "factor": "factor job.toml",
    "forces": "forces job.toml",
    "generate": "generate single -o drawn.stl --segments 24",
    "grade": "grade --grade 6.3 --speed-rpm 9000 --mass 2000",
    "influence": "influence trials.toml",
    "inspect": "inspect job.toml --sections --suggest inertia_kg_mm2=2000",
    "jobs": "jobs . --find done",
    "machine": "machine machine.toml",
    "nc": "nc done/report.json tool.toml -o programs",
    "orders": "orders signal.csv --speed-rpm 1500",
    "parts": "parts job.toml",
    "recut": "recut done/report.json reading.toml -o second --no-report",
    "rod": "rod rod.stl --unit mm",
    "rotor": "rotor shaft.toml",
    "shafts": "shafts job.toml",
    "strength": "strength cycle.toml",
    "study": "study job.toml --samples 200 --exact 1 --workers 1",
    "torsion": "torsion cycle.toml",
    "verify": "verify done/report.json",
}
