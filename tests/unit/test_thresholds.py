"""Every number that decides in recognition, correction and estimates says what it limits, and why."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import autobalance

ROOT = Path(autobalance.__file__).parent
ROOMS = ("crank", "correction", "solid/soundness", "solid/chordal_error", "solid/roughness")


def numbers_without_reason(tree: ast.Module) -> Iterator[str]:
    """Yield names of numbers that no text explains, below them or below the numbers next to them."""
    open_: list[str] = []
    for node in tree.body:
        if isinstance(node, ast.Assign) and _is_number(node):
            open_.append(ast.unparse(node.targets[0]))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            open_ = []
        elif open_:
            yield from open_
            open_ = []
    yield from open_


def _is_number(node: ast.Assign) -> bool:
    """Tell whether a constant is a number, or a few: tables and what is computed of others are not."""
    names = node.targets[0].elts if isinstance(node.targets[0], ast.Tuple) else [node.targets[0]]
    if not all(isinstance(name, ast.Name) and name.id.strip("_").isupper() for name in names):
        return False
    values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
    values = [each.operand if isinstance(each, ast.UnaryOp) else each for each in values]
    return all(isinstance(each, ast.Constant) and isinstance(each.value, int | float) for each in values)


@pytest.mark.parametrize("room", ROOMS)
def test_every_threshold_has_a_reason(room: str) -> None:
    found = [
        f"{file.relative_to(ROOT)}: {name}"
        for file in sorted((ROOT / room).rglob("*.py"))
        for name in numbers_without_reason(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert not found


def test_a_number_without_a_text_is_found() -> None:
    tree = ast.parse("LEAST = 3\n\nMOST_MM, WIDE = 4.0, -1\n'''Both.'''\nLAST = 2\n")
    assert list(numbers_without_reason(tree)) == ["LAST"]
