"""Figures of a bearing's analysis in the report: friction, oil, film and orbit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from autobalance.declare import (
    MM,
    MM3_S,
    MPA,
    RPM,
    Degrees,
    Matrix2,
    NotNegative,
    Positive,
    record,
)

Limit = Literal["contact"] | None
FilmThickness = Annotated[NotNegative | None, MM]


@record
class BearingFriction:
    """Friction at one speed; None where a number does not apply.

    ``coefficient`` is the moment over the load times half the diameter.
    """

    schema_name: ClassVar[str] = "Friction"
    moment_N_m: float | None = None
    power_W: float | None = None
    coefficient: float | None = None
    mu: float | None = None
    mu_small_angle: float | None = None
    mu_equivalent: float | None = None
    small_angle_N_m: float | None = None


@record
class LoadMeans:
    """Means of a constant and a turning load."""

    mean_N: float
    cubic_mean_N: float
    equivalent_N: float
    f_m: float | None


@record
class Oil:
    """The oil as it runs."""

    viscosity_Pa_s: Positive | None = None
    kinematic_mm2_s: Positive | None = None
    temperature_C: float | None = None
    outlet_C: float | None = None


@record
class OilFilm:
    """A film in steady running; for Petroff's formula, what is known of one without Reynolds' equation."""

    eccentricity_ratio: NotNegative | None = None
    attitude_angle_rad: Degrees | None = None
    sommerfeld: float | None = None
    load_N: float | None = None
    least_film_m: FilmThickness = None
    greatest_pressure_pa: Annotated[float | None, MPA] = None
    side_flow_m3_s: Annotated[float | None, MM3_S] = None
    stiffness_N_m: Matrix2 | None = None
    damping_N_s_m: Matrix2 | None = None
    whirl_ratio: float | None = None
    critical_mass_kg: float | None = None


@record
class Plates:
    """Stiffness and damping of a squeeze film; None of other bearings."""

    stiffness_N_m: float | None = None
    damping_source_N_s_m: float | None = None
    damping_N_s_m: float | None = None


@record
class FilmOrbit:
    """The journal's orbit through a cycle; no numbers where the film breaks."""

    least_film_m: FilmThickness = None
    at_rad: Degrees | None = None
    greatest_eccentricity_ratio: NotNegative | None = None
    mean_friction_N_m: float | None = None
    turns_to_settle: int | None = None


@record
class BearingRow:
    """A bearing at one speed."""

    speed_rad_s: Annotated[NotNegative, RPM]
    moment_N_m: float | None
    power_W: float | None
    eccentricity_ratio: NotNegative | None
    least_film_m: FilmThickness
    stiffness_N_m: Matrix2 | None
    damping_N_s_m: Matrix2 | None
    limit: Limit


@record
class FeedPoint:
    """A recess, groove or hole: place, pressure above the ambient's, and flow into the film."""

    angle_rad: Degrees
    z_m: Annotated[float, MM]
    pressure_pa: Annotated[float, MPA]
    flow_m3_s: Annotated[float, MM3_S]


@record
class FedRow:
    """A bearing with feeds at one speed and place of its journal; nulls at contact."""

    speed_rad_s: Annotated[NotNegative, RPM]
    eccentricity_ratio: NotNegative | None
    attitude_angle_rad: Degrees | None
    load_N: float | None
    moment_N_m: float | None
    power_W: float | None
    supplied_m3_s: Annotated[float | None, MM3_S]
    pumping_W: float | None
    stiffness_N_m: Matrix2 | None
    damping_N_s_m: Matrix2 | None
    limit: Limit


@record
class FedBearingFigures:
    """Oil under pressure in a bearing, at its first speed; then by speed and by eccentricity.

    ``heat_W`` is the power of friction and pump, ``energy_error`` the share of it that shear, flow in the
    film and restrictors do not account for (null with the film cut off, "half").
    """

    schema_name: ClassVar[str] = "FedBearing"
    supplied_m3_s: Annotated[float | None, MM3_S]
    pumping_W: float | None
    heat_W: float | None
    energy_error: NotNegative | None
    supplies: Sequence[FeedPoint]
    by_speed: Sequence[FedRow]
    by_eccentricity: Sequence[FedRow]
