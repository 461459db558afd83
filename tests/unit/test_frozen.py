"""Frozen dataclasses with shared methods are to their users what the standard library's are."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, asdict, dataclass, field, fields, is_dataclass, replace

import pytest

from autobalance.frozen import frozen


@dataclass(frozen=True)
class Standard:
    """By the standard library."""

    x: int
    y: tuple[float, ...] = (1.0,)
    note: str = field(default="", compare=False, repr=False)


@frozen
class Shared:
    """The same, with shared methods."""

    x: int
    y: tuple[float, ...] = (1.0,)
    note: str = field(default="", compare=False, repr=False)


@frozen(eq=False)
class Named(Shared):
    """With a base and its own text."""

    z: list[int] = field(default_factory=list)

    def __repr__(self) -> str:
        return "named"


@frozen(eq=False)
class Alone:
    """Equal to itself alone."""

    x: int


def test_text_equality_and_hash_are_the_standard_librarys() -> None:
    for values in ((1,), (1, (2.0,)), (1, (1.0,), "kept out")):
        one, other = Standard(*values), Shared(*values)
        assert repr(other) == repr(one).replace("Standard", "Shared")
        assert hash(other) == hash(one)
        assert (other == Shared(1)) == (one == Standard(1))
        assert asdict(other) == asdict(one)
    assert is_dataclass(Shared)
    assert [each.name for each in fields(Named)] == ["x", "y", "note", "z"]


def test_copies_are_equal_and_free_of_the_first() -> None:
    first = Shared(1, note="one")
    for copied in (copy.copy(first), copy.deepcopy(first), pickle.loads(pickle.dumps(first)), replace(first)):
        assert copied == first
        assert copied.note == "one"
    assert replace(first, x=2).x == 2


def test_nothing_can_be_set_or_deleted_afterwards() -> None:
    for thing in (Shared(1), Named(1)):
        for name in ("x", "note", "other"):
            with pytest.raises(FrozenInstanceError, match=f"cannot assign to field '{name}'"):
                setattr(thing, name, 2)
        with pytest.raises(FrozenInstanceError, match="cannot delete field 'x'"):
            delattr(thing, "x")


def test_own_text_stays_and_without_eq_an_object_equals_itself_alone() -> None:
    assert repr(Named(1)) == "named"
    thing = Alone(1)
    assert {thing: 1}[thing] == 1
    assert thing != Alone(1)
