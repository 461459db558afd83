"""Cranks to begin with: the bundled one, and presets drawn with the dimensions that a user types."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from autobalance.browser.cranks import DrawnFrom, KnownCrank, keep_crank, known_cranks
from autobalance.browser.guard import body_of, refused
from autobalance.browser.opening import for_another, job_of, job_told, open_job
from autobalance.browser.project import JOB
from autobalance.bundled import bundled_folder
from autobalance.errors import AutobalanceError, FileError, FormatError
from autobalance.toml_files.document import toml_of, toml_text

if TYPE_CHECKING:
    from autobalance.browser.cranks import CrankNames
    from autobalance.browser.project import Project
    from autobalance.drawn_cranks.design import Design

RADIUS = "counterweight.radius_mm"
DIMENSIONS = (
    "stroke_mm",
    RADIUS,
    "counterweight.fan_angle_deg",
    "main_journal.diameter_mm",
    "crankpin.diameter_mm",
    "web.thickness_mm",
    "oil_hole_mm",
)
"""Dimensions of a design that the page has fields for, by their dotted keys."""
LARGEST_BOB_WEIGHTS_G: Mapping[str, float] = {
    "parallel-twin-360": 800.0,
    "inline-3": 800.0,
    "v6-60": 800.0,
    "v8-crossplane": 2100.0,
}
"""Bob-weights of usual engines, with a fifth to drill off, of presets whose own counterweights suit none.

The app draws the counterweights for them. The other presets suit usual engines as they are."""
ENGINES: Mapping[str, Mapping[str, Any]] = {
    "v-twin-45": {"rods_per_throw": 2, "layout": {"bank_deg": [-22.5, 22.5]}},
    "v8-crossplane": {"rods_per_throw": 2, "layout": {"bank_deg": [-45.0, 45.0]}},
    "v8-flatplane": {"rods_per_throw": 2, "layout": {"bank_deg": [-45.0, 45.0]}},
    "v12-60": {"rods_per_throw": 2, "layout": {"bank_deg": [-30.0, 30.0]}},
}
"""Engines of the presets that are drawn, where they are not one rod a throw in line."""
EXAMPLES: Mapping[str, Mapping[str, Any]] = {
    "v8-crossplane": {
        "engine": {
            "rotating_g": {"connecting_rod_big_end": 450.0, "big_end_bearing": 45.0},
            "reciprocating_g": {
                "connecting_rod_small_end": 170.0,
                "piston": 430.0,
                "wrist_pin": 120.0,
                "rings_clips_oil": 40.0,
            },
        },
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6500.0},
        "correction": {"method": "drill"},
    }
}
"""Weights and targets of the presets that are examples too."""


def open_example(name: str | None, project: Project, is_weighed: bool = False) -> None:
    """Make the bundled crank with its job the project's, or a crank drawn from a preset's dimensions.

    ``is_weighed``: with the weights of an example, `EXAMPLES`.

    Raises
    ------
    AutobalanceError
        If there is no such preset, or no weights of it.
    """
    if is_weighed and name not in EXAMPLES:
        raise FormatError(f"{name} has no weights; expected one of {', '.join(EXAMPLES)}")
    if name is None:
        bundled = bundled_folder() / "crf250r" / "drafted"
        open_job(bundled / "factor-0.28.toml", project)
        before = toml_of((bundled / "factor-original.toml").read_text(encoding="utf-8"), JOB)["original"]
        project.write_job(toml_text({**job_of(project), "original": before}))
        return
    kept, density = drawn_crank(project, name, {})
    table = {"file": kept, "unit": "mm", "density_kg_m3": density}
    tables = dict(EXAMPLES[name]) if is_weighed else {}
    engine = {**ENGINES.get(name, {}), **tables.pop("engine", {})}
    own = {"crankshaft": table, **({"engine": engine} if engine else {}), **tables}
    project.write_job(toml_text({**for_another(project), **own}))


def drawn_crank(
    project: Project, preset_name: str, typed: Mapping[str, float], most_g: float | None = None
) -> tuple[str, float]:
    """Draw a preset with the dimensions that were typed; return its file in the project, and its density.

    Without a radius among ``typed`` the counterweights are drawn for bob-weights up to ``most_g`` [g], None:
    those of the preset.

    Raises
    ------
    AutobalanceError
        If there is no such preset, or a dimension is impossible with the others.
    """
    from autobalance.drawn_cranks.design import preset
    from autobalance.drawn_cranks.input import with_settings
    from autobalance.drawn_cranks.suggested_sizes import size_of
    from autobalance.drawn_cranks.verb import generate

    design = with_settings(preset(preset_name), typed)
    radius, suits = _counterweights(preset_name, design, RADIUS in typed, most_g)
    drawn = generate(preset_name, file=f"{preset_name}.stl", settings={**typed, RADIUS: radius})
    with TemporaryDirectory() as folder:
        (path,) = (each for each in drawn.write(folder) if each.suffix == ".stl")
        file = project.copied(path)
    sizes = {key: size_of(drawn.design, key) for key in DIMENSIONS}
    own = DrawnFrom(preset_name, sizes, tuple(typed), suits, most_g is not None)
    keep_crank(project, file, replace(known_cranks(project).get(file, KnownCrank()), drawn=own))
    return file, drawn.design.density_kg_m3


def _counterweights(
    name: str, design: Design, is_typed: bool, most_g: float | None
) -> tuple[float, float | None]:
    """Return the radius of the counterweights [mm], and the bob-weights [g] up to which they suffice."""
    from autobalance.drawn_cranks.design import preset
    from autobalance.drawn_cranks.suggested_sizes import (
        largest_bob_weight_g,
        radius_for_bob_weights_mm,
        size_of,
    )

    radius, own = size_of(design, RADIUS), largest_bob_weight_g(design)
    if own is None and most_g is not None:
        raise FormatError("the throws cancel each other out: bob-weights do not count; leave them empty")
    if own is None or is_typed:
        return radius, own
    usual = LARGEST_BOB_WEIGHTS_G.get(name) or largest_bob_weight_g(preset(name))
    wanted = most_g or usual
    if wanted is None or wanted == own:
        return radius, own
    return radius_for_bob_weights_mm(design, wanted), wanted


def drawn_again(project: Project, file: str, typed: Mapping[str, float], most_g: float | None) -> str:
    """Draw a crank of the project with other dimensions; return the new file. It keeps the crank's name.

    Raises
    ------
    AutobalanceError
        As `drawn_crank`; `FileError` if the file was not drawn here.
    """
    known = known_cranks(project).get(file)
    if known is None or known.drawn is None:
        raise FileError(f"{file} was not drawn here; only drawn cranks have dimensions to change")
    name, _ = drawn_crank(project, known.drawn.preset, typed, most_g)
    keep_crank(project, name, replace(known_cranks(project)[name], name=known.name))
    return name


class DrawingEndpoints:
    """The endpoints."""

    def __init__(self, project: Project, names: CrankNames) -> None:
        self._project, self._names = project, names

    def routes(self) -> list[Route]:
        return [
            Route("/api/example", self.example, methods=["POST"]),
            Route("/api/cranks/draw", self.draw, methods=["POST"]),
        ]

    async def example(self, request: Request) -> Response:
        """Make the bundled crank the project's, or one drawn from a preset."""
        values = await body_of(request)
        name = values.get("preset") if isinstance(values, dict) else False
        if not (name is None or isinstance(name, str)):
            return refused('the body must be {"preset": NAME or null}', 400)
        is_weighed = bool(values.get("weighed"))

        def opened() -> dict[str, Any]:
            open_example(name, self._project, is_weighed)
            return {**job_told(self._project), "cranks": self._names.told()}

        return await _answered(opened)

    async def draw(self, request: Request) -> Response:
        """Draw the crank of a file with other dimensions, as another file."""
        values = await body_of(request)
        if not isinstance(values, dict) or not isinstance(values.get("dimensions"), dict):
            return refused('the body must be {"file": ..., "dimensions": {KEY: NUMBER}}', 400)
        file, typed, most_g = str(values.get("file")), values["dimensions"], values.get("most_bob_weight_g")
        if unknown := sorted(set(typed) - set(DIMENSIONS)):
            return refused(f"{unknown[0]} is not a dimension; expected {', '.join(DIMENSIONS)}", 400)
        if wrong := [key for key, each in typed.items() if not _is_size(each)]:
            return refused(f"{wrong[0]} must be a number of 0 or more", 400)
        if most_g is not None and not (_is_size(most_g) and most_g > 0.0):
            return refused("most_bob_weight_g must be a number above 0", 400)
        if RADIUS in typed and most_g is not None:
            return refused("enter the counterweight radius or the largest bob-weight, not both", 400)

        def drawn() -> dict[str, Any]:
            name = drawn_again(self._project, file, typed, most_g)
            return {"file": name, "cranks": self._names.told()}

        return await _answered(drawn)


def _is_size(value: Any) -> bool:
    return (
        isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and value >= 0
    )


async def _answered(work: Callable[[], dict[str, Any]]) -> Response:
    try:
        return JSONResponse(await run_in_threadpool(work))
    except AutobalanceError as error:
        return refused(str(error), 400)
