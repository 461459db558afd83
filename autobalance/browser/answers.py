"""Helpers of every endpoint: bodies read within limits, errors of one line."""

from __future__ import annotations

import contextlib
import gzip
import json
from collections.abc import AsyncIterator
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response

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
