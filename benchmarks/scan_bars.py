"""How often a scan's error bars cover the truth: benchmarks.scan_bars [--cases N] [--first N] [--kept FILE].

Scans of cranks that are within tolerance as they are: σ of 0 to 50 µm, edges of 0.4 to 2.5 mm, waves of 3 to
60 mm. Half of them are meshed as a scanner's software does it, half are drawn facets that were split; half
have a skin and a scale drawn from an accuracy that is stated, half none, and none is stated. Unbalance, both
planes, mass and axis are held against the true crank. A line each, which ``--kept`` keeps: a run that was
stopped goes on where it was. Then for each σ and measure how often the truth was within, and the bar over
the root mean square of the errors.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

import autobalance as ab
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.solid import Solid
from benchmarks.scan_cuts import ACCURACY_MM, BIG_END_G, DENSITY_G_MM3, FACTOR, PISTON_G, true_crank
from tests.scans import Scan, scan
from tests.split_scans import split_scan

MEASURES = ("unbalance", "plane A", "plane B", "mass", "axis offset", "axis angle")
CRANKS = ("single", "single", "v-twin-45", "parallel-twin-360")
SIGMAS_UM = (0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0, 50.0)
EDGES_MM = (2.5, 1.9, 1.4, 1.0, 0.7, 0.4)
EDGE_SHARES = (0.3, 0.27, 0.22, 0.12, 0.06, 0.03)
"""Triangles of 0.4 mm cost forty times those of 2.5 mm."""
WAVES_MM = (3.0, 8.0, 20.0, 40.0)
LONGEST_WAVE = 1.5
TWO_AXES_SIGMAS_95 = 2.45
EXACT = 1e-4
"""What a drawn crank's axis may be off, whose standard error is none [mm, deg]: the file's digits."""

Row = dict[str, Any]


def scanned(number: int) -> tuple[Row, Scan]:
    """Return what a scan is, and the scan."""
    rng = np.random.default_rng([number, 92])
    name, sigma = CRANKS[number // len(SIGMAS_UM) % len(CRANKS)], SIGMAS_UM[number % len(SIGMAS_UM)]
    edge = float(rng.choice(EDGES_MM, p=EDGE_SHARES))
    edge = max(edge, 1.4) if name != "single" else edge  # a twin has four times the surface
    shortest = float(rng.choice(WAVES_MM))
    stated, split = bool(rng.random() < 0.5) and sigma > 0.0, bool(rng.random() < 0.5)
    skin = float(rng.normal(0.0, ACCURACY_MM / 1.96)) if stated else 0.0
    is_of = {"number": number, "crank": name, "sigma_um": sigma, "edge_mm": edge, "waves_mm": shortest}
    lengths = (shortest, LONGEST_WAVE * shortest)
    sigma_mm = 1e-3 * sigma
    if split:
        there = split_scan(
            name, sigma_mm, edge_mm=edge, segments=256, seed=number, lengths_mm=lengths, skin_mm=skin
        )
    else:
        diagonal = 160.0 if name == "single" else 250.0
        scale = 1.0 + (float(rng.normal(0.0, ACCURACY_MM / diagonal / 1.96)) if stated else 0.0)
        there = scan(name, sigma_mm, edge_mm=edge, seed=number, lengths_mm=lengths, skin_mm=skin, scale=scale)
    return {**is_of, "split": split, "stated": stated}, there


def offs_and_bars(row: Row, there: Scan) -> list[tuple[float, float]]:
    """Return by how much each of the measures is off, and the bar that is stated of it."""
    stated = {"scan_accuracy_mm": ACCURACY_MM} if row["stated"] else {}
    job = {
        "crankshaft": {"density_kg_m3": 1e6 * DENSITY_G_MM3, **stated},
        "engine": {"rotating_g": {"big_end": BIG_END_G}, "reciprocating_g": {"piston": PISTON_G}},
        "balance": {"factor": FACTOR, "grade": 4000, "speed_rpm": 1000, "judge": "dynamic"},
        "correction": {"method": "drill"},
    }
    crank = ab.crank_from_mesh(there.mesh.vertices, there.mesh.triangles, 1e6 * DENSITY_G_MM3)
    report = ab.balance(ab.Job.from_dict(job), crank=crank).report
    assert not report["corrections"]
    frame = there.truth.file_to_rotor
    solid = Solid.from_mesh(there.true) if row["split"] else true_crank(row["crank"]).moved(there.placement)
    true = solid.moments(DENSITY_G_MM3, frame)
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
    told = report["crank"]
    facets = told["facet_error"]
    drawn_pm = facets["mass_bar_g"] + (0.0 if facets["correction"] == "applied" else abs(facets["mass_g"]))
    mass_pm = told.get("mass_pm_g", drawn_pm)
    return [*pairs, (abs(told["mass_g"] - true.mass_g), float(mass_pm)), *_of_axis(crank, there)]


def _of_axis(crank: ab.Crank, there: Scan) -> list[tuple[float, float]]:
    """Return by how much the axis is off amid the main journals and in direction, and what is told of it."""
    fit = crank.measured.anatomy.scan
    middle = 0.0 if fit is None else fit.axis_middle_mm
    to_true = there.truth.file_to_rotor @ np.linalg.inv(crank.file_to_rotor)
    place = to_true @ np.array([0.0, 0.0, middle, 1.0])
    told = (0.0, 0.0) if fit is None else (fit.axis_offset_mm, fit.axis_angle_deg)
    off = float(np.hypot(*place[:2])), float(np.degrees(np.hypot(*to_true[:2, 2])))
    return [(each, TWO_AXES_SIGMAS_95 * pm + EXACT) for each, pm in zip(off, told, strict=True)]


def _measured(number: int) -> Row:
    begun = time.process_time()
    row, there = scanned(number)
    try:
        row["pairs"] = offs_and_bars(row, there)
    except ab.AutobalanceError as error:
        row["refused"] = str(error)
    row["triangles"], row["seconds"] = len(there.mesh.triangles), round(time.process_time() - begun, 1)
    return row


def tables(rows: Iterable[Row]) -> str:
    """Return a line for each σ: how often each measure's truth was within, and the bar over the errors."""
    by_sigma: dict[float, list[Row]] = defaultdict(list)
    for row in rows:
        by_sigma[row["sigma_um"]].append(row)
    lines = ["| σ | scans | " + " | ".join(MEASURES) + " |", "|---" * (len(MEASURES) + 2) + "|"]
    everything = [row for group in by_sigma.values() for row in group]
    groups = [
        *((f"{sigma:g} µm", by_sigma[sigma]) for sigma in sorted(by_sigma)),
        ("a scanner's mesh", [row for row in everything if not row["split"]]),
        ("split facets", [row for row in everything if row["split"]]),
        ("all", everything),
    ]
    for title, group in groups:
        pairs = np.array([row["pairs"] for row in group if "pairs" in row])
        if len(pairs) == 0:
            continue
        off, pm = pairs[..., 0], pairs[..., 1]
        within = (off <= pm).sum(axis=0)
        ratio = pm.mean(axis=0) / np.maximum(np.sqrt((off**2).mean(axis=0)), 1e-12)
        cells = " | ".join(f"{count}, {times:.1f}" for count, times in zip(within, ratio, strict=True))
        lines.append(f"| {title} | {len(pairs)} | {cells} |")
    refused = [row for row in everything if "refused" in row]
    return "\n".join([*lines, *(f"{row['number']} refused: {row['refused']}" for row in refused)])


def main() -> None:
    """Print the lines and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kept", type=Path)
    asked = parser.parse_args()
    kept = asked.kept.read_text().splitlines() if asked.kept is not None and asked.kept.exists() else []
    rows = {row["number"]: row for row in map(json.loads, kept)}
    for number in range(asked.first, asked.first + asked.cases):
        if number in rows:
            continue
        rows[number] = _measured(number)
        line = json.dumps(rows[number])
        print(line, flush=True)
        if asked.kept is not None:
            with asked.kept.open("a") as file:
                file.write(line + "\n")
    print(tables(rows[number] for number in sorted(rows)))


if __name__ == "__main__":
    main()
