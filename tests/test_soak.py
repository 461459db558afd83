"""What random cases ever brought down stands: see ``make soak``."""

import gzip
import json
import random
from pathlib import Path

import pytest

from tests.soak.__main__ import CORPUS
from tests.soak.cases import KINDS, made, mutated, read

FILES = sorted(CORPUS.glob("*-damaged-*.gz"))
CASES = [json.loads(line) for line in (CORPUS / "cases.jsonl").read_text("utf-8").splitlines()]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    here = tmp_path_factory.mktemp("soak")
    made(here)
    return here


@pytest.mark.parametrize("packed", FILES, ids=lambda each: each.name)
def test_a_damaged_file_is_read_or_one_clear_line(packed: Path, tmp_path: Path) -> None:
    name = packed.name.removesuffix(".gz").partition("-damaged-")[2]
    place = tmp_path / f"damaged-{name}"
    place.write_bytes(gzip.decompress(packed.read_bytes()))
    read(place, name)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda each: f"{each['kind']}-{each['seed']}")
def test_a_case_that_once_fell_stands(case: dict[str, int | str], folder: Path) -> None:
    KINDS[str(case["kind"])][0](folder, random.Random(int(case["seed"])))


def test_damage_changes_a_file_and_is_the_same_again() -> None:
    data = bytes(range(256)) * 4
    found = {mutated(data, random.Random(seed)) for seed in range(50)}
    assert len(found) == 50
    assert data not in found
    assert mutated(data, random.Random(7)) == mutated(data, random.Random(7))
