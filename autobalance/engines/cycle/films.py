"""Oil films of main bearings and big ends through a cycle, from their loads and the job's clearances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Count,
    Degrees,
    NotNegative,
    Ordinal,
    Positive,
    Registered,
    record,
)
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import FactorMainLoads
from autobalance.engines.cycle.figures import CycleSummary, PendulumFigures, SweepRow
from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.engines.cycle.model import OilFilms
from autobalance.engines.cycle.section import cycle_section_types
from autobalance.report.records.answers import Head, JobEcho
from autobalance.types import Array, Complex
from autobalance.units import M_PER_MM
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.engines.bearings.orbit import Orbits


FILM_ANGLE_STRIDE = 2
"""Angles of the grid from one force to the next: a degree, and two if there are many bearings."""
FEW_BEARINGS = 100
"""Bearings up to which they are not many."""


@dataclass(frozen=True, eq=False)
class Bearings:
    """Plain bearings of a crank: diameters, lengths and radial clearances (k,) [mm]."""

    diameter_mm: Array
    length_mm: Array
    clearance_mm: Array


@dataclass(frozen=True, eq=False)
class CycleFilms:
    """Orbits of the journals in main bearings, one each, and of crankpins in big ends, None without any.

    ``big_end_cylinders`` are the numbers, from 1, of the cylinders whose rods the big ends belong to.
    """

    mains: Orbits
    big_ends: Orbits | None
    big_end_cylinders: tuple[int, ...] = ()


def main_bearings(anatomy: Anatomy, film: OilFilms) -> Bearings:
    """Return the main bearings of a crank, increasing z."""
    pins = sorted(anatomy.main_journals, key=lambda pin: float(pin.centre_mm[2]))
    lengths = [film.main_length_mm or pin.width_mm for pin in pins]
    clearances = np.full(len(pins), film.main_clearance_mm)
    return Bearings(np.array([pin.diameter_mm for pin in pins]), np.array(lengths), clearances)


def big_ends(anatomy: Anatomy, film: OilFilms, rods: Sequence[int]) -> Bearings | None:
    """Return the big ends, with the number of them on each throw; None if no clearance is given."""
    if film.crankpin_clearance_mm is None:
        return None
    pins = [throw.crankpin for throw, count in zip(anatomy.throws, rods, strict=True) for _ in range(count)]
    shares = [count for count in rods for _ in range(count)]
    lengths = [film.crankpin_length_mm or pin.width_mm / n for pin, n in zip(pins, shares, strict=True)]
    clearances = np.full(len(pins), film.crankpin_clearance_mm)
    return Bearings(np.array([pin.diameter_mm for pin in pins]), np.array(lengths), clearances)


def cycle_films(cycle: CycleAnalysis, anatomy: Anatomy, film: OilFilms) -> CycleFilms:
    """Return the films of a cycle's loads.

    The rod swings about a mean turning speed of zero, which is taken for its big end's.
    """
    speed = cycle.speed_rad_s
    mains = main_bearings(anatomy, film)
    loads = FactorMainLoads.of(cycle.firing)
    whole = loads.parts.mains_n(speed, loads.parts.crank_n)
    groups = [_on_crankpin(cycle.firing, throw.cylinders) for throw in cycle.firing.throws]
    ends = big_ends(anatomy, film, [len(each) for each in groups])
    if ends is None:
        return CycleFilms(orbits_of(cycle.firing, whole, mains, film.viscosity_pa_s, speed), None)
    rods = [cycle.loads.crankpin_n[list(rod)].sum(axis=0) for group in groups for rod in group]
    on_rods = np.stack([-(load[:, 0] + 1j * load[:, 1]) for load in rods])
    return CycleFilms(
        orbits_of(cycle.firing, whole, mains, film.viscosity_pa_s, speed),
        orbits_of(cycle.firing, on_rods, ends, film.viscosity_pa_s, speed),
        tuple(rod[0] + 1 for group in groups for rod in group),
    )


def films_of_mains_mm(
    cycle: CycleAnalysis, anatomy: Anatomy, film: OilFilms, force_n: Complex
) -> list[float | None]:
    """Return the least film of each main under any forces (m, n), x + iy; None where it breaks [mm]."""
    mains = main_bearings(anatomy, film)
    orbits = orbits_of(cycle.firing, force_n, mains, film.viscosity_pa_s, cycle.speed_rad_s)
    settled = (orbits.turns_to_settle > 0) & ~orbits.contact
    films = orbits.least_film_m / M_PER_MM
    return [float(value) if good else None for value, good in zip(films, settled, strict=True)]


def _on_crankpin(firing: FiringEngine, cylinders: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the rods that turn on a crankpin, each as its cylinder (from 0) and those of the links on it.

    Link rods turn on the knuckle pins of their master rod, whose one big end carries them all.
    """
    of = firing.engine.cylinders
    return [
        (number, *(each for each in cylinders if of[each].master == number))
        for number in cylinders
        if of[number].master is None
    ]


def least_films_mm(
    firing: FiringEngine,
    anatomy: Anatomy,
    film: OilFilms,
    speeds_rad_s: Sequence[float],
    factors: Sequence[float],
) -> list[list[float | None]]:
    """Return the least film of all mains of ideal cranks, by speed and factor; None where one breaks [mm].

    All orbits are followed at once.
    """
    loads = FactorMainLoads.of(firing)
    cases = [(speed, factor) for speed in speeds_rad_s for factor in factors]
    forces = [loads.parts.mains_n(speed, loads.crank_n(factor)) for speed, factor in cases]
    bearings = main_bearings(anatomy, film)
    count = len(bearings.diameter_mm)
    many = Bearings(
        np.tile(bearings.diameter_mm, len(cases)),
        np.tile(bearings.length_mm, len(cases)),
        np.tile(bearings.clearance_mm, len(cases)),
    )
    speeds = np.repeat([speed for speed, _ in cases], count)
    orbits = orbits_of(firing, np.concatenate(forces), many, film.viscosity_pa_s, speeds)
    settled = (orbits.turns_to_settle > 0) & ~orbits.contact
    films = (orbits.least_film_m / M_PER_MM).reshape(-1, count).min(axis=1)
    known = [bool(row.all()) for row in settled.reshape(-1, count)]
    flat = [float(value) if good else None for value, good in zip(films, known, strict=True)]
    return [flat[first : first + len(factors)] for first in range(0, len(flat), len(factors))]


def orbits_of(
    firing: FiringEngine,
    force_n: Complex,
    bearings: Bearings,
    viscosity_pa_s: Array | float,
    speed_rad_s: Array | float,
) -> Orbits:
    """Return the orbits of journals under forces (k, n) on their bushes; viscosity and speed may be (k,)."""
    from autobalance.engines.bearings.orbit import film_orbits

    every = FILM_ANGLE_STRIDE if len(force_n) <= FEW_BEARINGS else 2 * FILM_ANGLE_STRIDE
    even = force_n[:, : firing.grid.even_rad.size : every].T
    return film_orbits(
        firing.grid.even_rad[::every],
        np.stack([even.real, even.imag], axis=-1),
        speed_rad_s,
        viscosity_pa_s,
        bearings.diameter_mm * M_PER_MM,
        bearings.length_mm * M_PER_MM,
        bearings.clearance_mm * M_PER_MM,
    )


@record
class FilmFigures:
    """The film of one bearing; a broken one has no numbers but its limit."""

    number: Ordinal
    least_film_mm: NotNegative | None
    at_rad: Degrees | None
    greatest_eccentricity_ratio: NotNegative | None
    mean_friction_N_m: float | None
    turns_to_settle: Count | None
    limit: Literal["contact", "not periodic"] | None
    change_of_eccentricity: Annotated[
        NotNegative | Absent, "how far a path that does not repeat is from doing so"
    ] = ABSENT

    @classmethod
    def of(cls, number: int, orbit: Orbits) -> Self:
        broken, turns = bool(orbit.contact[0]), int(orbit.turns_to_settle[0])
        settled = turns > 0 and not broken
        return cls(
            number=number,
            least_film_mm=float(orbit.least_film_m[0]) / M_PER_MM if settled else None,
            at_rad=float(orbit.least_at_rad[0]) if settled else None,
            greatest_eccentricity_ratio=float(orbit.ratio.max()) if settled else None,
            mean_friction_N_m=float(orbit.mean_moment_N_m[0]) if settled else None,
            turns_to_settle=turns if settled else None,
            limit="contact" if broken else None if turns else "not periodic",
            change_of_eccentricity=ABSENT if broken or turns or orbit.off is None else float(orbit.off[0]),
        )


@record
class FilmTable:
    """Films of main bearings and big ends, these by the number of their rod's cylinder."""

    main_journals: Sequence[FilmFigures]
    big_ends: Sequence[FilmFigures] | None


def film_table(films: CycleFilms) -> FilmTable:
    ends = films.big_ends
    numbers = range(1, films.mains.eccentricity.shape[1] + 1)
    return FilmTable(
        main_journals=_rows(films.mains, numbers),
        big_ends=None if ends is None else _rows(ends, films.big_end_cylinders),
    )


def _rows(orbits: Orbits, numbers: Sequence[int]) -> list[FilmFigures]:
    return [FilmFigures.of(number, orbits.case(at)) for at, number in enumerate(numbers)]


# The report of `cycle`.


@record
class CycleReport(Head):
    """Gas pressure, torque, speed, loads, and what each balance factor costs."""

    command: Literal["cycle"] = "cycle"
    job_set: Sequence[str] | Absent = ABSENT
    input: JobEcho
    speed_rpm: Positive
    summary: Annotated[CycleSummary, INLINE]
    pendulum: PendulumFigures | None
    sweep: Sequence[SweepRow] | None
    films: FilmTable | None
    of_addons: Annotated[Mapping[str, Any], INLINE, Registered(cycle_section_types)] = field(
        default_factory=dict
    )
    warnings: Sequence[str]
