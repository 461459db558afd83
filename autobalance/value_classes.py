"""Dataclasses whose methods are made when they are needed: a command defines 400 classes and uses some.

`dataclasses.dataclass` compiles six methods of every class from text, half a millisecond a class: a
quarter of the time of a command on a small crank. Here one function serves a method of all classes, and
``__init__`` is compiled when it is first looked up. Fields, and what reads them, are the standard library's.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Hashable
from dataclasses import MISSING, Field, FrozenInstanceError
from functools import cache
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, cast

T = TypeVar("T")


class Options(NamedTuple):
    """Parameters of the decorator, of the same meaning as the standard library's."""

    frozen: bool = False
    eq: bool = True
    repr: bool = True
    kw_only: bool = False


def _dataclass(of: type[T] | None = None, /, **options: bool) -> type[T] | Callable[[type[T]], type[T]]:
    """Make a class a dataclass, as `dataclasses.dataclass` does; its options are those of `Options`."""
    chosen = Options(**options)

    def made(cls: type[T]) -> type[T]:
        # What the standard library derives from one of its frozen classes it must make itself.
        if any(map(dataclasses.is_dataclass, cls.__mro__[1:])):
            return dataclasses.dataclass(**chosen._asdict())(cls)
        return _made(cls, chosen)

    return made if of is None else made(of)


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass  # noqa: PLC0414 - type checkers know it by its name
else:
    dataclass = _dataclass


@cache
def _parameters(options: Options) -> Any:
    """Return the standard library's record of the options, which tells what may derive from a class."""
    bare: Any = dataclasses.dataclass(**options._asdict())(type("Bare", (), {}))
    return bare.__dataclass_params__


def _made(cls: type[T], options: Options) -> type[T]:
    undescribed = cls.__doc__ is None
    if undescribed:  # else the signature would be asked for, which compiles ``__init__``
        cls.__doc__ = cls.__name__
    dataclasses.dataclass(init=False, repr=False, eq=False, kw_only=options.kw_only)(cls)
    fields = dataclasses.fields(cast("Any", cls))
    if undescribed:
        cls.__doc__ = f"{cls.__name__}({', '.join(each.name for each in fields)})"
    methods: dict[str, Any] = {
        "__dataclass_params__": _parameters(options),
        "__init__": _Constructor(cls, options.frozen),
    }
    if options.repr and "__repr__" not in cls.__dict__:
        methods["__repr__"] = _shown_by(tuple(each.name for each in fields if each.repr))
    if options.eq:
        methods |= _compared_by(cls, _values([each.name for each in fields if each.compare]), options.frozen)
    if options.frozen:
        methods |= _frozen(cls, frozenset(each.name for each in fields))
    for name, method in methods.items():
        setattr(cls, name, method)
    return cls


def _values(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return the function that gives the values of attributes."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda instance: tuple(getattr(instance, name) for name in names)


def _shown_by(names: tuple[str, ...]) -> Callable[[Any], str]:
    @recursive_repr()
    def __repr__(self: Any) -> str:  # noqa: N807
        here = [each for each in names if hasattr(self, each)]  # a record that was read partly lacks some
        return f"{type(self).__qualname__}({', '.join(f'{each}={getattr(self, each)!r}' for each in here)})"

    return __repr__


def _compared_by(cls: type[Any], values: Callable[[Any], tuple[Any, ...]], is_frozen: bool) -> dict[str, Any]:
    """Return ``__eq__`` and ``__hash__``, unless the class has its own: no hash if its values may change."""

    def __eq__(self: Any, other: object) -> bool:  # noqa: N807
        return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

    def __hash__(self: Hashable) -> int:  # noqa: N807
        return hash(values(self))

    own = cls.__dict__
    made: dict[str, Any] = {} if "__eq__" in own else {"__eq__": __eq__}
    return made if own.get("__hash__") is not None else made | {"__hash__": __hash__ if is_frozen else None}


def _frozen(cls: type[Any], names: frozenset[str]) -> dict[str, Any]:
    """Return the methods that refuse to change a field; a derived class may have attributes besides."""

    def __setattr__(self: Any, name: str, value: object) -> None:  # noqa: N807
        if type(self) is cls or name in names:
            raise FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def __delattr__(self: Any, name: str) -> None:  # noqa: N807
        if type(self) is cls or name in names:
            raise FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    return {"__setattr__": __setattr__, "__delattr__": __delattr__}


class _Constructor:
    """The ``__init__`` of a class until it is first looked up, which puts the compiled one in its place."""

    def __init__(self, of: type[Any], is_frozen: bool) -> None:
        self.of, self.is_frozen = of, is_frozen

    def __get__(self, instance: object, owner: type[Any] | None = None) -> Any:
        made = _compiled(self.of, self.is_frozen)
        self.of.__init__ = made
        return made if instance is None else made.__get__(instance, owner)


class _LeftOut:
    """Default of an argument whose field has a ``default_factory``."""

    def __repr__(self) -> str:
        return "<factory>"


_LEFT_OUT = _LeftOut()


def _compiled(cls: type[Any], is_frozen: bool) -> Any:
    """Return ``__init__`` of a dataclass."""
    fields = dataclasses.fields(cls)
    taken = [each for each in fields if each.init]
    by_keyword = [_argument(each) for each in taken if each.kw_only]
    arguments = [_argument(each) for each in taken if not each.kw_only]
    arguments = ["self", *arguments, *(["*", *by_keyword] if by_keyword else [])]
    body = [_assigned(each, is_frozen) for each in fields if each.init or each.default_factory is not MISSING]
    body += ["self.__post_init__()"] if hasattr(cls, "__post_init__") else []
    given = {"_put": object.__setattr__, "_left_out": _LEFT_OUT}
    given |= {f"_default_{each.name}": each.default for each in fields}
    given |= {f"_make_{each.name}": each.default_factory for each in fields}
    lines = [
        f"def _with({', '.join(given)}):",
        f" def __init__({', '.join(arguments)}):",
        *(f"  {line}" for line in body or ["pass"]),
        " return __init__",
    ]
    names: dict[str, Any] = {}
    exec("\n".join(lines), sys.modules[cls.__module__].__dict__, names)
    made = names["_with"](**given)
    made.__qualname__ = f"{cls.__qualname__}.__init__"
    made.__annotations__ = {each.name: each.type for each in taken} | {"return": None}
    return made


def _argument(field: Field[Any]) -> str:
    if field.default is not MISSING:
        return f"{field.name}=_default_{field.name}"
    return field.name if field.default_factory is MISSING else f"{field.name}=_left_out"


def _assigned(field: Field[Any], is_frozen: bool) -> str:
    """Return the line that sets a field."""
    value = field.name if field.init else f"_make_{field.name}()"
    if field.init and field.default_factory is not MISSING:
        value = f"_make_{field.name}() if {field.name} is _left_out else {field.name}"
    return f"_put(self, {field.name!r}, {value})" if is_frozen else f"self.{field.name} = {value}"
