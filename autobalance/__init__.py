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
    "BalanceResult": "verbs.balance",
    "Crank": "verbs.crank",
    "Job": "job.read",
    "crank_from_mesh": "verbs.crank",
    "crank_from_shape": "verbs.crank",
    "read_crank": "verbs.crank",
    "read_job": "verbs.crank_job",
    **registry.functions(),
}
"""Public name → the module that holds it."""
__all__ = sorted([*PUBLIC, "__version__", "theory"])  # noqa: PLE0605, mypy reads the imports below

if TYPE_CHECKING:
    from autobalance import theory as theory
    from autobalance.browser.serving import app as app
    from autobalance.crank_dynamics.rotor.verb import rotor as rotor
    from autobalance.crank_dynamics.strength.verb import strength as strength
    from autobalance.crank_dynamics.torsion.verb import torsion as torsion
    from autobalance.drawn_cranks.verb import generate as generate
    from autobalance.engines.bearings.verb import bearing as bearing
    from autobalance.engines.cycle.verb import cycle as cycle
    from autobalance.engines.factor import factor as factor
    from autobalance.engines.forces.verb import forces as forces
    from autobalance.engines.parts import parts as parts
    from autobalance.engines.rod import rod as rod
    from autobalance.engines.shafts.verb import shafts as shafts
    from autobalance.errors import AutobalanceError as AutobalanceError
    from autobalance.finite_elements.verb import fem as fem
    from autobalance.formulas.calc import calc as calc
    from autobalance.formulas.grade import grade as grade
    from autobalance.job.read import Job as Job
    from autobalance.machining.verb import nc as nc
    from autobalance.paper.verb import sheet as sheet
    from autobalance.profile_search.verb import design as design
    from autobalance.signals.verb import orders as orders
    from autobalance.studies.batch.verb import batch as batch
    from autobalance.studies.jobs import jobs as jobs
    from autobalance.studies.study.verb import study as study
    from autobalance.test_stands.bench.verb import bench as bench
    from autobalance.test_stands.influence.verb import influence as influence
    from autobalance.test_stands.machine.verb import machine as machine
    from autobalance.verbs.balance import BalanceResult as BalanceResult
    from autobalance.verbs.balance import balance as balance
    from autobalance.verbs.compare import compare as compare
    from autobalance.verbs.crank import Crank as Crank
    from autobalance.verbs.crank import crank_from_mesh as crank_from_mesh
    from autobalance.verbs.crank import crank_from_shape as crank_from_shape
    from autobalance.verbs.crank import read_crank as read_crank
    from autobalance.verbs.crank_job import read_job as read_job
    from autobalance.verbs.init import init as init
    from autobalance.verbs.inspect import inspect as inspect
    from autobalance.verbs.recut import recut as recut
    from autobalance.verbs.schema import schema as schema
    from autobalance.verbs.verify import verify as verify


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
