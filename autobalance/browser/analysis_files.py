"""Endpoints of the files that verbs read beside the job: a rotor, a bearing, a bench, a design."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from autobalance.browser.analyses import ANALYSES, example
from autobalance.browser.answers import body_of, file_of, jsonable, refused
from autobalance.errors import AutobalanceError
from autobalance.toml_files.document import toml_of
from autobalance.toml_files.text import toml_text

if TYPE_CHECKING:
    from autobalance.browser.project import Project


class AnalysisFiles:
    """The endpoints; the file of a verb is ``VERB.toml`` in the project."""

    def __init__(self, project: Project) -> None:
        self._project = project

    def routes(self) -> list[Route]:
        return [
            Route("/api/analyses/{verb}", self.read),
            Route("/api/analyses/{verb}", self.keep, methods=["PUT"]),
        ]

    async def read(self, request: Request) -> Response:
        """Give the file of a verb: the project's, else an example."""
        verb = request.path_params["verb"]
        if not _has_file(verb):
            return file_of(None)
        path = self._project.file(f"{verb}.toml")
        if path is None or "example" in request.query_params:
            return _document(example(verb), verb)
        return _document(path.read_text(encoding="utf-8", errors="replace"), verb)

    async def keep(self, request: Request) -> Response:
        """Keep the file of a verb, as tables or as it was typed."""
        verb, values = request.path_params["verb"], await body_of(request)
        if not _has_file(verb):
            return file_of(None)
        tables, text = (values.get(name) if isinstance(values, dict) else None for name in ("tables", "toml"))
        if not isinstance(tables, dict) and not isinstance(text, str):
            return refused('the body must be {"tables": {...}} or {"toml": TEXT}', 400)
        try:
            kept = toml_text(tables) if isinstance(tables, dict) else str(text)
            toml_of(kept, f"{verb}.toml")
        except AutobalanceError as error:
            return refused(str(error), 400)
        self._project.write_text(f"{verb}.toml", kept)
        return _document(kept, verb)


def _has_file(verb: str) -> bool:
    return verb in ANALYSES and bool(ANALYSES[verb].schema)


def _document(text: str, verb: str) -> Response:
    """Return the text of a verb's file with its tables; without those where it is not TOML."""
    try:
        tables = jsonable(toml_of(text, f"{verb}.toml"))
    except AutobalanceError:
        tables = {}
    return JSONResponse({"text": text, "tables": tables})
