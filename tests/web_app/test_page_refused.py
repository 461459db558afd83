"""What the page is given that is wrong or hostile: files, bombs, pages of others."""

import contextlib
import io
import threading
import tomllib
import zipfile
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

import autobalance as ab
from tests import jobs
from tests.report.browser import Browser
from tests.web_app.page import BROWSER, READY, at, chosen, job_text, text_of, until
from tests.web_app.serving import Served
from tests.web_app.test_page_checks import JOB_KEYS

pytestmark = BROWSER


def zip_bomb() -> bytes:
    """Return a 3MF of some kilobytes that unpacks to a thousand times as much."""
    buffer = io.BytesIO()
    with (
        zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as out,
        out.open("3D/3dmodel.model", "w") as model,
    ):
        model.write(b'<?xml version="1.0"?><model unit="millimeter">')
        for _ in range(8):
            model.write(b" " * (1 << 24))
    return buffer.getvalue()


FILES: dict[str, Callable[[], bytes]] = {
    "wrong.stl": lambda: b"no crank",
    "bomb.3mf": zip_bomb,
    "many.stl": lambda: b"solid".ljust(80) + (4_000_000_000).to_bytes(4, "little") + bytes(50),
    "many.ply": lambda: (
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        b"property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n"
        b"end_header\n" + bytes(64)
    ),
}


def test_wrong_files_and_bombs_end_in_one_line_as_in_inspect(
    page: Browser, project: Served, tmp_path: Path
) -> None:
    for name, data in FILES.items():
        path = tmp_path / name
        path.write_bytes(data())
        chosen(page, path)
        page.click_on(at("open"))
        until(page, "return document.querySelector('[data-testid=error]').textContent !== ''")
        said = text_of(page, "error")
        with pytest.raises(ab.AutobalanceError) as own:
            ab.inspect(path, density_kg_m3=7850.0, unit=None if name.endswith("3mf") else "mm")
        raw = str(own.value).replace(str(path), name)  # no path of the server
        assert said == raw or (JOB_KEYS.search(raw) and not JOB_KEYS.search(said))
        assert "\n" not in said
        run = project.ask("/api/runs").json["runs"][-1]
        assert (run["state"], run["exit_code"], run["error"]) == ("failed", 3, raw)
        assert not (project.project / "runs" / run["id"]).exists()
        page.run("document.querySelector('[data-testid=error]').textContent = ''")


def test_a_job_with_its_crank_opens_at_once_and_cylinders_are_called_what_they_are(
    page: Browser, tmp_path: Path
) -> None:
    job = jobs.pin_job(tmp_path / "pin", method='"shoulder"\nfaces = [[1.5, 20.0, -30.0]]')
    chosen(page, job, job.parent / "crank-with-pin.stl")
    text = job_text(page, "crank-with-pin")
    assert tomllib.loads(text)["correction"]["shoulder"]["faces"] == [[1.5, 20.0, -30.0]]
    assert tomllib.loads(text)["engine"]["reciprocating_g"] == {"piston": 261.5}
    until(page, "return document.querySelector('[data-testid=tree] [data-kind=throw]')")
    until(page, READY)
    page.press("[data-kind=main_journal][data-number='2']", "\ue007")
    until(page, "return !document.getElementById('cylinder').hidden")
    page.click_on("#is-journal")
    table = tomllib.loads(job_text(page, "main_journals"))["crankshaft"]
    assert len(table["main_journals"]) == 2
    until(page, READY)
    assert text_of(page, "error") == ""


HOSTILE = """<!doctype html><img src="{base}/api/project"><iframe src="{base}/"></iframe><script>
window.found = []; (async () => {{
  for (const [path, options] of [
    ["/api/health", {{}}], ["/api/runs", {{}}], ["/api/runs", {{ credentials: "include" }}],
    ["/api/runs", {{ mode: "no-cors", credentials: "include" }}],
    ["/api/runs", {{ method: "POST", mode: "no-cors", credentials: "include", body: "{{}}" }}],
  ]) try {{ const a = await fetch("{base}" + path, options); window.found.push(a.type); }}
  catch {{ window.found.push("refused"); }}
  window.done = true;
}})();</script>"""


@contextlib.contextmanager
def another_server(page: str) -> Iterator[str]:
    """Serve a page on another port of this machine: to cookies that is the same site."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(page.encode())

        def log_message(self, format: str, *_: object) -> None:  # noqa: A002
            return None

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/"
        finally:
            server.shutdown()


@pytest.mark.parametrize("where", ["file", "port"])
def test_a_page_of_another_origin_reads_and_starts_nothing(
    window: Browser, project: Served, tmp_path: Path, where: str
) -> None:
    """The app's cookie is in the same browser; a file's origin is ``null``."""
    window.call("POST", "/url", {"url": project.address})
    until(window, "return document.body.dataset.ready === 'true'")
    before = project.ask("/api/runs").json
    text = HOSTILE.format(base=project.base)
    if where == "file":
        (tmp_path / "hostile.html").write_text(text, encoding="utf-8")
        window.open(tmp_path / "hostile.html")
        _refused(window)
    else:
        with another_server(text) as address:
            window.call("POST", "/url", {"url": address})
            _refused(window)
    assert project.ask("/api/runs").json == before


def _refused(window: Browser) -> None:
    until(window, "return window.done")
    assert window.run("return window.found") == ["refused"] * 5
    until(window, "return document.images[0].complete")
    assert window.run("return document.images[0].naturalWidth") == 0
    assert window.run("try { return frames[0].document.title } catch { return 'closed' }") == "closed"
