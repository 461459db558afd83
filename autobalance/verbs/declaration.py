"""The declaration of a public function: its parameters, and those that many share."""

from __future__ import annotations
import __future__

import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from autobalance import units

# Parameters that many public functions share, each with its meaning written once.
#
# ``@documented`` puts them into the docstring of a function that has them; the command line reads them here.


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


# The declaration of a public function: name, type, default and meaning of each parameter.
#
# Its signature and docstring are taken from the source without importing the module, whose numpy and scipy
# would make ``--help`` ten times as slow.


PACKAGE = Path(__file__).parents[1]
REQUIRED = object()
"""Default of a parameter without one."""


class Parameter(NamedTuple):
    """A parameter as its function declares it.

    Attributes
    ----------
    name : str
    type : str
        As annotated, without ``| None``.
    default : object
        ``REQUIRED`` without one.
    choices : tuple of str
        Where the docstring's type is a set, ``{"mm", "inch"}``; else empty.
    meaning : str
        The first sentence of its description in the docstring.
    """

    name: str
    type: str
    default: Any
    choices: tuple[str, ...]
    meaning: str


@cache
def parameters_of(function: str) -> Mapping[str, Parameter]:
    """Return the parameters of a function, named as ``"signals.verb:orders"``, in their order."""
    stub = _stub(function)
    described = _described(stub.__doc__ or "")
    code = stub.__code__
    positional = code.co_varnames[: code.co_argcount]
    keyword = code.co_varnames[code.co_argcount : code.co_argcount + code.co_kwonlyargcount]
    stub_defaults = stub.__defaults__ or ()
    defaults = {
        **dict(zip(positional[len(positional) - len(stub_defaults) :], stub_defaults, strict=True)),
        **(stub.__kwdefaults__ or {}),
    }
    parameters = {}
    for name in (*positional, *keyword):
        kind, meaning = described.get(name) or COMMON.get(name, ("", ""))
        parameters[name] = Parameter(
            name,
            stub.__annotations__[name].removesuffix(" | None"),
            defaults.get(name, REQUIRED),
            tuple(re.findall(r'"([^"]+)"', kind)) if kind.startswith("{") else (),
            _first_sentence(meaning),
        )
    return parameters


def _stub(function: str) -> Callable[..., object]:
    """Return the function without its body: signature and docstring, annotations as text."""
    module, name = function.split(":")
    source = PACKAGE.joinpath(*module.split(".")).with_suffix(".py").read_text(encoding="utf-8")
    start = source.rindex(f"\ndef {name}(")
    doc = source.index('"""', start) + 3
    text = source[start : source.index('"""', doc) + 3]
    scope: dict[str, Any] = dict(vars(units))  # a default may be one of its constants
    flags = __future__.annotations.compiler_flag
    exec(compile(text, function, "exec", flags=flags, dont_inherit=True), scope)  # the program's own source
    stub: Callable[..., object] = scope[name]
    return stub


def _described(doc: str) -> Mapping[str, tuple[str, str]]:
    """Return type and description of each parameter in a numpy docstring."""
    _, _, rest = doc.partition("Parameters\n    ----------\n")
    section = re.split(r"\n\n", rest, maxsplit=1)[0].rstrip()
    described: dict[str, tuple[str, str]] = {}
    for entry in re.split(r"\n(?=    \S)", f"\n{section}")[1:]:
        head, _, body = entry.strip().partition("\n")
        names, _, kind = head.partition(" : ")
        for name in names.split(", "):
            described[name.strip("*")] = (kind, " ".join(body.split()))
    return described


def _first_sentence(text: str) -> str:
    first = re.split(r"\.(?= [A-Z0-9(`]|$)", " ".join(text.split()), maxsplit=1)[0]
    return first.replace("`", "")
