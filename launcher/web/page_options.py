"""The values of the options about the page in the browser, for runs and for the verb `web`."""

from __future__ import annotations

import os

from launcher.base.errors import UsageError
from launcher.base.model.run_options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_tls(word: str) -> tuple[str, str]:
    """The paths of the certificate and of the key; ValueError."""
    certificate, comma, key = word.partition(",")
    if not (certificate and comma and key):
        raise ValueError(f"'{word}' is not CERT,KEY: two files")
    for path in (certificate, key):
        if not os.access(path, os.R_OK):
            raise ValueError(f"cannot read '{path}'")
    return os.path.abspath(certificate), os.path.abspath(key)


def check(options: RunOptions) -> None:
    """UsageError for options that exclude each other, or where a library is missing."""
    if not options.web:
        raise UsageError("--web-port, --web-host and the others need --web")
    if not options.control:
        raise UsageError("--web needs the control socket and excludes --no-control")
    require_page("--web")
    if options.web_token is not None:
        from launcher.web.access import token_in

        token_in(options.web_token)


def require_page(what: str) -> None:
    """UsageError with the command that installs what the page needs."""
    from launcher.packages.extras import require

    for package in ("nicegui", "starlette", "uvicorn", "websockets", "prometheus_client"):
        require("web", package, what)


def settings_of(options: RunOptions, socket: str) -> dict[str, Any]:
    """The settings of `launcher.web.web_server`."""
    certificate, key = options.web_tls or (None, None)
    return {
        "socket": socket,
        "host": options.web_host or "127.0.0.1",
        "port": options.web_port,
        "token_file": options.web_token,
        "certificate": certificate,
        "key": key,
        "read_only": options.web_read_only,
    }
