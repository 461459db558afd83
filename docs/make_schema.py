"""Write the JSON Schemas of reports into the package, from the typed records.

python docs/make_schema.py
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from autobalance.report.records.written import written_schema  # noqa: E402


def main() -> None:
    """Write both files."""
    for name in ("report", "generate"):
        path = ROOT / "autobalance" / "report" / "records" / f"{name}.schema.json"
        text = json.dumps(written_schema(name), indent=2, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
