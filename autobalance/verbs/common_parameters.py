"""Parameters that many public functions share, each with its meaning written once.

``@documented`` puts them into the docstring of a function that has them; the command line reads them here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Function = TypeVar("Function", bound=Callable[..., object])

COMMON = {
    "cluster": (
        "str or None",
        "Address of a Dask scheduler, whose workers are used instead; None: processes on this machine.",
    ),
    "cluster_timeout_s": ("float", "Longest wait for the cluster's answer [s]."),
    "crank": ("Crank or None", "Crank used instead of the job's crank file."),
    "progress": (
        "callable or None",
        "``progress(message, share)`` is called at each step, the share done from 0 to 1;\n"
        "raise from it to cancel.",
    ),
    "settings": (
        "sequence of str",
        "Key of the job to set before it is checked, for example balance.factor=0.5. Each as text:\n"
        '``["balance.factor=0.5"]``.',
    ),
    "workers": ("int or None", "Number of processes on this machine; None: one for each core."),
}
"""Name → its type and meaning, as a numpy docstring has them."""


def documented(function: Function) -> Function:
    """Add the meaning of the function's common parameters to its docstring, in the order of its signature."""
    doc = function.__doc__
    if doc is None:  # python -OO
        return function
    lines = doc.split("\n")
    start = next(number for number, line in enumerate(lines) if line.strip() == "Parameters") + 2
    end = next((n for n in range(start, len(lines)) if not lines[n].strip()), len(lines))
    if not lines[-1].strip():
        end = min(end, len(lines) - 1)
    entries = _entries(lines[start:end])
    code = function.__code__
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    for name in names:
        if name not in entries and name in COMMON:
            kind, meaning = COMMON[name]
            entries[name] = [f"    {name} : {kind}", *(f"        {line}" for line in meaning.split("\n"))]
    ordered = sorted(entries, key=lambda name: names.index(name) if name in names else len(names))
    lines[start:end] = [line for name in ordered for line in entries[name]]
    function.__doc__ = "\n".join(lines)
    return function


def _entries(lines: list[str]) -> dict[str, list[str]]:
    """Return the lines of each parameter, by its (first) name."""
    entries: dict[str, list[str]] = {}
    for line in lines:
        if line[4:5] not in ("", " "):
            entries[line.strip().partition(" : ")[0].partition(",")[0].lstrip("*")] = [line]
        else:
            entries[next(reversed(entries))].append(line)
    return entries
