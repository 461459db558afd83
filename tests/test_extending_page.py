"""The walk-through of docs/extending.md: a kind, a format, an output, a verb; a file and a line each."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import autobalance
from tests.coarse import bundled_corners
from tests.jobs import write_stl

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "extending.md"
FILE = re.compile(r"`autobalance/([a-z_/]+\.py)`[^\n]*\n\n```python\n(.*?)```", re.DOTALL)
CONTRACTS = {
    "tests/geometry/test_kind_contract.py": "notch",
    "tests/geometry/test_solid_formats.py": "-tri] and round_trip",
    "tests/report/test_output_kinds.py": "taken",
    "tests/command/test_options.py": "webs",
}
"""The tests that the page names → those of them that are of what it adds."""
UNDOCUMENTED = {
    "tests/report/test_output_kinds.py": ("page_of_outputs", "cuts.csv"),
    "tests/command/test_options.py": ("known_to_type_checkers", "import webs as webs"),
}
"""Those of them that ask for pages → what they miss."""
ENDED = re.compile(r"^(PASSED|FAILED|ERROR) (\S+?)::(.+?)(?: - .*)?$", re.MULTILINE)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of package and tests with the page's files and lines put in."""
    folder = tmp_path_factory.mktemp("tree")
    package = Path(autobalance.__file__).parent
    copied = folder / "autobalance"
    shutil.copytree(package, copied)  # with what is compiled, which holds as long as times are the same
    if not (copied / "_fixtures").exists():  # a checkout has them beside the package
        shutil.copytree(ROOT / "fixtures", folder / "fixtures")
    bundled = copied / "_fixtures" if (copied / "_fixtures").exists() else folder / "fixtures"
    write_stl(bundled / "crf250r" / "drafted" / "crank.stl", bundled_corners())  # the last example is of it
    shutil.copytree(ROOT / "tests", folder / "tests")
    shutil.copytree(ROOT / "docs", folder / "docs", ignore=shutil.ignore_patterns("_build", "_generated"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    blocks = FILE.findall(PAGE.read_text(encoding="utf-8"))
    assert len(blocks) == 8
    assert len(new_files()) == 4
    for name, code in blocks:
        with (copied / name).open("a", encoding="utf-8") as file:
            file.write(code)
    return folder


def new_files() -> list[str]:
    package = Path(autobalance.__file__).parent
    names = [name for name, _ in FILE.findall(PAGE.read_text(encoding="utf-8"))]
    return [f"autobalance/{name}" for name in names if not (package / name).exists()]


def run(tree: Path, *words: str, where: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    return subprocess.run(
        [sys.executable, *words], cwd=where, env=environment, capture_output=True, text=True, check=False
    )


def test_four_files_and_four_lines_are_enough(tree: Path, tmp_path: Path) -> None:
    """The page's last example runs."""
    examples = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    done = run(tree, "-c", examples[-1], where=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "web 2: z" in done.stdout
    report = (tmp_path / "out" / "report.json").read_text(encoding="utf-8")
    assert '"kind": "notch"' in report
    assert '"format": "tri"' in report
    rows = (tmp_path / "out" / "cuts.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "number,kind,web,depth_mm,removed_mass_g"
    assert any(",notch,1," in row for row in rows)  # numbered in the order in which one makes them
    assert '"command": "webs"' in (tmp_path / "webs.json").read_text(encoding="utf-8")


def test_help_knows_them(tree: Path) -> None:
    shown = run(tree, "-m", "autobalance", "webs", "--help", where=tree).stdout
    assert "--pressed-up" in shown
    assert "take the crank for a pressed-up one, drawn without its crankpins" in " ".join(shown.split())
    assert ".tri" in run(tree, "-m", "autobalance", "inspect", "--help", where=tree).stdout
    assert "cuts" in run(tree, "-m", "autobalance", "balance", "--help", where=tree).stdout


@pytest.fixture(scope="module")
def tested(tree: Path) -> str:
    """What one run of all those tests says: to begin one for each would take longer than they do."""
    asked = [*CONTRACTS.items(), *((file, which) for file, (which, _) in UNDOCUMENTED.items())]
    words = " or ".join(f"({Path(file).name} and {which})" for file, which in asked)
    return run(
        tree, "-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider", "-k", words, *CONTRACTS, where=tree
    ).stdout


def ends_of(tested: str, file: str, which: str) -> set[str]:
    """Return how the tests of a file ended that are of some words."""
    words = which.split(" and ")
    return {
        end
        for end, path, name in ENDED.findall(tested)
        if path == file and all(word in name for word in words)
    }


@pytest.mark.parametrize(("file", "which"), CONTRACTS.items(), ids=CONTRACTS.values())
def test_they_pass_the_tests_that_the_page_names(tested: str, file: str, which: str) -> None:
    assert f"`{file}`" in PAGE.read_text(encoding="utf-8")
    assert ends_of(tested, file, which) == {"PASSED"}, tested[-3000:]


@pytest.mark.parametrize("file", UNDOCUMENTED)
def test_what_is_not_documented_is_noticed(tested: str, file: str) -> None:
    """The same tests ask for the pages of what was added."""
    which, words = UNDOCUMENTED[file]
    assert ends_of(tested, file, which) == {"FAILED"}, tested[-3000:]
    assert words in tested


def test_their_code_is_clean(tree: Path) -> None:
    for words in (("check",), ("format", "--check")):
        done = run(tree, "-m", "ruff", *words, *new_files(), where=tree)
        assert done.returncode == 0, done.stdout
