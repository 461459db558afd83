"""Lines broken between words, never inside a word, a number with its unit or a path."""

from __future__ import annotations

import re

GLUE = "\ue000"
"""Placeholder of a space at which no line is broken: a private character, which no text contains."""
UNITS = (
    "mm|mm²|mm³|cm|m|in|in²|in³|g|kg|oz|lb|g·mm|g·m|g·in|oz·in|kg·mm|g·mm²|oz·in²|kg·mm²|lb·in²|kg/m³|N|kN|N·m"
    "|rpm|krpm|s|ms|min|Hz|%|MPa|GPa|mm/s|mm/s²|MB|GB|°C|K|W|J|g·mm/mm|oz·in/in|N/mm|N/µm|µm|kg·m²"
)
NUMBER_WITH_UNIT = re.compile(rf"(?<=\d) (?=(?:{UNITS})(?![\w·/]))")
SIGN_WITH_NUMBER = re.compile(r"(?<=[±⌀×]) (?=\d)|(?<=\d) (?=×)|(?<=\bG) (?=\d)")
SETTING = re.compile(r"--set '[^']*'")
FIRST_COLUMN = re.compile(r" *(?:- |\S+(?: \S+)* {2,})(?=\S)")
"""A dash, or a label with its text some spaces behind."""
WIDEST_LABEL = 32
ESCAPE = "\x1b"
"""Begins what colours a line, which fits already."""


def glued(text: str) -> str:
    """Return a text whose numbers hold on to their units, and settings to all of their words."""
    text = SETTING.sub(lambda found: whole(found[0]), text)
    return SIGN_WITH_NUMBER.sub(GLUE, NUMBER_WITH_UNIT.sub(GLUE, text))


def whole(text: object) -> str:
    """Return a path or a command whose words no line may part."""
    return str(text).replace(" ", GLUE)


def unglued(text: str) -> str:
    """Return a text with its spaces again."""
    return text.replace(GLUE, " ")


def longest_word(cell: str) -> int:
    """Return the length of the longest word of a table's cell, with its indent."""
    indent = len(cell) - len(cell.lstrip(" "))
    return max((indent + len(word) for word in cell.split(" ") if word), default=0)


def wrapped(line: str, width: int) -> list[str]:
    """Return a line in parts of a width at most, where its words allow that; later parts keep its indent.

    Examples
    --------
    >>> wrapped("  lower both shoulders", 14)
    ['  lower both', '  shoulders']
    """
    if len(line) <= width or ESCAPE in line:
        return [line]
    label = FIRST_COLUMN.match(line)
    indent = len(line) - len(line.lstrip(" "))
    hanging = len(label[0]) if label is not None and len(label[0]) <= WIDEST_LABEL else indent
    parts: list[str] = []
    start = 0
    while len(line) - start > width - (hanging if parts else 0):
        room = width - (hanging if parts else 0)
        first = start + (indent if not parts else 0)
        space = line.rfind(" ", first + 1, start + room + 1)
        if space < 0:
            space = line.find(" ", first + 1)
        if space < 0:
            break
        parts.append(" " * hanging * bool(parts) + line[start:space].rstrip(" "))
        start = space + 1
        while line[start : start + 1] == " ":
            start += 1
    return [*parts, " " * hanging * bool(parts) + line[start:]]


def fitted(text: str, width: int) -> str:
    """Return a text with every line wrapped; lines that fit stay as they are."""
    lines = (part for line in text.split("\n") for part in wrapped(glued(line), width))
    return unglued("\n".join(lines))
