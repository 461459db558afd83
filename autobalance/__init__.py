"""Balance crankshafts from their solid models.

Everything public is here; see the functions' own documentation. Each is loaded when it is first used, so that
``import autobalance`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from autobalance import registry
from autobalance.version import __version__ as __version__

PUBLIC = {
    "AutobalanceError": "errors",
    "BalanceResult": "api.balance",
    "Crank": "api.crank",
    "Job": "job.read",
    "crank_from_mesh": "api.crank_in_memory",
    "crank_from_shape": "api.crank_in_memory",
    "read_crank": "api.crank",
    "read_job": "api.job",
    **registry.functions(),
}
"""Public name → the module that holds it."""
__all__ = sorted([*PUBLIC, "__version__", "theory"])  # noqa: PLE0605, mypy reads the imports below

if TYPE_CHECKING:
    from autobalance import theory as theory
    from autobalance.api.balance import BalanceResult as BalanceResult
    from autobalance.api.balance import balance as balance
    from autobalance.api.batch import batch as batch
    from autobalance.api.bearing import bearing as bearing
    from autobalance.api.bench import bench as bench
    from autobalance.api.calc import calc as calc
    from autobalance.api.compare import compare as compare
    from autobalance.api.crank import Crank as Crank
    from autobalance.api.crank import read_crank as read_crank
    from autobalance.api.crank_in_memory import crank_from_mesh as crank_from_mesh
    from autobalance.api.crank_in_memory import crank_from_shape as crank_from_shape
    from autobalance.api.cycle import cycle as cycle
    from autobalance.api.design import design as design
    from autobalance.api.fem import fem as fem
    from autobalance.api.forces import forces as forces
    from autobalance.api.generate import generate as generate
    from autobalance.api.grade import grade as grade
    from autobalance.api.influence import influence as influence
    from autobalance.api.init import init as init
    from autobalance.api.inspect import inspect as inspect
    from autobalance.api.job import read_job as read_job
    from autobalance.api.jobs import jobs as jobs
    from autobalance.api.machine import machine as machine
    from autobalance.api.nc import nc as nc
    from autobalance.api.orders import orders as orders
    from autobalance.api.parts import parts as parts
    from autobalance.api.recut import recut as recut
    from autobalance.api.rod import rod as rod
    from autobalance.api.rotor import rotor as rotor
    from autobalance.api.schema import schema as schema
    from autobalance.api.shafts import shafts as shafts
    from autobalance.api.sheet import sheet as sheet
    from autobalance.api.strength import strength as strength
    from autobalance.api.study import study as study
    from autobalance.api.torsion import torsion as torsion
    from autobalance.api.verify import verify as verify
    from autobalance.errors import AutobalanceError as AutobalanceError
    from autobalance.job.read import Job as Job
    from autobalance.web_app.serving import app as app


def __getattr__(name: str) -> Any:
    if name == "theory":  # a room of its own that is public
        return import_module("autobalance.theory")
    if name not in PUBLIC:
        raise AttributeError(f"module 'autobalance' has no attribute {name!r}")
    value = getattr(import_module(f"autobalance.{PUBLIC[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
