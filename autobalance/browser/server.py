"""The server: endpoints over the project and its runs, on 127.0.0.1 alone."""

from __future__ import annotations

import socket
from collections.abc import Callable, Sequence
from importlib import resources
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from autobalance.browser.analyses import ANALYSES, AnalysisFiles, wrong_request
from autobalance.browser.bundle import script, style
from autobalance.browser.cranks import CrankNames, saved_name
from autobalance.browser.drawing import DrawingEndpoints
from autobalance.browser.guard import (
    PICTURES,
    TOKEN_HEADER,
    Guard,
    Keys,
    asset,
    body_of,
    drained,
    file_of,
    has_cookie,
    jsonable,
    packed,
    refused,
)
from autobalance.browser.live import Live
from autobalance.browser.opening import (
    JOBS,
    duplicate_crank,
    job_of,
    job_told,
    open_crank,
    open_job_of,
    open_own_job,
    open_report,
)
from autobalance.browser.project import RUN_ID, Project, TooLarge, is_plain, named_files
from autobalance.browser.runs import Runs
from autobalance.browser.work import SHEET, VERBS
from autobalance.errors import AutobalanceError
from autobalance.job.from_options import differences
from autobalance.toml_files.document import toml_of, toml_text
from autobalance.version import __version__

TYPES = {".js": "text/javascript", ".css": "text/css", ".json": "application/json", **PICTURES}


def _static() -> dict[str, tuple[str, str, str]]:
    """Return the page's own files: name → where it lies in the package, and its type."""
    names = (each.name for each in resources.files("autobalance.browser").joinpath("static").iterdir())
    own = {
        name: ("browser", f"static/{name}", TYPES[Path(name).suffix])
        for name in names
        if Path(name).suffix in TYPES
    }
    return {**own, "three.min.js": ("report", "assets/three.min.js", TYPES[".js"])}


STATIC = _static()
APP_PAGE = "app.md"
"""Page of the documentation that explains the app."""
OTHER_ENDINGS = (".toml", ".xlsx", ".json")
"""Endings of files that may be opened besides cranks: jobs and reports."""


def _endings() -> dict[str, str]:
    """Return the endings of files that the page takes, as it has them."""
    from autobalance.solid.formats.registry import needs_unit
    from autobalance.solid.formats.table import endings

    cranks = endings()
    known = [each[1:] for each in cranks]
    unitless = [each for each in cranks if needs_unit(Path(f"crank{each}"))]
    return {
        "accept": ",".join((*cranks, *OTHER_ENDINGS)),
        "cranks": " ".join(known),
        "unitless": " ".join(each[1:] for each in unitless),
    }


def project_urls() -> tuple[str, ...]:
    """Return the addresses that the installed package states, as its metadata has them."""
    try:
        return tuple(metadata("autobalance").get_all("Project-URL") or ())
    except PackageNotFoundError:
        return ()


def documentation(urls: Sequence[str]) -> str:
    """Return the address of the app's page in the documentation; empty if a package does not state it."""
    found = (each.removeprefix("Documentation, ") for each in urls if each.startswith("Documentation, "))
    index = next(found, "")
    return f"{index.rpartition('/')[0]}/{APP_PAGE}" if index else ""


DOCS = documentation(project_urls())


class Pages:
    """The endpoints."""

    def __init__(self, project: Project, runs: Runs, keys: Keys, max_upload_bytes: int) -> None:
        self._project, self._runs, self._keys, self._most = project, runs, keys, max_upload_bytes
        self._names = CrankNames(project)
        self._live = Live(project, runs, self._names)
        self._openings = 0
        self._joined = {"page.js": (script(), TYPES[".js"]), "page.css": (style(), TYPES[".css"])}

    def routes(self) -> list[Route]:
        return [
            Route("/", self.page),
            Route("/static/{name}", self.static),
            Route("/api/health", self.health),
            Route("/api/job", self.keep_job, methods=["PUT"]),
            Route("/api/job/text", self.type_job, methods=["PUT"]),
            Route("/api/files", self.upload, methods=["POST"]),
            Route("/api/open", self.open, methods=["POST"]),
            Route("/api/duplicate", self.duplicate, methods=["POST"]),
            Route("/api/runs", self.all_runs),
            Route("/api/runs", self.start, methods=["POST"]),
            Route("/api/runs/{run}", self.one_run),
            Route("/api/runs/{run}", self.delete, methods=["DELETE"]),
            Route("/api/runs/{run}/cancel", self.cancel, methods=["POST"]),
            Route("/api/runs/{run}/report", self.report),
            Route("/api/runs/{run}/files/{name}", self.result),
            *self._live.routes(),
            *self._names.routes(),
            *DrawingEndpoints(self._project, self._names).routes(),
            *AnalysisFiles(self._project).routes(),
        ]

    async def page(self, request: Request) -> Response:
        """Give the page: with its token once for each opening of the address, which becomes a cookie first.

        Reloaded by the cookie alone the page is without: it keeps the token in its tab, and other servers on
        this machine are sent the cookie too.
        """
        if "token" in request.query_params:
            if not self._keys.is_token(request.query_params["token"]):
                return refused("the token is wrong; open the address that was printed", 401)
            self._openings += 1
            answer: Response = RedirectResponse("/", 303)
            answer.set_cookie(
                self._keys.cookie_name, self._keys.cookie, httponly=True, samesite="strict", path="/"
            )
            return answer
        knows = self._keys.is_token(request.headers.get(TOKEN_HEADER))
        if not (knows or has_cookie(request.headers.get("cookie", ""), self._keys)):
            return refused("the token is missing; open the address that was printed", 401)
        if not knows and self._openings:
            self._openings, knows = self._openings - 1, True
        self._runs.prepare()  # a person is about to ask for something
        text = asset("browser", "static/index.html").decode()
        token = self._keys.token if knows else ""
        known = {"token": token, "version": __version__, "docs": DOCS}
        for name, value in {**known, **_endings()}.items():
            text = text.replace(f"{{{{{name}}}}}", value)
        return HTMLResponse(text)

    async def static(self, request: Request) -> Response:
        """Give a file of the page's own."""
        name = request.path_params["name"]
        if name in self._joined:
            return packed(request, *self._joined[name])
        static = STATIC.get(name)
        if static is None:
            return refused("there is no such file", 404)
        room, path, kind = static
        return packed(request, asset(room, path), kind)

    async def health(self, _: Request) -> Response:
        """Return a reply that the server exists, with its version."""
        return JSONResponse({"ok": True, "version": __version__})

    # --- the project ----------------------------------------------------------------------------------------

    async def keep_job(self, request: Request) -> Response:
        """Keep the page's job as ``job.toml`` and give its text."""
        values = await body_of(request)
        if not isinstance(values, dict):
            return refused("the body is not a JSON object", 400)
        try:
            text = toml_text(values)
        except AutobalanceError as error:
            return refused(str(error), 400)
        return self._kept(request, text) or JSONResponse(
            {"job_text": text, "job_version": self._project.job_version}
        )

    async def type_job(self, request: Request) -> Response:
        """Keep a job as it was typed."""
        values = await body_of(request)
        text = values.get("toml") if isinstance(values, dict) else None
        if not isinstance(text, str):
            return refused('the body must be {"toml": TEXT}', 400)
        try:
            toml_of(text, "job.toml")
        except AutobalanceError as error:
            return refused(str(error), 400)
        return self._kept(request, text) or JSONResponse(
            {
                "job": jsonable(job_of(self._project)),
                "job_text": text,
                "job_version": self._project.job_version,
            }
        )

    def _kept(self, request: Request, text: str) -> Response | None:
        """Keep the text of the job; refuse it where ``If-Match`` names another job than the one kept here."""
        known, here = request.headers.get("if-match"), self._project.job_version
        if known is None or known == here:
            self._project.write_job(text)
            return None
        mine = toml_of(text, "job.toml")
        found = list(differences(mine, job_of(self._project)))
        words = "; ".join(f"{each.key} is {each.now!r} there, {each.was!r} here" for each in found[:3])
        return JSONResponse(
            {
                "error": f"the job was changed in another tab: {words or 'its text'}; load this page again",
                "changes": jsonable([each._asdict() for each in found]),
                "job_version": here,
            },
            409,
        )

    async def upload(self, request: Request) -> Response:
        """Keep a file that is sent, as it comes in; ``apart``: one of the files of a result."""
        name, apart = request.query_params.get("name", ""), request.query_params.get("apart")
        if not is_plain(name):
            return refused("name must be a plain file name: no folder, no leading dot", 400)
        if apart is not None and (not RUN_ID.fullmatch(apart) or self._runs.state_of(apart) is not None):
            return refused("apart must be 12 digits 0 to f that no run has", 400)
        length = request.headers.get("content-length", "")
        body = request.stream()
        try:
            if length.isdecimal() and int(length) > self._most:
                return _too_large(self._most)  # at once: a stated length may be anything
            kept = await self._project.keep(name, body, self._most, apart)
        except TooLarge:
            await drained(body)
            return _too_large(self._most)
        except ClientDisconnect:
            return refused("the upload was broken off", 400)
        return JSONResponse(kept, 201)

    async def open(self, request: Request) -> Response:
        """Make a file the project's job or crank, or a result one of its runs; or take a run's job again."""
        values = await body_of(request)
        if isinstance(values, dict) and set(values) == {"run"}:
            return self._job_of_a_run(str(values["run"]))
        name = values.get("file") if isinstance(values, dict) else None
        apart = values.get("apart") if isinstance(values, dict) else None
        if not isinstance(name, str) or not (apart is None or isinstance(apart, str)):
            return refused('the body must be {"file": ...}', 400)
        path = self._project.file(name) if apart is None else self._project.own(apart, name)
        if path is None:
            return refused("file must be the name of a file in the project", 400)
        try:
            run = await run_in_threadpool(self._opened, path, apart)
        except AutobalanceError as error:
            return refused(self._project.as_named(str(error)), 400)
        return JSONResponse({"run": run, **self._job()})

    def _job_of_a_run(self, run: str) -> Response:
        made_of = self._runs.job(run)
        if made_of is None:
            return refused("there is no such run, or its job is not known", 404)
        try:
            open_job_of(made_of, self._project)
        except AutobalanceError as error:
            return refused(str(error), 400)
        return JSONResponse({"run": run, **self._job()})

    async def duplicate(self, _: Request) -> Response:
        """Make a second job of the open crank beside the first, by another name."""
        return await self._changed(duplicate_crank, self._project)

    async def _changed(self, work: Callable[..., Any], *given: Any) -> Response:
        try:
            await run_in_threadpool(work, *given)
        except AutobalanceError as error:
            return refused(str(error), 400)
        return JSONResponse(self._job())

    def _job(self) -> dict[str, Any]:
        return {**job_told(self._project), "cranks": self._names.told()}

    def _opened(self, path: Path, apart: str | None) -> str | None:
        ending = path.suffix.lower()
        if ending == ".json":
            try:
                run = open_report(path, self._project, anywhere=False)
            finally:
                if apart is not None:
                    self._project.forget(apart)
            self._runs.take_up()
            return run
        if ending in JOBS:
            open_own_job(path.name, self._project)
        else:
            open_crank(path.name, self._project)
        return None

    # --- runs -----------------------------------------------------------------------------------------------

    async def all_runs(self, _: Request) -> Response:
        """Return all runs."""
        return JSONResponse({"runs": self._runs.all()})

    async def start(self, request: Request) -> Response:
        """Begin a run."""
        values = await body_of(request)
        if not isinstance(values, dict):
            return refused('the body must be {"verb": ..., "job": {...}}', 400)
        verb = values.pop("verb", None)
        if not isinstance(verb, str) or verb not in VERBS:
            return refused(f"verb must be one of {', '.join(VERBS)}", 400)
        look = {
            "recut": self._wrong_reading,
            "nc": self._wrong_machine,
            "scale": self._wrong_scale,
        }.get(verb, self._wrong_job)
        wrong = look(values) if verb not in ANALYSES else wrong_request(verb, values, self._project)
        if verb in ANALYSES and not wrong and "job" in values:
            wrong = self._wrong_job({"job": values["job"]})
        return refused(wrong, 400) if wrong else JSONResponse({"id": self._runs.start(verb, values)}, 202)

    def _wrong_job(self, values: dict[str, Any]) -> str:
        """Return the error in a job, "" if it is correct: its files are the project's own."""
        job = values.get("job")
        if set(values) - {"job"}:
            return 'the body must be {"verb": ..., "job": {...}}'
        if not isinstance(job, dict) or not isinstance(job.get("crankshaft"), dict):
            return "job must be an object with crankshaft"
        for where, name in named_files(job):
            if not isinstance(name, str) or self._project.file(name) is None:
                return f"{where} must be the name of a file in the project"
        if "file" not in job["crankshaft"]:
            return "crankshaft.file must be the name of a file in the project"
        return ""

    def _wrong_reading(self, values: dict[str, Any]) -> str:
        """Return the error in a reading on the result of a run, "" if it is correct."""
        if set(values) - {"run", "reading", "trust_reading"} or not isinstance(values.get("reading"), dict):
            return 'the body must be {"verb": "recut", "run": ..., "reading": {...}}'
        return self._wrong_result(values)

    def _wrong_machine(self, values: dict[str, Any]) -> str:
        """Return the error in a machine file for the result of a run, "" if it is correct."""
        if set(values) - {"run", "machine"} or not isinstance(values.get("machine"), str):
            return 'the body must be {"verb": "nc", "run": ..., "machine": "text of a machine file"}'
        return self._wrong_result(values)

    def _wrong_scale(self, values: dict[str, Any]) -> str:
        """Return the error in a request to scale a crank's file, "" if it is correct."""
        factor, stroke = values.get("factor"), values.get("stroke_mm")
        numbers = all(isinstance(each, int | float) and 0.0 < each < 1e9 for each in (factor, stroke))
        if set(values) != {"job", "factor", "stroke_mm"} or not numbers:
            return 'the body must be {"verb": "scale", "job": ..., "factor": ..., "stroke_mm": ...}, both > 0'
        return self._wrong_job({"job": values["job"]})

    def _wrong_result(self, values: dict[str, Any]) -> str:
        run = self._runs.state_of(str(values.get("run")))
        if run is None or run["state"] != "done" or run["verb"] not in ("balance", "recut"):
            return "run must be a run of balance or recut that is done"
        return ""

    async def one_run(self, request: Request) -> Response:
        """Return one run."""
        run = self._runs.state_of(request.path_params["run"])
        return refused("there is no such run", 404) if run is None else JSONResponse(run)

    async def delete(self, request: Request) -> Response:
        """Take a run away with all its files; what still runs is ended first."""
        if not await run_in_threadpool(self._runs.delete, request.path_params["run"]):
            return refused("there is no such run", 404)
        return JSONResponse({"runs": self._runs.all()})

    async def cancel(self, request: Request) -> Response:
        """End a run."""
        if not await run_in_threadpool(self._runs.cancel, request.path_params["run"]):
            return refused("there is no such run", 404)
        return JSONResponse(self._runs.state_of(request.path_params["run"]), 202)

    async def report(self, request: Request) -> Response:
        """Give a run's report."""
        path = self._of_run(request.path_params["run"], "report.json")
        return file_of(None) if path is None else FileResponse(path, media_type="application/json")

    async def result(self, request: Request) -> Response:
        """Give a file of a run."""
        name = request.path_params["name"]
        run = request.path_params["run"]
        path = self._of_run(run, name)
        if path is not None and name.endswith(SHEET):
            path = await run_in_threadpool(self._runs.sheet_with_ticks, run) or path
        told = self._runs.state_of(run)
        saved_as = name if told is None else saved_name(self._project, told, name)
        return file_of(path, saved_as, "show" in request.query_params)

    def _of_run(self, run: str, name: str) -> Path | None:
        record = self._runs.state_of(run)
        return self._project.result(run, name) if record is not None and name in record["files"] else None


def _too_large(most_bytes: int) -> Response:
    return refused(f"the file is larger than {most_bytes >> 20} MB", 413)


async def _missing(_: Request, error: Exception) -> Response:
    status = getattr(error, "status_code", 500)
    return refused("there is nothing here" if status == 404 else "this cannot be done here", status)


def application(project: Project, runs: Runs, keys: Keys, port: int, max_upload_mb: int) -> ASGIApp:
    """Return the guarded app."""
    pages = Pages(project, runs, keys, max_upload_mb << 20)
    app = Starlette(routes=pages.routes(), exception_handlers={404: _missing, 405: _missing, 500: _missing})
    return Guard(app, keys, port)


def listening_socket(port: int) -> socket.socket:
    """Return a socket on 127.0.0.1; port 0: any that is free."""
    # asyncio sends without delay on a socket that names its protocol; else each answer takes 40 ms
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(("127.0.0.1", port))
        listener.listen(128)  # now: who reads the address may ask before the server has started
    except BaseException:
        listener.close()
        raise
    return listener
