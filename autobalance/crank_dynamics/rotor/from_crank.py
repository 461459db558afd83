"""A measured crank as a straight rotor: shafts as flexible as its throws, parts as discs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Self

from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Pin
from autobalance.crank.sections import Section, sections
from autobalance.crank_dynamics.torsion.chain import ThrowShape
from autobalance.crank_dynamics.torsion.from_job import sides_of_throws, throw_shapes, webs_beside
from autobalance.declare import Ordinal, Positive, record
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.units import KG_MM2_PER_G_MM2, KG_PER_G, MPA_PER_GPA
from autobalance.value_classes import dataclass

# Bending stiffness of a crank throw, as that of an equivalent straight shaft.
#
# A throw is taken as a frame of journal, web, crankpin, web, journal [1]_. A constant bending moment in the
# plane of the throw bends both webs across their thickness; one across that plane twists them. Each length
# adds its flexibility, corners add none.
#
# References
# ----------
# .. [1] S. Timoshenko, The bending and torsion of multi-throw crankshafts on many supports, Trans. ASME 45
#    (1923) 449.


@dataclass(frozen=True)
class ThrowBending:
    """EI of a straight shaft of a throw's length and bending flexibility [N·mm²]."""

    in_plane_n_mm2: float
    across_n_mm2: float

    @property
    def mean_n_mm2(self) -> float:
        """EI of an equivalent round shaft: by the mean flexibility of both planes."""
        return 2.0 / (1.0 / self.in_plane_n_mm2 + 1.0 / self.across_n_mm2)


def throw_bending(shape: ThrowShape, youngs_mpa: float, shear_mpa: float) -> ThrowBending:
    """Return the equivalent bending stiffness of a throw.

    Parameters
    ----------
    shape : ThrowShape
        The throw reaches from the middle of one journal to the middle of the next.
    youngs_mpa, shear_mpa : float
        E and G [MPa].

    Examples
    --------
    >>> straight = ThrowShape(50, 0, 40, 50, 0, 40, 1e-9, 10, 50)
    >>> found = throw_bending(straight, 210e3, 80e3)
    >>> bare = 210e3 * math.pi / 64 * 50**4
    >>> round(found.mean_n_mm2 / bare, 3)  # 100 mm long, of which the webs' 20 mm are rigid
    1.25
    """
    journal = math.pi / 64.0 * (shape.journal_mm**4 - shape.journal_bore_mm**4)
    pin = math.pi / 64.0 * (shape.pin_mm**4 - shape.pin_bore_mm**4)
    length = shape.journal_length_mm + shape.pin_length_mm + 2.0 * shape.web_thickness_mm
    shafts = (shape.journal_length_mm / journal + shape.pin_length_mm / pin) / youngs_mpa
    webs = 2.0 * shape.crank_radius_mm
    web = shape.web_breadth_mm * shape.web_thickness_mm**3 / 12.0
    in_plane = shafts + webs / (youngs_mpa * web)
    across = shafts + webs / (shear_mpa * rectangle_torsion_mm4(shape.web_breadth_mm, shape.web_thickness_mm))
    return ThrowBending(length / in_plane, length / across)


def web_bending(shape: ThrowShape, youngs_mpa: float, shear_mpa: float) -> ThrowBending:
    """Return EI of a straight shaft of one web's thickness and bending flexibility."""
    web = shape.web_breadth_mm * shape.web_thickness_mm**3 / 12.0
    twist = rectangle_torsion_mm4(shape.web_breadth_mm, shape.web_thickness_mm)
    share = shape.web_thickness_mm / shape.crank_radius_mm
    return ThrowBending(share * youngs_mpa * web, share * shear_mpa * twist)


def rectangle_torsion_mm4(breadth_mm: float, thickness_mm: float) -> float:
    """Return the torsion constant of a rectangle, to 0.5 %: a b³ (1/3 − 0.21 b/a (1 − b⁴/12a⁴)).

    Examples
    --------
    >>> round(rectangle_torsion_mm4(1.0, 1.0), 3)
    0.141
    """
    a, b = max(breadth_mm, thickness_mm), min(breadth_mm, thickness_mm)
    return a * b**3 * (1.0 / 3.0 - 0.21 * b / a * (1.0 - b**4 / (12.0 * a**4)))


# A measured crank becomes a straight rotor: shafts as flexible as its throws, discs as heavy as parts.


E_GPA, NU = 210.0, 0.3
"""Young's modulus [GPa] and Poisson's ratio of steel."""
N_M2_PER_N_MM2 = 1e-6
MASSLESS_DENSITY_KG_M3 = 8.0
"""Density of the shaft [kg/m³], a thousandth of steel's: the discs have the crank's mass."""
LEAST_SHARE = 1e-9
MEANING = (
    "A throw bends more easily in its own plane than across it, and throws point different ways; a straight"
    " shaft has one stiffness, the mean of both. An estimate of size alone: free in space the bundled"
    " motocross single came out at 1.24 kHz, its solid at 1.6 kHz in one plane and 2.4 kHz in the other; a"
    " generated one at 2.06 kHz against 1.46 and 2.31 kHz. `fem` has it from the solid itself."
)


@record
class ThrowStiffness:
    """Bending stiffness of a throw as its equivalent straight shaft has it."""

    number: Ordinal
    in_plane_N_m2: Positive
    across_N_m2: Positive
    used_N_m2: Positive

    @classmethod
    def of(cls, number: int, throw: ThrowBending) -> Self:
        return cls(
            number=number,
            in_plane_N_m2=N_M2_PER_N_MM2 * throw.in_plane_n_mm2,
            across_N_m2=N_M2_PER_N_MM2 * throw.across_n_mm2,
            used_N_m2=N_M2_PER_N_MM2 * throw.mean_n_mm2,
        )


@record
class EquivalentShaft:
    """The straight rotor in a crank's place, and what it is worth."""

    worth: str
    z_of_start_mm: float
    throws: Sequence[ThrowStiffness]


@dataclass(frozen=True, eq=False)
class StraightRotor:
    """A rotor file's structure for a crank, z from the crank's lower end."""

    file: dict[str, Any]
    equivalent: EquivalentShaft


def straight_rotor(crank: Crank, speed_rpm: float, bearing_n_m: float | None) -> StraightRotor:
    """Return the straight rotor of a crank.

    Parameters
    ----------
    crank : Crank
        Measured.
    speed_rpm : float
        [1/min].
    bearing_n_m : float or None
        Stiffness of each main bearing, 0: none at all; None: the mains are pinned.
    """
    anatomy = crank.anatomy
    parts = sections(crank.source.solid, anatomy, crank.density_g_mm3)
    youngs = E_GPA * MPA_PER_GPA
    shear = youngs / (2.0 * (1.0 + NU))
    throws = tuple(throw_bending(shape, youngs, shear) for shape in throw_shapes(crank))
    low, _ = _reach_mm(crank)
    shaft = [
        {
            "length_mm": b - a,
            "outer_mm": diameter,
            "density_kg_m3": MASSLESS_DENSITY_KG_M3,
            "e_gpa": E_GPA,
            "nu": NU,
        }
        for a, b, diameter in _lengths(crank, youngs, shear)
    ]
    bearings = []
    if bearing_n_m != 0.0:
        held: dict[str, Any] = {"kind": "pinned"} if bearing_n_m is None else {"k_n_m": bearing_n_m}
        bearings = [{"z_mm": float(m.centre_mm[2]) - low, **held} for m in anatomy.main_journals]
    file = {
        "speed_rpm": speed_rpm,
        "beam": "euler",
        "shaft": shaft,
        "disc": [_disc(moments, low) for moments in _stations(parts)],
        "bearing": bearings,
    }
    stiffness = [ThrowStiffness.of(number, each) for number, each in enumerate(throws, 1)]
    return StraightRotor(file, EquivalentShaft(worth=MEANING, z_of_start_mm=low, throws=stiffness))


def _reach_mm(crank: Crank) -> tuple[float, float]:
    bounds = crank.source.solid.moved(crank.anatomy.file_to_rotor).bounds
    return float(bounds[0, 2]), float(bounds[1, 2])


def _lengths(crank: Crank, youngs_mpa: float, shear_mpa: float) -> list[tuple[float, float, float]]:
    """Return start, end and diameter of each length of shaft: journals, webs, crankpins, ends."""
    anatomy, webs = crank.anatomy, {}
    for throw, sides in zip(anatomy.throws, sides_of_throws(crank), strict=True):
        for web, side in zip(webs_beside(anatomy, throw), sides, strict=True):
            stiffness = web_bending(side, youngs_mpa, shear_mpa).mean_n_mm2
            webs[web.number] = (web, (64.0 * stiffness / (math.pi * youngs_mpa)) ** 0.25)
    low, high = _reach_mm(crank)
    pins: list[Pin] = [*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)]
    marks = {low, high} | {z for web, _ in webs.values() for z in (web.z_min_mm, web.z_max_mm)}
    lengths = []
    for a, b in pairwise(sorted(marks)):
        if b - a <= LEAST_SHARE * (high - low):
            continue
        inside = [d for web, d in webs.values() if web.z_min_mm < 0.5 * (a + b) < web.z_max_mm]
        nearest = min(pins, key=lambda pin: abs(float(pin.centre_mm[2]) - 0.5 * (a + b)))
        lengths.append((a, b, inside[0] if inside else nearest.diameter_mm))
    return lengths


def _stations(parts: Sequence[Section]) -> list[Moments]:
    """Return the moments of journals, crankpins, webs with their counterweights, and ends."""
    by_station: dict[tuple[str, int], Moments] = {}
    for part in parts:
        key = ("web" if part.kind == "counterweight" else part.kind, part.number)
        by_station[key] = by_station.get(key, Moments.zero()) + part.moments
    return sorted(by_station.values(), key=lambda each: float(each.centre_mm[2]))


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
