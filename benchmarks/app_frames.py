"""Measure the app's view under software rendering: opening, frames a second, picking, dragging a hole.

Run from a checkout with Chromium and its driver: ``python benchmarks/app_frames.py [TRIANGLES | FILE ...]``,
files that carry their unit; ``drag TRIANGLES`` measures a drag alone. The processor time of a frame is that
of all processes of the browser: what it takes without a graphics card.
"""

from __future__ import annotations

import contextlib
import math
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import quote

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from main_job import subdivided, write_stl  # noqa: E402

from autobalance.drawn_cranks.design import PRESETS  # noqa: E402
from autobalance.drawn_cranks.generate import crank_solid  # noqa: E402
from tests.report.browser import Browser, browser  # noqa: E402
from tests.web_app.page import READY, at, chosen, load, until  # noqa: E402
from tests.web_app.serving import served  # noqa: E402

FRAMES, PICKS, TURNED_S = 3, 200, 6
SEEN = "return document.querySelector('[data-testid=model]').dataset.triangles !== '0'"
EMPTY = "document.querySelector('[data-testid=model]').dataset.triangles = '0'"
BYTES_A_TRIANGLE = 50
WHOLE = """
const [frames] = arguments, view = document.getElementById("model").view, gl = view.renderer.getContext();
const pixel = new Uint8Array(4), begin = performance.now();
for (let k = 0; k < frames; k++) {
  view.drawn();
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits until it is drawn
}
return (performance.now() - begin) / frames;
"""
TURN = """
const [seconds, done] = arguments, view = document.getElementById("model").view, drawn = view.drawn;
const from = view.controls.target, { up, position } = view.camera, begin = performance.now();
let frames = 0, last = 0, longest = 0;
view.drawn = () => { frames++; drawn.call(view); };
view.controls.dispatchEvent({ type: "start" });
const step = () => {
  const now = performance.now();
  if (last) longest = Math.max(longest, now - last);
  last = now;
  if (performance.now() - begin > 1000 * seconds) {
    view.drawn = drawn;
    view.controls.dispatchEvent({ type: "end" });
    done([frames, Boolean(view.slow), longest]);
    return;
  }
  position.sub(from).applyAxisAngle(up, 0.05).add(from);
  view.controls.update();
  requestAnimationFrame(step);
};
step();
"""
PICK = """
const [picks] = arguments, view = document.getElementById("model").view, took = [];
const box = view.box.getBoundingClientRect();
let seed = 1;
const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
while (took.length < picks) {
  const [x, y] = [box.x + box.width * random(), box.y + box.height * random()], begin = performance.now();
  if (view.pick(x, y)) took.push(performance.now() - begin);
}
took.sort((a, b) => a - b);
return [took[picks >> 1], took[Math.floor(0.99 * picks)]];
"""


WATCH = """
window.tasks = []; window.gaps = [];
new PerformanceObserver(list => { for (const each of list.getEntries()) window.tasks.push(each.duration); })
  .observe({ type: "longtask" });
let last = 0;
const step = (now) => { if (last) window.gaps.push(now - last); last = now; requestAnimationFrame(step); };
requestAnimationFrame(step);
"""
HELD = """
const hand = document.querySelector(".handle:not([data-behind=true])");
const { left, top, width, height } = hand.getBoundingClientRect();
return [left + width / 2, top + height / 2];
"""
MOVES, MOVE_MS, FAR_PX = 120, 30, 60
DRILLED = {
    "engine": {"rotating_g": {"rod": 250.0}, "reciprocating_g": {"piston": 300.0}},
    "balance": {"factor": 0.3, "grade": 6.3, "speed_rpm": 6000.0},
    "correction": {"method": "drill"},
}


def main() -> None:
    """Measure each file, and a drawn crank of each number of triangles."""
    if sys.argv[1:2] == ["drag"]:
        for wanted in sys.argv[2:]:
            with tempfile.TemporaryDirectory() as folder:
                print(dragging(drawn(int(wanted), Path(folder), "single"), Path(folder)), flush=True)
        return
    for wanted in sys.argv[1:] or ["100000", "1000000"]:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            crank = drawn(int(wanted), place) if wanted.isdigit() else Path(shutil.copy(wanted, place))
            print(f"{crank.name}: {opened(crank, place)}", flush=True)


def drawn(triangles: int, place: Path, preset: str = "inline-4") -> Path:
    """Write a crank of about so many triangles, named by their number."""
    crank = place / "crank.stl"
    write_stl(crank, crank_solid(PRESETS[preset], round(128 * (triangles / 53_000) ** 0.5)).mesh.corners)
    splits = max(0, round(math.log(triangles / (crank.stat().st_size / BYTES_A_TRIANGLE), 4.0)))
    corners = subdivided(crank, splits)
    named = place / f"{preset} of {len(corners)} triangles.stl"
    write_stl(named, corners)
    return named


def opened(crank: Path, place: Path) -> str:
    """Drop a file on the page, and tell when it is seen and named, and how fast it is drawn and picked."""
    with served(place / "project") as app, browser(place / "profile", pixels=1.0) as page:
        page.resize(1400, 900)
        load(page, app)
        page.click_on(at("bundled"))  # what runs need is loaded when the page is: wait for it
        until(page, READY)
        used, began = processor_s(), time.perf_counter()
        page.run(EMPTY)
        chosen(page, crank)  # a drop opens at once
        sent = time.perf_counter() - began
        until(page, SEEN, most_s=900.0)
        seen, seen_s = time.perf_counter() - began, processor_s() - used
        until(page, READY, most_s=900.0)
        known, known_s = time.perf_counter() - began, processor_s() - used
        times = (
            f"sent after {sent:.1f} s, in 3D {seen:.1f} s ({seen_s:.1f} s of processor time), "
            f"recognised {known:.1f} s ({known_s:.1f} s) after the drop"
        )
        return f"{times}; {frames(page)}"


def frames(page: Browser) -> str:
    """Draw the crank whole, turn it as a hand does, pick on it, and tell how long that took."""
    page.call("POST", "/timeouts", {"script": 600_000})
    page.run(WHOLE, 1)
    before = processor_s()
    page.run(WHOLE, FRAMES)
    whole = 1000.0 * (processor_s() - before) / FRAMES
    page.call("POST", "/execute/async", {"script": TURN, "args": [2]})  # finds out how fast it is drawn
    before = processor_s()
    turned, slow, longest = page.call("POST", "/execute/async", {"script": TURN, "args": [TURNED_S]})
    turning = 1000.0 * (processor_s() - before) / turned
    middle, most = page.run(PICK, PICKS)
    size = page.run("const c = document.getElementById('canvas'); return `${c.width} × ${c.height}`")
    return (
        f"whole {whole:.0f} ms of processor time at {size} pixels; turning {turned / TURNED_S:.1f} frames/s, "
        f"{turning:.0f} ms of processor time each{', coarse' if slow else ''},"
        f" at most {longest:.0f} ms apart; "
        f"picking {middle:.2f} ms, 99 of 100 under {most:.1f} ms"
    )


def dragging(crank: Path, place: Path) -> str:
    """Drill a crank, drag one of its holes with a real pointer, and tell the tasks that this took."""
    with served(place / "project") as app, browser(place / "profile", pixels=1.0) as page:
        page.resize(1400, 900)
        app.ask(f"/api/files?name={quote(crank.name)}", crank.read_bytes())
        table = {"file": crank.name, "unit": "mm", "density_kg_m3": 7850.0}
        job = {"crankshaft": table, **DRILLED}
        app.ask("/api/job", job, "PUT")
        for verb in ("inspect", "balance"):
            app.ended(app.ask("/api/runs", {"verb": verb, "job": job}).json["id"], 900.0)
        load(page, app)
        page.click_on(at("tab-see"))
        until(page, "return document.querySelectorAll('.handle:not([data-behind=true])').length > 0")
        triangles = page.run("return document.getElementById('model').dataset.triangles")
        time.sleep(2.0)
        page.run(WATCH)
        x, y = page.run(HELD)
        moves = [
            {
                "type": "pointerMove",
                "duration": MOVE_MS,
                "x": round(x + FAR_PX * math.sin(k / 15)),
                "y": round(y + FAR_PX * math.sin(k / 11)),
            }
            for k in range(MOVES)
        ]
        grip = [{"type": "pointerMove", "duration": 0, "x": round(x), "y": round(y)}]
        acts = [*grip, {"type": "pointerDown", "button": 0}, *moves, {"type": "pointerUp", "button": 0}]
        before, main_before = processor_s(), page_thread_s()
        page.call("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": acts}]})
        took, main_took = processor_s() - before, page_thread_s() - main_before
        moved = page.run("return !document.getElementById('dragged').hidden")
        tasks, gaps = page.run("return [window.tasks, window.gaps]")
        gaps.sort()
        longest = f", longest {max(tasks):.0f} ms" if tasks else ""
        return (
            f"{triangles} triangles: hole dragged {MOVES} times{'' if moved else ' (not moved!)'}, "
            f"{1000.0 * took / MOVES:.0f} ms of processor time each, "
            f"{1000.0 * main_took / MOVES:.0f} of them in the page's thread; "
            f"tasks over 50 ms of a clock: {len(tasks)}{longest}; "
            f"frames {gaps[len(gaps) // 2]:.0f} ms apart, "
            f"95 of 100 under {gaps[int(0.95 * len(gaps))]:.0f} ms"
        )


def page_thread_s() -> float:
    """Return the processor time of the thread in which the page's scripts, styles and layout run."""
    used = [0.0]
    for number in ours():
        with contextlib.suppress(OSError):
            if b"--type=renderer" in Path(f"/proc/{number}/cmdline").read_bytes():
                used.append(used_s(Path(f"/proc/{number}/task/{number}/stat")))
    return max(used)


def processor_s() -> float:
    """Return the processor time that what was started from here has used, and still runs."""
    found = 0.0
    for number in ours():
        with contextlib.suppress(OSError):
            found += used_s(Path(f"/proc/{number}/stat"))
    return found


def used_s(stat: Path) -> float:
    fields = stat.read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def ours() -> list[int]:
    """Return this process and all that were started from it."""
    parents: dict[int, int] = {}
    for each in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parents[int(each.parent.name)] = int(each.read_text().rpartition(")")[2].split()[1])

    def is_ours(number: int) -> bool:
        while number in parents:
            if number == os.getpid():
                return True
            number = parents[number]
        return False

    return [number for number in parents if is_ours(number)]


if __name__ == "__main__":
    main()
