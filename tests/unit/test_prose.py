"""The check of the project's prose: each rule fires on a planted sentence, and plain sentences pass."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "script" / "prose"
PLANTED = (
    ("d", "Of the crank.", "opening"),
    ("d", "Return what is cut.", "what-clause"),
    ("h", "by how much the depth strays", "fragment"),
    ("a", "What was recognised", "what-clause"),
    ("m", "the mass of what was removed", "what-clause"),
    ("p", "Of all cuts the deepest is the first.", "inversion"),
    ("m", "job.toml is no job", "no-for-not"),
    ("m", "the file has none", "none"),
    ("p", "The sheet states by how much it strays.", "by-how-much"),
    ("p", "The angle is the machine's.", "possessive"),
    ("h", "those of the job", "that-of"),
    ("p", "Three cuts, of which two are equal.", "of-which"),
    ("p", "Each has a table of its own.", "of-own"),
    ("p", "The report says so.", "person"),
    ("p", "The unit stands in the key.", "stand"),
    ("m", "main_journals settles it", "idiom"),
    ("p", "This counts as nothing.", "idiom"),
    ("p", "A negative mass comes on.", "idiom"),
    ("p", "The file is not there.", "idiom"),
    ("p", "The grade as of ISO 21940.", "as-of"),
    ("p", "The sum thereof.", "archaic"),
    ("p", "The key is to be set.", "is-to-be"),
    ("s", "the greatest load of a main journal", "extreme"),
    ("h", "unit, where there is a choice", "where-for-if"),
)
"""Source, words and rule: one for each pattern, in their order."""
PLAIN = (
    ("p", "Weigh the crank, and compare the mass with the model."),
    ("a", "Recognised features"),
    ("h", "speed of the forces; 1000 if the job has no speed"),
    ("m", "job.toml: balance.speed_rpm is -100; enter a value above 0"),
    ("s", "left 0.46 of 3.12 g·mm permitted (plane B)"),
    ("d", "Return the wall [mm] next to a hole."),
)
PAGE = """# Of the crank

The report says so. Plain words follow.

| key | meaning |
|---|---|
| `a` | the file has none |

```
The report says so.
```

<!-- keys of a table -->
The report says so.
<!-- end -->

- By how much it strays.
"""
MODULE = '''"""What a module has."""

KEY = Key("name", str, "of the crank that is cut")


def read(path: str) -> None:
    """Read a file.

    Parameters
    ----------
    path : str
        The file says so.
    **more
        Those of another function.
    """
    raise FileError(f"{path} is no file")


print("the report says that all is well")
'''


@pytest.fixture(scope="module")
def prose() -> Iterator[ModuleType]:
    """Return the script as a module."""
    loader = SourceFileLoader("prose", str(SCRIPT))
    spec = importlib.util.spec_from_loader("prose", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["prose"] = module  # its named tuples look their module up
    loader.exec_module(module)
    yield module
    del sys.modules["prose"]


def rules_of(prose: ModuleType, source: str, words: str) -> set[str]:
    return {fault.rule for fault in prose.faults(prose.Text(Path("page.md"), 1, source, words))}


def test_every_pattern_fires_on_its_sentence_alone(prose: ModuleType) -> None:
    assert [rule for _, _, rule in PLANTED] == [rule.name for rule in prose.RULES]
    for (source, words, name), rule in zip(PLANTED, prose.RULES, strict=True):
        found = [fault.remedy for fault in prose.faults(prose.Text(Path("page.md"), 1, source, words))]
        assert rule.remedy in found, words
        assert name in rules_of(prose, source, words)


@pytest.mark.parametrize(("source", "words"), PLAIN)
def test_plain_words_pass(prose: ModuleType, source: str, words: str) -> None:
    assert rules_of(prose, source, words) == set()


def test_length_and_semicolons_are_counted_by_sentence(prose: ModuleType) -> None:
    longest = "One" + " word" * (prose.LONGEST - 2) + " more."
    assert rules_of(prose, "p", f"{longest} {longest}") == set()
    assert rules_of(prose, "p", f"And {longest}") == {"long"}
    assert rules_of(prose, "p", "one; two. Three; four.") == set()
    assert rules_of(prose, "p", "one; two; three.") == {"semicolons"}


def test_pages_are_read_without_code_and_generated_tables(prose: ModuleType, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE, encoding="utf-8")
    found = [(fault.line, fault.rule) for text in prose.texts_of_file(page) for fault in prose.faults(text)]
    assert found == [(1, "inversion"), (3, "person"), (7, "none"), (17, "by-how-much")]


def test_modules_are_read_by_docstring_help_message_and_print(prose: ModuleType, tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text(MODULE, encoding="utf-8")
    found = {
        (text.source, fault.line, fault.rule)
        for text in prose.texts_of_file(module)
        for fault in prose.faults(text)
    }
    assert found == {
        ("d", 1, "opening"),
        ("h", 3, "fragment"),
        ("d", 12, "person"),
        ("d", 14, "that-of"),
        ("m", 16, "no-for-not"),
        ("s", 19, "person"),
    }
