"""A notification on the desktop of the user."""

from __future__ import annotations

import html
import shutil
from collections.abc import Mapping

from launcher.base.text import escape

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_SESSIONS = ("DBUS_SESSION_BUS_ADDRESS", "WAYLAND_DISPLAY", "DISPLAY")
_NOTIFICATIONS = "org.freedesktop.Notifications"
_PATH = "/org/freedesktop/Notifications"
MAX_TEXT = 300


def sender(env: Mapping[str, str]) -> str | None:
    """The program that shows one: notify-send or busctl; None without it, or without a desktop."""
    if not any(env.get(name) for name in _SESSIONS):
        return None
    found = (shutil.which(name, path=env.get("PATH")) for name in ("notify-send", "busctl"))
    return next(filter(None, found), None)


def words(program: str, fault: Mapping[str, Any]) -> list[str]:
    """The command that shows a fault."""
    title = f"{fault['state']}: {fault['fault']}"[:MAX_TEXT]
    parts = (fault["seen"], fault["cause"])
    # Desktops take the body as markup.
    body = html.escape("; ".join(filter(None, parts))[:MAX_TEXT], quote=False)
    title, body = (escape(text, keep="") for text in (title, body))
    if program.endswith("notify-send"):
        return [program, "--app-name=launcher", "--", title, body]
    call = ("--user", "call", "--", _NOTIFICATIONS, _PATH, _NOTIFICATIONS, "Notify")
    return [program, *call, "susssasa{sv}i", "launcher", "0", "", title, body, "0", "0", "-1"]
