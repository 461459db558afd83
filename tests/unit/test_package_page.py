"""The package's page: links of README.md lead to where the project lives, as git or PKG-INFO says."""

import importlib.util
import re
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
HOME = "https://example.org/workshop/autobalance"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    made = importlib.util.spec_from_file_location("package_page", ROOT / "script" / "package_page.py")
    assert made is not None
    assert made.loader is not None
    module = importlib.util.module_from_spec(made)
    made.loader.exec_module(module)
    return module


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / "README.md").write_text((ROOT / "README.md").read_text(encoding="utf-8"), encoding="utf-8")
    subprocess.run(["git", "init", "--quiet", str(tmp_path)], check=True)
    return tmp_path


def metadata(script: ModuleType, root: Path) -> dict[str, dict[str, str]]:
    found: dict[str, dict[str, str]] = {}
    script.PackagePage(str(root), {}).update(found)
    return found


@pytest.mark.parametrize(
    "remote",
    [
        "https://example.org/workshop/autobalance.git",
        "https://somebody:secret@example.org/workshop/autobalance",
        "ssh://git@example.org/workshop/autobalance.git",
        "git@example.org:workshop/autobalance.git",
    ],
)
def test_every_link_leads_to_where_git_says(script: ModuleType, checkout: Path, remote: str) -> None:
    subprocess.run(["git", "-C", str(checkout), "remote", "add", "origin", remote], check=True)
    found = metadata(script, checkout)
    links = re.findall(r"\]\(([^)]+)\)", found["readme"]["text"])
    assert len(links) > 8
    for link in links:
        assert link.startswith(f"{HOME}/"), link
        kind, _, path = link.removeprefix(f"{HOME}/").split("/", 2)
        assert kind == ("raw" if path.endswith(".png") else "blob")
        assert (ROOT / path).exists()
    assert found["urls"]["Source"] == HOME
    assert all(each.startswith(HOME) for each in found["urls"].values())


@pytest.mark.parametrize(
    "remote", [None, "/home/somebody/autobalance", "../autobalance", "file:///autobalance"]
)
def test_without_a_public_address_no_link_leads_nowhere(
    script: ModuleType, checkout: Path, remote: str | None
) -> None:
    if remote is not None:
        subprocess.run(["git", "-C", str(checkout), "remote", "add", "origin", remote], check=True)
    found = metadata(script, checkout)
    assert found["urls"] == {}
    assert "](" not in found["readme"]["text"]
    assert "every key of a job" in found["readme"]["text"]


def test_a_source_distribution_keeps_its_address(script: ModuleType, checkout: Path) -> None:
    (checkout / "PKG-INFO").write_text(f"Name: autobalance\nProject-URL: Source, {HOME}\n", encoding="utf-8")
    assert metadata(script, checkout)["urls"]["Source"] == HOME
