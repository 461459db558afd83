"""Frozen dataclasses whose methods are shared, so that the modules that hold them load quickly.

The standard library writes and compiles the source of six methods for every frozen dataclass when its
module is loaded: with the hundreds that a command needs, a fifth of a second. Here only ``__init__`` is
written so; the others are the same few functions for all. `dataclasses.fields`, ``replace``, ``asdict`` and
``is_dataclass`` work as on any dataclass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import FrozenInstanceError, dataclass, field, fields
from reprlib import recursive_repr
from typing import Any, TypeVar, dataclass_transform, overload

T = TypeVar("T")


@overload
def frozen(cls: type[T], /) -> type[T]: ...


@overload
def frozen(*, eq: bool = True) -> Callable[[type[T]], type[T]]: ...


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(cls: type[T] | None = None, /, *, eq: bool = True) -> Any:
    """Make a class what ``dataclass(frozen=True)`` makes it; a ``__repr__`` of its own or its base's stays.

    A class derived from one must be made by ``frozen`` too: those that packages outside derive from, such as
    limits of kinds of correction, are the standard library's own.

    Parameters
    ----------
    cls : type
    eq : bool
        Equal where all fields are, and hashed by them; without, an object equals itself alone.
    """

    def made(chosen: type[T]) -> type[T]:
        return _with_shared_methods(dataclass(eq=False, repr=False)(chosen), eq)

    return made if cls is None else made(cls)


def _with_shared_methods(cls: type[T], eq: bool) -> type[T]:
    shared: dict[str, Any] = {"__setattr__": _set_once, "__delattr__": _keep}
    own = vars(cls)
    if cls.__repr__ is object.__repr__:
        shared["__repr__"] = _repr
    if eq:
        if own.get("__hash__") is None:  # Python sets None beside a class's own __eq__
            shared["__hash__"] = _hash
        if "__eq__" not in own:
            shared["__eq__"] = _eq
    for name, method in shared.items():
        setattr(cls, name, method)
    return cls


def _set_once(self: Any, name: str, value: object) -> None:
    """Let ``__init__`` set each field, and nobody anything afterwards."""
    held = self.__dict__
    if name in held or name not in self.__dataclass_fields__:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")
    held[name] = value


def _keep(self: Any, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


@recursive_repr()
def _repr(self: Any) -> str:
    shown = ", ".join(f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.repr)
    return f"{type(self).__qualname__}({shown})"


def _compared(self: Any) -> tuple[object, ...]:
    return tuple(getattr(self, each.name) for each in fields(self) if each.compare)


def _eq(self: Any, other: object) -> Any:
    return _compared(self) == _compared(other) if type(other) is type(self) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_compared(self))
