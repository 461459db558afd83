"""Random jobs of a shop: where their holes went, and whether their sheets can be read.

    python benchmarks/shop_jobs.py [--jobs 100] [--first 0]

A V8, an inline-4 or a single is drawn, its weights off its counterweights by a few per cent and its casting
unlike its drawing; it is balanced, and every second one read on a machine and cut again. Holes are held
against the sizes that the crank was drawn from: inside their zone, no nearer to a fillet than their wall.
Sheets are read back with poppler: no text over text, no page under a third full but the last.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT)]

LAYOUTS = ("v8-crossplane", "inline-4", "single", "v8-flatplane")
STEEL = 7.85e-3
FACETS_MM = 0.05
"""What chords of a crank of 48 corners take from a distance."""
LEAST_BOB_G = 50.0
FREE_BOB_G = 400.0
"""A bob-weight of a crank that is balanced by its symmetry, whatever hangs on it."""
Array = NDArray[np.float64]


def main() -> None:
    import autobalance as ab

    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    totals: Counter[str] = Counter()
    for seed in range(arguments.first, arguments.first + arguments.jobs):
        start = time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            try:
                said, wrong = tried(Path(folder), seed)
            except ab.AutobalanceError as error:
                said, wrong = f"refused: {error}"[:160], []
                totals["refused"] += 1
        totals["jobs"] += 1
        totals["with faults"] += bool(wrong)
        print(f"{seed:3d} {time.process_time() - start:5.1f} s  {said}", flush=True)
        for each in wrong:
            print(f"      {each}", flush=True)
    print(dict(totals))


def tried(folder: Path, seed: int) -> tuple[str, list[str]]:
    """Balance a random job, every second one once more after a reading; return what came out and is wrong."""
    import autobalance as ab
    from tests.generated import generated_crank
    from tests.jobs import without_advice

    rng = np.random.default_rng(seed)
    crank = generated_crank(LAYOUTS[seed % len(LAYOUTS)], seed=seed, segments=48)
    job = written_job(folder, crank, rng)
    paper, units = ("A4", "Letter")[seed % 2], ("metric", "inch")[seed // 2 % 2]
    with without_advice():  # what would suffice where limits fall short takes longer than all the rest
        result: Any = ab.balance(job)
    result.write(folder / "out", ("pdf",), paper=paper, units=units)
    said, wrong = stage(result, crank, folder / "out")
    if seed % 2 and result.corrections:
        with without_advice():
            again: Any = ab.recut(folder / "out" / "report.json", reading(result, rng))
        again.write(folder / "again", ("pdf",), paper=paper, units=units)
        more, faulty = stage(again, crank, folder / "again")
        said, wrong = f"{said}; recut {more}", wrong + [f"recut: {each}" for each in faulty]
    return f"{crank.design.name}, {paper}, {units}: {said}", wrong


def stage(result: Any, crank: Any, folder: Path) -> tuple[str, list[str]]:
    """Return how a run ended, and what is wrong with its holes and its sheet."""
    from tests.pages import faults, page_texts

    sheet = folder / "sheet.pdf"
    wrong = [*misplaced(result, crank), *faults(sheet)]
    return f"{result.outcome}, {len(result.corrections)} cuts, {len(page_texts(sheet))} pages", wrong


def written_job(folder: Path, crank: Any, rng: np.random.Generator) -> Path:
    """Write a job with weights near those that the crank's counterweights balance."""
    from tests.jobs import write_stl

    write_stl(folder / "crank.stl", crank.mesh.corners)
    bob = balanced_bob_g(crank) * float(rng.uniform(0.88, 1.0))
    size = 0.01 * bob * crank.design.crank_radius_mm
    methods = [["drill"], ["drill"], ["drill", "slug"], ["shoulder", "drill"]][int(rng.integers(4))]
    uneven = "".join(
        f'[[engine.attached]]\nname = "casting {name}"\nmass_g = 1.0\nz_mm = {z:.2f}\n'
        f"unbalance_g_mm = [{x:.2f}, {y:.2f}]\n"
        for name, z, (x, y) in zip("ab", ends(crank), size * rng.normal(size=(2, 2)), strict=True)
    )
    drills = ["", 'series = "inch"\n', "diameters_mm = [8.0, 10.0, 12.0]\n"][int(rng.integers(3))]
    path = folder / "job.toml"
    path.write_text(
        '[crankshaft]\nfile = "crank.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0\n'
        f"[engine.rotating_g]\nconnecting_rod_big_end = {0.6 * bob:.2f}\n"
        f"[engine.reciprocating_g]\npiston = {0.8 * bob:.2f}\n{uneven}"
        f'[balance]\nfactor = "50 %"\ngrade = {rng.choice([2.5, 6.3, 16.0])}\nspeed_rpm = 6000\n'
        f"[correction]\nmethod = {methods}\n"
        f'[correction.drill]\ndirection = "{rng.choice(["radial", "radial", "axial"])}"\n'
        f'zone = "{rng.choice(["counterweights", "counterweights", "web"])}"\n{drills}',
        encoding="utf-8",
    )
    return path


def ends(crank: Any) -> tuple[float, float]:
    """Return the middles of the first and the last web [mm]."""
    first, last = crank.truth.webs[0], crank.truth.webs[-1]
    return 0.5 * (first.z_min_mm + first.z_max_mm), 0.5 * (last.z_min_mm + last.z_max_mm)


def balanced_bob_g(crank: Any) -> float:
    """Return the bob-weight that leaves the drawn crank's two end planes least unbalanced [g]."""
    from autobalance.rigid_rotor.unbalance import Moments, Unbalance

    bobs = [Moments.point(1.0, throw.crankpin.centre_mm) for throw in crank.truth.throws]
    bare, per_g = (
        Unbalance.of(each).in_planes(*ends(crank)).ravel()
        for each in (crank.solid.moments(STEEL, crank.truth.file_to_rotor), sum(bobs[1:], bobs[0]))
    )
    if np.linalg.norm(per_g) < crank.design.crank_radius_mm * 1e-3:
        return FREE_BOB_G
    bob = -float(per_g @ bare) / float(per_g @ per_g)
    return bob if bob > LEAST_BOB_G else FREE_BOB_G


def reading(result: Any, rng: np.random.Generator) -> dict[str, Any]:
    """Return a reading a few times what is permitted off the prediction."""
    planes = []
    for plane, permitted in zip(result.residual.planes, result.tolerance.planes, strict=True):
        limit = float(permitted.permissible_g_mm)
        x, y = np.array(plane.unbalance_g_mm) + limit * rng.normal(size=2) * 3.0
        planes.append(
            {
                "at": plane.name,
                "g_mm": round(math.hypot(x, y), 2),
                "angle_deg": round(math.degrees(math.atan2(y, x)) % 360.0, 1),
            }
        )
    return {"serial": "1", "urr_percent": 97.0, "umar_g_mm": 0.01, "plane": planes}


def misplaced(result: Any, crank: Any) -> list[str]:
    """Return the holes that are outside their zone, or nearer to a fillet than their wall."""
    limits = dict(zip(result.job.method_names, result.job.methods, strict=True))
    fillets = fillet_points(crank)
    to_truth = crank.truth.file_to_rotor @ result.before.measured.anatomy.rotor_to_file
    wrong = []
    for cut in result.corrections:
        if cut.kind not in ("drill", "slug"):
            continue
        entry = to_truth[:3, :3] @ np.array(cut.position_mm) + to_truth[:3, 3]
        inward = to_truth[:3, :3] @ np.array(cut.inward)
        zone = getattr(limits[cut.kind], "zone", "counterweights")
        name = f"{cut.kind} {cut.number}, web {cut.web}"
        wrong += [f"{name}: {each}" for each in outside(crank, cut, entry, inward, zone)]
        off = fillets - entry
        along = off @ inward
        across = np.sqrt(np.maximum((off * off).sum(axis=1) - along * along, 0.0))
        beyond = np.maximum(np.maximum(-along, along - cut.depth_mm), 0.0)
        nearest = float(np.hypot(np.maximum(across - 0.5 * cut.diameter_mm, 0.0), beyond).min())
        wall = limits[cut.kind].min_wall_mm
        if nearest < wall - FACETS_MM:
            wrong.append(f"{name}: {nearest:.2f} mm from a fillet, its wall is {wall:g} mm")
    return wrong


def outside(crank: Any, cut: Any, entry: Array, inward: Array, zone: str) -> list[str]:
    """Return in what a hole leaves its zone; ``counterweights``: the sector that was drawn."""
    web = crank.truth.webs[cut.web - 1]
    towards = sum(throw.direction for throw in crank.truth.throws_of(web))
    away = math.atan2(-towards[1], -towards[0])
    off_deg = abs(math.degrees(math.remainder(math.atan2(entry[1], entry[0]) - away, math.tau)))
    half_deg = 90.0 if zone == "web" else 0.5 * crank.design.counterweight.fan_angle_deg
    wrong = []
    if zone != "anywhere" and off_deg > half_deg + 0.5:
        wrong.append(f"{off_deg:.1f}° off the middle of its zone, which ends at {half_deg:g}°")
    if zone == "counterweights":
        if not web.counterweight:
            wrong.append("no counterweight there")
        point = 0.5 * cut.diameter_mm / math.tan(math.radians(0.5 * cut.get("point_angle_deg", 180.0)))
        end = entry + (cut.depth_mm + point) * inward
        beside = 0.5 * crank.design.main_journal.diameter_mm + crank.design.fillet_mm
        if np.hypot(*end[:2]) < beside - 0.1:
            wrong.append(f"ends at a radius of {np.hypot(*end[:2]):.1f} mm, inside the fillet at {beside:g}")
    return wrong


def fillet_points(crank: Any) -> Array:
    """Return points (n, 3) on the arcs of all fillets as they were drawn, rotor frame."""
    radius = crank.design.fillet_mm
    turn, arc = np.meshgrid(np.linspace(0.0, math.tau, 361), np.linspace(0.0, 0.5 * math.pi, 7))
    points = []
    for pin in (*crank.truth.main_journals, *(throw.crankpin for throw in crank.truth.throws)):
        out = 0.5 * pin.diameter_mm + radius * (1.0 - np.cos(arc))
        for z, sense in zip(pin.z_range_mm, (-1.0, 1.0), strict=True):
            if not beside_web(crank, z + sense * radius):
                continue
            x, y = pin.centre_mm[0] + out * np.cos(turn), pin.centre_mm[1] + out * np.sin(turn)
            points.append(np.stack([x, y, z + sense * radius * np.sin(arc)], axis=-1).reshape(-1, 3))
    return np.concatenate(points)


def beside_web(crank: Any, z_mm: float) -> bool:
    """Whether a web is at a height: the free ends of nose and flange have no fillet.

    A counterweight thicker than its arm stands around the journal's fillet.
    """
    return any(web.z_min_mm - 1e-3 <= z_mm <= web.z_max_mm + 1e-3 for web in crank.truth.webs)


if __name__ == "__main__":
    main()
