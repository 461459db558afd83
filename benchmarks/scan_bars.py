"""How often a scan's error bars cover the truth: benchmarks.scan_bars [--cases N] [--first N].

Scans with noise, with a skin and a scale drawn from the accuracy stated, of cranks that are within tolerance
as they are. Unbalance, both planes and mass are held against the true crank, meshed more finely. A line
each; then for each crank how often the truth was within, and the bar over the root mean square of the errors.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict

import numpy as np

import autobalance as ab
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.unbalance import Unbalance
from benchmarks.scan_cuts import (
    ACCURACY_MM,
    BIG_END_G,
    CRANKS,
    DENSITY_G_MM3,
    EDGE_MM,
    FACTOR,
    PISTON_G,
    SIGMAS_MM,
    true_crank,
)
from tests.scans import Scan, scan

MEASURES = ("unbalance [g·mm]", "plane A [g·mm]", "plane B [g·mm]", "mass [g]")


def scanned(number: int) -> tuple[str, float, Scan]:
    """Return a crank's name, the scan's σ and the scan."""
    name, sigma = CRANKS[number % len(CRANKS)], SIGMAS_MM[number // len(CRANKS) % len(SIGMAS_MM)]
    rng = np.random.default_rng([number, 92])
    skin = float(rng.normal(0.0, ACCURACY_MM / 1.96))
    diagonal = scan(name, 0.0, edge_mm=4.0).mesh.diagonal_mm
    scale = 1.0 + float(rng.normal(0.0, ACCURACY_MM / diagonal / 1.96))
    return name, sigma, scan(name, sigma, edge_mm=EDGE_MM, seed=number, skin_mm=skin, scale=scale)


def offs_and_bars(name: str, there: Scan) -> list[tuple[float, float]]:
    """Return by how much each of the measures is off, and the bar that is stated of it."""
    job = {
        "crankshaft": {"density_kg_m3": 1e6 * DENSITY_G_MM3, "scan_accuracy_mm": ACCURACY_MM},
        "engine": {"rotating_g": {"big_end": BIG_END_G}, "reciprocating_g": {"piston": PISTON_G}},
        "balance": {"factor": FACTOR, "grade": 4000, "speed_rpm": 1000, "judge": "dynamic"},
        "correction": {"method": "drill"},
    }
    crank = ab.crank_from_mesh(there.mesh.vertices, there.mesh.triangles, 1e6 * DENSITY_G_MM3)
    report = ab.balance(ab.Job.from_dict(job), crank=crank).report
    assert not report["corrections"]
    frame = there.truth.file_to_rotor
    true = true_crank(name).moved(there.placement).moments(DENSITY_G_MM3, frame)
    loaded = true
    for throw in there.truth.throws:
        loaded = loaded + Moments.point(BIG_END_G + FACTOR * PISTON_G, throw.crankpin.centre_mm)
    unbalance = Unbalance.of(loaded)
    places = [plane["z_mm"] for plane in report["tolerance"]["planes"]]
    vectors = [unbalance.resultant_g_mm, *unbalance.in_planes(*places)]
    turn = (frame @ np.linalg.inv(crank.file_to_rotor))[:2, :2]
    initial = report["initial"]
    pairs = [
        (
            float(np.linalg.norm(vector - turn @ np.array(each["unbalance_g_mm"]))),
            float(each["uncertainty_g_mm"]),
        )
        for vector, each in zip(vectors, [initial, *initial["planes"]], strict=True)
    ]
    return [*pairs, (abs(report["crank"]["mass_g"] - true.mass_g), float(report["crank"]["mass_pm_g"]))]


def main() -> None:
    """Print the lines and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    table: dict[str, list[list[tuple[float, float]]]] = defaultdict(list)
    for number in range(asked.first, asked.first + asked.cases):
        begun = time.process_time()
        name, sigma, there = scanned(number)
        pairs = offs_and_bars(name, there)
        table[name].append(pairs)
        words = ", ".join(
            f"{measure}: {off:.4g} of ± {pm:.4g}" for measure, (off, pm) in zip(MEASURES, pairs, strict=True)
        )
        print(f"{number:4d}  {name} σ {sigma:g} {words}, {time.process_time() - begun:.0f} s", flush=True)
    for name, found in table.items():
        for place, measure in enumerate(MEASURES):
            off, pm = np.array([row[place] for row in found]).T
            ratio = float(np.mean(pm)) / float(np.sqrt(np.mean(off**2)))
            print(f"| {name} | {measure} | {int((off <= pm).sum())} of {len(off)} | {ratio:.1f} |")


if __name__ == "__main__":
    main()
