"""Draw the pictures of ``engines.md``.

Run from the checkout's root: ``python docs/make_engine_pictures.py``.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
sys.path.insert(0, str(ROOT))

from autobalance.command import main  # noqa: E402


def draw() -> None:
    """Make the cranks of the examples in a scratch folder, analyse them and keep a plot of each."""
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        for job in (ROOT / "examples").glob("*.toml"):
            shutil.copyfile(job, here / job.name)
        smaller = ["--set", "counterweight.radius_mm=78"]
        main(["generate", "v8-crossplane", *smaller, "-o", str(here / "external-v8.stl")])
        for name in ("radial", "motorcycle"):
            main(["generate", "single", "-o", str(here / f"{name}.stl")])
        main(["balance", str(here / "external-v8-job.toml"), "-o", str(here / "v8")])
        main(["forces", str(here / "radial-job.toml"), "--plots", str(here / "radial")])
        motorcycle = ["forces", str(here / "motorcycle-job.toml"), "--mounts"]
        main([*motorcycle, "--plots", str(here / "motorcycle")])
        main(["torsion", str(here / "geared-train.toml"), "--plots", str(here / "geared")])
        for plot, name in (
            ("v8/crank-after", "external-v8"),
            ("radial/crankpins-polar", "radial-crankpins"),
            ("motorcycle/mounts-1", "motorcycle-handlebar"),
            ("geared/torsion-modes", "geared-modes"),
        ):
            shutil.copyfile(here / f"{plot}.png", PICTURES / f"{name}.png")


if __name__ == "__main__":
    draw()
