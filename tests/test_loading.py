"""What a verb loads: a formula needs no crank, and what is broken elsewhere does not break it."""

import subprocess
import sys

import pytest

PROGRAM = """
import sys

class Broken:
    def find_spec(self, name, path=None, target=None):
        if name.startswith(("autobalance.correction", "autobalance.crank", "autobalance.balancing")):
            raise SyntaxError(f"{name} is broken")

sys.meta_path.insert(0, Broken())
import autobalance as ab
CALL
print(sum(name.startswith("autobalance") for name in sys.modules))
"""
GRADE = "ab.grade(6.3, speed_rpm=3000, mass=2500)"
DRY = "ab.bearing({'kind': 'dry', 'speed_rpm': 3000, 'mu': 0.1, 'load_N': 100, 'diameter_mm': 20})"


@pytest.mark.parametrize(("call", "most"), [(GRADE, 43), (DRY, 57)])
def test_a_formula_loads_neither_cuts_nor_cranks(call: str, most: int) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.replace("CALL", call)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) <= most


def test_the_report_of_every_add_on_is_described_without_scipy() -> None:
    program = "from autobalance.balancing.sections import section_types; section_types(); import sys"
    check = "; sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program + check], check=False).returncode == 0
