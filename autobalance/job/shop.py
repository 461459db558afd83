"""A shop's own file, ``shop.toml``: found beside a job, or else in the user's configuration folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.errors import JobError
from autobalance.job.header import SHOP
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.keys import read
from autobalance.toml_files.typed_units import in_base_units
from autobalance.user_folders import shop_file

FILES = ("logo", "machine")
"""Keys that are paths, relative to the file that they are in."""


def with_shop(raw: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return the tables of a job with those of the shop's file; the job's own ``[shop]`` goes first.

    Raises
    ------
    FileError, JobError
        If the shop's file cannot be read, or is wrong; the message begins with its path.
    """
    path, own = shop_file(folder), raw.get("shop", {})
    if path is None or not isinstance(own, Mapping):
        return raw
    try:
        content = in_base_units(toml_of(text_of(path, "shop's file"), path.name))
        read(content, (SHOP,))
    except JobError as error:
        raise error.within(str(path)) from None
    return {**raw, "shop": {**located(content.get("shop", {}), path.parent), **own}}


def located(shop: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return a shop's table whose files are named from anywhere, not from the folder of its file."""
    named = {key: shop[key] for key in FILES if shop.get(key) is not None}
    return {**shop, **{key: (folder / name).resolve().as_posix() for key, name in named.items()}}
