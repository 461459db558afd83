"""Fanuc and Haas."""

from __future__ import annotations

import textwrap

from autobalance.machining.posts.post import Post, ascii_text

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
