"""Every public function of the package: an outside script that needs no private name and no file of its own.

python examples/every_verb.py
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import autobalance as ab

PARTS = {
    "rod_length_mm": 104.0,
    "rotating_g": {"big_end": 134.04},
    "reciprocating_g": {"small_end": 46.5, "piston": 215.0},
}
CORRECTIONS = {"method": "shoulder"}
BALANCE = {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000}
CRANKSHAFT = {"density_kg_m3": 7850.0, "unit": "mm"}
STRENGTH = {"pin_fillet_mm": 2.0, "material": {"tensile_MPa": 900.0}}
CYCLE = {"bore_mm": 76.8, "compression_ratio": 12.0, "heat_J": 600.0}
DRY = {"kind": "dry", "diameter_mm": 20.0, "mu": 0.1}
FILM = {"at": "A", "g_mm": 35.0, "angle_deg": 191.0}
READING = {"urr_percent": 95.0, "umar_g_mm": 0.5, "plane": [FILM, {**FILM, "at": "B"}]}
MACHINE = {
    "kind": "hard",
    "speed_rpm": 600.0,
    "planes_mm": [-40.0, 40.0],
    "rotor": {"mass_g": 2000.0, "z_mm": 0.0},
    "unbalance": [{"z_mm": 40.0, "g_mm": 100.0, "angle_deg": 30.0}],
}
TRIALS = {
    "initial": [[2.0, 0.0]],
    "trial": [{"plane": 1, "g_mm": 5.0, "angle_deg": 0.0, "readings": [[3.0, 0.0]]}],
}
CHAIN = {
    "speed_rpm": [500, 6000],
    "inertia": [{"name": "crank", "kg_mm2": 3000.0}, {"name": "flywheel", "kg_mm2": 9000.0}],
    "spring": [{"N_m_rad": 20000.0}],
}
SHAFT = {
    "speed_rpm": [0, 6000],
    "shaft": [{"length_mm": 1000.0, "outer_mm": 50.0}],
    "disc": [{"z_mm": 300.0, "mass_kg": 30.0, "polar_kg_mm2": 3e5, "diametral_kg_mm2": 1.6e5}],
    "bearing": [{"z_mm": 0.0, "k_n_m": 1e7}, {"z_mm": 1000.0, "k_n_m": 1e7}],
}
JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = 134.04
[engine.reciprocating_g]
piston = 261.5
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 9000
[correction]
method = "shoulder"
"""
TOOL = {
    "machine": {"post": "linuxcnc", "max_rpm": 8000},
    "zero": {"angle": "crankpin 1", "z_mm": "crankpin 1"},
    "tool": [
        {
            "number": 1,
            "kind": "end_mill",
            "diameter_mm": 12.0,
            "flute_mm": 30.0,
            "stick_out_mm": 110.0,
            "holder": [[32.0, 60.0]],
            "rpm": 2500,
            "feed_mm_min": 300.0,
        }
    ],
}
FREE = {"webs": [1, 2], "sector_deg": [100.0, 260.0], "hold_radius_mm": 26.0, "points": 8, "symmetric": True}


def main() -> int:
    """Draw a crank, measure and balance it, check the result, and ask everything else that can be asked."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        crank = measured(folder)
        within = balanced(crank, folder)
        around(crank, folder)
        return 0 if within else 4


def measured(folder: Path) -> ab.Crank:
    """Draw a crank, read it, and say what is in it."""
    drawn = ab.generate("single", file=folder / "crank.stl", segments=64)
    drawn.write(folder)
    crank = ab.read_crank(folder / "crank.stl", unit="mm", density_kg_m3=7850.0)
    print(crank)
    print(ab.inspect(crank).text())
    same = ab.crank_from_mesh(crank.vertices_mm, crank.triangles, density_kg_m3=7850.0)
    print(f"of a mesh: {same.mass_g:.1f} g")
    print(ab.init(folder / "crank.stl", file=folder / "job.toml", unit="mm").text())
    return crank


def balanced(crank: ab.Crank, folder: Path) -> bool:
    """Balance the crank, check what was written, cut again by a machine's reading, draw the sheet again."""
    tables = {"crankshaft": CRANKSHAFT, "engine": PARTS, "balance": BALANCE, "correction": CORRECTIONS}
    job = ab.Job.from_dict(tables)
    result = ab.balance(job, crank=crank)
    print(result, [cut.depth_mm for cut in result.corrections])
    result.write(folder / "balanced", only=("json",))
    report = folder / "balanced" / "report.json"
    checked = ab.verify(report, independent=True)
    print(checked.holds, checked.within_tolerance)
    print(ab.recut(report, READING).text())
    print(ab.nc(report, TOOL).text())
    print(ab.jobs(report.parent).text())
    print(ab.sheet(report, only=("pdf",)).text())
    with_cycle = ab.Job.from_dict({**tables, "cycle": CYCLE, "strength": STRENGTH})
    spread = {**PARTS, "rotating_g": {"big_end": {"g": 134.04, "pm": 0.5}}}
    for found in (
        ab.compare(job, crank=crank),
        ab.factor(job, crank=result.crank),
        ab.forces(job, crank=result.crank),
        ab.cycle(with_cycle, crank=result.crank),
        ab.strength(with_cycle, crank=result.crank),
        ab.shafts(job, crank=result.crank),
        ab.parts(job, crank=result.crank),
        ab.torsion(job, crank=result.crank),
        ab.study(ab.Job.from_dict({**tables, "engine": spread}), crank, samples=200, exact=1, workers=1),
        ab.grade(6.3, speed_rpm=9000, mass=result.crank.mass_g),
    ):
        print(found.text())
    return checked.within_tolerance


def around(crank: ab.Crank, folder: Path) -> None:
    """Ask what needs no job: formulas, bearings, machines, shafts, signals; many jobs; what extras offer."""
    time_s = np.arange(4000) / 2000.0
    signal = {"accel_g": 0.5 * np.cos(2.0 * np.pi * 25.0 * time_s)}
    bench = {"rotor": {"inertia_kg_mm2": 2847.0, "weight_N": 25.0}, "bearing": DRY}
    for found in (
        ab.calc("swept_volume_cm3", {"bore_mm": "76.8", "stroke_mm": "53.8"}),
        ab.bearing({**DRY, "load_N": 25.0}),
        ab.bench(bench),
        ab.influence(TRIALS),
        ab.machine(MACHINE),
        ab.orders(signal, sample_rate=2000.0, speed_rpm=1500),
        ab.rotor(SHAFT),
        ab.torsion(CHAIN),
    ):
        print(found.text())
    print(f"the schema of a job has {len(ab.schema('job')['properties'])} tables")
    (folder / "jobs").mkdir()
    crank.write(folder / "jobs" / "crank.stl")
    (folder / "jobs" / "one.toml").write_text(JOB, encoding="utf-8")
    print(f"the job asks for a factor of {ab.read_job(folder / 'jobs' / 'one.toml').balance.factor}")
    print(ab.batch(folder / "jobs", folder / "rows", workers=1).text())
    search = {"objectives": ["mass_g"], "evaluations": 20}
    design: dict[str, Any] = {
        "engine": PARTS,
        "balance": BALANCE,
        "counterweight": [FREE],
        "envelope": {"radius_mm": 80.0},
        "search": search,
    }
    design["crankshaft"] = {**CRANKSHAFT, "file": str(folder / "crank.stl")}
    with_extra(lambda: ab.inspect(ab.crank_from_shape(ab.generate("single", file="crank.step").data)))
    with_extra(lambda: ab.design(design, workers=1))
    coarse = ab.generate("single", file=folder / "coarse.stl", segments=12)
    coarse.write(folder)
    with_extra(lambda: ab.fem(coarse.file, unit="mm", modes=1, size_mm=60.0))
    with_extra(lambda: ab.rod(folder / "crank.stl", unit="mm"))  # which it is not, and that is said


def with_extra(call: Callable[[], Any]) -> None:
    """Print a result, or the line that says which extra is missing or what is wrong."""
    try:
        print(call().text())
    except ab.AutobalanceError as error:
        print(error)


if __name__ == "__main__":
    raise SystemExit(main())
