"""Solids beside the crank: a measured connecting rod, and the bodies of an assembly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Literal

import numpy as np

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.rod_eyes import RodEyes, find_eyes
from autobalance.errors import RecognitionError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh
from autobalance.solid.formats.bodies import BodySource
from autobalance.solid.formats.read import Source
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.slicing.slices import Slab
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2
from autobalance.value_classes import dataclass

# A connecting rod measured in its solid: eyes, mass, end weights, inertia, and their uncertainty.


TURN_RAD = np.radians(np.arange(0.0, 360.0, 0.25))

X_TO_Z = np.array([[0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Takes a rod's x, which runs along it, to z."""
ROUNDING = 1e-7
"""Corners this near to a cut, as a share of the rod's diagonal, lie on it."""


@dataclass(frozen=True)
class RodUncertainty:
    """Uncertainty of a rod's masses from its facets and its density [g]."""

    mass_g: float
    big_end_g: float
    small_end_g: float


@dataclass(frozen=True, eq=False)
class MeasuredRod:
    """A connecting rod's solid, recognised and measured.

    Attributes
    ----------
    source : Source
    eyes : RodEyes
    density_g_mm3, density_pm_g_mm3 : float
        Density and its uncertainty.
    moments : Moments
        In the rod's axes (origin in the big end, x to the small end, z along the eyes); what the facets hide
        of round surfaces is added.
    facets : ChordalError
    """

    source: Source
    eyes: RodEyes
    density_g_mm3: float
    density_pm_g_mm3: float
    moments: Moments
    facets: ChordalError

    @cached_property
    def rod(self) -> ConnectingRod:
        """The rod of the lever rule."""
        small = np.array([self.eyes.length_mm, 0.0, 0.0])
        try:
            return ConnectingRod.from_solid(self.moments, np.zeros(3), small)
        except ValueError as error:
            raise RecognitionError(f"no connecting rod: {error}") from None

    @property
    def about_centre(self) -> Moments:
        """Moments about the rod's centre of mass, in the directions of the rod's axes."""
        placement = np.eye(4)
        placement[:3, 3] = -self.moments.centre_mm
        return self.moments.moved(placement)

    def missed_couple(self, stroke_mm: float, speed_rad_s: float) -> tuple[float, float]:
        """Return the largest couple that two masses leave out [N·m], and its crank angle [rad].

        Raises
        ------
        ValueError
            If a rod of this length cannot have that stroke.
        """
        swing = SliderCrank(0.5 * stroke_mm, self.rod.length_mm).motion(TURN_RAD).ddtilt * speed_rad_s**2
        place = int(np.argmax(np.abs(swing)))
        couple = self.rod.couple_inertia_g_mm2 * float(swing[place]) * N_M_PER_G_MM2_S2
        return abs(couple), float(TURN_RAD[place])

    @property
    def volume_mm3(self) -> float:
        """Volume inside the true surfaces [mm³]."""
        return self.moments.mass_g / self.density_g_mm3

    @property
    def uncertainty(self) -> RodUncertainty:
        """Uncertainty from facets and density; no less than either alone.

        The small end weighs ∫ x dm / l, so the bar of the first moment about the big end counts there; that
        and the bar of the mass count at the big end.
        """
        off = self.density_pm_g_mm3 / self.density_g_mm3
        at_small = self.facets.unbalance_bar_g_mm / self.eyes.length_mm
        return RodUncertainty(
            math.hypot(self.facets.mass_bar_g, off * self.rod.mass_g),
            math.hypot(self.facets.mass_bar_g + at_small, off * self.rod.big_end_g),
            math.hypot(at_small, off * self.rod.small_end_g),
        )

    @cached_property
    def cut_halves_g(self) -> tuple[float, float]:
        """Big and small piece of the rod cut at its centre of mass; the lever rule is better [g]."""
        placed = self.source.solid.mesh.moved(X_TO_Z @ self.eyes.file_to_rod)
        slab = Slab(placed.vertices, placed.triangles, ROUNDING * placed.diagonal_mm)
        low, high = float(placed.bounds[0, 2]), float(placed.bounds[1, 2])
        cut = self.rod.centre_from_big_end_mm
        big, small = (slab.moments(part, 1.0).mass_g for part in ((low - 1.0, cut), (cut, high + 1.0)))
        share = small / (big + small)
        mass = self.rod.mass_g
        return (1.0 - share) * mass, share * mass


def measure_rod(source: Source, density_g_mm3: float, density_pm_g_mm3: float = 0.0) -> MeasuredRod:
    """Recognise a connecting rod in a checked solid and measure it.

    Parameters
    ----------
    source : Source
        The solid, as ``solid.formats.read`` gives it.
    density_g_mm3, density_pm_g_mm3 : float
        Density and its uncertainty [g/mm³].

    Raises
    ------
    RecognitionError
        If the solid is not a connecting rod.
    """
    cylinders = () if source.surfaces is None else source.surfaces.cylinders
    eyes = find_eyes(source.solid.mesh, source.moments(1.0).centre_mm, cylinders)
    moments = source.moments(density_g_mm3, eyes.file_to_rod)
    if source.exact is not None:  # measured on the true surfaces
        from autobalance.solid.cad.soundness import doubt_of

        facets = doubt_of(source.exact.gaps, density_g_mm3, eyes.file_to_rod)
    else:
        facets = chordal_error_of_mesh(source.solid.mesh, density_g_mm3, eyes.file_to_rod)
    rod = MeasuredRod(source, eyes, density_g_mm3, density_pm_g_mm3, moments + facets.missing, facets)
    rod.rod  # noqa: B018  refuses a centre of mass beyond the eyes now
    return rod


# Recognition of an assembly's bodies by their places: crank, rods, pins, bearings and pistons.
#
# A rod's big end lies on a crankpin of the crank. Its pin or bearing lies within a rod's eye. The piston
# lies around the small end. Names of parts are not trusted: they are in any language.


Role = Literal[
    "crank", "rod", "wrist_pin", "small_end_bearing", "big_end_bearing", "piston", "on_piston", "other"
]

BORE_RADII = 1.02
"""A pin or bearing lies within this many radii of the eye's bore: drawn with no play, or pressed in."""
MIN_BORE_SHARE = 0.7
"""A bearing in an eye leaves at least this share of the bore's radius free."""
WRIST_PIN_WIDTHS = 1.25
"""A wrist pin is longer than this many widths of the small end; bushes are not."""
LEAST_CRANK = 0.05
"""A crank has at least this share of the largest body's volume."""
CANDIDATES = 24
"""And is one of so many largest bodies: of a bin of equal parts none is looked at for long."""
ON_PIN = 0.05
"""The big end's axis is the crankpin's when they are apart by less than this share of the bore's radius."""
MAX_PROTRUSION_SHARE = 0.02
"""Rings and clips stand out of the piston's box by at most this share of its size."""
EQUAL_VOLUME_SHARE = 1e-3
"""Bodies whose volumes differ by less are the same part again."""


@dataclass(frozen=True, eq=False)
class AssemblyPart:
    """A body of an assembly with its role; ``rod`` is the number of the rod it belongs to, from 1.

    ``eyes`` are a rod's, ``anatomy`` a crank's.
    """

    body: BodySource
    role: Role
    rod: int | None = None
    eyes: RodEyes | None = None
    anatomy: Anatomy | None = None


def assembly_parts(bodies: Sequence[BodySource]) -> tuple[AssemblyPart, ...]:
    """Return each body of an assembly with its role.

    Parameters
    ----------
    bodies : sequence of BodySource
        All of one file, in its coordinates, by falling volume.

    Returns
    -------
    tuple of AssemblyPart
        In the order given. Of several cranks (a balance shaft may pass for one) only those that carry a rod
        are called so, if any does.
    """
    eyes = [_eyes(body) for body in bodies]
    rods = [pair for pair in eyes if pair is not None]
    least_mm3 = LEAST_CRANK * max((body.source.volume_mm3 for body in bodies), default=0.0)
    cranks = [
        _crank(body) if pair is None and body.source.volume_mm3 >= least_mm3 and place < CANDIDATES else None
        for place, (body, pair) in enumerate(zip(bodies, eyes, strict=True))
    ]
    carrying = [anatomy is not None and _carries(anatomy, rods) for anatomy in cranks]
    parts: list[AssemblyPart] = []
    number = 0
    for body, pair, anatomy, carries in zip(bodies, eyes, cranks, carrying, strict=True):
        if pair is not None:
            number += 1
            parts.append(AssemblyPart(body, "rod", number, pair))
        elif anatomy is not None and (carries or not any(carrying)):
            parts.append(AssemblyPart(body, "crank", anatomy=anatomy))
        else:
            parts.append(_beside_a_rod(body, rods))
    return tuple(_with_pistons(parts, rods))


def _eyes(body: BodySource) -> RodEyes | None:
    source = body.source
    cylinders = () if source.surfaces is None else source.surfaces.cylinders
    try:
        return find_eyes(source.solid.mesh, source.moments(1.0).centre_mm, cylinders)
    except RecognitionError:
        return None


def _crank(body: BodySource) -> Anatomy | None:
    cylinders = () if body.source.surfaces is None else body.source.surfaces.cylinders
    try:
        return recognise(body.source.solid, Overrides(crankpin_in_file=True), cylinders)
    except RecognitionError:
        return None


def _carries(anatomy: Anatomy, rods: Sequence[RodEyes]) -> bool:
    for eyes in rods:
        centre = anatomy.file_to_rotor[:3, :3] @ eyes.big.file_centre_mm + anatomy.file_to_rotor[:3, 3]
        for throw in anatomy.throws:
            pin = throw.crankpin
            low, high = pin.z_range_mm
            off = float(np.hypot(*(centre[:2] - pin.centre_mm[:2])))
            if off < ON_PIN * eyes.big.diameter_mm and low - pin.width_mm < centre[2] < high + pin.width_mm:
                return True
    return False


def _beside_a_rod(body: BodySource, rods: Sequence[RodEyes]) -> AssemblyPart:
    """Return a body with its role in a rod's eye, as wrist pin or bearing; "other" outside of every eye."""
    for number, eyes in enumerate(rods, 1):
        placed = _placed(body.source.solid.mesh, eyes)
        for eye, along in ((eyes.small, eyes.length_mm), (eyes.big, 0.0)):
            away = np.hypot(placed[:, 0] - along, placed[:, 1])
            radius = 0.5 * eye.diameter_mm
            middle = 0.0 if eye is eyes.big else eyes.offset_mm
            holds_middle = float(placed[:, 2].min()) < middle < float(placed[:, 2].max())
            if float(away.max()) > BORE_RADII * radius or not holds_middle:
                continue
            if eye is eyes.small and float(np.ptp(placed[:, 2])) > WRIST_PIN_WIDTHS * eye.width_mm:
                return AssemblyPart(body, "wrist_pin", number)
            if float(away.min()) > MIN_BORE_SHARE * radius:
                role: Role = "small_end_bearing" if eye is eyes.small else "big_end_bearing"
                return AssemblyPart(body, role, number)
    return AssemblyPart(body, "other")


def _placed(mesh: Mesh, eyes: RodEyes) -> Array:
    placed: Array = mesh.vertices @ eyes.file_to_rod[:3, :3].T + eyes.file_to_rod[:3, 3]
    return placed


def _with_pistons(parts: Sequence[AssemblyPart], rods: Sequence[RodEyes]) -> list[AssemblyPart]:
    """Return the parts, with the largest around each small end as piston and parts within it on it."""
    assembly = list(parts)
    for number, eyes in enumerate(rods, 1):
        boxes = {
            place: _box(part, eyes)
            for place, part in enumerate(assembly)
            if part.role == "other" and part.body.source.volume_mm3 > 0.0
        }
        around = [place for place, box in boxes.items() if _holds(box, eyes)]
        if not around:
            continue
        piston = max(around, key=lambda place: assembly[place].body.source.volume_mm3)
        assembly[piston] = AssemblyPart(assembly[piston].body, "piston", number)
        room = MAX_PROTRUSION_SHARE * float(np.ptp(boxes[piston], axis=0).max())
        for place, box in boxes.items():
            inside = (box[0] > boxes[piston][0] - room).all() and (box[1] < boxes[piston][1] + room).all()
            if place != piston and inside:
                assembly[place] = AssemblyPart(assembly[place].body, "on_piston", number)
    return assembly


def _box(part: AssemblyPart, eyes: RodEyes) -> Array:
    placed = _placed(part.body.source.solid.mesh, eyes)
    return np.stack([placed.min(axis=0), placed.max(axis=0)])


def _holds(box: Array, eyes: RodEyes) -> bool:
    """Return whether a box in the rod's axes is around the small end and not around the big one."""
    small = np.array([eyes.length_mm, 0.0, eyes.offset_mm])
    return bool((box[0] < small).all() and (box[1] > small).all()) and box[0][0] > 0.0
