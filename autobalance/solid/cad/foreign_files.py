"""CAD files from elsewhere are read in a process of their own: a damaged one can bring the kernel down.

Of 300 STEP files with a line or a number changed, some 40 ended the kernel's reader by a segmentation
fault, and three kept it for ever. Here that is one line. What is sent back is the kernel's own binary form,
which keeps every surface to the bit.
"""

from __future__ import annotations

import atexit
import contextlib
import pickle
import signal
import struct
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any, BinaryIO, Final

from autobalance.errors import AutobalanceError, FormatError, SolidError
from autobalance.solid.cad.cad_file import CadFile, NamedBody
from autobalance.solid.cad.kernel import kernel_failures, require_kernel

MOST_S: Final = 600.0
"""A reader that takes longer is ended; the largest file tried, of 30 MB, takes 40 s."""
KINDS: Final = ("step", "iges", "brep")


def read_foreign_file(kind: str, data: bytes) -> CadFile:
    """Read the solids of a CAD file, in a process of its own.

    Parameters
    ----------
    kind : str
        One of ``KINDS``.
    data : bytes

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, or the file cannot be read, or brings the kernel down.
    SolidError
        If its surfaces do not close.
    """
    with _lock:
        child = _running_child()
        child.send((kind, data))
        try:
            require_kernel(kind.upper())  # meanwhile: loading it takes as long here as there
            answer = child.receive()
        except BaseException:
            child.end()
            raise
        if answer is None:
            raise FormatError(_what_ended(kind, child.end()))
    if isinstance(answer, AutobalanceError):
        raise answer
    bodies = tuple(NamedBody(name, _shape(body), place) for name, place, body in answer["bodies"])
    return CadFile(bodies, answer["unit"], answer["repairs"])


class _Child:
    """The process that reads, and the way to it."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", "from autobalance.solid.cad.foreign_files import serve; serve()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )

    def send(self, message: Any) -> None:
        assert self.process.stdin
        try:
            _write(self.process.stdin, message)
        except BrokenPipeError:  # it has ended: ``receive`` finds that out
            return

    def receive(self) -> Any:
        """Return what was read; None if the process ended instead."""
        assert self.process.stdout
        return _read(self.process.stdout)

    def end(self) -> int:
        """End the process, and return its exit code: -11 where a segmentation fault ended it."""
        global _child  # noqa: PLW0603
        _child = None
        assert self.process.stdin
        assert self.process.stdout
        self.process.stdout.close()
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        try:
            return self.process.wait(timeout=0.5)  # one that crashed has its code in a moment
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


_lock = threading.Lock()
_child: _Child | None = None


def _running_child() -> _Child:
    """Return the process that reads, started if there is none: the kernel takes a second to load."""
    global _child  # noqa: PLW0603
    if _child is None or _child.process.poll() is not None:
        if _child is None:
            atexit.register(_end_child)
        _child = _Child()
    return _child


def _end_child() -> None:
    if _child is not None:
        _child.process.kill()
        _child.end()


def _what_ended(kind: str, code: int) -> str:
    if code == -signal.SIGALRM:
        why = f"keeps the CAD kernel busy for more than {MOST_S:g} s"
    elif code < 0:
        why = f"brings the CAD kernel down ({signal.Signals(-code).name})"
    else:
        why = f"ends the CAD kernel's process (exit code {code})"
    return (
        f"the {kind.upper()} file {why}; expected a sound file: "
        "export it anew, or open and save it in a CAD program"
    )


def serve() -> None:
    """Read one file after the other for the process that started this one, until it closes the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent's to answer, who then closes the pipe
    requests, answers = sys.stdin.buffer, sys.stdout.buffer
    while (request := _read(requests)) is not None:
        _alarm(MOST_S)
        answer = _answer(*request)
        _alarm(0.0)
        _write(answers, answer)


def _alarm(seconds: float) -> None:
    """Let the system end this process after a while, in whatever it is; 0 takes that back."""
    if hasattr(signal, "setitimer"):  # not on Windows
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _answer(kind: str, data: bytes) -> dict[str, Any] | AutobalanceError:
    from autobalance.solid.cad.brep_file import read_brep_file
    from autobalance.solid.cad.iges_file import read_iges_file
    from autobalance.solid.cad.step_file import read_step_file

    try:
        require_kernel(kind.upper())
        with kernel_failures(f"the {kind.upper()} file"):
            file = {"step": read_step_file, "iges": read_iges_file, "brep": read_brep_file}[kind](data)
    except (FormatError, SolidError) as error:
        return error
    bodies = [(one.name, one.place, _bytes(one.body)) for one in file.bodies]
    return {"bodies": bodies, "unit": file.unit, "repairs": file.repairs}


def _bytes(shape: Any) -> bytes:
    """Return a shape in the kernel's binary form."""
    from OCP.BinTools import BinTools

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shape"
        if not BinTools.Write_s(shape, str(path)):
            raise SolidError("the CAD kernel could not hand a solid on")
        return path.read_bytes()


def _shape(data: bytes) -> Any:
    """Return the shape that ``_bytes`` wrote."""
    from OCP.BinTools import BinTools
    from OCP.TopoDS import TopoDS_Shape

    shape: Any = TopoDS_Shape()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shape"
        path.write_bytes(data)
        if not BinTools.Read_s(shape, str(path)):
            raise SolidError("the CAD kernel could not take a solid over")
    return shape


LENGTH: Final = struct.Struct("<Q")


def _write(pipe: BinaryIO | Any, message: Any) -> None:
    data = pickle.dumps(message)
    pipe.write(LENGTH.pack(len(data)))
    pipe.write(data)
    pipe.flush()


def _read(pipe: BinaryIO | Any) -> Any:
    """Return the next message, or None where the other side has ended."""
    head = pipe.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    data = pipe.read(LENGTH.unpack(head)[0])
    return pickle.loads(data)
