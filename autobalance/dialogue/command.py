"""``autobalance start [FOLDER]``: a job by questions and answers, balanced at the end."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

from autobalance.errors import FileError

EXAMPLES = """examples:
  autobalance start                      in the folder of the crank file
  autobalance start cranks -o job.toml   another folder, another job file
  autobalance start < answers.txt        one answer a line; empty: the default"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        metavar="FOLDER",
        nargs="?",
        default=".",
        help="folder with the crank file (default: this one)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="JOB.toml",
        help="job file to write, or to continue (default: job.toml in FOLDER)",
    )
    parser.epilog = EXAMPLES


def run(arguments: argparse.Namespace) -> int:
    """Ask, write the job, balance; the exit code of ``balance``, or 130 where the input ended before."""
    from autobalance.command.main import main

    folder = Path(arguments.folder)
    job_file = Path(arguments.output) if arguments.output else folder / "job.toml"
    return started(folder, job_file, sys.stdin, sys.stdout, lambda job: main(["balance", str(job)]))


def started(folder: Path, job_file: Path, lines: TextIO, out: TextIO, balance: Callable[[Path], int]) -> int:
    """Hold the dialogue and return its exit code.

    Parameters
    ----------
    folder : Path
        Folder that is searched for crank files.
    job_file : Path
        File of the answers, from which a dialogue continues.
    lines, out : text streams
        Answers, one a line, and the printed text.
    balance : callable
        Takes the finished job, balances it, prints the verdict and returns the exit code.

    Raises
    ------
    FileError
        If there is no such folder, or the job is not one of a dialogue.
    """
    from autobalance.dialogue.conversation import STOPPED, Talk, converse
    from autobalance.dialogue.questions import QUESTIONS

    if not folder.is_dir():
        raise FileError(f"{folder} is not a folder; expected the one with the crank file")
    talk = Talk(folder, job_file)
    if talk.take_up():
        out.write(f"{job_file}: its answers are kept; `back` returns to earlier questions.\n")
    out.write("?: help, back: the question before, empty: the default in brackets.\n\n")
    if not converse(talk, QUESTIONS, lines, out):
        out.write(f"\nStopped. `autobalance start {folder} -o {job_file}` continues from here.\n")
        return STOPPED
    talk.keep()
    if talk.open:
        out.write(f"{job_file} is written. Left open, to weigh or look up: {', '.join(talk.open)}.\n")
        out.write(f"Fill them in, then: autobalance balance {job_file}\n")
        return FileError.exit_code
    out.write(f"{job_file} is written. Balancing.\n\n")
    out.flush()
    code = balance(job_file)
    results = job_file.with_name(f"{job_file.stem}-balanced")
    following = {0: f"autobalance verify {results / 'report.json'}", 4: f"autobalance compare {job_file}"}
    if code in following:
        out.write(f"\nNext: {following[code]}\n")
    return code
