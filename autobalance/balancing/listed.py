"""Cuts that a job lists, made exactly as they are listed: nothing is planned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np

from autobalance.balancing.loop import Result, cut_as_given
from autobalance.balancing.measuring import Measure
from autobalance.balancing.offers import BestOffer, workpiece
from autobalance.balancing.rotor import Rotor
from autobalance.correction import KINDS, joined
from autobalance.correction.apart import TOUCHING_MM, gap_mm, keep_apart
from autobalance.correction.contract import Item
from autobalance.correction.kind import Candidates, Kind, ListedCutError, Workpiece
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError, FormatError, JobError
from autobalance.job import Job
from autobalance.planning.depths import Plan
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import Notify
from autobalance.types import Array

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
