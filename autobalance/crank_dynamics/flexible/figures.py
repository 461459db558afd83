"""Figures of a crank that bends over its cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np

from autobalance.declare import ABSENT, INLINE, Absent, NotNegative, Ordinal, Pair, Positive, record
from autobalance.engines.bearings.film import CONTACT_ECCENTRICITY_RATIO
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.load_figures import LoadPeak
from autobalance.types import Complex
from autobalance.units import UM_PER_MM

if TYPE_CHECKING:  # half a second of a cycle whose crank does not bend: scipy.integrate
    from autobalance.crank_dynamics.flexible.cycle import FlexibleCycle, ShaftTwist

MRAD_PER_RAD = 1e3


@record
class FlexibleMain:
    """A main's load and its journal's orbit; beside, the rigid crank's largest load."""

    number: Ordinal
    stiffness_N_mm: Annotated[Positive | None, "null in a film"]
    load: Annotated[LoadPeak, INLINE]
    rigid_greatest_N: NotNegative
    greatest_orbit_um: NotNegative
    orbit_x_um: Pair
    orbit_y_um: Pair
    least_film_mm: NotNegative | Absent | None = ABSENT
    limit: Literal["contact", "not periodic"] | Absent | None = ABSENT


@record
class FlexibleWeb:
    """Smallest and largest bending moment in a throw's plane in the middle of a web."""

    throw: Ordinal
    web: Ordinal
    bending_N_m: Pair


@record
class FlexibleShaft:
    """Smallest and largest twist and torque between neighbouring stations of the torsional chain."""

    between: tuple[str, str]
    twist_mrad: Pair
    torque_N_m: Pair


@record
class BareMain:
    """A main's load and the reach of its journal's orbit."""

    number: Ordinal
    load: Annotated[LoadPeak, INLINE]
    greatest_orbit_um: NotNegative


@record
class WithoutCounterweights:
    """The same crank without the metal of its counterweights."""

    main_journals: Sequence[BareMain]
    webs: Sequence[FlexibleWeb]

    @classmethod
    def of(cls, flexible: FlexibleCycle, cycle: CycleAnalysis) -> Self:
        mains = [
            BareMain(number=number, load=_peak(cycle, load), greatest_orbit_um=UM_PER_MM * _reach(path))
            for number, (load, path) in enumerate(zip(flexible.main_n, flexible.orbit_mm, strict=True), 1)
        ]
        return cls(main_journals=mains, webs=_webs(flexible))


@record
class Flexible:
    """The cycle of a crank that bends on springs or in films."""

    main_journals: Sequence[FlexibleMain]
    webs: Sequence[FlexibleWeb]
    rigid_difference: NotNegative
    shafts: Sequence[FlexibleShaft] | None
    without_counterweights: WithoutCounterweights | None

    @classmethod
    def of(
        cls,
        found: FlexibleCycle,
        bare: FlexibleCycle | None,
        twists: Sequence[ShaftTwist] | None,
        cycle: CycleAnalysis,
    ) -> Self:
        """Return the results; orbits of clockwise engines as they are, not mirrored."""
        mains = []
        sense = -1.0 if cycle.firing.engine.clockwise else 1.0
        rigid = cycle.peaks(cycle.loads.main_n)
        for number, (load, path) in enumerate(zip(found.main_n, found.orbit_mm, strict=True), 1):
            x, y = UM_PER_MM * path.real, sense * UM_PER_MM * path.imag
            springs = found.stiffness_n_mm
            mains.append(
                FlexibleMain(
                    number=number,
                    stiffness_N_mm=None if springs is None else springs[number - 1],
                    load=_peak(cycle, load),
                    rigid_greatest_N=rigid[number - 1].greatest_n,
                    greatest_orbit_um=float(np.hypot(x, y).max()),
                    orbit_x_um=(float(x.min()), float(x.max())),
                    orbit_y_um=(float(y.min()), float(y.max())),
                    **_film(found, number),
                )
            )
        return cls(
            main_journals=mains,
            webs=_webs(found),
            rigid_difference=found.rigid_difference,
            shafts=None if twists is None else [_shaft(each) for each in twists],
            without_counterweights=None if bare is None else WithoutCounterweights.of(bare, cycle),
        )


def _shaft(found: ShaftTwist) -> FlexibleShaft:
    twist, torque = MRAD_PER_RAD * found.twist_rad, found.torque_n_m
    return FlexibleShaft(
        between=(found.first, found.second),
        twist_mrad=(float(twist.min()), float(twist.max())),
        torque_N_m=(float(torque.min()), float(torque.max())),
    )


def _film(flexible: FlexibleCycle, number: int) -> dict[str, Any]:
    """Return the fields of a journal's film; none on a spring."""
    if flexible.clearance_mm is None:
        return {}
    clearance, reach = float(flexible.clearance_mm[number - 1]), _reach(flexible.orbit_mm[number - 1])
    broken = reach > CONTACT_ECCENTRICITY_RATIO * clearance
    return {
        "least_film_mm": None if broken or not flexible.is_periodic else clearance - reach,
        "limit": "contact" if broken else None if flexible.is_periodic else "not periodic",
    }


def _reach(path: Complex) -> float:
    return float(np.abs(path).max())


def _peak(cycle: CycleAnalysis, load: Complex) -> LoadPeak:
    return cycle.peak(np.stack([load.real, load.imag], axis=-1))


def _webs(flexible: FlexibleCycle) -> list[FlexibleWeb]:
    return [
        FlexibleWeb(
            throw=each.throw,
            web=each.web,
            bending_N_m=(float(each.bending_n_m.min()), float(each.bending_n_m.max())),
        )
        for each in flexible.webs
    ]
