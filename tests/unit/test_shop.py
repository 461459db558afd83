"""Whose work a job is, and the shop's own file: found, merged, kept in the report."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance import job
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.errors import JobError
from autobalance.job.limits import limits_of_every_kind
from autobalance.user_folders import configuration_folder
from tests import jobs

SHOP = """
[shop]
name = "Turner"
logo = "logo.png"
units = "inch"
drills = ["1/2 in", 8]
washers_g = [1, 2.5]
[[shop.slugs]]
diameter_mm = "1 in"
length_mm = 12.7
"""


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a job with nothing of a shop beside it."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr("sys.platform", "linux")
    return jobs.bundled_job(tmp_path / "work")


def with_header(path: Path) -> Path:
    text = path.read_text("utf-8")
    path.write_text('[job]\ncustomer = "C. Owner"\nserial = "C-17"\n' + text, "utf-8")
    return path


def test_the_header_is_kept_in_the_report(path: Path) -> None:
    without = job.describe(job.load(path))
    assert {"job", "shop"} & set(without) == set()
    told = job.describe(job.load(with_header(path)))
    assert told.pop("job") == {
        "customer": "C. Owner",
        "engine": None,
        "part": None,
        "serial": "C-17",
        "operator": None,
        "note": None,
    }
    assert told == without


def test_a_shop_beside_the_job_is_read_with_it(path: Path) -> None:
    beside = path.parent / "shop.toml"
    beside.write_text(SHOP, "utf-8")
    shop = job.describe(job.load(path))["shop"]
    assert shop["drills"] == [12.7, 8.0]
    assert shop["slugs"] == [{"diameter_mm": 25.4, "length_mm": 12.7, "density_kg_m3": 17000.0}]
    assert shop["logo"] == (path.parent / "logo.png").resolve().as_posix()
    assert shop["machine"] is None
    again = job.describe(job.load(path, ["shop.name=Other"]))["shop"]
    assert again == {**shop, "name": "Other"}


def test_the_users_shop_gives_way_to_that_beside_the_job_and_to_the_jobs_own(path: Path) -> None:
    configuration_folder().mkdir(parents=True)
    (configuration_folder() / "shop.toml").write_text('[shop]\nname = "at home"\nunits = "inch"\n', "utf-8")
    assert job.describe(job.load(path))["shop"]["name"] == "at home"
    (path.parent / "shop.toml").write_text('[shop]\nname = "beside"\n', "utf-8")
    assert job.describe(job.load(path))["shop"]["name"] == "beside"
    path.write_text('[shop]\nname = "its own"\n' + path.read_text("utf-8"), "utf-8")
    shop = job.describe(job.load(path))["shop"]
    assert (shop["name"], shop["units"]) == ("its own", None)


def test_what_is_wrong_with_a_shop_names_its_file(path: Path) -> None:
    beside = path.parent / "shop.toml"
    beside.write_text('[shop]\nnmae = "x"\ndrills = "letters"\n', "utf-8")
    with pytest.raises(JobError) as caught:
        job.load(path)
    assert caught.value.lines == (
        f"{beside}: shop.nmae is an unknown key; did you mean 'name'?",
        f"{beside}: shop.drills is 'letters'; must be 'mm' or 'inch' or 'letter' or 'number' or a list, each "
        "entry a number; did you mean 'letter'?",
    )


def test_init_writes_a_shop_that_can_be_read(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(path.parent)
    assert jobs.run("init", "--shop") == 0
    assert f"or as {configuration_folder() / 'shop.toml'} for all jobs" in " ".join(
        capsys.readouterr().out.split()
    )
    text = Path("shop.toml").read_text("utf-8")
    assert job.describe(job.load(path))["shop"]["name"] is None
    kept = "\n".join(
        line.removeprefix("# ") for line in text.splitlines() if " = " in line or "[shop]" in line
    )
    Path("shop.toml").write_text(kept, "utf-8")
    shop = job.describe(job.load(path))["shop"]
    assert {key for key, value in shop.items() if value is None} == set()
    assert set(tomllib.loads(kept)["shop"]) == set(shop)
    assert jobs.run("init", "--shop", "crank.stl") == 2
    assert jobs.run("init") == 2
    assert jobs.run("init", "--shop", "-o", "shop.xlsx") == 2


def test_the_report_of_a_run_holds_both_and_verifies(path: Path) -> None:
    (path.parent / "shop.toml").write_text(SHOP, "utf-8")
    found = ab.balance(with_header(path))
    assert found.report["job"]["shop"]["name"] == "Turner"
    assert found.report["job"]["job"]["serial"] == "C-17"
    written = found.write(path.parent / "out", only=("json",))
    report = next(each for each in written if each.name == "report.json")
    assert ab.verify(report).holds


def test_slugs_of_the_shop_count_where_the_job_names_none() -> None:
    slugs = [
        {"diameter_mm": 25.4, "length_mm": 12.7, "density_kg_m3": 17000.0},
        {"diameter_mm": 20.0, "length_mm": 30.0, "density_kg_m3": 18000.0},
        {"diameter_mm": 20.0, "length_mm": 10.0, "density_kg_m3": 18000.0},
    ]
    raw: dict[str, Any] = {"correction": {"method": "slug"}, "shop": {"slugs": slugs}}
    limits = limits_of_every_kind(raw)["slug"]
    assert isinstance(limits, SlugLimits)
    assert (limits.diameters_mm, limits.lengths_mm, limits.density_kg_m3) == ((20.0,), (10.0, 30.0), 18000.0)
    raw["correction"] = {"method": "slug", "slug": {"diameters_mm": [8.0]}}
    own = limits_of_every_kind(raw)["slug"]
    assert isinstance(own, SlugLimits)
    assert own.diameters_mm == (8.0,)
    assert own.density_kg_m3 == 17000.0
