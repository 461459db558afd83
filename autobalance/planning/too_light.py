"""Lack of unbalance of counterweights that are too light, and metal on them as a remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from autobalance import correction
from autobalance.correction import Limits
from autobalance.correction.kind import Workpiece
from autobalance.crank.faces import find_faces
from autobalance.planning.relaxation import Attempt, Change, Relaxation
from autobalance.planning.whole_cuts import choose
from autobalance.quantities import Quantity, said

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
    changes = [Change(f"correction.{kind.name}.{key}", None, value) for key, value in keys.items()]
    methods = tuple(correction.kind_of(each).name for each in tried.asked)
    method = (*names, kind.name) if len(put_on) < len(cuts) else (kind.name,)
    if methods != method:
        changes.insert(0, Change("correction.method", methods, method))
    metal = sum(abs(cut.effect(depth).mass_g) for cut, depth in cuts)
    own_methods = tuple(each for each in tried.methods if correction.kind_of(each).name in method)
    run_with = (*own_methods, kind.limits(**keys))
    return Relaxation(text, tuple(changes), plan.share, float(metal), methods=run_with)
