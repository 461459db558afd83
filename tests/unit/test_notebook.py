"""The notebook for newcomers runs from its first cell to its last, as printed."""

import contextlib
import io
import json
from pathlib import Path
from typing import Any

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "balance_in_python.ipynb"


def test_every_cell_of_the_notebook_runs() -> None:
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    names: dict[str, Any] = {}
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        for source in sources:
            exec(compile(source, NOTEBOOK.name, "exec"), names)
    assert "within_tolerance" in said.getvalue()
    assert "all claims hold: True" in said.getvalue()
    assert not any(cell.get("outputs") for cell in cells)  # what it shows is made anew when the site is built
