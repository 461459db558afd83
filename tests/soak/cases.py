"""Random cases, each of one kind and seed: valid jobs, damaged files, changed reports, requests, kills.

A case ends in an exit code that is documented, in one line where input is refused, and never in a traceback.
"""

from __future__ import annotations

import contextlib
import copy
import hashlib
import io
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from autobalance import command
from tests import jobs
from tests.cranks import Shape, make_crank
from tests.web_app import small

CODES = frozenset({0, 2, 3, 4})
MESHES = "obj", "3mf", "ply", "off", "glb"
EXACT = "step", "iges", "brep"
WITH_FILES = "job.toml", "job.xlsx", "list.csv", "crank.stl", *(f"crank.{each}" for each in (*MESHES, *EXACT))
RECORDS = "record.csv", "record.wav", "record.uff", "record.mat", "record.tdms"


def ran(*arguments: object) -> tuple[int, str]:
    """Run a command; return its exit code and what it said on standard error."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = command.main([str(each) for each in arguments])
    return code, err.getvalue()


def held(code: int, said: str, what: str) -> None:
    """Hold an end against what is documented."""
    if code not in CODES:
        raise AssertionError(f"{what}: exit code {code}: {said[-500:]}")
    if "Traceback" in said or (code == 3 and said.count("\n") != 1):
        raise AssertionError(f"{what}: exit code {code} with other than one line: {said[-500:]}")


# --- what files are made of -------------------------------------------------------------------------------


def made(folder: Path) -> None:
    """Write a small job and its crank in every format that the program reads, and records of a signal."""
    small.crank(folder).rename(folder / "crank.stl")
    text = "\n".join(_toml(key, value) for key, value in small.job().items()).replace(small.NAME, "crank.stl")
    (folder / "job.toml").write_text(text, encoding="utf-8")
    (folder / "list.csv").write_text("name,job\none,job.toml\ntwo,job.toml\n", encoding="utf-8")
    assert ran("init", folder / "job.toml", "-o", folder / "job.xlsx")[0] == 0
    assert ran("balance", folder / "job.toml", "-o", folder / "out", "--no-report")[0] in (0, 4)
    for ending in MESHES:
        _converted(folder / "crank.stl", folder / f"crank.{ending}")
    with contextlib.suppress(AssertionError):
        assert ran("generate", "single", "-o", folder / "crank.step")[0] == 0
        _exact(folder)
    _records(folder)


def _toml(key: str, value: Any) -> str:
    lines = [f"[{key}]"]
    for name, inner in value.items():
        if isinstance(inner, dict):
            inside = ", ".join(f"{each} = {json.dumps(item)}" for each, item in inner.items())
            lines.append(f"{name} = {{{inside}}}")
        else:
            lines.append(f"{name} = {json.dumps(inner)}")
    return "\n".join(lines) + "\n"


def _converted(source: Path, target: Path) -> None:
    from autobalance.solid.formats.read import read
    from autobalance.solid.formats.write import Written

    mesh = read(source, "mm").solid.mesh
    target.write_bytes(Written.of(mesh, target.suffix[1:], 1.0).data)


def _exact(folder: Path) -> None:
    """Write the STEP crank as IGES and BREP too."""
    from OCP.BRepTools import BRepTools
    from OCP.IGESControl import IGESControl_Writer
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    reader.ReadFile(str(folder / "crank.step"))
    reader.TransferRoots()
    shape = reader.OneShape()
    BRepTools.Write_s(shape, str(folder / "crank.brep"))
    writer = IGESControl_Writer()
    writer.AddShape(shape)
    writer.Write(str(folder / "crank.iges"))


def _records(folder: Path) -> None:
    from scipy.io import savemat, wavfile

    times = np.arange(400) / 2000.0
    wave = np.sin(2.0 * np.pi * 25.0 * times)
    rows = "\n".join(f"{t:.6g},{v:.6g}" for t, v in zip(times.tolist(), wave.tolist(), strict=True))
    (folder / "record.csv").write_text(f"time_s,accel_g\n{rows}\n", encoding="utf-8")
    wavfile.write(folder / "record.wav", 2000, (wave * 0.25).astype(np.float32))
    savemat(folder / "record.mat", {"time_s": times, "accel_g": wave})
    with contextlib.suppress(ImportError):
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(folder / "record.tdms") as file:
            file.write_segment([ChannelObject("run", "accel_g", wave, {"wf_increment": 5e-4})])
    with contextlib.suppress(ImportError):
        import pyuff

        pyuff.UFF(str(folder / "record.uff")).write_sets(_uff(times, wave), "add")


def _uff(times: Any, wave: Any) -> dict[str, Any]:
    return {
        "type": 58, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1,
        "data": wave, "x": times, "id1": "accel", "rsp_ent_name": "n", "ref_ent_name": "n",
        "abscissa_spacing": 1, "abscissa_min": 0.0, "abscissa_inc": 5e-4, "num_pts": len(wave),
        "ord_data_type": 4, "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 0, "binary": 0,
    }  # fmt: skip


def job_text(asked: dict[str, Any], crank: str = "crank.stl") -> str:
    """Return a job's tables as its file."""
    return "\n".join(_toml(key, value) for key, value in asked.items()).replace(small.NAME, crank)


def random_job(draw: random.Random) -> dict[str, Any]:
    """Return a valid job for the small crank."""
    kind = draw.choice(["shoulder", "drill", "slug", "mill", "turn", "add"])
    return small.job(
        balance={
            "factor": round(draw.uniform(0.0, 1.0), 3),
            "grade": draw.choice([2.5, 6.3, 16.0, 40.0]),
            "speed_rpm": float(draw.randrange(1000, 12000)),
        },
        correction={"method": kind},
    )


# --- the kinds ----------------------------------------------------------------------------------------------


def job(folder: Path, draw: random.Random) -> None:
    """Balance by a random valid job; what is written is believed by ``verify``."""
    text = job_text(random_job(draw))
    (folder / "random.toml").write_text(text, encoding="utf-8")
    with jobs.without_advice():
        code, said = ran("balance", folder / "random.toml", "-o", folder / "random", "--no-report")
    held(code, said, text)
    if code in (0, 4):
        again, said = ran("verify", folder / "random" / "report.json")
        assert again == code, f"verify: exit code {again}: {said[-500:]}\n{text}"


def mutated(data: bytes, draw: random.Random) -> bytes:
    """Return bytes with some changed, left out, doubled or cut off; of texts, numbers made strange."""
    changed = bytearray(data)
    for _ in range(draw.randrange(1, 6)):
        if not changed:
            break
        at, size = draw.randrange(len(changed)), draw.randrange(1, 40)
        way = draw.randrange(5)
        if way == 0:
            changed[at] = draw.randrange(256)
        elif way == 1:
            del changed[at : at + size]
        elif way == 2:
            changed[at:at] = changed[at : at + size] * draw.randrange(1, 4)
        elif way == 3:
            changed[at : at + 1] = draw.choice(
                [b"1e308", b"-1", b"nan", b"\0", b"4294967296", b"\xff\xfe", b'"']
            )
        else:
            lines = bytes(changed).split(b"\n")
            del lines[draw.randrange(len(lines))]
            changed = bytearray(b"\n".join(lines))
    return bytes(changed)


def damaged(folder: Path, draw: random.Random) -> None:
    """Read a damaged file of any format."""
    name = draw.choice([each for each in (*WITH_FILES, *RECORDS) if (folder / each).is_file()])
    place = folder / f"damaged-{name}"
    place.write_bytes(mutated((folder / name).read_bytes(), draw))
    read(place, name)


def read(place: Path, name: str) -> None:
    """Give a file to the command that reads such files as ``name`` is."""
    if name in RECORDS:
        code, said = ran("orders", place, "--speed-rpm", 1500)
    elif name == "list.csv":
        code, said = ran("batch", place, "-o", place.parent / "results", "--workers", 1)
    elif name.startswith("job"):
        code, said = ran("init", place, "-o", place.with_name("again.toml"), "--force")
    else:
        code, said = ran("inspect", place, "--unit", "mm")
    held(code, said, str(place))


def report(folder: Path, draw: random.Random) -> None:
    """Change a finished report in some places; ``verify`` refuses it in one line, or does not look there."""
    values: Any = json.loads((folder / "out" / "report.json").read_text("utf-8"))
    for _ in range(draw.randrange(1, 3)):
        inner: Any = values
        while isinstance(inner, dict | list) and inner:
            key: Any = draw.choice(list(inner)) if isinstance(inner, dict) else draw.randrange(len(inner))
            if not isinstance(inner[key], dict | list) or draw.random() < 0.1:
                inner[key] = draw.choice([None, True, 0, -1, 1e30, 5e-324, 10**400, "", "../x", [], {}, [[]]])
                break
            inner = inner[key]
    before = (folder / "out" / "report.json").read_bytes()
    try:
        (folder / "out" / "report.json").write_text(json.dumps(values), encoding="utf-8")
        held(*ran("verify", folder / "out" / "report.json"), f"report {json.dumps(values)[:200]}")
    finally:
        (folder / "out" / "report.json").write_bytes(before)


def requests(folder: Path, draw: random.Random) -> None:
    """Send the app whatever comes to mind; it answers each and goes on."""
    from tests.web_app.serving import served

    project = folder / "project"
    bodies: list[Any] = [
        None,
        [],
        {},
        "x",
        0,
        {"verb": []},
        {"verb": "balance"},
        {"verb": "inspect", "job": 1},
    ]
    bodies += [{"verb": "balance", "job": small.job()}, {"path": "\ud800"}, b"\xff", b"{", {"job": None}]
    paths = ["/api/runs", "/api/job", "/api/open", "/api/files?name=a.stl", "/api/files?name=../x.toml"]
    paths += [
        "/api/runs/nothing/cancel",
        "/api/runs/nothing/predict",
        "/api/project",
        "/api/runs/x/files/..%2f",
    ]
    with served(project) as app:
        for _ in range(30):
            path, body = draw.choice(paths), draw.choice(bodies)
            method = draw.choice(["GET", "POST", "PUT"])
            answer = app.ask(path, None if method == "GET" else body, method)
            if answer.status >= 500:
                raise AssertionError(f"{method} {path} {body!r}: {answer.status} {answer.body[:300]!r}")
        assert app.ask("/api/health").status == 200
    left = list(project.rglob("*.part")) if project.is_dir() else []
    assert not left, f"left behind: {left}"


def kill(folder: Path, draw: random.Random) -> None:
    """Kill a run at any time; the next one ends as if nothing had been, and leaves nothing half-written."""
    out = folder / "killed"
    asked = [sys.executable, "-m", "autobalance", "balance", str(folder / "job.toml"), "-o", str(out)]
    asked += ["--no-report"]
    with subprocess.Popen(
        asked, cwd=jobs.ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        time.sleep(draw.uniform(0.05, 3.0))
        process.send_signal(draw.choice([signal.SIGTERM, signal.SIGINT, signal.SIGKILL]))
        process.wait(timeout=60)
    code, said = ran("balance", folder / "job.toml", "-o", out, "--no-report")
    held(code, said, "the run after a killed one")
    assert code in (0, 4), said
    confirmed, said = ran("verify", out / "report.json")
    assert confirmed == code, f"balance ended {code}, verify {confirmed}: {said}"
    left = [each.name for each in out.iterdir() if each.name not in ("report.json", "balanced.stl")]
    assert not left, f"left behind: {left}"


def folders(folder: Path, draw: random.Random) -> None:
    """Balance random jobs into one folder, other papers each time; it holds the last one's files alone."""
    out = folder / f"shared-{draw.randrange(2**32)}"
    papers = ["json", "html", "pdf", "xlsx", "csv"]
    try:
        for turn in range(draw.randrange(2, 4)):
            text = job_text(random_job(draw))
            (folder / "turn.toml").write_text(text, encoding="utf-8")
            asked = ["--only", ",".join(sorted({"json", *draw.sample(papers, draw.randrange(1, 3))}))]
            before = contents(out)
            with jobs.without_advice():
                code, said = ran("balance", folder / "turn.toml", "-o", out, *asked)
            held(code, said, text)
            if code in (0, 4):
                only_the_listed(out, f"turn {turn}: {asked} after {sorted(before)}\n{text}")
                again, said = ran("verify", out)
                assert again == code, f"verify: exit code {again}: {said[-500:]}\n{text}"
            else:
                assert contents(out) == before, f"a refused run changed its folder: {said}"
    finally:
        shutil.rmtree(out, ignore_errors=True)


def contents(folder: Path) -> dict[str, str]:
    """Return the hash of each file of a folder."""
    files = [each for each in folder.rglob("*") if each.is_file()] if folder.is_dir() else []
    return {each.relative_to(folder).as_posix(): _sha256(each) for each in files}


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def only_the_listed(folder: Path, what: str) -> None:
    """Hold a folder against its report: every file is listed, with its hash, and no other is there."""
    report = json.loads((folder / "report.json").read_text("utf-8"))
    entries = [each for each in report["outputs"].values() if isinstance(each, dict | list)]
    files = [each for entry in entries for each in (entry if isinstance(entry, list) else [entry])]
    listed = {each["file"]: each.get("sha256") for each in files}
    found = contents(folder)
    strange = sorted(found.keys() - listed.keys() - {"report.json"})
    assert not strange, f"{strange} are no files of this report: {what}"
    for name, sha256 in listed.items():
        assert found.get(name) is not None, f"{name} is listed and not there: {what}"
        assert sha256 in (None, found[name]), f"{name} is another file than the one listed: {what}"


SMALL_STROKE_MM = 2.0 * Shape().crank_radius
"""Stroke of the small crank."""
SLIPS: dict[str, Callable[[dict[str, Any]], None]] = {
    "thousands of revolutions": lambda job: job["balance"].update(speed_rpm=6.0),
    "a decimal point for a thousands' sign": lambda job: job["balance"].update(speed_rpm=11.000),
    "one part in kg": lambda job: job["engine"]["reciprocating_g"].update(piston=0.5),
    "all parts in kg": lambda job: job["engine"].update(
        rotating_g={"rod": 0.4}, reciprocating_g={"piston": 0.5}
    ),
    "density in g/cm³": lambda job: job["crankshaft"].update(density_kg_m3=7.85),
    "a file in inch": lambda job: job["crankshaft"].update(unit="inch"),
    "a file in cm": lambda job: job["crankshaft"].update(unit="cm"),
    "radius for stroke": lambda job: job["engine"].update(stroke_mm=SMALL_STROKE_MM / 2.0),
    "stroke of another": lambda job: job["engine"].update(stroke_mm=SMALL_STROKE_MM + 3.0),
    "per cent for a share": lambda job: job["balance"].update(factor=50.0),
    "a journal beside the file's": lambda job: job["crankshaft"].update(axis_point_mm=[0.6, 0.0, 0.0]),
}


def slip(folder: Path, draw: random.Random) -> None:
    """Balance by a job with a slip of typing: it is refused, or a warning or the verdict's reason says so."""
    name = draw.choice(list(SLIPS))
    asked = copy.deepcopy(random_job(draw))
    SLIPS[name](asked)
    text = job_text(asked)
    (folder / "slip.toml").write_text(text, encoding="utf-8")
    out = folder / "slip"
    try:
        with jobs.without_advice():
            code, said = ran("balance", folder / "slip.toml", "-o", out, "--no-report")
        held(code, said, text)
        assert code == 3 or "warning:" in said, f"{name}: believed without a word (exit code {code})\n{text}"
    finally:
        shutil.rmtree(out, ignore_errors=True)


def session(folder: Path, draw: random.Random) -> None:
    """Use the app: two cranks, jobs that change, runs, a second start; results keep their jobs."""
    from tests.web_app.serving import served

    project = folder / f"session-{draw.randrange(2**32)}"
    project.mkdir()
    small.crank(project)
    other, _ = make_crank([0.0], Shape(segments=20))
    jobs.write_stl(project / "other.stl", other.mesh.corners)
    asked: dict[str, dict[str, Any]] = {}
    try:
        for _ in range(2):
            with served(project) as app:
                for run, job in asked.items():
                    _is_of(app, run, job)
                for _ in range(draw.randrange(2, 5)):
                    wanted = random_job(draw)
                    wanted["crankshaft"] = {
                        **wanted["crankshaft"],
                        "file": draw.choice([small.NAME, "other.stl"]),
                    }
                    if draw.random() < 0.5:
                        assert app.ask("/api/job", wanted, "PUT").status < 500
                    answer = app.ask(
                        "/api/runs", {"verb": draw.choice(["inspect", "balance"]), "job": wanted}
                    )
                    assert answer.status == 202, answer.body
                    run = answer.json["id"]
                    if draw.random() < 0.2:
                        assert app.ask(f"/api/runs/{run}/cancel", {}).status < 500
                    told = app.ended(run)
                    if told["state"] == "done":
                        asked[run] = wanted
                        _is_of(app, run, wanted)
                assert app.ask("/api/runs").status == 200
    finally:
        shutil.rmtree(project, ignore_errors=True)


def _is_of(app: Any, run: str, job: dict[str, Any]) -> None:
    """Hold a finished run of the app against the job that it was asked with."""
    report = app.ask(f"/api/runs/{run}/report").json
    if "job" in report and report["command"] == "balance":
        for table in ("balance", "crankshaft"):
            for key, value in job[table].items():
                found = report["job"][table].get(key)
                same = Path(str(found)).name == value if key == "file" else found == value
                assert same, f"run {run}: {table}.{key} is {found!r}, asked {value!r}"


def good(folder: Path, draw: random.Random) -> None:
    """Balance a random crank of any format; no verb refuses what was written."""
    from tests.good_results import faults, good_job  # which draws on this module

    with tempfile.TemporaryDirectory(dir=folder) as place:
        found = faults(good_job(Path(place), draw), draw)
    assert not found, "; ".join(found)


KINDS: dict[str, tuple[Callable[[Path, random.Random], None], float]] = {
    "damaged": (damaged, 10.0),
    "report": (report, 4.0),
    "job": (job, 2.0),
    "kill": (kill, 0.5),
    "good": (good, 0.5),
    "requests": (requests, 0.3),
    "folders": (folders, 1.0),
    "slip": (slip, 2.0),
    "session": (session, 0.2),
}
"""What is tried, and how often beside the others."""


def drawn(seed: int) -> Iterator[tuple[str, int]]:
    """Yield kinds and seeds without end."""
    draw = random.Random(seed)
    names, often = list(KINDS), [share for _, share in KINDS.values()]
    while True:
        yield draw.choices(names, often)[0], draw.randrange(2**32)
