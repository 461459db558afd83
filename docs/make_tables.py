"""Write the tables of the kinds of correction into ``job-file.md``, from what the kinds say of themselves.

python docs/make_tables.py
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from autobalance.correction import KINDS  # noqa: E402
from autobalance.correction.contract import Limits  # noqa: E402

PAGE = ROOT / "docs" / "job-file.md"
BEGIN = "<!-- written by make_tables.py -->"
END = "<!-- end -->"


def tables() -> str:
    """Return a table a kind: its keys, their defaults and meanings."""
    return "\n\n".join(
        "\n".join(
            [
                f"`[correction.{name}]`: {kind.noun.lower()}; depths count from {kind.datum}.",
                "",
                "| key | default | meaning |",
                "|---|---|---|",
                *rows(kind.limits),
            ]
        )
        for name, kind in KINDS.items()
    )


def rows(limits: type[Limits]) -> Iterator[str]:
    """Yield a row a key."""
    meanings = dict(attributes(inspect.cleandoc(limits.__doc__ or "")))
    for each in fields(limits):
        yield f"| `{each.name}` | {shown(each.default)} | {meanings.get(each.name, '')} |"


def attributes(text: str) -> Iterator[tuple[str, str]]:
    """Yield names and descriptions of a docstring's Attributes section."""
    section = text.partition("Attributes\n----------\n")[2]
    for head, body in re.findall(r"^(\S.*)\n?((?:[ ]{4}.*\n?)*)", section, re.MULTILINE):
        names, _, kind = head.partition(" : ")
        said = " ".join(body.split()).replace("``", "`").rstrip(".")
        if re.fullmatch(r'"\w+" or "\w+"', kind):
            said = f"{kind}; {said}".rstrip("; ")
        for name in names.split(", "):
            yield name, said


def shown(default: Any) -> str:
    """Return a default as the job file has it."""
    if default is None:
        return "not set"
    if isinstance(default, bool):
        return "`true`" if default else "`false`"
    if isinstance(default, str):
        return f'`"{default}"`'
    if isinstance(default, tuple):
        return f"`{plain(default)}`"
    return f"`{default:g}`"


def plain(value: Any) -> str:
    """Return a list of numbers as TOML has it."""
    return f"[{', '.join(plain(each) for each in value)}]" if isinstance(value, tuple) else f"{value:g}"


def page(text: str) -> str:
    """Return the page with its tables, and its list of methods, as they are now."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    names = ", ".join(f'`"{name}"`' for name in KINDS)
    method = f"| `method` | required | {names}, or a list of them to mix |"
    before = re.sub(r"^\| `method` \|.*$", method, before, flags=re.MULTILINE)
    return f"{before}{BEGIN}\n\n{tables()}\n\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
