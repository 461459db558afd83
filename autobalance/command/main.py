"""The program's way in: find the subcommand, run it, turn errors into one line and an exit code."""

from __future__ import annotations

import argparse
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from difflib import get_close_matches
from importlib import import_module
from io import TextIOWrapper
from typing import Any, NoReturn, TextIO

from autobalance import registry, runtime
from autobalance.command import objects
from autobalance.command.console import complain, fail, open_closed_streams, warn, written
from autobalance.command.help_groups import CommandGroups
from autobalance.errors import AutobalanceError, DecimalCommaWarning, UsageError, system_reason
from autobalance.registry import VERBS
from autobalance.version import __version__

WAYS_IN = """\
autobalance: error: no command was given. Use one of these, or another from `autobalance --help`
  autobalance inspect crank.stl --unit mm            measure a crank file
  autobalance init crank.stl --unit mm -o job.toml   write a job for it, to fill in
  autobalance balance job.toml                       cut the crank, with report and sheets
  autobalance verify job-balanced/report.json        check every number of the report
  autobalance generate single -o crank.stl           no crank yet: draw one
  autobalance demo                                   balance the bundled crank
  autobalance app                                    all of it in a browser"""
INTERRUPTED_EXIT_CODE = 130
INTERRUPTED_MESSAGE = "interrupted; nothing half-written was left"
DONE_EXIT_CODES = (0, 4)
"""Exit codes of a command that did what it was asked: within tolerance, or above."""
NO_CACHE_HELP = "read the crank again, without the cache (default: use the cache)"
QUICK_VERBS = ("app", "schema", "completion", "calc", "grade")
NO_MEMORY = ("failed to map segment", "can't start new thread", "pthread_create has failed")
"""Messages of the loader of libraries and of threads if they run out of memory."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; never raises for anything a user can cause."""
    arguments = _as_called_here(sys.argv[1:] if argv is None else list(argv))
    open_closed_streams()
    runtime.one_thread_of_linear_algebra()
    if argv is None:  # the process is this command's alone
        runtime.own_standard_output()
        runtime.collect_rarely()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a terminal that knows no "·" or "²" shows "?"
            stream.reconfigure(errors="replace")
    if argv is None and _may_take_long(arguments):
        from autobalance.command.supervisor import supervised

        runtime.silence_loggers()

        return supervised(lambda: _answered(arguments, is_alone=True), lambda: _stopped(arguments))
    return _answered(arguments, is_alone=argv is None)


def _may_take_long(arguments: Sequence[str]) -> bool:
    """Whether a command reads or computes what may take long; the app is ended by its own ways."""
    called = next((word for word in arguments if not word.startswith("-")), None)
    return called in VERBS and called not in QUICK_VERBS and not {"-h", "--help"} & set(arguments)


def _stopped(arguments: Sequence[str]) -> int:
    """Print that a command was stopped, in its place; return its exit code."""
    if not objects.are_asked_for(arguments):
        return _last_words()
    with objects.written_as_objects():
        return _last_words()


def _answered(arguments: list[str], is_alone: bool) -> int:
    if not objects.are_asked_for(arguments):
        return _guarded(arguments, is_alone)
    with objects.written_as_objects() as objects_out:
        code = _guarded(arguments, is_alone)
        objects_out.end(is_done=code in DONE_EXIT_CODES)
        return code


def _guarded(arguments: list[str], is_alone: bool) -> int:
    """Run a command; turn what may go wrong into a line and an exit code."""
    try:
        with runtime.interruptible(), _commas_told():
            return _run(arguments, is_alone)
    except AutobalanceError as error:
        return fail(error.lines, error.exit_code)
    except (MemoryError, ImportError, RuntimeError) as error:
        if not isinstance(error, MemoryError) and not any(words in str(error) for words in NO_MEMORY):
            raise
        return fail(["not enough memory for this file"], AutobalanceError.exit_code)
    except OSError as error:
        if error.filename is None and not isinstance(error, FileNotFoundError):  # of no file that was named
            raise
        named = error.filename or "the folder that this runs in"  # which may be gone
        why = system_reason(error)
        return fail([f"{named}: {why}"], AutobalanceError.exit_code)
    except KeyboardInterrupt:
        return _last_words()


@contextmanager
def _commas_told() -> Iterator[None]:
    """Print, once each, that a number was read with its comma as the decimal point."""
    with warnings.catch_warnings():
        warnings.simplefilter("default", DecimalCommaWarning)
        before = warnings.showwarning

        def show(
            message: Warning | str, category: type[Warning], filename: str, lineno: int,
            file: TextIO | None = None, line: str | None = None,
        ) -> None:  # fmt: skip
            if issubclass(category, DecimalCommaWarning):
                warn(str(message))
            else:
                before(message, category, filename, lineno, file, line)

        warnings.showwarning = show
        yield


def _last_words() -> int:
    """Print that the command was stopped; return its exit code."""
    as_objects = objects.current()
    if not runtime.takes_last_word():
        return INTERRUPTED_EXIT_CODE
    if as_objects is None:
        complain(f"autobalance: {INTERRUPTED_MESSAGE}")
    else:
        as_objects.fail([INTERRUPTED_MESSAGE], INTERRUPTED_EXIT_CODE)
    return INTERRUPTED_EXIT_CODE


def _run(arguments: list[str], is_alone: bool) -> int:
    if not arguments:
        complain(WAYS_IN)
        return UsageError.exit_code
    if arguments[0] in registry.OWN_HELP:
        from autobalance.command.console import say

        text = registry.loaded(registry.OWN_HELP[arguments[0]])(arguments)
        if text is not None:
            say(text)
            return 0
    called = next((word for word in arguments if not word.startswith("-")), None)
    alone = called in VERBS and arguments[0] == called  # options before a command may ask for all of them
    listed = [name for name in VERBS if name == called or not alone]
    try:
        parsed = _parser(listed, lambda name: name == called).parse_args(arguments)
    except SystemExit as stop:  # 0 for --help and --version, 2 for wrong use
        return stop.code if isinstance(stop.code, int) else 2
    runtime.keep_freed_memory()
    from autobalance.command.terminal import drawn_tables, fill_in_units

    fill_in_units(parsed)
    if called == "app":  # a server, not one run: what it has read it may write again
        return int(parsed.run(parsed))
    in_time = runtime.ended_in_time(_last_words) if is_alone else nullcontext()
    with drawn_tables(), runtime.reading_noted(), in_time, _cache_of(parsed):
        return int(parsed.run(parsed))


def _cache_of(arguments: argparse.Namespace) -> AbstractContextManager[None]:
    """Return a context that turns the cache off if the command line has ``--no-cache``."""
    if not getattr(arguments, "no_cache", False):
        return nullcontext()
    from autobalance.disk_cache import without_cache

    return without_cache()


class Parser(argparse.ArgumentParser):
    """A parser whose help and errors go where everything else that is printed goes."""

    def error(self, message: str) -> NoReturn:
        message = _helpful(message, self)
        if objects.current() is None:
            super().error(message)
        raise SystemExit(fail([message], UsageError.exit_code))

    def _print_message(self, message: str, file: Any = None) -> None:
        if file is sys.stdout:
            with written():
                file.write(message)
        else:
            complain(message.removesuffix("\n"))


OTHER_NAMES = {"version": "--version", "gui": "app", "web": "app", "new": "init"}
"""Names of commands in other programs, and their names here."""


def _as_called_here(arguments: list[str]) -> list[str]:
    """Return the arguments as this program calls its commands: ``help``, ``version``, ``gui`` are others."""
    if not arguments:
        return arguments
    first, *others = arguments
    if first.lower() == "help":
        return [*(OTHER_NAMES.get(each.lower(), each) for each in others[:1]), "--help"]
    return [OTHER_NAMES.get(first.lower(), first), *others]


def _options_of(parser: argparse.ArgumentParser) -> Iterable[str]:
    """Yield the long options of a parser and of the commands in it."""
    for action in parser._actions:
        yield from (option for option in action.option_strings if option.startswith("--"))
        if isinstance(action.choices, dict):
            for each in action.choices.values():
                yield from _options_of(each)


def _helpful(message: str, parser: argparse.ArgumentParser) -> str:
    """Return argparse's complaint in words that say what to type."""
    unknown = re.match(r"argument COMMAND: invalid choice: '(.*?)' \(choose from", message)
    if unknown is not None:
        word = unknown[1]
        close = get_close_matches(word.lower(), VERBS, 1)
        asked = f"did you mean `{close[0]}`?" if close else "expected one of `autobalance --help`"
        return f"{word!r} is not a command; {asked}"
    extra = re.match(r"unrecognized arguments: (.*)", message)
    unknown_option = extra[1].split()[0].partition("=")[0] if extra is not None else ""
    if unknown_option.startswith("--"):
        options = sorted(set(_options_of(parser)))
        longer = [each for each in options if each.startswith(unknown_option)]
        meant = longer or get_close_matches(unknown_option, options, 1)
        return f"{message}; did you mean {' or '.join(meant)}?" if meant else message
    if extra is not None and any(each.endswith((".toml", ".xlsx")) for each in extra[1].split()):
        return f"{message}; for several jobs: `autobalance batch FOLDER -o DIR`"
    return message


FIRST_STEPS = """first steps:
  autobalance inspect crank.stl --unit mm
  autobalance init crank.stl --unit mm -o job.toml
  autobalance balance job.toml

autobalance COMMAND --help explains one command, with examples."""


def full_parser() -> argparse.ArgumentParser:
    """Return the parser with the options of every command."""
    return _parser(VERBS, lambda _: True)


def _parser(listed: Iterable[str], is_loaded: Callable[[str], bool]) -> argparse.ArgumentParser:
    """Return the parser of some commands; only the ``is_loaded`` ones are loaded for their options."""
    parser = Parser(
        prog="autobalance",
        allow_abbrev=False,
        description="Balance a crankshaft from its 3D model: plan cuts, make them in the model, measure it.",
        epilog=FIRST_STEPS,
        formatter_class=CommandGroups,
    )
    parser.add_argument("--version", action="version", version=f"autobalance {__version__}")
    subparsers = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for name in listed:
        subparser = subparsers.add_parser(
            name,
            help=VERBS[name].says,
            description=VERBS[name].says,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        if is_loaded(name):
            add_arguments, run = _command(name)
            add_arguments(subparser)
            if name in registry.CRANK_READERS:
                subparser.add_argument("--no-cache", action="store_true", help=NO_CACHE_HELP)
            subparser.set_defaults(run=run)
    return parser


def _command(name: str) -> tuple[Callable[[argparse.ArgumentParser], None], Callable[[Any], int]]:
    """Return the functions that add a command's options, and that run it."""
    from autobalance.command.verb import Verb

    listed = VERBS[name]
    if not listed.command:  # it is what its function is
        verb = Verb(f"{listed.function}:{name}")
        return verb.add_arguments, verb.run
    place, _, among_others = listed.command.partition(":")
    module: Any = import_module(f"autobalance.{place}")
    if among_others:
        declared = getattr(module, among_others)
        return declared.add_arguments, declared.run
    declared = getattr(module, "VERB", module)
    return declared.add_arguments, getattr(module, "run", declared.run)
