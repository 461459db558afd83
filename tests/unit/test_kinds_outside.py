"""Outside of ``correction`` nothing asks which kind a cut is."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import autobalance
from autobalance.correction import KINDS

PACKAGE = Path(autobalance.__file__).parent
MODULES = {type(kind).__module__ for kind in KINDS.values()}
NAMES = set(KINDS)
WRITE_JOBS = {
    "verbs/init.py",
    "command/init.py",
    "profile_search/written.py",
    "profile_search/input.py",
    "dialogue/questions.py",
    "job/from_options.py",
    "job/balance.py",
    "job/read.py",
    "browser/drawing.py",
}
"""Files that write jobs, in which one method has to be named, or list keys of a report."""
LIMITS = {kind.limits.__name__ for kind in KINDS.values()}


def faults_in(text: str) -> Iterator[str]:
    """Yield what asks for a kind; the corrections of influence coefficients have their own words."""
    names = NAMES if "correction" in text.lower() and "influence" not in text else set()
    if not any(word in text for word in names | LIMITS | MODULES):
        return
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node.value in names:
            yield f"line {node.lineno}: the name {node.value!r}"
        if isinstance(node, ast.Name | ast.Attribute):
            name = node.id if isinstance(node, ast.Name) else node.attr
            if name in LIMITS:
                yield f"line {node.lineno}: {name}"
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            wanted = {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
            for module in sorted(wanted & MODULES):
                yield f"line {node.lineno}: imports {module}"
        if isinstance(node, ast.Import):
            for module in sorted({each.name for each in node.names} & MODULES):
                yield f"line {node.lineno}: imports {module}"


def test_nothing_outside_asks_which_kind_a_cut_is() -> None:
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        inside = path.relative_to(PACKAGE)
        if inside.parts[0] != "correction":
            faults = faults_in(path.read_text(encoding="utf-8"))
            writes = inside.as_posix() in WRITE_JOBS
            found += [f"{inside}, {fault}" for fault in faults if not (writes and "the name" in fault)]
    assert found == []


def test_the_page_asks_neither() -> None:
    """But for the kind that its form begins with; a machine file calls a tool a drill, too."""
    quoted = re.compile("[\"'](" + "|".join(NAMES) + ")[\"']")
    pages = sorted((PACKAGE / "browser" / "static").glob("*.js"))
    found = [(path.name, name) for path in pages for name in quoted.findall(path.read_text("utf-8"))]
    assert set(found) == {("limits.js", "drill"), ("nc.js", "drill")}


def test_that_would_be_seen() -> None:
    text = (
        "from autobalance.correction.drill import DrillLimits\nfrom autobalance.correction import slug\n"
        "if item['kind'] == 'turn' or isinstance(limits, DrillLimits):\n    pass\n"
    )
    assert len(list(faults_in(text))) == 4
