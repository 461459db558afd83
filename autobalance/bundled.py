"""Folder of the bundled cranks: inside the installed package, or in the checkout beside it."""

from __future__ import annotations

from pathlib import Path

from autobalance.errors import FileError

PACKAGE = Path(__file__).resolve().parent


def bundled_folder() -> Path:
    """Return the folder that holds ``crf250r``.

    Raises
    ------
    FileError
        If it was not installed.
    """
    for folder in (PACKAGE / "_fixtures", PACKAGE.parent / "fixtures"):
        if (folder / "crf250r").is_dir():
            return folder
    raise FileError(f"the bundled cranks are missing from {PACKAGE / '_fixtures'}; install autobalance again")
