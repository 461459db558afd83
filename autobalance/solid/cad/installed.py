"""Detection of the installed CAD kernel by the names of files, without loading it."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Final

INSTALL: Final = "pip install 'autobalance[step]'"
GENERATION: Final = "8"
"""First number of the CAD kernel's version; packages of another generation have other names inside."""


def has_kernel() -> bool:
    """Return whether a CAD kernel of the generation that is needed is installed."""
    if find_spec("OCP") is None:
        return False
    versions = installed_versions()
    return not versions or any(is_of_generation(each) for each in versions)


def is_of_generation(version: str) -> bool:
    return version.partition(".")[0] == GENERATION


def installed_versions() -> tuple[str, ...]:
    """Return the versions of the packages that bring the kernel; several share one import name.

    Beside CadQuery 2.8, which brings ``cadquery-ocp`` 7.9, the extra ``step`` brings ``-novtk`` 8:
    whichever was unpacked last is known when it is loaded.
    """
    spec = find_spec("OCP")
    places = () if spec is None else spec.submodule_search_locations or ()
    names = [each.name for place in places for each in Path(place).parent.glob("cadquery_ocp*.dist-info")]
    parts = [name.removesuffix(".dist-info").partition("-") for name in names]
    return tuple(sorted(version for package, _, version in parts if package != "cadquery_ocp_proxy"))
