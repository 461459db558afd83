"""The cache of what reading gave: the same to the bit, spoilt entries, room, other processes, no pickles."""

from __future__ import annotations

import io
import json
import os
import pickle
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance import disk_cache
from autobalance.command.main import main
from autobalance.disk_cache import kept, program
from autobalance.errors import UsageError
from autobalance.quantities import mm, said
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.value_codec import CodecError, from_bytes, plain_of, to_bytes, value_of
from tests import jobs
from tests.coarse import coarse_facets


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("AUTOBALANCE_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("AUTOBALANCE_CACHE_MB")
    return tmp_path / "cache"


def main_of(*arguments: str | Path) -> int:
    """Run a command without what tests keep in memory."""
    return main([str(each) for each in arguments])


def entries(cache: Path) -> dict[str, bytes]:
    return {each.name: each.read_bytes() for each in cache.iterdir()} if cache.is_dir() else {}


def counted(calls: list[int], value: object = 1.5) -> object:
    calls.append(1)
    return value


def report_and_solid(folder: Path) -> tuple[dict[str, object], bytes]:
    report = jobs.report_of(folder)
    for each in ("seconds", "outputs"):
        del report[each]
    return report, next(folder.glob("balanced.*")).read_bytes()


def test_results_with_and_without_the_cache_are_the_same_to_the_bit(tmp_path: Path, cache: Path) -> None:
    job = jobs.pin_job(tmp_path)
    found = []
    for name, more in (("none", ("--no-cache",)), ("fills", ()), ("uses", ())):
        assert main_of("balance", job, "-o", tmp_path / name, "--no-report", *more) == 0
        found.append(report_and_solid(tmp_path / name))
        assert bool(entries(cache)) == (name != "none")
    assert found[0] == found[1] == found[2]
    kinds = {name.partition("-")[0] for name in entries(cache)}
    assert kinds == {"source", "anatomy", "facets"}


@pytest.mark.slow
def test_a_step_file_gives_the_same_to_the_bit_and_needs_no_kernel(tmp_path: Path, cache: Path) -> None:
    pytest.importorskip("OCP")
    ab.generate("single", file=tmp_path / "crank.step").write(tmp_path)
    (tmp_path / "job.toml").write_text(
        '[crankshaft]\nfile = "crank.step"\ndensity_kg_m3 = 7850\n[engine.rotating_g]\nall = 134.0\n'
        "[engine.reciprocating_g]\nall = 261.5\n[balance]\nfactor = 0.5\ngrade = 16\nspeed_rpm = 6000\n"
        '[correction]\nmethod = "drill"\n'
    )
    found = []
    with coarse_facets():
        for name, more in (("none", ("--no-cache",)), ("fills", ()), ("uses", ())):
            assert main_of("balance", tmp_path / "job.toml", "-o", tmp_path / name, "--no-report", *more) == 0
            found.append(report_and_solid(tmp_path / name))
    assert found[0][0] == found[1][0] == found[2][0]
    code = "import sys, autobalance as ab; ab.read_crank(sys.argv[1]); print('OCP' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "crank.step")], capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"


def test_a_result_is_computed_once_for_its_file_and_question(cache: Path) -> None:
    calls: list[int] = []
    for key in ("a", "a", "b", "a", ""):
        assert kept("source", key, lambda: counted(calls)) == 1.5
    assert len(calls) == 3  # a, b, and what has no key
    assert len(entries(cache)) == 2


def test_another_program_reads_anew(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []
    kept("source", "a", lambda: counted(calls))
    assert program() == program()
    monkeypatch.setattr(disk_cache, "program", lambda: "another version")
    kept("source", "a", lambda: counted(calls))
    assert len(calls) == 2


@pytest.mark.parametrize("spoil", ["cut off", "one byte", "empty", "pickle"])
def test_a_spoilt_entry_is_read_anew_and_mended(cache: Path, spoil: str) -> None:
    calls: list[int] = []
    value = np.arange(1000.0)
    kept("source", "a", lambda: counted(calls, value))
    (path,) = cache.iterdir()
    whole = path.read_bytes()
    changed = bytearray(whole)
    changed[len(whole) // 2] ^= 1
    spoilt = {"cut off": whole[:-9], "one byte": bytes(changed), "empty": b"", "pickle": pickle.dumps(value)}
    path.write_bytes(spoilt[spoil])
    found = kept("source", "a", lambda: counted(calls, value))
    assert np.array_equal(np.asarray(found), value)
    assert len(calls) == 2
    assert path.read_bytes() == whole


def test_the_oldest_go_first_and_what_is_used_stays(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AUTOBALANCE_CACHE_MB", "0.03")  # three entries of some 9 kB
    calls: list[int] = []
    big = np.arange(1000.0)
    for key in ("a", "b", "c"):
        kept("source", key, lambda: counted(calls, big))
    in_order = sorted(cache.iterdir(), key=lambda each: each.stat().st_mtime_ns)
    for age, path in zip((30, 20, 10), in_order, strict=True):
        os.utime(path, (time.time() - age, time.time() - age))
    kept("source", "a", lambda: counted(calls, big))  # used: now the youngest
    kept("source", "d", lambda: counted(calls, big))
    assert sum(map(len, entries(cache).values())) <= 30_000
    before = len(calls)
    kept("source", "a", lambda: counted(calls, big))
    assert len(calls) == before
    kept("source", "b", lambda: counted(calls, big))
    assert len(calls) == before + 1


def test_entries_appear_whole_beside_other_processes(cache: Path) -> None:
    code = (
        "import numpy as np, sys\nfrom autobalance.disk_cache import kept\n"
        "for _ in range(40):\n"
        "    value = kept('source', str(_ % 4), lambda: np.full(20000, float(_ % 4)))\n"
        "    assert (value == _ % 4).all() and len(value) == 20000\n"
    )
    environment = {**os.environ, "AUTOBALANCE_CACHE_MB": "0.4"}  # two entries: they take out each other's
    running = [subprocess.Popen([sys.executable, "-c", code], env=environment) for _ in range(3)]
    assert [each.wait() for each in running] == [0, 0, 0]
    assert all(name.endswith(".kept") for name in entries(cache))


def test_a_folder_that_takes_nothing_costs_no_result(
    tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("AUTOBALANCE_CACHE", str(tmp_path / "file" / "cache"))
    assert kept("source", "a", lambda: 2.0) == 2.0
    monkeypatch.setenv("AUTOBALANCE_CACHE_MB", "much")
    with pytest.raises(UsageError, match=r"AUTOBALANCE_CACHE_MB is 'much'. Enter a number of MB"):
        kept("source", "a", lambda: 2.0)


def test_values_come_back_to_the_bit_with_what_they_share() -> None:
    mesh = Mesh(np.asfortranarray(np.random.default_rng(1).normal(size=(5, 3))), np.arange(6).reshape(2, 3))
    text = said("wall of {}", mm(4.5, ".1f"))
    value = (mesh, mesh, {"a": [np.float64(0.1), -0.0, float("inf"), None]}, text, b"\0\xff", Moments.zero())
    back = from_bytes(to_bytes(value))
    assert back[0] is back[1]
    assert back[0].vertices.tobytes("A") == mesh.vertices.tobytes("A")
    assert back[0].vertices.flags.f_contiguous
    assert type(back[2]["a"][0]) is np.float64
    assert repr(back[2]) == repr(value[2])
    assert back[3] == text
    assert back[3].parts == text.parts
    assert back[4] == b"\0\xff"
    assert to_bytes(back) == to_bytes(value)


def test_nothing_that_is_no_value_of_this_program_is_made() -> None:
    with pytest.raises(CodecError, match="cannot be kept"):
        to_bytes(lambda: 0)
    plan = {"c": "subprocess:Popen", "i": 0, "v": {}}
    whole = to_bytes("x")
    for name in ("subprocess:Popen", "os:system", "autobalance.disk_cache:kept"):
        forged = json.dumps({**plan, "c": name}).encode()
        with np.load(io.BytesIO(whole)) as archive:
            assert archive.files == ["plan"]
        stream = io.BytesIO()
        np.savez(stream, plan=np.frombuffer(forged, np.uint8))
        with pytest.raises(CodecError):
            from_bytes(stream.getvalue())
    objects = io.BytesIO()
    np.savez(objects, plan=np.array([object()], dtype=object))
    with pytest.raises(CodecError):
        from_bytes(objects.getvalue())


def test_a_file_that_was_changed_is_read_anew(tmp_path: Path, cache: Path) -> None:
    job = jobs.pin_job(tmp_path)
    first = ab.read_crank(tmp_path / "crank-with-pin.stl", unit="mm")
    data = (tmp_path / "crank-with-pin.stl").read_bytes()
    (tmp_path / "crank-with-pin.stl").write_bytes(b"another header".ljust(80) + data[80:])
    again = ab.read_crank(tmp_path / "crank-with-pin.stl", unit="mm")
    assert again.mass_g == first.mass_g
    assert sum(name.startswith("source") for name in entries(cache)) == 2
    in_inches = ab.read_crank(tmp_path / "crank-with-pin.stl", unit="inch")
    assert in_inches.mass_g == pytest.approx(first.mass_g * 25.4**3, rel=1e-9)
    assert job.exists()


def test_a_kept_solid_is_cut_alike_whether_it_or_the_tool_was_built_first() -> None:
    """A study of a report and of its job differed in the last digits: one looked at the crank before."""
    low, high = np.zeros(3), np.array([40.0, 30.0, 20.0])
    plain = (Solid.box(low, high) - Solid.box(low + 5.0, high + 5.0)).to_plain()
    cut = []
    for first in (True, False):
        solid = Solid.from_plain(plain)
        if first:
            assert not solid.section(10.0).is_empty
        tool = Solid.box(low + 1.0, high - 11.0)
        cut.append((solid - tool).mesh)
    np.testing.assert_array_equal(cut[0].vertices, cut[1].vertices)
    np.testing.assert_array_equal(cut[0].triangles, cut[1].triangles)


def test_what_was_just_computed_is_laid_out_as_its_entry_is() -> None:
    """Sums depend on it in their last digits: no view of a table's column, no fixed bytes."""
    table = np.arange(12.0).reshape(4, 3)
    fixed = np.frombuffer(bytes(16), np.uint8)
    arrays = (table, table.T, table[:, 1], table[::-1], fixed, np.asfortranarray(table)[:, :2])
    at_once, from_entry = value_of(plain_of(arrays)), from_bytes(to_bytes(arrays))
    for given, one, other in zip(arrays, at_once, from_entry, strict=True):
        assert np.array_equal(given, one)
        assert (one.strides, one.flags.writeable) == (other.strides, other.flags.writeable)
    assert at_once[0] is table
