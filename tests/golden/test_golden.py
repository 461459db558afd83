"""Whole runs against stored reports (``regenerate.py`` stores them anew)."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from tests.golden import messages
from tests.golden.regenerate import CASES, fresh_report, golden_file

RELATIVE = 1e-6
"""What other versions of the libraries may change by rounding and by their solvers' stopping rules."""
ABSOLUTE = {"_g_mm": 5e-3, "_g_mm2": 0.5}
"""The same for residuals, which are differences of large numbers [g·mm, g·mm²]."""


@pytest.mark.parametrize(("variant", "name"), CASES)
def test_report_is_as_stored(variant: str, name: str, tmp_path: Path) -> None:
    stored = json.loads(golden_file(variant, name).read_text(encoding="utf-8"))
    differences = list(compare(stored, fresh_report(variant, name, tmp_path), ""))
    assert not differences, "\n".join(differences)


def compare(stored: Any, fresh: Any, path: str) -> list[str]:
    """Return a line for each place where two reports differ; keys may be added, not lost."""
    if isinstance(stored, dict) and isinstance(fresh, dict):
        if lost := sorted(stored.keys() - fresh.keys()):
            return [f"{path}: the keys {lost} are gone"]
        return [line for key in stored for line in compare(stored[key], fresh[key], f"{path}.{key}")]
    if isinstance(stored, list) and isinstance(fresh, list) and len(stored) == len(fresh):
        return [line for k, one in enumerate(stored) for line in compare(one, fresh[k], f"{path}.{k}")]
    if _is_number(stored) and _is_number(fresh):
        same = math.isclose(stored, fresh, rel_tol=RELATIVE, abs_tol=_absolute(path))
    else:
        same = type(stored) is type(fresh) and stored == fresh
    return [] if same else [f"{path}: stored {stored!r}, now {fresh!r}"]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _absolute(path: str) -> float:
    for key in reversed(path.split(".")):
        for ending, slack in ABSOLUTE.items():
            if key.endswith(ending):
                return slack
    return 1e-6


def test_a_difference_is_seen() -> None:
    stored = {"a": [1.0, None], "b_g_mm": 5.0, "c": True}
    assert compare(stored, {"a": [1.0 + 1e-9, None], "b_g_mm": 5.004, "c": True}, "") == []
    for spoilt in (
        {"a": [1.00001, None], "b_g_mm": 5.0, "c": True},
        {"a": [1.0, 0.0], "b_g_mm": 5.0, "c": True},
        {"a": [1.0], "b_g_mm": 5.0, "c": True},
        {"a": [1.0, None], "b_g_mm": 5.01, "c": True},
        {"a": [1.0, None], "b_g_mm": 5.0, "c": 1},
        {"a": [1.0, None], "c": True},
    ):
        assert len(compare(stored, spoilt, "")) == 1


@pytest.mark.slow
def test_messages_are_as_stored() -> None:
    """``python -m tests.golden.messages`` stores them."""
    assert messages.all_messages() == messages.STORED.read_text(encoding="utf-8")
