"""What is wrong with a file, gathered so that all of it is reported at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from autobalance.errors import JobError


class Faults:
    """Errors that were met so far, a line each."""

    def __init__(self, *lines: str) -> None:
        self.lines = list(lines)

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Keep an error for later and go on behind the block."""
        try:
            yield
        except JobError as error:
            self.lines += error.lines

    def refuse(self) -> None:
        """Raise all that was gathered, in its order.

        Raises
        ------
        JobError
            If there is anything.
        """
        if self.lines:
            raise JobError(*dict.fromkeys(self.lines))
