"""The program's way in: find the subcommand, run it, turn errors into one line and an exit code."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from io import TextIOWrapper
from typing import Any

from autobalance.command.console import complain, open_closed_streams, written
from autobalance.errors import AutobalanceError
from autobalance.runtime import interruptible, keep_freed_memory, one_thread_of_linear_algebra, reading_noted
from autobalance.version import __version__

COMMANDS: dict[str, str] = {
    "demo": "balance the bundled motocross crank twice and compare with the published result",
    "init": "write a commented job for a crank, or put a job into a workbook and back",
    "inspect": "measure a crank file: mass, axis, journals, throws, webs, unbalance, faces",
    "balance": "the main job: measure, plan, cut, measure again until within tolerance",
    "calc": "any of the documented formulas, by its name",
    "compare": "try every kind of correction and the useful mixes on one crank, like for like",
    "generate": "build a crankshaft of any layout from its dimensions, as a mesh or as STEP",
    "verify": "read a corrected solid from disk again and check every number its report claims",
    "forces": "inertia forces of the job's engine: orders, bearing loads, what each balance factor does",
    "cycle": "the working cycle: gas pressure, loads of pins and bearings, torque, speed",
    "shafts": "balance shafts: what would cancel the first and second order, and what the job's shafts leave",
    "parts": "roll up the weights of the job: rotating, reciprocating, bob-weights, with their uncertainty",
    "rod": "measure a connecting rod: eyes, mass, end weights, inertia, and the couple that two masses miss",
    "influence": "balancing by influence coefficients: what to add in each plane, from trial weights",
    "machine": "what a balancing machine reads on a rotor of known unbalance, and what following it leaves",
    "bench": "a rotor under speed control in its bearings: torque needed, and what was measured beside it",
    "rotor": "a shaft on bearings: critical speeds, modes, unbalance response, modal balancing",
    "recut": "further cuts on a corrected crank, from what a balancing machine read on it",
    "sheet": "the shop sheet and the drawing again from a report, on other paper, in other units",
    "torsion": "torsional vibration of a crank or a chain: frequencies, critical orders, torque, stress",
    "schema": "the JSON Schema of a file that the program reads or writes, for editors",
    "grade": "balance quality grades: permissible and achieved, and the list for crank drives",
    "design": "search counterweight profiles for the best that meet the balance exactly",
    "batch": "many jobs from a list or a folder: one row each, taken up again after a kill",
    "study": "many cranks to one plan: how many are within tolerance, and which ± to improve",
    "fem": "natural modes and static stress of a solid, by quadratic tetrahedra (extra)",
    "bearing": "friction, oil film, stiffness and damping of a bearing; its film through a cycle",
    "orders": "a recorded signal: spectrum, orders, natural frequencies, bearings, and what may cause them",
    "app": "the whole program in a browser, on this machine",
    "completion": "a script for bash, zsh or fish that completes commands and options",
}
"""Name of a subcommand → what it does, in the order of the help text.

Each is a module ``autobalance.command.<name>`` with ``add_arguments(parser)`` and ``run(arguments) -> int``.
Only the one that is called is imported, so that ``--help`` stays fast.
"""

INTERRUPTED = 130
NO_MEMORY = ("failed to map segment", "can't start new thread", "pthread_create has failed")
"""What the loader of libraries and threads say when there is no memory for them."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; never raises for anything a user can cause."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    open_closed_streams()
    one_thread_of_linear_algebra()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a terminal that knows no "·" or "²" shows "?"
            stream.reconfigure(errors="replace")
    try:
        with interruptible():
            return _run(arguments)
    except AutobalanceError as error:
        for line in error.lines:
            complain(f"autobalance: error: {line}")
        return error.exit_code
    except (MemoryError, ImportError, RuntimeError) as error:
        if not isinstance(error, MemoryError) and not any(words in str(error) for words in NO_MEMORY):
            raise
        complain("autobalance: error: not enough memory for this file")
        return AutobalanceError.exit_code
    except OSError as error:
        if error.filename is None and not isinstance(error, FileNotFoundError):  # of no file that was named
            raise
        named = error.filename or "the folder that this runs in"  # which may be gone
        why = (error.strerror or str(error)).lower()
        complain(f"autobalance: error: {named}: {why}")
        return AutobalanceError.exit_code
    except KeyboardInterrupt:
        complain("autobalance: interrupted; nothing half-written was left")
        return INTERRUPTED


def _run(arguments: list[str]) -> int:
    if arguments[:1] == ["calc"]:
        from autobalance.command.calc import help_for
        from autobalance.command.console import say

        text = help_for(arguments)
        if text is not None:
            say(text)
            return 0
    called = next((word for word in arguments if not word.startswith("-")), None)
    alone = called in COMMANDS and arguments[0] == called  # options before a command may ask for all of them
    listed = [name for name in COMMANDS if name == called or not alone]
    try:
        parsed = _parser(listed, lambda name: name == called).parse_args(arguments)
    except SystemExit as stop:  # 0 for --help and --version, 2 for wrong use
        return stop.code if isinstance(stop.code, int) else 2
    keep_freed_memory()
    from autobalance.command.terminal import drawn_tables

    if called == "app":  # a server, not one run: what it has read it may write again
        return int(parsed.run(parsed))
    with drawn_tables(), reading_noted():
        return int(parsed.run(parsed))


class Parser(argparse.ArgumentParser):
    """A parser whose help and errors go where everything else that is printed goes."""

    def _print_message(self, message: str, file: Any = None) -> None:
        if file is sys.stdout:
            with written():
                file.write(message)
        else:
            complain(message.removesuffix("\n"))


def full_parser() -> argparse.ArgumentParser:
    """Return the parser with the options of every command."""
    return _parser(COMMANDS, lambda _: True)


def _parser(listed: Iterable[str], wanted: Callable[[str], bool]) -> argparse.ArgumentParser:
    """Return the parser of some commands; only the ``wanted`` ones are loaded for their options."""
    parser = Parser(
        prog="autobalance",
        description="Balances crankshafts from their solid models: measures, cuts, measures again.",
        epilog="autobalance COMMAND --help tells more about each.",
    )
    parser.add_argument("--version", action="version", version=f"autobalance {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name in listed:
        subparser = subparsers.add_parser(
            name,
            help=COMMANDS[name],
            description=COMMANDS[name],
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if wanted(name):
            module = import_module(f"autobalance.command.{name}")
            verb = getattr(module, "VERB", module)
            verb.add_arguments(subparser)
            subparser.set_defaults(run=getattr(module, "run", verb.run))
    return parser
