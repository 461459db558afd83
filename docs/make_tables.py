"""Write the tables of keys into the documentation, from what the program declares of each.

python docs/make_tables.py

A page has ``<!-- keys of NAME -->`` and ``<!-- end -->``; what stands between them is written here.
"""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from autobalance.crank_dynamics.torsion.input import OF_A_JOB  # noqa: E402
from autobalance.declare import FILLED, REQUIRED, Key  # noqa: E402
from autobalance.drawn_cranks.input import DESIGN, PRESET  # noqa: E402
from autobalance.job.read_engine import WEIGHTS  # noqa: E402
from autobalance.job.reading import forms_of  # noqa: E402
from autobalance.job.tables import job_tables  # noqa: E402
from autobalance.profile_search.input import DESIGN_KEYS  # noqa: E402
from autobalance.registry import FILES  # noqa: E402
from autobalance.toml_files.document import toml_value  # noqa: E402

DOCS = ROOT / "docs"
PAGES = tuple(
    DOCS / f"{name}.md" for name in ("job-file", "cycle", "bearings", "other-files", "nc", "strength")
)
BLOCK = re.compile(r"<!-- keys of ([a-z -]+?) -->\n.*?<!-- end -->", re.DOTALL)
OF_WORDS = ("share",)
"""Units that are words of the meaning."""
COLUMN = 75
"""Letters in a line of the site's boxes of text."""
HEAD = "| key | value | default | meaning |\n|---|---|---|---|"


def wrapped(text: str) -> str:
    """Return a help text without lines that a box of the site would have to scroll."""
    lines = []
    for line in text.rstrip().splitlines():
        indent = " " * (len(line) - len(line.lstrip()))
        lines += textwrap.wrap(
            line, COLUMN, subsequent_indent=f"{indent}    ", break_long_words=False, break_on_hyphens=False
        ) or [""]
    return "\n".join(lines)


def blocks() -> dict[str, str]:
    """Return what stands in each block, by the name in its first line."""
    tables = {key.name: key for key in job_tables()}
    of_torsion = sorted((key.name for key in OF_A_JOB), key="torsion".__ne__)
    found = {name: of_tables((key,)) for name, key in tables.items() if name not in of_torsion}
    found["torsion"] = of_tables(tuple(tables[name] for name in of_torsion))
    found["a weight"] = "\n\n".join(
        f"`{{ ... }}` {form.says}:\n\n{HEAD}\n" + "\n".join(rows(form.keys))
        for named in WEIGHTS[:1]
        if named.named is not None
        for form in named.named.forms
    )
    files = {name: {"": DESIGN_KEYS} if name == "design-file" else forms_of(name) for name in FILES}
    files["crank-file"] = {"": (replace(PRESET, default=None), *DESIGN)}
    return found | {name: of_forms(forms) for name, forms in files.items()}


def of_forms(forms: Mapping[str, tuple[Key, ...]]) -> str:
    """Return the tables of each form; those inside them once, at the end."""
    if len(forms) == 1:
        return of_tables(*forms.values())
    parts = [f"{form}:\n\n{HEAD}\n" + "\n".join(rows(top(keys))) for form, keys in forms.items()]
    inside = {key.name: key for keys in forms.values() for key in keys if inner(key)}
    return "\n\n".join([*parts, *(part for key in inside.values() for part in of_table(key, ""))])


def top(keys: tuple[Key, ...]) -> tuple[Key, ...]:
    """Return the plain keys of a form."""
    return tuple(key for key in keys if not inner(key))


def of_tables(keys: tuple[Key, ...]) -> str:
    """Return the tables of keys, those inside them after them; plain keys of a file first."""
    plain = top(keys)
    parts = [f"{HEAD}\n" + "\n".join(rows(plain))] if plain else []
    for key in keys:
        if inner(key):
            parts += of_table(key, "")
    return "\n\n".join(parts)


def inner(key: Key) -> bool:
    """Tell whether a key gets a table of its own."""
    return bool(key.keys) and key.hint is None


def of_table(key: Key, path: str) -> Iterator[str]:
    """Yield the table of a key, and of those inside it."""
    place = f"{path}.{key.name}" if path else key.name
    brackets = f"`[[{place}]]`" if key.many else f"`[{place}]`"
    verbs = f" Read by {verbs_of(key)}." if key.verbs else ""
    says = key.says[:1].upper() + key.says[1:]
    yield f"{brackets}: {key.says}.{verbs}" if says else f"{brackets}.{verbs}"
    within = tuple(each for each in key.keys if not inner(each))
    if within:
        yield f"{HEAD}\n" + "\n".join(rows(within))
    for each in key.keys:
        if inner(each) and not each.forms:
            yield from of_table(each, place)
        for form in each.forms:
            yield f"`[{place}.{each.name}]` {form.says}:\n\n{HEAD}\n" + "\n".join(rows(form.keys))


def verbs_of(key: Key) -> str:
    """Return which verbs read a key."""
    if key.verbs == "all":
        return "every verb that takes a job"
    return ", ".join(f"`{verb}`" for verb in key.read_by)


def rows(keys: tuple[Key, ...]) -> Iterator[str]:
    """Yield a row a key."""
    for key in keys:
        own = f" ({verbs_of(key)} only)" if key.verbs else ""
        says = key.says.replace("|", "\\|")
        yield f"| `{key.name}` | {value_of(key)} | {default_of(key)} | {says}{own} |"


def value_of(key: Key) -> str:
    """Return what a key's value may be."""
    if key.named is not None:
        return "named weights"
    words = words_of(key.hint)
    rule = (
        key.rule.text.removeprefix("must ").removeprefix("be ").replace("not be", "not").replace("|", "\\|")
    )
    numbers = any(each in words for each in ("number", "numbers"))
    unit = f"[{key.unit}]" if key.unit and key.unit not in OF_WORDS else ""
    return " ".join(each for each in (words, rule, unit) if each) if numbers else words


def words_of(hint: Any) -> str:
    """Return a type in words."""
    origin, parts = get_origin(hint), [each for each in get_args(hint) if each not in (type(None), Ellipsis)]
    if origin is Literal:
        return ", ".join(f'`"{each}"`' for each in parts)
    if origin in (Union, UnionType):
        lists = {each: get_args(each)[0] for each in parts if get_origin(each) is tuple}
        alike = [each for each, item in lists.items() if item in parts]
        words = dict.fromkeys("list of them" if each in alike else words_of(each) for each in parts)
        return " or ".join(words)
    if origin is tuple:
        item = words_of(parts[0])
        many = item if item.endswith("text") or get_origin(parts[0]) is not None else f"{item}s"
        return f"list of {many}" if Ellipsis in get_args(hint) else f"list of {len(parts)} {many}"
    names = {int: "whole number", bool: "`true` or `false`", str: "text", dict: "table"}
    return names.get(hint, "number")


def default_of(key: Key) -> str:
    """Return a default as the job file has it, or in words."""
    if key.default is REQUIRED:
        return "required"
    if key.usual:
        return key.usual
    if key.default is None or (key.default is FILLED and key.is_table):
        return "none"
    if key.default == ():
        return "none"
    return f"`{toml_value(shortest(key.default))}`"


def shortest(value: Any) -> Any:
    """Return whole numbers without their point."""
    if isinstance(value, tuple):
        return [shortest(each) for each in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def page(text: str) -> str:
    """Return a page with its tables as they are now."""
    made = blocks()

    def written(found: re.Match[str]) -> str:
        return f"<!-- keys of {found[1]} -->\n\n{made[found[1]]}\n\n<!-- end -->"

    return BLOCK.sub(written, text)


if __name__ == "__main__":
    for each in PAGES:
        each.write_text(page(each.read_text(encoding="utf-8")), encoding="utf-8")
