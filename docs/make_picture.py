"""Draw ``docs/crank.png``: the bundled crank after correction, in red what was cut from it.

Run from the checkout's root: ``python docs/make_picture.py``.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from autobalance.command import main
from autobalance.report.pictures.zbuffer import Camera, png, render
from autobalance.solid.formats.read import read

ROOT = Path(__file__).resolve().parents[1]
JOB = ROOT / "fixtures" / "crf250r" / "drafted" / "factor-0.28.toml"
STEEL, CUT = (0.72, 0.75, 0.78), (0.86, 0.16, 0.12)


def draw() -> None:
    """Balance the crank and draw it with the metal that went."""
    with tempfile.TemporaryDirectory() as folder:
        main(["balance", str(JOB), "-o", folder])
        after = read(Path(folder) / "balanced.stl", "mm", pressed_up=True).solid
    before = read(JOB.parent / "crank.stl", "mm", pressed_up=True).solid
    gone = before - after
    parts = [(after.mesh, STEEL), (gone.mesh, CUT)]
    vertices = np.concatenate([mesh.vertices for mesh, _ in parts])
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh, _ in parts[:-1]])
    triangles = np.concatenate(
        [mesh.triangles + start for (mesh, _), start in zip(parts, starts, strict=True)]
    )
    colours = np.concatenate([np.tile(colour, (len(mesh.triangles), 1)) for mesh, colour in parts])
    camera = Camera(looks=(-1.0, 0.9, -1.4), up=(0.0, 1.0, 0.0))
    picture = render(vertices, triangles, colours, camera, width=1000, height=620)
    (ROOT / "docs" / "crank.png").write_bytes(png(picture.image))


if __name__ == "__main__":
    draw()
