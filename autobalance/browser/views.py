"""A crank, or what a run left of one, to look at in a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from autobalance import registry
from autobalance.report.pictures.anatomy import crank_picture

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank


@dataclass(frozen=True)
class Still:
    """A picture that shows itself in a notebook."""

    png: bytes

    def _repr_png_(self) -> bytes:
        return self.png


def view(source: object, crank: Crank) -> Any:
    """Return the app's view of a crank or a result, which turns.

    A still picture of the crank where the extra ``notebook`` is not installed.
    """
    if find_spec("anywidget") is None:
        return Still(crank_picture(crank.source.solid.mesh, crank.anatomy, crank.faces))
    app = import_module(
        f"autobalance.{registry.functions()['app']}"
    ).app  # by its name: the app stands on this room
    return app(source)
