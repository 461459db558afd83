"""The page's texts: one file a language, none of what the page says is missing in any."""

from __future__ import annotations

import json
import re
from importlib.resources import files
from typing import Any

import pytest

STATIC = files("autobalance.browser").joinpath("static")
SAME = {"autobalance", "mm", "cm", "m"}


def texts(language: str) -> dict[str, str]:
    found: dict[str, str] = json.loads(STATIC.joinpath(f"text-{language}.json").read_text(encoding="utf-8"))
    return found


def said() -> set[str]:
    """Return what components and the page as it is loaded say in English."""
    found: set[str] = set()
    for path in STATIC.iterdir():
        if path.name.endswith(".js") and not path.name.endswith(".min.js"):
            found |= set(re.findall(r'\bt\("((?:[^"\\]|\\.)*)"', path.read_text(encoding="utf-8")))
    page = re.sub(r"<title>.*?</title>", "", STATIC.joinpath("index.html").read_text(encoding="utf-8"))
    inside = [" ".join(each.split()) for each in re.findall(r">([^<>]+)<", page)]
    named = re.findall(r'(?:aria-label|title|placeholder)="([^"]+)"', page)
    return found | {each for each in (*inside, *named) if re.search("[A-Za-z]{2}", each) and "{{" not in each}


@pytest.mark.parametrize("language", ["en", "de", "es"])
def test_everything_that_the_page_says_has_a_text_in_every_language(language: str) -> None:
    known = texts(language)
    assert sorted(said() - set(known) - SAME) == []
    assert all(known.values())


@pytest.mark.parametrize("language", ["de", "es"])
def test_texts_of_a_language_are_those_of_english_with_the_same_values(language: str) -> None:
    def braces(text: Any) -> list[str]:
        return sorted(re.findall(r"\{\w+\}", text))

    english, other = texts("en"), texts(language)
    assert set(other) == set(english)
    assert {key: braces(value) for key, value in other.items()} == {key: braces(key) for key in english}
