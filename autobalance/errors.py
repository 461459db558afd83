"""The tree of errors that a user can cause; each owns its exit code."""

from collections.abc import Iterator
from contextlib import contextmanager

LONGEST_MESSAGE = 1500
"""Characters of a message; a file may hold a name as long as itself."""
MOST_LINES = 20
"""Further faults of one file that are listed; more are counted."""


def one_line(text: str) -> str:
    r"""Return a text on one line that does nothing to a terminal: control characters as their escapes.

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
        """All that it has to say, each on one line."""
        return (str(self),)


class UsageError(AutobalanceError):
    """The command line was used wrongly."""

    exit_code = 2


class FileError(AutobalanceError, OSError):
    """A file or folder cannot be read or written."""


class FormatError(AutobalanceError, ValueError):
    """A file breaks its format."""


class SolidError(AutobalanceError, ValueError):
    """A mesh or solid cannot be trusted: open, inverted, empty, self-contradictory."""


class BodiesError(SolidError):
    """A file holds several bodies, and none was chosen."""

    def __init__(self, message: str, bodies: int = 0) -> None:
        """Take the message and how many there are."""
        super().__init__(message)
        self.bodies = bodies


class OverlapError(SolidError):
    """A solid overlaps itself, so that some of its metal counts twice."""

    def __init__(self, message: str, volume_mm3: float = 0.0) -> None:
        """Take the message and the volume in doubt [mm³]."""
        super().__init__(message)
        self.volume_mm3 = volume_mm3


class JobError(AutobalanceError, ValueError):
    """A job file holds something impossible, unknown or contradictory.

    Its text is what was found first; ``lines`` has all that was found wrong, a line a key.
    """

    def __init__(self, message: str, *others: str) -> None:
        """Take what was found first, and what else."""
        super().__init__(message)
        self.others = others

    @property
    def lines(self) -> tuple[str, ...]:
        """Everything that is wrong, each on one line; of very many the first."""
        more = len(self.others) - MOST_LINES
        texts = [one_line(each) for each in self.others[:MOST_LINES]]
        return (str(self), *texts, *([f"and {more} more"] if more > 0 else []))

    def within(self, place: str) -> "JobError":
        """Return the error with the place, such as a file's name, before each of its lines."""
        return JobError(*(f"{place}: {line}" for line in self.lines))


class RecognitionError(AutobalanceError, ValueError):
    """No crankshaft, or not enough of one, was found in the solid."""


class CorrectionError(AutobalanceError, ValueError):
    """A correction cannot be set up as asked."""


class ClaimError(AutobalanceError, ValueError):
    """A report claims something that the files on disk do not bear out."""


@contextmanager
def file_errors(action: str) -> Iterator[None]:
    """Raise what the system refuses inside the block as a `FileError`: ``cannot read a.csv: is a directory``.

    ``action`` is what is done there, and to what: ``read the trace a.csv``. Nothing but file access belongs
    into the block: a ValueError counts too, which is how ``open`` refuses a NUL in a name.
    """
    try:
        yield
    except AutobalanceError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(f"cannot {action}: {system_reason(error)}") from None


def system_reason(error: BaseException) -> str:
    """Return the system's reason for a failure, in lower case: ``no such file or directory``."""
    return (getattr(error, "strerror", None) or str(error)).lower()
