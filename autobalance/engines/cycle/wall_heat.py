"""The closed part with heat through the walls (Woschni) or a γ that changes with temperature: solved."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from autobalance.engines.cycle.chamber import Chamber
from autobalance.engines.cycle.closed_part import Charge, burn_corners_rad, burn_edges_rad
from autobalance.engines.cycle.heat_release import Wiebe
from autobalance.engines.cycle.quadrature import edges_between, hermite
from autobalance.types import Array

WIDEST_RAD = np.radians(0.25)
RELATIVE_TOLERANCE = 1e-10
"""Error of the solved pressure, relative."""


@dataclass(frozen=True)
class Woschni:
    """Heat transfer to walls of one temperature.

    h = 3.26 B^−0.2 p^0.8 T^−0.55 w^0.8 in W/(m² K), with B in m, p in kPa and T in K. The gas speed is w =
    2.28 c_m + C₂ V_s T₀/(p₀ V₀) (p − p_motored) in m/s; C₂ is 0.00324 once fuel burns, before it 0.

    Attributes
    ----------
    wall_temperature_k : float
    speed_rad_s : float
        Of the crank: heat takes time [rad/s].

    References
    ----------
    Heywood 1988, Eqs 12.18 and 12.19; Woschni 1967, SAE 670931.
    """

    wall_temperature_k: float
    speed_rad_s: float

    def coefficient_w_m2_k(
        self, bore_mm: float, pressure_mpa: float, temperature_k: float, gas_speed_m_s: float
    ) -> float:
        """Return h of a gas speed [W/(m² K)].

        Examples
        --------
        >>> round(Woschni(450.0, 300.0).coefficient_w_m2_k(100.0, 5.0, 2000.0, 20.0), 1)
        790.0
        """
        gas = (pressure_mpa * 1e3) ** 0.8 * temperature_k**-0.55
        result: float = 3.26 * (bore_mm * 1e-3) ** -0.2 * gas * gas_speed_m_s**0.8
        return result


@dataclass(frozen=True, eq=False)
class SolvedPart:
    """The closed part as its energy equation was solved: p V at a table of angles, with its slope."""

    chamber: Chamber
    heat: Wiebe | None
    from_rad: float
    to_rad: float
    table: tuple[Array, Array, Array]
    work_n_mm: float
    wall_heat_n_mm: float

    @classmethod
    def of(
        cls,
        chamber: Chamber,
        charge: Charge,
        heat: Wiebe | None,
        ends_rad: tuple[float, float],
        walls: Woschni | None,
    ) -> SolvedPart:
        """Return the part between two angles after firing top dead centre [rad]."""
        gas = GasEquation(chamber, charge, heat, ends_rad[0], walls)
        edges = (
            edges_between(*ends_rad, WIDEST_RAD, ())
            if heat is None
            else edges_between(*ends_rad, WIDEST_RAD, burn_edges_rad(heat, *ends_rad))
        )
        state = _solved(gas, edges)
        slope = np.array([gas.rates(angle, each)[0] for angle, each in zip(edges, state.T, strict=True)])
        work, wall = float(state[1, -1]), float(state[2, -1])
        return cls(chamber, heat, *ends_rad, (edges, state[0], slope), work, wall)

    @property
    def corners_rad(self) -> tuple[float, ...]:
        """Edges of panels where the pressure changes quickly [rad]."""
        return burn_corners_rad(self.heat, self.from_rad, self.to_rad)

    def pressure_mpa(self, after_top_rad: Array, volume_mm3: Array) -> Array:
        """Return the pressure at angles inside, whose volumes are known [MPa]."""
        return hermite(after_top_rad, *self.table) / volume_mm3


def _solved(gas: GasEquation, edges_rad: Array) -> Array:
    """P V, work and wall heat (3, n) at the edges; in two runs where a burn starts between."""
    from scipy.integrate import solve_ivp

    state = np.zeros((3, edges_rad.size))
    state[:, 0] = gas.first_state
    burn = None if gas.heat is None else int(np.searchsorted(edges_rad, gas.heat.start_rad))
    stops = sorted({0, edges_rad.size - 1, *([] if burn is None else [min(burn, edges_rad.size - 1)])})
    for low, high in itertools.pairwise(stops):
        run = solve_ivp(
            gas.rates,
            (edges_rad[low], edges_rad[high]),
            state[:, low],
            method="DOP853",
            t_eval=edges_rad[low : high + 1],
            rtol=RELATIVE_TOLERANCE,
            atol=RELATIVE_TOLERANCE * gas.first_state[0],
        )
        state[:, low : high + 1] = run.y
    return state


class GasEquation:
    """The energy equation d(p V) = (γ − 1)(dQ − dQ_wall − p dV)."""

    def __init__(
        self, chamber: Chamber, charge: Charge, heat: Wiebe | None, from_rad: float, walls: Woschni | None
    ) -> None:
        self.chamber, self.charge, self.heat, self.walls = chamber, charge, heat, walls
        self.first_mm3 = float(chamber.volume_mm3(np.array(from_rad)))
        self.first_state = np.array([charge.pressure_mpa * self.first_mm3, 0.0, 0.0])

    def rates(self, angle_rad: float, state: Array) -> Array:
        """Return the derivatives by the crank angle of p V, work and wall heat."""
        volume, slope = (float(each) for each in self.chamber.volume_and_slope(np.array(angle_rad)))
        pressure = float(state[0]) / volume
        temperature = self.charge.temperature_k * float(state[0]) / float(self.first_state[0])
        gamma = self.charge.gamma + self.charge.gamma_per_k * (temperature - self.charge.temperature_k)
        if not (temperature > 0.0 and gamma > 1.0):
            raise ValueError(
                f"the gas comes to {temperature:.4g} K and gamma to {gamma:.4g} at"
                f" {np.degrees(angle_rad):.4g}°; it must stay above 0 K, and gamma above 1"
            )
        burnt = 0.0 if self.heat is None else float(self.heat.rate_n_mm(np.array(angle_rad)))
        lost = self._lost_n_mm(angle_rad, volume, pressure, temperature)
        return np.array([(gamma - 1.0) * (burnt - lost - pressure * slope), pressure * slope, lost])

    def _lost_n_mm(self, angle_rad: float, volume: float, pressure: float, temperature: float) -> float:
        """Heat to the walls over the crank angle [N·mm/rad]."""
        if self.walls is None:
            return 0.0
        chamber, charge = self.chamber, self.charge
        piston_m_s = chamber.slider_crank.stroke_mm * 1e-3 * self.walls.speed_rad_s / np.pi
        gas_speed = 2.28 * piston_m_s
        if self.heat is not None and angle_rad > self.heat.start_rad:
            motored = charge.pressure_mpa * (self.first_mm3 / volume) ** charge.gamma
            per_kpa = chamber.swept_mm3 * charge.temperature_k / (charge.pressure_mpa * 1e3 * self.first_mm3)
            gas_speed += 3.24e-3 * per_kpa * max(0.0, pressure - motored) * 1e3
        h = self.walls.coefficient_w_m2_k(chamber.bore_mm, pressure, temperature, gas_speed)
        area_m2 = float(chamber.surface_mm2(np.array(volume))) * 1e-6
        watts = h * area_m2 * (temperature - self.walls.wall_temperature_k)
        return float(watts / self.walls.speed_rad_s * 1e3)
