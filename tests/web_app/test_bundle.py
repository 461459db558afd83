"""The page's modules joined to one script: nothing of them is lost, and what cannot be joined is refused."""

from __future__ import annotations

import re
import subprocess
from importlib.resources import files
from pathlib import Path
from shutil import which

import pytest

from autobalance.browser.bundle import IMPORT, OUTSIDE, Module, script, style

STATIC = files("autobalance.browser").joinpath("static")
APART = {"notebook.js", OUTSIDE}
"""Not the page's own: of a notebook, and a library."""


def test_every_module_is_in_the_script_once_after_those_that_it_needs() -> None:
    text = script().decode()
    order = re.findall(r"^await \(async \(\$exports\) => \{ // ([\w.-]+)$", text, re.MULTILINE)
    own = {each.name for each in STATIC.iterdir() if each.name.endswith(".js")} - APART
    assert sorted(order) == sorted(own)
    assert order[-1] == "app.js"
    assert not re.search(r"^(import (?!\* as \$outside)|export )", text, re.MULTILINE)
    for name in ("tools.js", "store.js", "words.js"):  # used by others as they are loaded
        importers = [each for each in order if name in {source for _, source in Module.of(each).imports}]
        assert all(order.index(name) < order.index(each) for each in importers)


def test_the_style_sheet_is_all_three_in_their_order() -> None:
    sheets = [STATIC.joinpath(name).read_bytes() for name in ("tokens.css", "frame.css", "app.css")]
    assert style() == b"".join(sheets)


def test_every_import_names_what_its_module_exports() -> None:
    own = [each.name for each in STATIC.iterdir() if each.name.endswith(".js") and each.name not in APART]
    exported = {name: Module.of(name).exports for name in own}
    for name in exported:
        for imported, source in IMPORT.findall(STATIC.joinpath(name).read_text(encoding="utf-8")):
            if source != OUTSIDE and not imported.startswith("*"):
                names = {each.split(" as ")[0].strip() for each in imported.strip("{} ").split(",")}
                assert names <= set(exported[source]), (name, source)


@pytest.mark.skipif(which("node") is None, reason="not installed: node")
def test_the_script_parses(tmp_path: Path) -> None:
    (tmp_path / "page.mjs").write_bytes(script())
    subprocess.run(["node", "--check", str(tmp_path / "page.mjs")], check=True)
