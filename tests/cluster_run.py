"""A batch on a real Dask cluster of two worker processes, one of which is killed in the middle."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any


def main() -> None:
    """Run the list ``argv[1]`` into the folder ``argv[2]``."""
    import distributed

    from autobalance.api.batch import batch

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


if __name__ == "__main__":
    main()
