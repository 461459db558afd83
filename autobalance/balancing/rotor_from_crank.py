"""A measured crank becomes a straight rotor: shafts as flexible as its throws, discs as heavy as parts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalance.balancing.measured_crank import Crank
from autobalance.balancing.torsion_from_job import throw_shapes
from autobalance.crank.anatomy import Anatomy
from autobalance.crank.sections import sections
from autobalance.dynamics.crank_bending import ThrowBending, throw_bending
from autobalance.rigid_rotor.moments import Moments

KG_PER_G = 1e-3
KG_MM2_PER_G_MM2 = 1e-3
MPA_PER_GPA = 1e3
N_M2_PER_N_MM2 = 1e-6
WEIGHTLESS = 8.0
"""Density of the shaft [kg/m³], a thousandth of steel's: the discs have the crank's mass."""
LEAST_SHARE = 1e-9
WORTH = (
    "A throw bends more easily in its own plane than across it, and throws point different ways; a straight"
    " shaft has one stiffness, the mean of both. Expect the first bending frequencies of the bare crank"
    " within some 15 %; `fem` has them from the solid itself."
)


@dataclass(frozen=True, eq=False)
class StraightRotor:
    """A rotor file's structure for a crank, z from the crank's lower end; and its throws' stiffness."""

    file: dict[str, Any]
    throws: tuple[ThrowBending, ...]
    z_of_start_mm: float


def straight_rotor(
    crank: Crank, speed_rpm: float, bearing_n_m: float | None, e_gpa: float = 210.0, nu: float = 0.3
) -> StraightRotor:
    """Return the straight rotor of a crank.

    Parameters
    ----------
    crank : Crank
        Measured.
    speed_rpm : float
        [1/min].
    bearing_n_m : float or None
        Stiffness of each main bearing, 0: none at all; None: the mains are pinned.
    e_gpa, nu : float
        Of its material.
    """
    anatomy = crank.anatomy
    parts = [(part.kind, part.number, part.moments) for part in _sections(crank)]
    youngs = e_gpa * MPA_PER_GPA
    throws = tuple(throw_bending(shape, youngs, youngs / (2.0 * (1.0 + nu))) for shape in throw_shapes(crank))
    low, high = _reach_mm(crank)
    shaft = [
        {"length_mm": b - a, "outer_mm": diameter, "density_kg_m3": WEIGHTLESS, "e_gpa": e_gpa, "nu": nu}
        for a, b, diameter in _lengths(anatomy, throws, youngs, low, high)
    ]
    bearings = []
    if bearing_n_m != 0.0:
        held: dict[str, Any] = {"kind": "pinned"} if bearing_n_m is None else {"k_n_m": bearing_n_m}
        bearings = [{"z_mm": float(m.centre_mm[2]) - low, **held} for m in anatomy.main_journals]
    file = {
        "speed_rpm": speed_rpm,
        "beam": "euler",
        "shaft": shaft,
        "disc": [_disc(moments, low) for moments in _stations(parts, anatomy)],
        "bearing": bearings,
    }
    return StraightRotor(file, throws, low)


def _sections(crank: Crank) -> Any:
    return sections(crank.source.solid, crank.anatomy, crank.density_g_mm3)


def _reach_mm(crank: Crank) -> tuple[float, float]:
    bounds = crank.source.solid.moved(crank.anatomy.file_to_rotor).bounds
    return float(bounds[0, 2]), float(bounds[1, 2])


def _lengths(
    anatomy: Anatomy, throws: tuple[ThrowBending, ...], youngs_mpa: float, low: float, high: float
) -> list[tuple[float, float, float]]:
    """Return start, end and diameter of each length of shaft: ends, and throws between their journals."""
    places = [float(throw.crankpin.centre_mm[2]) for throw in anatomy.throws]
    mains = [float(main.centre_mm[2]) for main in anatomy.main_journals]
    cuts = []
    for below, above in zip([low, *places], [*places, high], strict=True):
        between = [z for z in mains if below < z < above]
        outer = below == low or above == high
        cuts.append(
            between[-1 if below == low else 0] if between else (below if outer else 0.5 * (below + above))
        )
    cuts[0] = cuts[0] if cuts[0] < places[0] else low
    cuts[-1] = cuts[-1] if cuts[-1] > places[-1] else high
    lengths = [
        (a, b, (64.0 * each.mean_n_mm2 / (math.pi * youngs_mpa)) ** 0.25)
        for a, b, each in zip(cuts[:-1], cuts[1:], throws, strict=True)
    ]
    journals = anatomy.main_journals
    ends = [(low, cuts[0], journals[0].diameter_mm), (cuts[-1], high, journals[-1].diameter_mm)]
    whole = [ends[0], *lengths, ends[1]]
    return [(a, b, d) for a, b, d in whole if b - a > LEAST_SHARE * (high - low)]


def _stations(parts: list[tuple[str, int, Moments]], anatomy: Anatomy) -> list[Moments]:
    """Return the moments of throws (crankpin and webs), journals and ends."""
    places = np.array([float(throw.crankpin.centre_mm[2]) for throw in anatomy.throws])
    found: dict[tuple[str, int], Moments] = {}
    for kind, number, moments in parts:
        key = (kind, number)
        if kind in ("crankpin", "web", "counterweight"):
            key = ("throw", int(np.argmin(np.abs(places - moments.centre_mm[2]))))
        found[key] = found.get(key, Moments.zero()) + moments
    return sorted(found.values(), key=lambda each: float(each.centre_mm[2]))


def _disc(moments: Moments, low_mm: float) -> dict[str, float]:
    centre = float(moments.centre_mm[2])
    along = float(moments.second_g_mm2[2, 2]) - moments.mass_g * centre**2
    polar = moments.polar_inertia_g_mm2
    return {
        "z_mm": centre - low_mm,
        "mass_kg": KG_PER_G * moments.mass_g,
        "polar_kg_mm2": KG_MM2_PER_G_MM2 * polar,
        "diametral_kg_mm2": KG_MM2_PER_G_MM2 * (0.5 * polar + along),
    }
