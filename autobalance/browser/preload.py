"""Modules of every run, loaded once: runs are copies of a process that imported this."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process with threads cannot be copied safely
os.environ.setdefault("MPLBACKEND", "agg")

import scipy.optimize  # noqa: F401
