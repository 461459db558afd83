"""Play the machine's loop: hidden deviations, a simulated machine, further cuts; count the stages.

``python benchmarks/machine_loop.py [CASES] [SEED]`` prints how many cranks needed how many stages.
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import autobalance as ab

CRANK = Path(__file__).parents[1] / "fixtures" / "crf250r" / "straight" / "crank.stl"
MOST_STAGES = 4

JOB: dict[str, Any] = {
    "crankshaft": {"file": str(CRANK), "unit": "mm", "density_kg_m3": 7850.0, "crankpin_in_file": False},
    "engine": {
        "rotating_g": {"rod": 134.04},
        "reciprocating_g": {"rest": 261.5},
        "crankpin_g": {"crankpin": 114.65},
    },
    "balance": {"factor": 0.28, "grade": 6.3, "speed_rpm": 15200.0},
    "correction": {"method": "drill", "drill": {"max_holes": 10}},
}
MACHINE = {
    "noise": {"g_mm": 0.2, "gain_percent": 2.0, "angle_deg": 1.0},
    "urr_percent": 95.0,
    "umar_g_mm": 0.5,
}


def hidden(rng: np.random.Generator) -> list[dict[str, float]]:
    """Return deviations that no model has: density gradient, core shift, wandering drills [g·mm]."""
    causes = [("gradient", 25.0), ("core", 40.0), *(("drill", 4.0) for _ in range(6))]
    return [
        {
            "z_mm": float(rng.uniform(-25.0, 25.0)),
            "g_mm": float(abs(rng.normal(0.0, size))),
            "angle_deg": float(rng.uniform(0.0, 360.0)),
        }
        for _, size in causes
    ]


def drill_errors(result: Any, rng: np.random.Generator) -> list[dict[str, float]]:
    """Return what depths off by some 0.05 mm leave of a stage's cuts."""
    errors = []
    for cut in result.report["corrections"]:
        off = np.array(cut["unbalance_per_mm_g_mm"]) * rng.normal(0.0, 0.05)
        errors.append(
            {
                "z_mm": float(cut["position_mm"][2]),
                "g_mm": float(np.hypot(*off)),
                "angle_deg": float(np.degrees(np.arctan2(off[1], off[0]))),
            }
        )
    return errors


def stages_needed(first: Path, result: Any, seed: int, folder: Path) -> int:
    """Return in which stage the crank is in truth within tolerance; MOST_STAGES where it is not before."""
    rng = np.random.default_rng(seed)
    deviations, report = [*hidden(rng), *drill_errors(result, rng)], first
    for stage in range(2, MOST_STAGES):
        task = {"kind": "hard", "speed_rpm": 600.0, "seed": seed + stage, "unbalance": deviations}
        reading = {key: MACHINE[key] for key in ("urr_percent", "umar_g_mm")}
        read = ab.machine(
            {**task, "rotor": {"report": str(report)}, "noise": MACHINE["noise"], "reading": reading}
        )
        if within(read.report, result.report["tolerance"]):
            return stage - 1
        read.write(folder / f"read-{stage}", only=("toml",))
        done = ab.recut(report, folder / f"read-{stage}" / "reading.toml", folder=folder / f"stage-{stage}")
        done.write(only=("json",))
        deviations += drill_errors(done, rng)
        report = folder / f"stage-{stage}" / "report.json"
    last = ab.machine(
        {"kind": "hard", "speed_rpm": 600.0, "rotor": {"report": str(report)}, "unbalance": deviations}
    )
    return MOST_STAGES - 1 if within(last.report, result.report["tolerance"]) else MOST_STAGES


def within(report: dict[str, Any], tolerance: dict[str, Any]) -> bool:
    """Tell whether the true rotor is within tolerance, whatever was read."""
    rotor = report["rotor"]
    permitted = [plane["permissible_g_mm"] for plane in tolerance["planes"]]
    sizes = [plane["g_mm"] for plane in rotor["planes"]]
    return rotor["magnitude_g_mm"] <= tolerance["permissible_g_mm"] and all(
        size <= most for size, most in zip(sizes, permitted, strict=True)
    )


def main(cases: int = 100, seed: int = 1) -> None:
    """Count the stages of many cranks."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        result = ab.balance(ab.Job.from_dict(JOB, folder))
        result.write(folder / "first", only=("json",))
        counts = Counter(
            stages_needed(
                folder / "first" / "report.json", result, 1000 * seed + case, folder / f"case-{case}"
            )
            for case in range(cases)
        )
    for stages, count in sorted(counts.items()):
        more = "or more, or never" if stages >= MOST_STAGES else ""
        print(f"{count:4d} of {cases} within tolerance at stage {stages} {more}")


if __name__ == "__main__":
    main(*(int(each) for each in sys.argv[1:]))
