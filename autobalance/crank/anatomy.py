"""The parts of a crankshaft, in the rotor frame: z is the crank axis, x points to crankpin 1."""

from __future__ import annotations

import math
from dataclasses import field, replace
from typing import Literal

import numpy as np

from autobalance.crank.datums import Datums, ScanFit
from autobalance.types import Array, Indices
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

# The parts of a crankshaft, in the rotor frame: z is the crank axis, x points to crankpin 1.


CylinderKind = Literal["outside", "bore"]
CylinderRole = Literal["main_journal", "crankpin", "collar", "shaft", "web", "none"]
DoubtSubject = Literal["main_journal", "crankpin", "axis"]
PIN_SETTINGS = {
    "crankshaft.crankpin_in_file = true": True,
    "crankshaft.crankpin_in_file = false": False,
}
"""Lines of a job that take another reading of a crank whose crankpin may be in the file, or not."""
ON_AXIS_MM = 1e-3
"""The middle of a cylinder nearer to the axis than this has no angle: files are rounded to as much."""


@dataclass(frozen=True, eq=False)
class Pin:
    """A bare cylinder parallel to the crank axis: a main journal or a crankpin.

    ``centre_mm`` (3,) is the middle of the bare cylinder, ``width_mm`` its length between webs or fillets.
    """

    centre_mm: Array
    diameter_mm: float
    width_mm: float

    @property
    def z_range_mm(self) -> tuple[float, float]:
        """Smallest and largest z of the bare cylinder [mm]."""
        half = 0.5 * self.width_mm
        return float(self.centre_mm[2]) - half, float(self.centre_mm[2]) + half


@dataclass(frozen=True, eq=False)
class MainJournal(Pin):
    """A main journal; numbered from 1 along increasing z."""

    number: int


@dataclass(frozen=True, eq=False)
class Throw:
    """A crankpin with its crank radius and angle; numbered from 1 along increasing z.

    ``crank_radius_mm`` is the distance of the crankpin from the axis (half the stroke), ``angle_rad`` its
    angle from throw 1, counter-clockwise seen from +z.
    """

    number: int
    crank_radius_mm: float
    angle_rad: float
    crankpin: Pin

    @property
    def angle_deg(self) -> float:
        """Angle from throw 1, in [0, 360)."""
        return wrapped_deg(math.degrees(self.angle_rad))

    @property
    def direction(self) -> Array:
        """Unit vector (2,) from the axis to the crankpin."""
        x, y = self.crankpin.centre_mm[:2]
        return np.array([x, y]) / self.crank_radius_mm


@dataclass(frozen=True)
class CounterweightOutline:
    """A counterweight's largest distance from the axis, the angle that its rim spans, and its thickness.

    ``skew_rad`` is how far the middle of that angle lies from the direction away from the web's crankpins,
    counter-clockwise seen from +z.
    """

    rim_radius_mm: float
    fan_angle_rad: float
    thickness_mm: float
    skew_rad: float = 0.0

    @property
    def fan_angle_deg(self) -> float:
        """Angle that the rim spans, at most 360; as reports have it."""
        return min(math.degrees(self.fan_angle_rad), 360.0)

    @property
    def skew_deg(self) -> float:
        return math.degrees(self.skew_rad)


@dataclass(frozen=True)
class Web:
    """A web with its counterweight if it has one; numbered from 1 along increasing z."""

    number: int
    z_min_mm: float
    z_max_mm: float
    counterweight: bool
    outline: CounterweightOutline | None = None


@dataclass(frozen=True, eq=False)
class Face:
    """A largest connected set of triangles on one plane (or cylinder) that a correction can use.

    Attributes
    ----------
    id : str
        Stays the same from run to run on the same file.
    web : int or None
        Number of the web it belongs to.
    normal : (3,) float
        Outward, rotor frame.
    centroid_mm : (3,) float
        Centroid of its area, rotor frame; ``normal @ centroid_mm`` is the plane's height.
    area_mm2 : float
    triangles : (k,) int64
        Rows of the mesh's triangles that make it up.
    spread_mm : float
        How far its vertices lie from the plane, at most.
    surfaces : tuple of int
        Numbers of the exact solid's faces that make it up, where the file keeps true surfaces.
    rms_mm, flatness_mm : float or None
        Of a scanned face: root mean square of its points' distance from the fitted plane, and the distance of
        the two planes that hold 95 % of it; None where it was drawn.
    centroid_pm_mm : (3,) float or None
    normal_pm_deg : float or None
        Standard errors of a scanned face.
    """

    id: str
    kind: Literal["plane", "cylinder"]
    web: int | None
    area_mm2: float
    normal: Array
    centroid_mm: Array
    triangles: Indices
    spread_mm: float
    surfaces: tuple[int, ...] = ()
    rms_mm: float | None = None
    flatness_mm: float | None = None
    centroid_pm_mm: Array | None = None
    normal_pm_deg: float | None = None


@dataclass(frozen=True, eq=False)
class Cylinder(Pin):
    """A bare cylinder or bore along the crank axis, recognised as any feature or none.

    ``number`` is that of the journal or crankpin that it was taken for, else None.
    """

    kind: CylinderKind
    role: CylinderRole
    number: int | None = None

    @property
    def offset_mm(self) -> float:
        """Distance from the crank axis."""
        return math.hypot(float(self.centre_mm[0]), float(self.centre_mm[1]))

    @property
    def angle_deg(self) -> float:
        """Angle of its middle from throw 1, in [0, 360); 0 for one on the axis."""
        if self.offset_mm < ON_AXIS_MM:
            return 0.0
        return wrapped_deg(math.degrees(math.atan2(float(self.centre_mm[1]), float(self.centre_mm[0]))))


@dataclass(frozen=True, eq=False)
class Doubt:
    """A choice that the rules of recognition leave open: what was taken, and what could be meant instead.

    ``number`` counts the journals or crankpins that ``about`` names; ``setting`` is the line of a job that
    takes the other reading.
    """

    about: DoubtSubject
    number: int
    chosen: Pin
    other: Pin
    setting: str

    @property
    def pin_in_file(self) -> bool | None:
        """Value of ``crankpin_in_file`` in the other reading, if that is its setting, else None."""
        return PIN_SETTINGS.get(self.setting)


@dataclass(frozen=True, eq=False)
class CylinderFound(Pin):
    """The file's cylinder or bore nearest to a typed main journal or crankpin, fitted to its surface.

    Attributes
    ----------
    hint : int
        Place of the typed one in its list.
    typed_mm : (3,) float
        Its typed centre, rotor frame.
    typed_diameter_mm : float or None
    along_mm : float
        Distance of the middles along the axis; 0 where the typed stretch lies within the surface, or exceeds
        it by as much at both ends, as fillets do.
    within_mm : float
        Both agree within this: three times the surface's roughness at least.
    centre_in_file_mm : (3,) float
    """

    kind: Literal["outside", "bore"]
    hint: int
    typed_mm: Array
    typed_diameter_mm: float | None
    along_mm: float
    within_mm: float
    centre_in_file_mm: Array

    @property
    def aside_mm(self) -> Array:
        """Distance (2,) of the found centre from the typed one across the axis."""
        aside: Array = self.centre_mm[:2] - self.typed_mm[:2]
        return aside

    @property
    def offset_mm(self) -> float:
        """Length of ``aside_mm``."""
        return math.hypot(*self.aside_mm)


@dataclass(frozen=True, eq=False)
class AxisFound:
    """The line through the middles of the file's main journals, ``centres_mm`` (n, 3) in the rotor frame.

    ``diameter_mm`` is the widest one's; a typed axis agrees with the line within ``within_mm``.
    """

    centres_mm: Array
    diameter_mm: float
    within_mm: float

    @property
    def z_mm(self) -> float:
        """Middle of the main journals."""
        return float(self.centres_mm[:, 2].mean())

    @property
    def offset_mm(self) -> float:
        """Largest distance of a middle from the z axis."""
        return float(np.hypot(*self.centres_mm[:, :2].T).max())

    def at(self, z_mm: float) -> Array:
        """Return the place (2,) of the line at a height."""
        z = self.centres_mm[:, 2] - self.z_mm
        slope = np.zeros(2) if np.ptp(z) < ON_AXIS_MM else z @ self.centres_mm[:, :2] / (z @ z)
        place: Array = self.centres_mm[:, :2].mean(axis=0) + (z_mm - self.z_mm) * slope
        return place


@dataclass(frozen=True, eq=False)
class Typed:
    """Crank axis, journals and crankpins as typed in a job, with what the file has there.

    ``main_journals`` and ``crankpins`` are numbered as the anatomy's, None if none was typed; ``axis`` is
    what its point and direction are compared with. ``left_out`` are texts on cylinders within the webs that
    are neither among the typed journals nor the typed crankpins.
    """

    axis_point: bool = False
    axis_direction: bool = False
    axis: AxisFound | None = None
    main_journals: tuple[CylinderFound | None, ...] | None = None
    crankpins: tuple[CylinderFound | None, ...] | None = None
    left_out: tuple[str, ...] = ()

    @property
    def is_axis(self) -> bool:
        """Whether the axis was typed: a point, a direction or both."""
        return self.axis_point or self.axis_direction

    @property
    def is_bored(self) -> bool:
        """Whether a typed journal or crankpin is a bore in the file, within its web."""
        found = (*(self.main_journals or ()), *(self.crankpins or ()))
        return any(each is not None and each.kind == "bore" for each in found)


@dataclass(frozen=True, eq=False)
class Anatomy:
    """A recognised crankshaft.

    ``file_to_rotor`` (4, 4) takes file coordinates (in mm) to the rotor frame. ``journal_misalignment_mm`` is
    the largest distance of a main journal's centre from the common axis. ``datums`` is None if they were not
    looked for. ``scan`` is None if the surface is drawn, not scanned. ``cylinders`` are all those along the
    axis, by increasing z. ``doubts`` are the other possible readings; ``typed`` are the features of the file
    at the job's own entries.
    """

    file_to_rotor: Array
    main_journals: tuple[MainJournal, ...]
    throws: tuple[Throw, ...]
    webs: tuple[Web, ...]
    journal_misalignment_mm: float
    datums: Datums | None = None
    scan: ScanFit | None = None
    cylinders: tuple[Cylinder, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    typed: Typed = field(default_factory=Typed)

    @property
    def rotor_to_file(self) -> Array:
        """The inverse of ``file_to_rotor`` (4, 4), a rigid motion."""
        turn, shift = self.file_to_rotor[:3, :3], self.file_to_rotor[:3, 3]
        back = np.eye(4)
        back[:3, :3] = turn.T
        back[:3, 3] = -turn.T @ shift
        return back

    def throws_of(self, web: Web) -> tuple[Throw, ...]:
        """Return the throws whose crankpins a web carries: one, or two between which it is.

        Of a web drawn alone that is the one whose bore is in it.
        """
        low, high = web.z_min_mm, web.z_max_mm
        within = [throw for throw in self.throws if low < float(throw.crankpin.centre_mm[2]) < high]
        if within:
            return tuple(within)
        middle = 0.5 * (web.z_min_mm + web.z_max_mm)
        pins: list[tuple[float, Throw | None]] = [
            *((float(throw.crankpin.centre_mm[2]), throw) for throw in self.throws),
            *(
                (z, None)
                for z in (float(journal.centre_mm[2]) for journal in self.main_journals)
                if not low < z < high
            ),
        ]
        below = max((pin for pin in pins if pin[0] < middle), key=lambda pin: pin[0], default=(0.0, None))
        above = min((pin for pin in pins if pin[0] >= middle), key=lambda pin: pin[0], default=(0.0, None))
        return tuple(throw for _, throw in (below, above) if throw is not None)


@dataclass(frozen=True, eq=False)
class PinHint:
    """A journal or crankpin as a job gives it: file axes, mm; ``width_mm`` may be unknown."""

    centre_mm: Array
    diameter_mm: float | None = None
    width_mm: float | None = None


@dataclass(frozen=True, eq=False)
class Overrides:
    """A job's statements about the anatomy in place of recognition, or in aid of it; file axes, mm.

    ``crankpin_in_file`` None: not known; crankpins are looked for first, then bores for them.
    """

    axis_point_mm: Array | None = None
    axis_direction: Array | None = None
    crankpins: tuple[PinHint, ...] | None = None
    main_journals: tuple[PinHint, ...] | None = None
    crankpin_in_file: bool | None = True


# A crank of one throw with main journal and crankpin in each other's place.


def exchanged(anatomy: Anatomy) -> Anatomy:
    """Return the anatomy about the line of throw 1's crankpin, its main journal 1 being the crankpin.

    Its axis points as before. Webs keep their counterweights, cylinders and doubts are left out: it is for a
    verdict on the other reading of a doubt about the axis.

    Raises
    ------
    ValueError
        If there is not one throw.
    """
    if len(anatomy.throws) != 1:
        raise ValueError(f"{len(anatomy.throws)} throws; main journal and crankpin are exchanged with one")
    pin, journal = anatomy.throws[0].crankpin, anatomy.main_journals[0]
    arm = journal.centre_mm[:2] - pin.centre_mm[:2]
    radius = math.hypot(*arm)
    x, y = arm / radius
    turn = np.eye(4)
    turn[:2, :2] = [[x, y], [-y, x]]
    turn[:3, 3] = -turn[:3, :3] @ np.array([*pin.centre_mm[:2], journal.centre_mm[2]])
    up = float(turn[2, 3])

    def moved(one: Pin) -> np.ndarray:
        return turn[:3, :3] @ one.centre_mm + turn[:3, 3]

    return replace(
        anatomy,
        file_to_rotor=turn @ anatomy.file_to_rotor,
        main_journals=(MainJournal(moved(pin), pin.diameter_mm, pin.width_mm, 1),),
        throws=(Throw(1, radius, 0.0, Pin(moved(journal), journal.diameter_mm, journal.width_mm)),),
        webs=tuple(
            replace(web, z_min_mm=web.z_min_mm + up, z_max_mm=web.z_max_mm + up) for web in anatomy.webs
        ),
        cylinders=(),
        doubts=(),
    )
