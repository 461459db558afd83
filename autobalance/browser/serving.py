"""``app``: the whole program in a browser on this machine."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import webbrowser
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, overload

from autobalance.errors import FileError, FormatError, UsageError, system_reason

if TYPE_CHECKING:
    from autobalance.verbs.balance import BalanceResult
    from autobalance.verbs.crank import Crank


@overload
def app(source: Crank | BalanceResult) -> Any: ...


@overload
def app(
    source: str | Path | None = None,
    *,
    port: int = 0,
    browser: bool = True,
    project: str | Path = "autobalance-project",
    max_upload_mb: int = 512,
    memory_mb: int = 4096,
    told: Callable[[str], None] | None = None,
) -> None: ...


def app(
    source: str | Path | Crank | BalanceResult | None = None,
    *,
    port: int = 0,
    browser: bool = True,
    project: str | Path = "autobalance-project",
    max_upload_mb: int = 512,
    memory_mb: int = 4096,
    told: Callable[[str], None] | None = None,
) -> Any:
    """Serve the app on 127.0.0.1 until it is interrupted; ``told`` gets its address, with a token, first.

    A crank or a result as an object is shown inline in a notebook instead, and nothing is served.

    Parameters
    ----------
    source : path, Crank, BalanceResult or None
        Crank, job, report or its folder that is copied into the project; None: an empty project. An object:
        shown in a notebook.
    port : int
        Port on 127.0.0.1; 0 is any that is free.
    browser : bool
        Print the address without opening it. True: open it.
    project : path
        Folder of the project, made where it is missing, taken up where it was left.
    max_upload_mb : int
        Largest file that may be uploaded [MB].
    memory_mb : int
        Memory of one run [MB].
    told : callable or None
        Called with the address.

    Returns
    -------
    widget or None
        The view of an object; None once the server has ended.

    Raises
    ------
    FormatError
        If the extra ``app`` is not installed, or ``notebook`` for an object.
    UsageError
        If a number is impossible.
    FileError
        If the project cannot be made, a file cannot be copied, or the port is taken.
    """
    if source is not None and not isinstance(source, str | Path):
        from autobalance.browser.notebook import view_of

        return view_of(source)
    _serve(source, port, browser, project, max_upload_mb, memory_mb, told)
    return None


def _serve(
    source: str | Path | None,
    port: int,
    browser: bool,
    project: str | Path,
    max_upload_mb: int,
    memory_mb: int,
    told: Callable[[str], None] | None,
) -> None:
    if not 0 <= port <= 65535:
        raise UsageError(f"--port is {port}; must be 0 to 65535")
    for name, number in (("--max-upload-mb", max_upload_mb), ("--memory-mb", memory_mb)):
        if number < 1:
            raise UsageError(f"{name} is {number}; must be at least 1")
    try:
        import starlette  # noqa: F401
        import uvicorn
    except ImportError:
        raise FormatError("the app needs starlette and uvicorn: pip install 'autobalance[app]'") from None
    if source is not None and not Path(source).exists():
        raise FileError(f"{source} does not exist")
    umask = os.umask(0o077)  # what the project holds is this user's alone
    try:
        _serve_project(uvicorn, source, port, browser, Path(project), max_upload_mb, memory_mb, told)
    finally:
        os.umask(umask)


def _serve_project(
    uvicorn: Any,
    source: str | Path | None,
    port: int,
    browser: bool,
    project: Path,
    max_upload_mb: int,
    memory_mb: int,
    told: Callable[[str], None] | None,
) -> None:
    from autobalance.browser.guard import Keys
    from autobalance.browser.opening import open_in
    from autobalance.browser.project import Project
    from autobalance.browser.runs import Runs
    from autobalance.browser.server import application, listening_socket

    opened = Project.at(project)
    if source is not None:
        open_in(Path(source), opened)
    try:
        listener = listening_socket(port)
    except OSError as error:
        raise FileError(f"port {port} cannot be listened on: {system_reason(error)}") from None
    number = int(listener.getsockname()[1])
    keys, runs = Keys(), Runs(opened, memory_mb)
    config = uvicorn.Config(
        application(opened, runs, keys, number, max_upload_mb),
        log_level="critical",
        access_log=False,
        lifespan="off",
        ws="none",
        server_header=False,
        timeout_graceful_shutdown=1,
    )
    server = uvicorn.Server(config)
    address = f"http://127.0.0.1:{number}/?token={keys.token}"
    redirect: Path | None = None
    try:
        with _ending(server):  # from here on: who reads the address may end it at once
            if told is not None:
                told(address)
            if browser:
                redirect = _redirect(address)
                webbrowser.open(redirect.as_uri())
            server.run(sockets=[listener])
    finally:
        if redirect is not None:
            redirect.unlink(missing_ok=True)
        runs.close()
        listener.close()


def _redirect(address: str) -> Path:
    """Write a page, for this user alone, that leads to an address: all users see a browser's command line."""
    handle, name = tempfile.mkstemp(prefix="autobalance-", suffix=".html")
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        stream.write(f'<!doctype html><title>…</title><meta http-equiv="refresh" content="0; url={address}">')
    return Path(name)


class _ending:  # noqa: N801 - a context, read as words
    """SIGTERM, SIGHUP and Ctrl-C end the server, without a traceback."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self._before: dict[int, Any] = {}

    def __enter__(self) -> None:
        def end(number: int, _: FrameType | None) -> None:
            self._server.should_exit = True

        self._server.install_signal_handlers = lambda: None
        self._server.capture_signals = _nothing
        names = ("SIGINT", "SIGTERM", *(() if sys.platform == "win32" else ("SIGHUP",)))
        for name in names:
            number = int(getattr(signal, name))
            self._before[number] = signal.signal(number, end)

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)


class _nothing:  # noqa: N801
    """Replace uvicorn's own handlers, which raise the signal again."""

    def __enter__(self) -> None:
        return None

    def __exit__(self, *_: object) -> None:
        return None
