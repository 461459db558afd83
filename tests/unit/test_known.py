"""Results that are used again: only where asked for, only for equal questions."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.known import KEPT_OF_A_KIND, Known, once, using
from autobalance.solid.formats.read import read
from tests.jobs import BUNDLED


def answers(known: Known | None, *keys: object, settings: object = None) -> list[int]:
    """Return the number of the work that answered each key."""
    done: list[int] = []

    def work() -> int:
        done.append(len(done))
        return done[-1]

    def each() -> list[int]:
        return [once("number", partial(str, key), None, work) for key in keys]

    if known is None:
        return each()
    with using(known, settings):
        return each()


def test_nothing_is_kept_unless_asked_for() -> None:
    assert answers(None, "a", "a") == [0, 1]


def test_equal_keys_are_answered_once() -> None:
    assert answers(Known(), "a", "b", "a") == [0, 1, 0]


def test_other_settings_are_other_questions() -> None:
    known = Known()
    assert answers(known, "a", settings=1) == [0]
    assert answers(known, "b", "a", settings=2) == [0, 1]


def test_the_oldest_is_forgotten() -> None:
    keys = [*range(KEPT_OF_A_KIND), 0, KEPT_OF_A_KIND, 1, 0]  # 0 was asked for again, so 1 goes
    assert answers(Known(), *keys) == [*range(KEPT_OF_A_KIND), 0, KEPT_OF_A_KIND, KEPT_OF_A_KIND + 1, 0]


def test_failures_are_not_kept() -> None:
    known, tries = Known(), []

    def fails() -> int:
        tries.append(1)
        raise ValueError("no")

    for _ in range(2):
        try:
            with using(known):
                once("number", lambda: "a", None, fails)
        except ValueError:
            continue
    assert len(tries) == 2


def test_a_file_of_equal_bytes_is_read_once(tmp_path: Path) -> None:
    file, copy = BUNDLED / "drafted" / "crank.stl", tmp_path / "copy.stl"
    copy.write_bytes(file.read_bytes())
    with using(Known()):
        source, hints = read(file, "mm", pressed_up=True), Overrides(crankpin_in_file=False)
        assert read(copy, "mm", pressed_up=True) is source
        assert read(copy, "cm", pressed_up=True) is not source
        assert recognise(source.solid, hints) is recognise(source.solid, hints)
    assert read(file, "mm", pressed_up=True) is not source
