"""Settings of ``--set`` that would reach the tolerance, as lines for people."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from typing import Any

from autobalance.quantities import Text, g, joined, said


def relaxation_lines(report: Mapping[str, Any]) -> list[Text]:
    """Return a line for each relaxation that changes the job: its settings, and the result they lead to."""
    return [_line(each) for each in report.get("relaxations", ()) if each["changes"]]


def _line(relaxation: Mapping[str, Any]) -> Text:
    settings = " ".join(
        "--set " + shlex.quote(f"{change['key']}={json.dumps(change['proposed'], ensure_ascii=False)}")
        for change in relaxation["changes"]
    )
    comes_to: list[str] = [f"leaves {relaxation['used_share']:.2f} of the permissible value"]
    metal_g = relaxation["metal_g"]
    comes_to += [] if metal_g is None else [said("{} of metal in all", g(metal_g, ".1f"))]
    comes_to += [] if relaxation["tried"] else ["not tried"]
    return said("{}: {}", settings, joined(", ", comes_to))
