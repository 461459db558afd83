"""Store the reports of whole runs anew: ``python -m tests.golden.regenerate``; then read the difference.

These compare the program with itself, tightly; published values are compared in ``tests/reference``.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from tests import jobs

HERE = Path(__file__).parent
CASES = [
    (variant, name) for variant in ("straight", "drafted") for name in ("factor-0.28", "factor-original")
]


def golden_file(variant: str, name: str) -> Path:
    return HERE / f"{variant}-{name}.json"


def fresh_report(variant: str, name: str, folder: Path) -> dict[str, Any]:
    """Run a bundled job in a folder and return its report without what changes from run to run."""
    report = jobs.balanced(jobs.whole_job(folder, variant, name), folder / "out")
    del report["autobalance"], report["seconds"]
    del report["job"]["file"], report["input"]["file"]
    del report["outputs"]["solid"]["triangles"]  # manifold3d's version
    for output in report["outputs"].values():
        del output["sha256"]  # pages hold the whole report, with every key that is added
    return report


def main() -> None:
    for variant, name in CASES:
        with tempfile.TemporaryDirectory() as folder:
            report = fresh_report(variant, name, Path(folder))
        text = json.dumps(report, indent=1, ensure_ascii=False, allow_nan=False)
        golden_file(variant, name).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
