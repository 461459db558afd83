"""The pressure in one cylinder over its whole cycle, the work it does and where it peaks."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Literal

import numpy as np

from autobalance.engines.cycle.closed_part import (
    SAME_RAD,
    AdiabaticPart,
    Chamber,
    Charge,
    ClosedPart,
    Panels,
    Wiebe,
    edges_between,
)
from autobalance.engines.cycle.trace import PressureTrace
from autobalance.engines.cycle.wall_heat import SolvedPart, Woschni
from autobalance.running_gear.articulated import LinkCrank
from autobalance.types import Array
from autobalance.value_classes import dataclass

Strokes = Literal[2, 4]
WIDEST_RAD = math.radians(0.5)
GAUSS_POINTS = 3
AT_JUMP_RAD = 1e-5
"""So little before a jump is at it: throws of a crank from a file are by a millionth off their angles."""


def span_rad(strokes: Strokes) -> float:
    """Return the crank angle of a cycle [rad]."""
    return math.pi * strokes


@dataclass(frozen=True)
class GasExchange:
    """Pressures, angles and volumes of gas exchange, outside of the closed part.

    Attributes
    ----------
    strokes : 2 or 4
    intake_mpa, exhaust_mpa : float
        Pressures above the piston while gas is exchanged; two strokes have the first alone [MPa].
    crankcase_mpa : float
        Below the piston, at top dead centre [MPa].
    closes_rad, opens_rad : float or None
        Where the intake closes and the exhaust opens, after firing top dead centre; None: at the bottom dead
        centres beside it [rad].
    crankcase_mm3 : float or None
        Volume below the piston at top dead centre, whose gas the piston presses together (without loss, with
        the γ of the charge); None: so large that its pressure is constant [mm³].
    """

    strokes: Strokes
    intake_mpa: float
    exhaust_mpa: float
    crankcase_mpa: float
    closes_rad: float | None = None
    opens_rad: float | None = None
    crankcase_mm3: float | None = None

    def closed_ends_rad(self, chamber: Chamber) -> tuple[float, float]:
        """Return beginning and end of the closed part.

        Raises
        ------
        ValueError
            If it is longer than a cycle.
        """
        bottom = chamber.bottom_after_top_rad
        low = bottom - 2.0 * math.pi if self.closes_rad is None else self.closes_rad
        high = bottom if self.opens_rad is None else self.opens_rad
        if high - low > span_rad(self.strokes) + SAME_RAD:
            raise ValueError(
                f"the closed part from {math.degrees(low):g}° to {math.degrees(high):g}° is longer than a"
                f" cycle, {180 * self.strokes}°"
            )
        return low, high


@dataclass(frozen=True, eq=False)
class CylinderCycle:
    """One cylinder's gas over its cycle; angles count from its firing top dead centre.

    Attributes
    ----------
    chamber : Chamber
    exchange : GasExchange
    charge : Charge
    part : ClosedPart or None
        None where the pressure was measured.
    trace : PressureTrace or None
    heat_n_mm : float or None
        That fuel brings, None where it is not known [N·mm].
    """

    chamber: Chamber
    exchange: GasExchange
    charge: Charge
    part: ClosedPart | None = None
    trace: PressureTrace | None = None
    heat_n_mm: float | None = None

    @classmethod
    def modelled(
        cls,
        chamber: Chamber,
        exchange: GasExchange,
        charge: Charge,
        heat: Wiebe | None,
        walls: Woschni | None,
    ) -> CylinderCycle:
        """Return the cycle of a single zone; without ``heat`` it is motored.

        Raises
        ------
        ValueError
            If the burn starts outside the closed part.
        """
        low, high = ends = exchange.closed_ends_rad(chamber)
        if heat is not None and not low <= heat.start_rad < high:
            raise ValueError(
                f"heat release starts at {math.degrees(heat.start_rad):g}°; must be while the valves are"
                f" shut, {math.degrees(low):g}° to {math.degrees(high):g}°"
            )
        part: ClosedPart
        if walls is None and charge.gamma_per_k == 0.0:
            part = AdiabaticPart.of(chamber, charge, heat, low, high)
        else:
            part = SolvedPart.of(chamber, charge, heat, ends, walls)
        return cls(chamber, exchange, charge, part, None, None if heat is None else heat.heat_n_mm)

    @classmethod
    def measured(
        cls, chamber: Chamber, exchange: GasExchange, charge: Charge, trace: PressureTrace
    ) -> CylinderCycle:
        """Return the cycle of a measured pressure."""
        exchange.closed_ends_rad(chamber)
        return cls(chamber, exchange, charge, None, trace)

    @cached_property
    def known_rad(self) -> tuple[float, float]:
        """Angles between which the pressure is that of the closed part or the trace."""
        if self.part is not None:
            return self.part.from_rad, self.part.to_rad
        assert self.trace is not None
        first = float(self.trace.angle_rad[0])
        return first, first + self.span_rad if self.trace.whole else float(self.trace.angle_rad[-1])

    @property
    def span_rad(self) -> float:
        """Crank angle of the cycle [rad]."""
        return span_rad(self.exchange.strokes)

    def wrapped(self, after_firing_rad: Array) -> Array:
        """Return angles brought into the cycle that begins with the known part; a hair before it is in it."""
        low = self.known_rad[0]
        local = np.mod(np.asarray(after_firing_rad, dtype=np.float64) - low, self.span_rad)
        result: Array = low + np.where(local > self.span_rad - AT_JUMP_RAD, 0.0, local)
        return result

    def pressure_mpa(self, after_firing_rad: Array, volume_mm3: Array | None = None) -> Array:
        """Return the pressure at any angles; at a jump the one after it [MPa].

        Parameters
        ----------
        after_firing_rad : (...) float
            Crank angle after firing top dead centre [rad].
        volume_mm3 : (...) float, optional
            Volume at those angles, where it is known already [mm³].
        """
        angle = self.wrapped(after_firing_rad)
        volume = self.chamber.volume_mm3(angle) if volume_mm3 is None else volume_mm3
        high = self.known_rad[1]
        inside = angle < high - AT_JUMP_RAD
        pressure = np.full(angle.shape, self.exchange.intake_mpa)
        if self.exchange.strokes == 4:
            pressure[~inside & (angle < 2.0 * math.pi - AT_JUMP_RAD)] = self.exchange.exhaust_mpa
        if self.part is not None:
            pressure[inside] = self.part.pressure_mpa(angle[inside], volume[inside])
        elif self.trace is not None:
            pressure[inside] = self.trace.at(angle[inside])
        return pressure

    def below_mpa(self, volume_mm3: Array) -> Array:
        """Return the pressure below the piston where the volume above it is known [MPa]."""
        case = self.exchange.crankcase_mm3
        if case is None:
            return np.full(volume_mm3.shape, self.exchange.crankcase_mpa)
        left = case - (volume_mm3 - self.chamber.clearance_mm3)
        result: Array = self.exchange.crankcase_mpa * (case / left) ** self.charge.gamma
        return result

    @cached_property
    def jumps_rad(self) -> tuple[float, ...]:
        """Jumps and corners of the pressure's curve over a cycle [rad]."""
        low, high = self.known_rad
        corners = [low, high, *(self.part.corners_rad if self.part is not None else ())]
        if self.exchange.strokes == 4:
            corners.append(2.0 * math.pi)
        return tuple(corners)

    def panels(self, low_rad: float, high_rad: float) -> Panels:
        """Return Gauss points between two angles of the cycle, none across a corner of the pressure."""
        corners = list(self.jumps_rad)
        if self.trace is not None:
            corners += list(self.wrapped(self.trace.angle_rad))
        turned = [corner + turn * self.span_rad for corner in corners for turn in (-1.0, 0.0, 1.0)]
        return Panels.between(edges_between(low_rad, high_rad, WIDEST_RAD, turned), GAUSS_POINTS)

    def integral(self, low_rad: float, high_rad: float, pressure: Callable[[Array], Array]) -> float:
        """Return ∫ p dV of any pressure over angles between two angles [N·mm]."""
        panels = self.panels(low_rad, high_rad)
        _, slope = self.chamber.volume_and_slope(panels.nodes_rad)
        return float(np.sum(pressure(panels.nodes_rad) * slope * panels.weights_rad))

    @cached_property
    def closed_work_n_mm(self) -> float:
        """∫ p dV from where the intake closes to where the exhaust opens [N·mm]."""
        if self.part is not None:
            return self.part.work_n_mm
        low, high = self.exchange.closed_ends_rad(self.chamber)
        return self.integral(low, high, self.pressure_mpa)

    @cached_property
    def closed_work_by_cycle_n_mm(self) -> tuple[float, ...] | None:
        """The same of each cycle of a measured trace [N·mm]; None where the pressure is computed."""
        if self.trace is None:
            return None
        low, high = self.exchange.closed_ends_rad(self.chamber)
        return tuple(self.integral(low, high, cycle.at) for cycle in self.trace.each)

    @cached_property
    def pumping_work_n_mm(self) -> float:
        """∫ p dV over the rest of the cycle, negative where gas exchange costs work [N·mm]."""
        low, high = self.exchange.closed_ends_rad(self.chamber)
        if self.part is None:
            return self.integral(high, low + self.span_rad, self.pressure_mpa)
        at = np.array([high, 2.0 * math.pi, low + self.span_rad])
        volume = self.chamber.volume_mm3(at)
        exchange = self.exchange
        if exchange.strokes == 2:
            return float(exchange.intake_mpa * (volume[2] - volume[0]))
        out = exchange.exhaust_mpa * (volume[1] - volume[0])
        return float(out + exchange.intake_mpa * (volume[2] - volume[1]))

    @property
    def work_n_mm(self) -> float:
        """∮ p dV over the whole cycle [N·mm]."""
        return self.closed_work_n_mm + self.pumping_work_n_mm

    @cached_property
    def torque_work_n_mm(self) -> float:
        """∮ of the torque of the gas about the crank axis, from its forces, not from p dV [N·mm]."""
        low = self.known_rad[0]
        panels = self.panels(low, low + self.span_rad)
        angle = panels.nodes_rad
        volume = self.chamber.volume_mm3(angle)
        force = (self.pressure_mpa(angle, volume) - self.below_mpa(volume)) * self.chamber.piston_area_mm2
        crank = self.chamber.slider_crank
        if isinstance(crank, LinkCrank):
            return float(
                np.sum(force * crank.lever_mm(angle + crank.dead_centres_rad[0]) * panels.weights_rad)
            )
        motion = crank.motion(angle + self.chamber.top_rad)
        # The rod's force on the crankpin is (−G, −G tan β); its moment about the axis is r × F.
        along, across = -force, -force * motion.rod_sine / motion.rod_cosine
        radius = crank.crank_radius_mm
        torque = radius * (motion.crank_cosine * across - motion.crank_sine * along)
        return float(np.sum(torque * panels.weights_rad))

    def mean_pressure_mpa(self) -> float:
        """Work over swept volume: the indicated mean effective pressure [MPa]."""
        return self.work_n_mm / self.chamber.swept_mm3

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Largest pressure [MPa] and its angle after firing top dead centre [rad]."""
        if self.trace is not None:
            pressure = self.pressure_mpa(self.trace.angle_rad)
            place = int(np.argmax(pressure))
            angle = float(self.trace.angle_rad[place])
            half = 0.5 * self.span_rad
            return float(pressure[place]), (angle + half) % self.span_rad - half
        return self._greatest(self.pressure_mpa)

    @cached_property
    def peak_temperature_k(self) -> float | None:
        """Largest temperature of the charge between intake and exhaust; None without its volume [K]."""
        if self.chamber.compression_ratio is None:
            return None
        return self._greatest(self.temperature_k)[0]

    def temperature_k(self, after_firing_rad: Array) -> Array:
        """Return the temperature T₀ p V/(p₀ V₀) of the closed charge [K]."""
        first = np.array(self.exchange.closed_ends_rad(self.chamber)[0])
        start = float(self.pressure_mpa(first[None])[0] * self.chamber.volume_mm3(first))
        volume = self.chamber.volume_mm3(after_firing_rad)
        result: Array = (
            self.charge.temperature_k * self.pressure_mpa(after_firing_rad, volume) * volume / start
        )
        return result

    def _greatest(self, function: Callable[[Array], Array]) -> tuple[float, float]:
        """Largest value of a function in the closed part, and its angle [rad], between points too."""
        from scipy.optimize import minimize_scalar

        low, high = self.exchange.closed_ends_rad(self.chamber)
        angle = self.panels(low, high).nodes_rad.ravel()
        values = function(angle)
        place = int(np.argmax(values))
        ends = angle[max(place - 1, 0)], angle[min(place + 1, angle.size - 1)]
        optimum = minimize_scalar(
            lambda at: -float(function(np.array([at]))[0]),
            bounds=ends,
            method="bounded",
            options={"xatol": 1e-9},
        )
        return max((-float(optimum.fun), float(optimum.x)), (float(values[place]), float(angle[place])))

    def scatter_mpa(self) -> float | None:
        """Return the standard deviation of the mean effective pressure over a trace's cycles [MPa]."""
        if self.trace is None or len(self.trace.pressure_mpa) < 2:
            return None
        shares = self._work_shares_mm3(self.trace)
        return float(np.std(self.trace.pressure_mpa @ shares) / self.chamber.swept_mm3)

    def _work_shares_mm3(self, trace: PressureTrace) -> Array:
        """Return the weight of each row's pressure in ∮ p dV, linear between rows (n,) [mm³]."""
        edges = np.append(trace.angle_rad, trace.angle_rad[0] + trace.span_rad)
        panels = Panels.between(edges, 5)
        _, slope = self.chamber.volume_and_slope(panels.nodes_rad)
        piece = slope * panels.weights_rad
        later = (panels.nodes_rad - edges[:-1, None]) / np.diff(edges)[:, None]
        shares: Array = (piece * (1.0 - later)).sum(axis=1) + np.roll((piece * later).sum(axis=1), 1)
        return shares
