"""Faults of a file, gathered so that all of them are reported at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from autobalance.errors import JobError


class Faults:
    """Errors so far, a line each."""

    def __init__(self, *lines: str) -> None:
        self.lines = list(lines)

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Keep an error for later and continue behind the block."""
        try:
            yield
        except JobError as error:
            self.lines += error.lines

    def with_more(self, later: Faults) -> Faults:
        """Return these faults and later ones of other keys."""
        known = [line.split(maxsplit=1)[0] for line in self.lines]
        return Faults(*self.lines, *(line for line in later.lines if not _is_about(line, known)))

    def refuse(self) -> None:
        """Raise all that was gathered, in its order.

        Raises
        ------
        JobError
            If there is anything.
        """
        if self.lines:
            raise JobError(*dict.fromkeys(self.lines))


def _is_about(line: str, keys: list[str]) -> bool:
    """Return whether a line begins with a key, or a key in it; a density's material may be there."""
    name = line.split(maxsplit=1)[0].rstrip(":,;")
    return any(name == key or name.startswith((f"{key}.", f"{key}[", f"{key}_kg_m3")) for key in keys)
