"""A kind of file for people that a balancing run can write."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from autobalance.report.material import Material


class OutputKind(NamedTuple):
    """A kind of file beside the solid and ``report.json``.

    Attributes
    ----------
    name : str
        As ``--only`` and ``write(only=...)`` take it.
    files : mapping
        Key in ``outputs`` of the report → name of the file.
    make : callable
        Material of a run → bytes by the same keys.
    is_usual : bool
        Whether it is written if nothing is chosen.
    is_to_fill : bool
        Whether people write into it afterwards: then it is not listed in ``outputs``, and one that lies there
        is left as it is.
    is_paper : bool
        Whether it is handed on: its name then begins with part and serial, where the job has them.
    require : callable
        Raises ``FormatError`` where the extra that it needs is not installed.
    """

    name: str
    files: Mapping[str, str]
    make: Callable[[Material], Mapping[str, bytes]]
    is_usual: bool = True
    require: Callable[[], None] = lambda: None
    is_to_fill: bool = False
    is_paper: bool = False

    def named(self, prefix: str) -> Mapping[str, str]:
        """Return the files by their keys, with a prefix if they are papers."""
        return {key: prefix * self.is_paper + name for key, name in self.files.items()}
