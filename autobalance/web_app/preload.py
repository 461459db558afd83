"""Modules of every run, loaded once: runs are copies of a process that imported this."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a process with threads cannot be copied safely
os.environ.setdefault("MPLBACKEND", "agg")

import scipy.optimize  # noqa: F401

import autobalance.api.balance
import autobalance.api.inspect
import autobalance.report.bundle
import autobalance.report.page.html
import autobalance.report.pictures.picture
import autobalance.web_app.meshes
import autobalance.web_app.prediction  # noqa: F401
