"""Cranks of a project: what each is called, and those whose file was scaled from another's."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from autobalance.browser.guard import body_of, file_of, refused
from autobalance.browser.project import APP_FOLDER, free
from autobalance.errors import FormatError, file_errors
from autobalance.types import Array
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.browser.project import Project

FILE = "cranks.json"
LONGEST_NAME = 80
NOT_IN_NAMES = re.compile(r'[\\/:*?"<>|]')
PICTURES = "pictures"
"""Folder of the cranks' small pictures, ``CRANK.png`` each."""
PNG = b"\x89PNG\r\n\x1a\n"
LARGEST_PICTURE = 1 << 18


@dataclass(frozen=True)
class DrawnFrom:
    """A preset and the dimensions with which it was drawn.

    ``dimensions`` are those of the crank by their dotted keys, ``typed`` the keys of those that a user typed.
    The counterweights suffice for bob-weights up to ``most_bob_weight_g`` [g], None if none count;
    ``is_most_typed``: the counterweights were drawn for that number, which a user typed.
    """

    preset: str
    dimensions: Mapping[str, float]
    typed: Sequence[str]
    most_bob_weight_g: float | None
    is_most_typed: bool


@dataclass(frozen=True)
class KnownCrank:
    """Facts about a crank's file beside the file.

    ``name`` is the one that a user gave it, else "". It was scaled from the file ``scaled_from`` by
    ``factor`` for a stroke of ``stroke_mm``, or not scaled: "". ``drawn`` is
    None of a crank that was not drawn here.
    """

    name: str = ""
    scaled_from: str = ""
    factor: float = 1.0
    stroke_mm: float = 0.0
    drawn: DrawnFrom | None = None


def known_cranks(project: Project) -> dict[str, KnownCrank]:
    """Return the facts about the project's cranks, by their files: named, scaled, or with a job kept."""
    path = _path(project)
    told = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    jobs = (each.name.removesuffix(".toml") for each in kept_jobs(project).glob("*.toml"))
    return {name: KnownCrank() for name in sorted(jobs)} | {
        name: KnownCrank(**{**each, "drawn": DrawnFrom(**each["drawn"]) if each.get("drawn") else None})
        for name, each in told.items()
    }


def saved_name(project: Project, told: Mapping[str, Any], name: str) -> str:
    """Return the name under which a file of a run is saved: of its crank, from the second stage on its stage.

    It differs between two cranks, and two stages of one, in the same folder of downloads.
    """
    crank = told["crank"] or ""
    called = known_cranks(project).get(crank, KnownCrank()).name or Path(crank).stem
    stage = f"stage-{told['stage']}" if told["stage"] > 1 else ""
    return "-".join(filter(None, (NOT_IN_NAMES.sub("-", called).lstrip("."), stage, name)))


def kept_jobs(project: Project) -> Path:
    """Return the folder of the jobs of cranks that are not open, ``CRANK.toml`` each."""
    return project.folder / APP_FOLDER / "jobs"


def keep_crank(project: Project, file: str, crank: KnownCrank) -> None:
    """Keep the facts about one crank; the file is whole at any time."""
    kept = {name: asdict(each) for name, each in {**known_cranks(project), file: crank}.items()}
    project.write_text(f"{APP_FOLDER}/{FILE}", json.dumps(kept, ensure_ascii=False))


def _path(project: Project) -> Path:
    return project.folder / APP_FOLDER / FILE


def scaled_crank(project: Project, file: str, factor: float, stroke_mm: float) -> str:
    """Write a crank's triangles times ``factor`` as a separate file in mm; return its name.

    Raises
    ------
    FormatError
        If the file has its own unit, or is not one.
    """
    from autobalance.solid.formats.gltf import file_bytes
    from autobalance.solid.formats.registry import format_of, needs_unit

    path = project.folder / file
    kind = format_of(path)
    if kind is None or not needs_unit(path):
        raise FormatError(f"{file} has its own unit of length; only files without one are scaled")
    with np.errstate(all="ignore"):  # numbers that overflow are refused when the file is opened
        soup: Array = kind.read(file_bytes(path)).soup.astype(np.float64) * factor
        corners = soup.reshape(-1, 3).astype(kind.number)
    data = kind.write(corners, np.arange(len(corners), dtype=np.int64).reshape(-1, 3), 1.0)
    with TemporaryDirectory() as folder:
        made = Path(folder) / f"{path.stem}-stroke-{stroke_mm:g}{path.suffix}"
        made.write_bytes(data)
        name = project.copied(made)
    before = known_cranks(project).get(file, KnownCrank()).name
    keep_crank(project, name, KnownCrank(before, file, factor, stroke_mm))
    return name


def copied_crank(project: Project, file: str) -> str:
    """Copy a crank's file under a new name; return that. It is called as the crank, with a number."""
    known, path = known_cranks(project), project.folder / file
    target = free(project.folder, file)
    number = target.stem.rpartition("-")[2]
    with file_errors(f"copy {file}"):
        target.write_bytes(path.read_bytes())
    own = known.get(file, KnownCrank())
    keep_crank(project, target.name, replace(own, name=f"{own.name or path.stem} {number}"[-LONGEST_NAME:]))
    return target.name


class CrankNames:
    """The endpoints."""

    def __init__(self, project: Project) -> None:
        self._project = project

    def routes(self) -> list[Route]:
        return [
            Route("/api/cranks", self.read),
            Route("/api/cranks", self.rename, methods=["PUT"]),
            Route("/api/cranks/picture", self.picture),
            Route("/api/cranks/picture", self.keep_picture, methods=["PUT"]),
        ]

    @property
    def _pictures(self) -> Path:
        return self._project.folder / APP_FOLDER / PICTURES

    def told(self) -> dict[str, dict[str, Any]]:
        """Return the facts about the cranks, as the page has them; ``picture`` changes with the picture."""
        pictured = {
            path.name.removesuffix(".png"): float(path.stat().st_mtime_ns)
            for path in self._pictures.glob("*.png")
        }
        here = {name: KnownCrank() for name in pictured if self._project.file(name) is not None}
        known = here | known_cranks(self._project)
        return {name: {**asdict(each), "picture": pictured.get(name, 0.0)} for name, each in known.items()}

    async def picture(self, request: Request) -> Response:
        """Give the small picture of a crank."""
        file = request.query_params.get("file", "")
        path = self._pictures / f"{file}.png"
        return file_of(path if self._project.file(file) is not None and path.is_file() else None)

    async def keep_picture(self, request: Request) -> Response:
        """Keep a small picture of a crank, as the page's view shows it."""
        file = request.query_params.get("file", "")
        if self._project.file(file) is None:
            return refused("file must be the name of a file in the project", 400)
        data = b""
        async for chunk in request.stream():
            data += chunk
            if len(data) > LARGEST_PICTURE:
                return refused(f"a picture must have at most {LARGEST_PICTURE} bytes", 413)
        if not data.startswith(PNG):
            return refused("the body must be a PNG", 400)
        self._pictures.mkdir(parents=True, exist_ok=True)
        self._project.write_bytes(f"{APP_FOLDER}/{PICTURES}/{file}.png", data)
        return JSONResponse({"cranks": self.told()})

    async def read(self, _: Request) -> Response:
        """Return the facts about the project's cranks."""
        return JSONResponse({"cranks": self.told()})

    async def rename(self, request: Request) -> Response:
        """Give a crank another name; an empty one is its file's own."""
        values = await body_of(request)
        file, name = (values.get(key) if isinstance(values, dict) else None for key in ("file", "name"))
        if not isinstance(file, str) or not isinstance(name, str):
            return refused('the body must be {"file": ..., "name": ...}', 400)
        name = name.strip()
        if self._project.file(file) is None:
            return refused("file must be the name of a file in the project", 400)
        if len(name) > LONGEST_NAME or not name.isprintable():
            return refused(f"name must be one line of at most {LONGEST_NAME} characters", 400)
        known = known_cranks(self._project).get(file, KnownCrank())
        keep_crank(self._project, file, replace(known, name=name))
        return JSONResponse({"cranks": self.told()})
