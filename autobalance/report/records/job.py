"""The job in a report, a record for each table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from autobalance.declare import (
    ABSENT,
    OMITTED,
    Absent,
    NotNegative,
    Ordinal,
    Pair,
    Pattern,
    Positive,
    Share,
    Size,
    Triple,
    decoded,
    record,
)
from autobalance.declare.schema import open_keys


@record
class JobCrankshaft:
    """The job's crank file and its data of the crank."""

    file: Annotated[str | None, "null: the crank was given in memory"] = None
    unit: Literal["mm", "cm", "m", "inch", None]
    density_kg_m3: Positive
    crankpin_in_file: bool
    axis_point_mm: Triple | None
    axis_direction: Triple | None
    crankpins: Sequence[Mapping[str, Any]] | None
    main_journals: Sequence[Mapping[str, Any]] | None
    body: Ordinal | Annotated[str, Pattern(least=1)] | None
    density_pm_kg_m3: NotNegative | Absent | None = ABSENT


@record
class Weight:
    """A weight with its uncertainty."""

    g: NotNegative
    pm: NotNegative
    distribution: Literal["normal", "rectangular"] | Absent = ABSENT


@record
class WeightTables:
    """Three tables of weights."""

    rotating_g: Mapping[str, NotNegative | Weight]
    reciprocating_g: Mapping[str, NotNegative | Weight]
    crankpin_g: Mapping[str, NotNegative | Weight]

    def weights_g(self, group: str) -> dict[str, float]:
        """Return the weights of a group, ``rotating_g``, by their names."""
        named: Mapping[str, float | Weight] = getattr(self, group, {})
        return {name: each.g if isinstance(each, Weight) else each for name, each in named.items()}


@record
class JobThrow(WeightTables):
    """A throw that differs from the others."""

    number: Ordinal
    rods: Ordinal
    bank_deg: Sequence[float] | Absent = ABSENT


@record
class JobAttached:
    """An attached part that turns with the crank and is out of balance."""

    name: str
    mass_g: NotNegative
    unbalance_g_mm: Pair
    z_mm: float
    pm_g_mm: NotNegative | Absent = ABSENT


@record
class JobLayout:
    """Banks and offsets of the cylinders."""

    bank_deg: Sequence[float] | None
    rod_pitch_mm: float
    offset_mm: float


@record
class JobRod:
    """A connecting rod by its ends."""

    big_end_g: NotNegative
    small_end_g: NotNegative
    inertia_kg_mm2: Positive | None
    solid: Mapping[str, Any] | Absent = ABSENT


@open_keys
@record
class JobEngine(WeightTables):
    """The parts that the crank carries."""

    rod_length_mm: Positive | None
    stroke_mm: Positive | None
    rods_per_throw: Ordinal = 1
    throw: Sequence[JobThrow] = ()
    attached: Sequence[JobAttached] = ()
    layout: JobLayout | Absent = ABSENT
    rod: JobRod | Absent = ABSENT
    turns: Annotated[Literal["cw"], "seen from +z"] | Absent = ABSENT

    def of_throw(self, number: int) -> tuple[WeightTables, int]:
        """Return the weights of a throw, its own or those of all, and the number of its rods."""
        own = next((each for each in self.throw if each.number == number), None)
        return (self, self.rods_per_throw) if own is None else (own, own.rods)


@open_keys
@record
class JobBalance:
    """Balance factor, top speed and quality grade."""

    factor: Share | Literal["original"] | None
    grade: Positive | None
    speed_rpm: Positive | None
    judge: Literal["dynamic", "static"]
    rotor_mass_g: Positive | None
    tolerance_planes_mm: Pair | None
    margin: Literal["none", "expanded"] | Absent = ABSENT
    facet_correction: bool | Absent = ABSENT
    external: str | Absent = ABSENT


@open_keys
@record
class JobCorrection:
    """Kinds of correction and their preference; each kind's own table is next to these."""

    method: Annotated[Sequence[str], Size(1)] | None
    depth_tolerance_mm: NotNegative | Absent | None = ABSENT


@open_keys
@record
class JobPart:
    """The part, and who made it for whom; names of papers begin with part and serial."""

    part: str | None = None
    customer: str | None = None
    engine: str | None = None
    serial: str | None = None
    operator: str | None = None
    note: str | None = None


@open_keys
@record
class JobShop:
    """The shop, as the papers show it."""

    name: str | None = None
    logo: str | None = None
    machine: str | None = None
    units: str | None = None
    washers_g: Sequence[float] | None = None


@open_keys
@record
class Job:
    """The job as read, defaults filled in."""

    file: str
    crankshaft: JobCrankshaft
    engine: JobEngine
    original: WeightTables | None
    balance: JobBalance
    correction: JobCorrection
    drive: Mapping[str, Any] | Absent = ABSENT
    job: Annotated[JobPart, OMITTED] = JobPart()
    shop: Annotated[JobShop, OMITTED] = JobShop()

    @classmethod
    def read(cls, values: Mapping[str, Any]) -> Self:
        """Return a job from the values of its echo, of an earlier version as far as it goes."""
        return decoded(cls, values, partly=True)
