"""The files of a robot: a Debian or Ubuntu with systemd, as the machine's, made once and cached."""

from __future__ import annotations

import fcntl
import hashlib
import os
import platform
import shutil
import subprocess
from functools import cache
from pathlib import Path

from tests.support.hosts.tool import ToolError, run_tool

USER, USER_ID = "robot", 1000
# Programs of the machine run there, so it is of the same release. `python3` brings the libraries
# that any Python needs.
PACKAGES = (
    "dbus",
    "dbus-user-session",
    "iproute2",
    "libpam-systemd",
    "openssh-server",
    "procps",
    "python3",
    "python3-venv",
    "rsync",
    "systemd",
    "systemd-sysv",
)
_BUILD_TIMEOUT_S = 500.0

# $1 tree, $2 user, $3 its id. A user that lingers has a `systemd --user` from boot on.
_FINISH = """set -e
chroot "$1" useradd --create-home --shell /bin/bash --uid "$3" "$2"
mkdir -p "$1/var/lib/systemd/linger" "$1/var/log/journal"
touch "$1/var/lib/systemd/linger/$2"
rm -f "$1"/etc/ssh/ssh_host_*
for unit in apt-daily.timer apt-daily-upgrade.timer console-getty.service dpkg-db-backup.timer \\
            e2scrub_all.timer fstrim.timer systemd-firstboot.service; do
  ln -sf /dev/null "$1/etc/systemd/system/$unit"
done
"""


class NoTreeError(Exception):
    """The tree is not in the cache and cannot be made."""


@cache
def tree() -> Path:
    """The folder with the files, made by the first process that asks; nobody writes to it."""
    name = f"tree-{hashlib.sha256(_recipe().encode()).hexdigest()[:12]}"
    folder = _cache() / name
    folder.parent.mkdir(parents=True, exist_ok=True)
    with open(folder.with_name(f"{name}.lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            _make(folder)
    return folder


def _cache() -> Path:
    """`LAUNCHER_LAB_CACHE`, or a folder in the user's cache."""
    user = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(os.environ.get("LAUNCHER_LAB_CACHE") or f"{user}/launcher-lab").expanduser()


def _recipe() -> str:
    return f"{_release()} {' '.join(PACKAGES)} {_FINISH}"


def _release() -> str:
    return platform.freedesktop_os_release().get("VERSION_CODENAME", "stable")


def _components() -> str:
    """Ubuntu's python3-venv is not in `main`."""
    is_ubuntu = platform.freedesktop_os_release().get("ID") == "ubuntu"
    return "main,universe" if is_ubuntu else "main"


def _make(folder: Path) -> None:
    making = folder.with_name(f"{folder.name}.part")
    shutil.rmtree(making, ignore_errors=True)
    packages = f"--include={','.join(PACKAGES)}"
    options = ("--quiet", "--variant=minbase", packages, f"--components={_components()}")
    try:
        run_tool("mmdebstrap", *options, _release(), making, timeout_s=_BUILD_TIMEOUT_S)
        run_tool("sh", "-c", _FINISH, "sh", making, USER, USER_ID)
    except (ToolError, subprocess.TimeoutExpired) as error:
        shutil.rmtree(making, ignore_errors=True)
        reason = error.complaint if isinstance(error, ToolError) else "it takes too long"
        raise NoTreeError(f"mmdebstrap cannot make the files of a robot: {reason}") from None
    making.rename(folder)
