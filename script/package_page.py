"""The package's page: README.md with links that hold away from the checkout, and the project's addresses.

A build hook of hatchling. Where the project lives is asked of git (``remote.origin.url``), or, in a source
distribution, read from PKG-INFO; links and pictures of README.md then lead there. Where nobody says, as in a
checkout without a public remote, links become plain text and pictures are left out.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\((?!https?:|#|mailto:)(?P<path>[^)\s]+)\)")
"""A link or picture of Markdown whose address is a path in the checkout."""
REMOTE = re.compile(r"(?:https?|ssh|git)://(?:[^@/]*@)?(?P<host>[^/]+)/(?P<path>.+?)(?:\.git)?/?")
SHORT_REMOTE = re.compile(r"(?:[^@/:]+@)(?P<host>[^/:]+):(?P<path>[^/].*?)(?:\.git)?/?")


class PackagePage(MetadataHookInterface):
    """Gives the wheel and the source distribution their page and addresses."""

    PLUGIN_NAME = "custom"

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the dynamic fields ``readme`` and ``urls``."""
        root = Path(self.root)
        address = home(root)
        text = (root / "README.md").read_text(encoding="utf-8")
        metadata["readme"] = {"content-type": "text/markdown", "text": page(text, address)}
        metadata["urls"] = {} if address is None else urls(address)


def home(root: Path) -> str | None:
    """Return the project's public address, None where neither PKG-INFO nor git knows one."""
    told = root / "PKG-INFO"
    if told.is_file():
        found = re.search(r"^Project-URL: Source, (\S+)$", told.read_text(encoding="utf-8"), re.MULTILINE)
        return found and found[1]
    asked = ["git", "-C", str(root), "config", "--local", "--get", "remote.origin.url"]
    try:
        answer = subprocess.run(asked, capture_output=True, text=True, check=False)
    except FileNotFoundError:  # no git on this machine
        return None
    return public_address(answer.stdout.strip())


def public_address(remote: str) -> str | None:
    """Return a remote's address for a browser, without anybody's name or password; None for a folder."""
    found = REMOTE.fullmatch(remote) or SHORT_REMOTE.fullmatch(remote)
    return found and f"https://{found['host']}/{found['path']}"


def urls(address: str) -> dict[str, str]:
    """Return the project's addresses as a package's page lists them."""
    return {
        "Source": address,
        "Documentation": f"{address}/blob/HEAD/docs/index.md",
        "Changelog": f"{address}/blob/HEAD/CHANGELOG.md",
        "Issues": f"{address}/issues",
    }


def page(readme: str, address: str | None) -> str:
    """Return README.md as it reads away from the checkout."""

    def led(link: re.Match[str]) -> str:
        if address is None:
            return "" if link["picture"] else link["text"]
        kind = "raw" if link["picture"] else "blob"
        return f"{link['picture']}[{link['text']}]({address}/{kind}/HEAD/{link['path']})"

    return LINK.sub(led, readme)
