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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autobalance.runtime import silence_loggers
from tests.soak.cases import KINDS, drawn, made

CORPUS = Path(__file__).with_name("corpus")
"""Files that brought something down, packed, each `damaged-NAME` by what it was; and ``cases.jsonl``."""
PATIENCE_S = 300
"""Processor time after which a case computes without end, where that can be limited."""
WAIT_S = 1800.0
"""Seconds after which a case hangs: on a busy machine, processor time is a tenth of that."""
MEMORY_BYTES = 6 << 30
"""Address space of a case: what needs more takes a small machine down."""


def tried(kind: str, seed: int, folder: Path, told: Any) -> None:
    """Try one case; tell what fell, nothing where nothing did, and the memory it took at most [bytes]."""
    silence_loggers()  # as a command does in a process of its own
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE_S, PATIENCE_S))
    said = ""
    try:
        KINDS[kind][0](folder, random.Random(seed))
    except BaseException:  # noqa: BLE001 whatever falls is what is looked for
        said = traceback.format_exc()
    told.put((said, most_memory()))


def most_memory() -> int:
    """Return the most memory that this process, or a child of it, held [bytes]; 0 where not known."""
    if sys.platform == "win32":
        return 0
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    usages = (resource.getrusage(each) for each in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return unit * max(each.ru_maxrss for each in usages)


@dataclass
class Figures:
    """What the cases of one kind took."""

    cases: int = 0
    fell: int = 0
    longest_s: float = 0.0
    longest_seed: int = 0
    most_bytes: int = 0

    def add(self, seed: int, took_s: float, memory_bytes: int, fell: bool) -> None:
        """Count a case."""
        self.cases += 1
        self.fell += fell
        if took_s > self.longest_s:
            self.longest_s, self.longest_seed = took_s, seed
        self.most_bytes = max(self.most_bytes, memory_bytes)

    def row(self, kind: str) -> str:
        """Return a line of the table of kinds."""
        size = self.most_bytes / 2**20
        return (
            f"{kind:9} {self.cases:6} cases, {self.fell} fell, "
            f"longest {self.longest_s:.1f} s (seed {self.longest_seed}), at most {size:.0f} MiB\n"
        )


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
    end, kinds = time.monotonic() + 3600.0 * asked.hours, collections.defaultdict[str, Figures](Figures)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made(folder)
        for kind, seed in drawn(asked.seed):
            if time.monotonic() >= end:
                break
            told, memory, began = apart.Queue(), 0, time.monotonic()
            process = apart.Process(target=tried, args=(kind, seed, folder, told))
            process.start()
            process.join(WAIT_S)
            if process.is_alive():
                process.kill()
                process.join()
                said = f"hangs for more than {WAIT_S:g} s"
            else:
                said = "" if process.exitcode == 0 else f"the process ended with {process.exitcode}"
                said, memory = (said, 0) if said else told.get(timeout=10.0)
            kinds[kind].add(seed, time.monotonic() - began, memory, bool(said))
            if said:
                sys.stdout.write(f"{kind} {seed}:\n{said}\n")
                sys.stdout.flush()
                keep(kind, seed, folder)
    fell = sum(each.fell for each in kinds.values())
    sys.stdout.writelines(each.row(kind) for kind, each in sorted(kinds.items()))
    sys.stdout.write(f"seed {asked.seed}: {sum(each.cases for each in kinds.values())} cases; {fell} fell\n")
    return 1 if fell else 0


if __name__ == "__main__":
    raise SystemExit(main())
