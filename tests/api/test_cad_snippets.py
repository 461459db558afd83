"""The snippets of the pages on build123d and CadQuery run as they stand, where these are installed."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from autobalance.solid.cad.installed import has_kernel
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
IN_MEMORY = """
from autobalance.solid.cad.kernel import properties
off = properties(corrected.wrapped).mass_g / result.crank.volume_mm3 - 1.0
assert abs(off) < 1e-9, off
assert result.crank.volume_mm3 < crank.volume_mm3
"""
BY_FILES = """
assert corrected.isValid()
rest = work.val().cut(*tools)
assert abs(rest.Volume() / corrected.Volume() - 1.0) < 5e-5  # its Volume has no tolerance: 1e-5 was seen
assert corrected.Volume() < work.val().Volume()
"""
VALID = {"build123d": "assert corrected.is_valid\n", "cadquery": "assert corrected.isValid()\n"}


def snippets(name: str) -> list[str]:
    page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    return [block.partition("```")[0] for block in page.split("```python\n")[1:]]


def run(python: str, code: str, folder: Path, crank: str) -> None:
    """Run code beside a crank and a job on it; the command ``autobalance`` is this environment's."""
    (folder / "crank.step").write_bytes(single_step())
    (folder / "job.toml").write_text(JOB.replace("crank.step", crank), encoding="utf-8")
    (folder / "snippet.py").write_text(code, encoding="utf-8")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    done = subprocess.run(
        [python, "snippet.py"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env={**os.environ, "PATH": path},
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["build123d", "cadquery"])
def test_the_snippet_for_one_environment_runs(tmp_path: Path, name: str) -> None:
    if importlib.util.find_spec(name) is None or not has_kernel():
        pytest.skip(f"{name} is not installed beside the extra 'step'")
    run(sys.executable, snippets(name)[-1] + VALID[name] + IN_MEMORY, tmp_path, "crank.step")


def test_the_snippet_for_two_environments_runs(tmp_path: Path) -> None:
    """``CADQUERY_PYTHON`` is the Python of an environment with CadQuery."""
    python = os.environ.get("CADQUERY_PYTHON")
    if python is None or not has_kernel():
        pytest.skip("CADQUERY_PYTHON names no Python with CadQuery")
    run(python, snippets("cadquery")[0] + BY_FILES, tmp_path, "to-balance.step")
