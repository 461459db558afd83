"""A design search on disk: one line for each generation, from which a stopped search resumes."""

from __future__ import annotations

import json
import shutil
import zlib
from collections.abc import Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any

from autobalance.errors import FileError, file_errors
from autobalance.profile_search.search import Generation
from autobalance.studies.batch.journal import made_folder

SEARCH_FILE = "search.jsonl"
WRITTEN_FILES = ("design.json", "front.svg", "front.png", SEARCH_FILE)
DESIGNS = "designs"


class KeptSearch:
    """Generations of a search, kept in a folder if there is one.

    Parameters
    ----------
    folder : Path or None
    fingerprint : str
        Hash of everything that the search depends on; each line holds it.
    fresh : bool
        Delete the results of earlier searches in the folder.

    Raises
    ------
    FileError
        If the folder belongs to another design, or cannot be written.
    """

    def __init__(self, folder: Path | None, fingerprint: str, *, fresh: bool) -> None:
        self.generations: list[Generation] = []
        self._folder, self._fingerprint = folder, fingerprint
        if folder is None:
            return
        lines = [] if fresh else _lines(folder / SEARCH_FILE)
        if any(line.get("design") != fingerprint for line in lines):
            raise FileError(f"{folder} holds another design's search; choose another folder, or --fresh")
        self.generations = [Generation.of_line(line) for line in takewhile(_is_as_written, lines)]
        made_folder(folder)
        with file_errors(f"write {folder}"):
            if fresh:
                _forget(folder)
            text = "".join(self._text(generation) for generation in self.generations)
            (folder / SEARCH_FILE).write_text(text, encoding="utf-8")

    def keep(self, generation: Generation) -> None:
        if self._folder is not None:
            with (self._folder / SEARCH_FILE).open("a", encoding="utf-8") as stream:
                stream.write(self._text(generation))

    def _text(self, generation: Generation) -> str:
        line = generation.line()
        return json.dumps({"design": self._fingerprint, "crc32": _crc32(line), **line}) + "\n"


def _crc32(line: Mapping[str, Any]) -> int:
    return zlib.crc32(json.dumps(line).encode())


def _is_as_written(line: Mapping[str, Any]) -> bool:
    """Return whether a line is as it was written: the search resumes before the first changed one."""
    generation = {key: value for key, value in line.items() if key not in ("design", "crc32")}
    return line.get("crc32") == _crc32(generation)


def _lines(path: Path) -> list[dict[str, Any]]:
    """Return the complete lines of a file as objects, up to the first that is not JSON."""
    if not path.exists():
        return []
    entries = []
    for text in path.read_text(encoding="utf-8", errors="replace").split("\n")[:-1]:
        try:
            line = json.loads(text)
        except (ValueError, RecursionError):
            break
        entries.append(line if isinstance(line, dict) else {})
    return entries


def _forget(folder: Path) -> None:
    """Delete everything that searches have written to the folder."""
    for name in WRITTEN_FILES:
        (folder / name).unlink(missing_ok=True)
    if (folder / DESIGNS).is_dir():
        shutil.rmtree(folder / DESIGNS)
