"""A design search on disk goes on from what nobody has changed."""

import json
from pathlib import Path

import numpy as np
import pytest

from autobalance.errors import FileError
from autobalance.profile_search.candidates import JudgedDesign
from autobalance.profile_search.search import Generation, KeptSearch


@pytest.mark.parametrize("damage", [{"variables": None}, {"asked": [[1.0]]}, {"objectives": [[2.5]]}, None])
def test_a_search_goes_on_before_the_first_changed_line(
    damage: dict[str, object] | None, tmp_path: Path
) -> None:
    one = JudgedDesign(np.array([1.0, 2.0]), np.array([3.0]), 0.0, 0.0)
    kept = KeptSearch(tmp_path, "this", fresh=True)
    for number in range(3):
        kept.keep(Generation(number, np.array([[1.0, 2.0]]), (one,), ()))
    assert [each.number for each in KeptSearch(tmp_path, "this", fresh=False).generations] == [0, 1, 2]
    file = tmp_path / "search.jsonl"
    lines = file.read_text("utf-8").splitlines()
    lines[1] = "[" * 100_000 if damage is None else json.dumps({**json.loads(lines[1])} | damage)
    file.write_text("".join(f"{line}\n" for line in lines), "utf-8")
    with pytest.raises(FileError, match="another design's"):
        KeptSearch(tmp_path, "that", fresh=False)
    assert [each.number for each in KeptSearch(tmp_path, "this", fresh=False).generations] == [0]
