"""Questions and answers, lines in and lines out: one answer a line, ``?``, ``back``, empty: default."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import field
from pathlib import Path
from typing import Any, TextIO

from autobalance.errors import AutobalanceError, FileError
from autobalance.job.from_options import HEADED, filled_in, job_text
from autobalance.report.files import Staging
from autobalance.toml_files.document import toml_of, toml_value, with_settings
from autobalance.toml_files.typed_units import FILL_IN, leaves
from autobalance.value_classes import dataclass

STOPPED = 130
"""Exit code of a dialogue whose input ended."""
WIDTH = 79
UNKNOWN = ("don't know", "dont know", "unknown")


class AnswerError(Exception):
    """An answer that cannot be used; its text is the reason."""


@dataclass
class Talk:
    """Answers so far, as tables of a job, and facts of its crank.

    Attributes
    ----------
    folder : Path
        Folder that is searched for cranks.
    job_file : Path
        File of the answers.
    tables : dict
        Keys of the job that were answered.
    open : list of str
        Keys that nobody knows yet.
    done : set of str
        Names of the questions that were answered.
    facts : dict
        Results found between questions, such as the measured crank.
    """

    folder: Path
    job_file: Path
    tables: dict[str, Any] = field(default_factory=dict)
    open: list[str] = field(default_factory=list)
    done: set[str] = field(default_factory=set)
    facts: dict[str, Any] = field(default_factory=dict)

    def set(self, key: str, value: Any) -> None:
        """Set a key of the job."""
        self.tables = with_settings(self.tables, [f"{key}={toml_value(value)}"])
        self.open = [each for each in self.open if each != key]

    def leave_open(self, key: str) -> None:
        """Keep a key to fill in."""
        if key not in self.open:
            self.open.append(key)

    def drop(self, *keys: str) -> None:
        """Forget keys, or whole tables."""
        for key in keys:
            table, _, name = key.rpartition(".")
            place: Any = self.tables
            for step in table.split(".") if table else ():
                place = place.get(step, {})
            place.pop(name, None)
            self.open = [each for each in self.open if each != key]

    def value(self, key: str) -> Any:
        """Return the value of a key; None if it was not answered."""
        place: Any = self.tables
        for step in key.split("."):
            place = place.get(step) if isinstance(place, dict) else None
        return place

    def text(self) -> str:
        """Return the job's file."""
        return job_text(filled_in(self.tables, self.open))

    def keep(self) -> None:
        """Write the answers so far."""
        with Staging([self.job_file.parent]) as staging:
            staging.add(self.job_file, self.text().encode())
            staging.commit()

    def take_up(self) -> bool:
        """Take the answers of a dialogue that was left; return whether there were any.

        Raises
        ------
        FileError
            If the job is not one that a command wrote.
        """
        if not self.job_file.exists():
            return False
        text = self.job_file.read_text(encoding="utf-8", errors="replace")
        if not HEADED.match(text):
            raise FileError(f"{self.job_file} exists and is not of a dialogue; choose another: -o JOB.toml")
        tables = toml_of(text, self.job_file.name)
        for key, value in leaves(tables):
            if value == FILL_IN:
                self.leave_open(key)
            else:
                self.set(key, value)
        return bool(tables)


@dataclass(frozen=True)
class Question:
    """One question.

    Attributes
    ----------
    name : str
    asks : callable
        Returns the lines to print before the answer; the last one is the question.
    reads : callable
        Takes the answer's text and keeps it in the talk, or raises ``AnswerError``.
    default : callable
        Returns what an empty answer stands for; None: an answer is needed.
    help : str
        What ``?`` prints.
    applies : callable
        Whether it is asked.
    keys : tuple of str
        Keys that its answer sets.
    may_be_unknown : bool
        Whether "don't know" is an answer.
    """

    name: str
    asks: Callable[[Talk], Sequence[str]]
    reads: Callable[[Talk, str], None]
    default: Callable[[Talk], str | None] = lambda _: None
    help: str = ""
    applies: Callable[[Talk], bool] = lambda _: True
    keys: tuple[str, ...] = ()
    may_be_unknown: bool = False

    def is_answered(self, talk: Talk) -> bool:
        """Return whether the answer is among those that were taken up."""
        return self.name in talk.done or (
            bool(self.keys) and all(talk.value(key) is not None for key in self.keys)
        )


def converse(talk: Talk, questions: Sequence[Question], lines: TextIO, out: TextIO) -> bool:
    """Ask all questions in their order and keep each answer; return whether all were answered.

    End of input stops the dialogue.
    """
    place = 0
    mark_taken_up(talk, questions)
    while place < len(questions):
        question = questions[place]
        if not question.applies(talk) or question.is_answered(talk):
            place += 1
            continue
        word = _ask(talk, question, lines, out)
        if word is None:
            return False
        if word == "back":
            before = [n for n in range(place) if questions[n].applies(talk)]
            place = before[-1] if before else place
            talk.done.discard(questions[place].name)
            talk.drop(*questions[place].keys)
            continue
        talk.done.add(question.name)
        talk.keep()
        place += 1
    return True


def wrapped(lines: Sequence[str]) -> str:
    """Return lines of at most ``WIDTH`` letters; none is broken inside a word or a path."""
    wrapper = textwrap.TextWrapper(WIDTH, break_long_words=False, break_on_hyphens=False)
    parts = ([line] if len(line) <= WIDTH else wrapper.wrap(line) for line in lines)
    return "\n".join(part for each in parts for part in each)


def mark_taken_up(talk: Talk, questions: Sequence[Question]) -> None:
    """Count questions without keys as answered if a later question has its keys."""
    last = max((n for n, each in enumerate(questions) if each.keys and each.is_answered(talk)), default=-1)
    talk.done |= {each.name for each in questions[: max(last, 0)] if not each.keys}


def _ask(talk: Talk, question: Question, lines: TextIO, out: TextIO) -> str | None:
    """Ask until an answer can be used; return it, ``back``, or None at the end of the input."""
    shown = question.asks(talk)
    default = question.default(talk)
    while True:
        offered = "" if default is None else f" [{default}]"
        out.write(wrapped([*shown[:-1], f"{shown[-1]}{offered}:"]) + " ")
        out.flush()
        line = lines.readline()
        out.write("" if lines.isatty() else "\n")
        if not line:
            return None
        text = line.strip()
        shown = shown[-1:]
        if text == "?":
            out.write(wrapped(question.help.splitlines()) + "\n")
            continue
        if text.lower() == "back":
            return "back"
        if not text and default is not None:
            text = default
        if text.lower() in UNKNOWN and question.may_be_unknown:
            for key in question.keys:
                talk.leave_open(key)
            return text
        try:
            if not text:
                raise AnswerError("An answer is needed; ? explains it.")
            question.reads(talk, text)
        except (AnswerError, AutobalanceError) as error:
            out.write(wrapped([str(error)]) + "\n")
            continue
        return text
