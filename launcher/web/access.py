"""Who may see the page: a token in the link, then a cookie; the Host and Origin of requests."""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import secrets
import shlex
import socket
import stat
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import urlsplit

from launcher.base.errors import UsageError

TOKEN_BYTES = 24
_SHORTEST_TOKEN = 16
_LOCAL_NAMES = ("localhost", "127.0.0.1", "::1")


def new_token() -> str:
    """A random token, for a link."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def token_in(file: str) -> str:
    """The token that a file holds; UsageError if others may read it or it is too short."""
    path = Path(file)
    try:
        mode = path.stat().st_mode
        token = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not text"
        raise UsageError(f"{path}: cannot read the token: {reason}") from None
    if stat.S_IMODE(mode) & 0o077:
        raise UsageError(
            f"{path}: other users may read the token", hint=f"chmod 600 {shlex.quote(file)}"
        )
    if len(token) < _SHORTEST_TOKEN or not token.isascii() or not token.isprintable():
        raise UsageError(
            f"{path}: a token is one line of at least {_SHORTEST_TOKEN} printable ASCII characters"
        )
    return token


def is_loopback(host: str) -> bool:
    """Whether only this machine can connect to an address or name."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Access:
    """Decides about requests by their headers. `host` is what the server listens at.

    A web page of somebody else can make the browser send requests here: by its own name that it
    has pointed to this machine (DNS rebinding; the Host header shows it), or across sites (the
    Origin header shows it; a WebSocket is not stopped by the same-origin policy).
    """

    def __init__(self, token: str, host: str, *, secure: bool) -> None:
        self._token = token
        # Neither is the token: a browser sends a cookie to other ports of this host, too, where
        # another user may listen. For the feed the key is needed besides, which no cookie holds.
        self._pass = _derived(token, "cookie")
        self.feed_key = _derived(token, "feed")
        self._secure = secure
        self._is_anywhere = not is_loopback(host)
        names = {*_LOCAL_NAMES, host.lower()}
        if self._is_anywhere:
            names |= {socket.gethostname().lower(), socket.getfqdn().lower()}
        self._names = names
        # Cookies do not distinguish ports: two runs on one host need different names.
        self._cookie = f"launcher-{hashlib.sha256(token.encode()).hexdigest()[:12]}"

    def is_known_host(self, header: str | None) -> bool:
        """Whether the Host header names this machine; any port, which ssh -L may change."""
        name = _host_name(header)
        if name is None:
            return False
        return name in self._names or (self._is_anywhere and _is_address(name))

    def is_same_origin(self, origin: str | None, host: str | None) -> bool:
        """Whether a WebSocket, or a request that changes something, comes from our own page."""
        scheme = "https" if self._secure else "http"
        return origin is not None and host is not None and origin == f"{scheme}://{host}"

    def is_token(self, given: str | None) -> bool:
        return given is not None and _is_same(given, self._token)

    def is_feed_key(self, given: object) -> bool:
        return isinstance(given, str) and _is_same(given, self.feed_key)

    def has_cookie(self, cookies: Mapping[str, str]) -> bool:
        given = cookies.get(self._cookie)
        return given is not None and _is_same(given, self._pass)

    def cookie(self) -> str:
        """The value of Set-Cookie for a page that came with the token."""
        secure = "; Secure" if self._secure else ""
        return f"{self._cookie}={self._pass}; Path=/; HttpOnly; SameSite=Strict{secure}"


def _derived(token: str, purpose: str) -> str:
    return hmac.new(token.encode(), purpose.encode(), hashlib.sha256).hexdigest()


def _is_same(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode(errors="replace"), wanted.encode())


def _host_name(header: str | None) -> str | None:
    try:
        return urlsplit(f"//{header}").hostname if header else None
    except ValueError:
        return None


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
