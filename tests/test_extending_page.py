"""The walk-through of docs/extending.md: a kind, a format and a command, one file and one line each."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import autobalance

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "extending.md"
FILE = re.compile(r"`autobalance/([a-z_/]+\.py)`[^\n]*\n\n```python\n(.*?)```", re.DOTALL)


@pytest.mark.slow
def test_three_files_and_three_lines_are_enough(tmp_path: Path) -> None:
    """The package is copied, the page's files and lines are put in, and its last example runs."""
    package = Path(autobalance.__file__).parent
    copied = tmp_path / "autobalance"
    shutil.copytree(package, copied)
    if not (copied / "_fixtures").exists():  # a checkout has them beside the package
        shutil.copytree(ROOT / "fixtures", tmp_path / "fixtures")
    text = PAGE.read_text(encoding="utf-8")
    blocks = FILE.findall(text)
    new = [name for name, _ in blocks if not (package / name).exists()]
    assert len(blocks) == 6
    assert len(new) == 3
    for name, code in blocks:
        with (copied / name).open("a", encoding="utf-8") as file:
            file.write(code)
    example = re.findall(r"```python\n(.*?)```", text, re.DOTALL)[-1]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", example],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "web 2: z" in done.stdout
    report = (tmp_path / "out" / "report.json").read_text(encoding="utf-8")
    assert '"kind": "notch"' in report
    assert '"format": "tri"' in report


def test_a_job_key_is_one_line(tmp_path: Path) -> None:
    """The page's declaration is put into a copy of the package; reader, schema, template and echo have it."""
    package = Path(autobalance.__file__).parent
    shutil.copytree(package, tmp_path / "autobalance", ignore=shutil.ignore_patterns("__pycache__"))
    section = PAGE.read_text(encoding="utf-8").partition("## A key of the job")[2].partition("\n## ")[0]
    declaration, example = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    table = tmp_path / "autobalance" / "job" / "balance.py"
    head, tail = table.read_text(encoding="utf-8").split("    ),\n)\n", 1)
    table.write_text(f"{head}        {declaration.strip()},\n    ),\n)\n{tail}", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", example],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
