"""The ``[cycle]`` table of a job in MPa, mm, N, s and rad."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any, Literal

from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.cycle.cylinder import Strokes
from autobalance.engines.cycle.drive import Drive
from autobalance.engines.cycle.friction import Friction
from autobalance.engines.cycle.pendulum import Pendulum
from autobalance.engines.cycle.piston_friction import PistonFriction
from autobalance.engines.cycle.weight import Gravity
from autobalance.engines.cycle.windage import Air
from autobalance.job import Job
from autobalance.value_classes import dataclass

Model = Literal["wiebe", "trace", "motored"]
Peg = Literal["none", "intake"]


@dataclass(frozen=True)
class CylinderGas:
    """Gas in one cylinder; pressures in MPa, heat in N·mm, angles after firing top dead centre."""

    bore_mm: float
    compression_ratio: float | None
    model: Model
    start_rad: float
    duration_rad: float
    wiebe_a: float
    wiebe_n: float
    heat_n_mm: float | None
    gamma: float
    gamma_per_k: float
    intake_mpa: float
    intake_k: float
    exhaust_mpa: float
    crankcase_mpa: float
    crankcase_mm3: float | None
    intake_closes_rad: float | None
    exhaust_opens_rad: float | None


@dataclass(frozen=True)
class TraceFile:
    """A measured pressure: its file as the job names it, and what is done to it."""

    file: str
    shift_rad: float
    peg: Peg
    smooth_rad: float


@dataclass(frozen=True)
class Absorber:
    """A pendulum, its largest swing, and the share of its order's torque that it is to take."""

    pendulum: Pendulum
    swing_rad: float
    reduction: float


@dataclass(frozen=True)
class Film:
    """Oil films: viscosity [Pa·s], radial clearances and lengths [mm]; None: as long as the pins are wide."""

    viscosity_pa_s: float
    main_clearance_mm: float
    main_length_mm: float | None
    crankpin_clearance_mm: float | None
    crankpin_length_mm: float | None


@dataclass(frozen=True)
class MainHeat:
    """Heat paths of each main bearing: to the block and, with a supply, with oil that flows through.

    ``flow_m3_s`` None: the flow of its film.
    """

    conductance_W_K: float
    ambient_C: float
    oil: WaltherOil
    supply_C: float | None
    flow_m3_s: float | None
    heat_capacity_J_kg_K: float


@dataclass(frozen=True, eq=False)
class Cycle:
    """The ``[cycle]`` table of a job, checked; ``values`` are its keys with the defaults filled in."""

    strokes: Strokes
    default: CylinderGas
    by_cylinder: Mapping[int, CylinderGas]
    trace: TraceFile
    firing_order: tuple[int, ...] | None
    firing_rad: tuple[float, ...] | None
    flywheel_g_mm2: float
    fluctuation_wanted: float | None
    woschni_wall_k: float | None
    friction: Friction
    absorber: Absorber | None = None
    film: Film | None = None
    gravity: Gravity | None = None
    drives: tuple[Drive, ...] = ()
    piston: PistonFriction | None = None
    heat: MainHeat | None = None
    windage: Air | None = None
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def measured(self) -> bool:
        """Whether a cylinder takes its pressure from a trace."""
        return any(gas.model == "trace" for gas in (self.default, *self.by_cylinder.values()))

    def of_cylinder(self, number: int) -> CylinderGas:
        """Return the gas of a cylinder, from 1."""
        return self.by_cylinder.get(number, self.default)


def table_of(job: Job) -> Cycle:
    """Return the ``[cycle]`` of a job that is known to have one."""
    cycle = job.table(Cycle)
    assert cycle is not None
    return cycle
