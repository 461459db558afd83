"""Libraries that are not installed, or are others: as Python finds them, without touching the program."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import pytest


def uninstalled(patch: pytest.MonkeyPatch, *names: str) -> None:
    """Let Python find no library of these names."""
    for name in names:
        patch.setitem(sys.modules, name, None)  # neither found nor imported


def installed_instead(
    patch: pytest.MonkeyPatch, folder: Path, name: str, code: str = "", packages: Iterable[str] = ()
) -> None:
    """Let Python find a library of ``code``, unpacked into ``folder`` from packages with these versions."""
    (folder / name).mkdir(parents=True)
    (folder / name / "__init__.py").write_text(code, encoding="utf-8")
    for package in packages:
        (folder / f"{package}.dist-info").mkdir()
    uninstalled(patch, name)  # what was loaded comes back afterwards
    del sys.modules[name]
    patch.syspath_prepend(folder)
