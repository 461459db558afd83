"""LinuxCNC."""

from __future__ import annotations

import re

from autobalance.errors import JobError
from autobalance.machining.posts.post import Post, ascii_text

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
