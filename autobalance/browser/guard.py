"""Checks before every request: host, origin, token; and the headers of every answer."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field

from starlette.responses import JSONResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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
