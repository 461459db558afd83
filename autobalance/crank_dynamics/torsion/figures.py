"""Figures of a torsional train: inertias and springs, modes, absorber, its crank's throws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

from autobalance.crank_dynamics.torsion.chain import HolzerRow, ThrowShape, TorsionMode
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.from_job import CrankChain
from autobalance.crank_dynamics.torsion.model import Formula, NamedTrain, PendulumAbsorber
from autobalance.declare import (
    INLINE,
    KG_MM2_OF_SI,
    MM,
    MRAD,
    Count,
    Floats,
    Hertz,
    NotNegative,
    Ordinal,
    Positive,
    record,
)
from autobalance.types import Array

if TYPE_CHECKING:  # finite elements
    from autobalance.crank_dynamics.torsion.throw_twist import ThrowTwist

Stations = Annotated[Sequence[Ordinal], "from 1"]


@record
class Gears:
    """A pair of gears between two stations."""

    stations: Stations
    ratio: float
    mesh_N_m_rad: Positive | None


@record
class CouplingFigures:
    """The mean torque of a coupling, and its stiffness there."""

    station: Ordinal
    mean_N_m: float
    N_m_rad: Positive


@record
class TrainFigures:
    """Inertias and springs, as they are and referred to station 1; formulas are those of a crank's throws."""

    stations: Sequence[str]
    inertias_kg_m2: Annotated[Floats, KG_MM2_OF_SI]
    stiffness_N_m_rad: Floats
    ker_wilson_N_m_rad: Floats | None
    carter_N_m_rad: Floats | None
    fem_N_m_rad: Floats | None
    links: Sequence[Stations]
    ratios: Floats
    referred_inertias_kg_m2: Annotated[Floats, KG_MM2_OF_SI]
    referred_stiffness_N_m_rad: Floats
    gears: Sequence[Gears]
    couplings: Sequence[CouplingFigures]

    @classmethod
    def of(cls, named: NamedTrain, chain: CrankChain | None, metal_n_m_rad: Array | None) -> Self:
        """Return the figures of a train; ``chain`` is the crank in it, whose own metal has these springs."""
        train = named.train
        return cls(
            stations=named.names,
            inertias_kg_m2=train.inertias_kg_m2,
            stiffness_N_m_rad=train.springs_n_m_rad,
            ker_wilson_N_m_rad=None if chain is None else chain.ker_wilson_n_m_rad,
            carter_N_m_rad=None if chain is None else chain.carter_n_m_rad,
            fem_N_m_rad=metal_n_m_rad,
            links=[[int(a) + 1, int(b) + 1] for a, b in train.links],
            ratios=train.ratios,
            referred_inertias_kg_m2=train.referred_inertias_kg_m2,
            referred_stiffness_N_m_rad=train.referred_springs_n_m_rad,
            gears=[
                Gears(stations=[g.first + 1, g.second + 1], ratio=g.ratio, mesh_N_m_rad=g.mesh_n_m_rad)
                for g in train.gears
            ],
            couplings=[
                CouplingFigures(station=each.station + 1, mean_N_m=each.mean_n_m, N_m_rad=each.n_m_rad)
                for each in named.couplings
            ],
        )


@record
class Damping:
    """Damping ratio of every mode, and whether the file gives dampers."""

    ratio: NotNegative
    dampers: bool

    @property
    def is_none(self) -> bool:
        """Whether nothing limits the peaks of the response."""
        return self.ratio == 0.0 and not self.dampers


@record
class TorsionModeFigures:
    """A mode, with Holzer's table where the stations are a chain that hangs together."""

    frequency_rad_s: Hertz
    name: Sequence[str]
    shape: Floats
    twist_rad: Annotated[Floats, MRAD, "along each link for 1 mrad at the largest amplitude"]
    nodes: Count
    holzer: Sequence[HolzerRow] | None

    @classmethod
    def of(cls, model: ExcitedTrain, mode: TorsionMode) -> Self:
        return cls(
            frequency_rad_s=mode.frequency_rad_s,
            name=model.named.names,
            shape=mode.shape,
            twist_rad=MRAD.read(1.0) * model.named.train.twists(mode.shape),
            nodes=mode.nodes,
            holzer=model.holzer(mode),
        )


@record
class AbsorberSize:
    """A pendulum's length, and its inertia about the crank axis."""

    schema_name: ClassVar[str] = "PendulumFigures"
    length_m: Annotated[Positive, MM]
    inertia_kg_m2: Annotated[Positive, KG_MM2_OF_SI]

    @classmethod
    def of(cls, absorber: PendulumAbsorber) -> Self:
        return cls(length_m=absorber.length_m, inertia_kg_m2=absorber.inertia_kg_m2)


@record
class ThrowFigures:
    """The dimensions that the stiffness of a throw was computed from, and what came of them."""

    number: Ordinal
    shape: Annotated[ThrowShape, INLINE]
    formula: Formula
    ker_wilson_N_m_rad: Positive
    carter_N_m_rad: Positive
    fem_N_m_rad: Positive | None
    fem_error_N_m_rad: NotNegative | None
    fem_levels_N_m_rad: Floats | None
    fem_nodes: Count | None
    fem_note: Annotated[str | None, "why its own metal gives no stiffness"]

    @classmethod
    def of(cls, number: int, chain: CrankChain, formula: Formula, twist: ThrowTwist | None) -> Self:
        """Return the figures of a throw, numbered from 1."""
        metal = None if twist is None else twist.stiffness
        return cls(
            number=number,
            shape=chain.shapes[number - 1],
            formula=formula,
            ker_wilson_N_m_rad=chain.throws_n_m_rad["ker_wilson"][number - 1],
            carter_N_m_rad=chain.throws_n_m_rad["carter"][number - 1],
            fem_N_m_rad=None if metal is None else metal.n_m_rad,
            fem_error_N_m_rad=None if metal is None else metal.error_n_m_rad,
            fem_levels_N_m_rad=None if metal is None else metal.levels_n_m_rad,
            fem_nodes=None if metal is None else metal.nodes,
            fem_note=None if twist is None else twist.reason,
        )
