"""Dataclasses made when they are needed do all that the standard library's do."""

from __future__ import annotations

import dataclasses
import inspect
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, field
from dataclasses import dataclass as standard
from functools import cached_property
from typing import Any

import pytest

from autobalance.value_classes import dataclass as quick

Decorator = Callable[..., Any]


def samples(decorator: Decorator) -> dict[str, Any]:
    """Return classes of every kind in use, made by a decorator."""

    @decorator(frozen=True)
    class Plain:
        """With a description."""

        width: float
        names: tuple[str, ...] = ()
        parts: list[int] = field(default_factory=list)
        hidden: int = field(default=3, repr=False, compare=False)

        @cached_property
        def doubled(self) -> float:
            return 2.0 * self.width

    @decorator(frozen=True, kw_only=True)
    class ByKeyword:
        first: int = 1
        second: int

    @decorator
    class Changing:
        value: int
        square: int = field(init=False)

        def __post_init__(self) -> None:
            self.square = self.value**2

    @decorator(frozen=True, eq=False, repr=False)
    class Bare:
        value: int

        def __repr__(self) -> str:
            return "bare"

    @decorator(frozen=True)
    class OwnComparison:
        value: int

        def __eq__(self, other: object) -> bool:
            return True

        __hash__ = None  # type: ignore[assignment]

    @decorator(frozen=True)
    class Derived(Plain):
        depth: float = 1.0

    @decorator(frozen=True)
    class Empty:
        pass

    return {each.__name__: each for each in (Plain, ByKeyword, Changing, Bare, OwnComparison, Derived, Empty)}


OURS, THEIRS = samples(quick), samples(standard)
CALLS: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = [
    ("Plain", (1.5,), {}),
    ("Plain", (1.5, ("a",)), {"parts": [1], "hidden": 4}),
    ("ByKeyword", (), {"second": 2}),
    ("Changing", (3,), {}),
    ("Derived", (1.0,), {"depth": 2.0}),
    ("Empty", (), {}),
]


@pytest.mark.parametrize("name", OURS)
def test_class_looks_as_the_standard_library_makes_it(name: str) -> None:
    ours, theirs = OURS[name], THEIRS[name]
    assert str(inspect.signature(ours)) == str(inspect.signature(theirs))
    assert ours.__init__.__annotations__ == theirs.__init__.__annotations__
    assert ours.__init__.__qualname__ == theirs.__init__.__qualname__
    assert str(ours.__dataclass_params__) == str(theirs.__dataclass_params__)
    assert ours.__match_args__ == theirs.__match_args__
    assert (ours.__hash__ is None) == (theirs.__hash__ is None)
    assert (ours.__hash__ is object.__hash__) == (theirs.__hash__ is object.__hash__)


@pytest.mark.parametrize(("name", "values", "by_name"), CALLS)
def test_instances_show_compare_and_change_alike(
    name: str, values: tuple[Any, ...], by_name: dict[str, Any]
) -> None:
    ours, again, theirs = (each[name](*values, **by_name) for each in (OURS, OURS, THEIRS))
    assert repr(ours) == repr(theirs)
    assert ours == again
    assert ours != theirs
    assert dataclasses.asdict(ours) == dataclasses.asdict(theirs)
    changed = dict.fromkeys([each.name for each in dataclasses.fields(ours) if each.init][:1], 9)
    assert repr(dataclasses.replace(ours, **changed)) == repr(dataclasses.replace(theirs, **changed))
    assert (dataclasses.replace(ours, **changed) == ours) is not bool(changed)


def test_equal_values_hash_alike_and_lists_are_their_own() -> None:
    plain = OURS["ByKeyword"]
    assert hash(plain(second=2)) == hash(plain(second=2))
    assert len({plain(second=2), plain(second=2), plain(second=3)}) == 2
    assert OURS["Plain"](1.0).parts is not OURS["Plain"](1.0).parts
    with pytest.raises(TypeError, match="unhashable"):
        hash(OURS["Plain"](1.0))  # of a list
    with pytest.raises(TypeError, match="unhashable"):
        hash(OURS["Changing"](1))


@pytest.mark.parametrize("classes", [OURS, THEIRS])
def test_what_is_frozen_does_not_change(classes: dict[str, Any]) -> None:
    plain = classes["Plain"](1.0)
    assert plain.doubled == 2.0
    for name in ("width", "new"):
        with pytest.raises(FrozenInstanceError, match=f"cannot assign to field '{name}'"):
            setattr(plain, name, 2.0)
    with pytest.raises(FrozenInstanceError, match="cannot delete field 'width'"):
        del plain.width

    class Loose(classes["Plain"]):  # type: ignore[misc, name-defined, valid-type]
        pass

    loose = Loose(1.0)
    loose.new = 2.0
    with pytest.raises(FrozenInstanceError):
        loose.width = 2.0


def test_wrong_arguments_are_refused_alike() -> None:
    for values, by_name in (((), {}), ((1.0, (), [], 3, 4), {}), ((1.0,), {"other": 1})):
        refusals = []
        for classes in (OURS, THEIRS):
            with pytest.raises(TypeError) as refused:
                classes["Plain"](*values, **by_name)
            refusals.append(str(refused.value))
        assert refusals[0] == refusals[1]


def test_standard_library_derives_from_such_a_class() -> None:
    @standard(frozen=True)
    class Limits(OURS["Plain"]):  # type: ignore[misc, name-defined, valid-type]
        deepest: float = 5.0

    assert repr(Limits(1.0, deepest=2.0)).endswith("Limits(width=1.0, names=(), parts=[], deepest=2.0)")
    with pytest.raises(TypeError, match="non-frozen"):

        @standard
        class Wrong(OURS["Plain"]):  # type: ignore[misc, name-defined, valid-type]
            pass


@quick(frozen=True)
class Kept:
    """At module level, as what is pickled must be."""

    value: int


def test_instance_survives_a_pickle() -> None:
    assert pickle.loads(pickle.dumps(Kept(3))) == Kept(3)
