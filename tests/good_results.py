"""Random good results of every format and kind, for every verb that reads a result: none may refuse its own.

A crank anywhere in space, in any format, with the unbalance that asks for a cut; a job with whatever tables
may stand in it. ``python -m tests.good_results 100`` tries as many and says how many were believed.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from autobalance.drawn_cranks.design import PRESETS, Design
from autobalance.errors import AutobalanceError, JobError
from autobalance.machining.verb import nc
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.formats.write import encode
from tests import jobs, nc_jobs
from tests.generated import GeneratedCrank, generated_crank
from tests.soak.cases import ran

LAYOUTS = ("single", "pressed-up-single", "v-twin-45", "parallel-twin-360", "inline-3", "v6-60")
MESHES = ("stl", "obj", "ply", "off", "3mf", "glb")
KINDS = ("shoulder", "turn", "drill", "slug", "add", "mill")
CORRECTIONS: dict[str, str] = {
    "shoulder": "",
    "turn": "",
    "drill": "[correction.drill]\ndiameters_mm = [6.0, 8.0, 10.0]\n",
    "slug": "[correction.slug]\ndiameters_mm = [8.0, 10.0, 12.0]\nlengths_mm = [5.0, 8.0, 12.0]\n"
    "min_wall_mm = 2.0\n",
    "add": "",
    "mill": "[correction.mill]\ncutter_mm = 8.0\n",
}
FIRING = {
    1: "",
    2: "firing_order = [1, 2]\n",
    3: "firing_order = [1, 3, 2]\n",
    6: "firing_order = [1, 4, 2, 5, 3, 6]\n",
}
STEEL = 7.85e-3
ROD_G = 100.0


class Good(NamedTuple):
    """A job on its crank, and what it is in words."""

    job: Path
    what: str
    kinds: tuple[str, ...]


def good_job(
    folder: Path,
    draw: random.Random,
    kind: str | None = None,
    ending: str | None = None,
    layout: str | None = None,
) -> Good:
    """Write a crank and a job that a plan can meet; what is None is drawn."""
    folder.mkdir(parents=True, exist_ok=True)
    layout = layout or draw.choice(LAYOUTS)
    design = PRESETS[layout]
    ending = ending or draw.choice(("step", *MESHES) if design.crankpin_in_file else MESHES)
    kinds = (kind,) if kind else tuple(draw.sample(KINDS, draw.choice((1, 1, 2))))
    place = None if ending == "step" else draw.randrange(2**31)
    crank = generated_crank(design, seed=place, segments=draw.choice((24, 32, 48)))
    unit = _written(folder / f"crank.{ending}", crank, design, draw)
    heavier = set(kinds) <= {"slug", "add"}
    towards = 1.0 if heavier or (len(kinds) > 1 and draw.random() < 0.3) else -1.0
    text = "".join(
        [
            f'[crankshaft]\nfile = "crank.{ending}"\ndensity_kg_m3 = 7850.0\n{unit}',
            "" if design.crankpin_in_file else "crankpin_in_file = false\n",
            "density_pm_kg_m3 = 20.0\n" * draw.choice((0, 1)),
            _engine(crank, layout, draw, towards),
            _balance(draw),
            f"[correction]\nmethod = {json.dumps(list(kinds))}\n",
            *(CORRECTIONS[each] for each in kinds),
        ]
    )
    (folder / "job.toml").write_text(text, encoding="utf-8")
    return Good(folder / "job.toml", f"{layout} as {ending}, {' and '.join(kinds)}", kinds)


def _written(path: Path, crank: GeneratedCrank, design: Design, draw: random.Random) -> str:
    """Write the crank; return the line of its unit, where the format has none."""
    if path.suffix == ".step":
        assert ran("generate", _preset_of(design), "-o", path)[0] == 0
        return ""
    unit = draw.choice(("mm", "inch")) if path.suffix in (".stl", ".obj", ".ply", ".off") else "mm"
    scale = {"mm": 1.0, "inch": 25.4}[unit] if path.suffix != ".glb" else 1000.0
    path.write_bytes(encode(crank.mesh, path.suffix[1:], scale))
    return f'unit = "{unit}"\n' if path.suffix in (".stl", ".obj", ".ply", ".off") else ""


def _preset_of(design: Design) -> str:
    return next(name for name, each in PRESETS.items() if each is design)


def _engine(crank: GeneratedCrank, layout: str, draw: random.Random, towards: float) -> str:
    """Return the engine, with bolted parts that leave the crank an unbalance within reach of a few cuts.

    ``towards`` is 1 where it is heavy at the crankpins, for what is added, -1 where at the counterweights.
    """
    anatomy = crank.truth
    webs = anatomy.webs
    ends = tuple(0.5 * (each.z_min_mm + each.z_max_mm) for each in (webs[0], webs[-1]))
    size = draw.uniform(0.5, 2.0) * PRESETS[layout].crank_radius_mm * 10.0
    parts = sum(
        (_point(ROD_G, throw.crankpin.centre_mm) for throw in anatomy.throws),
        crank.solid.moments(STEEL, anatomy.file_to_rotor),
    )
    now = Unbalance.of(parts).in_planes(*ends)
    lines = [f"[engine]\nrod_length_mm = {4.0 * PRESETS[layout].crank_radius_mm}\n"]
    lines.append(f"[engine.rotating_g]\nrod = {ROD_G}\n[engine.reciprocating_g]\npiston = {ROD_G}\n")
    if not PRESETS[layout].crankpin_in_file:
        lines.append("[engine.crankpin_g]\ncrankpin = 100.0\n")
    for name, z, here, throw in zip("ab", ends, now, (anatomy.throws[0], anatomy.throws[-1]), strict=True):
        heavy = towards * size * np.array([np.cos(throw.angle_rad), np.sin(throw.angle_rad)])
        x, y = heavy - here
        lines.append(
            f'[[engine.attached]]\nname = "{name}"\nmass_g = 1.0\nz_mm = {z}\nunbalance_g_mm = [{x}, {y}]\n'
        )
    if draw.random() < 0.6:
        order = FIRING[len(anatomy.throws)]
        lines.append(f"[cycle]\nbore_mm = 70.0\ncompression_ratio = 10.0\nheat_J = 500.0\n{order}")
    return "".join(lines)


def _point(mass_g: float, place: Any) -> Any:
    from autobalance.rigid_rotor.unbalance import Moments

    return Moments.point(mass_g, place)


def _balance(draw: random.Random) -> str:
    judge = draw.choice(("dynamic", "dynamic", "static"))
    grade = draw.choice((6.3, 16.0, 40.0))
    lines = f'[balance]\nfactor = 0.0\ngrade = {grade}\nspeed_rpm = 6000.0\njudge = "{judge}"\n'
    if draw.random() < 0.2:
        lines += 'margin = "expanded"\n'
    return lines


def faults(good: Good, draw: random.Random) -> list[str]:
    """Balance, and let every verb read what was written; return what one said against it."""
    out = good.job.parent / "out"
    with jobs.without_advice():
        code, said = ran("balance", good.job, "-o", out, "--no-report")
    if code not in (0, 4):
        return [f"balance {code}: {said[-300:]}"]
    found = [*_verified(out, code)]
    report = jobs.report_of(out)
    if draw.random() < 0.5 and report["outputs"]["solid"] is not None:
        found += recut_faults(out, report, draw)
    if draw.random() < 0.3:
        found += _programmed(out)
    return found


def _verified(out: Path, code: int) -> list[str]:
    again, said = ran("verify", out / "report.json")
    wrong = [f"verify {again} after {code}: {said[-300:]}"] if again != code else []
    return wrong + ([f"verify warns: {said[-300:]}"] if again == code and said.strip() else [])


def recut_faults(out: Path, report: Any, draw: random.Random) -> list[str]:
    """Spin the crank on a machine that reads a little, and cut it further."""
    planes = [
        f'[[plane]]\nat = "{each["name"]}"\ng_mm = {draw.uniform(0.5, 2.0) * each["permissible_g_mm"]}\n'
        f"angle_deg = {draw.uniform(0.0, 360.0)}\n"
        for each in report["tolerance"]["planes"]
    ]
    one = f"[[plane]]\ng_mm = {report['tolerance']['permissible_g_mm']}\nangle_deg = 10.0\n"
    reading = "urr_percent = 95.0\numar_g_mm = 0.01\n" + ("".join(planes) or one)
    (out / "reading.toml").write_text(reading, encoding="utf-8")
    with jobs.without_advice():
        code, said = ran(
            "recut", out / "report.json", out / "reading.toml", "--trust-reading", "--no-report",
            "-o", out / "stage-2",
        )  # fmt: skip
    if code not in (0, 4):
        return [f"recut {code}: {said[-300:]}"]
    return _verified(out / "stage-2", code)


def _programmed(out: Path) -> list[str]:
    """Ask for NC programs: all claims are checked first; what the tools cannot make may be refused."""
    try:
        nc(out / "report.json", nc_jobs.machine())
    except JobError:
        return []
    except AutobalanceError as error:
        return [f"nc: {error}"]
    return []


def _ended(good: Good) -> str:
    """Return how a run ended, in words."""
    if not (good.job.parent / "out" / "report.json").is_file():
        return "no report"
    report = jobs.report_of(good.job.parent / "out")
    loads = ", loads with gas" if "loads_with_gas" in report else ""
    return f"{report['outcome']} with {len(report['corrections'])} cuts{loads}"


def main(count: int, seed: int = 1) -> int:
    """Try some; print what each is and took, and how many no verb spoke against."""
    draw, held = random.Random(seed), 0
    for number in range(1, count + 1):
        with tempfile.TemporaryDirectory() as name:
            began, case_seed = time.process_time(), draw.randrange(2**32)
            case = random.Random(case_seed)
            good = good_job(Path(name), case)
            found = faults(good, case)
            held += not found
            sys.stdout.write(
                f"{number}: seed {case_seed}, {good.what}, {_ended(good)}, "
                f"{time.process_time() - began:.0f} s: {found or 'holds'}\n"
            )
            sys.stdout.flush()
            if found:
                text = good.job.read_text(encoding="utf-8")
                sys.stderr.write(f"--- {number}\n{text}")
    sys.stdout.write(f"{held} of {count} hold\n")
    return 0 if held == count else 1


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:])))
