"""The server: endpoints over the project and its runs, on 127.0.0.1 alone."""

from __future__ import annotations

import json
import socket
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from autobalance.job.toml_text import toml_text
from autobalance.version import __version__
from autobalance.web_app.guard import COOKIE, Guard, Keys, has_cookie
from autobalance.web_app.project import JOB, Project, TooLarge, is_plain
from autobalance.web_app.runs import Runs
from autobalance.web_app.work import VERBS

LARGEST_JOB = 1 << 20
STATIC = {
    "app.js": ("web_app", "static/app.js", "text/javascript"),
    "view.js": ("web_app", "static/view.js", "text/javascript"),
    "app.css": ("web_app", "static/app.css", "text/css"),
    "three.min.js": ("report", "assets/three.min.js", "text/javascript"),
}
"""The page's own files: name → where it lies in the package, and its type."""
FILE_KEYS = ("file", "trace")


class Pages:
    """The endpoints."""

    def __init__(self, project: Project, runs: Runs, keys: Keys, max_upload_bytes: int) -> None:
        """Serve a project."""
        self._project, self._runs, self._keys, self._most = project, runs, keys, max_upload_bytes

    def routes(self) -> list[Route]:
        """Return all endpoints."""
        return [
            Route("/", self.page),
            Route("/static/{name}", self.static),
            Route("/api/health", self.health),
            Route("/api/project", self.project),
            Route("/api/job", self.keep_job, methods=["PUT"]),
            Route("/api/files", self.upload, methods=["POST"]),
            Route("/api/runs", self.all_runs),
            Route("/api/runs", self.start, methods=["POST"]),
            Route("/api/runs/{run}", self.one_run),
            Route("/api/runs/{run}/cancel", self.cancel, methods=["POST"]),
            Route("/api/runs/{run}/report", self.report),
            Route("/api/runs/{run}/files/{name}", self.result),
        ]

    async def page(self, request: Request) -> Response:
        """Give the page, with its token in it; the address's token becomes a cookie first."""
        if "token" in request.query_params:
            if not self._keys.is_token(request.query_params["token"]):
                return _error("the token is wrong; open the address that was printed", 401)
            answer = RedirectResponse("/", 303)
            answer.set_cookie(COOKIE, self._keys.cookie, httponly=True, samesite="strict", path="/")
            return answer
        header = request.headers.get("cookie", "")
        if not (
            has_cookie(header, self._keys) or self._keys.is_token(request.headers.get("x-autobalance-token"))
        ):
            return _error("the token is missing; open the address that was printed", 401)
        text = _asset("web_app", "static/index.html").decode()
        return HTMLResponse(text.replace("{{token}}", self._keys.token).replace("{{version}}", __version__))

    async def static(self, request: Request) -> Response:
        """Give a file of the page's own."""
        found = STATIC.get(request.path_params["name"])
        if found is None:
            return _error("there is no such file", 404)
        room, path, kind = found
        return Response(_asset(room, path), media_type=kind)

    async def health(self, _: Request) -> Response:
        """Say that the server is there."""
        return JSONResponse({"ok": True, "version": __version__})

    async def project(self, _: Request) -> Response:
        """Tell what the project holds: files, the job as text and as tables."""
        path = self._project.file(JOB)
        text = "" if path is None else path.read_text(encoding="utf-8", errors="replace")
        try:
            tables: Any = tomllib.loads(text)
        except tomllib.TOMLDecodeError:
            tables = {}
        return JSONResponse({"files": self._project.files(), "job_text": text, "job": tables})

    async def keep_job(self, request: Request) -> Response:
        """Keep the page's job as ``job.toml`` and give its text."""
        values = await _body(request)
        if not isinstance(values, dict):
            return _error("the body is no JSON object", 400)
        text = toml_text(values)
        (self._project.folder / JOB).write_text(text, encoding="utf-8")
        return JSONResponse({"job_text": text})

    async def upload(self, request: Request) -> Response:
        """Keep a file that is sent, as it comes in."""
        name = request.query_params.get("name", "")
        if not is_plain(name):
            return _error("name must be a plain file name: no folder, no leading dot", 400)
        length = request.headers.get("content-length", "")
        if length.isdecimal() and int(length) > self._most:
            return _error(f"the file is larger than {self._most >> 20} MB", 413)
        try:
            kept = await self._project.keep(name, request.stream(), self._most)
        except TooLarge:
            return _error(f"the file is larger than {self._most >> 20} MB", 413)
        except ClientDisconnect:
            return _error("the upload was broken off", 400)
        path = self._project.folder / str(kept["file"])
        if path.suffix.lower() == ".toml":
            copied_in(path, self._project)
        return JSONResponse(kept, 201)

    async def all_runs(self, _: Request) -> Response:
        """Tell all runs."""
        return JSONResponse({"runs": self._runs.all()})

    async def start(self, request: Request) -> Response:
        """Begin a run."""
        values = await _body(request)
        if not isinstance(values, dict) or set(values) - {"verb", "job"}:
            return _error('the body must be {"verb": ..., "job": {...}}', 400)
        verb, job = values.get("verb"), values.get("job")
        if verb not in VERBS:
            return _error(f"verb must be one of {', '.join(VERBS)}", 400)
        if not isinstance(job, dict) or not isinstance(job.get("crankshaft"), dict):
            return _error("job must be an object with crankshaft", 400)
        for where, name in _named_files(job, ""):
            if not isinstance(name, str) or self._project.file(name) is None:
                return _error(f"{where} must be the name of a file in the project", 400)
        if "file" not in job["crankshaft"]:
            return _error("crankshaft.file must be the name of a file in the project", 400)
        return JSONResponse({"id": self._runs.start(verb, job)}, 202)

    async def one_run(self, request: Request) -> Response:
        """Tell one run."""
        found = self._runs.told(request.path_params["run"])
        return _error("there is no such run", 404) if found is None else JSONResponse(found)

    async def cancel(self, request: Request) -> Response:
        """End a run."""
        from starlette.concurrency import run_in_threadpool

        if not await run_in_threadpool(self._runs.cancel, request.path_params["run"]):
            return _error("there is no such run", 404)
        return JSONResponse(self._runs.told(request.path_params["run"]), 202)

    async def report(self, request: Request) -> Response:
        """Give a run's report."""
        return self._file(request.path_params["run"], "report.json", "application/json")

    async def result(self, request: Request) -> Response:
        """Give a file of a run."""
        return self._file(request.path_params["run"], request.path_params["name"], None)

    def _file(self, run: str, name: str, kind: str | None) -> Response:
        told = self._runs.told(run)
        path = self._project.result(run, name)
        if told is None or path is None or name not in told["files"]:
            return _error("there is no such file", 404)
        if kind is not None:
            return FileResponse(path, media_type=kind)
        return FileResponse(path, media_type="application/octet-stream", filename=path.name)


def _named_files(values: Any, path: str) -> list[tuple[str, Any]]:
    """Return every file that a job names, with its key."""
    found: list[tuple[str, Any]] = []
    if isinstance(values, dict):
        for key, value in values.items():
            where = f"{path}.{key}" if path else str(key)
            found += [(where, value)] if key in FILE_KEYS else _named_files(value, where)
    elif isinstance(values, list):
        for place, item in enumerate(values, 1):
            found += _named_files(item, f"{path}[{place}]")
    return found


async def _body(request: Request) -> Any:
    """Return the JSON of a small body; None where it is none."""
    data = b""
    async for chunk in request.stream():
        data += chunk
        if len(data) > LARGEST_JOB:
            return None
    try:
        return json.loads(data)
    except (ValueError, RecursionError):
        return None


def _error(text: str, status: int) -> Response:
    return JSONResponse({"error": text}, status)


def _asset(room: str, path: str) -> bytes:
    return (resources.files(f"autobalance.{room}") / path).read_bytes()


async def _missing(_: Request, error: Exception) -> Response:
    status = getattr(error, "status_code", 500)
    return _error("there is nothing here" if status == 404 else "this cannot be done here", status)


def application(project: Project, runs: Runs, keys: Keys, port: int, max_upload_mb: int) -> ASGIApp:
    """Return the guarded app."""
    pages = Pages(project, runs, keys, max_upload_mb << 20)
    app = Starlette(routes=pages.routes(), exception_handlers={404: _missing, 405: _missing, 500: _missing})
    return Guard(app, keys, port)


def listening_socket(port: int) -> socket.socket:
    """Return a socket on 127.0.0.1; port 0: any that is free."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind(("127.0.0.1", port))
        found.listen(128)  # now: who reads the address may ask before the server has started
    except BaseException:
        found.close()
        raise
    return found


def copied_in(source: Path, project: Project) -> None:
    """Copy a crank, a job with its crank, or a folder's files into the project."""
    import shutil

    files = [source] if source.is_file() else [path for path in sorted(source.iterdir()) if path.is_file()]
    for path in files:
        if path.suffix.lower() == ".toml":
            try:
                values = tomllib.loads(path.read_text(encoding="utf-8"))
            except ValueError:  # no UTF-8, or no TOML
                continue
            crank = values.get("crankshaft", {}).get("file")
            if isinstance(crank, str):
                found = path.parent / crank
                if found.is_file() and found.resolve().parent != project.folder:
                    shutil.copy(found, project.folder / Path(crank).name)
                values["crankshaft"]["file"] = Path(crank).name
            (project.folder / JOB).write_text(toml_text(values), encoding="utf-8")
        elif is_plain(path.name):
            shutil.copy(path, project.folder / path.name)
