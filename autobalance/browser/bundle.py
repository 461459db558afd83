"""The page's own modules as one script, and its style sheets as one: two files, not sixty."""

from __future__ import annotations

import re
from collections.abc import Iterator

from autobalance.browser.guard import asset
from autobalance.value_classes import dataclass

FIRST = "app.js"
OUTSIDE = "preact.min.js"
"""Imported by the script as it is."""
SHEETS = ("tokens.css", "frame.css", "app.css")
IMPORT = re.compile(r'^import (\{[^}]*\}|\* as \w+) from "/static/([\w.-]+)";.*\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async )?function|class|const )", re.MULTILINE)
EXPORTED = re.compile(r"^export (?:async )?(?:function|class|const) ([\w$]+)", re.MULTILINE)
EXPORTED_LIST = re.compile(r"^export \{([^}]*)\};\n", re.MULTILINE)
HEAD = f"""import * as $outside from "/static/{OUTSIDE}";
const $modules = {{ "{OUTSIDE}": $outside }}, $links = [];
const $linked = () => {{ for (const link of $links) link(); }};
"""


@dataclass(frozen=True)
class Module:
    """A module of the page: its imports as ``(names or * as name, file)``, the names it exports, its text."""

    name: str
    imports: tuple[tuple[str, str], ...]
    exports: tuple[str, ...]
    body: str

    @classmethod
    def of(cls, name: str) -> Module:
        """Read a module.

        Raises
        ------
        ValueError
            If it has an import or export that cannot be joined, such as ``export let``.
        """
        text = asset("browser", f"static/{name}").decode()
        listed = [each.strip() for some in EXPORTED_LIST.findall(text) for each in some.split(",")]
        body = EXPORT.sub("", EXPORTED_LIST.sub("", IMPORT.sub("", text)))
        left = re.search(r"^(?:import|export)\b.*", body, re.MULTILINE)
        if left:
            raise ValueError(f"{name}: cannot be joined: {left[0]}")
        return cls(name, tuple(IMPORT.findall(text)), (*EXPORTED.findall(text), *listed), body)

    def joined(self) -> str:
        """Return the module as a function: its imports are set again after each module that has run.

        A module may then use, once all have run, what a module exports that itself imports this one.
        """
        names, sets = [], []
        for imported, source in self.imports:
            if imported.startswith("*"):
                names.append(f"{imported.split()[-1]} = $modules[{source!r}]")
                continue
            for each in imported.strip("{} ").split(","):
                known, _, here = each.strip().partition(" as ")
                names.append(here or known)
                sets.append(f"{here or known} = $modules[{source!r}].{known};")
        own = ", ".join(f"{each}: {{ get: () => {each} }}" for each in self.exports)
        head = f"let {', '.join(names)};\n" if names else ""
        link = f"$links.push(() => {{ {' '.join(sets)} }}); $links.at(-1)();\n"
        exported = f"Object.defineProperties($exports, {{ {own} }});\n"
        return (
            f"await (async ($exports) => {{ // {self.name}\n{head}{link}{exported}"
            f"{self.body}}})($modules[{self.name!r}]); $linked();\n"
        )


def script() -> bytes:
    """Return all modules that the page imports as one, each after those that it needs."""
    order = list(_needed(FIRST, {OUTSIDE}))
    known = "".join(f"$modules[{each.name!r}] = {{}};\n" for each in order)
    return "".join((HEAD, known, *(each.joined() for each in order))).encode()


def style() -> bytes:
    """Return the page's style sheets as one."""
    return b"".join(asset("browser", f"static/{name}") for name in SHEETS)


def _needed(name: str, seen: set[str]) -> Iterator[Module]:
    """Yield a module after all that it imports, each once."""
    seen.add(name)
    module = Module.of(name)
    for _, source in module.imports:
        if source not in seen:
            yield from _needed(source, seen)
    yield module
