"""A rotor with friction under PI speed control: ramp, hold, torque limit, anti-windup, delay. SI units.

Classical Runge-Kutta steps inside smooth stretches; where the torque reaches its limit, the integral stops,
or the rotor starts or stops, the step ends. A torque that would flutter at its limit slides along it.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from autobalance.declare import Degrees, NotNegative, derived
from autobalance.types import Array
from autobalance.value_classes import dataclass

LONGEST_STEP_S = 1e-3
STEP_PER_TIME_CONSTANT = 0.1
SHORTEST_DELAY_S = 5e-5
"""Delay below which the torque is extrapolated by its slope, rather than steps made shorter."""
MOST_STEPS = 200_000
"""Largest number of steps of a run; 30 s need 5500 millisecond steps, of some 30 µs each."""
BISECTIONS = 48
AT_LIMIT = 1e-9
"""Largest relative distance of a torque at its limit from the limit."""
STANDING_RAD_S = 1e-12


@dataclass(frozen=True)
class SpeedControl:
    """T = kp e + ki ∫e dt with the speed error e, |T| at most the limit, late by the delay.

    The integral is held while the torque is cut and has the sign of e.
    """

    kp_N_m_s: float
    ki_N_m: float
    torque_limit_N_m: float
    delay_s: float = 0.0


@dataclass(frozen=True)
class LoopMargin:
    """Margin to instability of the loop (kp + ki/s) e^(−s delay)/(J s)."""

    schema_name: ClassVar[str] = "speed_loop"

    phase_margin_rad: Degrees
    crossover_rad_s: NotNegative

    @derived
    def stable(self) -> bool:
        """Whether the closed loop is stable: its gain falls monotonically, so the phase margin decides."""
        return self.phase_margin_rad > 0.0


def loop_margin(control: SpeedControl, inertia_kg_m2: float) -> LoopMargin:
    """Return the crossover ω where |L| = 1, and the phase margin atan(kp ω/ki) − ω delay.

    |L|² = (kp² ω² + ki²)/(J² ω⁴) = 1 is a quadratic in ω².

    Examples
    --------
    >>> round(math.degrees(loop_margin(SpeedControl(0.05, 0.5, 5.0), 0.002847335).phase_margin_rad), 2)
    63.08
    """
    kp, ki, J = control.kp_N_m_s, control.ki_N_m, inertia_kg_m2
    crossover = math.sqrt((kp**2 + math.sqrt(kp**4 + 4.0 * J**2 * ki**2)) / 2.0) / J
    lead = math.atan2(kp * crossover, ki)
    return LoopMargin(lead - crossover * control.delay_s, crossover)


@dataclass(frozen=True, eq=False)
class SpeedTrace:
    """A run from rest, all (n,): speeds [rad/s], torque on the rotor, friction against it, ∫T dt [N·m·s]."""

    time_s: Array
    speed: Array
    wanted: Array
    torque_N_m: Array
    friction_N_m: Array
    impulse_N_m_s: Array

    def mean_torque_N_m(self, start_s: float, end_s: float) -> float:
        """Return the mean torque between two ends of steps."""
        first, last = np.interp([start_s, end_s], self.time_s, self.impulse_N_m_s)
        return float((last - first) / (end_s - start_s))


def ramp_and_hold(
    inertia_kg_m2: float,
    friction_N_m: Callable[[float], float],
    control: SpeedControl,
    speed_rad_s: float,
    ramp_s: float,
    hold_s: float,
) -> SpeedTrace:
    """Return a run of J Ω̇ = T − T_f from rest: a ramp up to a speed, then a hold.

    Parameters
    ----------
    inertia_kg_m2 : float
    friction_N_m : callable
        Friction moment against the motion by |Ω| [rad/s]; at rest up to its value at 0.
    control : SpeedControl
    speed_rad_s : float
        Set speed at the end of the ramp.
    ramp_s, hold_s : float

    Returns
    -------
    Trace
        Its steps end at half and end of the ramp and of the hold.

    Raises
    ------
    ValueError
        If the control is so fast that the run would take more than ``MOST_STEPS`` steps.
    """
    run = _SpeedRun(inertia_kg_m2, friction_N_m, control, speed_rad_s / ramp_s, ramp_s)
    if not (ramp_s + hold_s) / run.longest <= MOST_STEPS:
        raise ValueError(
            f"the control is so fast that {ramp_s + hold_s:g} s take {(ramp_s + hold_s) / run.longest:.2g} "
            f"steps; expected {MOST_STEPS} at most: lower its gains, raise the inertia, or run a shorter time"
        )
    for end in (0.5 * ramp_s, ramp_s, ramp_s + 0.5 * hold_s, ramp_s + hold_s):
        run.until(end)
    return run.trace()


State = tuple[float, float, float]
"""Speed, integral of e, integral of the torque."""


class _SpeedRun:
    """State, mode and history of one run."""

    def __init__(
        self,
        inertia: float,
        friction: Callable[[float], float],
        control: SpeedControl,
        slope: float,
        ramp_s: float,
    ) -> None:
        self.J, self.friction, self.control = inertia, friction, control
        self.slope, self.ramp_s = slope, ramp_s
        self.kp, self.ki, self.limit = control.kp_N_m_s, control.ki_N_m, control.torque_limit_N_m
        rate = max(self.kp / inertia, math.sqrt(self.ki / inertia))
        self.longest = min(LONGEST_STEP_S, STEP_PER_TIME_CONSTANT / rate)
        if control.delay_s > 0.0:
            self.longest = min(self.longest, max(control.delay_s, SHORTEST_DELAY_S))
        self.at_rest = friction(0.0)
        self.t, self.y = 0.0, (0.0, 0.0, 0.0)
        self.rising = True
        self.mode, self.side, self.motion = "linear", 1.0, 1.0
        self.rows: list[tuple[float, float, float, float, float, float]] = []
        self.commands: list[tuple[float, float, float]] = []
        self._remember()
        self._choose()
        self._record()

    # --- the model ------------------------------------------------------------------------------------------

    def wanted(self, t: float) -> float:
        return self.slope * min(t, self.ramp_s)

    def error(self, t: float, y: State) -> float:
        return self.wanted(t) - y[0]

    def command(self, t: float, y: State) -> float:
        """Return the torque of the control law, before the limit."""
        return self.kp * self.error(t, y) + self.ki * y[1]

    def cut(self, t: float, y: State) -> float:
        """Return the torque of the control, within its limit."""
        if self.mode == "linear":
            return self.command(t, y)
        return self.side * self.limit

    def torque(self, t: float, y: State) -> float:
        """Return the torque on the rotor: that of the control one delay earlier."""
        if self.control.delay_s == 0.0:
            return self.cut(t, y)
        return self._late(t - self.control.delay_s)

    def acceleration(self, t: float, y: State) -> float:
        if self.motion == 0.0:
            return 0.0
        return (self.torque(t, y) - self.motion * self.friction(abs(y[0]))) / self.J

    def error_slope(self, t: float, y: State) -> float:
        return (self.slope if self.rising else 0.0) - self.acceleration(t, y)

    def rates(self, t: float, y: State) -> State:
        faster = self.acceleration(t, y)
        return faster, self._integral_slope(t, y, faster), self.torque(t, y)

    def _integral_slope(self, t: float, y: State, faster: float) -> float:
        if self.mode == "frozen":
            return 0.0
        if self.mode == "sliding":
            return -self.kp / self.ki * ((self.slope if self.rising else 0.0) - faster)
        return self.error(t, y)

    def _late(self, t: float) -> float:
        """Return the control's torque at an earlier time: a cubic between steps, 0 before the start."""
        if t <= 0.0:
            return 0.0
        place = bisect_right(self.commands, t, key=lambda row: row[0])
        t0, T0, d0 = self.commands[place - 1]
        if place == len(self.commands):
            return T0 + d0 * (t - t0)
        t1, T1, d1 = self.commands[place]
        h = t1 - t0
        s = (t - t0) / h
        jump, r = T1 - T0, 1.0 - s
        curve = T0 + s * s * (3.0 - 2.0 * s) * jump + s * r * h * (r * d0 - s * d1)
        return max(-self.limit, min(self.limit, curve))

    # --- modes ----------------------------------------------------------------------------------------------

    def _choose(self) -> None:
        """Choose the mode at a point: moving or standing, the torque free, cut or sliding along its limit."""
        t, y = self.t, self.y
        before = self.mode
        self.mode = "linear"  # for the torque on the rotor without a delay
        torque = self.command(t, y)
        side = 1.0 if torque >= 0.0 else -1.0
        over = side * torque - self.limit
        on_limit = abs(over) <= AT_LIMIT * self.limit
        if on_limit or over > 0.0:
            self.mode, self.side = before, side
            if self.mode == "linear":
                self.mode = "frozen"
        self._choose_motion(t, y)
        if not (on_limit or over > 0.0):
            return
        e = self.error(t, y)
        rising_frozen = side * self.kp * self.error_slope(t, y)
        rising_free = rising_frozen + side * self.ki * e
        if on_limit and rising_free <= 0.0:
            self.mode = "linear"
        elif side * e <= 0.0:
            self.mode = "running"
        elif on_limit and rising_frozen < 0.0:
            self.mode = "sliding"
        else:
            self.mode = "frozen"

    def _choose_motion(self, t: float, y: State) -> None:
        torque = self.torque(t, y)
        if abs(y[0]) > STANDING_RAD_S:
            self.motion = 1.0 if y[0] > 0.0 else -1.0
        elif abs(torque) <= self.at_rest and self.at_rest > 0.0:
            self.motion = 0.0
        else:
            self.motion = 1.0 if torque >= 0.0 else -1.0

    def _leaves(self, t: float, y: State) -> bool:
        """Return whether a point is outside the present mode."""
        if self.motion == 0.0:
            if abs(self.torque(t, y)) > self.at_rest:
                return True
        elif self.motion * y[0] < -STANDING_RAD_S:
            return True
        excess = self.side * self.command(t, y) - self.limit
        if self.mode == "linear":
            return abs(self.command(t, y)) > self.limit
        e = self.side * self.error(t, y)
        if self.mode == "frozen":
            return excess < 0.0 or e < 0.0
        if self.mode == "running":
            return excess < 0.0 or e > 0.0
        slope = self.side * self.kp * self.error_slope(t, y)
        return slope > 0.0 or slope + self.ki * e < 0.0

    # --- steps ----------------------------------------------------------------------------------------------

    def until(self, end: float) -> None:
        """Advance the run to a time, which becomes the end of a step."""
        self.rising = end <= self.ramp_s
        self._choose()
        while self.t < end:
            count = max(1, math.ceil((end - self.t) / self.longest - 1e-9))
            h = (end - self.t) / count
            y = self._step(h)
            if self._leaves(self.t + h, y):
                h, y = self._to_the_edge(h)
            last = count == 1 and h == end - self.t
            self.t, self.y = (end if last else self.t + h), y
            self._remember()
            if self._leaves(self.t, self.y):
                if abs(self.y[0]) <= 2.0 * STANDING_RAD_S:
                    self.y = (0.0, *self.y[1:])
                self._choose()
            self._record()

    def _to_the_edge(self, h: float) -> tuple[float, State]:
        """Return the shortest known step that leaves the mode, and the state after it."""
        inside, outside, state = 0.0, h, self._step(h)
        for _ in range(BISECTIONS):
            middle = 0.5 * (inside + outside)
            if middle in (inside, outside) or self.t + middle == self.t:
                break
            y = self._step(middle)
            if self._leaves(self.t + middle, y):
                outside, state = middle, y
            else:
                inside = middle
        return outside, state

    def _step(self, h: float) -> State:
        """Return the state after a classical Runge-Kutta step."""
        t, y = self.t, self.y
        a = self.rates(t, y)
        b = self.rates(t + 0.5 * h, _moved(y, a, 0.5 * h))
        c = self.rates(t + 0.5 * h, _moved(y, b, 0.5 * h))
        d = self.rates(t + h, _moved(y, c, h))
        w = h / 6.0
        return (
            y[0] + w * (a[0] + 2.0 * (b[0] + c[0]) + d[0]),
            y[1] + w * (a[1] + 2.0 * (b[1] + c[1]) + d[1]),
            y[2] + w * (a[2] + 2.0 * (b[2] + c[2]) + d[2]),
        )

    def _remember(self) -> None:
        """Store the control's torque and its slope, for a delayed torque."""
        if self.control.delay_s == 0.0:
            return
        slope = 0.0
        if self.mode == "linear":
            faster = self.acceleration(self.t, self.y) if self.commands else 0.0
            slope = self.kp * ((self.slope if self.rising else 0.0) - faster) + self.ki * self.error(
                self.t, self.y
            )
        self.commands.append((self.t, self.cut(self.t, self.y), slope))

    def _record(self) -> None:
        torque = self.torque(self.t, self.y)
        friction = abs(torque) if self.motion == 0.0 else self.friction(abs(self.y[0]))
        self.rows.append((self.t, self.y[0], self.wanted(self.t), torque, friction, self.y[2]))

    def trace(self) -> SpeedTrace:
        return SpeedTrace(*np.array(self.rows).T)


def _moved(y: State, rates: State, h: float) -> State:
    return y[0] + h * rates[0], y[1] + h * rates[1], y[2] + h * rates[2]
