"""Every verb of the core as a function: an outside script that needs no private name and no file of its own.

python examples/every_verb.py
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import autobalance as ab

PARTS = {
    "rod_length_mm": 104.0,
    "rotating_g": {"big_end": 134.04},
    "reciprocating_g": {"small_end": 46.5, "piston": 215.0},
}
CORRECTIONS = {"method": "shoulder"}
BALANCE = {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000}
CRANKSHAFT = {"density_kg_m3": 7850.0, "unit": "mm"}


def main() -> int:
    """Draw a crank, measure it, balance it, verify the result, and ask what its engine makes of it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drawn = ab.generate("single", file=folder / "crank.stl", segments=64)
        drawn.write(folder)
        crank = ab.read_crank(folder / "crank.stl", unit="mm", density_kg_m3=7850.0)
        print(crank)
        print(ab.inspect(crank).text())

        job = ab.Job.from_dict(
            {"crankshaft": CRANKSHAFT, "engine": PARTS, "balance": BALANCE, "correction": CORRECTIONS}
        )
        result = ab.balance(job, crank=crank)
        print(result, [cut.depth_mm for cut in result.corrections])
        result.write(folder / "balanced", only=("json",))
        checked = ab.verify(folder / "balanced" / "report.json", independent=True)
        print(checked.holds, checked.within_tolerance)

        for found in (
            ab.compare(job, crank=crank),
            ab.forces(job, crank=result.crank),
            ab.shafts(job, crank=result.crank),
            ab.parts(job, crank=result.crank),
            ab.grade(6.3, speed_rpm=9000, mass=result.crank.mass_g),
        ):
            print(found.text())
        return 0 if checked.within_tolerance else 4


if __name__ == "__main__":
    raise SystemExit(main())
