"""Who may talk to the workbench: this machine's browser, with the token of the URL that was printed.

A page on another site could send requests to the loopback (DNS rebinding, forged forms), so the Host header
must name this server and every request, web sockets included, must carry the token: first in the URL, then
in a cookie that only this site sends.
"""

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
App = Callable[[Scope, Callable[[], Awaitable[Any]], Callable[[Any], Awaitable[None]]], Awaitable[None]]


class Guard:
    """ASGI middleware that refuses strangers. token: of this run; hosts: `name:port` that are this server."""

    def __init__(self, app: App, token: str, hosts: frozenset[str], cookie: str):
        self.app, self.token, self.hosts, self.cookie = app, token, hosts, cookie

    async def __call__(self, scope: Scope, receive: Any, send: Any) -> None:
        """Let a request pass or answer 403."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        in_url = _equal(parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0], self.token)
        known = in_url or _equal(_cookie(headers.get("cookie", ""), self.cookie), self.token)
        if headers.get("host", "") not in self.hosts or not known or not self._same_site(headers):
            await _refuse(scope, send)
        elif in_url and scope["type"] == "http":
            await self.app(scope, receive, self._with_cookie(send))
        else:
            await self.app(scope, receive, send)

    def _same_site(self, headers: dict[str, str]) -> bool:
        origin = headers.get("origin")
        return origin is None or origin.partition("://")[2] in self.hosts

    def _with_cookie(self, send: Any) -> Any:
        value = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict".encode("latin-1")

        async def answered(message: Any) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), (b"set-cookie", value)]
            await send(message)

        return answered


def _equal(given: str, token: str) -> bool:
    return secrets.compare_digest(given.encode("utf-8", "replace"), token.encode())


def _cookie(header: str, name: str) -> str:
    try:
        found = SimpleCookie(header).get(name)
    except Exception:  # a damaged header is no cookie
        return ""
    return found.value if found else ""


async def _refuse(scope: Scope, send: Any) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008})
        return
    text = b"This workbench answers only to the link that `pyident open` printed."
    await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]})
    await send({"type": "http.response.body", "body": text})
