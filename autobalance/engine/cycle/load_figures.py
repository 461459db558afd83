"""Loads and torque orders of a cycle, as reports have them; loads nothing that computes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from autobalance.records import INLINE, Bound, Degrees, NewtonMetres, Newtons, Ordinal, record


@dataclass(frozen=True)
class LoadPeak:
    """Greatest magnitude of a load, the crank angle where it is, and its mean magnitude over a cycle."""

    greatest_n: Annotated[Newtons, Bound("minimum", 0)]
    at_rad: Degrees
    mean_n: Annotated[Newtons, Bound("minimum", 0)]


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
    """A bearing's or pin's load through the cycle."""

    number: Ordinal
    load: Annotated[LoadPeak, INLINE]


def numbered_loads(peaks: Sequence[LoadPeak]) -> list[NumberedLoad]:
    """Return greatest and mean loads, numbered from 1."""
    return [NumberedLoad(number=number, load=peak) for number, peak in enumerate(peaks, 1)]
