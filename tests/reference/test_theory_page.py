"""The page of formulas: what it cites exists, and every misprint that a case notes is on it."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import pytest

from tests.reference.published import CASES

PAGE = (Path(__file__).parents[2] / "docs" / "theory.md").read_text("utf-8")
CASE = r"\b(?:KIN|BF|ISO|CPO|ROT|UNB|CRF|T5|RU|SYN|FM|FR|TQ)-\d+"
PAGES = "".join(path.read_text("utf-8") for path in (Path(__file__).parents[2] / "docs").glob("*.md"))
NAMED = set(re.findall(CASE, PAGE))
"""Cases that the page of balance and forces names; those of other subjects stand on their own pages."""


def stem(case: str) -> str:
    """Return ``CRF-06`` for ``CRF-06-0.28``."""
    return "-".join(case.split("-")[:2])


def test_every_case_that_the_page_names_exists() -> None:
    assert len(NAMED) > 30
    assert {stem(case) for case in CASES} >= NAMED


def test_every_misprint_is_on_the_page() -> None:
    misprinted = {stem(case) for case, values in CASES.items() if "misprint" in values}
    named = set(re.findall(CASE, PAGES))
    assert misprinted - {"UNB-3", "UNB-4"} <= named  # UNB-2…5 stand as one


def test_every_case_has_a_test_of_its_name() -> None:
    text = "".join(path.read_text("utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    tests = re.findall(r"def test_([a-z]+\d?(?:_\d+)+)", text)
    tested = {stem(case) for case in re.findall(r'check\(\s*"([^"]+)"', text)}
    for name in tests:
        group, *numbers = name.split("_")
        tested |= {f"{group.upper()}-{number}" for number in numbers}
    assert {stem(case) for case in CASES} <= tested


@pytest.mark.parametrize(
    "name",
    [
        "stroked_crank",
        "crankpin_overlap_mm",
        "substitute_rotor",
        "section_sums",
        "balancing_counterweights",
        "fan_counterweight_for",
        "final_hole_depth_mm",
        "complete_balance",
        "ConnectingRod.from_solid",
    ],
)
def test_what_python_alone_offers_is_shown(name: str) -> None:
    assert re.search(rf"^>>> .*\b{re.escape(name)}\(", PAGE, re.MULTILINE)


def test_the_pages_examples_are_right() -> None:
    examples = doctest.DocTestParser().get_doctest(PAGE, {}, "theory.md", None, None)
    assert len(examples.examples) > 15
    assert doctest.DocTestRunner(verbose=False).run(examples).failed == 0
