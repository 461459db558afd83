"""The program's version, and that of its reports."""

from typing import Final

__version__ = "0.2.0"
SCHEMA_VERSION: Final = 1
"""Goes up when a key of a report changes its meaning."""
