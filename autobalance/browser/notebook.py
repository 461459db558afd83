"""The app's view of a crank inline in a notebook: the page's own modules, in one widget."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from autobalance.errors import FormatError

if TYPE_CHECKING:
    from autobalance.verbs.balance import BalanceResult
    from autobalance.verbs.crank import Crank

MODULES = ("buffers.js", "anatomy.js", "coarse.js", "picking.js", "pieces.js", "view.js", "notebook.js")
"""Modules of the widget, in the order in which one needs the other."""
OUTSIDE = re.compile(r"^import .*?;\n|^export (?!default)|^const T = window\.THREE;\n", re.MULTILINE)
"""Modules that only separate modules need."""


def view_of(source: Crank | BalanceResult) -> Any:
    """Return a widget that shows a crank, or what a run left of one and took from it.

    Raises
    ------
    FormatError
        If the extra ``notebook`` is not installed.
    """
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise FormatError(
            "a crank in a notebook needs anywidget: pip install 'autobalance[notebook]'"
        ) from None

    class CrankView(anywidget.AnyWidget):
        _esm = script()
        _css = style()
        kind = traitlets.Unicode().tag(sync=True)
        data = traitlets.Bytes().tag(sync=True)

    kind, data = buffer_of(source)
    return CrankView(kind=kind, data=data)


def buffer_of(source: Crank | BalanceResult) -> tuple[str, bytes]:
    """Return the kind, ``crank`` or ``result``, and the buffer that the page would be sent."""
    from autobalance.browser.meshes import recognised_mesh, result_view
    from autobalance.verbs.balance import BalanceResult

    if isinstance(source, BalanceResult):
        return "result", result_view(source)
    import autobalance as ab

    return "crank", recognised_mesh(ab.inspect(source))


def script() -> str:
    """Return the page's modules as one that imports nothing."""
    from autobalance.browser.guard import asset

    parts = [asset("browser", f"static/{name}").decode() for name in MODULES]
    three = asset("report", "assets/three.min.js").decode()
    return "\n".join([three, "const T = THREE;", *(OUTSIDE.sub("", part) for part in parts)])


def style() -> str:
    from autobalance.browser.guard import asset

    return asset("browser", "static/notebook.css").decode()
