"""The end of every command: the files that were requested, all or none, and the rest printed."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.command.console import say, say_as_it_is, warn
from autobalance.errors import UsageError
from autobalance.report.files import Staging, from_here, remove_stale
from autobalance.report.tables import whole
from autobalance.runtime import was_read

if TYPE_CHECKING:
    from autobalance.command.console import Mode
    from autobalance.job import Job
    from autobalance.report.material import Choice
    from autobalance.verbs.balance import BalanceResult
    from autobalance.verbs.balanced_files import BalancedFiles
    from autobalance.verbs.result import VerbResult


def finish(
    arguments: argparse.Namespace,
    result: VerbResult,
    sources: tuple[str | Path, ...] = (),
    files: Mapping[Path, bytes] | None = None,
) -> int:
    """Write the files of ``--json``, ``--plots`` and ``-o``, print the rest, return the exit code.

    Parameters
    ----------
    arguments : argparse.Namespace
        Options of the command; ``json``, ``plots``, ``output`` and ``units`` are looked at if they exist.
    result : VerbResult
    sources : tuple of paths
        Files the command read: none of them may be overwritten.
    files : mapping or None
        Further files with their paths, such as that of ``--series``.

    Raises
    ------
    UsageError
        If a file would be written over another, or over one that was read.
    """
    to_write = [*_asked_for(arguments, result), *(files or {}).items()]
    page = _page(arguments, result)
    to_write += [] if page is None else [page]
    job = getattr(arguments, "job", None)
    named = {
        Path(source).resolve(): "the job" if source == job else "a file that is read" for source in sources
    }
    _refuse_collisions([path for path, _ in to_write], named)
    with Staging(sorted({path.parent for path, _ in to_write})) as staging:
        for path, data in to_write:
            staging.add(path, data)
        notes: tuple[str, ...] = ()
        if getattr(arguments, "output", None) is not None and not result.caller_names_files:
            notes = remove_stale(staging, Path(arguments.output) / result.report_name, result.report)
        staging.commit()
    warnings = (*result.warnings, *notes)
    if getattr(arguments, "json", None) == "-":
        for text in warnings:
            warn(text)
        say_as_it_is(result.json(Path()).removesuffix("\n"))
    else:
        written = [path for path, _ in to_write]
        say_result(
            _text(arguments, result), written, warnings, page and page[0], getattr(arguments, "open", False)
        )
    return result.exit_code


def _text(arguments: argparse.Namespace, result: VerbResult) -> str:
    """Return a result's lines in the requested units, all of them with ``--verbose``."""
    units = getattr(arguments, "units", "metric")
    return result.full_text(units) if getattr(arguments, "verbose", False) else result.text(units)


def _page(arguments: argparse.Namespace, result: VerbResult) -> tuple[Path, bytes] | None:
    """Return the page of a result that has one, for the folder of ``-o``; none beside ``--json -``."""
    if not hasattr(arguments, "open") or arguments.json == "-":
        return None
    data = result.page(arguments.units)
    folder = Path(arguments.output) if arguments.output else usual_folder(Path(arguments.job), result)
    return None if data is None else (folder / f"{result.report['command']}.html", data)


def usual_folder(source: Path, result: VerbResult) -> Path:
    """Return the default folder of a page: ``NAME-compare`` next to a job; with the job of a crank's file."""
    from autobalance.verbs.crank_job import default_folder, is_crank

    if is_crank(source):
        return default_folder(source)
    return source.with_name(f"{source.stem}-{result.report['command']}")


def finish_in_place(
    arguments: argparse.Namespace, result: VerbResult, sources: tuple[str | Path, ...], written: str
) -> int:
    """Do the same for a command whose folder is written already; ``written`` lists it, after the rest."""
    refuse_in_results(arguments, [f"{result.report['command']}.json", *result.files()])
    arguments.output = None
    code = finish(arguments, result, sources)
    if arguments.json != "-":
        say(f"\nWritten: {written}")
    return code


def refuse_in_results(arguments: argparse.Namespace, names: Iterable[str]) -> None:
    """Refuse a ``--json`` that would take the place of a result in the folder of ``-o``.

    Parameters
    ----------
    arguments : argparse.Namespace
    names : iterable of str
        Of results in that folder; one that ends with a slash stands for all below it.

    Raises
    ------
    UsageError
        If it would.
    """
    if arguments.json in (None, "-"):
        return
    target, folder = Path(arguments.json).resolve(), Path(arguments.output).resolve()
    for name in names:
        place = folder / name
        if target == place or (name.endswith("/") and target.is_relative_to(place)):
            where = f"a result in {arguments.output}"
            raise UsageError(f"--json {arguments.json} would overwrite {where}; choose another place")


def _asked_for(arguments: argparse.Namespace, result: VerbResult) -> list[tuple[Path, bytes]]:
    """Return the files that the usual options ask for."""
    files: list[tuple[Path, bytes]] = []
    json_file, plots = getattr(arguments, "json", None), getattr(arguments, "plots", None)
    output = getattr(arguments, "output", None)
    if output is not None:
        folder = Path(output)
        files += [(folder / name, data) for name, data in result.folder_files(folder).items()]
    if plots is not None:
        folder = Path(plots)
        drawn = result.plots()
        files += [(folder / f"{name}.{end}", data) for name, by in drawn.items() for end, data in by.items()]
    if json_file not in (None, "-"):
        path = Path(str(json_file))
        files.append((path, result.json(path.parent).encode()))
    return files


def _refuse_collisions(targets: list[Path], sources: Mapping[Path, str]) -> None:
    """Refuse two outputs in one place, and an output over an input; ``sources`` names these."""
    seen: set[Path] = set()
    for target in targets:
        place = target.resolve()
        if place in sources or was_read(target):
            what = sources.get(place, "a file that is read")
            raise UsageError(f"{target} would overwrite {what}; choose another place")
        if place in seen:
            raise UsageError(f"two outputs share the path {target}; choose another path for one of them")
        seen.add(place)


def say_result(
    text: str,
    files: Sequence[Path],
    warnings: Iterable[str] = (),
    page: Path | None = None,
    opens: bool = False,
) -> None:
    """Print a result, the files that were written, and warnings; the page to open comes last.

    Parameters
    ----------
    text : str
        The result: its verdict first.
    files : sequence of Path
        Files that were written, the report's folder first.
    warnings : iterable of str
        Lines for standard error.
    page : Path or None
        Page for the browser; None if the command writes no page.
    opens : bool
        Open the page in the browser.
    """
    say(text)
    for warning in warnings:
        warn(warning)
    if files:
        say("\nWritten: " + ", ".join(whole(path) for path in files))
    if page is not None:
        say(whole(f"Open: {from_here(page)}"))
        if opens:
            import webbrowser

            webbrowser.open(page.resolve().as_uri())


def balanced(
    job: Job,
    folder: Path,
    json_file: str | None = None,
    choice: Choice | None = None,
    mode: Mode = "usual",
    fem: bool = False,
) -> BalancedFiles:
    """Run a job and put its files in place; what it warns of is still to print."""
    from autobalance.command.console import shown
    from autobalance.verbs.balanced_files import balance_to_files
    from autobalance.verbs.progress import telling

    with shown(mode) as progress:
        return balance_to_files(job, folder, json_file, telling(progress), choice, fem)


def judged(result: BalanceResult, arguments: argparse.Namespace) -> int:
    """Return the exit code of a run; with ``--strict`` a result that is not proven is above tolerance."""
    from autobalance.verbs.balance import ABOVE_TOLERANCE

    return ABOVE_TOLERANCE if arguments.strict and not result.proven else result.exit_code
