"""Bending of the webs as a part of the main report, which ``--fem`` asks for."""

from __future__ import annotations

from typing import Any

from autobalance.balancing.sections import Section, State
from autobalance.crank_dynamics.strength.bending_text import bending_rows, bending_text, bending_words
from autobalance.crank_dynamics.strength.web_bending import Bending, bending, inertia_forces_N
from autobalance.finite_elements.mesher import need_libraries
from autobalance.runtime import Notify


def _ended(before: State, after: State, notify: Notify) -> Bending:
    forces = inertia_forces_N(after.job, after.crank.anatomy)
    cut = None if after.solid is before.solid else after.solid
    return bending(after.crank, cut, forces, lambda text, _: notify(text))


def _page(found: Bending) -> tuple[str, dict[str, Any]]:
    return "bending.html", {"rows": bending_rows(found), "words": bending_words(found)}


SECTION = Section(
    Bending,
    "with --fem: stress of the webs, before and after",
    begun=lambda before: before,
    ended=_ended,
    text=bending_text,
    page=_page,
    unchecked=lambda _: "finite elements on meshes that are not kept; `balance --fem` computes them again",
    require=need_libraries,
)
