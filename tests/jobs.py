"""Jobs on the bundled cranks, edited and run through ``main``, for tests of whole runs."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from autobalance import command
from autobalance.balancing import offers
from tests.coarse import bundled_corners
from tests.read_once import read_once

ROOT = Path(__file__).resolve().parents[1]
BUNDLED = ROOT / "fixtures" / "crf250r"
Array = NDArray[np.float64]
RECORD = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

WITH_PIN = """
[crankshaft]
file = "crank-with-pin.stl"
unit = "mm"
density_kg_m3 = 7850.0

[engine.rotating_g]
connecting_rod_big_end = 95.04
big_end_bearing = 39.00

[engine.reciprocating_g]
piston = 261.5

[balance]
factor = 0.28
grade = 6.3
speed_rpm = 15200

[correction]
method = "shoulder"
"""


def bundled_job(folder: Path, variant: str = "drafted", name: str = "factor-0.28", **edits: str) -> Path:
    """Write a bundled job with its crank to ``folder``; each edit replaces the text of a key's value.

    ``speed_rpm="1"`` puts ``speed_rpm = 1``; the empty text takes the key away. The crank's circles have a
    quarter of the bundled file's segments, and everything takes a quarter of the time.
    """
    _write_crank(folder / "crank.stl", variant, pin=False)
    return _edited(folder, variant, name, **edits)


def whole_job(folder: Path, variant: str = "drafted", name: str = "factor-0.28", **edits: str) -> Path:
    """Copy a bundled job with the bundled crank itself to ``folder``, edited as in ``bundled_job``."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(BUNDLED / variant / "crank.stl", folder)
    return _edited(folder, variant, name, **edits)


def pin_job(folder: Path, **edits: str) -> Path:
    """Write a job on the straight crank with its pin in the file, as coarse and edited as ``bundled_job``."""
    _write_crank(folder / "crank-with-pin.stl", "straight", pin=True)
    return written(folder / "job.toml", WITH_PIN, **edits)


def _write_crank(path: Path, variant: str, pin: bool) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_stl(path, bundled_corners(variant, pin=pin))


def _edited(folder: Path, variant: str, name: str, **edits: str) -> Path:
    text = (BUNDLED / variant / f"{name}.toml").read_text(encoding="utf-8")
    return written(folder / f"{name}.toml", text, **edits)


def written(path: Path, text: str, **edits: str) -> Path:
    for key, value in edits.items():
        line = f"{key} = {value}" if value else ""
        text, count = re.subn(rf"^{key} = .*$", line.replace("\\", r"\\"), text, flags=re.MULTILINE)
        assert count == 1, f"the job has {count} keys {key}"
    path.write_text(text, encoding="utf-8")
    return path


def main(arguments: Sequence[str]) -> int:
    """Run the command line; cranks that were read before are known."""
    with read_once():
        return command.main(list(arguments))


def run(*arguments: str | Path) -> int:
    """Run the command line."""
    return main([str(argument) for argument in arguments])


@contextmanager
def without_advice() -> Iterator[None]:
    """Balance without what would suffice where limits fall short: it takes longer than all the rest."""
    with pytest.MonkeyPatch.context() as patch:
        for ways in ("relaxations", "heavier", "lighter", "factor_relaxations"):
            patch.setattr(offers, ways, lambda *_, **__: [])
        yield


def balanced(job: Path, output: Path, code: int = 0, *options: str) -> dict[str, Any]:
    """Run ``balance`` and return its report."""
    assert run("balance", job, "-o", output, *options) == code
    return report_of(output)


def computed(job: Path, output: Path, code: int = 0) -> dict[str, Any]:
    """Run ``balance`` without its pages, sheets and pictures, and return its report."""
    return balanced(job, output, code, "--no-report")


def report_of(folder: Path) -> dict[str, Any]:
    values: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return values


def corners_of(path: Path) -> Array:
    """Return the corners (m, 3, 3) of a binary STL."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    assert len(data) == 84 + 50 * count
    return np.frombuffer(data, RECORD, count, 84)["corners"].astype(np.float64)


def volume_mm3(path: Path) -> float:
    """Return the volume inside the triangles of a binary STL."""
    return float(np.linalg.det(corners_of(path)).sum() / 6.0)


def write_stl(path: Path, corners: Array | NDArray[np.float32]) -> None:
    """Write triangles as a binary STL."""
    data = np.zeros(len(corners), RECORD)
    data["corners"] = corners
    path.write_bytes(b"test".ljust(80) + len(corners).to_bytes(4, "little") + data.tobytes())


def place(path: Path, placement: Array) -> None:
    """Move the part in a binary STL by a rigid motion (4, 4)."""
    write_stl(path, corners_of(path) @ placement[:3, :3].T + placement[:3, 3])


def folder_state(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder with its bytes."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
