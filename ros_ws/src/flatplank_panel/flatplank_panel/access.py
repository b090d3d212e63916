# SPDX-License-Identifier: Apache-2.0
"""Access control of the page: a guard checks every request and every web socket.

On the loopback address every user of this machine has access. On any other address a token is
required, once in the URL (`?token=...`), then by a cookie. Requests of other web sites in the
operator's browser are refused by their Origin and Host, on any address.
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

COOKIE = "flatplank_token"
Scope = MutableMapping[str, Any]
App = Callable[[Scope, Any, Any], Awaitable[None]]


def is_loopback(host: str) -> bool:
    """True for an address that only this machine reaches."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def address(host: str, port: int, token: str = "") -> str:
    """URL for a browser; for a wildcard address, one that other machines can reach."""
    if host in ("0.0.0.0", "::"):
        host = _outward()
    name = f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")


def _outward() -> str:
    """Address of this machine towards other machines; its host name when there is no route."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        try:
            s.connect(("192.0.2.1", 9))  # sends nothing, only selects the interface
        except OSError:
            return socket.gethostname()
        return s.getsockname()[0]


def host_of(header: str) -> str:
    """Name or address in a Host header, without port."""
    return urlsplit(f"//{header}").hostname or ""


class Guard:
    """ASGI middleware that checks every request."""

    def __init__(self, app: App, host: str, token: str = "") -> None:
        """`token` may be empty only for a loopback `host`."""
        if not token and not is_loopback(host):
            raise ValueError(f"{host} can be reached from other machines: a token is needed")
        self.app, self.host, self.token = app, host, token

    async def __call__(self, scope: Scope, receive: Any, send: Any) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        status = self.refusal_of(headers, scope.get("query_string", b"").decode("latin-1"))
        if status:
            await _refuse(scope, send, *status)
            return
        given = _token_in_query(scope.get("query_string", b"").decode("latin-1"))
        await self.app(scope, receive, self._with_cookie(send) if given and self.token else send)

    def refusal_of(self, headers: dict[str, str], query: str) -> tuple[int, str] | None:
        """Status and reason of a refusal, or None."""
        host = host_of(headers.get("host", ""))
        if not self.token and not is_loopback(host):
            return 400, "this page is served to this machine only"
        origin = headers.get("origin")
        if origin and urlsplit(origin).netloc != headers.get("host", ""):
            return 403, "requests of other sites are refused"
        if self.token:
            cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
            brought = _token_in_query(query) or (cookie.value if cookie else "")
            if not hmac.compare_digest(brought.encode(), self.token.encode()):
                return 401, "open the address with the token that flatplank panel has printed"
        return None

    def _with_cookie(self, send: Any) -> Any:
        async def wrapped(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                value = f"{COOKIE}={self.token}; HttpOnly; SameSite=Strict; Path=/"
                message["headers"] = [*message["headers"], (b"set-cookie", value.encode())]
            await send(message)

        return wrapped


def _token_in_query(query: str) -> str:
    return parse_qs(query).get("token", [""])[0]


async def _refuse(scope: Scope, send: Any, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": reason.encode()})
