"""Loads and torque orders of a cycle, as reports have them; loads nothing that computes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.declare import ABSENT, INLINE, Absent, Degrees, NewtonMetres, Newtons, Ordinal, Range, record
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class LoadPeak:
    """Largest magnitude of a load, the crank angle where it is, and its mean magnitude over a cycle."""

    greatest_n: Annotated[Newtons, Range(least=0)]
    at_rad: Degrees
    mean_n: Annotated[Newtons, Range(least=0)]


@dataclass(frozen=True)
class TorqueOrder:
    """One order of the torque: amplitudes of gas, inertia and all, and the phase of all, A cos(kθ + φ)."""

    order: float
    gas_n_m: NewtonMetres
    inertia_n_m: NewtonMetres
    total_n_m: NewtonMetres
    phase_rad: Degrees


@record
class NumberedLoad:
    """A bearing's or pin's load through the cycle.

    ``on``, in an articulated engine: a link rod's big end is on its knuckle pin. The load of its master rod
    alone is on no bearing: the one big end carries the links too and has the load of the crankpin.
    """

    number: Ordinal
    load: Annotated[LoadPeak, INLINE]
    on: Literal["knuckle pin", "no bearing"] | Absent = ABSENT


Carrier = Literal["knuckle pin", "no bearing"]


def numbered_loads(
    peaks: Sequence[LoadPeak], on: Sequence[Carrier | Absent] | None = None
) -> list[NumberedLoad]:
    """Return largest and mean loads, numbered from 1; ``on``: what carries each."""
    carriers = [ABSENT] * len(peaks) if on is None else on
    return [
        NumberedLoad(number=number, load=peak, on=carrier)
        for number, (peak, carrier) in enumerate(zip(peaks, carriers, strict=True), 1)
    ]
