"""What every kind of correction offers to the job file, the planner, the loop and the report."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.relaxing import Relaxing
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool

if TYPE_CHECKING:
    from autobalance.correction.overlap import Overlap
    from autobalance.correction.room import Room
    from autobalance.correction.trace import Trace

Array = NDArray[np.float64]
Prefer = Literal["simple", "least_metal", "fewest_holes", "least_inertia_change", "most_inertia_removed"]
"""What to spare, or to get rid of, among plans that reach the aim; simple: fewest different cuts (of tool and
depth), then fewest cuts, then least metal."""


class Cut(Protocol):
    """One place where metal may be changed, with one depth to choose.

    Everything is in the rotor frame. A cut belongs to one solid; passes ask for it in another depth.
    """

    @property
    def label(self) -> str:
        """Short name for messages: ``face w1-a``, ``hole 3 (⌀10)``."""
        ...

    @property
    def least_depth_mm(self) -> float:
        """Least depth that can be made, if any is made at all; 0 where any depth can."""
        ...

    @property
    def max_depth_mm(self) -> float:
        """Greatest depth that the metal and the limits allow [mm]."""
        ...

    @property
    def depth_step_mm(self) -> float:
        """Step in which the machine sets the depth; 0 where any depth can be set [mm]."""
        ...

    @property
    def limit(self) -> str:
        """What ends the depth, for messages: ``max_depth_mm = 2``, ``the shoulder's height``."""
        ...

    @property
    def limit_is_reach(self) -> bool:
        """Whether ``max_depth_mm`` is only how far was looked (``Workpiece.look`` widens that)."""
        ...

    @property
    def adds_metal(self) -> bool:
        """Whether ``tool`` is added to the crank instead of subtracted."""
        ...

    @property
    def room(self) -> Room:
        """What metal the cut takes, adds or replaces, at any depth; other kinds' cuts keep clear of it."""
        ...

    @property
    def clearance_mm(self) -> float:
        """Metal that the cut wants between its room and that of another kind's cut [mm]."""
        ...

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the rotor's moments by a cut of this depth (negative mass: metal removed)."""
        ...

    def rate(self, depth_mm: float) -> Moments:
        """Return the derivative of ``effect`` with the depth [per mm]."""
        ...

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of other metal that is put in and that the written solid does not hold."""
        ...

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to subtract from the crank (to add, for kinds that add metal)."""
        ...

    def exact_tool(self, depth_mm: float) -> Tool | None:
        """Return ``tool`` without facets, for solids that keep their true surfaces; None: no metal moves."""
        ...

    def correction(self, depth_mm: float) -> Correction:
        """Return what the machinist and the report need to know of a cut of this depth."""
        ...


SAME_PLACE_MM = 0.5
"""Distance at which a cut is the one of an earlier stage, gone on with."""


@dataclass(frozen=True, eq=False)
class EarlierCut:
    """A cut of an earlier stage: its kind, its web and where it enters, rotor frame (3,) [mm]."""

    kind: str
    web: int | None
    position_mm: Array

    def is_at(self, position_mm: Array) -> bool:
        """Tell whether another cut enters where this one does."""
        return bool(np.linalg.norm(self.position_mm - position_mm) <= SAME_PLACE_MM)


@dataclass(frozen=True, eq=False)
class Workpiece:
    """The crank as a kind of correction finds it.

    Attributes
    ----------
    solid : Solid
        In file coordinates [mm].
    anatomy : Anatomy
    faces : tuple of Face
        What ``crank.faces.find_faces`` found on the solid's mesh.
    density_g_mm3 : float
    heavy_at : two of (float, (2,) float)
        Heavy vector (rotor frame) at two places along the axis [mm, g·mm].
    look : float
        How much farther than the unbalance seems to need a kind should look for metal; 1 at first.
    service_speed_rad_s : float or None
        For the loads on what is pressed in.
    earlier : tuple of EarlierCut
        Cuts of earlier stages, which the solid has already.
    """

    solid: Solid
    anatomy: Anatomy
    faces: tuple[Face, ...]
    density_g_mm3: float
    heavy_at: tuple[tuple[float, Array], tuple[float, Array]]
    look: float = 1.0
    service_speed_rad_s: float | None = None
    earlier: tuple[EarlierCut, ...] = ()

    def made_earlier(self, kind: str, web: int | None = None) -> int:
        """Return how many cuts of a kind were made in earlier stages, in a web or anywhere."""
        return sum(each.kind == kind and web in (None, each.web) for each in self.earlier)

    def is_taken(self, kind: str, position_mm: Array) -> bool:
        """Tell whether a cut of this kind was made at a place in an earlier stage."""
        return any(each.kind == kind and each.is_at(position_mm) for each in self.earlier)

    def is_filled(self, kind: str, position_mm: Array) -> bool:
        """Tell whether a hole there is one that another kind made in an earlier stage, and filled maybe."""
        return any(each.kind != kind and each.is_at(position_mm) for each in self.earlier)

    @property
    def need_g_mm(self) -> float:
        """Unbalance to move, at most [g·mm]."""
        return sum(float(np.linalg.norm(vector)) for _, vector in self.heavy_at)


@dataclass(frozen=True, eq=False)
class Offer:
    """Cuts that a kind offers on a workpiece, what they have to share, and notes for the user."""

    cuts: tuple[Cut, ...]
    shared: tuple[SharedDepth, ...] = ()
    same_depth: bool = False
    apart: tuple[Apart, ...] = ()
    counts: tuple[Count, ...] = ()
    varieties: tuple[Variety, ...] = ()
    notes: tuple[str, ...] = ()
    overlaps: tuple[Overlap, ...] = ()


@dataclass(frozen=True)
class SharedDepth:
    """Two cuts, by their places in a list, whose depths together must not exceed ``most_mm``."""

    first: int
    second: int
    most_mm: float


@dataclass(frozen=True)
class Apart:
    """Two cuts of which, where both are made, neither may be deeper than ``most_mm``; below 0: never both."""

    first: int
    second: int
    most_mm: float


@dataclass(frozen=True)
class Count:
    """Cuts of which at most ``most`` may be made; ``limit`` says so: ``max_holes = 6 in web 2``."""

    members: tuple[int, ...]
    most: int
    limit: str


@dataclass(frozen=True)
class Variety:
    """Groups of cuts of which at most ``most`` may be used: drills, for instance; ``limit`` says so."""

    groups: tuple[tuple[int, ...], ...]
    most: int
    limit: str


def setting_of(cut: Cut) -> str:
    """Return what a machine is set up with for a cut, beside its depth: ``drill 8``.

    Cuts of one setting and depth are alike in the workshop; where they have no ``setting``, all are of one.
    """
    return str(getattr(cut, "setting", type(cut).__name__))


@dataclass(frozen=True, eq=False)
class Correction:
    """One finished correction, as the report lists it.

    ``change`` is the exact change of the rotor's moments; ``details`` holds what the kind needs to be
    machined, with JSON values and keys that end in their unit; ``rate`` is what one more millimetre of depth
    would change (the loop fills it in where the kind does not).
    """

    kind: str
    face: str | None
    web: int | None
    position_mm: Array
    depth_mm: float
    change: Moments
    removed_volume_mm3: float
    details: dict[str, Any] = field(default_factory=dict)
    rate: Moments | None = None


# --- the contract of a kind ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Limits:
    """What a job asks of one kind of correction: a frozen dataclass, its fields the keys of its table."""


L = TypeVar("L", bound=Limits)


class Figures(Protocol):
    """How a sheet writes numbers, in the user's units."""

    @property
    def diameter_digits(self) -> int:
        """Decimals of a diameter."""
        ...

    @property
    def mass(self) -> str:
        """Name of the unit of mass."""
        ...

    def mm(self, value: float | None, digits: int | None = None) -> str:
        """Return a length [mm]."""
        ...

    def g(self, value: float | None) -> str:
        """Return a mass [g]."""
        ...


Item = Mapping[str, Any]
"""A correction as the report lists it: `Correction` with its details as JSON values."""


class Kind(ABC, Generic[L]):
    """A kind of correction: one class in one file, registered by one line in `autobalance.correction`.

    Job keys, the JSON Schema, the documentation's table, comparisons, sheets and pages are derived from what
    it says here; nothing outside of ``autobalance.correction`` asks which kind a cut is.

    Attributes
    ----------
    name : str
        As a job's ``method`` has it; its limits stand in ``[correction.<name>]``.
    verb, noun : str
        For people: ``drill``, ``Drilled hole``.
    datum : str
        From where its depths count, for the machinist.
    limits : type
        A frozen dataclass derived from `Limits`, each field with a default.
    efforts : int
        How many ever wider offers it can make.
    needs_faces : bool
        Whether its cuts begin at planar faces, which have to be found first.
    adds_metal : bool
        Whether its cuts put metal on instead of taking it.
    has_axis : bool
        Whether each of its cuts has a place and an axis of its own, as holes have.
    is_round_the_rim : bool
        Whether its cuts go all around, so that they have no angle.
    finishes : bool
        Whether it can make the last cuts on the machine, where some unbalance is left for these.
    mixed_with : tuple of str
        Kinds that make up what it cannot reach alone; ``compare`` tries it with each.
    remedy : Limits or None
        Usual limits of a single cut to propose where the kinds of a job fall short.
    pressed_in : (str, str) or None
        Keys of the details that hold mass [g] and centre (3,) [mm] of what is pressed in.
    """

    name: ClassVar[str]
    verb: ClassVar[str]
    noun: ClassVar[str]
    datum: ClassVar[str]
    limits: ClassVar[type[Limits]]
    efforts: ClassVar[int] = 1
    needs_faces: ClassVar[bool] = False
    adds_metal: ClassVar[bool] = False
    has_axis: ClassVar[bool] = False
    is_round_the_rim: ClassVar[bool] = False
    finishes: ClassVar[bool] = False
    mixed_with: ClassVar[tuple[str, ...]] = ()
    remedy: ClassVar[Limits | None] = None
    pressed_in: ClassVar[tuple[str, str] | None] = None

    # --- cuts -------------------------------------------------------------------------------------------

    @abstractmethod
    def offer(self, work: Workpiece, limits: L, effort: int) -> Offer:
        """Return the cuts that limits allow on a workpiece, and the rules they keep among themselves.

        Raises
        ------
        CorrectionError
            If no cut fits anywhere.
        """

    def relaxing(self, limits: L) -> Sequence[Relaxing]:
        """Return in which ways these limits might be widened, where they fall short."""
        del limits
        return ()

    def remedy_most_g_mm(self, work: Workpiece) -> float:
        """Return what no cut that ``remedy`` offers moves more than, told without looking for its place."""
        del work
        return math.inf

    def remedy_text(self, cut: Any) -> str:
        """Return what to propose of a cut that ``remedy`` offered."""
        return str(cut.label)

    def remedy_keys(self, cut: Any) -> Mapping[str, Any]:
        """Return what the kind's table in a job needs for that cut alone."""
        del cut
        return {} if self.remedy is None else asdict(self.remedy)

    # --- what is told ---------------------------------------------------------------------------------------

    @abstractmethod
    def instruction(self, item: Item, figures: Figures) -> str:
        """Return what the machinist is to do, in one line."""

    @abstractmethod
    def size(self, item: Item) -> str:
        """Return what the machinist sets besides the depth, in mm; nothing where the depth is all."""

    def wall_left_mm(self, made: Sequence[Correction], anatomy: Anatomy) -> float | None:
        """Return the least metal left beside corrections of this kind; None where they weaken nothing."""
        del anatomy
        walls = [float(each.details["wall_left_mm"]) for each in made if "wall_left_mm" in each.details]
        return min(walls, default=None)

    def trace(self, item: Item) -> Trace | None:
        """Return what a listed correction must have left behind, so that it can be verified; None: not known.

        Raises
        ------
        FormatError
            If the list has not what that takes.
        """
        del item
        return None

    def face_depths_mm(self, work: Workpiece, rims: Sequence[Face]) -> Mapping[str, float]:
        """Return how deep faces and rims, by their ids, may be cut by default where metal ends that."""
        del work, rims
        return {}
