"""A batch on a real Dask cluster of two worker processes, one of which is killed in the middle."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any


def main() -> None:
    """Run the list ``argv[1]`` into the folder ``argv[2]``."""
    import dask
    import distributed

    from autobalance.studies.batch.verb import batch

    dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"})  # a new worker starts sooner
    folder = Path(sys.argv[2])
    make: Any = distributed.LocalCluster
    cluster = make(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster:
        victim = next(iter(cluster.workers.values())).pid

        def kill() -> None:
            journal = folder / "journal.jsonl"
            while not journal.exists() or '"exit_code": 0' not in journal.read_text("utf-8"):
                time.sleep(0.01)
            os.kill(victim, signal.SIGKILL)

        threading.Thread(target=kill, daemon=True).start()
        batch(sys.argv[1], folder, cluster=cluster.scheduler_address)
        found = {"ends": tries(cluster.scheduler_address, folder), "version": other_version(cluster)}
        sys.stdout.write(json.dumps(found) + "\n")


def tries(address: str, folder: Path) -> list[list[Any]]:
    """Return number, whether it was lost, and tries of five tasks; one kills its worker each time."""
    from autobalance.studies.workers import workers_of
    from tests.worker_tasks import square_unless_killed

    (folder / "deaths").write_text("99")
    (folder / "marks").mkdir()
    tasks = [(number, str(folder / "marks")) for number in range(5)]
    with workers_of(None, address) as pool:
        ends = sorted(pool.run(square_unless_killed, tasks), key=lambda done: done.number)
    assert len(list((folder / "marks").iterdir())) == 3
    return [[done.number, done.lost, done.attempt] for done in ends]


def other_version(cluster: Any) -> str:
    """Return what is said where the workers have another version of the package."""
    from autobalance.errors import FileError
    from autobalance.studies import workers

    vars(workers)["__version__"] = "0.0.other"
    try:
        with workers.workers_of(None, cluster.scheduler_address):
            return ""
    except FileError as error:
        return str(error)


if __name__ == "__main__":
    main()
