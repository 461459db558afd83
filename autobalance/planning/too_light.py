"""Counterweights too light for a tolerance: how much is missing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from autobalance import correction
from autobalance.correction import Limits
from autobalance.correction.contract import Cut
from autobalance.correction.kind import Workpiece
from autobalance.crank.faces import find_faces
from autobalance.planning.relaxation import Attempt, JobChange, Relaxation
from autobalance.planning.ties import key
from autobalance.planning.whole_cuts import choose
from autobalance.quantities import Quantity, g_mm, joined, mm, said
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.wording import angle_deg

# Lack of unbalance of counterweights that are too light, and metal on them as a remedy.


MIN_ALIGNED_SHARE = 0.5
"""Share of the unbalance, along the crankpins, above which counterweights are too light."""
G_MM_PER_G_M = 1000.0


def too_light_g_mm(work: Workpiece) -> float | None:
    """Return the unbalance that the counterweights lack, both ends together; None where they do not."""
    total = along = 0.0
    webs = work.anatomy.webs
    if not webs:  # eccentrics
        return None
    for web, (_, heavy) in zip((webs[0], webs[-1]), work.heavy_at, strict=True):
        towards = sum((throw.direction for throw in work.anatomy.throws_of(web)), np.zeros(2))
        size = float(np.linalg.norm(towards))
        total += float(np.linalg.norm(heavy))
        along += float(heavy @ towards) / size if size > 0.0 else 0.0
    return total if total > 0.0 and along > MIN_ALIGNED_SHARE * total else None


def too_light_text(total_g_mm: float) -> str:
    in_metres = total_g_mm >= G_MM_PER_G_M
    both = (
        Quantity("{}", (each / G_MM_PER_G_M if in_metres else each,), "g·m" if in_metres else "g·mm", ".3g")
        for each in (total_g_mm, 0.5 * total_g_mm)
    )
    return said("the counterweights are too light by {}, {} at each end", *both)


def heavier(
    tried: Attempt, known: Sequence[Relaxation], as_run: Callable[[Relaxation], Relaxation | None]
) -> Iterator[Relaxation]:
    """Yield relaxations by metal on the counterweights, each run and within tolerance: one a kind.

    Kinds with a ``known`` relaxation are passed over. ``as_run`` returns a relaxation with what a run of it
    leaves and takes; None where it fails, and the next is tried.
    """
    names = tuple(correction.kind_of(limits).name for limits in tried.asked)
    work = tried.work
    if not work.faces:
        work = replace(work, faces=tuple(find_faces(work.solid.mesh, work.anatomy)))
    tried = replace(tried, work=work)
    for kind in correction.KINDS.values():
        if any(change.key.startswith(f"correction.{kind.name}.") for way in known for change in way.changes):
            continue
        choices = kind.heavier()
        if choices:
            tried.progress(f"trying {kind.name} on the counterweights")
        alone = (_relaxation(tried, (), limits) for limits in choices)
        trimmed = (_relaxation(tried, names, limits) for limits in choices[:1] if kind.name not in names)
        planned = (each for each in chain(alone, trimmed) if each is not None)
        remedy = next(filter(None, map(as_run, planned)), None)
        if remedy is not None:
            yield remedy


def _relaxation(tried: Attempt, names: tuple[str, ...], limits: Limits) -> Relaxation | None:
    """Return the relaxation by one kind, alone or trimmed by the job's own methods (``names``); else None."""
    own = tried.offer_with(limits, coarse=True)
    if own is None or (names and not tried.candidates.cuts):
        return None
    candidates = correction.joined([tried.candidates, own]) if names else own
    if not tried.may_do(candidates):
        return None
    tried.planned.append(len(candidates.cuts))
    plan = choose(tried.residual, tried.tolerance, candidates, prefer="simple")
    cuts = [
        (cut, depth)
        for cut, depth in zip(candidates.cuts, plan.depths_mm.tolist(), strict=True)
        if depth > 0.0
    ]
    if plan.share > 1.0 or not cuts:
        return None
    kind = correction.kind_of(limits)
    put_on = [(cut, depth) for cut, depth in cuts if any(cut is each for each in own.cuts)]
    if not put_on:
        return None
    text, keys = kind.heavier_words(put_on)
    if len(put_on) < len(cuts):
        text = said("{}, trimmed by {}", text, " and ".join(names))
    changes = [JobChange(f"correction.{kind.name}.{key}", None, value) for key, value in keys.items()]
    methods = tuple(correction.kind_of(each).name for each in tried.asked)
    method = (*names, kind.name) if len(put_on) < len(cuts) else (kind.name,)
    if methods != method:
        changes.insert(0, JobChange("correction.method", methods, method))
    metal = sum(abs(cut.effect(depth).mass_g) for cut, depth in cuts)
    own_methods = tuple(each for each in tried.methods if correction.kind_of(each).name in method)
    run_with = (*own_methods, kind.limits(**keys))
    return Relaxation(text, tuple(changes), plan.share, float(metal), methods=run_with)


# Explanation of a residual above tolerance: its excess and plane, its limits and its remedies.


ROUNDING_SHARE = 0.05
"""Share of the permissible value that rounding a printed angle may be worth."""
FACTOR_STEPS = (0.0, 0.02, 0.05)
"""Steps of factors tried below the factor of smallest residual: there is metal to take off then."""
AS_LEFT_SHARE = 0.97
"""Share of the residual from which its lower bound is the residual itself, except for the bound's polygon."""
ONE_PLACE_SHARE = 0.5
"""Share of the permissible value that metal added in one place may leave; else it is named in two."""


@dataclass(frozen=True, eq=False)
class Shortfall:
    """Residual above the permissible value, and the cuts tried.

    ``places_mm`` are two places along the axis where metal can be added, if there are two; ``too_light`` is
    the reason in words where the counterweights are too light.
    """

    residual: Unbalance
    tolerance: Tolerance
    per_factor: Unbalance
    factor: float
    cuts: Sequence[Cut]
    depths_mm: Array
    binding: tuple[str, ...]
    places_mm: tuple[float, float] | None = None
    too_light: str = ""


def explain_shortfall(
    short: Shortfall, computed: Sequence[str] = (), bound: float = 0.0, factor: Relaxation | None = None
) -> str:
    """Return the explanation of a shortfall: its excess and plane, its limits and its remedies.

    ``computed`` are changes of the limits that are known to suffice, ``factor`` is one of the balance factor.
    ``bound`` is the share of the permissible value that no plan within the limits gets below, if known.
    """
    worst, value, permitted = max(_judged_values(short), key=lambda row: key(row[1] / row[2]))
    text = said(
        "the residual of {} is {}, {} above the permissible {}",
        worst,
        g_mm(value, ".2f"),
        g_mm(value - permitted, ".2f"),
        g_mm(permitted, ".2f"),
    )
    is_light = bool(short.too_light) and not short.depths_mm.any()
    if is_light:
        text += "; " + short.too_light
    elif not short.cuts:
        text += "; no cut is available on the heavy side"
    elif short.binding:
        text += "; limited by " + joined(", ", short.binding)
    else:
        text += "; none of the available cuts acts in the remaining direction"
    if bound > 1.0:
        is_left = not short.depths_mm.any() and bound >= AS_LEFT_SHARE * value / permitted
        least = "that" if is_left else f"{bound:.3g} times the permissible value"
        text += f"; no plan within these limits leaves less than {least}"
    enough = "; enough would be: " + joined(", or ", computed) if computed else ""
    fixes = [] if factor is None else [factor.text]
    fixes += [] if is_light and computed else [_added(short)]
    return text + enough + ("; " + joined(", or ", fixes) if fixes else "")


def _judged_values(short: Shortfall) -> list[tuple[str, float, float]]:
    rows = [("the resultant", short.residual.magnitude_g_mm, short.tolerance.permissible_g_mm)]
    if short.tolerance.judge == "dynamic":
        a, b = short.tolerance.planes
        for plane, vector in zip((a, b), short.residual.in_planes(a.z_mm, b.z_mm), strict=True):
            rows.append((f"plane {plane.name}", math.hypot(*vector), plane.permissible_g_mm))
    return rows


def _added(short: Shortfall) -> str:
    """Return the metal to add, in words: in one place if that leaves little, else in two."""
    residual, tolerance = short.residual, short.tolerance
    permissible = min([tolerance.permissible_g_mm, *(plane.permissible_g_mm for plane in tolerance.planes)])
    if tolerance.judge == "static":
        return said("add {} from throw 1", _vector(-residual.resultant_g_mm, permissible))
    size = float(residual.resultant_g_mm @ residual.resultant_g_mm)
    if size > 0.0:
        z = float(residual.moment_g_mm2 @ residual.resultant_g_mm) / size
        after = residual - Unbalance(residual.resultant_g_mm, z * residual.resultant_g_mm)
        low, high = sorted(short.places_mm or (plane.z_mm for plane in tolerance.planes))
        if low <= z <= high and tolerance.used_share(after) <= ONE_PLACE_SHARE:
            metal = _vector(-residual.resultant_g_mm, permissible)
            return said("add {} from throw 1, at z {}", metal, mm(round(z, 1) + 0.0, ".1f"))
    a, b = short.places_mm or (tolerance.planes[0].z_mm, tolerance.planes[1].z_mm)
    first, second = residual.in_planes(a, b)
    one, other = _vector(-first, permissible), _vector(-second, permissible)
    ends = one, mm(a, ".1f"), other, mm(b, ".1f")
    return said("add {} at z {} and {} at z {}, angles from throw 1", *ends)


def _vector(unbalance: Array, permissible_g_mm: float) -> str:
    """Return a vector in words, its angle with digits enough that rounding leaves next to nothing."""
    size = math.hypot(*unbalance)
    angle = angle_deg(unbalance)
    off = math.radians(0.5) * size / (ROUNDING_SHARE * permissible_g_mm)
    digits = min(max(math.ceil(math.log10(off)), 1), 6) if off > 0.0 else 1
    return said("{} of metal at {}°", g_mm(size, ".1f"), round(angle, digits) % 360.0)


def factor_relaxations(short: Shortfall) -> tuple[Relaxation, ...]:
    """Return changes of the balance factor to try: the one that the same cuts reach.

    Without any, and with counterweights that are too light, those that further cuts may reach.
    """
    factor = _least_factor(short)
    if factor is None:
        return ()
    if _share_at(short, factor) > 1.0:
        lower = [factor - step for step in FACTOR_STEPS if factor >= step] if short.too_light else []
        return tuple(_relaxed_to(short, each, "with the available cuts") for each in lower)
    return (_relaxed_to(short, factor, "with the available cuts" if short.depths_mm.any() else "as it is"),)


def _relaxed_to(short: Shortfall, factor: float, how: str) -> Relaxation:
    factor = round(factor, 6)
    text = f"a balance factor of {factor:.4f} can be reached {how}"
    change = JobChange("balance.factor", short.factor, factor)
    return Relaxation(text, (change,), _share_at(short, factor), None)


def _share_at(short: Shortfall, factor: float) -> float:
    """Return the largest share of a permissible value that the same cuts leave at a factor."""
    return short.tolerance.used_share(short.residual + short.per_factor.scaled(factor - short.factor))


def _least_factor(short: Shortfall) -> float | None:
    """Return the balance factor of least squares with the same cuts; None where that is not from 0 to 1.

    Of the resultant, and with ``judge = "dynamic"`` of both planes: throws that cancel each other out leave
    a couple.
    """
    left, slope = _judged_vector(short, short.residual), _judged_vector(short, short.per_factor)
    size = float(slope @ slope)
    exact = short.factor - float(left @ slope) / size if size > 0.0 else -1.0
    return exact if 0.0 <= exact <= 1.0 else None


def _judged_vector(short: Shortfall, unbalance: Unbalance) -> Array:
    if short.tolerance.judge == "static":
        return unbalance.resultant_g_mm
    a, b = short.tolerance.planes
    return unbalance.in_planes(a.z_mm, b.z_mm).ravel()
