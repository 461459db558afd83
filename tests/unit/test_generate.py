"""Generated cranks: mass properties against closed forms, anatomy against the metal, errors."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from autobalance.declare import encoded
from autobalance.drawn_cranks.design import (
    PRESETS,
    Design,
    DesignBay,
    DesignCounterweight,
    DesignFlange,
    DesignWeb,
    DrawnShaft,
    preset,
)
from autobalance.drawn_cranks.generate import crank_solid, exact_moments
from autobalance.drawn_cranks.input import read_design, with_settings
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import JobError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Bar, tessellated
from autobalance.solid.csg.solid import Solid
from fixtures import make
from tests.generated import generated_crank, random_placement

RHO = 7.85e-3
GRID = 2.0**-26  # regions keep coordinates on a grid of half that
NO_FACETS = 2e-7  # what is left after extrapolation from 128 and 256 segments
SAME = 1e-9


def plain(name: str) -> Design:
    """A preset without what breaks its symmetry."""
    return replace(PRESETS[name], oil_hole_mm=0.0, nose=None, flange=None)


def straight_fixture() -> tuple[Design, make.Dimensions]:
    size = make.straight()
    return (
        Design(
            name="crf",
            stroke_mm=53.8,
            main_journal=DrawnShaft(28.0, size.journal_length),
            crankpin=DrawnShaft(28.0, 16.0, bore_mm=size.pin_bore),
            web=DesignWeb(size.web_thickness, "disc", disc_radius_mm=size.web_radius),
            counterweight=DesignCounterweight(
                size.counterweight_radius,
                180.0,
                thickness_mm=size.web_thickness + size.shoulder_height,
                inner_radius_mm=size.shoulder_inner_radius,
            ),
            bays=(DesignBay(),),
        ),
        size,
    )


def test_the_bundled_crank_comes_out_of_its_dimensions() -> None:
    design, _ = straight_fixture()
    moments = exact_moments(design)
    assert moments.mass_g == pytest.approx(2700.0, rel=NO_FACETS)
    assert moments.polar_inertia_g_mm2 == pytest.approx(2847.335e3, rel=NO_FACETS)
    product = 2020.40 * 6.16 - 114.65 * 26.9
    assert -moments.first_g_mm[0] == pytest.approx(product, rel=5.0 * NO_FACETS)


def test_a_counterweight_is_a_sector_of_a_ring() -> None:
    """U = ρ T 2/3 sin(A/2) (R³ − ri³) for each of the two."""
    base = replace(
        plain("single"),
        main_journal=DrawnShaft(30.0, 60.0),
        counterweight=DesignCounterweight(60.0, 120.0, thickness_mm=15.0, inner_radius_mm=25.0),
    )
    thick = with_settings(base, {"counterweight.thickness_mm": 35.0})
    change = exact_moments(thick) - exact_moments(base)
    assert -change.first_g_mm[0] / 2.0 == pytest.approx(18162.7899, rel=1e-6)
    assert change.mass_g / 2.0 == pytest.approx(489.119796, rel=1e-6)
    assert change.first_g_mm[0] / change.mass_g == pytest.approx(-37.1336227, rel=1e-6)


def test_facet_error_falls_with_the_square_of_the_segments() -> None:
    design, _ = straight_fixture()
    exact = np.array([2700.0, 2847.335e3])
    errors = []
    for segments in (64, 128, 256):
        moments = crank_solid(design, segments).moments(RHO)
        errors.append(exact - [moments.mass_g, moments.polar_inertia_g_mm2])
    ratios = np.array(errors[:-1]) / errors[1:]
    np.testing.assert_allclose(ratios, 4.0, rtol=0.02)


@pytest.mark.parametrize("name", ["single", "v-twin-45", "parallel-twin-360"])
def test_extrapolated_moments_are_the_limit_of_finer_meshes(name: str) -> None:
    crank = PRESETS[name]
    exact = exact_moments(crank, 128)
    errors = [exact.mass_g - crank_solid(crank, n).moments(RHO).mass_g for n in (64, 128)]
    assert 0.0 < errors[1] < 1e-3 * exact.mass_g
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


def test_every_corner_of_a_drafted_crank_lies_on_its_cylinders() -> None:
    crank = replace(PRESETS["pressed-up-single"], nose=None)
    mesh = crank_solid(crank, 24).mesh
    about_axis = np.linalg.norm(mesh.vertices[:, :2], axis=1)
    about_pin = np.linalg.norm(mesh.vertices[:, :2] - [crank.crank_radius_mm, 0.0], axis=1)
    off_axis = [np.abs(about_axis - radius) for radius in (14.0, 19.0, 48.0, 51.5)]
    off_pin = [np.abs(about_pin - radius) for radius in (14.0, 9.0)]
    off = np.min([*off_axis, *off_pin], axis=0)
    centres = about_axis == 0.0  # of the ends
    assert off[~centres].max() < GRID
    corners = mesh.corners
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges.min() > 0.01


def test_a_draft_takes_the_wedges_it_should() -> None:
    """Both flanks lean: each wedge has the section h² tan δ / 2 and the length from ri to R, nearly."""
    upright = replace(plain("pressed-up-single"), bays=(DesignBay(counterweights=(True, False)),))
    upright = with_settings(upright, {"counterweight.draft_deg": 0.0})
    leaning = with_settings(upright, {"counterweight.draft_deg": 14.0})
    slope, height = math.tan(math.radians(14.0)), 3.0
    node, weight = np.polynomial.legendre.leggauss(8)
    wedge = 0.0
    for x, w in zip(node, weight, strict=True):  # over the distance from the edge
        u = 0.5 * slope * height * (x + 1.0)
        chord = math.sqrt(51.5**2 - u**2) - math.sqrt(19.0**2 - u**2)
        wedge += 0.5 * slope * height * w * (height - u / slope) * chord
    for fan in (170.0, 180.0):  # at 180° both edges lie in one line
        pair = [with_settings(each, {"counterweight.fan_angle_deg": fan}) for each in (upright, leaning)]
        before, after = (exact_moments(each).mass_g for each in pair)
        assert before - after == pytest.approx(2.0 * RHO * wedge, rel=1e-6)
        before, after = (crank_solid(each, 240).volume_mm3 for each in pair)
        assert before - after == pytest.approx(2.0 * wedge, rel=1e-3)


@pytest.mark.parametrize("name", ["inline-3", "inline-4", "inline-6", "v6-60", "v8-crossplane", "v12-60"])
def test_cranks_of_even_throws_have_no_resultant(name: str) -> None:
    moments = crank_solid(plain(name), 64).moments(RHO)
    one = crank_solid(replace(plain(name), bays=(DesignBay(),)), 64).moments(RHO)
    scale = float(np.linalg.norm(one.first_g_mm[:2]))
    np.testing.assert_allclose(moments.first_g_mm[:2], 0.0, atol=2e-3 * scale)


def test_a_crossplane_crank_has_a_moment_and_a_flat_one_has_none() -> None:
    cross, flat = (crank_solid(plain(name), 64).moments(RHO) for name in ("v8-crossplane", "v8-flatplane"))
    arm = 94.0 * 2.0  # about two bays
    assert np.linalg.norm(cross.second_g_mm2[:2, 2]) > 100.0 * arm
    np.testing.assert_allclose(flat.second_g_mm2[:2, 2], 0.0, atol=1e-3)


def test_a_full_counterweight_lies_opposite_its_crankpin() -> None:
    crank = plain("single")
    heavier = with_settings(crank, {"counterweight.radius_mm": crank.counterweight.radius_mm + 4.0})  # type: ignore[union-attr]
    change = exact_moments(heavier, 64) - exact_moments(crank, 64)
    assert change.first_g_mm[0] < 0.0
    assert abs(change.first_g_mm[1]) < SAME * abs(change.first_g_mm[0])


# --- anatomy -----------------------------------------------------------------------------------------------
COUNTS = {
    "single": (2, 1, 2),
    "pressed-up-single": (2, 1, 2),
    "pressed-up-single-no-pin": (2, 1, 2),
    "v-twin-45": (2, 1, 2),
    "parallel-twin-360": (3, 2, 4),
    "inline-3": (4, 3, 6),
    "inline-4": (5, 4, 8),
    "inline-6": (7, 6, 12),
    "v6-60": (4, 6, 9),
    "v8-crossplane": (5, 4, 8),
    "v8-flatplane": (5, 4, 8),
    "v12-60": (7, 6, 12),
}
ANGLES = {
    "inline-3": [0, 240, 120],
    "inline-4": [0, 180, 180, 0],
    "v6-60": [0, 60, 240, 300, 120, 180],
    "v8-crossplane": [0, 90, 270, 180],
}


@pytest.mark.parametrize("name", PRESETS)
def test_counts_of_journals_throws_and_webs(name: str) -> None:
    truth = crank_anatomy(PRESETS[name])
    assert (len(truth.main_journals), len(truth.throws), len(truth.webs)) == COUNTS[name]
    assert len(crank_solid(PRESETS[name], 12).pieces()) == (2 if name.endswith("no-pin") else 1)
    if name in ANGLES:
        found = [math.degrees(throw.angle_rad) for throw in truth.throws]
        np.testing.assert_allclose(found, ANGLES[name], atol=SAME)


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("seed", [1, 2])
def test_the_anatomy_is_that_of_the_metal(name: str, seed: int) -> None:
    crank = generated_crank(name, seed=seed, segments=48)
    here = crank.solid.moved(crank.truth.file_to_rotor)
    pins = [throw.crankpin for throw in crank.truth.throws] if crank.design.crankpin_in_file else []
    for pin in [*pins, *crank.truth.main_journals]:
        bore = (crank.design.crankpin if pin in pins else crank.design.main_journal).bore_mm
        low, high = pin.z_range_mm
        for z in (low + 0.02, high - 0.02):
            check_ring(here, z, pin.centre_mm[:2], pin.diameter_mm, bore, crank.design.oil_hole_mm)
    for web in crank.truth.webs:
        inside = here.section(web.z_min_mm + 0.02).area_mm2, here.section(web.z_max_mm - 0.02).area_mm2
        outside = here.section(web.z_min_mm - 0.02).area_mm2, here.section(web.z_max_mm + 0.02).area_mm2
        assert min(inside) > max(outside) or not web.counterweight


def check_ring(
    solid: Solid, z: float, centre: np.typing.NDArray[np.float64], outer: float, inner: float, hole: float
) -> None:
    near = Region.circle(0.5 * outer + 0.5, 48, tuple(centre))  # a shoulder may stand around the journal
    area, first, _ = (solid.section(z) & near).area_moments()
    n = 48
    polygon = 0.125 * n * math.sin(2 * math.pi / n)
    assert area == pytest.approx(polygon * (outer**2 - inner**2), rel=0.12 if hole else 1e-5)
    np.testing.assert_allclose(first / area, centre, atol=2.0 if hole else 1e-4)


def test_the_rotor_frame_is_that_of_the_contract() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        placement = random_placement(rng)
        truth = crank_anatomy(PRESETS["v6-60"], placement)
        axis = truth.rotor_to_file[:3, 2]
        assert axis[np.argmax(np.abs(axis))] > 0.0
        first = truth.throws[0].crankpin.centre_mm
        np.testing.assert_allclose(first, [43.0, 0.0, 0.0], atol=SAME)
        z = [throw.crankpin.centre_mm[2] for throw in truth.throws]
        assert z == sorted(z)
        turn = truth.file_to_rotor[:3, :3]
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)


def test_of_equal_components_the_first_decides_the_sense() -> None:
    placement = np.eye(4)
    placement[:3, 2] = [-math.sqrt(0.5), math.sqrt(0.5) * (1 + 1e-9), 0.0]
    placement[:3, 0] = [0.0, 0.0, 1.0]
    placement[:3, 1] = np.cross(placement[:3, 2], placement[:3, 0])
    axis = crank_anatomy(PRESETS["single"], placement).rotor_to_file[:3, 2]
    assert axis[0] > 0.0


def test_an_overhung_crank_has_one_journal() -> None:
    crank = replace(plain("single"), journals="first")
    truth = crank_anatomy(crank)
    assert (len(truth.main_journals), len(truth.throws), len(truth.webs)) == (1, 1, 1)
    pin = truth.throws[0].crankpin
    assert pin.width_mm == crank.crankpin.width_mm - crank.fillet_mm  # one end is free
    end = crank_solid(crank, 32).moved(truth.file_to_rotor).bounds[1, 2]
    assert pin.z_range_mm[1] == pytest.approx(end, abs=SAME)
    assert len(crank_solid(crank, 32).pieces()) == 1


def test_a_slender_slanted_tool_is_sliced() -> None:
    """Facets from end to end made booleans with fine cranks take minutes: their boxes meet everything."""
    bar = tessellated(Bar((0.0, 0.0, 0.0), (30.0, 30.0, 30.0), 5.0), 32)
    boxes = np.ptp(bar.mesh.corners, axis=1)
    assert boxes.max() < 2.0 * 5.0
    axis = np.ones(3) / math.sqrt(3.0)
    off = np.linalg.norm(np.cross(bar.mesh.vertices, axis), axis=1)
    np.testing.assert_allclose(off, 2.5, atol=GRID)


def test_hollow_journals_are_open_at_both_ends() -> None:
    crank = with_settings(plain("parallel-twin-360"), {"main_journal.bore_mm": 20.0})
    solid = crank_solid(crank, 64)
    for journal in crank_anatomy(crank).main_journals:
        z = journal.centre_mm[2] - crank_anatomy(crank).file_to_rotor[2, 3]
        (ring,) = solid.section(float(z)).pieces()
        assert len(ring.polygons) == 2


# --- descriptions ------------------------------------------------------------------------------------------
TEXT = """
preset = "inline-4"
name = "mine"
stroke_mm = 90.0
[counterweight]
radius_mm = 74
"""


def test_a_description_starts_from_a_preset() -> None:
    crank, engine = read_design(TEXT, "mine.toml")
    assert engine is None
    assert crank.name == "mine"
    assert crank.crank_radius_mm == 45.0
    assert crank.counterweight is not None
    assert crank.counterweight.radius_mm == 74.0
    assert crank.counterweight.fan_angle_deg == PRESETS["inline-4"].counterweight.fan_angle_deg  # type: ignore[union-attr]
    assert crank.bays == PRESETS["inline-4"].bays


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_survives_its_own_table(name: str) -> None:
    assert with_settings(PRESETS[name], {}) == PRESETS[name]
    assert encoded(PRESETS[name])["name"] == name


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"strok_mm": 60.0}, "strok_mm is an unknown key; did you mean 'stroke_mm'?"),
        (
            {"counterweight.radius": 60.0},
            "counterweight.radius is an unknown key; did you mean 'radius_mm'?",
        ),
        ({"nothing_like_it": 1}, "nothing_like_it is an unknown key; known here: name, stroke_mm"),
        ({"stroke_mm": "long"}, "stroke_mm is 'long'; must be a number"),
        ({"stroke_mm": True}, "stroke_mm is true; must be a number"),
        ({"segments": 12.5}, "segments is 12.5; must be a whole number"),
        ({"segments": 4}, "segments is 4; must be 8 to 4096"),
        ({"stroke_mm": 0.0}, "stroke_mm is 0; must be > 0"),
        ({"stroke_mm": math.nan}, "stroke_mm is nan; must be a finite number"),
        ({"web.thickness_mm": -1.0}, "web.thickness_mm is -1; must be ≥ 0"),
        ({"web.outline": "round"}, "web.outline is 'round'; must be one of 'pear', 'disc'"),
        ({"web.outline": "disc"}, "web.disc_radius_mm is needed for the outline 'disc'"),
        ({"web.outline": "disc", "web.disc_radius_mm": 30.0}, "web.disc_radius_mm is 30; needs"),
        ({"web.pin_end_radius_mm": 10.0}, "web.pin_end_radius_mm is 10; crankpin and fillet need 18"),
        ({"web.hub_radius_mm": 10.0}, "web.hub_radius_mm is 10; main journal and fillet need 17"),
        ({"web.hub_radius_mm": 60.0}, "one end of the pear lies inside the other"),
        ({"counterweight.fan_angle_deg": 270.0}, "counterweight.fan_angle_deg is 270; must be in 0..180"),
        ({"counterweight.radius_mm": 20.0}, "counterweight.radius_mm is 20; the web there has 22"),
        ({"counterweight.thickness_mm": 4.0}, "counterweight.thickness_mm is 4; at least the web's"),
        (
            {"counterweight.inner_radius_mm": 4.0},
            "counterweight.inner_radius_mm is 4; must be between 17 and 52",
        ),
        ({"counterweight.draft_deg": 60.0}, "counterweight.draft_deg is 60; must be in 0..45"),
        ({"counterweight.thickness_mm": 60.0}, "its shoulder is as wide as the main journal"),
        ({"crankpin.bore_mm": 40.0}, "crankpin.bore_mm is 40; must be less than its diameter"),
        ({"crankpin.width_mm": 3.0}, "crankpin.width_mm is 3; two fillets leave no cylinder"),
        ({"main_journal.bore_mm": 28.0}, "main_journal.bore_mm is 28; it reaches into the crankpin"),
        ({"bays": []}, "[[bays]] is missing; expected at least one"),
        ({"bays": 3}, "bays is 3; must be a list of tables: [[bays]]"),
        ({"bays": [{"counterweights": [True]}]}, "bays[1].counterweights has 1 entries; must be a list of 2"),
        (
            {"bays": [{"crankpins_deg": [0.0, 60.0]}], "crankpin_in_file": False},
            "needs one crankpin in each bay",
        ),
        (
            {"web": 1, "web.thickness_mm": 2},
            "web.thickness_mm is set inside web, which is set to a value too",
        ),
        ({"web": 3}, "web is 3; must be a table"),
        (
            {"journals": "first", "flange": {"diameter_mm": 60.0, "thickness_mm": 8.0}},
            'flange: it stands on the last main journal, which journals = "first" leaves out',
        ),
        ({"flange": {"thickness_mm": 3.0}}, "flange.diameter_mm is missing"),
    ],
)
def test_impossible_descriptions_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(JobError) as caught:
        with_settings(PRESETS["single"], settings)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_does_not_fit_together_is_refused_when_built() -> None:
    crank = PRESETS["inline-4"]
    with pytest.raises(JobError, match=r"flange.bolt_circle_mm is 60; the holes need metal"):
        crank_solid(replace(crank, flange=DesignFlange(90.0, 14.0, 6, 10.5, 60.0)))
    with pytest.raises(JobError, match="oil_hole_mm: a straight hole would break out"):
        crank_solid(with_settings(crank, {"crankpin.width_mm": 100.0}))
    broad = {"counterweight.fan_angle_deg": 180.0, "web.pin_end_radius_mm": 75.0}
    with pytest.raises(JobError, match="so wide that the sector runs into"):
        crank_solid(with_settings(crank, broad))


def test_unreadable_and_unknown_descriptions_are_refused() -> None:
    with pytest.raises(JobError, match=r"a.toml is not valid TOML"):
        read_design("stroke_mm =", "a.toml")
    with pytest.raises(JobError, match=r"a.toml: stroke_mm is missing"):
        read_design("", "a.toml")
    with pytest.raises(JobError, match=r"a.toml: engine.rotating_g is 3; must be a table"):
        read_design('preset = "single"\nengine.rotating_g = 3', "a.toml")
    with pytest.raises(JobError, match=r"engine.crankpin_g.crankpin is missing"):
        read_design('preset = "pressed-up-single-no-pin"\nengine.rods_per_throw = 1', "a.toml")
    with pytest.raises(JobError, match=r"no preset is called 'inline4'; did you mean inline-4\?"):
        preset("inline4")
