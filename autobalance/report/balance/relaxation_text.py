"""Settings of ``--set`` that would reach the tolerance, as lines for people."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from typing import Any


def relaxation_lines(report: Mapping[str, Any]) -> list[str]:
    """Return a line for each relaxation that changes the job: its settings, and the result they lead to."""
    return [_line(each) for each in report.get("relaxations", ()) if each["changes"]]


def _line(relaxation: Mapping[str, Any]) -> str:
    settings = " ".join(
        "--set " + shlex.quote(f"{change['key']}={json.dumps(change['proposed'], ensure_ascii=False)}")
        for change in relaxation["changes"]
    )
    comes_to = [f"leaves {relaxation['used_share']:.2f} of the permissible value"]
    comes_to += [] if relaxation["metal_g"] is None else [f"{relaxation['metal_g']:.1f} g of metal in all"]
    comes_to += [] if relaxation["tried"] else ["not tried"]
    return f"{settings}: {', '.join(comes_to)}"
