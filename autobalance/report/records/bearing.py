"""The report of `bearing`: every key of the interface, None where one does not apply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from autobalance.bearings.analysis import Analysis, Friction, LoadMeans, PetroffFilm, PlateFilm, State
from autobalance.bearings.film import Film
from autobalance.bearings.rolling import FourParts, PalmgrenParts
from autobalance.declare import INLINE, Degrees, Matrix2, NotNegative, Positive, record
from autobalance.report.records.head import Head

MM_PER_M = 1e3
MM3_PER_M3 = 1e9
MPA_PER_PA = 1e-6
Limit = Literal["contact"] | None


@record
class BearingRow:
    """A bearing at one speed."""

    speed_rpm: NotNegative
    moment_N_m: float | None
    power_W: float | None
    eccentricity_ratio: NotNegative | None
    least_film_mm: NotNegative | None
    stiffness_N_m: Matrix2 | None
    damping_N_s_m: Matrix2 | None
    limit: Limit

    @classmethod
    def of(cls, speed_rpm: float, state: State) -> Self:
        """Return a state at a speed as it was given."""
        film = state.film
        return cls(
            speed_rpm=speed_rpm,
            moment_N_m=state.friction.moment_N_m,
            power_W=state.friction.power_W,
            eccentricity_ratio=None if film is None else film.eccentricity_ratio,
            least_film_mm=None if film is None else MM_PER_M * film.least_film_m,
            stiffness_N_m=None if film is None else film.stiffness_N_m,
            damping_N_s_m=None if film is None else film.damping_N_s_m,
            limit="contact" if state.contact else None,
        )


@record
class Oil:
    """The oil as it runs."""

    viscosity_Pa_s: Positive | None
    kinematic_mm2_s: Positive | None
    temperature_C: float | None
    outlet_C: float | None

    @classmethod
    def of(cls, state: State) -> Self:
        oil = state.lubricant
        return cls(
            viscosity_Pa_s=None if oil is None else oil.viscosity_Pa_s,
            kinematic_mm2_s=None if oil is None else oil.kinematic_mm2_s,
            temperature_C=None if oil is None else oil.celsius,
            outlet_C=state.outlet_C,
        )


@record
class OilFilm:
    """A film in steady running."""

    eccentricity_ratio: NotNegative | None = None
    attitude_angle_rad: Degrees | None = None
    sommerfeld: float | None = None
    load_N: float | None = None
    least_film_mm: NotNegative | None = None
    greatest_pressure_MPa: float | None = None
    side_flow_mm3_s: float | None = None
    stiffness_N_m: Matrix2 | None = None
    damping_N_s_m: Matrix2 | None = None
    whirl_ratio: float | None = None
    critical_mass_kg: float | None = None

    @classmethod
    def of(cls, film: Film | PetroffFilm | None) -> Self:
        """Return a film, or what Petroff's formula gives of one."""
        if film is None:
            return cls()
        known = cls(
            eccentricity_ratio=film.eccentricity_ratio,
            attitude_angle_rad=film.attitude_rad,
            sommerfeld=film.sommerfeld,
            load_N=film.load_N,
            least_film_mm=MM_PER_M * film.least_film_m,
        )
        if isinstance(film, PetroffFilm):
            return known
        return replace(
            known,
            greatest_pressure_MPa=MPA_PER_PA * film.greatest_pressure_Pa,
            side_flow_mm3_s=MM3_PER_M3 * film.side_flow_m3_s,
            stiffness_N_m=film.stiffness_N_m,
            damping_N_s_m=film.damping_N_s_m,
            whirl_ratio=film.whirl.whirl_ratio,
            critical_mass_kg=film.whirl.critical_mass_kg,
        )


@record
class FilmOrbit:
    """The journal's orbit through a cycle; no numbers where the film breaks."""

    least_film_mm: NotNegative | None = None
    at_rad: Degrees | None = None
    greatest_eccentricity_ratio: NotNegative | None = None
    mean_friction_N_m: float | None = None
    turns_to_settle: int | None = None

    @classmethod
    def of(cls, analysis: Analysis) -> Self | None:
        """Return the orbit of an analysis; None where no load history is given."""
        orbit = analysis.orbit
        if orbit is None:
            return None
        if analysis.orbit_breaks:
            return cls()
        return cls(
            least_film_mm=MM_PER_M * float(orbit.least_film_m[0]),
            at_rad=float(orbit.least_at_rad[0]),
            greatest_eccentricity_ratio=float(orbit.ratio.max()),
            mean_friction_N_m=float(orbit.mean_moment_N_m[0]),
            turns_to_settle=int(orbit.turns_to_settle[0]) or None,
        )


@record
class Plates:
    """Stiffness and damping of a squeeze film; None of other bearings."""

    stiffness_N_m: float | None = None
    damping_source_N_s_m: float | None = None
    damping_N_s_m: float | None = None

    @classmethod
    def of(cls, film: PlateFilm | None) -> Self:
        return cls() if film is None else cls(**vars(film))


@record
class BearingReport(Head):
    """Friction, film and orbit of a bearing."""

    command: Literal["bearing"] = "bearing"
    input: Mapping[str, Any]
    kind: Literal["dry", "hydrodynamic", "rolling", "squeeze_film"]
    friction: Friction
    rows: Sequence[BearingRow]
    oil: Oil
    load: LoadMeans | None
    attitude_angle_rad: Degrees | None
    film: OilFilm | None
    petroff_N_m: float | None
    orbit: FilmOrbit | None
    limit: Limit
    parts: PalmgrenParts | FourParts | None
    plates: Annotated[Plates, INLINE]

    @classmethod
    def of(
        cls, kind: Any, described: Mapping[str, Any], speeds_rpm: Sequence[float], analysis: Analysis
    ) -> Self:
        """Return the report of an analysis."""
        first = analysis.first
        oiled = kind == "hydrodynamic"
        return cls(
            input=described,
            kind=kind,
            friction=first.friction,
            rows=[BearingRow.of(rpm, state) for rpm, state in zip(speeds_rpm, analysis.states, strict=True)],
            oil=Oil.of(first),
            load=first.load,
            attitude_angle_rad=first.attitude_rad,
            film=OilFilm.of(first.petroff_film or first.film) if oiled else None,
            petroff_N_m=first.petroff_N_m,
            orbit=FilmOrbit.of(analysis),
            limit="contact" if first.contact or analysis.orbit_breaks else None,
            parts=first.parts,
            plates=Plates.of(first.plates),
        )
