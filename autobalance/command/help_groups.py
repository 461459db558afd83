"""Groups of the help: commands by what people want, and the most used options of a command first."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterable
from typing import Final

COMMAND_GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "Start": ("demo", "start", "inspect", "init", "generate", "app"),
    "Balance a crank": ("balance", "compare", "factor", "verify", "sheet", "nc"),
    "At the balancing machine": ("recut", "influence", "machine", "grade", "jobs"),
    "Engine and dynamics": (
        *("parts", "rod", "forces", "shafts", "cycle", "strength"),
        *("bearing", "rotor", "torsion", "bench", "orders"),
    ),
    "Studies and design": ("study", "batch", "design", "fem"),
    "Reference": ("calc", "schema", "completion"),
}
"""Commands by heading, in the order of the help."""
OTHERS = "More commands"
"""Heading of commands that no group names."""


def grouped(commands: Iterable[str]) -> dict[str, list[str]]:
    """Return commands by heading, each once; groups without one of them are left out."""
    left = list(commands)
    groups = {title: [name for name in names if name in left] for title, names in COMMAND_GROUPS.items()}
    listed = {name for names in groups.values() for name in names}
    groups[OTHERS] = [name for name in left if name not in listed]
    return {title: names for title, names in groups.items() if names}


class CommandGroups(argparse.RawDescriptionHelpFormatter):
    """Lists commands under the headings of `COMMAND_GROUPS`."""

    def _format_action(self, action: argparse.Action) -> str:
        if not isinstance(action, argparse._SubParsersAction):
            return super()._format_action(action)
        entries = {each.dest: each for each in self._iter_indented_subactions(action)}
        parts = []
        for title, names in grouped(entries).items():
            parts.append(f"{title}\n")
            parts += [super(CommandGroups, self)._format_action(entries[name]) for name in names]
            parts.append("\n")
        return "".join(parts)


def most_used_first(parser: argparse.ArgumentParser, most_used: Collection[str]) -> None:
    """Leave the ``most_used`` options (by destination) in the first list of the help; others follow."""
    if not most_used:
        return
    first = parser._optionals
    first.title = "most used options"
    rest = parser.add_argument_group("more options")
    for action in tuple(first._group_actions):
        if action.dest not in most_used:
            first._group_actions.remove(action)
            rest._group_actions.append(action)
