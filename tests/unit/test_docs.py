"""What the documents say is so: their jobs are read, their links lead somewhere, their commands exist."""

import importlib.util
import re
import shlex
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

from autobalance import PUBLIC, job
from autobalance.command.main import full_parser
from autobalance.job.tables import job_tables
from autobalance.registry import VERBS as COMMANDS
from autobalance.report.output_kinds import KINDS
from autobalance.solid.formats.table import ENTRIES, endings

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [
    path
    for folder in (ROOT, ROOT / "docs")
    for path in sorted(folder.glob("*.md"))
    if path.name != "CHANGELOG.md"
]


@pytest.mark.parametrize(
    "path", [ROOT / "README.md", ROOT / "docs" / "tutorial.md"], ids=lambda path: path.name
)
def test_jobs_in_documents_are_read(path: Path) -> None:
    blocks = re.findall(r"```toml\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        assert job.parse(tomllib.loads(block), path).balance.factor == 0.28


def test_the_tutorials_job_is_the_bundled_one() -> None:
    text = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    block = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0]
    bundled = (ROOT / "fixtures" / "crf250r" / "drafted" / "factor-0.28.toml").read_text(encoding="utf-8")
    assert tomllib.loads(block) == tomllib.loads(bundled)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)]+)\)", path.read_text(encoding="utf-8")):
        if "://" not in target and not target.startswith("_generated/"):  # those the site's builder checks
            assert (path.parent / target).exists(), target


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_commands_in_documents_exist(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for name in re.findall(r"^(?:\.venv/bin/)?autobalance ([a-z]+)", text, re.MULTILINE):
        assert name in COMMANDS


def test_the_readmes_commands_work_as_printed() -> None:
    """Each parses, and reads what the clone has or a line before it writes."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = text.split("these lines run as written, from the clone:\n\n```\n")[1].split("```")[0]
    there = set()
    for line in block.splitlines()[1:]:
        words = shlex.split(line, comments=True)
        assert words.pop(0) == "autobalance"
        full_parser().parse_args(words)
        files = [word for word in words[1:] if Path(word).suffix in (".stl", ".toml", ".json")]
        written = words[words.index("-o") + 1] if "-o" in words else None
        for file in files:
            assert file == written or (ROOT / file).is_file() or file.split("/")[0] in there, line
        there |= {written} if written else set()


def tables() -> ModuleType:
    """Return ``docs/make_tables.py`` as a module."""
    made = importlib.util.spec_from_file_location("make_tables", ROOT / "docs" / "make_tables.py")
    assert made is not None
    assert made.loader is not None
    module = importlib.util.module_from_spec(made)
    made.loader.exec_module(module)
    return module


def test_the_tables_of_keys_are_what_the_program_declares() -> None:
    """``python docs/make_tables.py`` writes them anew."""
    module = tables()
    for path in module.PAGES:
        text = path.read_text(encoding="utf-8")
        assert module.page(text) == text, path.name


def test_every_key_of_the_job_is_documented() -> None:
    """Every declared table has its block on a page."""
    module = tables()
    text = "".join(path.read_text(encoding="utf-8") for path in module.PAGES)
    assert set(module.BLOCK.findall(text)) == set(module.blocks())
    keys = {key.name for table in job_tables() for key in (table, *table.keys)}
    assert {key for key in keys if not re.search(rf"`\[*([a-z]+\.)?{key}\b", text)} == set()


def test_every_verb_is_documented() -> None:
    """In the page of commands, in the README's list, and as a function in the script of all verbs."""
    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    script = (ROOT / "examples" / "every_verb.py").read_text(encoding="utf-8")
    rows = "\n".join(re.findall(r"^\|([^|]*)\|", page, re.MULTILINE))
    assert {name for name in COMMANDS if f"`{name}`" not in rows} == set()
    assert {name for name in COMMANDS if not re.search(rf"`{name}`|autobalance {name}\b", readme)} == set()
    functions = [name for name in PUBLIC if name[0].islower() and name != "app"]  # which serves until stopped
    assert {name for name in functions if f"ab.{name}(" not in script} == set()


def test_the_map_of_the_package_is_the_contract_of_its_layers() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = {each["id"]: each for each in settings["tool"]["importlinter"]["contracts"]}
    layers = [layer.split(" | ") for layer in contracts["layers"]["layers"] if layer != "__main__"]
    page = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    table = page.partition("| layer |")[2].partition("\n\n")[0]
    mapped = [re.findall(r"`(\w+)`", row.split("|")[1]) for row in table.splitlines()[2:]]
    assert mapped == layers


def test_every_kind_of_output_is_documented() -> None:
    page = (ROOT / "docs" / "outputs.md").read_text(encoding="utf-8")
    for name, kind in KINDS.items():
        for file in kind.files.values():
            assert re.search(rf"^\|[^|]*`{re.escape(file)}`[^|]*\| `{name}`", page, re.MULTILINE), file


def test_every_format_is_documented() -> None:
    """In the table of formats of the job, with the README's and the key's own words."""
    page = (ROOT / "docs" / "job-file.md").read_text(encoding="utf-8")
    rows = "\n".join(re.findall(r"^\|([^|]*)\|", page, re.MULTILINE))
    assert {each for each in endings() if f"`{each}`" not in rows} == set()
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    first = [f".{entry.endings[0]}" for entry in ENTRIES.values() if entry.endings]
    assert {each for each in first if f"{each} " not in readme and f"{each}\n" not in readme} == set()


def test_help_on_the_site_fits_its_boxes() -> None:
    """And the front page shows no second table of contents beside the site's own."""
    module = tables()
    parser = full_parser()
    choices = parser._subparsers._group_actions[0].choices  # type: ignore[union-attr]
    for name in COMMANDS:
        text = module.wrapped(choices[name].format_help())  # type: ignore[index]
        assert max(map(len, text.splitlines())) <= module.COLUMN, name
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert index.count("```{toctree}") == index.count("```{toctree}\n:hidden:") > 0


def test_documents_weigh_two_rods_of_a_crankpin_in_one_way() -> None:
    """One rod with its piston is weighed, and ``rods_per_throw`` counts them; nobody doubles the pieces."""
    for path in DOCUMENTS:
        for block in re.findall(r"```toml\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL):
            if "rods_per_throw = 2" in block:
                assert "pieces = 2" not in block, path.name
            assert not re.search(r"(rod|piston|big_end|small_end)\w* = \{[^}]*pieces = 2", block), path.name


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_no_asterisks_are_left_of_bold_text(path: Path) -> None:
    text = re.sub(r"```.*?```|`[^`]*`", "x", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    for paragraph in re.split(r"\n\s*\n", text):
        assert paragraph.count("**") % 2 == 0, paragraph[:80]
        assert "****" not in paragraph
