import os
from pathlib import Path

import pytest

from autobalance.engines.bearings.input import read_history
from autobalance.errors import FileError, JobError, file_errors


@pytest.mark.parametrize(
    ("name", "reason"), [("gone.csv", "no such file or directory"), ("a\0b", "embedded null byte")]
)
def test_what_the_system_refuses_is_one_line(tmp_path: Path, name: str, reason: str) -> None:
    with pytest.raises(FileError) as raised, file_errors("read the trace a.csv"):
        (tmp_path / name).open()
    assert str(raised.value) == f"cannot read the trace a.csv: {reason}"


def test_a_series_too_large_is_no_failure_of_the_system(tmp_path: Path) -> None:
    file = tmp_path / "history.csv"
    file.touch()
    os.truncate(file, (1 << 27) + 1)  # a hole: it takes no room on the disk
    with pytest.raises(JobError, match=r"^history\.csv is larger than 134217728 bytes; is it a series\?$"):
        read_history(file, "x_N", "y_N")
