"""Recognise simulated scans and hold them against the truth: python -m benchmarks.scans [COUNT].

Cranks of several layouts, σ of 0.005 to 0.05 mm, whole or decimated, and parts that are no crank. A line
each, then how many were right, refused and wrong, and how many true values lie within three standard errors.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import replace
from typing import TypeVar

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Overrides, Pin
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import AutobalanceError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from tests.scans import Scan, decimated, scan, wrong_part

CRANKS = (
    "single",
    "pressed-up-single",
    "pressed-up-single-no-pin",
    "v-twin-45",
    "parallel-twin-360",
    "inline-3",
    "v6-60",
)
SIGMAS_MM = (0.005, 0.02, 0.05)
WRONG = ("camshaft", "propeller shaft")
EDGE_MM = 1.8
AnyPin = TypeVar("AnyPin", Pin, MainJournal)


def from_the_other_end(true: Anatomy) -> Anatomy:
    """Return an anatomy whose z runs the other way: the last throw is the first, and at 0°."""
    first = true.throws[-1].crankpin.centre_mm * (1.0, -1.0, -1.0)
    turn = np.exp(-1j * math.atan2(first[1], first[0]))

    def moved(pin: AnyPin) -> AnyPin:
        x, y, z = pin.centre_mm * (1.0, -1.0, -1.0) - (0.0, 0.0, first[2])
        in_plane = complex(x, y) * turn
        return replace(pin, centre_mm=np.array([in_plane.real, in_plane.imag, z]))

    return replace(
        true,
        main_journals=tuple(moved(pin) for pin in reversed(true.main_journals)),
        throws=tuple(replace(each, crankpin=moved(each.crankpin)) for each in reversed(true.throws)),
        webs=tuple(
            replace(web, z_min_mm=-web.z_max_mm - first[2], z_max_mm=-web.z_min_mm - first[2])
            for web in reversed(true.webs)
        ),
    )


def errors(found: Anatomy, there: Scan) -> list[tuple[float, float]] | None:
    """Return errors and their standard errors; None where something is miscounted."""
    true, fit = there.truth, found.scan
    if float(true.rotor_to_file[:3, 2] @ found.rotor_to_file[:3, 2]) < 0.0:
        true = from_the_other_end(true)
    parts = [[len(part) for part in (a.main_journals, a.throws, a.webs)] for a in (found, true)]
    if parts[0] != parts[1] or fit is None:
        return None
    places = zip(
        (*found.main_journals, *(throw.crankpin for throw in found.throws)),
        (*true.main_journals, *(throw.crankpin for throw in true.throws)),
        strict=True,
    )
    if any(abs(a.centre_mm[2] - b.centre_mm[2]) > 0.1 * b.width_mm for a, b in places):
        return None
    pairs = []
    shafts = [
        *zip(found.main_journals, true.main_journals, fit.journals, strict=True),
        *zip(
            (throw.crankpin for throw in found.throws),
            (throw.crankpin for throw in true.throws),
            fit.crankpins,
            strict=True,
        ),
    ]
    for pin, other, sure in shafts:
        pairs.append((pin.diameter_mm - other.diameter_mm, sure.diameter_pm_mm))
        pairs += zip(pin.centre_mm[:2] - other.centre_mm[:2], sure.centre_pm_mm[:2], strict=True)
    for throw, same, pm in zip(found.throws, true.throws, fit.crank_radius_pm_mm, strict=True):
        pairs.append((throw.crank_radius_mm - same.crank_radius_mm, pm))
    for web, there_too, each in zip(found.webs, true.webs, fit.webs, strict=True):
        pairs.append((web.z_min_mm - there_too.z_min_mm, each.z_min_pm_mm))
        pairs.append((web.z_max_mm - there_too.z_max_mm, each.z_max_pm_mm))
    return pairs


def recognised(mesh: Mesh) -> Anatomy | None:
    """Return the crank in a mesh as an STL file keeps it; None where it is refused."""
    try:
        solid = Solid.from_mesh(mesh_of_soup(mesh.corners.astype(np.float32)))
        return recognise(solid, Overrides(crankpin_in_file=None))
    except AutobalanceError:
        return None


def main(count: int) -> None:
    """Print the table."""
    right = refused = wrong = sure = values = 0
    for number in range(count):
        begun = time.perf_counter()
        if number % 10 == 9:
            name = WRONG[number // 10 % len(WRONG)]
            found = recognised(wrong_part(name, 0.03, edge_mm=1.6, seed=number))
            verdict = "refused, rightly" if found is None else "WRONG"
            right, wrong = right + (found is None), wrong + (found is not None)
        else:
            name = CRANKS[number % len(CRANKS)]
            sigma = SIGMAS_MM[number // len(CRANKS) % len(SIGMAS_MM)]
            there = scan(name, sigma, edge_mm=EDGE_MM, seed=number)
            mesh = decimated(there.mesh, 15_000) if number % 4 == 3 else there.mesh
            found = recognised(mesh)
            pairs = None if found is None else errors(found, there)
            name = f"{name} σ {sigma:g}, {len(mesh.triangles)} triangles"
            if found is None:
                verdict, refused = "refused", refused + 1
            elif pairs is None or max(abs(error) for error, _ in pairs) > 3.0 * sigma + 0.02:
                verdict, wrong = "WRONG", wrong + 1
            else:
                right += 1
                sure += sum(abs(error) < 3.0 * pm + 1e-3 for error, pm in pairs)
                values += len(pairs)
                verdict = f"right to {max(abs(error) for error, _ in pairs):.4f} mm"
        print(f"{number:4d}  {name}: {verdict}, {time.perf_counter() - begun:.1f} s", flush=True)
    print(f"{right} right, {refused} refused, {wrong} wrong; {sure} of {values} values within three errors")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
