"""Loads with gas before and after balancing, as the report has them; loads nothing that computes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

from autobalance.declare import NewtonMetres, Rpm, record
from autobalance.engines.cycle.load_figures import NumberedLoad, numbered_loads

if TYPE_CHECKING:
    from autobalance.engines.cycle.analysis import CycleAnalysis


@record
class MainLoads:
    """Loads of the mains and friction, which the crank's balance changes."""

    main_journals: Sequence[NumberedLoad]
    friction_mean_n_m: NewtonMetres

    @classmethod
    def of(cls, cycle: CycleAnalysis) -> Self:
        return cls(
            main_journals=numbered_loads(cycle.peaks(cycle.loads.main_n)),
            friction_mean_n_m=cycle.friction_mean_n_m,
        )


@record
class LoadsWithGas:
    """Loads with gas before and after, and those that balancing leaves as they are."""

    speed_rad_s: Rpm
    before: MainLoads
    after: MainLoads
    crankpins: Sequence[NumberedLoad]
    torque_mean_n_m: NewtonMetres

    @classmethod
    def of(cls, before: CycleAnalysis, after: CycleAnalysis) -> Self:
        return cls(
            speed_rad_s=before.speed_rad_s,
            before=MainLoads.of(before),
            after=MainLoads.of(after),
            crankpins=numbered_loads(after.peaks(after.crankpins_n)),
            torque_mean_n_m=after.mean_n_m,
        )
