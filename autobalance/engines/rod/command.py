"""``autobalance rod FILE``: a connecting rod's solid, measured."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_units
from autobalance.command.readers import body_of
from autobalance.command.verb import Keywords, Option, Verb
from autobalance.errors import UsageError
from autobalance.solid.formats.table import endings


def _adjust(keywords: Keywords, _: argparse.Namespace) -> None:
    """Refuse half a question; take millimetres where neither file nor option has a unit."""
    from autobalance.command.readers import unit_or_mm
    from autobalance.solid.formats.registry import names_bodies

    path = Path(keywords["file"])
    if (keywords["stroke_mm"] is None) != (keywords["speed_rpm"] is None):
        raise UsageError("--stroke-mm and --speed-rpm go together")
    keywords["unit"] = unit_or_mm(keywords["unit"], path)
    keywords["body"] = body_of(keywords["body"], names_bodies(path))


VERB = Verb(
    "engines.rod.verb:rod",
    examples=(
        "autobalance rod rod.stl --unit mm --density-kg-m3 7850",
        "autobalance rod engine.step --body rod --stroke-mm 53.8 --speed-rpm 12000",
        'In a job, [engine.rod] file = "rod.stl" puts the same rod in.',
    ),
    options={
        "file": Option(metavar="FILE", endings=endings),
        "body": Option(metavar="N", usual="the only one"),
    },
    writes=(add_json, add_units),
    adjust=_adjust,
)
