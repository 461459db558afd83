"""Whether the error bar of the facets falls as n⁻² and covers the truth, over all presets, and what it costs.

    python benchmarks/facet_bars.py [CRANK ...] [--segments 24 64 192 384] [--sampled]
    python benchmarks/facet_bars.py --odd 60 [--first 0] [--segments ...] [--sampled]

Each preset is drawn with and without fillets, with so many corners of a full circle; so are cranks whose webs
have blunt edges, chamfers, drafts and knife edges. The truth is the limit of two fine tessellations, good to
1e-7 of the mass. A line is marked where the bar does not cover the truth, is greater than that of the mesh
before, falls half as fast as n⁻² asks, or where estimate and bar together are more than ten times what the
facets hide (of 48 segments and more; of fewer a blunt edge may be a chord) and than a hundredth of what they
would if nothing cancelled: of throws at 0 and 180° that is all. With --sampled surfaces are carried from a
sample of the facets, as in a large mesh. With --odd the tests' odd cranks are drawn.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from autobalance.drawn_cranks.design import PRESETS, preset
from autobalance.drawn_cranks.generate import crank_shape
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh
from autobalance.solid.csg.shape import Shape, tessellated
from tests.blunt import BLUNT
from tests.odd_cranks import odd_crank

SEGMENTS = (24, 32, 48, 64, 96, 128, 192, 256, 384, 512)


TRUTH_SHARE, REACH_MM = 2e-7, 10.0
"""What the limit of two tessellations may be off by: a share of the mass, so far from the axis together."""
TIMES, FROM_SEGMENTS, OF_GROSS = 10.0, 48, 0.01


def marked(name: str, shape: Shape, density: float, segments: list[int], most: int | None) -> int:
    """Print a line for each mesh of a crank; return how many are marked."""
    coarse, fine = (tessellated(shape, 192, times).moments(density) for times in (1, 2))
    truth = fine.scaled(4.0 / 3.0) - coarse.scaled(1.0 / 3.0)
    unsure = TRUTH_SHARE * truth.mass_g
    before, marks = None, 0
    for count in segments:
        solid = tessellated(shape, count)
        began = time.process_time()
        facets = chordal_error_of_mesh(solid.mesh, density, most=most)
        seconds = time.process_time() - began
        hidden = truth - solid.moments(density)
        off = hidden - facets.missing
        bar, unbalance = facets.unbalance_bar_g_mm, math.hypot(*off.first_g_mm[:2])
        told, true = facets.unbalance_g_mm + bar, math.hypot(*hidden.first_g_mm[:2])
        least = max(TIMES * (true + unsure * REACH_MM), OF_GROSS * facets.gross_unbalance_g_mm)
        wide = count >= FROM_SEGMENTS and told > least
        wrong = [
            *(["unbalance not covered"] if unbalance > bar + unsure * REACH_MM else []),
            *(["mass not covered"] if abs(off.mass_g) > facets.mass_bar_g + unsure else []),
            *(
                [f"{told / true:.0f} times the true error, {told / facets.gross_unbalance_g_mm:.2g} of all"]
                if wide
                else []
            ),
            *(["rises"] if before and bar > before[1] else []),
            *(["falls slowly"] if before and bar > 2.0 * before[1] * (before[0] / count) ** 2 else []),
        ]
        mesh = f"{count} segments, {len(solid.mesh.triangles)} triangles ({seconds:.2f} s)"
        mass = f"{abs(off.mass_g):.2g} of ± {facets.mass_bar_g:.3g} g"
        print(
            f"{name}, {mesh}: hidden {true:.2g} g·mm, known to {unbalance:.2g} of ± {bar:.3g} g·mm, "
            f"{mass} {'; '.join(wrong)}",
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
    parser.add_argument("--sampled", action="store_true")
    parser.add_argument("--odd", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    marks, most = 0, 0 if arguments.sampled else None
    for seed in range(arguments.first, arguments.first + arguments.odd):
        odd = odd_crank(seed)
        marks += marked(f"{seed} {odd.kind}", odd.shape, 7.85e-3, arguments.segments, most)
    for name in arguments.presets or ([] if arguments.odd else [*PRESETS, *BLUNT]):
        if name in BLUNT:
            marks += marked(name, BLUNT[name], 7.85e-3, arguments.segments, most)
            continue
        design = preset(name)
        for each in (design, *([replace(design, fillet_mm=0.0)] if design.fillet_mm else [])):
            label = f"{name}, fillets {each.fillet_mm:g} mm"
            marks += marked(label, crank_shape(each), each.density_kg_m3 * 1e-6, arguments.segments, most)
    print(f"{marks} meshes marked")
    return 1 if marks else 0


if __name__ == "__main__":
    raise SystemExit(main())
