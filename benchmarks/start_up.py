"""How long the program takes to begin: ``import autobalance``, ``--help``, ``balance --help``, its API.

    python benchmarks/start_up.py [--repeat 20]

Processor seconds of whole processes, the least of several in turn; *python* is the interpreter alone.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from main_job import measured

ROOT = Path(__file__).resolve().parents[1]
COMMAND = [sys.executable, str(ROOT / "cli.py")]
WAYS = {
    "python": [sys.executable, "-c", "pass"],
    "import autobalance": [sys.executable, "-c", "import autobalance"],
    "--help": [*COMMAND, "--help"],
    "balance --help": [*COMMAND, "balance", "--help"],
    "autobalance.balance": [sys.executable, "-c", "import autobalance; autobalance.balance"],
}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, default=20)
    repeat = parser.parse_args().repeat
    taken: dict[str, list[float]] = {name: [] for name in WAYS}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(repeat):
            for name, command in WAYS.items():
                seconds, _, code = measured(command, Path(folder))
                if code:
                    print(f"{name} failed with exit code {code}")
                    return 1
                taken[name].append(seconds)
    for name, runs in taken.items():
        print(f"{name:>20} {min(runs):.3f} s")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
