from pathlib import Path

import pytest

from autobalance.errors import FileError, JobError, file_errors
from autobalance.job.files import history


@pytest.mark.parametrize(
    ("name", "reason"), [("gone.csv", "no such file or directory"), ("a\0b", "embedded null byte")]
)
def test_what_the_system_refuses_is_one_line(tmp_path: Path, name: str, reason: str) -> None:
    with pytest.raises(FileError) as raised, file_errors("read the trace a.csv"):
        (tmp_path / name).open()
    assert str(raised.value) == f"cannot read the trace a.csv: {reason}"


def test_a_series_too_large_is_no_failure_of_the_system(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "history.csv"
    file.write_text("angle_deg,force_n\n" * 10)
    monkeypatch.setattr(history, "LARGEST_BYTES", 100)
    with pytest.raises(JobError, match=r"^history\.csv is larger than 100 bytes; is it a series\?$"):
        history.read_history(file, "x_N", "y_N")
