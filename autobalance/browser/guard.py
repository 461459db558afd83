"""Checks before every request, and helpers of every endpoint."""

from __future__ import annotations

import contextlib
import gzip
import json
import secrets
from collections.abc import AsyncIterator
from dataclasses import field
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from autobalance.value_classes import dataclass

# Checks before every request: host, origin, token; and the headers of every answer.


TOKEN_HEADER = "x-autobalance-token"
FORBIDDEN, UNAUTHORISED = 403, 401
HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
}
OPEN_PATHS = ("/api/health", "/static/")
"""Paths that need no token: they contain nothing of the project."""


@dataclass(frozen=True)
class Keys:
    """The token of the address, and the cookie: not the token itself, under a name of this start."""

    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    cookie: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    cookie_name: str = field(default_factory=lambda: f"autobalance-{secrets.token_hex(4)}")

    def is_token(self, text: str | None) -> bool:
        """Return whether a text is the token, in a time that gives nothing away."""
        return text is not None and secrets.compare_digest(text.encode(), self.token.encode())

    def is_cookie(self, text: str | None) -> bool:
        """Return whether a text is the cookie's."""
        return text is not None and secrets.compare_digest(text.encode(), self.cookie.encode())


class Guard:
    """An ASGI layer around the app."""

    def __init__(self, app: ASGIApp, keys: Keys, port: int) -> None:
        """Guard ``app``, which listens on ``port``."""
        self._app, self._keys = app, keys
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = [(key.encode(), value.encode()) for key, value in HEADERS.items()]
                message["headers"] = [*message.get("headers", []), *own]
            await send(message)

        refused = self._refused(scope)
        await (refused or self._app)(scope, receive, with_headers)

    def _refused(self, scope: Scope) -> Response | None:
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        origin = headers.get("origin")
        host = headers.get("host")
        if host not in self._hosts or origin not in (None, f"http://{host}"):
            return JSONResponse({"error": "this host or origin may not ask here"}, FORBIDDEN)
        path = scope["path"]
        if path == OPEN_PATHS[0] or path.startswith(OPEN_PATHS[1]):
            return None
        if self._keys.is_token(headers.get(TOKEN_HEADER)):
            return None
        if scope["method"] == "GET" and (path == "/" or has_cookie(headers.get("cookie", ""), self._keys)):
            return None  # the page itself looks at the address's token
        return JSONResponse(
            {"error": "the token is missing or wrong; open the address that was printed"}, UNAUTHORISED
        )


def has_cookie(header: str, keys: Keys) -> bool:
    """Return whether a request's cookies hold ours."""
    pairs = (pair.strip().partition("=") for pair in header.split(";"))
    return any(name == keys.cookie_name and keys.is_cookie(value) for name, _, value in pairs)


# Helpers of every endpoint: bodies read within limits, errors of one line.


LARGEST_JSON = 1 << 20
LARGEST_DRAINED = 1 << 30
BINARY = "application/octet-stream"
PDF = (".pdf", "application/pdf")
PICTURES = {".png": "image/png", ".svg": "image/svg+xml"}


async def body_of(request: Request) -> Any:
    """Return the JSON of a small body; None if it is not JSON."""
    data = b""
    async for chunk in request.stream():
        data += chunk
        if len(data) > LARGEST_JSON:
            return None
    try:
        values = json.loads(data)
        json.dumps(values, ensure_ascii=False).encode()  # half a surrogate pair is not text
    except (ValueError, RecursionError):
        return None
    return values


async def drained(body: AsyncIterator[bytes]) -> None:
    """Read on what is refused: who still sends would not read the answer."""
    size = 0
    with contextlib.suppress(ClientDisconnect, RuntimeError):
        async for chunk in body:
            size += len(chunk)
            if size > LARGEST_DRAINED:
                return


def refused(text: str, status: int) -> Response:
    """Return an error."""
    return JSONResponse({"error": text}, status)


def file_of(path: Path | None, saved_as: str | None = None, to_show: bool = False) -> Response:
    """Return a file: a picture to show, a PDF if ``to_show``, anything else to save; 404 if it is missing."""
    if path is None:
        return refused("there is no such file", 404)
    picture = PICTURES.get(path.suffix.lower())
    if picture is not None:
        return FileResponse(path, media_type=picture)
    if to_show and path.suffix.lower() == PDF[0]:
        return FileResponse(path, media_type=PDF[1], filename=saved_as, content_disposition_type="inline")
    return FileResponse(path, media_type=BINARY, filename=saved_as)


def asset(room: str, path: str) -> bytes:
    """Return a file of the package."""
    return (resources.files(f"autobalance.{room}") / path).read_bytes()


def packed(request: Request, data: bytes, kind: str) -> Response:
    """Return text, packed where the browser takes that: a third of the bytes."""
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(data, media_type=kind)
    headers = {"Content-Encoding": "gzip", "Vary": "Accept-Encoding"}
    return Response(_gzipped(data), media_type=kind, headers=headers)


@lru_cache(maxsize=128)
def _gzipped(data: bytes) -> bytes:
    return gzip.compress(data, 6, mtime=0)


def jsonable(values: Any) -> Any:
    """Return TOML's values with dates and what is not finite as text."""
    if isinstance(values, dict):
        return {key: jsonable(value) for key, value in values.items()}
    if isinstance(values, list):
        return [jsonable(value) for value in values]
    finite = not isinstance(values, float) or abs(values) < float("inf")
    return values if isinstance(values, str | bool | int | float | None) and finite else str(values)
