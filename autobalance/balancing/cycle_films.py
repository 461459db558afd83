"""Oil films of main bearings and big ends through a cycle, from their loads and the job's clearances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.engine.cycle.analysis import CycleAnalysis
from autobalance.engine.cycle.factors import MainLoads
from autobalance.engine.slider_crank import Complex
from autobalance.job.cycle import Film
from autobalance.rigid_rotor.moments import Array

if TYPE_CHECKING:
    from autobalance.bearings.orbit import Orbits

Values = dict[str, Any]
EVERY = 2
"""Angles of the grid from one force to the next: a degree."""
M_PER_MM = 1e-3


@dataclass(frozen=True, eq=False)
class Bearings:
    """Plain bearings of a crank: diameters, lengths and radial clearances (k,) [mm]."""

    diameter_mm: Array
    length_mm: Array
    clearance_mm: Array


@dataclass(frozen=True, eq=False)
class CycleFilms:
    """Orbits of the journals in main bearings, one each, and of crankpins in big ends, None without any."""

    mains: Orbits
    big_ends: Orbits | None


def main_bearings(anatomy: Anatomy, film: Film) -> Bearings:
    """Return the main bearings of a crank, increasing z."""
    pins = sorted(anatomy.main_journals, key=lambda pin: float(pin.centre_mm[2]))
    lengths = [film.main_length_mm or pin.width_mm for pin in pins]
    clearances = np.full(len(pins), film.main_clearance_mm)
    return Bearings(np.array([pin.diameter_mm for pin in pins]), np.array(lengths), clearances)


def big_ends(anatomy: Anatomy, film: Film, rods: Sequence[int]) -> Bearings | None:
    """Return the big ends by cylinder, with the rods of each throw; None where no clearance is given."""
    if film.crankpin_clearance_mm is None:
        return None
    pins = [throw.crankpin for throw, count in zip(anatomy.throws, rods, strict=True) for _ in range(count)]
    shares = [count for count in rods for _ in range(count)]
    lengths = [film.crankpin_length_mm or pin.width_mm / n for pin, n in zip(pins, shares, strict=True)]
    clearances = np.full(len(pins), film.crankpin_clearance_mm)
    return Bearings(np.array([pin.diameter_mm for pin in pins]), np.array(lengths), clearances)


def cycle_films(found: CycleAnalysis, anatomy: Anatomy, film: Film) -> CycleFilms:
    """Return the films of a cycle's loads.

    The rod swings about a mean turning speed of zero, which is taken for its big end's.
    """
    speed = found.speed_rad_s
    mains = main_bearings(anatomy, film)
    loads = MainLoads.of(found.firing)
    whole = loads.parts.mains_n(speed, loads.parts.crank_n)
    ends = big_ends(anatomy, film, [len(throw.cylinders) for throw in found.firing.throws])
    if ends is None:
        return CycleFilms(_orbits(found, whole, mains, film), None)
    rods = found.loads.crankpin_n
    on_rods = -(rods[..., 0] + 1j * rods[..., 1])
    return CycleFilms(_orbits(found, whole, mains, film), _orbits(found, on_rods, ends, film))


def least_films_mm(
    found: CycleAnalysis, anatomy: Anatomy, film: Film, factors: Sequence[float]
) -> list[float | None]:
    """Return the least film of all mains of an ideal crank by balance factor; None where one breaks [mm]."""
    loads = MainLoads.of(found.firing)
    forces = [loads.parts.mains_n(found.speed_rad_s, loads.crank_n(factor)) for factor in factors]
    bearings = main_bearings(anatomy, film)
    count = len(bearings.diameter_mm)
    many = Bearings(
        np.tile(bearings.diameter_mm, len(factors)),
        np.tile(bearings.length_mm, len(factors)),
        np.tile(bearings.clearance_mm, len(factors)),
    )
    orbits = _orbits(found, np.concatenate(forces), many, film)
    films, broken = orbits.least_film_m / M_PER_MM, orbits.contact
    return [
        None if broken[first : first + count].any() else float(films[first : first + count].min())
        for first in range(0, count * len(factors), count)
    ]


def _orbits(found: CycleAnalysis, force_n: Complex, bearings: Bearings, film: Film) -> Orbits:
    """Return the orbits of journals under forces (k, n) on their bushes."""
    from autobalance.bearings.orbit import film_orbits

    even = force_n[:, : found.grid.even_rad.size : EVERY].T
    return film_orbits(
        found.grid.even_rad[::EVERY],
        np.stack([even.real, even.imag], axis=-1),
        found.speed_rad_s,
        film.viscosity_pa_s,
        bearings.diameter_mm * M_PER_MM,
        bearings.length_mm * M_PER_MM,
        bearings.clearance_mm * M_PER_MM,
    )


def film_values(films: CycleFilms) -> Values:
    """Return films as JSON values."""
    ends = films.big_ends
    return {
        "main_journals": _rows(films.mains),
        "big_ends": None if ends is None else _rows(ends),
    }


def _rows(orbits: Orbits) -> list[Values]:
    return [_row(number, orbits.case(number - 1)) for number in range(1, orbits.eccentricity.shape[1] + 1)]


def _row(number: int, orbit: Orbits) -> Values:
    """Return one bearing's film; a broken one has no numbers but its limit."""
    broken, turns = bool(orbit.contact[0]), int(orbit.turns_to_settle[0])
    limit = "contact" if broken else None if turns else "not periodic"
    told = limit is None
    return {
        "number": number,
        "least_film_mm": float(orbit.least_film_m[0]) / M_PER_MM if told else None,
        "at_deg": math.degrees(float(orbit.least_at_rad[0])) if told else None,
        "greatest_eccentricity_ratio": float(orbit.ratio.max()) if told else None,
        "mean_friction_N_m": float(orbit.mean_moment_N_m[0]) if told else None,
        "turns_to_settle": turns if told else None,
        "limit": limit,
    }
