"""What every kind of correction offers to the job file, the planner, the loop and the report."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from autobalance.correction.contract import (
    Apart,
    Correction,
    Count,
    Cut,
    EarlierCut,
    Figures,
    Item,
    Limits,
    SharedDepth,
    Variety,
)
from autobalance.correction.relaxing import Relaxing
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

if TYPE_CHECKING:
    from autobalance.correction.machining import Operation
    from autobalance.correction.overlap import Overlap
    from autobalance.correction.trace import Trace
    from autobalance.solid.csg.shape import Shape


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
        Multiple of the estimated need in which a kind searches for metal; 1 at first.
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
        """Return whether a cut of this kind was made at a place in an earlier stage."""
        return any(each.kind == kind and each.is_at(position_mm) for each in self.earlier)

    def is_filled(self, kind: str, position_mm: Array) -> bool:
        """Return whether a hole there is one that another kind made in an earlier stage, and filled maybe."""
        return any(each.kind != kind and each.is_at(position_mm) for each in self.earlier)

    @property
    def need_g_mm(self) -> float:
        """Unbalance to move, at most [g·mm]."""
        return sum(float(np.linalg.norm(vector)) for _, vector in self.heavy_at)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidate cuts of a kind on a workpiece, what they have to share, and notes for the user.

    ``equal``: one tool and one depth, in as few cuts as keep the tolerance, wherever such are found.
    """

    cuts: tuple[Cut, ...]
    shared: tuple[SharedDepth, ...] = ()
    same_depth: bool = False
    apart: tuple[Apart, ...] = ()
    counts: tuple[Count, ...] = ()
    varieties: tuple[Variety, ...] = ()
    notes: tuple[str, ...] = ()
    overlaps: tuple[Overlap, ...] = ()
    equal: bool = False


L = TypeVar("L", bound=Limits)
KEPT_MM = 0.05
"""How far the place of a cut that is kept may be off: a slightly changed crank."""
ENTRY_MM = 1.0
"""How far along its axis a kept hole or pocket may begin elsewhere."""


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
    search_levels : int
        Number of search levels, from few candidates to all.
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
    offers_all : bool
        Whether one look finds all its cuts wherever the unbalance lies: faces and rims.
    pressed_in : (str, str) or None
        Keys of the details that hold mass [g] and centre (3,) [mm] of what is pressed in.
    """

    name: ClassVar[str]
    verb: ClassVar[str]
    noun: ClassVar[str]
    datum: ClassVar[str]
    limits: ClassVar[type[Limits]]
    search_levels: ClassVar[int] = 1
    needs_faces: ClassVar[bool] = False
    adds_metal: ClassVar[bool] = False
    has_axis: ClassVar[bool] = False
    is_round_the_rim: ClassVar[bool] = False
    finishes: ClassVar[bool] = False
    mixed_with: ClassVar[tuple[str, ...]] = ()
    remedy: ClassVar[Limits | None] = None
    pressed_in: ClassVar[tuple[str, str] | None] = None
    offers_all: ClassVar[bool] = False

    # --- cuts -------------------------------------------------------------------------------------------

    @abstractmethod
    def offer(self, work: Workpiece, limits: L, search_level: int) -> Candidates:
        """Return the cuts that limits allow on a workpiece, and the rules they keep among themselves.

        Raises
        ------
        CorrectionError
            If no cut fits anywhere.
        """

    def kept_limits(self, limits: L, item: Item, around_deg: float) -> L:
        """Return limits that leave little but the place of a listed cut, so that it is found soon."""
        if not hasattr(limits, "sectors_deg") or item.get("angle_deg") is None:
            return limits
        angle_deg = float(item["angle_deg"])
        return replace(limits, **{"sectors_deg": ((angle_deg - around_deg, angle_deg + around_deg),)})

    def at_place(self, work: Workpiece, limits: L, item: Item) -> Sequence[Cut]:
        """Return the cuts that may be made where a listed one was; none where a kind only searches.

        On a crank that has changed a little the places that are tried are others than they were.

        Raises
        ------
        CorrectionError
            If no cut fits there.
        """
        del work, limits, item
        return ()

    def is_kept(self, cut: Any, item: Item) -> bool:
        """Return whether a candidate is the cut that an earlier report lists, at whatever depth."""
        shown = cut.correction(cut.max_depth_mm)
        near = np.linalg.norm(shown.position_mm - np.array(item["position_mm"], dtype=np.float64))
        return bool(shown.web == item.get("web") and shown.face == item.get("face") and near <= KEPT_MM)

    def relaxing(self, limits: L) -> Sequence[Relaxing]:
        """Return in which ways these limits might be widened, where they fall short."""
        del limits
        return ()

    def remedy_most_g_mm(self, work: Workpiece) -> float:
        """Return an upper bound on the unbalance that one cut of ``remedy`` moves, without searching."""
        del work
        return math.inf

    def remedy_text(self, cut: Any) -> str:
        """Return what to propose of a cut that ``remedy`` offered."""
        return str(cut.label)

    def remedy_keys(self, cut: Any) -> Mapping[str, Any]:
        """Return what the kind's table in a job needs for that cut alone."""
        del cut
        return {} if self.remedy is None else asdict(self.remedy)

    def heavier(self) -> Sequence[L]:
        """Return limits with which it might make up for counterweights that are too light, the best first."""
        return ()

    def heavier_words(self, cuts: Sequence[tuple[Any, float]]) -> tuple[str, Mapping[str, Any]]:
        """Return what cuts of `heavier`, each with its depth [mm], are, and the keys for them."""
        return ", ".join(str(cut.label) for cut, _ in cuts), {}

    # --- what is reported ---

    @abstractmethod
    def instruction(self, item: Item, figures: Figures) -> str:
        """Return what the machinist is to do, in one line."""

    def label(self, item: Item) -> str:
        """Return a short name of the cut for lists and trees: ``drill ⌀12``."""
        face = "" if item.get("face") is None else f" {item['face']}"
        return f"{self.verb}{face}"

    def machining(self, item: Item) -> Operation | str | None:
        """Return how a listed correction is cut on a machine tool; or why not; None: there is nothing to cut.

        Raises
        ------
        FormatError
            If the list has not what that takes.
        """
        del item
        return "metal is added, not cut" if self.adds_metal else "no program is known for it"

    @abstractmethod
    def size(self, item: Item) -> str:
        """Return what is set besides the depth, lengths with their unit; nothing where that is all."""

    def drawn(self, item: Item) -> Shape | None:
        """Return the tool's body of a listed correction, rotor frame [mm], exact; None: it is not known."""
        del item
        return None

    def wall_left_mm(self, corrections: Sequence[Correction], anatomy: Anatomy) -> float | None:
        """Return the least metal left beside corrections of this kind; None where they weaken nothing."""
        del anatomy
        walls = [
            float(each.details["wall_left_mm"]) for each in corrections if "wall_left_mm" in each.details
        ]
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
