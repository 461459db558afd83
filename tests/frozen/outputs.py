"""What a command printed and wrote, as text that two runs share."""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from openpyxl import load_workbook
from pypdf import PdfReader

import autobalance as ab
from tests.golden.test_golden import compare

HERE = Path(__file__).with_name("stored")
RUNS: dict[str, str] = {
    "balance-all": "balance job.toml -o all",
    "balance-drill": "balance drill.toml -o drilled --units inch",
    "balance-light": "balance light.toml -o light --no-report",
    "inspect-crank": "inspect crank.stl --unit mm",
    "init": "init crank.stl --unit mm -o new.toml",
    "torsion-train": "torsion train.toml",
    "sheet": "sheet done/report.json -o paper",
}
"""Runs besides those of ``every_command``: name, command line."""
VOLATILE_KEYS = frozenset(("seconds", "sha256", "autobalance", "triangles", "made", "date", "fingerprint"))
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
RELATIVE = 1e-6
LONG = 30
"""Of lists longer than this, length and some entries are stored."""
SHOWN = (".html", ".pdf", ".xlsx", ".csv", ".toml", ".md", ".ngc", ".txt")
"""Endings of files whose words are stored; of others the name alone."""


def stable(text: str, folder: Path) -> str:
    """Return printed text without what changes from run to run: folder, version, times, hashes, dates."""
    for root in {str(folder), str(folder.resolve())}:
        text = text.replace(root, "FOLDER")
    text = text.replace(ab.__version__, "VERSION")
    text = re.sub(r"(?<![.\w])(?=[0-9]*[a-f])[0-9a-f]{12,64}\b", "HASH", text)
    text = re.sub(r"\b\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d(?::\d\d)?(?:Z|[+-]\d\d:?\d\d)?)?", "DATE", text)
    text = re.sub(r"\b\d+(?:\.\d+)? s\b(?! ?\^)", "TIME", text)
    return "\n".join(line.rstrip() for line in text.splitlines())


def without_volatile(value: Any) -> Any:
    """Return a report without times, hashes and versions."""
    if isinstance(value, dict):
        return {key: without_volatile(each) for key, each in value.items() if key not in VOLATILE_KEYS}
    if isinstance(value, list) and len(value) > LONG:
        return _summary(value)
    if isinstance(value, list):
        return [without_volatile(each) for each in value]
    return value


def _summary(values: list[Any]) -> dict[str, Any]:
    """Return length and some entries of a long list, and the mean and root mean square of a curve."""
    some = {f"[{place}]": without_volatile(values[place]) for place in (0, 1, len(values) // 3, -1)}
    if not all(isinstance(each, float) for each in values):
        return {"length": len(values), **some}
    mean = math.fsum(values) / len(values)
    rms = math.sqrt(math.fsum(each**2 for each in values) / len(values))
    return {"length": len(values), **some, "mean": mean, "rms": rms}


def words(path: Path) -> str:
    """Return the words that a written file shows, in reading order; none for pictures and solids."""
    if path.suffix not in SHOWN:
        return ""
    if path.suffix == ".pdf":
        return "\n".join(page.extract_text() for page in PdfReader(path).pages)
    if path.suffix == ".xlsx":
        book = load_workbook(path)
        return "\n".join(
            f"{sheet.title}!{cell.coordinate}: {cell.value}"
            for sheet in book
            for row in sheet.iter_rows()
            for cell in row
            if cell.value is not None
        )
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".html":
        text = re.sub(r"<(script|style)\b.*?</\1>", "", text, flags=re.DOTALL)
        text = html.unescape(re.sub(r"<[^>]*>", "\n", text))
        text = re.sub(r"\s*\n\s*", "\n", text)
    return text


def written(folder: Path, before: set[Path]) -> Iterator[tuple[str, str]]:
    """Yield name and words of each file of a folder that was not there before."""
    for path in sorted(set(folder.rglob("*")) - before):
        if path.is_file() and path.suffix != ".json":
            yield path.relative_to(folder).as_posix(), words(path)


def differences(stored: str, fresh: str) -> list[str]:
    """Return a line for each line that differs: words to the letter, numbers by 1e-6 or their last place."""
    old, new = stored.splitlines(), fresh.splitlines()
    if len(old) != len(new):
        gone = [f"gone: {line}" for line in old if line not in new]
        return [
            f"{len(old)} lines stored, now {len(new)}",
            *gone,
            *(f"new: {n}" for n in new if n not in old),
        ]
    return [f"stored {a!r}, now {b!r}" for a, b in zip(old, new, strict=True) if not same_line(a, b)]


def same_line(stored: str, fresh: str) -> bool:
    if stored == fresh:
        return True
    squeezed = [re.sub(r" +", " ", NUMBER.sub("#", line)) for line in (stored, fresh)]
    if squeezed[0] != squeezed[1]:
        return False
    pairs = zip(NUMBER.findall(stored), NUMBER.findall(fresh), strict=True)
    return all(_same_number(old, new) for old, new in pairs)


def _same_number(stored: str, fresh: str) -> bool:
    if stored == fresh:
        return True
    place = max(_last_place(stored), _last_place(fresh))
    exact = place == 1.0 and "." not in stored + fresh  # a count
    return not exact and math.isclose(float(stored), float(fresh), rel_tol=RELATIVE, abs_tol=1.01 * place)


def _last_place(text: str) -> float:
    mantissa, _, power = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 10.0 ** (int(power or 0) - decimals)


def report_differences(stored: str, fresh: str) -> list[str]:
    """Return the places where two reports differ, keys that are added too."""
    old, new = json.loads(stored), json.loads(fresh)
    return [*compare(old, new, ""), *(f"new: {path}" for path in sorted(_paths(new) - _paths(old)))]


def _paths(value: Any, path: str = "") -> set[str]:
    if isinstance(value, dict):
        return {
            each for key, part in value.items() for each in {f"{path}.{key}", *_paths(part, f"{path}.{key}")}
        }
    if isinstance(value, list):
        return {each for part in value for each in _paths(part, f"{path}[]")}
    return set()


def differs(file: str, text: str) -> Iterator[str]:
    """Yield where a text differs from what is stored of it."""
    compare_as = report_differences if file.endswith(".json") else differences
    yield from compare_as((HERE / file).read_text(encoding="utf-8"), text)
