"""Versions read from folders' names are those that the libraries' own records tell."""

from __future__ import annotations

import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from autobalance.report.library_versions import LIBRARIES, library_versions


@pytest.fixture(autouse=True)
def fresh() -> None:
    library_versions.cache_clear()


def test_folders_and_records_tell_the_same() -> None:
    assert library_versions() == {name: version(name) for name in LIBRARIES}


def test_the_first_folder_on_the_path_counts_and_what_is_not_installed_has_no_version(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = {name: version(name) for name in LIBRARIES}
    for name in ("numpy-9.8.7.dist-info", "scipy", "numpy_stl-3.0.dist-info"):
        (tmp_path / name).mkdir()
    monkeypatch.setattr(sys, "path", [str(tmp_path / "none"), str(tmp_path), *sys.path])
    assert library_versions() == installed | {"numpy": "9.8.7"}
    library_versions.cache_clear()
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert library_versions() == dict.fromkeys(LIBRARIES, None) | {"numpy": "9.8.7"}
