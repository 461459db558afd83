"""The job of a balanced crank: its properties as the text of a job file."""

import json


def toml(values):
    """Return tables and keys as TOML; lists, numbers, truth values and texts are all there is."""
    return "\n".join(_table(values, ())) + "\n"


def _table(values, path):
    plain = [key for key, value in values.items() if not isinstance(value, dict)]
    lines = ["[%s]" % ".".join(path)] if path and plain else []
    lines += ["%s = %s" % (key, _value(values[key])) for key in plain]
    for key, value in values.items():
        if isinstance(value, dict):
            lines += _table(value, (*path, key))
    return lines


def _value(value):
    if isinstance(value, Typed):
        return str(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[%s]" % ", ".join(_value(each) for each in value)
    if isinstance(value, str):
        return json.dumps(value)
    return repr(float(value)) if isinstance(value, float) else str(value)


def job_of(crank, file, keep):
    """Return the tables of a balanced crank's job.

    Parameters
    ----------
    crank : object with the properties of a balanced crank
    file : str
        Name of the crank's file.
    keep : str or None
        Name of the report whose cuts are kept.
    """
    values = {
        "crankshaft": {
            "file": file,
            "density_kg_m3": float(crank.Density),
            "crankpin_in_file": bool(crank.CrankpinInFile),
        },
        "engine": {
            "rotating_g": _parts("rotating", crank.Rotating),
            "reciprocating_g": _parts("reciprocating", crank.Reciprocating),
        },
        "balance": {
            "factor": float(crank.Factor),
            "grade": float(crank.Grade),
            "speed_rpm": float(crank.SpeedRpm),
        },
        "correction": {"method": str(crank.Method)},
    }
    if crank.RodLength > 0.0:
        values["engine"]["rod_length_mm"] = float(crank.RodLength)
    if crank.Method == "drill" and list(crank.Drills):
        values["correction"]["drill"] = {"diameters_mm": [float(each) for each in crank.Drills]}
    if file.endswith(".stl"):
        values["crankshaft"]["unit"] = "mm"
    if list(crank.Crankpin):
        values["engine"]["crankpin_g"] = _parts("crankpin", crank.Crankpin)
    if keep is not None:
        values["correction"]["keep"] = keep
    for limit in crank.Limits:
        _set(values, limit if limit.startswith("correction.") else "correction." + limit)
    return values


class Typed(str):
    """A value as it was typed: TOML already."""


def _set(values, typed):
    """Set one key of nested tables to what was typed, as ``--set`` does: a bare word is a text."""
    path, _, text = typed.partition("=")
    *tables, key = path.strip().split(".")
    for name in tables:
        values = values.setdefault(name, {})
    text = text.strip()
    is_toml = text[:1] in "[{\"'+-.0123456789" or text in ("true", "false")
    values[key] = Typed(text) if text and is_toml else text


def _parts(name, weights):
    names = [name, *("%s_%d" % (name, number) for number in range(2, len(weights) + 1))]
    return {key: float(weight) for key, weight in zip(names, weights)}
