"""What a library does to the process it runs in stays in a process of ours."""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from autobalance.child_process import Children
from autobalance.errors import FormatError
from tests import jobs


@pytest.fixture
def children() -> Iterator[Children]:
    children = Children("tests.child_answers")
    yield children
    children.end()


def doubled(children: Children, number: int) -> int:
    with children.one() as child:
        child.send("double", number)
        answer: int = child.receive()
        return answer


def test_threads_have_their_answers_and_standard_output_has_none(
    children: Children, capfd: pytest.CaptureFixture[str]
) -> None:
    with ThreadPoolExecutor(3) as threads:
        assert [*threads.map(lambda number: doubled(children, number), range(9))] == [*range(0, 18, 2)]
    assert capfd.readouterr() == ("", "")


def test_one_process_serves_what_follows(children: Children) -> None:
    doubled(children, 1)
    (first,) = children._idle
    doubled(children, 2)
    assert children._idle == [first]
    first.process.kill()
    first.process.wait()
    assert doubled(children, 3) == 6  # by another


def test_what_it_refuses_is_raised_here_and_it_goes_on(children: Children) -> None:
    with children.one() as child:
        child.send("refuse", 3)
        with pytest.raises(FormatError, match="3 is odd"):
            child.receive()
    assert doubled(children, 3) == 6
    assert children._idle == [child]


def test_an_end_instead_of_an_answer_is_none_and_a_code(children: Children) -> None:
    with children.one() as child:
        child.send("end", 7)
        assert child.receive() is None
        assert child.end() == 7
    assert doubled(children, 3) == 6


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no copies of a process here")
def test_a_copy_of_this_process_asks_a_process_of_its_own() -> None:
    code = (
        "import os, sys; from autobalance.child_process import Children; from tests.unit.test_child_process "
        "import doubled; children = Children('tests.child_answers'); doubled(children, 1); copy = os.fork();"
        "code = 0 if doubled(children, 4 if copy else 5) == (8 if copy else 10) else 1;"
        "sys.exit(code if not copy else code or os.waitpid(copy, 0)[1])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(jobs.ROOT)},
        check=False,
        timeout=60,
    )
    assert done.returncode == 0
