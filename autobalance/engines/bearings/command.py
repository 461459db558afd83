"""``autobalance bearing BEARING.toml``: friction, film, stiffness and damping; the film through a cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.command.options import add_json, add_plots, add_series
from autobalance.command.verb import NOT_TYPED, Option, Verb
from autobalance.errors import UsageError

if TYPE_CHECKING:
    from autobalance.engines.bearings.verb import BearingResult


def _orbit(result: BearingResult) -> bytes:
    series = result.series()
    if series is None:
        raise UsageError("--series needs a [history] of loads: without one there is no orbit")
    return series


VERB = Verb(
    "engines.bearings.verb:bearing",
    examples=("autobalance bearing bearing.toml --series orbit.csv",),
    options={"bearing": Option(metavar="BEARING.toml"), "history": NOT_TYPED},
    writes=(add_series("the journal's orbit by angle, with [history]"), add_json, add_plots),
    series=_orbit,
)
