"""The ``[cycle]`` table of a job in MPa, mm, N, s and rad."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, Literal

import numpy as np

from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.cycle.cylinder import Strokes
from autobalance.engines.cycle.drive import Drive
from autobalance.engines.cycle.piston_friction import PistonFriction
from autobalance.engines.cycle.weight import Gravity
from autobalance.engines.cycle.windage import Air
from autobalance.job import Job
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2
from autobalance.value_classes import dataclass

# Friction of the main bearings by Coulomb, and of everything else as a mean pressure.


@dataclass(frozen=True)
class Friction:
    """Friction of main journals, pistons and auxiliaries.

    Attributes
    ----------
    main_mu : float
        Coefficient of friction of the dry main journals.
    chen_flynn : tuple of four float
        A, B, C, D of the friction mean pressure A + B p_max + C c_m + D c_m² in bar (rings, skirts,
        auxiliaries). The peak pressure p_max is in bar and the mean piston speed c_m in m/s.

    References
    ----------
    Chen and Flynn 1965, SAE 650733.
    """

    main_mu: float = 0.0
    chen_flynn: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def main_lever_mm(self, diameters_mm: Sequence[float]) -> Array:
        """Return the lever of each main's friction torque over its load, d/2 μ/√(1 + μ²) (m,) [mm].

        References
        ----------
        Hoem & Røsholm 2016, Eqs 4.9 and 4.10: the load attacks at the attitude angle atan μ.
        """
        share = self.main_mu / math.sqrt(1.0 + self.main_mu**2)
        return 0.5 * np.asarray(diameters_mm, dtype=np.float64) * share

    def mean_pressure_bar(self, peak_bar: float, piston_speed_m_s: float) -> float:
        """Return the friction mean pressure of one cylinder [bar].

        Examples
        --------
        >>> Friction(0.0, (0.4, 0.005, 0.09, 0.0009)).mean_pressure_bar(60.0, 10.0)
        1.69
        """
        constant, by_peak, by_speed, by_square = self.chen_flynn
        return constant + by_peak * peak_bar + by_speed * piston_speed_m_s + by_square * piston_speed_m_s**2


NO_FRICTION = Friction()


# A pendulum absorber on the crank: the order that it takes, and the mass that an order of torque needs.
#
# In a crank that turns evenly the mass moves in the field of the centrifugal force as a pendulum does under
# gravity, φ″ = −(R/L) sin φ by the crank angle. Its frequency is an order of the speed, at any speed.


Path = Literal["circular", "epicycloidal"]


@dataclass(frozen=True)
class Pendulum:
    """A mass on a path about a pivot in the crank.

    Attributes
    ----------
    order : float
        It is tuned to, for small swings.
    distance_mm : float
        R, from the crank axis to the pivot (the centre of curvature of the path) [mm].
    path : "circular" or "epicycloidal"
        On the second the order is the same however far it swings.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 3.1.1 (Borowski); Den Hartog 1956, *Mechanical Vibrations*, Sec. 5.9;
    Denman 1992, J. Sound Vib. 159, 251, for the path.

    Examples
    --------
    >>> Pendulum(2.0, 60.0).length_mm
    15.0
    """

    order: float
    distance_mm: float
    path: Path = "circular"

    def __post_init__(self) -> None:
        for name, value in (("order", self.order), ("distance_mm", self.distance_mm)):
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} of the pendulum is {value:g}; must be > 0")

    @property
    def length_mm(self) -> float:
        """L = R/n², from the pivot to the mass [mm]."""
        return self.distance_mm / self.order**2

    @property
    def widest_swing_rad(self) -> float:
        """Largest swing on the path: to its cusp, s = ρ/(n √(n² + 1)), or a quarter turn [rad]."""
        if self.path == "circular":
            return 0.5 * math.pi
        reach = (self.distance_mm + self.length_mm) / (self.order * math.sqrt(self.order**2 + 1.0))
        return reach / self.length_mm

    def order_at(self, swing_rad: float) -> float:
        """Return the order of a swing of ``swing_rad`` to each side (arc over L) about evenly turning pivot.

        Examples
        --------
        >>> round(Pendulum(2.0, 60.0).order_at(math.radians(60.0)), 4)
        1.8636
        >>> Pendulum(2.0, 60.0, "epicycloidal").order_at(math.radians(60.0))
        2.0
        """
        from scipy.special import ellipk

        if self.path == "epicycloidal":
            return self.order
        return self.order * 0.5 * math.pi / float(ellipk(math.sin(0.5 * swing_rad) ** 2))

    def torque_n_m(self, mass_g: float, swing_rad: float, speed_rad_s: float) -> float:
        """Return the torque m Ω² (R + L) R φ that it compares with its order at a small swing [N·m]."""
        arm = (self.distance_mm + self.length_mm) * self.distance_mm
        return mass_g * speed_rad_s**2 * arm * swing_rad * N_M_PER_G_MM2_S2

    def mass_g(self, torque_n_m: float, swing_rad: float, speed_rad_s: float) -> float:
        """Return the mass that takes a torque of its order at a swing [g]."""
        return torque_n_m / self.torque_n_m(1.0, swing_rad, speed_rad_s)

    def inertia_g_mm2(self, mass_g: float) -> float:
        """Return the mass's part of the crank's inertia, m (R + L)² [g·mm²]."""
        return mass_g * (self.distance_mm + self.length_mm) ** 2


Model = Literal["wiebe", "trace", "motored"]
Peg = Literal["none", "intake"]


@dataclass(frozen=True)
class CylinderGas:
    """Gas in one cylinder; pressures in MPa, heat in N·mm, angles after firing top dead centre."""

    bore_mm: float
    compression_ratio: float | None
    model: Model
    start_rad: float
    duration_rad: float
    wiebe_a: float
    wiebe_n: float
    heat_n_mm: float | None
    gamma: float
    gamma_per_k: float
    intake_mpa: float
    intake_k: float
    exhaust_mpa: float
    crankcase_mpa: float
    crankcase_mm3: float | None
    intake_closes_rad: float | None
    exhaust_opens_rad: float | None


@dataclass(frozen=True)
class TraceFile:
    """A measured pressure: its file as the job names it, and what is done to it."""

    file: str
    shift_rad: float
    peg: Peg
    smooth_rad: float


@dataclass(frozen=True)
class Absorber:
    """A pendulum, its largest swing, and the share of its order's torque that it is to take."""

    pendulum: Pendulum
    swing_rad: float
    reduction: float


@dataclass(frozen=True)
class OilFilms:
    """Oil films: viscosity [Pa·s], radial clearances and lengths [mm]; None: as long as the pins are wide."""

    viscosity_pa_s: float
    main_clearance_mm: float
    main_length_mm: float | None
    crankpin_clearance_mm: float | None
    crankpin_length_mm: float | None


@dataclass(frozen=True)
class MainHeat:
    """Heat paths of each main bearing: to the block and, with a supply, with oil that flows through.

    ``flow_m3_s`` None: the flow of its film.
    """

    conductance_W_K: float
    ambient_C: float
    oil: WaltherOil
    supply_C: float | None
    flow_m3_s: float | None
    heat_capacity_J_kg_K: float


@dataclass(frozen=True, eq=False)
class Cycle:
    """The ``[cycle]`` table of a job, checked; ``values`` are its keys with the defaults filled in."""

    strokes: Strokes
    default: CylinderGas
    by_cylinder: Mapping[int, CylinderGas]
    trace: TraceFile
    firing_order: tuple[int, ...] | None
    firing_rad: tuple[float, ...] | None
    flywheel_g_mm2: float
    fluctuation_wanted: float | None
    woschni_wall_k: float | None
    friction: Friction
    absorber: Absorber | None = None
    film: OilFilms | None = None
    gravity: Gravity | None = None
    drives: tuple[Drive, ...] = ()
    piston: PistonFriction | None = None
    heat: MainHeat | None = None
    windage: Air | None = None
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def measured(self) -> bool:
        """Whether a cylinder takes its pressure from a trace."""
        return any(gas.model == "trace" for gas in (self.default, *self.by_cylinder.values()))

    def of_cylinder(self, number: int) -> CylinderGas:
        """Return the gas of a cylinder, from 1."""
        return self.by_cylinder.get(number, self.default)


def table_of(job: Job) -> Cycle:
    """Return the ``[cycle]`` of a job that is known to have one."""
    cycle = job.table(Cycle)
    assert cycle is not None
    return cycle
