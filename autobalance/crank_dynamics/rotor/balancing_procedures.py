"""Procedures of ISO 21940-12 for rotors with flexible behaviour, and the choice among them for a rotor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from autobalance.crank_dynamics.rotor.critical_speeds import CriticalSpeed
from autobalance.declare import Count

RIGID_BELOW = 0.7
"""Largest ratio of service speed to first critical speed of a rotor usually taken as rigid."""


@dataclass(frozen=True)
class Procedure:
    """A procedure with its letter in ISO 21940-12, table 1 (formerly ISO 11342)."""

    letter: str
    name: str


PROCEDURES = (
    Procedure("A", "single-plane balancing"),
    Procedure("B", "two-plane balancing"),
    Procedure("C", "individual component balancing prior to assembly"),
    Procedure("D", "balancing subsequent to controlling initial unbalance"),
    Procedure("E", "balancing in stages during assembly"),
    Procedure("F", "balancing in optimum planes"),
    Procedure("G", "multiple speed balancing"),
    Procedure("H", "service speed balancing"),
    Procedure("I", "fixed speed balancing"),
)


@dataclass(frozen=True)
class BalancingAdvice:
    """The balancing procedures that fit the service speed."""

    behaviour: str
    reason: str
    planes: Count
    standard: Literal["ISO 21940-12"]
    procedures: tuple[Procedure, ...]


def advice(service_speed_rad_s: float, criticals: Sequence[CriticalSpeed]) -> BalancingAdvice:
    """Return the procedures that fit a service speed, and the planes of modal balancing (N + 2).

    Only critical speeds driven by unbalance count: those of forward whirl or of motion in a plane.
    """
    driven = [each.speed_rad_s for each in criticals if each.whirl in ("forward", None, "mixed")]
    if not driven or service_speed_rad_s <= RIGID_BELOW * driven[0]:
        reason = f"the service speed is at most {100 * RIGID_BELOW:.0f} % of the first critical speed"
        if not driven:
            reason = "no critical speed that unbalance drives was found"
        return _advice("rigid", reason, 2, "AB")
    passed = sum(1 for each in driven if each <= service_speed_rad_s)
    near = max(1, passed)
    planes = near + 2
    if not passed:
        reason = "the service speed is near the first critical speed, below it"
        return _advice("flexible, one mode", reason, planes, "CDEFH")
    reason = (
        f"the rotor passes {passed} critical speed{'s' if passed > 1 else ''} on its way to service speed"
    )
    return _advice("flexible", reason, planes, "G" if passed > 1 else "FG")


def _advice(behaviour: str, reason: str, planes: int, letters: str) -> BalancingAdvice:
    procedures = tuple(each for each in PROCEDURES if each.letter in letters)
    return BalancingAdvice(behaviour, reason, planes, "ISO 21940-12", procedures)
