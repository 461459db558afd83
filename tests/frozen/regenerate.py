"""Store what commands write anew: ``python -m tests.frozen.regenerate [NAME ...]``; read the difference."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from tests.frozen.outputs import HERE
from tests.frozen.run import LINES, helps, run_of, write_inputs


def main() -> None:
    names = sys.argv[1:] or list(LINES)
    HERE.mkdir(exist_ok=True)
    if len(sys.argv) == 1:
        for path in HERE.iterdir():
            path.unlink()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_inputs(folder)
        stored = helps()
        for each in names:
            stored |= run_of(each, folder)[0]
    for file, text in stored.items():
        (HERE / file).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
