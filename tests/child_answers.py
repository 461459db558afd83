"""A module that answers in a separate process, badly behaved."""

import os

from autobalance.errors import FormatError


def answer(what: str, number: int) -> int:
    """Print past Python, refuse, or end the process."""
    os.write(1, b"a line of a library")
    if what == "refuse":
        raise FormatError(f"{number} is odd")
    if what == "end":
        os._exit(number)
    return 2 * number
