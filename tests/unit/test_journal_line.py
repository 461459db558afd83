"""A line of a batch's journal that was changed by hand is none: its row is done anew."""

import pytest

from autobalance.report.records.batch import JournalLine

WORDS = {"name": "one", "fingerprint": "ab", "worker": "w", "started": "a", "finished": "b", "message": ""}
LINE = {"row": 1, "exit_code": 0, "try": 1, "files": {"report.json": "cd"}, **WORDS}


@pytest.mark.parametrize(
    "change", [{"exit_code": {}}, {"exit_code": "0"}, {"try": None}, {"message": 5}, {"files": []}, {"x": 1}]
)
def test_a_line_of_other_types_is_none(change: dict[str, object]) -> None:
    assert JournalLine.of(LINE) is not None
    assert JournalLine.of(LINE | change) is None
