"""The report of `rotor`: mm, rpm, Hz, µm and degrees; None where a thing does not apply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np

from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Count,
    NotNegative,
    Ordinal,
    Positive,
    Rpm,
    record,
)
from autobalance.dynamics.balancing_procedures import Advice, Procedure
from autobalance.dynamics.beam_rotor import BeamRotor
from autobalance.dynamics.critical_speeds import CriticalSpeed
from autobalance.dynamics.rotor_preparation import PreparedRotor
from autobalance.dynamics.run_up import Motion
from autobalance.dynamics.unbalance_response import Orbits, Sag
from autobalance.dynamics.whirl_modes import Whirl, WhirlMode
from autobalance.report.records.head import Head
from autobalance.types import Complex
from autobalance.units import RAD_S_PER_RPM

MM_PER_M = 1e3
UM_PER_M = 1e6
G_MM_PER_KG_M = 1e6


def mm(z_m: float) -> float:
    """Return a place in mm, without the last digits that the way through metres left."""
    return round(MM_PER_M * float(z_m), 9)


def phase_deg(value: complex) -> float:
    """Return φ of A exp(iφ) in (−180, 180]; 0 of nothing."""
    if value == 0.0:
        return 0.0
    degrees = float(np.degrees(np.angle(value)))
    return 180.0 if degrees <= -180.0 else degrees


@record
class RotorMass:
    """Mass, its centre, and how the rotor was divided."""

    mass_kg: Positive
    centre_of_mass_mm: float
    elements: Ordinal
    rigid_body_modes: Count

    @classmethod
    def of(cls, ready: PreparedRotor) -> Self:
        mass, moment = ready.rotor.mass_and_moment()
        return cls(
            mass_kg=mass,
            centre_of_mass_mm=MM_PER_M * moment / mass,
            elements=ready.elements,
            rigid_body_modes=ready.reduced.rigid_body_modes,
        )


@record
class Critical:
    """A critical speed."""

    speed_rad_s: Rpm
    whirl: Whirl
    log_decrement: float


@record
class Criticals:
    """Critical speeds, bare and with whirl and decrement."""

    critical_speeds_rad_s: Sequence[Rpm]
    criticals: Sequence[Critical]

    @classmethod
    def of(cls, criticals: Sequence[CriticalSpeed]) -> Self:
        return cls(
            critical_speeds_rad_s=[each.speed_rad_s for each in criticals],
            criticals=[Critical(**vars(each)) for each in criticals],
        )


@record
class ModeFigures:
    """A damped mode without its shape."""

    frequency_hz: NotNegative
    log_decrement: float
    whirl: Whirl

    @classmethod
    def of(cls, mode: WhirlMode) -> Self:
        return cls(
            frequency_hz=mode.frequency_rad_s / (2.0 * np.pi),
            log_decrement=mode.log_decrement,
            whirl=mode.whirl,
        )


@record
class ShapePoint:
    """A mode's amplitude and phase at a place."""

    z_mm: float
    x: NotNegative
    y: NotNegative
    x_phase_deg: float
    y_phase_deg: float


@record
class ShapedMode:
    """A damped mode with its shape, the greatest amplitude 1 with phase 0."""

    figures: Annotated[ModeFigures, INLINE]
    shape: Sequence[ShapePoint]

    @classmethod
    def of(cls, ready: PreparedRotor, mode: WhirlMode) -> Self:
        """Return a mode with its shape."""
        return cls(figures=ModeFigures.of(mode), shape=_shape(ready, mode.vector))


def _shape(ready: PreparedRotor, vector: Complex) -> list[ShapePoint]:
    matrices = ready.matrices
    x, y = matrices.deflections(vector)
    both = np.concatenate([x, y])
    greatest = both[int(np.argmax(np.abs(both)))]
    if greatest != 0.0:
        x, y = x / greatest, y / greatest
    return [
        ShapePoint(
            z_mm=mm(z),
            x=float(abs(a)),
            y=float(abs(b)),
            x_phase_deg=phase_deg(complex(a)),
            y_phase_deg=phase_deg(complex(b)),
        )
        for z, a, b in zip(matrices.shape_z_m, x, y, strict=True)
    ]


@record
class CampbellRow:
    """A speed with its modes."""

    speed_rad_s: Rpm
    modes: Sequence[ModeFigures]

    @classmethod
    def of(cls, speed_rad_s: float, modes: Sequence[WhirlMode]) -> Self:
        """Return a speed with its modes."""
        return cls(speed_rad_s=speed_rad_s, modes=[ModeFigures.of(each) for each in modes])


@record
class OrbitPoint:
    """The orbit of a place at a speed; None where it has no steady response."""

    speed_rad_s: Rpm
    x_um: NotNegative | None
    x_phase_deg: float | None
    y_um: NotNegative | None
    y_phase_deg: float | None
    major_um: NotNegative | None
    minor_um: float | None

    @classmethod
    def of(cls, speed_rad_s: float, x: complex, y: complex, major: float, minor: float) -> Self:
        """Return an orbit from its motion in metres."""
        known = bool(np.isfinite([x, y]).all())
        return cls(
            speed_rad_s=speed_rad_s,
            x_um=UM_PER_M * abs(x) if known else None,
            x_phase_deg=phase_deg(x) if known else None,
            y_um=UM_PER_M * abs(y) if known else None,
            y_phase_deg=phase_deg(y) if known else None,
            major_um=UM_PER_M * major if known else None,
            minor_um=UM_PER_M * minor if known else None,
        )


@record
class Response:
    """The orbits of a probe over the speeds."""

    z_mm: float
    points: Sequence[OrbitPoint]


def responses(probes_m: Sequence[float], orbits: Orbits) -> list[Response]:
    """Return the orbits at each probe."""
    major, minor = orbits.major_m, orbits.minor_m
    return [
        Response(
            z_mm=mm(z),
            points=[
                OrbitPoint.of(float(speed), complex(x), complex(y), float(a), float(b))
                for speed, x, y, a, b in zip(
                    orbits.speeds_rad_s,
                    orbits.x_m[:, at],
                    orbits.y_m[:, at],
                    major[:, at],
                    minor[:, at],
                    strict=True,
                )
            ],
        )
        for at, z in enumerate(probes_m)
    ]


@record
class Deflection:
    """Deflection of the rotor by gravity at a place."""

    z_mm: float
    x_um: float
    y_um: float


@record
class Reaction:
    """A bearing's force on the shaft under gravity; None where nothing holds it."""

    z_mm: float
    x_N: float | None
    y_N: float | None


@record
class Static:
    """The rotor under gravity."""

    deflections: Sequence[Deflection]
    reactions: Sequence[Reaction]

    @classmethod
    def of(cls, rotor: BeamRotor, sag: Sag | None) -> Self:
        if sag is None:
            free = [Reaction(z_mm=mm(each.z_m), x_N=None, y_N=None) for each in rotor.bearings]
            return cls(deflections=(), reactions=free)
        return cls(
            deflections=[
                Deflection(z_mm=mm(z), x_um=UM_PER_M * float(x), y_um=UM_PER_M * float(y))
                for z, (x, y) in zip(sag.z_m, sag.deflection_m, strict=True)
            ],
            reactions=[
                Reaction(z_mm=mm(each.z_m), x_N=float(x), y_N=float(y))
                for each, (x, y) in zip(rotor.bearings, sag.reactions_n, strict=True)
            ],
        )


@record
class AddedUnbalance:
    """The unbalance to add in a plane."""

    z_mm: float
    g_mm: NotNegative
    angle_deg: float


def added_unbalances(planes_m: Sequence[float], added_kg_m: Complex) -> list[AddedUnbalance]:
    """Return the unbalance to add in each plane."""
    return [
        AddedUnbalance(z_mm=mm(z), g_mm=G_MM_PER_KG_M * float(abs(each)), angle_deg=phase_deg(complex(each)))
        for z, each in zip(planes_m, added_kg_m, strict=True)
    ]


@record
class BalancingAdvice:
    """The balancing procedures that fit the service speed."""

    behaviour: str
    reason: str
    planes: Count
    standard: Literal["ISO 21940-12"] = "ISO 21940-12"
    procedures: Sequence[Procedure]

    @classmethod
    def of(cls, advice: Advice) -> Self:
        return cls(**vars(advice))


@record
class StiffnessRow:
    """Critical speeds without damping at one stiffness of the bearings."""

    k_n_m: Positive
    criticals: Annotated[Criticals, INLINE]


@record
class RunUpPoint:
    """The motion of a probe at an instant."""

    time_s: NotNegative
    speed_rpm: float
    x_um: float
    y_um: float


@record
class RunUp:
    """The motion of a probe while the speed changes, and its greatest."""

    z_mm: float
    greatest_um: NotNegative
    at_s: NotNegative
    at_rpm: float
    points: Sequence[RunUpPoint]


@record
class ThrowStiffness:
    """Bending stiffness of a throw as its equivalent straight shaft has it."""

    number: Ordinal
    in_plane_N_m2: Positive
    across_N_m2: Positive
    used_N_m2: Positive


@record
class EquivalentShaft:
    """The straight rotor in a crank's place, and what it is worth."""

    worth: str
    z_of_start_mm: float
    throws: Sequence[ThrowStiffness]


@record
class RotorReport(Head):
    """A shaft on bearings: its critical speeds, modes, response and balancing."""

    command: Literal["rotor"] = "rotor"
    input: Mapping[str, Any]
    mass: Annotated[RotorMass, INLINE]
    criticals: Annotated[Criticals, INLINE]
    modes: Sequence[ShapedMode]
    campbell: Sequence[CampbellRow]
    response: Sequence[Response]
    static: Static
    balancing: Sequence[AddedUnbalance]
    advice: BalancingAdvice
    stiffness_map: Sequence[StiffnessRow]
    run_up: Sequence[RunUp]
    equivalent: EquivalentShaft | Absent = ABSENT
    notes: Sequence[str] | Absent = ABSENT


def run_ups(probes_m: Sequence[float], motion: Motion) -> list[RunUp]:
    """Return the motion of each probe."""
    speeds_rpm = motion.speed_rad_s / RAD_S_PER_RPM
    return [
        RunUp(
            z_mm=mm(z),
            greatest_um=UM_PER_M * float(motion.greatest_m[at]),
            at_s=float(motion.greatest_at_s[at]),
            at_rpm=float(np.interp(motion.greatest_at_s[at], motion.time_s, speeds_rpm)),
            points=[
                RunUpPoint(
                    time_s=float(t),
                    speed_rpm=float(n),
                    x_um=UM_PER_M * float(x),
                    y_um=UM_PER_M * float(y),
                )
                for t, n, x, y in zip(
                    motion.time_s, speeds_rpm, motion.x_m[:, at], motion.y_m[:, at], strict=True
                )
            ],
        )
        for at, z in enumerate(probes_m)
    ]
