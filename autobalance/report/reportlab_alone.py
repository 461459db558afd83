"""reportlab without the files that it looks for in a home folder.

It runs ``~/.reportlab_mods`` and ``~/.reportlab_settings``. If home is not a folder (``HOME=/dev/null``, as
services have it), that ends in an error, and elsewhere in pages of another kind.
"""

from __future__ import annotations

import sys
from types import ModuleType

OWN_FILES = "reportlab_mods", "reportlab_settings"
"""Modules that reportlab takes in place of the files."""


def load_reportlab() -> None:
    """Import reportlab and its settings; do nothing where that was done."""
    missing = [name for name in OWN_FILES if name not in sys.modules]
    for name in missing:
        sys.modules[name] = ModuleType(name)
    try:
        import reportlab.rl_config  # noqa: F401
    finally:
        for name in missing:
            del sys.modules[name]
