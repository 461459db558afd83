"""Reading of CAD files from elsewhere in a separate process: a damaged one can bring the kernel down.

Of 300 STEP files with a line or a number changed, some 40 ended the kernel's reader by a segmentation
fault, and three kept it for ever. Here that is one line. The answer is the kernel's own binary form, which
keeps every surface to the bit.
"""

from __future__ import annotations

import signal
from typing import Any, Final

from autobalance.child_process import Children, ended_after
from autobalance.errors import FormatError
from autobalance.solid.cad.cad_file import CadFile, NamedBody
from autobalance.solid.cad.kernel import kernel_failures, require_kernel, shape_bytes, shape_of_bytes
from autobalance.solid.cad.tessellation import Fineness, tessellate

LEAST_S: Final = 20.0
S_PER_MB: Final = 10.0
"""Processor time after which a reader is ended [s]; the largest file tried, of 30 MB, takes 40 s."""
KINDS: Final = ("step", "iges", "brep")


def read_foreign_file(kind: str, data: bytes, longest_s: float | None = None) -> CadFile:
    """Read the solids of a CAD file, in a separate process.

    Parameters
    ----------
    kind : str
        One of ``KINDS``.
    data : bytes
    longest_s : float, optional
        Processor time after which the reader is ended [s]; by the size of the file where None.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, or the file cannot be read, or brings the kernel down.
    SolidError
        If its surfaces do not close.
    """
    with readers.one() as child:
        longest_s = LEAST_S + S_PER_MB * len(data) / 1e6 if longest_s is None else longest_s
        child.send(kind, data, longest_s, Fineness.usual())
        require_kernel(kind.upper())  # meanwhile: loading it takes as long here as there
        answer = child.receive()
        if answer is None:
            raise FormatError(_end_message(kind, child.end(), longest_s))
    bodies = tuple(NamedBody(name, shape_of_bytes(body), place) for name, place, body in answer["bodies"])
    return CadFile(bodies, answer["unit"], answer["repairs"])


readers: Final = Children(__name__)
"""Kept for the next file: the kernel takes a second to load."""


def _end_message(kind: str, code: int, longest_s: float) -> str:
    if code == -signal.SIGPROF:
        why = f"keeps the CAD kernel busy for more than {longest_s:.3g} s"
    elif code < 0:
        why = f"brings the CAD kernel down ({signal.Signals(-code).name})"
    else:
        why = f"ends the CAD kernel's process (exit code {code})"
    return (
        f"the {kind.upper()} file {why}; expected a sound file: "
        "export it again, or open and save it in a CAD program"
    )


def answer(kind: str, data: bytes, longest_s: float, fineness: Fineness) -> dict[str, Any]:
    """Read a file, in the process that reads: bodies with their triangles as bytes, unit and repairs.

    Bodies are tessellated here too: on a STEP file with one number of a curve changed, which reads well,
    that never ends.
    """
    from autobalance.solid.cad.brep_file import read_brep_file
    from autobalance.solid.cad.iges_file import read_iges_file
    from autobalance.solid.cad.step_file import read_step_file

    require_kernel(kind.upper())
    with ended_after(longest_s), kernel_failures(f"the {kind.upper()} file"):
        file = {"step": read_step_file, "iges": read_iges_file, "brep": read_brep_file}[kind](data)
        for one in file.bodies:
            tessellate(one.body, fineness)
    bodies = [(one.name, one.place, shape_bytes(one.body)) for one in file.bodies]
    return {"bodies": bodies, "unit": file.unit, "repairs": file.repairs}
