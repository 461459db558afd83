"""Time of recognising a crank beside that of welding it and building its solid.

    python benchmarks/recognition.py [--triangles 10000 100000 1000000] [--repeat 5]

Two cranks: the bundled one and the generated ``inline-4``, each triangle split in four as often as brings
their number nearest to the one asked for. *Weld* and *build* are what a binary STL costs once its bytes are
there; *overlap* looks for metal that counts twice. *Recognise* finds the axis, journals, throws and webs;
*faces* and *counterweights* are what ``balance`` looks for besides. Each is the least of several readings, on
a mesh not looked at before.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from main_job import BUNDLED, subdivided, write_stl  # noqa: E402

from autobalance.crank.anatomy import Overrides  # noqa: E402
from autobalance.crank.faces import find_faces  # noqa: E402
from autobalance.crank.recognition.recognise import recognise  # noqa: E402
from autobalance.crank.sections import counterweight_moments  # noqa: E402
from autobalance.drawn_cranks.design import PRESETS  # noqa: E402
from autobalance.drawn_cranks.generate import crank_solid  # noqa: E402
from autobalance.solid.csg.solid import Solid  # noqa: E402
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup  # noqa: E402
from autobalance.solid.soundness.validate import refuse_overlap  # noqa: E402

STAGES = ("weld", "build", "overlap", "recognise", "faces", "counterweights")
STEEL_G_MM3 = 7.85e-3


def seconds_of_stages(soup: np.ndarray, overrides: Overrides) -> dict[str, float]:
    """Return how long each stage takes, once."""
    marks = [time.perf_counter()]

    def mark() -> None:
        marks.append(time.perf_counter())

    mesh = mesh_of_soup(soup)
    mark()
    solid = Solid.from_mesh(Mesh(mesh.vertices, mesh.triangles))
    mark()
    refuse_overlap(solid)
    mark()
    anatomy = recognise(solid, overrides)
    mark()
    find_faces(solid.mesh, anatomy)
    mark()
    counterweight_moments(solid, anatomy, STEEL_G_MM3)
    mark()
    return dict(zip(STAGES, np.diff(marks).tolist(), strict=True))


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--repeat", type=int, default=5)
    arguments = parser.parse_args()
    print(f"{'crank':>10} {'triangles':>9} " + " ".join(f"{name:>14}" for name in STAGES), end="")
    print(f" {'recognise ÷ (weld + build)':>28}")
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "inline-4.stl"
        write_stl(drawn, crank_solid(PRESETS["inline-4"], 64).mesh.corners)
        cranks = {"bundled": (BUNDLED / "crank.stl", False), "inline-4": (drawn, True)}
        for name, (file, with_crankpins) in cranks.items():
            count = len(subdivided(file, 0))
            for wanted in arguments.triangles:
                splits = max(0, round(np.log(wanted / count) / np.log(4.0)))
                soup = subdivided(file, splits).astype(np.float32)
                overrides = Overrides(crankpin_in_file=with_crankpins)
                runs = [seconds_of_stages(soup, overrides) for _ in range(arguments.repeat)]
                least = {stage: min(run[stage] for run in runs) for stage in STAGES}
                times = " ".join(f"{1e3 * least[stage]:>11.1f} ms" for stage in STAGES)
                share = least["recognise"] / (least["weld"] + least["build"])
                print(f"{name:>10} {len(soup):>9} {times} {share:>28.2f}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
