"""Keys of each file that the program reads beside a job, by the name of its schema."""

from __future__ import annotations

from collections.abc import Mapping

from autobalance import registry
from autobalance.declare import Key


def forms_of(name: str) -> Mapping[str, tuple[Key, ...]]:
    """Return the keys at the top level of a file, by its form; most have one, without a name."""
    declared = registry.loaded(registry.FILES[name])
    if callable(declared):
        declared = declared()
    return declared if isinstance(declared, Mapping) else {"": declared}
