"""Jobs as objects."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from autobalance.job import Job
from autobalance.job.read import load


def read_job(path: str | Path, settings: Sequence[str] = ()) -> Job:
    """Read a job file.

    Parameters
    ----------
    path : path
        A TOML file, or a workbook as ``init`` writes it; the crank file it names is relative to it.
    settings : sequence of str
        Keys to set before anything is checked: ``["balance.factor=0.5"]``.

    Returns
    -------
    Job
        ``Job.from_dict`` makes one of a mapping.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> file = bundled_folder() / "crf250r" / "drafted" / "factor-0.28.toml"
    >>> read_job(file, ["balance.factor=0.5"]).balance.factor
    0.5
    """
    return load(path, settings)
