"""``autobalance generate`` from the command line to the files."""

import json
import shutil
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import autobalance as ab
from autobalance.command import main
from autobalance.drawn_cranks.command import PRESET_NAMES
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.input import read_design
from autobalance.solid.cad.files import read_step_file
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import properties
from autobalance.solid.formats.read import read
from autobalance.verbs.result import scalars
from autobalance.verbs.schema import schema

EXAMPLES = Path(__file__).parents[2] / "examples"
EXTRAPOLATED = 1e-5  # the command extrapolates from 64 segments


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def report(*arguments: str) -> dict[str, Any]:
    assert main(["generate", *arguments, "--json", "report.json"]) == 0
    values: dict[str, Any] = json.loads(Path("report.json").read_text(encoding="utf-8"))
    return values


def test_a_preset_becomes_a_file_and_a_summary(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", "single", "--segments", "32"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    for text in ("single.stl", "stroke 58.000 mm", "mass 1857.2", "Unbalance of the bare crank", "throw 1"):
        assert text in said.out
    source = read(Path("single.stl"), "mm", None, pressed_up=False)
    assert source.solid.volume_mm3 == pytest.approx(236_586.0, rel=0.01)  # with 32 segments a circle


def test_the_report_tells_the_file_from_the_true_crank() -> None:
    values = report("single", "-o", "a.stl", "--segments", "64")
    solid = read(Path("a.stl"), "mm", None, pressed_up=False).solid
    here = solid.moments(7.85e-3)
    crank = values["crank"]
    assert crank["facet_error"]["mass_g"] == pytest.approx(crank["mass_g"] - here.mass_g, abs=1e-3)
    assert values["initial"]["magnitude_g_mm"] - np.linalg.norm(here.first_g_mm[:2]) == pytest.approx(
        crank["facet_error"]["unbalance_g_mm"], rel=0.01
    )
    assert values["outputs"]["solid"]["triangles"] == solid.triangle_count
    finer = report("single", "-o", "a.stl", "--segments", "256")["crank"]
    assert finer["mass_g"] == pytest.approx(crank["mass_g"], rel=EXTRAPOLATED)
    assert finer["facet_error"]["mass_g"] < crank["facet_error"]["mass_g"] / 12.0


@pytest.mark.parametrize(("ending", "unit"), [("stl", "inch"), ("obj", "m"), ("ply", "cm"), ("3mf", "mm")])
def test_every_format_and_unit_holds_the_same_crank(ending: str, unit: str) -> None:
    values = report("pressed-up-single", "-o", f"a.{ending}", "--unit", unit)
    carried = None if ending == "3mf" else unit
    source = read(Path(f"a.{ending}"), carried, None, pressed_up=False)
    facets = values["crank"]["facet_error"]["mass_g"]
    assert source.solid.moments(7.85e-3).mass_g == pytest.approx(values["crank"]["mass_g"] - facets, rel=1e-6)


def test_settings_change_dimensions() -> None:
    before = report("inline-4", "--segments", "16")
    after = report(
        "inline-4", "--segments", "16", "--set", "counterweight.radius_mm=76", "--set", "name=heavy"
    )
    assert after["design"]["counterweight"]["radius_mm"] == 76.0
    assert after["outputs"]["solid"]["file"] == "heavy.stl"
    assert after["crank"]["polar_inertia_kg_mm2"] > before["crank"]["polar_inertia_kg_mm2"]
    pairs = list(zip(after["crank"]["webs"], before["crank"]["webs"], strict=True))
    assert [web["number"] for web, _ in pairs] == list(range(1, 9))
    assert all(abs(a[key] - b[key]) < 1e-6 for a, b in pairs for key in ("z_min_mm", "z_max_mm"))


def test_a_reported_design_is_a_description_again() -> None:
    design = report("v6-60", "--segments", "12")["design"]
    rebuilt, _ = read_design(_toml(design), "again.toml")
    assert rebuilt.bays == PRESETS["v6-60"].bays
    assert rebuilt.segments == 12


def _toml(value: dict[str, Any]) -> str:
    """Only what a design holds: inline tables all the way down."""

    def inline(item: Any) -> str:
        if isinstance(item, dict):
            return "{" + ", ".join(f"{key} = {inline(each)}" for key, each in item.items()) + "}"
        if isinstance(item, list):
            return "[" + ", ".join(inline(each) for each in item) + "]"
        return json.dumps(item)

    return "\n".join(f"{key} = {inline(item)}" for key, item in value.items())


def test_the_balance_factor_is_that_of_the_source() -> None:
    """One throw: f = (m_cw r′/r − m_rot)/m_rec, with m_cw r′ all of the crank's unbalance."""
    shutil.copy(EXAMPLES / "motocross.toml", "m.toml")
    values = report("m.toml")
    product = values["initial"]["magnitude_g_mm"]
    factor = (product / 26.9 - 248.69) / 261.5
    assert values["engine"]["balance_factor"] == pytest.approx(factor, rel=1e-5)
    assert values["engine"]["bob_weights"][0]["mass_g"] == pytest.approx(product / 26.9, rel=1e-5)


def test_throws_that_cancel_have_no_factor(capsys: pytest.CaptureFixture[str]) -> None:
    Path("i4.toml").write_text('preset = "inline-4"\nsegments = 12\nengine.reciprocating_g.piston = 400.0\n')
    assert main(["generate", "i4.toml"]) == 0
    assert "no balance factor: the throws cancel each other out" in capsys.readouterr().out


def test_json_to_standard_output_is_all_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", "single", "--segments", "12", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["command"] == "generate"


@pytest.mark.slow
@pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
def test_a_step_file_has_exact_surfaces(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", "pressed-up-single-no-pin", "-o", "a.step"]) == 0
    assert "exact surfaces" in capsys.readouterr().out
    text = Path("a.step").read_text(encoding="utf-8")
    assert text.startswith("ISO-10303-21;")
    assert text.count("MANIFOLD_SOLID_BREP(") == 2
    assert "CYLINDRICAL_SURFACE" in text
    assert ".MILLI.,.METRE." in text


@pytest.mark.slow
@pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
def test_the_volume_told_is_that_of_the_step_file() -> None:
    """It was that of a fine tessellation, 4e-6 off where there are fillets."""
    made = ab.generate("single", file="a.step")
    (body,) = read_step_file(made.data).bodies
    held = properties(body.body)
    assert made.report["crank"]["volume_mm3"] == pytest.approx(held.mass_g, rel=1e-9)
    assert made.report["crank"]["mass_g"] == pytest.approx(7.85e-3 * held.mass_g, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["singel"], 3, "no preset is called 'singel'; did you mean single?"),
        (["single", "--set", "strok_mm=3"], 3, "strok_mm is an unknown key; did you mean 'stroke_mm'?"),
        (["single", "--set", "stroke_mm=long"], 3, "stroke_mm is 'long'; must be a number"),
        (["single", "--set", "stroke_mm"], 2, "--set 'stroke_mm' is not KEY=VALUE"),
        (["single", "--segments", "3"], 3, "segments is 3; must be 8 to 4096"),
        (["single", "-o", "a.xyz"], 3, "xyz"),
        (["single", "-o", "a.step", "--unit", "inch"], 2, "--unit inch: STEP files are written in mm"),
        (["single", "-o", "a.stl", "--json", "a.stl"], 2, "must be files of different names"),
        (["none.toml"], 3, "cannot read the description none.toml: no such file or directory"),
        (["bad.toml"], 3, "bad.toml is not valid TOML"),
        (["bytes.toml"], 3, "bytes.toml is not UTF-8 text: byte 0 is 0xff"),
    ],
)
def test_what_cannot_be_built_is_one_line_and_no_file(
    arguments: list[str], code: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("bad.toml").write_text("stroke_mm =")
    Path("bytes.toml").write_bytes(b"\xff\xfe\x00")
    before = sorted(Path().iterdir())
    assert main(["generate", *arguments]) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert message in said.err
    assert len(said.err.splitlines()) == 1
    assert sorted(Path().iterdir()) == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["motocross", "v-twin-45", "inline-4"])
def test_the_examples_run(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    for file in EXAMPLES.glob(f"{name}*.toml"):
        shutil.copy(file, file.name)
    assert main(["generate", f"{name}.toml", "-o", f"{name}.stl", "--segments", "32"]) == 0
    assert main(["balance", f"{name}-job.toml", "-o", "out", "--no-report"]) == 0
    assert "WITHIN TOLERANCE" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["single", "pressed-up-single-no-pin", "v6-60", "motocross.toml"])
def test_reports_meet_their_schema(name: str) -> None:
    if name.endswith(".toml"):
        shutil.copy(EXAMPLES / name, ".")
    validator = jsonschema.Draft202012Validator(schema("generate"))
    validator.check_schema(validator.schema)
    values = report(name, "-o", "a.stl", "--segments", "16")
    validator.validate(values)
    assert (values["engine"] is not None) == name.endswith(".toml")
    for wrong in (values | {"crank": {}}, values | {"more": 1}, values | {"design": {"name": "x"}}):
        assert not validator.is_valid(wrong)


def test_what_both_schemas_share_is_the_same() -> None:
    ours, other = schema("generate"), schema("report")
    for name in ("autobalance", "frame", "crank", "initial", "schema_version"):
        assert ours["properties"][name] == other["properties"][name]
    for name in ours["$defs"].keys() & other["$defs"].keys():
        assert ours["$defs"][name] == other["$defs"][name]


def test_a_report_of_tables_alone_is_shown_by_what_they_hold() -> None:
    values = {"command": "generate", "crank": {"mass_g": 2.0, "webs": []}, "outputs": {"solid": {}}}
    assert scalars(values) == [("crank.mass_g", "2")]


def test_the_help_names_every_preset() -> None:
    assert tuple(PRESETS) == PRESET_NAMES
