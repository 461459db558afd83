"""The documentation's site: ``make docs`` builds it into ``docs/_build/html``; a warning is an error.

Three pages are written from the program itself before each build: the commands' help, the functions and
the formulas. They are not kept in the repository.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(DOCS))

from make_tables import COLUMN, wrapped  # noqa: E402

os.environ["COLUMNS"] = str(COLUMN + 2)  # argparse wraps its help at the terminal's width

from autobalance import PUBLIC, theory  # noqa: E402
from autobalance.command.main import full_parser  # noqa: E402
from autobalance.registry import VERBS as COMMANDS  # noqa: E402
from autobalance.version import __version__  # noqa: E402

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

project = "autobalance"
author = "The autobalance authors"
project_copyright = "the autobalance authors"
release = version = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
source_suffix = {".md": "myst-nb", ".rst": "restructuredtext", ".ipynb": "myst-nb"}
exclude_patterns = ["_build", "**/.ipynb_checkpoints"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300

autodoc_typehints = "none"  # the numpy docstrings give them in words, with shapes and units
autodoc_member_order = "bysource"
napoleon_google_docstring = False

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"autobalance {__version__}"
html_static_path: list[str] = []
html_theme_options = {"navigation_with_keys": True}

GENERATED = DOCS / "_generated"


def write_commands() -> None:
    """Write a page of every command's help, as the program prints it."""
    choices = full_parser()._subparsers._group_actions[0].choices  # type: ignore[union-attr]
    lines = ["# Every command's help", "", "`autobalance COMMAND --help` prints the same.", ""]
    for name in COMMANDS:
        lines += [f"## {name}", "", "```text", wrapped(choices[name].format_help()), "```", ""]  # type: ignore[index,call-overload]
    (GENERATED / "commands.md").write_text("\n".join(lines), encoding="utf-8")


def write_functions() -> None:
    """Write the reference of what ``import autobalance as ab`` offers, from its docstrings."""
    lines = ["Python functions", "================", ""]
    lines += ["``import autobalance as ab``; everything here is ``ab.NAME``.", ""]
    for name in sorted(PUBLIC, key=lambda each: (each[0].isupper(), each)):
        kind = "autoclass" if name[0].isupper() else "autofunction"
        members = "   :members:" if kind == "autoclass" else ""
        lines += [name, "-" * len(name), "", f".. {kind}:: autobalance.{name}", members, ""]
    (GENERATED / "functions.rst").write_text("\n".join(lines), encoding="utf-8")


def write_theory() -> None:
    """Write the reference of ``autobalance.theory``, a section for each module that has a formula."""
    lines = ["Formulas: ab.theory", "===================", ""]
    lines += ["``autobalance calc NAME key=value ...`` calls any of them from the command line.", ""]
    modules = sorted({getattr(theory, name).__module__ for name in theory.__all__})
    for module in modules:
        title = module.rsplit(".", 1)[1].replace("_", " ").capitalize()
        lines += [title, "-" * len(title), ""]
        names = [name for name in theory.__all__ if getattr(theory, name).__module__ == module]
        for name in names:
            kind = "autoclass" if isinstance(getattr(theory, name), type) else "autofunction"
            lines += [f".. {kind}:: {module}.{name}", ""]
    (GENERATED / "formulas.rst").write_text("\n".join(lines), encoding="utf-8")


def write_mathml(visitor: HTML5Translator, node: nodes.math | nodes.math_block) -> None:
    """Write a formula as MathML, which browsers set by themselves: no script, nothing from the network."""
    is_block = isinstance(node, nodes.math_block)
    visitor.body.append(tex2mathml(node.astext(), as_block=is_block))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Write the generated pages, and bring the notebooks in."""
    app.add_html_math_renderer("mathml", (write_mathml, None), (write_mathml, None))
    GENERATED.mkdir(exist_ok=True)
    write_commands()
    write_functions()
    write_theory()
    for notebook in (ROOT / "examples").glob("*.ipynb"):
        shutil.copyfile(notebook, GENERATED / notebook.name)
