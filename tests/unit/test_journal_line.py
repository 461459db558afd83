"""A line of a batch's journal that was changed by hand is none: its row is done anew."""

import json

import pytest

from autobalance.studies.batch.journal import journal_line

WORDS = {"name": "one", "fingerprint": "ab", "worker": "w", "started": "a", "finished": "b", "message": ""}
LINE = {"row": 1, "exit_code": 0, "try": 1, "files": {"report.json": "cd"}, **WORDS}


@pytest.mark.parametrize(
    "change", [{"exit_code": {}}, {"exit_code": "0"}, {"try": None}, {"message": 5}, {"files": []}, {"x": 1}]
)
def test_a_line_of_other_types_is_none(change: dict[str, object]) -> None:
    assert journal_line(json.dumps(LINE).encode()) is not None
    assert journal_line(json.dumps(LINE | change).encode()) is None
