"""Heavy-metal slugs: limits, and the holes that they fill."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated, Any

from autobalance.correction import relaxing
from autobalance.correction.contract import Correction, Envelope, Limits, bar
from autobalance.correction.cut import WalledCut
from autobalance.correction.holes.bores import BlindHole, blind_holes, fitting_mm
from autobalance.correction.holes.hole import FLAT_BOTTOM_RAD, Hole
from autobalance.correction.holes.sites import in_sectors
from autobalance.correction.holes.surface import Axis, Surface
from autobalance.correction.kind import Workpiece
from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

# Slugs in whichever hole, and slugs for existing blind holes.


class PressedIn(WalledCut, ABC):
    """A cut into which a slug is pressed."""

    limits: SlugLimits
    length_mm: float
    service_speed_rad_s: float | None
    depth_step_mm: float = 0.0
    limit: str = "the lengths of slugs in stock"

    @property
    @abstractmethod
    def slug(self) -> Moments:
        """Moments of the slug."""

    def filling(self, hole: Hole, end_mm: float) -> Moments:
        """Return the moments of a slug in a hole, that ends at a depth."""
        density = self.limits.density_kg_m3 * G_PER_MM3_PER_KG_M3
        return hole.column(end_mm - self.length_mm, end_mm).scaled(density)

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of the slug, which the written solid does not hold."""
        return self.slug if depth_mm > 0.0 else Moments.zero()

    def details(self, diameter_mm: float, axis: Axis, **own: Any) -> dict[str, Any]:
        """Return the details of any slug that the report lists, and this one's own."""
        slug, limits = self.slug, self.limits
        return {
            "direction": limits.direction,
            "diameter_mm": diameter_mm,
            "length_mm": self.length_mm,
            "density_kg_m3": limits.density_kg_m3,
            "slug_mass_g": slug.mass_g,
            "slug_centre_mm": [float(v) for v in slug.centre_mm],
            "entry_radius_mm": math.hypot(axis.entry_mm[0], axis.entry_mm[1]),
            "inward": [float(v) for v in axis.inward],
            "point_angle_deg": math.degrees(2.0 * FLAT_BOTTOM_RAD),
            **own,
            "centrifugal_load_N": load_n(slug, self.service_speed_rad_s),
        }


def load_n(slug: Moments, service_speed_rad_s: float | None) -> float | None:
    """Return the force m r Ω² on a slug at service speed [N]."""
    if service_speed_rad_s is None:
        return None
    return math.hypot(*slug.first_g_mm[:2]) * 1e-6 * service_speed_rad_s**2


@dataclass(frozen=True, eq=False)
class FillCut(PressedIn):
    """One slug that may be pressed into an existing blind hole (a `Cut` without a cut)."""

    hole: BlindHole
    radius_mm: float
    length_mm: float
    limits: SlugLimits
    service_speed_rad_s: float | None

    @property
    def setting(self) -> str:
        """The slug, which needs no bore."""
        return f"slug {2.0 * self.radius_mm:g} x {self.length_mm:g} in a hole"

    @property
    def label(self) -> str:
        return f"slug ⌀{2.0 * self.radius_mm:g} × {self.length_mm:g} in the hole in web {self.hole.web}"

    @property
    def web(self) -> int:
        return self.hole.web

    @property
    def diameter_mm(self) -> float:
        return 2.0 * self.radius_mm

    @property
    def max_depth_mm(self) -> float:
        return self.length_mm

    @property
    def least_depth_mm(self) -> float:
        """The slug's length: it is whole or not there."""
        return self.length_mm

    @property
    def slug(self) -> Moments:
        """Moments of the slug, which sits on the shoulder of the hole."""
        zero = Moments.zero()
        round_ = Hole(self.hole.axis, self.radius_mm, FLAT_BOTTOM_RAD, 0.0, zero, 0.0, 0.0)
        return self.filling(round_, self.hole.shoulder_mm)

    @property
    def envelope(self) -> Envelope:
        """Envelope of the slug at any depth."""
        axis, end = self.hole.axis, self.hole.shoulder_mm
        top, bottom = (axis.entry_mm + tau * axis.inward for tau in (end - self.length_mm, end))
        return bar(top, bottom, 0.0 * axis.inward, self.radius_mm)

    def effect(self, depth_mm: float) -> Moments:
        return self.pressed_in(depth_mm)

    def rate(self, depth_mm: float) -> Moments:
        """Return the mean slope: the depth is not free."""
        return self.slug.scaled(1.0 / self.length_mm)

    def tool(self, depth_mm: float) -> Solid:
        """Return nothing: no metal goes."""
        return Solid.nothing()

    def exact_tool(self, depth_mm: float) -> None:
        """Return nothing: no metal goes."""

    def correction(self, depth_mm: float) -> Correction:
        return Correction(
            kind="slug",
            face=None,
            web=self.hole.web,
            position_mm=self.hole.axis.entry_mm,
            depth_mm=self.hole.shoulder_mm,
            change=self.slug,
            removed_volume_mm3=0.0,
            rate=Moments.zero(),  # nothing is cut
            details=self.details(
                2.0 * self.radius_mm, self.hole.axis, fills_a_hole=True, entry_lift_mm=0.0, point_mm=0.0
            ),
            axis=self.hole.axis.inward,
        )


def fills(work: Workpiece, surface: Surface, limits: SlugLimits) -> list[FillCut]:
    """Return the slugs that fit into existing blind holes."""
    return [
        FillCut(hole, 0.5 * diameter, length, limits, work.service_speed_rad_s)
        for web in work.anatomy.webs
        for hole in blind_holes(surface, web, limits.direction)
        if in_sectors(math.atan2(*hole.axis.entry_mm[1::-1]), limits.sectors_deg)
        for diameter in fitting_mm(limits.diameters_mm, hole.radius_mm)
        for length in sorted(set(limits.lengths_mm))
        if length <= hole.shoulder_mm - hole.top_mm
    ]


# Limits of heavy-metal slugs.


@dataclass(frozen=True)
class SlugLimits(Limits):
    """Limits of heavy-metal slugs. The defaults are ours: no standard gives them.

    Attributes
    ----------
    direction : "axial" or "radial"
    diameters_mm, lengths_mm : tuple of float
        Slugs available: every diameter in every length.
    density_kg_m3 : float
        17 000 is that of usual tungsten alloy.
    max_slugs : int
        Number of slugs in the whole crank, at most.
    min_wall_mm : float
        Wall from the bore to any surface except the one it enters; towards the rim this is the wall that
        holds an axial slug against the centrifugal force. Between slugs too.
    sectors_deg : tuple of (float, float)
        Sectors for the axes of slugs, as for drilled holes.
    fill : bool
        Blind holes that exist, of a slug's diameter to 2 %, may be filled.
    """

    direction: relaxing.Direction = "axial"
    diameters_mm: Annotated[tuple[float, ...], POSITIVE] = (25.4,)
    lengths_mm: Annotated[tuple[float, ...], POSITIVE] = (12.7, 25.4)
    density_kg_m3: Annotated[float, POSITIVE] = 17000.0
    max_slugs: Annotated[int, COUNTED] = 4
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 4.0
    sectors_deg: relaxing.Sectors = relaxing.ALL_AROUND
    fill: bool = False

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        relaxing.refuse_direction("slug", self.direction)
        relaxing.refuse_sizes("slug", "diameters_mm", "diameter", self.diameters_mm)
        relaxing.refuse_sectors("slug", self.sectors_deg)
        relaxing.refuse_sizes("slug", "lengths_mm", "length", self.lengths_mm)
        relaxing.refuse_out_of_range("slug", self)

    @property
    def settles_webs(self) -> bool:
        """Whether a single slug is allowed, which one web alone can hold."""
        return self.max_slugs == 1
