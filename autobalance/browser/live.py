"""Endpoints of what the page shows as one types, drags and turns: from results that were measured."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from autobalance.browser.analyses import analyses
from autobalance.browser.cranks import saved_name
from autobalance.browser.forms import limits, tables
from autobalance.browser.guard import BINARY, body_of, file_of, jsonable, packed, refused
from autobalance.browser.opening import job_of
from autobalance.browser.prediction import DRAGGED_KEYS, PredictionModel, predicted, preview
from autobalance.browser.project import named_files
from autobalance.browser.work import CARDS, MESH, MODEL, VIEW, WEBS
from autobalance.declare import decoded, encoded
from autobalance.errors import AutobalanceError
from autobalance.paper.verb import DONE
from autobalance.toml_files.document import toml_text

if TYPE_CHECKING:
    from autobalance.browser.cranks import CrankNames
    from autobalance.browser.project import Project
    from autobalance.browser.runs import Runs

REPORT = "report.json"
CUTTERS = ("balance", "recut")
"""Verbs whose result has cuts to make."""
MOST_POLARS = 40
MOST_SIGN = 4


class Live:
    """The endpoints."""

    def __init__(self, project: Project, runs: Runs, names: CrankNames) -> None:
        self._project, self._runs, self._names = project, runs, names

    def routes(self) -> list[Route]:
        return [
            Route("/api/start", self.start),
            Route("/api/project", self.project),
            Route("/api/kinds", self.kinds),
            Route("/api/index-test", self.index_test, methods=["POST"]),
            Route("/api/polars", self.polars, methods=["POST"]),
            Route("/api/runs/{run}/asked", self.asked),
            Route("/api/runs/{run}/job", self.job),
            Route("/api/runs/{run}/mesh", self.mesh),
            Route("/api/runs/{run}/view", self.view),
            Route("/api/runs/{run}/webs", self.webs),
            Route("/api/runs/{run}/model", self.model),
            Route("/api/runs/{run}/ticks", self.ticks),
            Route("/api/runs/{run}/ticks", self.tick, methods=["PUT"]),
            Route("/api/runs/{run}/papers/{name}", self.paper),
            Route("/api/runs/{run}/cards", self.cards),
            Route("/api/runs/{run}/cards/{name}", self.card),
            Route("/api/runs/{run}/predict", self.predict, methods=["POST"]),
            Route("/api/runs/{run}/preview", self.preview, methods=["POST"]),
        ]

    async def start(self, request: Request) -> Response:
        """Return the first answers of a page: forms, project, runs, and the results that it shows.

        ``run`` is the result that the page showed last.
        """
        project, runs = self._told(), self._runs.all()
        table = project["job"].get("crankshaft")  # as it was typed
        crank = table.get("file") if isinstance(table, dict) else None
        own = [each for each in runs if each["state"] == "done" and each["crank"] in (crank, None)]
        looked = [each["id"] for each in own if each["verb"] == "inspect"]
        made = [each["id"] for each in own if each["verb"] in CUTTERS]
        before = request.query_params.get("run")
        shown = [*looked[-1:], *([before] if before in made else made[-1:])]
        answers = {
            f"/api/runs/{run}/{name}": json.loads(path.read_text(encoding="utf-8"))
            for run in shown
            for name, path in (
                ("report", self._project.result(run, REPORT)),
                ("model", self._project.own(run, MODEL)),
            )
            if path is not None
        }
        for told in own:
            if told["id"] in shown and told["verb"] in CUTTERS:
                answers[f"/api/runs/{told['id']}/ticks"] = self._ticks(told)
        forms = await run_in_threadpool(_forms)
        values = {"forms": forms, "project": project, "runs": runs, "answers": answers}
        return packed(request, json.dumps(values, ensure_ascii=False).encode(), "application/json")

    async def project(self, _: Request) -> Response:
        """Return the project: its files, the job as text and as tables."""
        return JSONResponse(self._told())

    def _told(self) -> dict[str, Any]:
        return {
            "files": self._project.files(),
            "cranks": self._names.told(),
            "job_text": self._project.job_text,
            "job_version": self._project.job_version,
            "job": jsonable(job_of(self._project)),
        }

    async def kinds(self, request: Request) -> Response:
        """Return the source of the page's forms: kinds, tables and analyses, usual parts, grades, presets."""
        values = await run_in_threadpool(_forms)
        return packed(request, json.dumps(values, ensure_ascii=False).encode(), "application/json")

    async def index_test(self, request: Request) -> Response:
        """Return the parts of two readings that are the crank's, and its tooling's."""
        from dataclasses import asdict

        from autobalance.theory.machines import index_test

        values, names = await body_of(request), ("turned_deg", "readings_g_mm", "readings_deg")
        if (
            not isinstance(values, dict)
            or set(values) != set(names)
            or not all(map(_numbers, values.values()))
        ):
            return refused(f"the body must have lists of numbers: {', '.join(names)}", 400)
        try:
            return JSONResponse(asdict(index_test(**values)))
        except ValueError as error:
            return refused(str(error), 400)

    async def polars(self, request: Request) -> Response:
        """Return polars as the report page draws them, as SVG."""
        values = await body_of(request)
        asked = values.get("polars") if isinstance(values, dict) else None
        if not isinstance(asked, list) or len(asked) > MOST_POLARS:
            return refused(f'the body must be {{"polars": [...]}}, at most {MOST_POLARS}', 400)
        try:
            return JSONResponse({"drawn": [_polar(each) for each in asked]})
        except (ArithmeticError, KeyError, TypeError, ValueError):
            return refused("a polar is permitted_g_mm > 0, zero_deg, sign, expected_g_mm, vectors", 400)

    async def asked(self, request: Request) -> Response:
        """Return the request of a run."""
        result = self._runs.asked(request.path_params["run"])
        return refused("there is no such run", 404) if result is None else JSONResponse(result)

    async def job(self, request: Request) -> Response:
        """Return the job that made a run's result, as a file has it."""
        made_of = self._runs.job(request.path_params["run"])
        if made_of is None:
            return refused("there is no such run, or its job is not known", 404)
        return Response(toml_text(made_of), media_type="application/toml")

    async def mesh(self, request: Request) -> Response:
        """Give the crank of an inspection as a buffer."""
        return await self._own(request.path_params["run"], MESH)

    async def view(self, request: Request) -> Response:
        """Give a corrected crank and the metal that went as a buffer."""
        return await self._own(request.path_params["run"], VIEW)

    async def webs(self, request: Request) -> Response:
        """Return webs and sections of a result as the sheet draws them: kind, title, labels, SVG."""
        return await self._own(request.path_params["run"], WEBS)

    async def model(self, request: Request) -> Response:
        """Return a run's data for the page: whether a crank has its pins, or the linear model of its cuts."""
        return await self._own(request.path_params["run"], MODEL)

    async def ticks(self, request: Request) -> Response:
        """Return the cuts of a result that are done, with their times, and the latest result of its crank."""
        run = request.path_params["run"]
        told = self._runs.state_of(run)
        if told is None:
            return refused("there is no such run", 404)
        return JSONResponse(self._ticks(told))

    async def tick(self, request: Request) -> Response:
        """Keep that a cut of a result is done, now, or is not."""
        run, values = request.path_params["run"], await body_of(request)
        told, report = self._runs.state_of(run), self._project.result(run, REPORT)
        if told is None or report is None:
            return refused("there is no such run", 404)
        made = json.loads(report.read_text(encoding="utf-8")).get("corrections", [])
        number, is_done = (
            values.get(key) if isinstance(values, dict) else None for key in ("number", "done")
        )
        known = type(number) is int and number in [each["number"] for each in made]
        if not known or not isinstance(is_done, bool):
            return refused('the body must be {"number": of a cut of the result, "done": true or false}', 400)
        path = self._project.result(run, DONE)
        kept = {} if path is None else json.loads(path.read_text(encoding="utf-8"))
        kept.pop(str(number), None)
        if is_done:
            kept[str(number)] = datetime.now(UTC).isoformat(timespec="seconds")
        done = self._project.run_folder(run) / DONE  # beside the report, for the sheet
        self._project.write_text(str(done.relative_to(self._project.folder)), json.dumps(kept))
        return JSONResponse(self._ticks(told))

    def _ticks(self, told: dict[str, Any]) -> dict[str, Any]:
        path = self._project.result(told["id"], DONE)
        made = [
            each["id"]
            for each in self._runs.all()
            if (each["state"], each["crank"]) == ("done", told["crank"]) and each["verb"] in CUTTERS
        ]
        kept = {} if path is None else json.loads(path.read_text(encoding="utf-8"))
        return {"ticks": kept, "latest": made[-1] if made else told["id"]}

    async def paper(self, request: Request) -> Response:
        """Give a certificate, a card, a list or a drawing of a result."""
        run, name = request.path_params["run"], request.path_params["name"]
        papers = (self._json(request, MODEL) or {}).get("papers", [])
        path, told = self._project.own(run, name) if name in papers else None, self._runs.state_of(run)
        saved_as = name if told is None else saved_name(self._project, told, name)
        return file_of(path, saved_as, "show" in request.query_params)

    async def cards(self, request: Request) -> Response:
        """Return the kinds compared so far: rows as in the report, and the names of those with a picture."""
        return JSONResponse(self._json(request, CARDS) or {"rows": [], "pictures": []})

    async def card(self, request: Request) -> Response:
        """Give the picture of a card."""
        name = request.path_params["name"]
        return file_of(self._project.own(request.path_params["run"], name) if name.endswith(".png") else None)

    async def predict(self, request: Request) -> Response:
        """Predict the residual of other depths and turns of a result's cuts."""
        model, values = self._json(request, MODEL), await body_of(request)
        if model is None or "cuts" not in model:
            return file_of(None)
        if not isinstance(values, dict) or set(values) - set(DRAGGED_KEYS):
            body = ", ".join(f'"{name}": [...]' for name in DRAGGED_KEYS)
            return refused(f"the body must be {{{body}}}", 400)
        try:
            given = (values.get(name, []) for name in DRAGGED_KEYS)
            return JSONResponse(encoded(predicted(decoded(PredictionModel, model), *given)))
        except AutobalanceError as error:
            return refused(str(error), 400)

    async def preview(self, request: Request) -> Response:
        """Return the effect of a job's weights on an inspected crank, or the reason why it is not known."""
        path, values = self._project.result(request.path_params["run"], REPORT), await body_of(request)
        if path is None:
            return file_of(None)
        if not isinstance(values, dict):
            return refused("the body is not a JSON object", 400)
        if any(where != "crankshaft.file" for where, _ in named_files(values)):
            return JSONResponse({"why": "weights of solids are known once the crank is balanced"})
        report = json.loads(path.read_text(encoding="utf-8"))
        try:
            return JSONResponse(await run_in_threadpool(preview, report, values, self._project.folder))
        except AutobalanceError as error:
            return JSONResponse({"why": self._project.as_named(str(error))})

    async def _own(self, run: str, name: str) -> Response:
        """Give one of the page's own files; nothing where a result came from elsewhere without it.

        It is read before anything is sent: a run may put a better mesh in its place meanwhile, and the length
        that was announced would be that of another file.
        """
        if self._runs.state_of(run) is None:
            return refused("there is no such run", 404)
        path = self._project.own(run, name)
        if path is None:
            return Response(status_code=204)
        return Response(await run_in_threadpool(path.read_bytes), media_type=BINARY)

    def _json(self, request: Request, name: str) -> Any:
        path = self._project.own(request.path_params["run"], name)
        return None if path is None else json.loads(path.read_text(encoding="utf-8"))


def _forms() -> dict[str, Any]:
    from autobalance.drawn_cranks.design import PRESETS
    from autobalance.job.balance import LISTED_CUTS
    from autobalance.job.template import USUAL_PARTS
    from autobalance.rigid_rotor.tolerance import GRADES

    return {
        "kinds": kinds(),
        "tables": tables(),
        "parts": USUAL_PARTS,
        "grades": [{"grade": each.grade_mm_s, "machinery": each.what} for each in GRADES],
        "listed": [key.name for key in LISTED_CUTS.keys],
        "presets": list(PRESETS),
        "analyses": analyses(),
    }


def _polar(values: Any) -> str:
    """Return the drawing of one polar that the page asks for."""
    from autobalance.report.pictures.polar import Vector, drawn

    def vector(given: Any) -> tuple[float, float]:
        x, y = given
        if not _numbers([x, y]):
            raise ValueError
        return float(x), float(y)

    vectors = [
        Vector(
            vector(each["unbalance_g_mm"]),
            str(each["name"]),
            None if each["uncertainty_g_mm"] is None else float(each["uncertainty_g_mm"]),
        )
        for each in values["vectors"]
    ]
    expected = None if values["expected_g_mm"] is None else vector(values["expected_g_mm"])
    permitted, zero_deg = vector((values["permitted_g_mm"], values["zero_deg"]))
    return drawn(permitted, vectors, zero_deg, str(values["sign"])[:MOST_SIGN], expected)


def _numbers(values: Any) -> bool:
    finite = (isinstance(each, int | float) and abs(each) < float("inf") for each in values)
    return isinstance(values, list) and all(finite)


def kinds() -> list[dict[str, Any]]:
    """Return every kind of correction, as a form needs it: its keys with their defaults."""
    from autobalance.correction import KINDS

    return [
        {
            "name": name,
            "verb": kind.verb,
            "noun": kind.noun,
            "datum": kind.datum,
            "adds": kind.adds_metal,
            "keys": limits(name),
        }
        for name, kind in KINDS.items()
    ]
