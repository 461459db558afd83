"""What runs in a process of its own: one verb on one job, its progress told through a pipe."""

from __future__ import annotations

import os
import signal
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    import autobalance as ab

MESH = "mesh.bin"
MEGABYTE = 1 << 20

Told = Callable[[str, float], None]


def work(verb: str, job: dict[str, Any], project: str, folder: str, memory_mb: int, pipe: Connection) -> None:
    """Run a verb and write its results to ``folder``; tell words, share and the end through ``pipe``."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's to deal with
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _limit_memory(memory_mb)
    from autobalance.errors import AutobalanceError

    def tell(words: str, share: float) -> None:
        pipe.send(("progress", words, share))

    try:
        code = VERBS[verb](job, Path(project), Path(folder), tell)
        pipe.send(("done", code))
    except AutobalanceError as error:
        pipe.send(("failed", error.exit_code, str(error)))
    except MemoryError:
        pipe.send(
            ("failed", AutobalanceError.exit_code, f"not enough memory for this file in {memory_mb} MB")
        )
    finally:
        pipe.close()


def _limit_memory(memory_mb: int) -> None:
    """Keep a file that unpacks without end from taking the machine's memory."""
    if sys.platform == "win32":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (memory_mb * MEGABYTE, memory_mb * MEGABYTE))


def _inspect(job: dict[str, Any], project: Path, folder: Path, tell: Told) -> int:
    import autobalance as ab
    from autobalance.job.read import read_crankshaft
    from autobalance.job.typed_units import in_base_units

    crankshaft = in_base_units({"crankshaft": job.get("crankshaft", {})})["crankshaft"]
    read_crankshaft(crankshaft, project)  # names a wrong key as a job would
    keys = {key: value for key, value in crankshaft.items() if key != "file"}
    result = ab.inspect(project / str(crankshaft["file"]), progress=tell, **keys)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "report.json").write_text(result.json(), encoding="utf-8")
    (folder / MESH).write_bytes(_buffers(result.crank))
    return 0


def _balance(job: dict[str, Any], project: Path, folder: Path, tell: Told) -> int:
    import autobalance as ab

    asked = ab.Job.from_dict(job, folder=project)
    result = ab.balance(asked, progress=tell)
    result.write(folder, progress=tell)
    (folder / MESH).write_bytes(_buffers(result.crank))
    return result.exit_code


VERBS: dict[str, Callable[[dict[str, Any], Path, Path, Told], int]] = {
    "inspect": _inspect,
    "balance": _balance,
}
"""What the page may ask for."""


def _buffers(crank: ab.Crank) -> bytes:
    """Return a crank in the rotor frame as plain buffers: two counts, corners, triangles; little-endian."""
    import numpy as np

    frame = crank.file_to_rotor
    corners = (crank.vertices_mm @ frame[:3, :3].T + frame[:3, 3]).astype("<f4")
    triangles = crank.triangles.astype("<u4")
    head = struct.pack("<II", len(corners), len(triangles))
    return head + np.ascontiguousarray(corners).tobytes() + np.ascontiguousarray(triangles).tobytes()
