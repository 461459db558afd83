"""The user's folders of the program: settings, and the cache of files that were read."""

from __future__ import annotations

import os
import sys
from pathlib import Path

SHOP_FILE = "shop.toml"
CACHE_VARIABLE = "AUTOBALANCE_CACHE"


def configuration_folder() -> Path:
    """Return the user's configuration folder of the program, whether it exists or not."""
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        base = Path(os.environ.get("APPDATA") or home / "AppData" / "Roaming")
    elif sys.platform == "darwin":
        base = home / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_CONFIG_HOME") or home / ".config")
    return base / "autobalance"


def cache_folder() -> Path:
    """Return ``$AUTOBALANCE_CACHE``, else the user's cache folder of the program; it may not exist."""
    own = os.environ.get(CACHE_VARIABLE)
    if own:
        return Path(own)
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        local = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
        return local / "autobalance" / "cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "autobalance"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "autobalance"


def shop_file(folder: Path) -> Path | None:
    """Return the shop's file for a job in a folder; None if the folder has no such file."""
    return next(
        (each for each in (folder / SHOP_FILE, configuration_folder() / SHOP_FILE) if each.is_file()), None
    )
