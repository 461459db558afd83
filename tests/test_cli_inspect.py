"""``inspect``: what it measures on the bundled cranks, and what it writes."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import autobalance as ab
from autobalance.report.balance.values import schema
from autobalance.solid.csg.solid import Solid
from tests import jobs
from tests.coarse import bundled_corners
from tests.generated import generated_crank

WITH_PIN = jobs.BUNDLED / "straight" / "crank-with-pin.stl"
HALVES = jobs.BUNDLED / "drafted" / "crank.stl"


@pytest.fixture(scope="module")
def halves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in fewer facets."""
    file = tmp_path_factory.mktemp("halves") / "halves.stl"
    jobs.write_stl(file, bundled_corners())
    return file


def test_published_mass_properties(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """CRF-09: 2.700 kg and 2847.335 kg·mm² with the pin; facets take 0.07 g and 0.15 kg·mm²."""
    target = tmp_path / "new" / "inspect.json"
    assert jobs.run("inspect", WITH_PIN, "--unit", "mm", "--json", target) == 0
    report = json.loads(target.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema()).validate(report)
    crank = report["crank"]
    assert crank["mass_g"] == pytest.approx(2700.0, abs=0.1)
    assert crank["polar_inertia_kg_mm2"] == pytest.approx(2847.335, abs=0.2)
    assert [throw["crank_radius_mm"] for throw in crank["throws"]] == [pytest.approx(26.9, abs=1e-3)]
    assert crank["throws"][0]["angle_deg"] == pytest.approx(0.0, abs=1e-6)
    assert [journal["diameter_mm"] for journal in crank["main_journals"]] == [
        pytest.approx(28.0, abs=1e-3)
    ] * 2
    assert [web["counterweight"] for web in crank["webs"]] == [True, True]
    rims = [web["outline"]["rim_radius_mm"] for web in crank["webs"]]
    assert rims == pytest.approx([51.3812] * 2, abs=1e-3)
    assert report["command"] == "inspect"
    assert report["job"] is None
    printed = capsys.readouterr()
    assert "mm 26.900 mm 0.00°" in " ".join(printed.out.split())
    assert "radius 51.381 mm 179." in " ".join(printed.out.split())
    assert printed.err == ""


def test_faces_are_best_first_and_in_the_files_coordinates(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", HALVES, "--no-crankpin", "--unit", "mm", "--json", "-") == 0
    report = json.loads(capsys.readouterr().out)
    faces = report["faces"]
    worth = [float(np.hypot(*face["unbalance_per_mm_g_mm"])) for face in faces]
    assert worth == sorted(worth, reverse=True)
    frame = np.array(report["frame"]["file_to_rotor"])
    for face in faces:
        place = frame[:3, :3] @ np.array(face["file_centroid_mm"]) + frame[:3, 3]
        assert place == pytest.approx(np.array(face["centroid_mm"]), abs=1e-9)
        offset = -7.85e-3 * face["area_mm2"] * np.array(face["centroid_mm"][:2])
        assert face["unbalance_per_mm_g_mm"] == pytest.approx(offset, rel=1e-9, abs=1e-9)
    # the shoulders: a drafted first moment of 85 800 mm³, and 4.442 mm high
    shoulders = [face for face in faces if face["max_depth_mm"] == pytest.approx(4.442, abs=1e-3)]
    assert [abs(face["unbalance_per_mm_g_mm"][0]) for face in shoulders] == [
        pytest.approx(7.85e-3 * 85_800.0, rel=1e-3)
    ] * 2


def test_a_unit_that_is_not_said_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", WITH_PIN) == 0
    assert "STL has no unit: taken as mm" in capsys.readouterr().err


def test_several_bodies_are_listed(halves: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", halves, "--unit", "mm", "--crankpin-in-file", "yes") == 3
    error = capsys.readouterr().err
    assert "holds 2 bodies" in error
    assert "no crank" not in error
    assert "--body N, --body all, or --no-crankpin" in error


def test_the_halves_of_a_pressed_up_crank_are_found_out(
    halves: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Told or not told that the crankpins are missing, the same crank; and it is said."""
    reports = []
    for option in ([], ["--no-crankpin"]):
        assert jobs.run("inspect", halves, "--unit", "mm", *option, "--json", "-") == 0
        printed = capsys.readouterr()
        reports.append(json.loads(printed.out))
        assert ("2 bodies taken together: the pieces of a pressed-up crank" in printed.err) is not bool(
            option
        )
    assert reports[0]["crank"] == reports[1]["crank"]
    assert reports[0]["input"]["repairs"][-1].startswith("2 bodies taken together")
    alone = ab.read_crank(halves, unit="mm")
    assert alone.mass_g == reports[0]["crank"]["mass_g"]


def test_two_cranks_side_by_side_are_one_short_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    crank = generated_crank("single").solid.mesh.corners
    jobs.write_stl(tmp_path / "two.stl", np.concatenate([crank, crank + np.array([200.0, 0.0, 0.0])]))
    assert jobs.run("inspect", tmp_path / "two.stl", "--unit", "mm") == 3
    error = capsys.readouterr().err.replace(str(tmp_path), "")
    assert "holds 2 bodies" in error
    assert "together they are not a crank" in error
    assert len(error) <= 500


def test_several_bodies_that_are_no_crank_are_told_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plate = Solid.box(np.zeros(3), np.array([40.0, 30.0, 2.0])).mesh.corners
    jobs.write_stl(tmp_path / "plates.stl", np.concatenate([plate, plate + np.array([0.0, 0.0, 10.0])]))
    assert jobs.run("inspect", tmp_path / "plates.stl", "--unit", "mm") == 3
    error = capsys.readouterr().err
    assert "holds 2 bodies" in error
    assert "together they are not a crank: no main journals found (" in error
    assert error.count("\n") == 1
    assert jobs.run("inspect", tmp_path / "plates.stl", "--unit", "mm", "--body", "1") == 3
    assert "plates.stl: no main journals found: the part has no bare cylinder" in capsys.readouterr().err


def test_a_missing_crank_leaves_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        jobs.run("inspect", tmp_path / "no.stl", "--unit", "mm", "--json", tmp_path / "new" / "x.json") == 3
    )
    assert "does not exist" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_sections_and_counterweights_add_up(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", HALVES, "--unit", "mm", "--no-crankpin", "--json", "-") == 0
    report = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator(schema()).validate(report)
    parts = report["sections"]
    assert sum(part["mass_g"] for part in parts) == pytest.approx(report["crank"]["mass_g"], rel=1e-12)
    unbalance = np.sum([part["unbalance_g_mm"] for part in parts], axis=0)
    assert unbalance == pytest.approx(report["initial"]["unbalance_g_mm"], abs=1e-6)
    moment = np.sum([part["moment_g_mm2"] for part in parts], axis=0)
    assert moment == pytest.approx(report["initial"]["moment_g_mm2"], abs=1e-4)
    each, other, both = report["counterweights"]
    assert (each["web"], other["web"], both["web"]) == (1, 2, None)
    assert both["mass_g"] == pytest.approx(2020.40, abs=0.07)
    assert both["radius_mm"] == pytest.approx(6.16, abs=0.001)
    assert both["product_g_mm"] == pytest.approx(each["product_g_mm"] + other["product_g_mm"], rel=1e-12)


def test_the_table_of_sections_is_printed_when_asked(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", WITH_PIN, "--unit", "mm") == 0
    assert "Section" not in capsys.readouterr().out
    assert jobs.run("inspect", WITH_PIN, "--unit", "mm", "--sections") == 0
    printed = capsys.readouterr().out
    assert "main journal 2" in printed
    assert "counterweight 1" in printed
    assert "m_cw" in printed


def test_the_picture_is_a_png(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "new" / "crank.png"
    assert jobs.run("inspect", WITH_PIN, "--unit", "mm", "--picture", target) == 0
    data = target.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert (int.from_bytes(data[16:20]), int.from_bytes(data[20:24])) == (1200, 800)
    assert capsys.readouterr().err == ""


def test_a_picture_must_not_overwrite_the_crank(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crank = tmp_path / "crank.stl"
    crank.write_bytes(WITH_PIN.read_bytes())
    assert jobs.run("inspect", crank, "--unit", "mm", "--picture", crank) == 2
    assert "would overwrite the crank file" in capsys.readouterr().err
    assert crank.read_bytes() == WITH_PIN.read_bytes()


def test_the_axis_and_the_crankpin_can_be_said_on_the_command_line(
    halves: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("inspect", halves, "--unit", "mm", "--crankpin-in-file", "no", "--json", "-") == 0
    found = json.loads(capsys.readouterr().out)
    frame = np.array(found["frame"]["file_to_rotor"])
    back = np.linalg.inv(frame)
    axis = [*("--axis-point", *map(repr, back[:3, 3].tolist())), *("--axis-direction", "0", "0", "1")]
    assert frame[2, :3] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert jobs.run("inspect", halves, "--unit", "mm", *axis, "--crankpin-in-file", "no", "--json", "-") == 0
    again = json.loads(capsys.readouterr().out)
    assert np.array(again["frame"]["file_to_rotor"]) == pytest.approx(frame, abs=1e-4)
    assert jobs.run("inspect", halves, "--unit", "mm", "--crankpin-in-file", "yes") == 3
