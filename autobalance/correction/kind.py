"""Interface of a kind of correction to the job file, the planner, the loop and the report."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, replace
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
from autobalance.errors import CorrectionError
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.correction.machining import Operation
    from autobalance.correction.overlap import Overlap
    from autobalance.correction.trace import Trace
    from autobalance.solid.csg.shape import Shape


@dataclass(frozen=True, eq=False)
class Workpiece:
    """The crank as a kind of correction works on it.

    Attributes
    ----------
    solid : Solid
        In file coordinates [mm].
    anatomy : Anatomy
    faces : tuple of Face
        Faces of the solid's mesh, from ``crank.faces.find_faces``.
    density_g_mm3 : float
    heavy_at : two of (float, (2,) float)
        Heavy vector (rotor frame) at two places along the axis [mm, g·mm].
    look : float
        Multiple of the estimated need in which a kind searches for metal; 1 at first.
    service_speed_rad_s : float or None
        For the loads on pressed-in metal.
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
        """Return the number of cuts of a kind in earlier stages, in a web or anywhere."""
        return sum(each.kind == kind and web in (None, each.web) for each in self.earlier)

    def is_taken(self, kind: str, position_mm: Array) -> bool:
        """Return whether a cut of this kind was made at a place in an earlier stage."""
        return any(each.kind == kind and each.is_at(position_mm) for each in self.earlier)

    def is_filled(self, kind: str, position_mm: Array) -> bool:
        """Return whether another kind made a cut at a place in an earlier stage, and perhaps filled it."""
        return any(each.kind != kind and each.is_at(position_mm) for each in self.earlier)

    @property
    def need_g_mm(self) -> float:
        """Unbalance to move, at most [g·mm]."""
        return sum(float(np.linalg.norm(vector)) for _, vector in self.heavy_at)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidate cuts of a kind on a workpiece, their rules, and notes for the user.

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


class ListedCutError(CorrectionError):
    """A cut that a job lists and that has no place: ``item`` is the cut as it is listed."""

    def __init__(self, item: Item, why: str) -> None:
        super().__init__(why)
        self.item = item


L = TypeVar("L", bound=Limits)
KEPT_MM = 0.05
"""Tolerance of the place of a kept cut, on a slightly changed crank."""
SAME_DEPTH_MM = 2e-3
"""Depth by which a listed cut may exceed a limit: those of a plan are used up to the accuracy of walls."""
ENTRY_MM = 1.0
"""Tolerance of the entry of a kept hole or pocket along its axis."""


class Kind(ABC, Generic[L]):
    """A kind of correction: one class in one file, registered by one line in `autobalance.correction`.

    Job keys, the JSON Schema, the documentation's table, comparisons, sheets and pages are derived from
    these attributes; nothing outside of ``autobalance.correction`` asks which kind a cut is.

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
        Whether each of its cuts has a separate place and axis, as holes have.
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
    described_by : tuple of str
        Keys without which a listed cut is not described; what may stand for another ``completed`` asks for.
    settings : tuple of str
        Limits that are a cut's own values too: a listed cut must have the value of the job.
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
    settings: ClassVar[tuple[str, ...]] = ()
    described_by: ClassVar[tuple[str, ...]] = ()

    @property
    def piece(self) -> str:
        """Word for one of its corrections: ``cut`` or ``pad``."""
        return "pad" if self.adds_metal else "cut"

    @property
    def extent(self) -> str:
        """Word for the size of one along its direction: ``depth`` or ``height``."""
        return "height" if self.adds_metal else "depth"

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
        """Return limits narrowed to the surroundings of a listed cut, for a short search."""
        if not hasattr(limits, "sectors_deg") or item.get("angle_deg") is None:
            return limits
        angle_deg = float(item["angle_deg"])
        return replace(limits, **{"sectors_deg": ((angle_deg - around_deg, angle_deg + around_deg),)})

    def at_place(self, work: Workpiece, limits: L, item: Item) -> Sequence[Cut]:
        """Return the cuts possible at the place of a listed one; none where a kind only searches.

        On a slightly changed crank a search tries other places than before.

        Raises
        ------
        CorrectionError
            If no cut fits there.
        """
        del work, limits, item
        return ()

    def why_not_kept(self, work: Workpiece, limits: L, item: Item) -> str | None:
        """Return the limit that a listed cut misses on this crank, and the amount; None if unknown."""
        del work, limits, item
        return None

    def is_kept(self, cut: Any, item: Item) -> bool:
        """Return whether a candidate is the cut that an earlier report lists, at any depth."""
        shown = cut.correction(cut.max_depth_mm)
        near = np.linalg.norm(shown.position_mm - np.array(item["position_mm"], dtype=np.float64))
        return bool(shown.web == item.get("web") and shown.face == item.get("face") and near <= KEPT_MM)

    # --- cuts that a job lists ---

    def open_keys(self, item: Item) -> Mapping[str, Any]:
        """Return the limits that let a listed cut be made, if its job sets no limits: its own settings."""
        del item
        return {}

    def opened(self, limits: L, item: Item, stated: Collection[str]) -> L:
        """Return limits for a listed cut: those that a job states, and none else."""
        return replace(limits, **{k: v for k, v in self.open_keys(item).items() if k not in stated})

    def completed(self, item: Item, anatomy: Anatomy, limits: L) -> Item:
        """Return a listed cut with the values that follow from those that describe it.

        Raises
        ------
        CorrectionError If it lacks a value, or has an impossible one.
        """
        del anatomy, limits
        return item

    def as_listed(self, work: Workpiece, limits: Sequence[L], items: Sequence[Item]) -> Candidates:
        """Return the cuts at the places of listed ones, in their order, each with its limits.

        Raises
        ------
        ListedCutError
            If one has no place.
        """
        return Candidates(
            tuple(self._listed_cut(work, each, item) for each, item in zip(limits, items, strict=True))
        )

    def _listed_cut(self, work: Workpiece, limits: L, item: Item) -> Cut:
        try:
            found = next(
                (each for each in self.at_listed_place(work, limits, item) if self.is_listed(each, item)),
                None,
            )
        except CorrectionError as error:
            raise ListedCutError(item, self.why_not_kept(work, limits, item) or str(error)) from None
        if found is None:
            why = self.why_not_kept(work, limits, item)
            raise ListedCutError(item, why or "it has no place there: the metal ends, or is too thin for it")
        return found

    def at_listed_place(self, work: Workpiece, limits: L, item: Item) -> Sequence[Cut]:
        """Return the cuts possible at the place of a cut that a job lists.

        Raises
        ------
        CorrectionError
            If no cut fits there.
        """
        return self.at_place(work, limits, item)

    def is_listed(self, cut: Any, item: Item) -> bool:
        """Return whether a cut is the one that a job lists."""
        return self.is_kept(cut, item)

    def listed_depth_mm(self, cut: Any, item: Item) -> float:
        """Return the depth to make a listed cut in.

        Raises
        ------
        CorrectionError
            If it breaks a limit.
        """
        depth, step = abs(float(item["depth_mm"])), float(cut.depth_step_mm)
        if depth > cut.max_depth_mm + SAME_DEPTH_MM:
            most = math.floor(1e3 * cut.max_depth_mm) / 1e3
            raise CorrectionError(f"depth_mm is {depth:g}; {cut.limit} allows {most:g} mm at most")
        if depth < cut.least_depth_mm - SAME_DEPTH_MM:
            raise CorrectionError(
                f"depth_mm is {depth:g}; the minimum depth there is {cut.least_depth_mm:.4g} mm"
            )
        if step and abs(depth - step * round(depth / step)) > SAME_DEPTH_MM:
            raise CorrectionError(f"depth_mm is {depth:g}, no multiple of depth_step_mm = {step:g}")
        return min(depth, float(cut.max_depth_mm))

    def too_many(self, items: Sequence[Item], limits: L, stated: Collection[str]) -> str | None:
        """Return the stated number that listed cuts exceed, in words; None if they keep it."""
        del items, limits, stated
        return None

    def relaxing(self, limits: L) -> Sequence[Relaxing]:
        """Return the ways to widen these limits where they fall short."""
        del limits
        return ()

    def remedy_most_g_mm(self, work: Workpiece) -> float:
        """Return an upper bound on the unbalance that one cut of ``remedy`` moves, without searching."""
        del work
        return math.inf

    def remedy_text(self, cut: Any) -> str:
        """Return the proposal of a cut that ``remedy`` offered, in words."""
        return str(cut.label)

    def remedy_keys(self, cut: Any) -> Mapping[str, Any]:
        """Return the keys of the kind's table in a job for that cut alone."""
        del cut
        return {} if self.remedy is None else asdict(self.remedy)

    def heavier(self) -> Sequence[L]:
        """Return limits that might make up for counterweights too light, the best first."""
        return ()

    def heavier_words(self, cuts: Sequence[tuple[Any, float]]) -> tuple[str, Mapping[str, Any]]:
        """Return cuts of `heavier`, each with its depth [mm], in words, and the keys for them."""
        return ", ".join(str(cut.label) for cut, _ in cuts), {}

    # --- what is reported ---

    @abstractmethod
    def instruction(self, item: Item, figures: Figures) -> str:
        """Return the instruction to the machinist, in one line."""

    def label(self, item: Item) -> str:
        """Return a short name of the cut for lists and trees: ``drill ⌀12``."""
        face = "" if item.get("face") is None else f" {item['face']}"
        return f"{self.verb}{face}"

    def machining(self, item: Item) -> Operation | str | None:
        """Return the operation of a listed correction, or the reason for its absence; None: nothing to cut.

        Raises
        ------
        FormatError
            If the list lacks a value for it.
        """
        del item
        return "metal is added, not cut" if self.adds_metal else "no program is known for it"

    @abstractmethod
    def size(self, item: Item) -> str:
        """Return the settings besides the depth, lengths with their unit; empty if depth is the only one."""

    def drawn(self, item: Item) -> Shape | None:
        """Return the tool's body of a listed correction, rotor frame [mm], exact; None if unknown."""
        del item
        return None

    def wall_left_mm(self, corrections: Sequence[Correction], anatomy: Anatomy) -> float | None:
        """Return the least metal left beside corrections of this kind; None where they weaken nothing."""
        del anatomy
        walls = [
            float(each.details["wall_left_mm"]) for each in corrections if "wall_left_mm" in each.details
        ]
        return min(walls, default=None)

    def remarks(self, corrections: Sequence[Correction], anatomy: Anatomy, limits: L) -> tuple[str, ...]:
        """Return the checks of a plan's corrections of this method that need a person, one line each."""
        del corrections, anatomy, limits
        return ()

    def trace(self, item: Item) -> Trace | None:
        """Return the trace of a listed correction, by which it can be verified; None if unknown.

        Raises
        ------
        FormatError
            If the list lacks a value for it.
        """
        del item
        return None

    def face_depths_mm(self, work: Workpiece, rims: Sequence[Face]) -> Mapping[str, float]:
        """Return the largest default depths of faces and rims, by their ids, where metal limits them."""
        del work, rims
        return {}
