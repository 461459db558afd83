"""A typed axis, journal or crankpin that the file contradicts is told with both numbers, or refused."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank.anatomy import Anatomy, Overrides, PinHint
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import RecognitionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from tests.coarse import coarse_facets
from tests.cranks import tilted
from tests.generated import generated_crank
from tests.odd_cranks import odd_crank
from tests.read_once import read_once

PLACE = tilted(0.7, (40.0, -25.0, 90.0))
EXACT_MM = 2e-4
Hints = dict[str, Any]


def _point(to_file: Any, point: Sequence[float]) -> list[float]:
    return [float(value) for value in to_file[:3, :3] @ np.asarray(point) + to_file[:3, 3]]


def _typed(pins: Sequence[Any], to_file: Any) -> list[Hints]:
    return [
        {
            "centre_mm": _point(to_file, pin.centre_mm),
            "diameter_mm": float(pin.diameter_mm),
            "width_mm": float(pin.width_mm),
        }
        for pin in pins
    ]


class Case:
    """A crank's mesh, and its journals and crankpins as a person would type them, in its file's axes."""

    def __init__(self, vertices: Any, triangles: Any, truth: Anatomy) -> None:
        self.vertices, self.triangles, self.truth = vertices, triangles, truth
        self.to_file = truth.rotor_to_file
        self.mains = _typed(truth.main_journals, self.to_file)
        self.pins = _typed([throw.crankpin for throw in truth.throws], self.to_file)

    def read(self, **hints: Any) -> ab.Crank:
        return ab.crank_from_mesh(self.vertices, self.triangles, density_kg_m3=7850.0, **hints)

    def moved(self, hints: Sequence[Hints], number: int, by: Sequence[float], **other: Any) -> list[Hints]:
        """Return hints, one of which is moved in the rotor frame or otherwise changed."""
        new = [dict(hint) for hint in hints]
        off = self.to_file[:3, :3] @ np.array(by)
        new[number]["centre_mm"] = [float(v) for v in np.array(new[number]["centre_mm"]) + off]
        new[number].update(other)
        return new

    @property
    def all_off(self) -> list[Hints]:
        return self.moved(self.moved(self.mains, 0, (0.2, 0.0, 0.0)), 1, (0.2, 0.0, 0.0))

    def axis(self, by: Sequence[float] = (0.0, 0.0, 0.0), lean_deg: float = 0.0) -> Hints:
        lean = math.radians(lean_deg)
        direction = self.to_file[:3, :3] @ np.array([math.sin(lean), 0.0, math.cos(lean)])
        return {"axis_point_mm": _point(self.to_file, by), "axis_direction": [float(v) for v in direction]}


@lru_cache(maxsize=8)
def case(name: str, segments: int = 24) -> Case:
    made = generated_crank(name, segments=segments, placement=PLACE)
    return Case(made.mesh.vertices, made.mesh.triangles, made.truth)


@lru_cache(maxsize=1)
def scan() -> Case:
    """A fine mesh of a crank whose every corner was moved by noise of 0.02 mm."""
    fine = case("single", 150)
    noise = np.random.default_rng(3).normal(0.0, 0.02, fine.vertices.shape)
    return Case(fine.vertices + noise, fine.triangles, fine.truth)


def _both(made: Case, **other: Any) -> Hints:
    return {"main_journals": made.mains, "crankpins": made.pins} | other


def _main(number: int, by: Sequence[float] = (0.0, 0.0, 0.0), **other: Any) -> Callable[[Case], Hints]:
    return lambda made: _both(made, main_journals=made.moved(made.mains, number, by, **other))


def _pin(number: int, by: Sequence[float] = (0.0, 0.0, 0.0), **other: Any) -> Callable[[Case], Hints]:
    return lambda made: _both(made, crankpins=made.moved(made.pins, number, by, **other))


def _alone(key: str, number: int, by: Sequence[float]) -> Callable[[Case], Hints]:
    hints = {"crankpins": "pins", "main_journals": "mains"}[key]
    return lambda made: {key: made.moved(getattr(made, hints), number, by)}


TOLD: list[tuple[str, str, Callable[[Case], Hints], list[str]]] = [
    ("axis 0.5 mm off", "single", lambda made: made.axis((0.5, 0.0, 0.0)), ["0.5 mm", "⌀30"]),
    ("axis 0.05 mm off", "single", lambda made: made.axis((0.0, 0.05, 0.0)), ["0.05 mm", "⌀30"]),
    ("axis leans a little", "inline-4", lambda made: made.axis(lean_deg=0.01), ["⌀54", "axis_direction"]),
    ("axis and journals", "single", lambda m: _both(m, **m.axis((0.3, 0.4, 0.0))), ["0.5 mm", "⌀30"]),
    ("axis of a v8 off", "v8-crossplane", lambda made: made.axis((0.0, 0.3, 0.0)), ["0.3 mm", "⌀62"]),
    ("journal 0.5 mm off", "inline-4", _main(0, (0.5, 0.0, 0.0)), ["0.5 mm", "⌀54"]),
    ("middle journal 0.5 mm off", "inline-4", _main(2, (0.0, 0.5, 0.0)), ["0.5 mm", "⌀54"]),
    ("all journals off", "single", lambda made: _both(made, main_journals=made.all_off), ["0.2 mm", "⌀30"]),
    ("journal 2 mm along", "single", _main(0, (0.0, 0.0, 2.0)), ["2 mm", "along"]),
    ("journal of twice its diameter", "single", _main(0, diameter_mm=60.0), ["⌀60", "⌀30"]),
    ("journal of half its diameter", "inline-4", _main(1, diameter_mm=27.0), ["⌀27", "⌀54"]),
    ("journal 0.2 mm thicker", "single", _main(1, diameter_mm=30.2), ["⌀30.2", "⌀30 "]),
    ("journal 0.6 % thicker", "single", _main(1, diameter_mm=30.18), ["⌀30.18", "⌀30 "]),
    ("journals alone", "inline-4", _alone("main_journals", 0, (0.1, 0.0, 0.0)), ["0.1 mm", "⌀54"]),
    ("pin 5 mm off", "single", _pin(0, (5.0, 0.0, 0.0)), ["5 mm", "⌀32"]),
    ("pin 5 mm off alone", "single", _alone("crankpins", 0, (5.0, 0.0, 0.0)), ["5 mm", "⌀32"]),
    ("pin aside by 0.1 mm", "v8-crossplane", _pin(2, (0.0, 0.1, 0.0)), ["0.1 mm", "⌀53"]),
    ("pin along by 3 mm", "inline-4", _pin(1, (0.0, 0.0, 3.0)), ["3 mm", "along"]),
    ("pin of 60 for 32 mm", "single", _pin(0, diameter_mm=60.0), ["⌀60", "⌀32"]),
    ("pin 0.3 mm thinner", "inline-4", _pin(3, diameter_mm=47.7), ["⌀47.7", "⌀48"]),
]  # fmt: skip
REFUSED: list[tuple[str, str, Callable[[Case], Hints], str]] = [
    ("journal in a web", "single", _main(0, (0.0, 0.0, 20.0)), "30 mm"),
    ("journal in a web of a v8", "v8-crossplane", _main(2, (0.0, 0.0, 25.0)), "62 mm"),
    ("journal beside the crank", "single", _main(1, (0.0, 40.0, 0.0)), "30 mm"),
    ("pin on the other side", "single", _pin(0, (-58.0, 0.0, 0.0)), "30 mm"),
    ("pin where a journal is", "inline-4", _pin(1, (0.0, 0.0, -44.0)), "48 mm"),
    ("pin beyond the crank", "single", _pin(0, (0.0, 0.0, 300.0)), "30 mm"),
]


@pytest.mark.parametrize(("name", "hints", "words"), [each[1:] for each in TOLD], ids=[t[0] for t in TOLD])
def test_what_the_file_contradicts_is_told_with_both_numbers(
    name: str, hints: Callable[[Case], Hints], words: list[str]
) -> None:
    made = case(name)
    warnings = made.read(**hints(made)).warnings
    told = [text for text in warnings if re.match(r"(axis_|main_journals\[|crankpins\[)", text)]
    assert any(all(word in text for word in words) and "g·mm" in text for text in told), warnings


@pytest.mark.parametrize(
    ("name", "hints", "word"), [each[1:] for each in REFUSED], ids=[r[0] for r in REFUSED]
)
def test_where_the_file_has_nothing_the_nearest_is_named(
    name: str, hints: Callable[[Case], Hints], word: str
) -> None:
    made = case(name)
    with pytest.raises(RecognitionError, match=r"covers a quarter of it; .*the nearest") as refused:
        made.read(**hints(made))
    assert f"has {word} at [" in str(refused.value).partition("the nearest")[2]


LEFT_OUT: list[tuple[str, str, int | None, int | None, list[str]]] = [
    ("middle journal", "inline-4", 1, None, ["main_journals", "web 2", "44 mm from crankpin 1", "⌀54 mm"]),
    ("last journal", "inline-3", -1, None, ["main_journals", "web 6", "220 mm from crankpin 1", "⌀54 mm"]),
    ("journal beside typed pins", "parallel-twin-360", 1, -2, ["web 2", "44 mm from crankpin 1", "⌀44 mm"]),
    ("crankpin", "v8-crossplane", None, 1, ["crankpins", "web 2", "114 mm from crankpin 1", "⌀53 mm"]),
]
"""What a job leaves out: a main journal and a crankpin (-2: all are typed), and the words of the warning."""


@pytest.mark.parametrize(
    ("name", "main", "pin", "words"), [each[1:] for each in LEFT_OUT], ids=[each[0] for each in LEFT_OUT]
)
def test_a_cylinder_that_a_job_leaves_out_is_told(
    name: str, main: int | None, pin: int | None, words: list[str]
) -> None:
    """It was metal of a web that reaches over it, and three webs were one, without a word."""
    made = case(name)
    hints: Hints = {}
    for key, all_of, left in (("main_journals", made.mains, main), ("crankpins", made.pins, pin)):
        if left is not None:
            gone = None if left == -2 else left % len(all_of)
            hints[key] = [hint for number, hint in enumerate(all_of) if number != gone]
    warnings = made.read(**hints).warnings
    (text,) = [text for text in warnings if all(word in text for word in words)]
    assert f"add it to {'crankpins' if main is None else 'main_journals'} if it is one" in text


@pytest.mark.parametrize("seed", [12, 58])
def test_a_fillet_that_touches_a_typed_end_does_not_hide_the_cylinder(seed: int) -> None:
    """True journals were refused: of the triangles that end there by a file's digits, all corners counted."""
    odd = odd_crank(seed)
    truth = odd.truth()
    hints = [
        PinHint(np.array(hint["centre_mm"]), hint["diameter_mm"], hint["width_mm"])
        for hint in _typed(truth.main_journals, np.linalg.inv(truth.file_to_rotor))
    ]
    found = recognise(odd.source().solid, Overrides(main_journals=tuple(hints))).typed
    assert found.main_journals is not None
    for each, journal in zip(found.main_journals, truth.main_journals, strict=True):
        assert each is not None
        assert each.diameter_mm == pytest.approx(journal.diameter_mm, abs=1e-3)
        assert each.offset_mm == pytest.approx(0.0, abs=1e-3)
    assert found.left_out == ()


@pytest.mark.parametrize("key", ["main_journals", "crankpins"])
@pytest.mark.parametrize("name", ["single", "inline-4", "v6-60"])
def test_nothing_is_left_out_by_all_journals_or_all_crankpins(name: str, key: str) -> None:
    made = case(name)
    assert made.read(**{key: made.mains if key == "main_journals" else made.pins}).warnings == ()


@pytest.mark.parametrize("name", ["single", "inline-4", "v8-crossplane"])
def test_what_agrees_changes_nothing_else(name: str) -> None:
    made = case(name)
    plain, typed = made.read(), made.read(**_both(made))
    reports = [ab.inspect(crank).report["crank"] for crank in (plain, typed)]
    assert typed.warnings == plain.warnings == ()
    truth = made.truth
    for report, is_typed in zip(reports, (False, True), strict=True):
        pairs = [
            *zip(report["main_journals"], truth.main_journals, strict=True),
            *zip((t["crankpin"] for t in report["throws"]), (t.crankpin for t in truth.throws), strict=True),
        ]
        for entry, pin in pairs:
            assert entry["typed"] is is_typed
            if not is_typed:
                assert entry["found"] is None
                continue
            assert entry["found"]["z_mm"] == pytest.approx(pin.centre_mm[2], abs=EXACT_MM)
            assert entry["found"]["diameter_mm"] == pytest.approx(pin.diameter_mm, abs=EXACT_MM)
            assert entry["found"]["offset_mm"] == pytest.approx(0.0, abs=EXACT_MM)
    assert reports[0]["axis"] == {"typed": False, "found": None}
    for key in ("mass_g", "centre_of_mass_mm", "polar_inertia_kg_mm2"):
        assert reports[0][key] == pytest.approx(reports[1][key], rel=1e-6, abs=1e-4)


def test_numbers_in_the_report_are_the_files() -> None:
    made = case("single")
    hints = _both(made, main_journals=made.moved(made.mains, 1, (0.3, 0.4, 0.0), diameter_mm=31.0))
    journal = ab.inspect(made.read(**hints, **made.axis())).report["crank"]["main_journals"][1]
    assert journal["typed"] is True
    assert journal["diameter_mm"] == pytest.approx(31.0)
    assert journal["found"] == {
        "z_mm": pytest.approx(made.truth.main_journals[1].centre_mm[2], abs=EXACT_MM),
        "diameter_mm": pytest.approx(30.0, abs=EXACT_MM),
        "offset_mm": pytest.approx(0.5, abs=EXACT_MM),
    }


def test_an_axis_off_costs_mass_times_offset() -> None:
    made = case("single")
    crank = made.read(**made.axis((0.0, 0.5, 0.0)))
    (text,) = [text for text in crank.warnings if text.startswith("axis_point_mm")]
    told = float(re.search(r": ([\d.e+]+) g·mm", text).group(1))  # type: ignore[union-attr]
    assert told == pytest.approx(0.5 * crank.mass_g, rel=5e-3)
    found = ab.inspect(crank).report["crank"]["axis"]["found"]
    assert found["offset_mm"] == pytest.approx(0.5, abs=EXACT_MM)
    assert found["diameter_mm"] == pytest.approx(30.0, abs=EXACT_MM)
    assert ab.inspect(crank).report["crank"]["journal_misalignment_mm"] == pytest.approx(0.5, abs=EXACT_MM)


def test_journals_off_the_axis_are_not_called_within_nothing_of_it() -> None:
    made = case("inline-4")
    hints = _both(made, main_journals=made.moved(made.mains, 2, (0.0, 0.7, 0.0)), **made.axis())
    report = ab.inspect(made.read(**hints)).report["crank"]
    assert report["main_journals"][2]["found"]["offset_mm"] == pytest.approx(0.7, abs=EXACT_MM)
    assert report["journal_misalignment_mm"] == pytest.approx(0.0, abs=EXACT_MM)  # the file's are on the axis


def test_a_scan_is_compared_within_three_times_its_roughness() -> None:
    made = scan()
    within = made.read(**_both(made, main_journals=made.moved(made.mains, 0, (0.04, 0.0, 0.0))))
    assert not [text for text in within.warnings if "main_journals[" in text]
    beyond = made.read(**_both(made, main_journals=made.moved(made.mains, 0, (0.3, 0.0, 0.0))))
    (text,) = [text for text in beyond.warnings if "main_journals[0]" in text]
    found = ab.inspect(beyond).report["crank"]["main_journals"][0]["found"]
    assert "across the axis" in text
    assert found["offset_mm"] == pytest.approx(0.3, abs=0.02)


def test_true_surfaces_are_compared_as_well(tmp_path: Path) -> None:
    file = tmp_path / "crank.step"
    file.write_bytes(ab.generate("single", file="crank.step").data)
    with coarse_facets(), read_once():
        crank = ab.read_crank(file)
        to_file = np.linalg.inv(crank.file_to_rotor)
        mains = _typed(crank.main_journals, to_file)
        pins = _typed([throw.crankpin for throw in crank.throws], to_file)
        assert ab.read_crank(file, main_journals=mains, crankpins=pins).warnings == ()
        mains[0]["centre_mm"][0] += 0.5
        typed = ab.read_crank(file, main_journals=mains, crankpins=pins)
    assert any("main_journals[0]" in text and "0.5 mm off" in text for text in typed.warnings)


@pytest.mark.parametrize(
    ("hints", "words"),
    [
        (lambda made: made.axis(lean_deg=0.5), ["axis_direction leans by 0.5°"]),
        (_alone("main_journals", 0, (3.0, 0.0, 0.0)), ["main_journals[0]", "has 54 mm", "3 mm away"]),
    ],
    ids=["axis", "journals"],
)
def test_a_refusal_for_what_was_typed_says_so(hints: Callable[[Case], Hints], words: list[str]) -> None:
    made = case("inline-4", 48)
    with pytest.raises(RecognitionError, match=r"contradicts the file|covers a quarter") as refused:
        made.read(**hints(made))
    assert all(word in str(refused.value) for word in words), refused.value


def _disc(radius: float, low: float, high: float, x: float = 0.0) -> Solid:
    return Solid.prism(Region.circle(radius, 64, (x, 0.0)), low, high)


def test_bores_are_what_is_typed_of_a_web_alone() -> None:
    """One web of a built-up crank: the typed journal and crankpin are its bores, one of them 0.7 mm off."""
    web = union([_disc(30.0, 0.0, 12.0), _disc(18.0, 0.0, 12.0, 25.0)])
    web = web - _disc(10.0, -1.0, 13.0) - _disc(7.0, -1.0, 13.0, 25.0)
    hints: Hints = {
        "axis_direction": [0.0, 0.0, 1.0],
        "main_journals": [{"centre_mm": [0.5, 0.5, 6.0], "diameter_mm": 20.0, "width_mm": 12.0}],
        "crankpins": [{"centre_mm": [25.0, 0.0, 6.0], "diameter_mm": 14.0, "width_mm": 12.0}],
        "crankpin_in_file": False,
    }
    mesh = web.mesh
    crank = ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850.0, **hints)
    report = ab.inspect(crank).report["crank"]
    assert report["main_journals"][0]["found"]["offset_mm"] == pytest.approx(
        math.hypot(0.5, 0.5), abs=EXACT_MM
    )
    assert report["throws"][0]["crankpin"]["found"]["diameter_mm"] == pytest.approx(14.0, abs=EXACT_MM)
    assert any("bore" in text and "0.707 mm" in text for text in crank.warnings)


def test_a_crankpin_that_is_not_in_the_file_is_compared_with_its_bores() -> None:
    halves = []
    for side in (-1.0, 1.0):
        parts = [
            _disc(45.0, *sorted((8.0 * side, 28.0 * side))),
            _disc(12.5, *sorted((28.0 * side, 70.0 * side))),
        ]
        halves.append(union(parts) - _disc(10.0, -40.0, 40.0, 25.0))
    mesh = union(halves).mesh
    pin = {"centre_mm": [25.4, 0.0, 0.0], "diameter_mm": 20.0, "width_mm": 16.0}
    crank = ab.crank_from_mesh(
        mesh.vertices,
        mesh.triangles,
        density_kg_m3=7850.0,
        crankpins=[pin],
        crankpin_in_file=False,
        body="all",
    )
    found = ab.inspect(crank).report["crank"]["throws"][0]["crankpin"]["found"]
    assert found["offset_mm"] == pytest.approx(0.4, abs=EXACT_MM)
    assert any("crankpins[0]" in text and "bore" in text for text in crank.warnings)


def test_a_jobs_warning_has_the_share_of_the_permissible_value(tmp_path: Path) -> None:
    (tmp_path / "crank.stl").write_bytes(ab.generate("single", file="crank.stl", segments=48).data)
    job = tmp_path / "job.toml"
    job.write_text(
        """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
axis_point_mm = [0.5, 0.0, 0.0]
axis_direction = [0.0, 0.0, 1.0]
[engine.rotating_g]
rod = 200.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 6000
[correction]
method = "drill"
"""
    )
    result = ab.inspect(job)
    (text,) = [text for text in result.warnings if "axis_point_mm and axis_direction: " in text]
    assert "--axis-point" not in text
    permissible = float(re.search(r"permissible ([\d.]+) g·mm", text).group(1))  # type: ignore[union-attr]
    times = float(re.search(r"([\d.]+) times", text).group(1))  # type: ignore[union-attr]
    mass = result.report["crank"]["mass_g"] + 200.0 + 0.5 * 300.0
    assert times == pytest.approx(0.5 * mass / permissible, rel=0.05)


def test_options_are_named_where_there_is_no_job() -> None:
    made = case("single")
    texts = made.read(**made.axis((0.5, 0.0, 0.0))).warnings
    assert any("--axis-point" in text and "--axis-direction" in text for text in texts)


def test_the_crank_itself_is_not_changed_by_what_is_found() -> None:
    """The typed statement stands: the file is told, not obeyed."""
    made = case("single")
    typed = made.read(**_pin(0, (5.0, 0.0, 0.0))(made)).throws[0]
    assert typed.crank_radius_mm == pytest.approx(34.0, abs=1e-6)
    assert replace(typed).crankpin.diameter_mm == pytest.approx(32.0)
