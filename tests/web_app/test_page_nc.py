"""NC programs from the page: the machine's file is pasted, the set-ups and what they leave are shown."""

from __future__ import annotations

import pytest

from autobalance.toml_files.document import toml_text
from tests import nc_jobs
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import at, load, nothing_wrong, text_of, until
from tests.web_app.serving import Served

pytestmark = pytest.mark.slow


def programs(page: Browser, machine: str) -> None:
    page.run(
        "const box = document.getElementById('machine-toml'); box.value = arguments[0];"
        "box.dispatchEvent(new Event('input', { bubbles: true }));"
        "document.getElementById('nc-box').open = true",
        machine,
    )
    page.click_on(at("nc"))


def test_the_page_writes_nc_programs(app: Served, window: Browser) -> None:
    data = small.crank(app.project.parent).read_bytes()
    assert app.ask(f"/api/files?name={small.NAME}", data).status == 201
    for verb in ("inspect", "balance"):
        small.ran(app, verb, small.DRILLED)
    app.ask("/api/job", small.DRILLED, "PUT")
    drill = nc_jobs.tool(7, "drill", diameter_mm=12.0, stick_out_mm=95.0)
    load(window, app)
    with nothing_wrong(window, app):
        window.click_on(at("tab-machine"))
        programs(window, toml_text(nc_jobs.machine(tool=[{**drill, "diameter_mm": 11.0}])))
        until(window, "return document.getElementById('error').textContent.includes('no tool fits')")
        programs(window, toml_text(nc_jobs.machine(tool=[drill])))
        until(window, "return !document.getElementById('setups').hidden")
        cells = window.run(
            "return [...document.getElementById('setups').tBodies[0].rows[0].cells].map(c => c.textContent)"
        )
        told = app.ask("/api/runs").json["runs"][-1]
        report = app.ask(f"/api/runs/{told['id']}/report").json
        assert (told["verb"], told["state"]) == ("nc", "done")
        assert cells[:3] == ["R", "setup-R.ngc", "T7"]
        assert cells[3] == ", ".join(str(number) for number in report["setups"][0]["cuts"])
        residual = report["simulated"]["residual"]["magnitude_g_mm"]
        assert f"Simulated residual {residual:.2f} g·mm" in text_of(window, "nc-says")
        text = app.ask(f"/api/runs/{told['id']}/files/setup-R.ngc").body.decode()
        assert text.rstrip().endswith("M30")
        window.resize(1400, 1400)
        (app.project.parent / "page.png").write_bytes(window.screenshot())
        window.resize(1400, 900)


def test_what_is_no_machine_file_is_refused(app: Served) -> None:
    run = next(
        (each["id"] for each in app.ask("/api/runs").json["runs"] if each["verb"] == "balance"), "none"
    )
    for body, why in (
        ({"run": run}, "text of a machine file"),
        ({"run": run, "machine": 3}, "text of a machine file"),
        ({"run": "000000000000", "machine": ""}, "a run of balance or recut"),
    ):
        answer = app.ask("/api/runs", {"verb": "nc", **body})
        assert answer.status == 400
        assert why in answer.json["error"]
