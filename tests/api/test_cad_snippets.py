"""The snippets of the pages on build123d and CadQuery run as they stand, where these are installed."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from tests.generated import single_step

pytestmark = pytest.mark.slow
PAGES = Path(__file__).resolve().parents[2] / "docs"
JOB = """
[crankshaft]
file = "crank.step"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = 0.14
grade = 40.0
speed_rpm = 6000
[correction]
method = "drill"
drill = { diameters_mm = [10.0] }
"""
VALID = {"build123d": "assert corrected.is_valid\n", "cadquery": "assert corrected.isValid()\n"}


@pytest.mark.parametrize("name", ["build123d", "cadquery"])
def test_the_snippet_of_a_page_runs(tmp_path: Path, name: str) -> None:
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    code = page.partition("```python\n")[2].partition("```")[0]
    (tmp_path / "crank.step").write_bytes(single_step())
    (tmp_path / "job.toml").write_text(JOB, encoding="utf-8")
    check = (
        "from autobalance.solid.cad.kernel import properties\n"
        "off = properties(corrected.wrapped).mass_g / result.crank.volume_mm3 - 1.0\n"
        "assert abs(off) < 1e-9, off\n"
        "assert result.crank.volume_mm3 < crank.volume_mm3\n"
    )
    (tmp_path / "snippet.py").write_text(code + VALID[name] + check, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "snippet.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
