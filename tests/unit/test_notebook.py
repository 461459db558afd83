"""The notebooks run from their first cell to their last, as printed."""

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SAID = {
    "balance_in_python": ("within_tolerance", "all claims hold: True"),
    "cycle_and_torsion": ("torque-over-angle", "angle_deg"),
    "tolerances_and_design": (),
}


def test_every_notebook_is_tried() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.ipynb")} == set(SAID)


@pytest.mark.parametrize("name", SAID)
def test_every_cell_of_the_notebook_runs(name: str) -> None:
    notebook = EXAMPLES / f"{name}.ipynb"
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    names: dict[str, Any] = {}
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        for source in sources:
            exec(compile(source, notebook.name, "exec"), names)
    for each in SAID[name]:
        assert each in said.getvalue()
    assert not any(cell.get("outputs") for cell in cells)  # what it shows is made anew when the site is built
