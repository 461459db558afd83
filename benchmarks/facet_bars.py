"""Whether the error bar of the facets falls as n⁻² and covers the truth, over all presets, and what it costs.

    python benchmarks/facet_bars.py [PRESET ...] [--segments 24 64 192 384]

Each preset is drawn with and without fillets, with so many corners of a full circle; the truth is the limit
of two fine tessellations. A line is marked where the bar does not cover the truth, is greater than that of
the mesh before, or falls half as fast as n⁻² asks.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from autobalance.balancing.measured_crank import facets_of_mesh
from autobalance.crank.parametric.design import PRESETS, Design, preset
from autobalance.crank.parametric.generate import crank_solid, exact_moments

SEGMENTS = (24, 32, 48, 64, 96, 128, 192, 256, 384, 512)


def marked(design: Design, segments: list[int]) -> int:
    """Print a line for each mesh of a crank; return how many are marked."""
    density = design.density_kg_m3 * 1e-6
    truth = exact_moments(design, 192)
    before, marks = None, 0
    for count in segments:
        solid = crank_solid(design, count)
        began = time.process_time()
        facets = facets_of_mesh(solid.mesh, density)
        seconds = time.process_time() - began
        off = truth - solid.moments(density) - facets.missing
        bar, unbalance = facets.unbalance_bar_g_mm, math.hypot(*off.first_g_mm[:2])
        wrong = [
            *(["unbalance not covered"] if unbalance > bar else []),
            *(["mass not covered"] if abs(off.mass_g) > facets.mass_bar_g else []),
            *(["rises"] if before and bar > before[1] else []),
            *(["falls slowly"] if before and bar > 2.0 * before[1] * (before[0] / count) ** 2 else []),
        ]
        way = "edges" if facets.fitted is None else "fit"
        mesh = f"{count} segments, {len(solid.mesh.triangles)} triangles ({way}, {seconds:.2f} s)"
        mass = f"{abs(off.mass_g):.2g} of ± {facets.mass_bar_g:.3g} g"
        print(
            f"{design.name}, fillets {design.fillet_mm:g} mm, {mesh}: "
            f"{unbalance:.2g} of ± {bar:.3g} g·mm, {mass} {'; '.join(wrong)}",
            flush=True,
        )
        before, marks = (count, bar), marks + bool(wrong)
    return marks


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("presets", nargs="*", default=[], metavar="PRESET")
    parser.add_argument("--segments", type=int, nargs="+", default=list(SEGMENTS))
    arguments = parser.parse_args()
    marks = 0
    for name in arguments.presets or list(PRESETS):
        design = preset(name)
        marks += marked(design, arguments.segments)
        if design.fillet_mm:
            marks += marked(replace(design, fillet_mm=0.0), arguments.segments)
    print(f"{marks} meshes marked")
    return 1 if marks else 0


if __name__ == "__main__":
    raise SystemExit(main())
