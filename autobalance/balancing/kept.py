"""Cuts that are given: those of an earlier report with new depths, and those that a job lists."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import partial
from itertools import product
from typing import Any, NoReturn, TypeVar

import numpy as np

from autobalance.balancing.loop import Result, balance, cut_as_given
from autobalance.balancing.measuring import Measure
from autobalance.balancing.offers import BestOffer, best_offer, heavy_vectors, workpiece
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import KINDS, joined, kind_of, search_levels
from autobalance.correction.apart import TOUCHING_MM, gap_mm, keep_apart
from autobalance.correction.contract import Apart, Cut, Item, Limits, SharedDepth
from autobalance.correction.faces.cut import FaceCut
from autobalance.correction.kind import Candidates, Kind, ListedCutError, Workpiece
from autobalance.correction.overlap import Overlap
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.errors import CorrectionError, FormatError, JobError
from autobalance.job import Job
from autobalance.planning.depths import Plan
from autobalance.planning.milp_model import is_never
from autobalance.planning.relaxation import JobChange, Relaxation
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import LIMITS_SOUGHT, Notify, Skipped, skippable
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Cuts of an earlier report with new depths: their places, tools, faces and numbers stay.


_Pair = TypeVar("_Pair", SharedDepth, Apart, Overlap)
SECTOR_DEG = 0.5
"""Sector to both sides of a cut's angle in which its place is looked for."""


@dataclass(frozen=True, eq=False)
class KeptPlan:
    """The plan to keep: its report's file name, sha256 and values, and its cuts as they are listed.

    ``cuts`` are those cuts on this crank, by number, once they were found on it; ``offered`` are all
    candidates found for them, with their numbers: some are set up again where a look reaches farther.
    ``heavy_at`` is the unbalance at the time of the report, as in a workpiece.
    """

    report: str
    sha256: str
    items: tuple[Item, ...]
    values: Mapping[str, Any]
    cuts: dict[int, Cut] = field(default_factory=dict)
    offered: list[tuple[Cut, int]] = field(default_factory=list)
    heavy_at: tuple[tuple[float, Array], tuple[float, Array]] | None = None

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of its cuts, each once."""
        return tuple(dict.fromkeys(str(item["kind"]) for item in self.items))

    def offer(self, work: Workpiece, limits: Limits, search_level: int) -> Candidates:
        """Return the kept cuts of a kind as the only candidates there are.

        Raises
        ------
        JobError
            If one has no metal at its place.
        """
        del search_level
        name = kind_of(limits).name
        mine = [item for item in self.items if item["kind"] == name]
        if not mine:
            return Candidates(())
        if KINDS[name].offers_all:
            return self._among_all(mine, work, limits)
        cuts = [self._kept_cut(item, work, limits) for item in mine]
        spacing = getattr(limits, "min_spacing_mm", 0.0)
        walls = np.array([max(spacing, cut.clearance_mm) for cut in cuts])
        most = np.array([cut.max_depth_mm for cut in cuts])
        apart = keep_apart([cut.envelope for cut in cuts], most, walls)
        for pair in apart:
            if is_never(pair, cuts):
                raise self._too_near(mine, cuts, (pair.first, pair.second), walls)
        return Candidates(tuple(cuts), apart=apart)

    def _too_near(
        self, mine: Sequence[Item], cuts: Sequence[Cut], pair: tuple[int, int], walls: Array
    ) -> JobError:
        """Return the error of two cuts that are too close at their smallest depths, with the gap."""
        least = np.array([cuts[k].least_depth_mm for k in pair])
        wanted = float(max(walls[k] for k in pair))
        gap = gap_mm([cuts[k].envelope for k in pair], least, wanted)
        one, other = (mine[k]["number"] for k in pair)
        return JobError(
            f"{self.report}: cuts {one} and {other} have no place beside each other with the job's limits: "
            f"{gap:.3f} mm between them, {wanted - gap:.3f} mm less than the {wanted:g} mm of "
            "min_spacing_mm or min_wall_mm; balance without keep"
        )

    def _among_all(self, mine: Sequence[Item], work: Workpiece, limits: Limits) -> Candidates:
        """Return the kept cuts among a kind's candidates, with the rules among them."""
        kind = kind_of(limits)
        # sectors of faces lie about the heavy side: they are looked for about the earlier one, too
        offered = Candidates(())
        places: list[int | None] = [None for _ in mine]
        then = [] if self.heavy_at is None else [replace(work, heavy_at=self.heavy_at)]
        for there, level in product([work, *then], range(search_levels(limits))):
            try:
                offered = kind.offer(there, limits, level)
            except CorrectionError:
                continue
            places = [
                next((k for k, c in enumerate(offered.cuts) if kind.is_kept(c, item)), None) for item in mine
            ]
            if None not in places:
                break
        for item, place in zip(mine, places, strict=True):
            if place is None:
                raise self._gone(item, work, limits)
            self.cuts[int(item["number"])] = offered.cuts[place]
            self.offered.append((offered.cuts[place], int(item["number"])))
        at = {place: k for k, place in enumerate(places)}

        def among(pairs: Sequence[_Pair]) -> tuple[_Pair, ...]:
            both = (each for each in pairs if each.first in at and each.second in at)
            return tuple(replace(each, first=at[each.first], second=at[each.second]) for each in both)

        return Candidates(
            tuple(offered.cuts[place] for place in at if place is not None),
            shared=among(offered.shared),
            same_depth=offered.same_depth,
            apart=among(offered.apart),
            overlaps=among(offered.overlaps),
        )

    def _gone(self, item: Item, work: Workpiece, limits: Limits) -> JobError:
        place = "" if item.get("web") is None else f" of web {item['web']}"
        why = kind_of(limits).why_not_kept(work, limits, item)
        return JobError(
            f"{self.report}: cut {item['number']} ({item['kind']}{place}) has no place here with the "
            f"job's limits: {why or 'its metal is gone, or it is another crank'}; balance without keep"
        )

    def _kept_cut(self, item: Item, work: Workpiece, limits: Limits) -> Cut:
        number = int(item["number"])
        if number not in self.cuts:
            cut = kept_cut(item, work, limits)
            if cut is None:
                raise self._gone(item, work, limits)
            self.cuts[number] = cut
            self.offered.append((cut, number))
        return self.cuts[number]

    def with_tools(self, result: Result) -> Result:
        """Return a result in the order of the kept numbers, with an empty body if nothing is cut."""
        cuts = self._made_by_number(result)
        places = [cuts.get(number) for number in self.numbers]
        order = [k for k in places if k is not None]
        tools = [Solid.nothing() if k is None else result.tools[k] for k in places]
        unused = [number for number, k in zip(self.numbers, places, strict=True) if k is None]
        notes = tuple(f"cut {number} of {self.report} is kept with depth 0" for number in unused)
        return replace(
            result,
            corrections=tuple(result.corrections[k] for k in order),
            made=tuple(result.made[k] for k in order),
            tools=tuple(tools),
            notes=result.notes + notes,
        )

    def _made_by_number(self, result: Result) -> dict[int, int]:
        """Return the index among a result's cuts by kept number, of those that are made."""
        numbers = {id(cut): number for cut, number in self.offered}
        return {numbers[id(cut)]: k for k, (cut, _) in enumerate(result.made)}

    @property
    def numbers(self) -> tuple[int, ...]:
        return tuple(int(item["number"]) for item in self.items)

    def places(self, result: Result) -> list[tuple[Item, int | None]]:
        """Return each kept cut with its index among the cuts that are made; None where it is not made."""
        cuts = self._made_by_number(result)
        return [(item, cuts.get(int(item["number"]))) for item in self.items]

    @property
    def faces(self) -> tuple[Face, ...]:
        """The faces that its cuts begin at, each once."""
        faces = (cut.face for cut in self.cuts.values() if isinstance(cut, FaceCut))
        return tuple({face.id: face for face in faces}.values())


def kept_cut(item: Item, work: Workpiece, limits: Limits) -> Cut | None:
    """Return the candidate of a kind that lies where a listed cut does; None without one.

    A kind's candidates at that very place come first. Else candidates are tried in even steps from the heavy
    side, which is put where the cut was.
    """
    kind = kind_of(limits)
    there = _kept(kind, item, lambda: kind.at_place(work, limits, item))
    if there is not None:
        return there
    x, y = (float(each) for each in item["position_mm"][:2])
    angle = math.radians(float(item["angle_deg"])) if math.hypot(x, y) > 0.0 else 0.0
    need = max(work.need_g_mm, 1.0)
    towards = need * np.array([math.cos(angle), math.sin(angle)])
    for sign in (1.0, -1.0):
        heavy = tuple((z, sign * towards) for z, _ in work.heavy_at)
        turned = replace(work, heavy_at=(heavy[0], heavy[1]))
        near = kind.kept_limits(limits, item, SECTOR_DEG)
        for level in range(search_levels(limits)):
            cut = _kept(kind, item, partial(_offered, kind, turned, near, level))
            if cut is not None:
                return cut
    return None


def _offered(kind: Kind[Any], work: Workpiece, limits: Limits, level: int) -> Sequence[Cut]:
    return kind.offer(work, limits, level).cuts


def _kept(kind: Kind[Any], item: Item, offered: Callable[[], Sequence[Cut]]) -> Cut | None:
    """Return the listed cut among what a kind offers; None if it is missing."""
    try:
        return next((cut for cut in offered() if kind.is_kept(cut, item)), None)
    except CorrectionError:
        return None


def balanced_as_kept(
    kept: KeptPlan, job: Job, rotor: Rotor, tolerance: Tolerance, measure: Measure, progress: Notify
) -> Result:
    """Balance with the cuts of an earlier plan alone; the result has remedies where they do not suffice.

    Raises
    ------
    JobError
        If one of them has no place.
    """
    methods = [limits for limits in job.methods if kind_of(limits).name in kept.kinds]
    progress("looking for the kept cuts")
    kept = replace(kept, heavy_at=_heavy_then(kept, tolerance, rotor.anatomy))
    initial = Unbalance.of(rotor.moments + rotor.loads)
    for limits in methods:  # all of them must have a place, needed or not
        kept.offer(workpiece(rotor, tolerance, initial), limits, 0)
    result = balance(
        rotor, tolerance, methods, measure, progress, prefer="least_metal", advise=False, offers=kept.offer
    )
    if result.outcome == "above_tolerance":
        progress(LIMITS_SOUGHT)
        with suppress(Skipped), skippable():
            anew = _without(kept, job, rotor, tolerance)
            result = replace(result, relaxations=(*result.relaxations, *anew))
    return kept.with_tools(result)


def _without(kept: KeptPlan, job: Job, rotor: Rotor, tolerance: Tolerance) -> tuple[Relaxation, ...]:
    """Return the remedy of planning again without keep, if that reaches the tolerance."""
    initial = Unbalance.of(rotor.moments + rotor.loads)
    free = best_offer(rotor, tolerance, job.methods, initial, job.prefer)
    if free.plan.share > 1.0:
        return ()
    cuts = zip(free.candidates.cuts, free.plan.depths_mm, strict=True)
    metal = sum(abs(cut.effect(float(depth)).mass_g) for cut, depth in cuts if depth > 0.0)
    count = int((free.plan.depths_mm > 0.0).sum())
    text = f"a new plan, without keep: {count} cut{'s' * (count != 1)}"
    return (Relaxation(text, (JobChange("correction.keep", kept.report, None),), free.plan.share, metal),)


def _heavy_then(
    kept: KeptPlan, tolerance: Tolerance, anatomy: Anatomy
) -> tuple[tuple[float, Array], tuple[float, Array]]:
    try:
        initial = kept.values["initial"]
        resultant, moment = (
            np.array(initial[key], dtype=np.float64) for key in ("unbalance_g_mm", "moment_g_mm2")
        )
    except (LookupError, TypeError, ValueError):
        raise JobError(f"{kept.report} is not a whole report: it has no initial unbalance") from None
    return heavy_vectors(Unbalance(resultant, moment), tolerance, anatomy)


def kept_plan(name: str, data: bytes, values: Mapping[str, Any]) -> KeptPlan:
    """Return the plan of a report.

    Raises
    ------
    JobError
        If it has no cuts.
    """
    items = values.get("corrections")
    if values.get("command") not in ("balance", "recut") or not isinstance(items, list) or not items:
        raise JobError(f"{name} lists no cuts to keep; expected a report of balance with corrections")
    return KeptPlan(name, hashlib.sha256(data).hexdigest(), tuple(items), values)


def refuse_other_crank(plan: KeptPlan, job: Job, anatomy: Anatomy) -> None:
    """Refuse a plan of another crank, or of kinds that the job's method does not name.

    Raises
    ------
    JobError
        If it is.
    """
    values = plan.values
    try:
        first = next(iter(plan.numbers))
        crank = values["crank"]
        there = tuple(len(crank[key]) for key in ("throws", "webs", "main_journals"))
    except (LookupError, TypeError, ValueError):
        raise JobError(
            f"{plan.report} is not a whole report: its cuts have no numbers, or it has no crank"
        ) from None
    here = len(anatomy.throws), len(anatomy.webs), len(anatomy.main_journals)
    if there != here:
        raise JobError(
            f"{plan.report}: cut {first} is of another crank: it has {there[0]} throws, {there[1]} webs and "
            f"{there[2]} main journals; this one has {here[0]}, {here[1]} and {here[2]}; balance without keep"
        )
    for item in plan.items:
        if item["kind"] not in job.method_names:
            raise JobError(
                f"{plan.report}: cut {item['number']} is of kind {item['kind']!r}; correction.method is "
                f"{', '.join(job.method_names)}; expected the kinds that are kept"
            )


# Cuts that a job lists, made exactly as they are listed: nothing is planned.


ROUNDING_MM = 1e-9
"""Depth up to which two cuts may exceed what both may have together: rounding."""


def cut_as_listed(job: Job, rotor: Rotor, tolerance: Tolerance, measure: Measure, progress: Notify) -> Result:
    """Make the cuts that a job lists, measure the crank and judge it.

    Raises
    ------
    JobError
        If a cut breaks a limit that the job states, has no place on this crank, or comes too near another;
        it names the cut, the limit and the figure.
    """
    progress("looking for the listed cuts")
    initial = Unbalance.of(rotor.moments + rotor.loads)
    work = workpiece(rotor, tolerance, initial)
    items, parts = [], []
    for name in job.method_names:
        of_kind = [_completed(job, item, rotor.anatomy) for item in job.cuts if item["kind"] == name]
        parts.append(_found(job, KINDS[name], work, of_kind))
        items += of_kind
    candidates = joined(parts)
    depths = np.array([_depth_mm(cut, item) for cut, item in zip(candidates.cuts, items, strict=True)])
    _refuse_too_near(job, candidates, depths, items)
    effects = [cut.effect(float(depth)) for cut, depth in zip(candidates.cuts, depths, strict=True)]
    predicted = sum((Unbalance.of(each) for each in effects), start=initial)
    plan = Plan(depths, predicted, tolerance.used_share(predicted), ("the cuts as they are listed",))
    chosen = BestOffer(candidates, plan, job.methods, ())
    order = np.argsort([int(item["number"]) for item in items])
    return cut_as_given(rotor, tolerance, chosen, measure, progress, order.tolist())


def _completed(job: Job, item: Item, anatomy: Anatomy) -> Item:
    try:
        return KINDS[item["kind"]].completed(item, anatomy, job.limits_of(item["kind"]))
    except (CorrectionError, FormatError) as error:
        _refuse(item, str(error))


def _found(job: Job, kind: Kind[Any], work: Workpiece, items: Sequence[Item]) -> Candidates:
    """Return the candidates of a kind's listed cuts, in their order."""
    limits, stated = job.limits_of(kind.name), job.stated_limits(kind.name)
    for item in items:
        for key in kind.settings:
            listed, wanted = item.get(key), getattr(limits, key)
            if key in stated and listed is not None and listed != wanted:
                _refuse(item, f"{key} is {listed}; correction.{kind.name}.{key} is {wanted}")
    if (many := kind.too_many(items, limits, stated)) is not None:
        raise JobError(f"correction.cut: {many}")
    opened = []
    for item in items:
        try:
            opened.append(kind.opened(limits, item, stated))
        except CorrectionError as error:
            _refuse(item, str(error))
    try:
        return kind.as_listed(work, opened, items)
    except ListedCutError as error:
        _refuse(error.item, str(error))


def _depth_mm(cut: Any, item: Item) -> float:
    try:
        return KINDS[item["kind"]].listed_depth_mm(cut, item)
    except CorrectionError as error:
        _refuse(item, str(error))


def _refuse_too_near(job: Job, candidates: Candidates, depths: Array, items: Sequence[Item]) -> None:
    """Refuse pairs of cuts that the limits keep apart, or that would take the same metal."""
    cuts = candidates.cuts
    for each in candidates.apart:
        if max(depths[each.first], depths[each.second]) > each.most_mm + ROUNDING_MM:
            most = "never both" if each.most_mm < 0.0 else f"{each.most_mm:.4g} mm at most together"
            _refuse_pair(items[each.first], items[each.second], most)
    for shared in candidates.shared:
        if depths[shared.first] + depths[shared.second] > shared.most_mm + ROUNDING_MM:
            text = f"their depths may be {shared.most_mm:.4g} mm together: min_wall_mm would be missed"
            _refuse_pair(items[shared.first], items[shared.second], text)
    overlapping = {(each.first, each.second) for each in candidates.overlaps}
    walls = np.array([_wall_mm(job, cut, item) for cut, item in zip(cuts, items, strict=True)])
    near = keep_apart([cut.envelope for cut in cuts], depths, walls)
    pairs = {(each.first, each.second) for each in near} - overlapping
    for first, second in sorted(pairs):
        same_kind = items[first]["kind"] == items[second]["kind"]
        if same_kind and KINDS[items[first]["kind"]].offers_all:  # their kind has compared them
            continue
        wanted = float(max(walls[first], walls[second]))
        gap = gap_mm([cuts[k].envelope for k in (first, second)], depths[[first, second]], wanted)
        text = f"{gap:.3f} mm between them, {wanted - gap:.3f} mm less than the {wanted:g} mm that they keep"
        _refuse_pair(items[first], items[second], text)


def _wall_mm(job: Job, cut: Any, item: Item) -> float:
    """Return the metal that a cut keeps to others: what the job states, else so much that none is shared."""
    stated = job.stated_limits(item["kind"])
    spacing = getattr(job.limits_of(item["kind"]), "min_spacing_mm", 0.0)
    return max(
        TOUCHING_MM,
        float(cut.clearance_mm) if "min_wall_mm" in stated else 0.0,
        spacing if "min_spacing_mm" in stated else 0.0,
    )


def _name(item: Item) -> str:
    """Return the name of a cut for messages: ``cut 3 (drill, web 2 at 153.7°)``."""
    place = [] if item.get("web") is None else [f"web {item['web']}"]
    place += [] if item.get("face") is None else [f"face {item['face']}"]
    angle = item.get("angle_deg")
    at = "" if angle is None or not math.isfinite(float(angle)) else f" at {float(angle):.4g}°"
    return f"cut {item['number']} ({', '.join([str(item['kind']), *place])}{at})"


def _refuse(item: Item, why: str) -> NoReturn:
    raise JobError(f"correction.{_name(item)}: {why}")


def _refuse_pair(one: Item, other: Item, why: str) -> NoReturn:
    raise JobError(f"correction.{_name(one)} and {_name(other)}: {why}")
