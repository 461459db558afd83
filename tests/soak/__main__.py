"""``python -m tests.soak --hours 2``: random cases until the time is over; what falls is kept as a case."""

from __future__ import annotations

import argparse
import collections
import gzip
import json
import multiprocessing
import random
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

from tests.soak.cases import KINDS, drawn, made

CORPUS = Path(__file__).with_name("corpus")
"""Files that brought something down, packed, each `damaged-NAME` by what it was; and ``cases.jsonl``."""
PATIENCE_S = 300.0
"""Seconds after which a case hangs."""
MEMORY_BYTES = 6 << 30
"""Address space of a case: what needs more takes a small machine down."""


def tried(kind: str, seed: int, folder: Path, told: Any) -> None:
    """Try one case; tell what fell, nothing where nothing did."""
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    try:
        KINDS[kind][0](folder, random.Random(seed))
    except BaseException:  # noqa: BLE001 whatever falls is what is looked for
        told.put(traceback.format_exc())
    else:
        told.put("")


def keep(kind: str, seed: int, folder: Path) -> None:
    """Keep what fell: the damaged file itself, or the seed that leads there."""
    CORPUS.mkdir(exist_ok=True)
    if kind == "damaged":
        place = max(folder.glob("damaged-*"), key=lambda each: each.stat().st_mtime_ns)
        (CORPUS / f"{seed}-{place.name}.gz").write_bytes(gzip.compress(place.read_bytes(), mtime=0))
        return
    with (CORPUS / "cases.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"kind": kind, "seed": seed}) + "\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=0.25)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 2**32)
    asked = parser.parse_args()
    apart: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    end, counts, fell = time.monotonic() + 3600.0 * asked.hours, collections.Counter[str](), 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made(folder)
        for kind, seed in drawn(asked.seed):
            if time.monotonic() >= end:
                break
            told = apart.Queue()
            process = apart.Process(target=tried, args=(kind, seed, folder, told))
            process.start()
            process.join(PATIENCE_S)
            if process.is_alive():
                process.kill()
                process.join()
                said = f"hangs for more than {PATIENCE_S:g} s"
            else:
                said = "" if process.exitcode == 0 else f"the process ended with {process.exitcode}"
                said = said or told.get(timeout=10.0)
            counts[kind] += 1
            if said:
                fell += 1
                sys.stdout.write(f"{kind} {seed}:\n{said}\n")
                sys.stdout.flush()
                keep(kind, seed, folder)
    listed = ", ".join(f"{count} of {kind}" for kind, count in sorted(counts.items()))
    sys.stdout.write(f"seed {asked.seed}: {sum(counts.values())} cases ({listed}); {fell} fell\n")
    return 1 if fell else 0


if __name__ == "__main__":
    raise SystemExit(main())
