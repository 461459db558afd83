"""A job in mm, g, s and rad; tables that few jobs hold are in separate modules."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Any, Literal

from autobalance.crank.anatomy import Overrides
from autobalance.rigid_rotor.margin import Margin
from autobalance.rigid_rotor.staged_assembly import ShaftKey
from autobalance.rigid_rotor.tolerance import Judge
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.soundness.holes import OpenHoles
from autobalance.value_classes import dataclass

# A shop's measurements of the crank in the hand: on a scale, with a micrometer.


Calibrate = Literal["skin", "density", "none"]
"""Quantity that absorbs a difference of mass: an even offset of the surface, the density, or nothing."""


@dataclass(frozen=True)
class CrankReadings:
    """Readings of the bare crank, with half-widths (``pm``) of about 95 %.

    ``micrometer_mm`` has ``main_journal`` and ``crankpin`` where they were measured.
    """

    weighed_g: float | None = None
    weighed_pm_g: float = 0.0
    calibrate: Calibrate = "none"
    micrometer_mm: Mapping[str, float] = field(default_factory=dict)
    micrometer_pm_mm: float = 0.0

    @property
    def any(self) -> bool:
        """Whether anything was measured."""
        return self.weighed_g is not None or bool(self.micrometer_mm)


# The crank, the parts on it and the requirements on it: tables of a job in mm, g, s and rad.


LengthUnit = Literal["mm", "cm", "m", "inch"]
Distribution = Literal["normal", "rectangular"]
Sampling = Literal["random", "latin_hypercube"]


@dataclass(frozen=True, eq=False)
class Crankshaft:
    """The file and what has to be known to read it as a crank.

    ``file`` is None if the crank is given as an object. ``unit`` is None if the format carries its own.
    ``body`` picks one of several solids, from 1, or by its name if the format has names. ``density_pm_g_mm3``
    is the uncertainty of the density, None if the job does not state it; ``scan_accuracy_mm`` is the
    scanner's, likewise. ``readings`` are a shop's measurements of it; ``holes`` are the holes of an open mesh
    to close. ``scan`` is a scan of the same crank, whose mass and unbalance count while the file's own faces
    are cut; scanner, readings and holes are its then.
    """

    file: Path | None
    unit: LengthUnit | None
    density_g_mm3: float
    overrides: Overrides
    body: int | str | None
    density_pm_g_mm3: float | None = None
    scan_accuracy_mm: float | None = None
    readings: CrankReadings = field(default_factory=CrankReadings)
    holes: OpenHoles = field(default_factory=OpenHoles)
    scan: Crankshaft | None = None

    @property
    def weighed(self) -> Crankshaft:
        """The file whose mass and unbalance count: the scan if there is one, else this one."""
        return self if self.scan is None else self.scan

    def weighed_with(self, **changes: Any) -> Crankshaft:
        """Return the crank with changed values of the file whose mass and unbalance count."""
        if self.scan is None:
            return replace(self, **changes)
        return replace(self, scan=replace(self.scan, **changes))

    @property
    def crankpin_in_file(self) -> bool:
        """False for a pressed-up crank that is modelled without its crankpins."""
        return self.overrides.crankpin_in_file is not False


@dataclass(frozen=True)
class Weight:
    """A mass on the scale, and its uncertainty [g].

    ``distribution`` is how ``study`` reads the ±; None: the job's ``[study]`` decides.
    """

    mass_g: float
    pm_g: float = 0.0
    distribution: Distribution | None = None


@dataclass(frozen=True)
class PartWeights:
    """The parts of one throw: of one connecting rod twice, then what belongs to the crankpin itself."""

    rotating: Mapping[str, Weight] = field(default_factory=dict)
    reciprocating: Mapping[str, Weight] = field(default_factory=dict)
    crankpin: Mapping[str, Weight] = field(default_factory=dict)

    def merged(self, other: PartWeights) -> PartWeights:
        """Return these parts with those of ``other`` put in, each in the place of the one of its name."""
        return PartWeights(
            {**self.rotating, **other.rotating},
            {**self.reciprocating, **other.reciprocating},
            {**self.crankpin, **other.crankpin},
        )


@dataclass(frozen=True)
class LinkRod:
    """A rod that hangs on the master rod of its throw, on a knuckle pin.

    ``cylinder`` is the number through the engine, from 1. ``knuckle_rad`` is about the crankpin from the
    master rod's axis. Masses None: those of the throw's other rods.
    """

    cylinder: int
    bank_rad: float
    rod_length_mm: float
    knuckle_radius_mm: float
    knuckle_rad: float
    rotating_g: float | None = None
    reciprocating_g: float | None = None


@dataclass(frozen=True)
class ThrowParts:
    """Parts on one throw; with ``links``, one of its rods is their master."""

    rods: int
    weights: PartWeights
    links: tuple[LinkRod, ...] = ()


@dataclass(frozen=True)
class Attached:
    """A part that turns with the crank and is out of balance, at a place on the axis (rotor frame).

    ``pm_g_mm`` is the uncertainty of its unbalance.
    """

    name: str
    mass_g: float
    unbalance_g_mm: tuple[float, float]
    z_mm: float
    pm_g_mm: float = 0.0


@dataclass(frozen=True, eq=False)
class ThrowOil:
    """Oil in the bores and drillings of a throw and of the mains beside it, up to halfway to its neighbours.

    ``moments`` are its own, rotor frame. ``on_crankpin_g`` at the crankpin's centre pulls along the throw as
    it does, so that it is part of the bob-weight; ``rest`` is what a bob-weight cannot stand for.
    """

    moments: Moments
    on_crankpin_g: float
    rest: Moments


@dataclass(frozen=True)
class CylinderLayout:
    """Places of the cylinders about the crank; for forces and shafts.

    ``bank_rad`` has one direction for each rod of a throw, from the rotor's x axis at crank angle 0, or is
    None if the job does not state it. ``bank_by_throw`` has those of the throws that differ, by their number.
    """

    bank_rad: tuple[float, ...] | None = None
    bank_by_throw: Mapping[int, tuple[float, ...]] = field(default_factory=dict)
    rod_pitch_mm: float = 0.0
    offset_mm: float = 0.0

    def banks_of(self, number: int) -> tuple[float, ...] | None:
        """Return the directions of a throw's cylinders, or None."""
        return self.bank_by_throw.get(number, self.bank_rad)


@dataclass(frozen=True)
class RodOnScales:
    """Weights of a bare connecting rod on two scales, and its inertia about its centre of mass.

    ``solid`` names the file that was measured, empty if the part was weighed.
    """

    big_end_g: float
    small_end_g: float
    inertia_g_mm2: float | None = None
    solid: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Bolted:
    """A weight on a balance shaft, drawn and, where it was, weighed."""

    name: str
    eccentricity_mm: float
    cad_g: float
    weighed_g: float | None = None


@dataclass(frozen=True)
class BalanceShaftEntry:
    """A balance shaft; its product is given, or the sum of its bolted weights'.

    ``z_mm`` is where its unbalance lies along the crank axis, rotor frame; None: at the reference of moments.
    """

    order: int
    forward: bool
    product_g_mm: float
    phase_rad: float
    place_mm: tuple[float, float] = (0.0, 0.0)
    weights: tuple[Bolted, ...] = ()
    z_mm: float | None = None


@dataclass(frozen=True)
class EngineParts:
    """Weights on the throws: those of every throw, and of the throws that differ, by their number.

    ``clockwise``: the crank turns so, seen from +z. ``oil_g_mm3`` is the density of the oil that fills its
    bores and drillings, None: none is counted; ``oil`` is that oil by throw, once a crank was measured.
    """

    default: ThrowParts
    by_throw: Mapping[int, ThrowParts] = field(default_factory=dict)
    attached: tuple[Attached, ...] = ()
    rod_length_mm: float | None = None
    stroke_mm: float | None = None
    layout: CylinderLayout = field(default_factory=CylinderLayout)
    rod: RodOnScales | None = None
    clockwise: bool = False
    oil_g_mm3: float | None = None
    oil: Mapping[int, ThrowOil] = field(default_factory=dict)

    def of_throw(self, number: int) -> ThrowParts:
        """Return the parts on a throw."""
        return self.by_throw.get(number, self.default)

    def oil_on_crankpin_g(self, number: int) -> float:
        """Return the oil's addition to a throw's bob-weight."""
        return self.oil[number].on_crankpin_g if number in self.oil else 0.0


External = Literal["none", "solve", "neutral", "detroit"]


@dataclass(frozen=True)
class ExternalPart:
    """A damper, flexplate or flywheel that carries unbalance for the crank, at ``z_mm`` of the rotor frame.

    ``unbalance_g_mm`` is what it carries now, ``max_g_mm`` what it can (None: any), ``angle_rad`` where alone
    (None: anywhere).
    """

    name: str
    z_mm: float
    unbalance_g_mm: tuple[float, float] = (0.0, 0.0)
    max_g_mm: float | None = None
    angle_rad: float | None = None


@dataclass(frozen=True)
class Balance:
    """Requirements on the balanced crank; ``factor`` None stands for the original one.

    ``overbalance_g_mm`` is left on purpose for final drilling, its heavy side at ``overbalance_rad``;
    ``facet_correction`` adds what the mesh's facets hide to what is measured.
    """

    factor: float | None
    grade_mm_s: float
    service_speed_rad_s: float
    judge: Judge
    rotor_mass_g: float | None
    tolerance_planes_mm: tuple[float, float] | None
    overbalance_g_mm: float = 0.0
    overbalance_rad: float = math.pi
    margin: Margin = "none"
    facet_correction: bool = False
    external: External = "none"
    external_parts: tuple[ExternalPart, ...] = ()


# The ``[[assembly]]`` tables of a job in mm, g and rad.


@dataclass(frozen=True)
class PartSolid:
    """The solid of a part."""

    file: Path
    unit: LengthUnit | None
    density_g_mm3: float
    turn_rad: float


@dataclass(frozen=True, eq=False)
class AssemblyEntry:
    """A part of the assembly; its own mass and unbalance, or its ``solid`` to measure them on."""

    name: str
    shaft: str
    z_mm: float
    mass_g: float | None
    unbalance_g_mm: complex
    solid: PartSolid | None
    runout_mm: complex
    key: ShaftKey | None
    correct_mm: tuple[float, ...]
    permissible_g_mm: float | None
    speed_ratio: float
    values: Mapping[str, Any] = field(default_factory=dict)


__all__ = [
    "Attached",
    "Balance",
    "BalanceShaftEntry",
    "Bolted",
    "Crankshaft",
    "CylinderLayout",
    "Distribution",
    "EngineParts",
    "External",
    "ExternalPart",
    "LengthUnit",
    "LinkRod",
    "PartWeights",
    "RodOnScales",
    "Sampling",
    "ThrowOil",
    "ThrowParts",
    "Weight",
]
