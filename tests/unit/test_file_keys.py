"""Every key of the files beside a job: what the reader refuses of it, the schema refuses."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest
from jsonschema import Draft202012Validator

import autobalance as ab
from autobalance.declare import Key
from autobalance.errors import JobError
from autobalance.job.reading import forms_of
from autobalance.registry import FILES
from autobalance.toml_files.keys import read
from autobalance.toml_files.typed_units import in_base_units
from autobalance.verbs.schema import READ_FILES
from tests.unit.test_job_keys import (
    FITTING,
    both_refuse,
    dotted,
    every_key,
    needed,
    sample,
    told,
    with_value,
    wrong,
)

Raw = dict[str, Any]
START: Raw = {
    "crankshaft": {"file": "crank.3mf", "density_kg_m3": 7850.0},
    "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
}
"""Tables of the job that a design starts from."""


def complaint(keys: tuple[Key, ...], raw: Raw) -> list[str]:
    try:
        read(in_base_units(raw), keys)
    except JobError as error:
        return list(error.lines)
    return []


def test_every_file_has_its_schema() -> None:
    assert set(READ_FILES) == {"job", *FILES}


@pytest.mark.parametrize(("name", "form"), [(name, form) for name in FILES for form in forms_of(name)])
def test_what_the_reader_refuses_the_schema_refuses(name: str, form: str) -> None:
    known = {} if name == "drive-file" else FITTING  # its gears are no torsional train's
    keys, schema = forms_of(name)[form], Draft202012Validator(ab.schema(name))
    said = partial(complaint, keys)
    base = {key.name: sample(key, key.name, known) for key in keys if needed(key)}
    base |= {"solid": {"file": "body.stl"}} if name == "fem-file" else {}
    own = tuple(key for key in keys if not key.verbs)
    if own != keys:  # the others are a job's, whose test they have
        base |= START if name == "design-file" else {}
    assert said(base) == []
    for key, path, held in every_key(own, base, known=known):
        raw, where, good = held, told(path), sample(key, dotted(path), known)
        for other in (each.name for each in own if each.instead == path[0]):
            if len(path) == 1:
                both_refuse(with_value(raw, path, good), f"{other} and ", said, schema)
            raw = with_value(raw, (other,), None)
        fits = with_value(raw, path, good)
        assert said(fits) == [], where
        assert [each.message for each in schema.iter_errors(fits)] == [], where
        for value in wrong(key):
            both_refuse(with_value(raw, path, value), where, said, schema)
        both_refuse(
            with_value(raw, path, good, rename=f"{key.name}x"), f"{where}x is an unknown key", said, schema
        )
        if needed(key):
            both_refuse(with_value(raw, path, None), where, said, schema)
