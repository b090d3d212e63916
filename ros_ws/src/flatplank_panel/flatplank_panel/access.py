# SPDX-License-Identifier: Apache-2.0
"""Access control of the page: a guard checks every request and every web socket.

A token is required on every address, on the loopback address, too: whoever takes charge moves
the machine. The token stands in the URL once (`?token=...`); then a cookie has it, and the URL is
without it. Requests of other web sites in the operator's browser are refused by their Origin and
Host. No other site may show the page in a frame, and the page loads nothing from elsewhere.
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs, parse_qsl, urlencode, urlsplit

COOKIE = "flatplank_token_{}"
"""of each port its own: a browser sends cookies to every port of a host"""
POLICY = "; ".join(
    [
        "default-src 'self'",
        "script-src 'self' 'unsafe-inline' 'unsafe-eval'",  # NiceGUI: Vue compiles its templates
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        "worker-src 'self' blob:",
        "connect-src 'self'",
        "object-src 'none'",
        "base-uri 'self'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    ]
)
HEADERS = (
    (b"content-security-policy", POLICY.encode()),
    (b"x-frame-options", b"DENY"),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
)
"""of every answer"""
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

    def __init__(self, app: App, host: str, token: str) -> None:
        """ValueError without a token."""
        if not token:
            raise ValueError("whoever opens the page can move the machine: a token is needed")
        self.app, self.host, self.token = app, host, token

    async def __call__(self, scope: Scope, receive: Any, send: Any) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        query = scope.get("query_string", b"").decode("latin-1")
        guarded = _with_headers(send)
        status = self.refusal_of(headers, query)
        if status:
            await _refuse(scope, guarded, *status)
        elif _token_in_query(query) and scope["type"] == "http":
            await self._forward(scope, guarded, headers, query)
        else:
            await self.app(scope, receive, guarded)

    def refusal_of(self, headers: dict[str, str], query: str) -> tuple[int, str] | None:
        """Status and reason of a refusal, or None."""
        host = host_of(headers.get("host", ""))
        if is_loopback(self.host) and not is_loopback(host):
            return 400, "this page is served to this machine only"
        origin = headers.get("origin")
        if origin and urlsplit(origin).netloc != headers.get("host", ""):
            return 403, "requests of other sites are refused"
        cookie = SimpleCookie(headers.get("cookie", "")).get(cookie_of(headers))
        brought = _token_in_query(query) or (cookie.value if cookie else "")
        if not hmac.compare_digest(brought.encode(), self.token.encode()):
            return 401, "open the address with the token that flatplank panel has printed"
        return None

    async def _forward(self, scope: Scope, send: Any, headers: dict[str, str], query: str) -> None:
        """Set the cookie and go to the same address without the token."""
        rest = urlencode([pair for pair in parse_qsl(query) if pair[0] != "token"])
        target = scope["path"] + (f"?{rest}" if rest else "")
        value = f"{cookie_of(headers)}={self.token}; HttpOnly; SameSite=Strict; Path=/"
        answer = [(b"location", target.encode("latin-1")), (b"set-cookie", value.encode())]
        await send({"type": "http.response.start", "status": 303, "headers": answer})
        await send({"type": "http.response.body", "body": b""})


def cookie_of(headers: dict[str, str]) -> str:
    """Name of the cookie at the port of a request."""
    return COOKIE.format(urlsplit(f"//{headers.get('host', '')}").port or 80)


def _with_headers(send: Any) -> Any:
    async def wrapped(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message["headers"], *HEADERS]
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
