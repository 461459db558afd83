"""Every word that FreeCAD's window shows of the workbench stands in its files of translations."""

import ast
from pathlib import Path
from xml.etree import ElementTree

import pytest

from autobalance.drawn_cranks.design import PRESETS

ROOM = Path(__file__).resolve().parents[2] / "freecad" / "freecad" / "autobalance"


def shown() -> set[str]:
    """Return the texts that are given to ``translate``: by themselves, in tables of fields, in commands."""
    texts: set[str] = set()
    for name in ("panel", "commands"):
        for node in ast.walk(ast.parse((ROOM / f"{name}.py").read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                count = {"translate": 1, "Command": 2}.get(node.func.id, 0)
                texts |= {str(each.value) for each in node.args[:count] if isinstance(each, ast.Constant)}
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("LISTS", "NUMBERS"):
                texts |= {words for _, words in ast.literal_eval(node.value)}
    return texts


def test_the_presets_to_choose_from_are_those_of_the_generator() -> None:
    tree = ast.parse((ROOM / "commands.py").read_text(encoding="utf-8"))
    lists = {ast.unparse(each.targets[0]): each.value for each in tree.body if isinstance(each, ast.Assign)}
    assert ast.literal_eval(lists["PRESETS"]) == tuple(PRESETS)


@pytest.mark.parametrize("name", ["autobalance.ts", "autobalance_de.ts"])
def test_every_word_can_be_translated(name: str) -> None:
    tree = ElementTree.parse(ROOM / "translations" / name)
    (context,) = tree.iter("context")
    assert context.findtext("name") == "autobalance"
    pairs = {each.findtext("source"): each.findtext("translation") for each in context.iter("message")}
    assert set(pairs) == shown()
    assert len(pairs) > 30
    if name != "autobalance.ts":
        assert all(pairs.values())
