"""Files of an earlier run in a folder: those that its report lists and the new run does not write.

They are removed together with the new files' renames. A file that no report of this program lists, or that
was changed since, is never touched.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from autobalance.errors import FileError
from autobalance.report.files import Staging

MOST_BYTES = 200_000_000
"""Length of a report at most; the longest of a batch has some MB."""


def earlier_report(path: Path) -> Mapping[str, Any] | None:
    """Return the values of a report of this program; None if it is missing or another file."""
    try:
        if not path.is_file() or path.stat().st_size > MOST_BYTES:
            return None
        values = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    ours = isinstance(values, dict) and isinstance(values.get("autobalance"), dict)
    return values if ours and isinstance(values.get("command"), str) else None


def remove_stale(staging: Staging, report: Path, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Let a staging remove the files of the earlier report in the place of a new one.

    Parameters
    ----------
    staging : Staging
        The new files' own, the new report among them.
    report : Path
        Where the new report goes.
    values : mapping
        The new report; the files that it names stay, even if the earlier one lists them.

    Returns
    -------
    tuple of str Listed files that were changed since, which stay, as a warning; empty without any.
    """
    earlier = earlier_report(report)
    if earlier is None:
        return ()
    folder, changed = report.parent, []
    named = {(folder / name).resolve() for name in _names_in(values)}
    for name, digest in listed_outputs(earlier):
        path = folder / name
        if staging.writes(path) or path.resolve() in named or not _is_below(path, folder):
            continue
        if path.is_symlink() or not path.is_file():
            continue
        if hashlib.sha256(path.read_bytes()).hexdigest() == digest:
            staging.remove(path)
        else:
            changed.append(name)
    if not changed:
        return ()
    them = "it" if len(changed) == 1 else "them"
    return (
        f"{folder}: {', '.join(changed)} of the earlier run was changed since and stays; "
        f"this run did not write {them}",
    )


def listed_outputs(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the names and sha256 of the files that a report lists as written beside it."""
    outputs = values.get("outputs")
    for entry in outputs.values() if isinstance(outputs, Mapping) else ():
        if isinstance(entry, Mapping):
            name, digest = entry.get("file"), entry.get("sha256")
            if isinstance(name, str) and name and isinstance(digest, str):
                yield name, digest


def _is_below(path: Path, folder: Path) -> bool:
    return path.resolve() != folder.resolve() and path.resolve().is_relative_to(folder.resolve())


def _names_in(values: Any) -> Iterator[str]:
    """Yield every file that a report names, at any depth."""
    if isinstance(values, Mapping):
        for key, value in values.items():
            if isinstance(value, str) and key in ("file", "report", "crank"):
                yield value
            else:
                yield from _names_in(value)
    elif isinstance(values, list | tuple):
        for each in values:
            yield from _names_in(each)


def refuse_another_run(folder: Path, report: Path) -> None:
    """Refuse a folder whose report of a run is another than the one that files are made of.

    Raises
    ------
    FileError
        If papers of one crank would lie beside the report of another.
    """
    there = folder / report.name
    if there.resolve() != report.resolve() and earlier_report(there) is not None:
        raise FileError(f"{folder} holds {there.name} of another run; choose another folder")
