"""The tree of errors that a user can cause; each owns its exit code."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager

LONGEST_MESSAGE = 1500
"""Characters of a message; a file may hold a name as long as itself."""
MOST_LINES = 20
"""Further faults of one file that are listed; more are counted."""


def one_line(text: str) -> str:
    r"""Return a text on one line, harmless to a terminal: control characters as their escapes.

    Examples
    --------
    >>> print(one_line("two\nlines"))
    two\nlines
    """
    shown = "".join(each if each.isprintable() else repr(each)[1:-1] for each in text[:LONGEST_MESSAGE])
    return shown if len(text) <= LONGEST_MESSAGE else f"{shown} ..."


class AutobalanceError(Exception):
    """Base of every error with a message for the user.

    The message is one line: what was found, what was expected, where.
    """

    exit_code = 3

    def __str__(self) -> str:
        return one_line(super().__str__())

    @property
    def lines(self) -> tuple[str, ...]:
        """Lines of the message, here a single one."""
        return (str(self),)


class UsageError(AutobalanceError):
    """Wrong use of the command line."""

    exit_code = 2


class FileError(AutobalanceError, OSError):
    """File or folder that cannot be read or written."""


class FormatError(AutobalanceError, ValueError):
    """Breach of a file's format."""


class SolidError(AutobalanceError, ValueError):
    """Mesh or solid that cannot be trusted: open, inverted, empty, self-contradictory."""


class BodiesError(SolidError):
    """File of several bodies without a choice of one."""

    def __init__(self, message: str, bodies: int = 0) -> None:
        super().__init__(message)
        self.bodies = bodies


class OverlapError(SolidError):
    """Self-overlap of a solid, by which some of its metal counts twice."""

    def __init__(self, message: str, volume_mm3: float = 0.0) -> None:
        """Take the message and the volume in doubt [mm³]."""
        super().__init__(message)
        self.volume_mm3 = volume_mm3


class JobError(AutobalanceError, ValueError):
    """Impossible, unknown or contradictory entry of a job file.

    Its text is the first fault; ``lines`` holds all faults, one for each key.
    """

    def __init__(self, message: str, *others: str) -> None:
        """Take the first fault and the others."""
        super().__init__(message)
        self.others = others

    @property
    def lines(self) -> tuple[str, ...]:
        """All faults, each on one line; the first ``MOST_LINES`` of the others, then a count."""
        more = len(self.others) - MOST_LINES
        texts = [one_line(each) for each in self.others[:MOST_LINES]]
        return (str(self), *texts, *([f"and {more} more"] if more > 0 else []))

    def within(self, place: str) -> "JobError":
        """Return the error with the place, such as a file's name, before each of its lines."""
        return JobError(*(f"{place}: {line}" for line in self.lines))


class RecognitionError(AutobalanceError, ValueError):
    """Solid without a recognisable crankshaft, or with too little of one."""


class CorrectionError(AutobalanceError, ValueError):
    """Requested correction that cannot be set up."""


class ClaimError(AutobalanceError, ValueError):
    """Claim of a report that the files on disk do not bear out."""


class DecimalCommaWarning(UserWarning):
    """A number was read with its comma as the decimal point."""


@contextmanager
def file_errors(action: str) -> Iterator[None]:
    """Turn the system's refusals inside the block into a `FileError`: ``cannot read a.csv: is a directory``.

    ``action`` names the access and its object: ``read the trace a.csv``. Nothing but file access belongs
    into the block: a ValueError counts too, which is how ``open`` refuses a NUL in a name.
    """
    try:
        yield
    except AutobalanceError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(f"cannot {action}: {system_reason(error)}") from None


def refuse_pipe(path: str | os.PathLike[str]) -> None:
    """Refuse a pipe, a socket or a device in place of a file: reading one may never end.

    What is missing or cannot be looked at is left to whoever opens it.

    Raises
    ------
    FileError
        If it is one.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise FileError(f"{path} is not a regular file; expected one on disk")


def system_reason(error: BaseException) -> str:
    """Return the system's reason for a failure, in lower case: ``no such file or directory``."""
    return (getattr(error, "strerror", None) or str(error)).lower()
