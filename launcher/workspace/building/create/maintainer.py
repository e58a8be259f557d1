"""Who maintains a new package: what the command line says, else git, else the user."""

from __future__ import annotations

import getpass
import subprocess

from launcher.base.errors import UsageError
from launcher.workspace.building.create.names import is_email

UNKNOWN_EMAIL = "user@example.com"
_TIMEOUT_S = 5.0


def maintainer(name: str | None, email: str | None, folder: str) -> tuple[str, str]:
    """(name, e-mail), from git's settings for this folder where they are not given; UsageError."""
    if email is not None and not is_email(email):
        raise UsageError(f"--maintainer-email: '{email}' is not an e-mail address")
    known = email or _git("user.email", folder)
    return (
        name or _git("user.name", folder) or _user(),
        known if is_email(known) else UNKNOWN_EMAIL,
    )


def _git(setting: str, folder: str) -> str:
    """The setting; empty if it is not set, or there is no git."""
    try:
        asked = subprocess.run(
            ["git", "config", "--get", setting],
            cwd=folder,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    value = asked.stdout.strip()
    return value if value.isprintable() else ""


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a user id without a name, as in containers
        return "user"
