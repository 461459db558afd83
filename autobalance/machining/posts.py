"""Dialects of NC programs, one file each; a new one registers here."""

from __future__ import annotations

import re
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar

from autobalance.errors import JobError
from autobalance.machining.input import (
    Block,
    Clamp,
    DrillCycle,
    Go,
    Index,
    MachineTool,
    Note,
    Retreat,
    ToolChange,
    Unclamp,
)

# Common part of the dialects: metric and absolute words, one comment a cut, cycles for holes.


FIRST_LINE = "G21 G90 G17 G40 G49 G80 G94 G54"


def word(letter: str, value: float) -> str:
    """Return a word with exactly four decimals, never a negative zero."""
    text = f"{value:.4f}"
    return letter + ("0.0000" if text == "-0.0000" else text)


class Post(ABC):
    """Writes blocks as lines of one dialect."""

    name: ClassVar[str]
    ending: ClassVar[str]

    def __init__(self, machine: MachineTool, lathe: bool) -> None:
        self.machine, self.lathe = machine, lathe
        self.refuse_codes()

    # --- what dialects differ in ------------------------------------------------------------------------

    @abstractmethod
    def comment(self, text: str) -> list[str]:
        """Return the lines of a comment."""

    @abstractmethod
    def head(self, number: int) -> list[str]:
        """Return the lines before the first comment; ``number`` is that of the program."""

    @abstractmethod
    def tail(self) -> list[str]:
        """Return the lines after ``M30``."""

    def refuse_codes(self) -> None:
        """Refuse codes of the machine's file that the dialect does not know.

        Raises
        ------
        JobError
            If there is one.
        """
        rotary = self.machine.rotary
        codes = {"machine.coolant": self.machine.spindle.coolant}
        if rotary is not None:
            codes |= {"rotary.unclamp": rotary.unclamp, "rotary.clamp": rotary.clamp}
        for key, code in codes.items():
            if code and not re.fullmatch(r"M\d{1,3}( P\d+)?", code):
                raise JobError(f'{key} is "{code}"; expected an M code such as "M8", or nothing')

    # --- the program ------------------------------------------------------------------------------------

    def program(self, number: int, notes: Sequence[str], blocks: Sequence[Block]) -> str:
        """Return the text of a program."""
        lines = [*self.head(number), *(line for note in notes for line in self.comment(note)), FIRST_LINE]
        if self.lathe:
            lines += self.diameters()
        for block in blocks:
            lines += self.lines(block)
        return "\n".join([*lines, "M30", *self.tail()]) + "\n"

    def diameters(self) -> list[str]:
        """Return the lines that make the machine take X words as diameters."""
        return []

    def lines(self, block: Block) -> Iterator[str]:
        """Yield the lines of a block."""
        letter = "A" if self.machine.rotary is None else self.machine.rotary.letter
        if isinstance(block, Note):
            yield from self.comment(block.text)
        elif isinstance(block, ToolChange):
            yield from self.change(block)
        elif isinstance(block, Index):
            yield from self.lines(Unclamp())
            yield f"G0 {word(letter, block.angle_deg)}"
            yield from self.lines(Clamp())
        elif isinstance(block, Unclamp | Clamp):
            rotary = self.machine.rotary
            code = "" if rotary is None else rotary.unclamp if isinstance(block, Unclamp) else rotary.clamp
            if code:
                yield code
        elif isinstance(block, Go):
            pairs = (("X", block.x), ("Y", block.y), ("Z", block.z), (letter, block.a))
            words = [word(key, value) for key, value in pairs if value is not None]
            tail = [] if block.feed is None else [word("F", block.feed)]
            yield " ".join(["G0" if block.feed is None else "G1", *words, *tail])
        elif isinstance(block, DrillCycle):
            yield from self.bore(block)
        else:
            yield from self.retreat(block)

    def change(self, block: ToolChange) -> Iterator[str]:
        """Yield the lines of a tool change; spindle and coolant run before the approach."""
        number = block.tool.number
        yield f"T{number} M6"
        yield f"S{block.rpm:.0f} M3"
        if self.machine.spindle.coolant:
            yield self.machine.spindle.coolant
        axis = "X" if self.lathe else "Z"
        yield f"G0 G43 H{number} {word(axis, block.safe_mm)}"

    def bore(self, block: DrillCycle) -> Iterator[str]:
        """Yield a drilling cycle, and its end."""
        place = f"{word('X', block.x)} {word('Y', block.y)}"
        ends = f"{word('Z', block.bottom)} {word('R', block.retract)}"
        cycle = "G81" if block.peck_mm == 0.0 else "G83"
        peck = "" if block.peck_mm == 0.0 else f" {word('Q', block.peck_mm)}"
        yield f"G98 {cycle} {place} {ends}{peck} {word('F', block.feed)}"
        yield "G80"

    def retreat(self, block: Retreat) -> Iterator[str]:
        """Yield the way back to the safe height."""
        yield f"G0 {word('X' if self.lathe else 'Z', block.safe_mm)}"
        if self.machine.spindle.coolant:
            yield "M9"
        yield "M5"


def ascii_text(text: str) -> str:
    """Return a comment in letters that every control shows, without brackets."""
    for old, new in {
        "⌀": "dia ",
        "°": " deg",
        "·": " ",
        "−": "-",
        "×": "x",
        "(": "",
        ")": "",
        "→": "to",
    }.items():
        text = text.replace(old, new)
    return re.sub(r"[^ -~]", "?", text)


# Fanuc and Haas.


MAX_LINE_CHARACTERS = 80
"""Characters of a line at most."""


class Fanuc(Post):
    """Programs for Fanuc and Haas: a percent sign at both ends, an O-number, comments in capitals."""

    name = "fanuc"
    ending = "nc"

    def comment(self, text: str) -> list[str]:
        """Return the comment in capitals, on as many lines as it takes.

        A semicolon is the end of a block there, a percent sign that of the tape.
        """
        words = ascii_text(text).upper().replace("%", "PERCENT").replace(";", ",")
        return [f"({line})" for line in textwrap.wrap(words, MAX_LINE_CHARACTERS - 2) or [""]]

    def head(self, number: int) -> list[str]:
        """Return the start of the tape and the program's number."""
        return ["%", f"O{number:04d}"]

    def tail(self) -> list[str]:
        """Return the end of the tape."""
        return ["%"]


# LinuxCNC.


KNOWN = re.compile(r"M(0?[3-9]|19|4[89]|5[0-3]|6[0-8]|7[0-3]|1\d\d)( P\d+)?")
"""M codes of LinuxCNC that may be in a machine's file; M100 to M199 are the user's own."""


class LinuxCnc(Post):
    """Programs for LinuxCNC: comments in brackets, nothing around the program."""

    name = "linuxcnc"
    ending = "ngc"

    def comment(self, text: str) -> list[str]:
        """Return the comment on a line."""
        return [f"({ascii_text(text)})"]

    def head(self, number: int) -> list[str]:
        """Return nothing: files have names."""
        del number
        return []

    def tail(self) -> list[str]:
        """Return nothing: M30 is the end."""
        return []

    def diameters(self) -> list[str]:
        """Return the code of diameter mode."""
        return ["G7"]

    def refuse_codes(self) -> None:
        """Refuse codes that LinuxCNC stops at."""
        super().refuse_codes()
        rotary = self.machine.rotary
        codes = {"machine.coolant": self.machine.spindle.coolant}
        if rotary is not None:
            codes |= {"rotary.unclamp": rotary.unclamp, "rotary.clamp": rotary.clamp}
        for key, code in codes.items():
            if code and not KNOWN.fullmatch(code):
                raise JobError(
                    f'{key} is "{code}", not a code of LinuxCNC; use for example M62 P0, M100 or nothing'
                )


POSTS: dict[str, type[Post]] = {post.name: post for post in (LinuxCnc, Fanuc)}


def post_named(name: str) -> type[Post]:
    """Return the post of a name.

    Raises
    ------
    JobError If the post is unknown.
    """
    if name not in POSTS:
        raise JobError(f'machine.post is "{name}"; expected one of {", ".join(POSTS)}')
    return POSTS[name]
