"""The declaration of a public function: name, type, default and meaning of each parameter.

Its signature and docstring are taken from the source without importing the module, whose numpy and scipy
would make ``--help`` ten times as slow.
"""

from __future__ import annotations
import __future__

import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from autobalance import units
from autobalance.verbs.common_parameters import COMMON

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
