"""All files that a run can write for people, from one report and the solids before and after."""

from __future__ import annotations

import datetime
from collections.abc import Collection

from autobalance.errors import FormatError
from autobalance.report.job_header import file_prefix
from autobalance.report.material import Choice, FileMaterial
from autobalance.report.output_kinds import KINDS, choices, usual

PAPERS = ("A4", "Letter")
UNIT_SYSTEMS = ("metric", "inch")
ZEROS = ("keyway", "crankpin")


def choice_of(
    only: Collection[str] | None, paper: str, units: str, date: str | None = None, zero: str = "keyway"
) -> Choice:
    """Return a checked choice: ``only`` None for the usual kinds, ``date`` None for today.

    Raises
    ------
    FormatError
        If a kind, the paper, the units or the zero are not known, or a kind's extra is not installed.
    """
    choices_made = [("only names", kind, choices()) for kind in only or ()]
    choices_made += [("paper is", paper, PAPERS), ("units is", units, UNIT_SYSTEMS), ("zero is", zero, ZEROS)]
    for words, value, known in choices_made:
        if value not in known:
            raise FormatError(f"{words} {value!r}; expected one of {', '.join(known)}")
    kinds = tuple(kind for kind in KINDS if kind in (usual() if only is None else only))
    for kind in kinds:
        KINDS[kind].require()
    day = datetime.date.today().isoformat() if date is None else date
    return Choice(kinds, paper, units, day, zero)


def bundle(material: FileMaterial) -> dict[str, tuple[str, bytes]]:
    """Return the chosen files: key in ``outputs`` → name and bytes."""
    files: dict[str, tuple[str, bytes]] = {}
    prefix = file_prefix(material.balanced.given.job, material.balanced.serial)
    for name, kind in KINDS.items():
        if name in material.choice.kinds:
            data = kind.make(material)
            files |= {key: (file, data[key]) for key, file in kind.named(prefix).items() if key in data}
    return files
