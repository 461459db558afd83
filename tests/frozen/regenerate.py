"""Store what commands write anew: ``python -m tests.frozen.regenerate [NAME ...]``; read the difference.

A file whose stored text says the same, but for last digits and the order of keys, stays as it is.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from tests.frozen.outputs import HERE, differs
from tests.frozen.run import LINES, helps, run_of, write_inputs


def main() -> None:
    names = sys.argv[1:] or list(LINES)
    HERE.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_inputs(folder)
        stored = helps()
        for each in names:
            stored |= run_of(each, folder)[0]
    if len(sys.argv) == 1:
        for path in HERE.iterdir():
            if path.name not in stored:
                path.unlink()
    for file, text in stored.items():
        if not (HERE / file).exists() or any(differs(file, text)):
            (HERE / file).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
