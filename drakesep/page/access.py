"""Who may speak to the page: a browser on this machine that was told its token.

A page on this machine can be reached by every program and every user on it, and by
every website that its user looks at: by another host name that leads here (DNS
rebinding), by requests that a foreign page makes (cross-site), by a websocket, which no
browser keeps to its origin. So each request must name this machine as its host, come
from no other origin, and have the token: at first in its address, then in a cookie that
scripts cannot read and foreign pages cannot send. What the page may load is said to the
browser too: nothing from elsewhere.
"""

import hmac
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from typing import Any, TypeAlias
from urllib.parse import parse_qs


Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
Application: TypeAlias = Callable[[Message, Receive, Send], Awaitable[None]]
"""As ASGI has it."""

HOSTS = ("127.0.0.1", "localhost")
"""Names of this machine; their port may be that of a tunnel."""
_POLICY = "; ".join(
    (
        "default-src 'self' data: blob:",
        # NiceGUI has its scripts and styles in the page, and makes functions of text.
        "script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:",
        "style-src 'self' 'unsafe-inline'",
        "frame-ancestors 'self'",
        "form-action 'self'",
        "base-uri 'none'",
    )
)
_HEADERS = (
    (b"content-security-policy", _POLICY.encode()),
    (b"referrer-policy", b"no-referrer"),  # an address may hold the token
    (b"x-content-type-options", b"nosniff"),
    (b"cross-origin-resource-policy", b"same-origin"),
)
_WELCOME = """<!doctype html><title>drakesep</title>
<meta http-equiv="refresh" content="0;url=/">"""
"""The page goes on by itself, so that the browser sends the cookie, which it does not
where a foreign page has led here."""


class Guard:
    """Lets through to an application what may speak to it; refuses the rest by 403."""

    def __init__(
        self, application: Application, token: str, cookie: str, once: str | None = None
    ):
        """Prepare.

        Args:
            application: that is guarded.
            token: which a browser must have been told.
            cookie: name of the cookie that holds it; cookies are shared by the ports of
                a host, so it should differ between servers.
            once: another token for an address, which is good for one time.
        """
        self._application, self._token, self._cookie = application, token, cookie
        self._once = once

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Let a request through, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            return await self._application(scope, receive, send)
        headers = _Headers(scope["headers"])
        why = wrong_source(headers.get("host"), headers.get("origin"))
        if why is None and self._is_known(headers):
            return await self._application(scope, receive, _with_headers(send))
        if why is None and scope["type"] == "http" and self._is_told(scope):
            cookie = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"
            return await _answer(send, 200, _WELCOME, ("set-cookie", cookie))
        if scope["type"] == "websocket":  # before it is accepted: 403
            return await send({"type": "websocket.close", "code": 1008})
        return await _answer(send, 403, why or "the token is missing or wrong")

    def _is_known(self, headers: "_Headers") -> bool:
        """Return whether the cookie has the token."""
        # Cookies are shared by all programs of a host, which write them as they like.
        for each in (headers.get("cookie") or "").split(";"):
            name, _, value = each.strip().partition("=")
            if name == self._cookie and _same(value, self._token):
                return True
        return False

    def _is_told(self, scope: Message) -> bool:
        """Return whether the address has the token."""
        query = parse_qs(scope["query_string"].decode("latin-1"))
        told = query.get("token", [""])[-1]
        if self._once is not None and _same(told, self._once):
            self._once = None
            return True
        return _same(told, self._token)


def _same(told: str, token: str) -> bool:
    return hmac.compare_digest(told.encode(), token.encode())


class _Headers(dict[str, str]):
    """The headers of a request, by their names; of several, the last."""

    def __init__(self, headers: Iterable[tuple[bytes, bytes]]):
        super().__init__(
            (name.decode("latin-1").lower(), value.decode("latin-1"))
            for name, value in headers
        )


def wrong_source(host: str | None, origin: str | None) -> str | None:
    """Return what is wrong with where a request goes and comes from; None if nothing.

    Args:
        host: that it names, with its port.
        origin: of the page that makes it; None if it says nothing, as a browser that
            opens an address does.
    """
    name = (host or "").rpartition(":")[0] or host
    if name not in HOSTS:
        return f"the host must be {' or '.join(HOSTS)}, got {host}"
    if origin is not None and origin != f"http://{host}":
        return f"the origin must be http://{host}, got {origin}"
    return None


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", ()), *_HEADERS]
        await send(message)

    return sent


async def _answer(
    send: Send, status: int, text: str, *headers: tuple[str, str]
) -> None:
    kind = "text/html" if text.startswith("<") else "text/plain"
    head = [("content-type", f"{kind}; charset=utf-8"), ("cache-control", "no-store")]
    pairs = [(name.encode(), value.encode()) for name, value in (*head, *headers)]
    start = {"type": "http.response.start", "status": status}
    await send({**start, "headers": [*pairs, *_HEADERS]})
    await send({"type": "http.response.body", "body": text.encode()})
