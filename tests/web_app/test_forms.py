"""The fields of the page are made from the job's declarations."""

from autobalance.browser.forms import tables
from autobalance.browser.server import documentation


def test_fields_are_named_as_their_keys_without_the_unit() -> None:
    engine = next(each for each in tables() if each["table"] == "engine")["keys"]
    words = {each["key"]: (each["words"], each["unit"], each["kind"]) for each in engine}
    assert words["rod_length_mm"] == ("rod length", "mm", "number")
    assert words["rod.inertia_kg_mm2"] == ("rod: inertia", "kg·mm²", "number")
    assert words["layout.bank_deg"] == ("layout: bank", "°", "list")
    assert words["turns"] == ("turns", "", "choice")


def test_no_field_is_named_twice() -> None:
    for table in tables():
        keys = [each["key"] for each in table["keys"]]
        assert len(set(keys)) == len(keys)
        assert all(each["says"] for each in table["keys"])


def test_fields_say_which_verbs_read_them_where_not_all_do() -> None:
    by_name = {each["table"]: each for each in tables()}
    rod = next(each for each in by_name["engine"]["keys"] if each["key"] == "rod_length_mm")
    assert {"forces", "cycle", "shafts"} <= set(rod["verbs"])
    assert {"cycle", "torsion", "forces"} <= set(by_name["cycle"]["verbs"])
    offset = next(each for each in by_name["engine"]["keys"] if each["key"] == "layout.offset_mm")
    assert {"forces", "cycle", "shafts"} <= set(offset["verbs"])
    assert "cycle" in by_name["shafts"]["verbs"]  # for the roll couple
    assert all("strength" in by_name[name]["verbs"] for name in ("torsion", "damper", "coupling"))
    assert by_name["engine"]["verbs"] == []


def test_help_leads_to_the_apps_page_of_the_documentation_that_the_package_states() -> None:
    urls = ("Source, https://a.test/x", "Documentation, https://a.test/x/blob/HEAD/docs/index.md")
    assert documentation(urls) == "https://a.test/x/blob/HEAD/docs/app.md"
    assert documentation(urls[:1]) == ""
