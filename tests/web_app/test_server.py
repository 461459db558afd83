"""The app's endpoints, and what they refuse: other hosts, other pages, other folders."""

import gzip
import hashlib
import http.client
import json
import os
import re
import signal
import socket
import sys
import tempfile
import threading
import time
import tomllib
import urllib.error
from collections.abc import Iterator
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.browser.work import MESH
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.toml_files.document import toml_text
from tests import jobs
from tests.generated import differences
from tests.web_app import small
from tests.web_app.serving import Served, served

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX")


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("app") / "project", "--max-upload-mb", "2") as running:
        assert running.ask("/api/files?name=crank.stl", crank_bytes()).status == 201
        yield running


def job(**changes: Any) -> dict[str, Any]:
    return {**small.DRILLED, "crankshaft": {**small.DRILLED["crankshaft"], "file": "crank.stl"}, **changes}


@cache
def written() -> Path:
    """Write the small crank and its job; return the job's path."""
    folder = Path(tempfile.mkdtemp())
    small.crank(folder).rename(folder / "crank.stl")
    (folder / "job.toml").write_text(toml_text(job()), encoding="utf-8")
    return folder / "job.toml"


def crank_bytes() -> bytes:
    return (written().parent / "crank.stl").read_bytes()


# --- safe ---------------------------------------------------------------------------------------------------


def test_every_answer_says_what_may_be_done_with_it(app: Served) -> None:
    for path, token in (
        ("/api/health", False),
        ("/", True),
        ("/api/nothing", True),
        ("/static/page.js", False),
    ):
        headers = app.ask(path, token=token).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert not any(word in policy for word in ("unsafe", "*", "http"))
        assert not any(name.startswith("access-control") for name in headers)


def test_other_hosts_and_origins_are_refused_before_all_else(app: Served) -> None:
    port = app.base.rpartition(":")[2]
    assert app.ask("/api/health", token=False, Host=f"localhost:{port}").status == 200
    others: tuple[dict[str, Any], ...] = (
        {"Host": "evil.example"},
        {"Host": "127.0.0.1:1"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": f"http://localhost:{port}"},
        {"Origin": f"http://127.0.0.1:{int(port) - 1}"},
    )
    for headers in others:
        assert app.ask("/api/health", token=False, **headers).status == 403
        assert app.ask("/api/runs", **headers).status == 403


def test_the_token_opens_and_the_cookie_only_reads(app: Served) -> None:
    assert app.ask("/", token=False).status == 401
    assert app.ask("/?token=wrong", token=False).status == 401
    first = app.ask(f"/?token={app.token}", token=False)
    assert (first.status, first.headers["location"]) == (303, "/")
    set_cookie = first.headers["set-cookie"]
    assert "HttpOnly" in set_cookie
    assert "samesite=strict" in set_cookie.lower()
    assert app.token not in set_cookie
    cookie = set_cookie.partition(";")[0]
    page = app.ask("/", token=False, Cookie=cookie)
    assert page.status == 200
    assert app.token.encode() in page.body
    again = app.ask("/", token=False, Cookie=cookie)  # reloaded: other servers are sent the cookie too
    assert again.status == 200
    assert app.token.encode() not in again.body
    name, _, value = cookie.partition("=")
    assert name.startswith("autobalance-")
    assert app.ask("/", token=False, Cookie=f"autobalance={value}").status == 401
    assert app.ask("/api/runs", token=False, Cookie=cookie).status == 200
    assert app.ask("/api/runs", token=False, Cookie=cookie, method="HEAD").status == 401
    body = {"verb": "inspect", "job": job()}
    assert app.ask("/api/runs", body, token=False, Cookie=cookie).status == 401
    assert app.ask("/api/runs", token=False).status == 401
    assert app.ask("/api/runs", token=False, X_Autobalance_Token="é").status == 401


@pytest.mark.parametrize(
    "name", ["../x.stl", "a/b.stl", ".hidden", "", "a%00b", "%2e%2e%2fx", "..", "a\\b.stl", "runs"]
)
def test_only_plain_names_are_kept(app: Served, name: str) -> None:
    before = sorted(app.project.rglob("*"))
    answer = app.ask(f"/api/files?name={name if '%' in name else name.replace(chr(92), '%5C')}", b"x")
    assert answer.status == 400
    assert list(answer.json) == ["error"]
    assert sorted(app.project.rglob("*")) == before


def test_nothing_outside_the_project_is_read(app: Served, tmp_path: Path) -> None:
    secret = tmp_path / "secret.stl"
    secret.write_bytes(crank_bytes())
    (app.project / "link.stl").symlink_to(secret)
    try:
        for file in (str(secret), "../secret.stl", "link.stl", "runs", "no.stl", 7):
            values = job(crankshaft={"file": file, "unit": "mm", "density_kg_m3": 7850.0})
            assert app.ask("/api/runs", {"verb": "inspect", "job": values}).status == 400
        engine = {"rotating_g": {"a": {"file": str(secret), "unit": "mm", "density_kg_m3": 7850.0}}}
        assert app.ask("/api/runs", {"verb": "balance", "job": job(engine=engine)}).status == 400
        answer = app.ask("/api/runs", {"verb": "balance", "job": job(shop={"logo": str(secret)})})
        assert "shop.logo" in answer.json["error"]
    finally:
        (app.project / "link.stl").unlink()
    for path in (
        "/api/runs/..%2f..%2fetc/files/passwd",
        "/api/runs/x/files/..%2fcrank.stl",
        "/static/..%2fserver.py",
    ):
        assert app.ask(path).status in (400, 404)


def test_a_file_that_is_too_large_leaves_nothing(app: Served) -> None:
    before = sorted(app.project.rglob("*"))
    with suppress(urllib.error.URLError):  # the server may close the connection while the rest still comes
        assert app.ask("/api/files?name=big.stl", bytes(3 << 20)).status == 413
    host, port = app.base.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=30) as raw:  # answered before it comes
        head = f"POST /api/files?name=big.stl HTTP/1.1\r\nHost: {host}:{port}\r\n"
        head += f"X-Autobalance-Token: {app.token}\r\nContent-Length: 1000000000000\r\n\r\n"
        raw.sendall(head.encode())
        assert b" 413 " in raw.recv(200)
    with socket.create_connection((host, int(port)), timeout=30) as raw:  # without saying how long it is
        head = f"POST /api/files?name=big.stl HTTP/1.1\r\nHost: {host}:{port}\r\n"
        head += f"X-Autobalance-Token: {app.token}\r\n"
        raw.sendall(head.encode() + b"Transfer-Encoding: chunked\r\n\r\n")
        with suppress(BrokenPipeError, ConnectionResetError):
            for _ in range(3):
                raw.sendall(b"100000\r\n" + bytes(1 << 20) + b"\r\n")
            raw.sendall(b"0\r\n\r\n")
            assert b" 413 " in raw.recv(200)
    assert sorted(app.project.rglob("*")) == before


# --- right --------------------------------------------------------------------------------------------------


def test_a_taken_name_gets_a_number(app: Served) -> None:
    kept = [app.ask("/api/files?name=part.obj", b"v 0 0 0").json["file"] for _ in range(2)]
    assert kept == ["part.obj", "part-2.obj"]


@pytest.mark.skipif("AUTOBALANCE_SHAKEN" in os.environ, reason="holds two processes to the last digit")
def test_a_balance_is_that_of_the_function(app: Served, tmp_path: Path) -> None:
    run = app.ask("/api/runs", {"verb": "balance", "job": job()})
    assert run.status == 202
    told = app.ended(run.json["id"])
    assert (told["state"], told["share"], told["exit_code"], told["error"]) == ("done", 1.0, 0, None)
    assert {"report.json", "balanced.stl", "report.html", "sheet.pdf"} <= set(told["files"])
    report = app.ask(f"/api/runs/{told['id']}/report").json
    own = ab.balance(ab.read_job(written())).report
    for key in ("residual", "corrections", "tolerance", "balance_factor"):
        assert report[key] == own[key]
    solid = app.ask(f"/api/runs/{told['id']}/files/balanced.stl").body
    assert len(solid) == 84 + 50 * report["outputs"]["solid"]["triangles"]
    folder = app.project / "runs" / told["id"]
    assert ab.verify(folder / "report.json").holds
    by_command = ab.balance(ab.read_job(written())).write(tmp_path, date="2026-01-01")
    assert (
        {path.name for path in folder.iterdir()} == {path.name for path in by_command} == set(told["files"])
    )
    assert told["id"] in [each["id"] for each in app.ask("/api/runs").json["runs"]]


def test_a_bad_job_fails_with_its_line(app: Served) -> None:
    values = job(balance={"factor": 0.28, "grade": 6.3, "speed_rpm": -1})
    told = app.ended(app.ask("/api/runs", {"verb": "balance", "job": values}).json["id"])
    assert (told["state"], told["exit_code"], told["files"]) == ("failed", 3, [])
    assert "balance.speed_rpm is -1; must be > 0" in told["error"]
    bodies: tuple[Any, ...] = ({"verb": "demo", "job": job()}, {"job": job()}, {"verb": "inspect"}, [], "x")
    for body in bodies:
        assert app.ask("/api/runs", body).status == 400
    assert app.ask("/api/runs/0123456789ab").status == 404
    assert app.ask("/api/runs/0123456789ab/cancel", {}).status == 404
    assert app.ask("/api/runs/0123456789ab/report").status == 404


def test_a_cancelled_run_leaves_no_file(app: Served) -> None:
    run = app.ask("/api/runs", {"verb": "balance", "job": job()}).json["id"]
    answer = app.ask(f"/api/runs/{run}/cancel", {})
    assert answer.status == 202
    assert app.ended(run, 3.0)["state"] == "cancelled"
    assert not (app.project / "runs" / run).exists()


def test_an_uploaded_job_is_kept_as_it_is_and_opened_with_files_of_the_project(app: Served) -> None:
    text = written().read_bytes().replace(b'"crank.stl"', b'"../elsewhere/crank.stl"')
    kept = app.ask("/api/files?name=mine.toml", text).json
    assert (app.project / "mine.toml").read_bytes() == text
    assert kept["sha256"] == hashlib.sha256(text).hexdigest()
    opened = app.ask("/api/open", {"file": "mine.toml"}).json["job"]
    assert opened["crankshaft"]["file"] == "crank.stl"
    assert app.ask("/api/open", {"file": "crank.stl"}).json["job"] == opened
    app.ask("/api/files?name=broken.toml", b"= 3")
    wrong: tuple[Any, ...] = ({"file": "broken.toml"}, {"file": "no.toml"}, {"file": "../x"}, {"file": 7}, [])
    for body in wrong:
        answer = app.ask("/api/open", body)
        assert (answer.status, list(answer.json)) == (400, ["error"])


def test_a_crank_to_begin_with_is_bundled_or_drawn(tmp_path: Path) -> None:
    with served(tmp_path / "project") as app:
        bundled = app.ask("/api/example", {"preset": None}).json["job"]
        assert bundled["engine"]["rotating_g"]["big_end_bearing"] == 39.0
        assert (app.project / bundled["crankshaft"]["file"]).is_file()
        assert "inline-4" in app.ask("/api/kinds").json["presets"]
        drawn = app.ask("/api/example", {"preset": "inline-4"}).json["job"]["crankshaft"]
        crank = ab.read_crank(app.project / drawn["file"], unit=drawn["unit"])
        assert differences(crank.measured.anatomy, crank_anatomy(PRESETS["inline-4"])) == []
        refused = app.ask("/api/example", {"preset": "inline-44"})
        assert (refused.status, refused.json["error"][:33]) == (400, "no preset is called 'inline-44'; ")
        assert app.ask("/api/example", {"preset": 4}).status == 400


def test_a_drawn_crank_is_drawn_again_with_its_dimensions(tmp_path: Path) -> None:
    with served(tmp_path / "project") as app:
        drawn = app.ask("/api/example", {"preset": "single"}).json
        file = drawn["job"]["crankshaft"]["file"]
        known = drawn["cranks"][file]["drawn"]
        assert (known["preset"], known["typed"]) == ("single", [])
        assert known["dimensions"]["counterweight.radius_mm"] == 52.0  # the preset's own
        asked = {"file": file, "dimensions": {"stroke_mm": 64.0}}
        answer = app.ask("/api/cranks/draw", asked).json
        again = answer["cranks"][answer["file"]]["drawn"]
        assert again["dimensions"]["stroke_mm"] == 64.0
        assert again["dimensions"]["counterweight.radius_mm"] > 52.0  # balances the same bob-weight
        assert again["most_bob_weight_g"] == pytest.approx(known["most_bob_weight_g"])
        for wrong, says in (
            ({"dimensions": {"stroke_mm": "64"}}, "stroke_mm must be a number"),
            ({"dimensions": {"name": 3.0}}, "name is not a dimension"),
            ({"dimensions": {"counterweight.radius_mm": 10.0}}, "the web there has 22"),
            ({"dimensions": {"counterweight.radius_mm": 55.0}, "most_bob_weight_g": 400.0}, "not both"),
            ({"most_bob_weight_g": 0.0}, "most_bob_weight_g must be a number above 0"),
            ({"file": "mine.stl"}, "mine.stl was not drawn here"),
        ):
            refused = app.ask("/api/cranks/draw", {**asked, **wrong})
            assert refused.status == 400
            assert says in refused.json["error"]


def test_another_crank_does_not_get_the_weights_and_limits_of_the_one_before(app: Served) -> None:
    """Unit, weights, the original's parts and limits go with their crank; its job is kept as a file."""
    former = job(
        shop={"name": "Turner"},
        original={"rotating_g": {"a": 95.0}, "reciprocating_g": {"b": 300.0}},
        correction={"method": "drill", "drill": {"max_depth_mm": 7.3}},
    )
    former["crankshaft"]["unit"] = "cm"
    assert app.ask("/api/job", json.dumps(former).encode(), method="PUT").status == 200
    file = former["crankshaft"]["file"]
    same = app.ask("/api/open", {"file": file}).json["job"]
    assert same["crankshaft"]["unit"] == "cm"
    assert same["engine"]
    other = app.ask("/api/files?name=other.stl", (app.project / file).read_bytes()).json["file"]
    opened = app.ask("/api/open", {"file": other}).json["job"]
    assert opened == {"shop": {"name": "Turner"}, "crankshaft": {"file": other}}
    before = app.ask("/api/open", {"file": "job-before.toml"}).json["job"]
    assert before["correction"]["drill"]["max_depth_mm"] == 7.3
    assert before["original"] == former["original"]
    drawn = app.ask("/api/example", {"preset": "single"}).json["job"]
    assert set(drawn) == {"shop", "crankshaft"}
    assert drawn["crankshaft"]["unit"] == "mm"


def test_a_job_may_be_a_workbook(app: Served, tmp_path: Path) -> None:
    assert jobs.run("init", written(), "-o", tmp_path / "job.xlsx") == 0
    assert app.ask("/api/files?name=mine.xlsx", (tmp_path / "job.xlsx").read_bytes()).status == 201
    found = app.ask("/api/open", {"file": "mine.xlsx"}).json["job"]
    for table in ("crankshaft", "engine", "balance", "correction"):
        assert found[table] == job()[table]


@pytest.mark.parametrize(
    "job", [b'{"crankshaft": {"file": "\\ud800.stl"}}', b'{"crankshaft": null}', b'{"a": [{"b": null}]}']
)
def test_a_job_that_toml_cannot_hold_is_refused_and_leaves_nothing(app: Served, job: bytes) -> None:
    before = sorted(path.name for path in app.project.iterdir())
    kept = app.ask("/api/job", job, method="PUT")
    assert kept.status == 400, kept.body
    assert sorted(path.name for path in app.project.iterdir()) == before


@pytest.mark.parametrize("verb", [["balance"], {"a": 1}, None, 3])
def test_a_verb_that_is_no_text_is_refused(app: Served, verb: Any) -> None:
    told = app.ask("/api/runs", {"verb": verb, "job": job()})
    assert (told.status, told.json["error"][:20]) == (400, "verb must be one of ")


def test_a_workbook_without_end_does_not_reach_the_server(app: Served, tmp_path: Path) -> None:
    import zipfile

    with zipfile.ZipFile(tmp_path / "bomb.xlsx", "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("[Content_Types].xml", "xl/workbook.xml", "xl/worksheets/sheet1.xml"):
            archive.writestr(name, " " * (30 << 20))
    assert app.ask("/api/files?name=bomb.xlsx", (tmp_path / "bomb.xlsx").read_bytes()).status == 201
    opened = app.ask("/api/open", {"file": "bomb.xlsx"})
    assert (opened.status, "90 MB unpacked; expected at most 64 MB" in opened.json["error"]) == (400, True)


def test_the_job_is_kept_as_the_command_line_takes_it(app: Served) -> None:
    text = app.ask("/api/job", job(), "PUT").json["job_text"]
    assert tomllib.loads(text) == job()
    assert (app.project / "job.toml").read_text("utf-8") == text
    assert app.ask("/api/project").json["job"] == job()


def test_it_ends_with_nothing_left_and_goes_on_where_it_was(tmp_path: Path) -> None:
    with served(tmp_path / "project", str(written())) as first:
        assert json.loads(first.ask("/api/project").body)["files"] == ["crank.stl", "job.toml"]
        run = first.ask("/api/runs", {"verb": "inspect", "job": job()}).json["id"]
        first.ended(run)
        busy = first.ask("/api/runs", {"verb": "balance", "job": job()}).json["id"]
        first.process.send_signal(signal.SIGTERM)
        assert first.process.wait(timeout=20) == 0
    assert not (tmp_path / "project" / "runs" / busy).exists()
    with served(tmp_path / "project") as again:
        assert [each["id"] for each in again.ask("/api/runs").json["runs"]] == [run]
        again.process.send_signal(signal.SIGINT)
        assert again.process.wait(timeout=20) == 0
    assert not os.path.exists("autobalance-project")


def test_runs_go_where_the_folder_for_what_is_passing_has_a_long_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No socket can be made in it."""
    long = tmp_path / ("long" * 30)
    long.mkdir()
    with monkeypatch.context() as there:
        there.setenv("TMPDIR", str(long))
        with served(tmp_path / "project", str(written())) as app:
            run = app.ask("/api/runs", {"verb": "inspect", "job": job()}).json["id"]
            assert app.ended(run)["state"] == "done"


def test_it_may_be_ended_as_soon_as_its_address_is_known(tmp_path: Path) -> None:
    with served(tmp_path / "project") as app:
        app.process.send_signal(signal.SIGTERM)
        assert app.process.wait(timeout=20) == 0


def test_a_report_and_its_folder_are_taken_in_as_a_run(tmp_path: Path) -> None:
    jobs.computed(written(), tmp_path / "out")
    data = (tmp_path / "out" / "report.json").read_bytes()
    (tmp_path / "project").mkdir()
    (tmp_path / "project" / ".upload-0.part").write_bytes(b"cut off")
    for source in ("out/report.json", "out"):
        with served(tmp_path / "project", str(tmp_path / source)) as app:
            runs = app.ask("/api/runs").json["runs"]
            assert [(each["verb"], each["state"], each["exit_code"]) for each in runs] == [
                ("balance", "done", 0)
            ]
            assert app.ask(f"/api/runs/{runs[0]['id']}/report").body == data
            assert app.ask("/api/project").json["files"] == ["crank.stl", "job.toml"]
            assert app.ask("/api/project").json["job"]["engine"]["rod_length_mm"] == 110.0
            reading = {"urr_percent": 95.0, "umar_g_mm": 0.5, "plane": _planes(app, runs[0]["id"])}
            body = {"verb": "recut", "run": runs[0]["id"], "reading": reading}
            if source == "out":
                told = app.ended(app.ask("/api/runs", body).json["id"])
                assert told["state"] == "done", told
                report = app.ask(f"/api/runs/{told['id']}/report").json
                assert [each["stage"] for each in report["stages"]] == [1, 2]
                assert "history.html" in told["files"]
                assert ab.verify(app.project / "runs" / told["id"] / "report.json").holds
    (tmp_path / "out" / "balanced.stl").unlink()
    assert jobs.run("app", tmp_path / "out", "--no-browser", "--project", tmp_path / "other") == 3


def _planes(app: Served, run: str) -> list[dict[str, Any]]:
    """Return a reading that the solid's own residual explains, with 20 g·mm more in plane A."""
    planes = app.ask(f"/api/runs/{run}/report").json["tolerance"]["planes"]
    return [
        {"at": plane["name"], "g_mm": 20.0 if plane["name"] == "A" else 0.0, "angle_deg": 200.0}
        for plane in planes
    ]


def test_a_result_is_taken_in_from_the_page(app: Served, tmp_path: Path) -> None:
    jobs.balanced(written(), tmp_path / "out", 0, "--only", "json")
    for name in ("report.json", "balanced.stl"):
        body = (tmp_path / "out" / name).read_bytes()
        assert app.ask(f"/api/files?name={name}&apart=0123456789ab", body).status == 201
    opened = app.ask("/api/open", {"file": "report.json", "apart": "0123456789ab"})
    assert opened.status == 200
    told = app.ask(f"/api/runs/{opened.json['run']}").json
    assert (told["state"], told["files"]) == ("done", ["balanced.stl", "report.json"])
    assert not (app.project / ".app" / "0123456789ab").exists()
    assert app.ask("/api/files?name=x.stl&apart=..", b"x").status == 400
    assert app.ask(f"/api/files?name=x.stl&apart={told['id']}", b"x").status == 400
    (tmp_path / "out" / "report.json").write_text("{}", encoding="utf-8")
    app.ask("/api/files?name=report.json", b"{}")
    assert app.ask("/api/open", {"file": "report.json"}).status == 400


def test_wrong_use_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    project = ("--project", tmp_path / "p", "--no-browser")
    for code, said, options in (
        (2, "--port is 70000", ("--port", "70000")),
        (2, "--memory-mb is 0", ("--memory-mb", "0")),
        (3, "does not exist", (tmp_path / "no.stl",)),
    ):
        assert jobs.run("app", *options, *project) == code
        assert said in capsys.readouterr().err
    (tmp_path / "file").touch()
    assert jobs.run("app", "--no-browser", "--project", tmp_path / "file") == 3
    assert "cannot make the project" in capsys.readouterr().err


def test_two_tabs_do_not_write_over_each_other(app: Served) -> None:
    """Who saves a job says which one was changed; another one is told, key by key, and nothing is written."""
    first = app.ask("/api/job", job(), "PUT").json
    known = first["job_version"]
    assert app.ask("/api/project").json["job_version"] == known
    theirs = job(balance={"factor": 0.5, "grade": 6.3, "speed_rpm": 9000.0})
    newer = app.ask("/api/job", theirs, "PUT", If_Match=known)
    assert newer.status == 200
    mine = job(balance={"factor": 0.28, "grade": 6.3, "speed_rpm": 9000.0})
    answer = app.ask("/api/job", mine, "PUT", If_Match=known)
    assert answer.status == 409
    assert "balance.factor is 0.5 there, 0.28 here" in answer.json["error"]
    assert {"key": "balance.factor", "was": 0.28, "now": 0.5} in answer.json["changes"]
    assert app.ask("/api/project").json["job_text"] == newer.json["job_text"]
    assert answer.json["job_version"] == newer.json["job_version"]
    assert app.ask("/api/job/text", {"toml": "a = 1\n"}, "PUT", If_Match=known).status == 409
    assert app.ask("/api/job", mine, "PUT", If_Match=answer.json["job_version"]).status == 200


def test_a_run_says_whose_crank_it_is_and_what_the_job_says_since(app: Served) -> None:
    asked = job()
    app.ask("/api/job", asked, "PUT")
    told = app.ended(app.ask("/api/runs", {"verb": "balance", "job": asked}).json["id"])
    assert (told["crank"], told["job_changed"], told["changes"]) == (asked["crankshaft"]["file"], False, [])
    assert len(told["job_sha256"]) == 64
    assert told["started"].endswith("+00:00")
    balance = {**asked["balance"], "factor": 0.77}
    app.ask("/api/job", {**asked, "balance": balance}, "PUT")
    since = app.ask(f"/api/runs/{told['id']}").json
    assert since["job_changed"] is True
    assert since["changes"] == [{"key": "balance.factor", "was": asked["balance"]["factor"], "now": 0.77}]
    assert since["job_sha256"] == told["job_sha256"]
    listed = {each["id"]: each["job_changed"] for each in app.ask("/api/runs").json["runs"]}
    assert listed[told["id"]] is True


def test_a_page_starts_with_any_job_that_was_typed(app: Served) -> None:
    assert app.ask("/api/job/text", {"toml": "crankshaft = 5"}, "PUT").status == 200
    first = app.ask("/api/start").json
    assert first["project"] == app.ask("/api/project").json
    assert first["forms"] == app.ask("/api/kinds").json
    assert first["runs"] == app.ask("/api/runs").json["runs"]


OTHER_LOADS = {
    "engine": {
        **small.DRILLED["engine"],
        "rod_length_mm": 140.0,
        "rod": {"big_end_g": 250.0, "small_end_g": 150.0, "inertia_kg_mm2": 1300.0},
        "layout": {"bank_deg": [20.0], "offset_mm": 2.0, "rod_pitch_mm": 1.0},
    },
    "cycle": {"bore_mm": 76.8, "compression_ratio": 13.0, "heat_J": 600.0, "firing_order": [1]},
    "strength": {"pin_fillet_mm": 2.0, "material": {"tensile_MPa": 900.0}},
    "study": {"sampling": "latin_hypercube"},
    "shafts": [{"order": 1, "sense": "backward", "product_g_mm": 900.0}],
    "job": {"customer": "Ann"},
}
"""Changes of the small crank's job that no plan reads."""


def test_what_changes_loads_alone_leaves_the_cuts_and_their_result_as_they_are(app: Served) -> None:
    small.crank(app.project)
    loads = {**small.DRILLED, **OTHER_LOADS}
    before, after = (
        ab.balance(ab.Job.from_dict(each, folder=app.project)).report for each in (small.DRILLED, loads)
    )
    assert before["corrections"] == after["corrections"]
    assert before["residual"] == after["residual"]
    assert before["forces"] != after["forces"]
    cut, forces = (small.ran(app, verb, small.DRILLED) for verb in ("balance", "forces"))
    app.ask("/api/job", loads, "PUT")
    assert app.ask(f"/api/runs/{cut}").json["job_changed"] is False
    since = app.ask(f"/api/runs/{forces}").json
    assert {"key": "engine.rod_length_mm", "was": 110.0, "now": 140.0} in since["changes"]
    assert "job.customer" not in {each["key"] for each in since["changes"]}
    heavier = {**loads["engine"], "rotating_g": {"rod": 401.0}}
    app.ask("/api/job", {**loads, "engine": heavier}, "PUT")
    changes = app.ask(f"/api/runs/{cut}").json["changes"]
    assert changes == [{"key": "engine.rotating_g.rod", "was": 400, "now": 401}]


def test_a_reading_without_the_machines_figures_takes_the_usual_ones(app: Served) -> None:
    told = app.ended(app.ask("/api/runs", {"verb": "balance", "job": job()}).json["id"])
    report = app.ask(f"/api/runs/{told['id']}/report").json
    permitted = report["tolerance"]["permissible_g_mm"]
    reading = {
        "urr_percent": "", "umar_g_mm": "", "rotation": "ccw", "reads": "heavy", "zero_deg": 0,
        "plane": [{"g_mm": 0.1 * permitted, "angle_deg": 10.0}],
    }  # fmt: skip
    body = {"verb": "recut", "run": told["id"], "reading": reading, "trust_reading": True}
    again = app.ended(app.ask("/api/runs", body).json["id"])
    assert (again["state"], again["error"]) == ("done", None)
    read = app.ask(f"/api/runs/{again['id']}/report").json["machine_reading"]["file"]
    assert (read["umar_g_mm"], read["urr_percent"]) == (0.5, 95.0)
    assert again["crank"] == told["crank"]


@pytest.mark.parametrize(
    ("preset", "rods", "banks"),
    [("v8-crossplane", 2, [-45.0, 45.0]), ("inline-4", None, None)],
)
def test_a_drawn_crank_comes_with_its_engine(
    preset: str, rods: int | None, banks: list[float] | None, tmp_path: Path
) -> None:
    from autobalance.browser.drawing import open_example
    from autobalance.browser.opening import job_of
    from autobalance.browser.project import Project

    project = Project.at(tmp_path)
    open_example(preset, project)
    engine = job_of(project).get("engine", {})
    assert engine.get("rods_per_throw") == rods
    assert engine.get("layout", {}).get("bank_deg") == banks


def test_scripts_and_forms_are_packed_for_a_browser_that_takes_that(app: Served) -> None:
    for path in ("/static/three.min.js", "/static/page.css", "/static/page.js", "/api/kinds"):
        plain, packed = app.ask(path), app.ask(path, Accept_Encoding="gzip")
        assert gzip.decompress(packed.body) == plain.body
        assert packed.headers["content-encoding"] == "gzip"
        assert len(packed.body) < 0.4 * len(plain.body)


def test_the_page_is_two_files_of_its_own_packed(app: Served) -> None:
    """One script, one style sheet and two libraries, before it asks for data."""
    page = app.ask("/", method="GET").body.decode()
    named = re.findall(r'(?:src|href)="(/static/[^"]+)"', page)
    assert sorted(set(named)) == [
        "/static/icon.svg",
        "/static/page.css",
        "/static/page.js",
        "/static/preact.min.js",
        "/static/three.min.js",
    ]
    for path in named:
        packed = app.ask(path, Accept_Encoding="gzip")
        assert packed.headers["content-encoding"] == "gzip"
        assert "default-src 'none'; script-src 'self'" in packed.headers["content-security-policy"]


@pytest.mark.timing
def test_answers_on_an_open_connection_do_not_wait_for_each_other(app: Served) -> None:
    place = app.base.removeprefix("http://")
    with closing(http.client.HTTPConnection(place, timeout=60)) as connection:
        seconds = []
        for _ in range(20):
            begun = time.monotonic()
            connection.request("GET", "/static/page.css", headers={"X-Autobalance-Token": app.token})
            answer = connection.getresponse()
            assert answer.status == 200
            answer.read()
            seconds.append(time.monotonic() - begun)
    assert sorted(seconds)[10] < 0.02  # 0.04 where the end of each is held back until its head is confirmed


def test_a_mesh_that_is_replaced_while_it_is_sent_is_whole(project: Served) -> None:
    """A run puts the crank with its parts where the bare solid was, which the page may just be reading."""
    run = next(each["id"] for each in project.ask("/api/runs").json["runs"] if each["verb"] == "inspect")
    [path] = project.project.rglob(f"{run}/{MESH}")
    whole = path.read_bytes()
    others, ended = [whole, 3 * whole], threading.Event()

    def replaced() -> None:
        while not ended.is_set():
            for each in others:
                path.with_suffix(".other").write_bytes(each)
                path.with_suffix(".other").replace(path)

    replacing = threading.Thread(target=replaced)
    replacing.start()
    try:
        answers = {project.ask(f"/api/runs/{run}/mesh").body for _ in range(80)}
    finally:
        ended.set()
        replacing.join()
        path.write_bytes(whole)
    assert answers == set(others)
