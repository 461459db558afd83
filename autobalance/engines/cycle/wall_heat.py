"""The closed part with heat through the walls (Woschni) or a γ that changes with temperature: solved."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from autobalance.engines.cycle.closed_part import (
    Chamber,
    Charge,
    Wiebe,
    burn_corners_rad,
    burn_edges_rad,
    edges_between,
    hermite,
)
from autobalance.types import Array
from autobalance.value_classes import dataclass

WIDEST_RAD = np.radians(0.25)


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
        edges, state = _table(chamber, charge, heat, ends_rad, walls)
        work, wall = float(state[2, -1]), float(state[3, -1])
        return cls(chamber, heat, *ends_rad, (edges, state[0], state[1]), work, wall)

    @property
    def corners_rad(self) -> tuple[float, ...]:
        """Edges of panels where the pressure changes quickly [rad]."""
        return burn_corners_rad(self.heat, self.from_rad, self.to_rad)

    def pressure_mpa(self, after_top_rad: Array, volume_mm3: Array) -> Array:
        """Return the pressure at angles inside, whose volumes are known [MPa]."""
        return hermite(after_top_rad, *self.table) / volume_mm3


@lru_cache(maxsize=32)  # the loads before and after balancing, and each check of them, are of the same gas
def _table(
    chamber: Chamber,
    charge: Charge,
    heat: Wiebe | None,
    ends_rad: tuple[float, float],
    walls: Woschni | None,
) -> tuple[Array, Array]:
    """Return the edges (n,) of steps, and the solution (4, n) there by ``_solved``; both read-only."""
    gas = GasEquation(chamber, charge, heat, ends_rad[0], walls)
    edges = (
        edges_between(*ends_rad, WIDEST_RAD, ())
        if heat is None
        else edges_between(*ends_rad, WIDEST_RAD, burn_edges_rad(heat, *ends_rad))
    )
    state = _solved(gas, edges)
    for each in (edges, state):
        each.setflags(write=False)
    return edges, state


# Cash and Karp's Runge–Kutta of order 5 (ACM Trans. Math. Softw. 16, 1990)
PLACES = (0.0, 0.2, 0.3, 0.6, 1.0, 0.875)
STEP = (37 / 378, 250 / 621, 125 / 594, 512 / 1771)
"""Weights of stages 1, 3, 4 and 6; those of the others are 0."""


def _solved(gas: GasEquation, edges_rad: Array) -> Array:
    """P V, its slope, work and wall heat (4, n) at the edges, by steps from edge to edge.

    All that depends on the angle alone is computed for all stages at once. Stages are written out: loops over
    their coefficients would take half of a cycle's time.
    """
    widths = np.diff(edges_rad)
    angles = edges_rad[:-1, None] + widths[:, None] * np.array(PLACES)
    rows = np.stack(gas.known(angles), axis=-1).tolist()
    last = np.stack(gas.known(edges_rad[-1:]), axis=-1).tolist()[0]
    held, work, lost = float(gas.first_state), 0.0, 0.0
    table = np.zeros((4, edges_rad.size))
    b1, b3, b4, b6 = STEP
    rates = gas.rates
    for place, (h, (at1, at2, at3, at4, at5, at6)) in enumerate(zip(widths.tolist(), rows, strict=True)):
        k1, w1, q1 = rates(at1, held)
        k2, _, _ = rates(at2, held + h * (k1 / 5))
        k3, w3, q3 = rates(at3, held + h * (3 / 40 * k1 + 9 / 40 * k2))
        k4, w4, q4 = rates(at4, held + h * (3 / 10 * k1 - 9 / 10 * k2 + 6 / 5 * k3))
        k5, _, _ = rates(at5, held + h * (-11 / 54 * k1 + 5 / 2 * k2 - 70 / 27 * k3 + 35 / 27 * k4))
        of_four = 1631 / 55296 * k1 + 175 / 512 * k2 + 575 / 13824 * k3 + 44275 / 110592 * k4
        k6, w6, q6 = rates(at6, held + h * (of_four + 253 / 4096 * k5))
        table[:, place] = held, k1, work, lost
        held += h * (b1 * k1 + b3 * k3 + b4 * k4 + b6 * k6)
        work += h * (b1 * w1 + b3 * w3 + b4 * w4 + b6 * w6)
        lost += h * (b1 * q1 + b3 * q3 + b4 * q4 + b6 * q6)
    table[:, -1] = held, rates(last, held)[0], work, lost
    return table


Known = Sequence[float]
"""An angle [rad] with its volume [mm³], the volume's slope [mm³/rad], the rate of heat [N·mm/rad], the
wall [m²] and the motored pressure [MPa]."""


class GasEquation:
    """The energy equation d(p V) = (γ − 1)(dQ − dQ_wall − p dV)."""

    def __init__(
        self, chamber: Chamber, charge: Charge, heat: Wiebe | None, from_rad: float, walls: Woschni | None
    ) -> None:
        self.chamber, self.charge, self.heat, self.walls = chamber, charge, heat, walls
        self.first_mm3 = float(chamber.volume_mm3(np.array(from_rad)))
        self.first_state = charge.pressure_mpa * self.first_mm3
        per_kpa = chamber.swept_mm3 * charge.temperature_k / (charge.pressure_mpa * 1e3 * self.first_mm3)
        self.by_burning = 3.24e-3 * per_kpa * 1e3
        self.by_piston = 0.0
        if walls is not None:
            stroke_m = chamber.slider_crank.stroke_mm * 1e-3
            self.by_piston = 2.28 * stroke_m * walls.speed_rad_s / float(np.pi)

    def known(self, angle_rad: Array) -> tuple[Array, ...]:
        """Return the columns of ``Known`` at angles of any shape."""
        volume, slope = self.chamber.volume_and_slope(angle_rad)
        burnt = np.zeros_like(angle_rad) if self.heat is None else self.heat.rate_n_mm(angle_rad)
        area_m2 = self.chamber.surface_mm2(volume) * 1e-6
        motored = self.charge.pressure_mpa * (self.first_mm3 / volume) ** self.charge.gamma
        return angle_rad, volume, slope, burnt, area_m2, motored

    def rates(self, known: Known, held_n_mm: float) -> tuple[float, float, float]:
        """Return the derivatives by the crank angle of p V, work and wall heat."""
        angle, volume, slope, burnt, area_m2, motored = known
        pressure = held_n_mm / volume
        charge = self.charge
        temperature = charge.temperature_k * held_n_mm / self.first_state
        gamma = charge.gamma + charge.gamma_per_k * (temperature - charge.temperature_k)
        if not (temperature > 0.0 and gamma > 1.0):
            raise ValueError(
                f"the gas comes to {temperature:.4g} K and gamma to {gamma:.4g} at"
                f" {np.degrees(angle):.4g}°; it must stay above 0 K, and gamma above 1"
            )
        lost = 0.0
        if self.walls is not None:
            gas_speed = self.by_piston
            if self.heat is not None and angle > self.heat.start_rad:
                gas_speed += self.by_burning * max(0.0, pressure - motored)
            h = self.walls.coefficient_w_m2_k(self.chamber.bore_mm, pressure, temperature, gas_speed)
            watts = h * area_m2 * (temperature - self.walls.wall_temperature_k)
            lost = watts / self.walls.speed_rad_s * 1e3
        return (gamma - 1.0) * (burnt - lost - pressure * slope), pressure * slope, lost
