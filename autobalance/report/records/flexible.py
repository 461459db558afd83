"""A crank that bends, as the report of `cycle` has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np

from autobalance.engine.cycle.analysis import CycleAnalysis
from autobalance.engine.cycle.load_figures import LoadPeak
from autobalance.machine_models.flexible_cycle import FlexibleCycle
from autobalance.records import INLINE, NotNegative, Ordinal, Pair, Positive, record

UM_PER_MM = 1e3


@record
class FlexibleMain:
    """A main's load and its journal's orbit on a spring; beside, the rigid crank's greatest load."""

    number: Ordinal
    stiffness_N_mm: Positive
    load: Annotated[LoadPeak, INLINE]
    rigid_greatest_N: NotNegative
    greatest_orbit_um: NotNegative
    orbit_x_um: Pair
    orbit_y_um: Pair


@record
class FlexibleWeb:
    """Least and greatest bending moment in a throw's plane in the middle of a web."""

    throw: Ordinal
    web: Ordinal
    bending_N_m: Pair


@record
class Flexible:
    """The cycle of a crank that bends on springs."""

    main_journals: Sequence[FlexibleMain]
    webs: Sequence[FlexibleWeb]
    rigid_difference: NotNegative

    @classmethod
    def of(cls, found: FlexibleCycle, cycle: CycleAnalysis) -> Self:
        """Return it of what was found; orbits of clockwise engines as they are, not mirrored."""
        mains = []
        sense = -1.0 if cycle.firing.engine.clockwise else 1.0
        rigid = cycle.peaks(cycle.loads.main_n)
        for number, (load, path) in enumerate(zip(found.main_n, found.orbit_mm, strict=True), 1):
            x, y = UM_PER_MM * path.real, sense * UM_PER_MM * path.imag
            mains.append(
                FlexibleMain(
                    number=number,
                    stiffness_N_mm=found.stiffness_n_mm[number - 1],
                    load=cycle.peak(np.stack([load.real, load.imag], axis=-1)),
                    rigid_greatest_N=rigid[number - 1].greatest_n,
                    greatest_orbit_um=float(np.hypot(x, y).max()),
                    orbit_x_um=(float(x.min()), float(x.max())),
                    orbit_y_um=(float(y.min()), float(y.max())),
                )
            )
        webs = [
            FlexibleWeb(
                throw=each.throw,
                web=each.web,
                bending_N_m=(float(each.bending_n_m.min()), float(each.bending_n_m.max())),
            )
            for each in found.webs
        ]
        return cls(main_journals=mains, webs=webs, rigid_difference=found.rigid_difference)
