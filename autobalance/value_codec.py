"""Values as bytes and back to the bit: dataclasses, tuples and arrays, without pickles.

The bytes are a NumPy archive of the arrays with a JSON text of their structure. Only
dataclasses and named tuples of this package are made again, so that bytes of a stranger can run nothing.

Classes that hold what is neither (a kernel's body) have ``to_plain()``, which returns values of the kinds
above, and a class method ``from_plain(values)``.
"""

from __future__ import annotations

import io
import json
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import IO, Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from autobalance.quantities import Text, from_listed, listed

PACKAGE = __name__.partition(".")[0]
PLAN = "plan"
"""Name of the JSON text in the archive."""

Arrays = list[NDArray[Any]]
MANY: dict[str, Any] = {"t": tuple, "l": list, "s": frozenset}


BROKEN = (ValueError, LookupError, TypeError, AttributeError, ImportError, OSError, EOFError, BadZipFile)
"""Errors from bytes that are not an archive, or an archive of something else."""


class CodecError(ValueError):
    """Bytes that hold no value, or a value that cannot be kept."""


class Plain(NamedTuple):
    """A value as a plan, which is a plain value of JSON, and the arrays that it names by number."""

    plan: Any
    arrays: Arrays


def plain_of(value: object) -> Plain:
    """Return a value as plan and arrays, those laid out as an archive keeps them.

    Raises
    ------
    CodecError
        If something in it is of no kind that can be kept.
    """
    encoder = _Encoder()
    plan = encoder.plan(value)
    return Plain(plan, [_laid_out(array) for array in encoder.arrays])


def value_of(plain: Plain) -> Any:
    """Return the value of a plan and its arrays, as reading the bytes gives it, to the bit."""
    return _Decoder(plain.arrays).value(plain.plan)


def _laid_out(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array in one piece that may be written to, by columns only where it lies so."""
    flags = array.flags
    return array if flags.writeable and (flags.c_contiguous or flags.f_contiguous) else array.copy("A")


def to_bytes(value: object) -> bytes:
    """Return a value as bytes.

    Raises
    ------
    CodecError
        If something in it is of no kind that can be kept.
    """
    stream = io.BytesIO()
    write(plain_of(value), stream)
    return stream.getvalue()


def write(plain: Plain, stream: IO[bytes]) -> None:
    """Write a value to a stream as bytes."""
    plan = json.dumps(plain.plan, separators=(",", ":"))
    arrays: dict[str, Any] = {str(place): array for place, array in enumerate(plain.arrays)}
    arrays[PLAN] = np.frombuffer(plan.encode("utf-8", "surrogatepass"), np.uint8)
    np.savez(stream, **arrays)


def from_bytes(data: bytes | memoryview) -> Any:
    """Return the value of some bytes; numbers and arrays are those that were kept, to the bit.

    Raises
    ------
    CodecError
        If they do not hold a plan.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            plan = json.loads(archive[PLAN].tobytes().decode("utf-8", "surrogatepass"))
            arrays = [archive[str(place)] for place in range(len(archive.files) - 1)]
        return value_of(Plain(plan, arrays))
    except (
        ValueError,
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        ImportError,
        OSError,
        EOFError,
    ) as error:
        raise CodecError(f"not a kept value: {error}") from None


class _Encoder:
    """Plans of values; arrays and objects that occur twice are kept once, and are one object again.

    A plan is a plain value of JSON, or a table of one kind. For values these are ``a`` array, ``g`` NumPy
    number, ``b`` bytes, ``q`` text with quantities, ``t`` tuple, ``l`` list, ``s`` frozen set, ``d`` mapping.
    For objects: ``n`` named tuple, ``c`` dataclass, ``p`` class with ``to_plain``, ``r`` an earlier object.
    """

    def __init__(self) -> None:
        self.arrays: Arrays = []
        self._seen: dict[int, int] = {}
        self._places: dict[int, int] = {}
        self._alive: list[object] = []

    def plan(self, value: object) -> Any:
        if value is None or type(value) in (bool, int, float, str):
            return value
        if isinstance(value, np.ndarray | np.generic | bytes):
            return self._numbers(value)
        if isinstance(value, Text):
            return {"q": listed(value)}
        if isinstance(value, tuple | list | frozenset | dict):
            return self._many(value)
        return self._object(value)

    def _numbers(self, value: NDArray[Any] | np.generic | bytes) -> Any:
        if isinstance(value, bytes):
            return {"b": self._array(np.frombuffer(value, np.uint8))}
        return {"a" if isinstance(value, np.ndarray) else "g": self._array(np.asarray(value))}

    def _many(self, value: Any) -> Any:
        if isinstance(value, dict):
            return {"d": [[self.plan(key), self.plan(each)] for key, each in value.items()]}
        if hasattr(value, "_fields"):
            return {"n": _name(type(value)), "v": [self.plan(each) for each in value]}
        kind = next((letter for letter, of in MANY.items() if type(value) is of), None)
        if kind is None:
            raise CodecError(f"{type(value).__name__} cannot be kept")
        return {kind: [self.plan(each) for each in (sorted(value) if kind == "s" else value)]}

    def _object(self, value: object) -> Any:
        known = self._seen.get(id(value))
        if known is not None:
            return {"r": known}
        self._alive.append(value)
        self._seen[id(value)] = number = len(self._seen)
        if hasattr(value, "to_plain"):
            return {"p": _name(type(value)), "i": number, "v": self.plan(value.to_plain())}
        if not is_dataclass(value):
            raise CodecError(f"{type(value).__name__} cannot be kept")
        content = {each.name: self.plan(getattr(value, each.name)) for each in fields(value)}
        return {"c": _name(type(value)), "i": number, "v": content}

    def _array(self, array: NDArray[Any]) -> int:
        if array.dtype.hasobject:
            raise CodecError("an array of objects cannot be kept")
        place = self._places.get(id(array))
        if place is None:
            self._alive.append(array)
            self.arrays.append(array)
            place = self._places[id(array)] = len(self.arrays) - 1
        return place


class _Decoder:
    """Values of plans."""

    def __init__(self, arrays: Arrays) -> None:
        self._arrays = arrays
        self._made: dict[int, Any] = {}

    def value(self, plan: Any) -> Any:
        if not isinstance(plan, dict):
            return plan
        kind = next(iter(plan))
        content = plan[kind]
        if kind in "agb":
            array = self._arrays[content]
            return array if kind == "a" else array[()] if kind == "g" else array.tobytes()
        if kind in MANY:
            return MANY[kind](self.value(each) for each in content)
        if kind == "d":
            return {self.value(key): self.value(each) for key, each in content}
        return from_listed(content) if kind == "q" else self._object(kind, content, plan)

    def _object(self, kind: str, content: Any, plan: Any) -> Any:
        if kind == "r":
            return self._made[content]
        made, held = _class(content), plan["v"]
        if kind == "n":
            return made(*(self.value(each) for each in held))
        if kind == "p":
            found = made.from_plain(self.value(held))
        else:
            found = object.__new__(made)
            for name, each in held.items():  # past __init__, which may round or check
                object.__setattr__(found, name, self.value(each))
        self._made[plan["i"]] = found
        return found


def _name(of: type) -> str:
    if of.__module__.partition(".")[0] != PACKAGE:
        raise CodecError(f"{of.__module__}.{of.__qualname__} cannot be kept")
    return f"{of.__module__}:{of.__qualname__}"


def _class(name: str) -> Any:
    module, _, qualified = name.partition(":")
    if module.partition(".")[0] != PACKAGE:
        raise CodecError(f"{name} is not of this program")
    found = getattr(import_module(module), qualified)
    if not (is_dataclass(found) or hasattr(found, "_fields") or hasattr(found, "from_plain")):
        raise CodecError(f"{name} is not a class of values")
    return found
