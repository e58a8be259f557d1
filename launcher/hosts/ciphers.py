"""Which cipher ssh is to prefer, where nobody has chosen one."""

from __future__ import annotations

import contextlib
import functools
import os
import pwd
from collections.abc import Iterator

# In front of OpenSSH's own order, from which none is removed. Its favourite, chacha20-poly1305,
# takes 0.17 s of CPU more for 80 MB, of both ends together, if processors have instructions for
# AES.
PREFERRED = "^aes128-gcm@openssh.com"
_CPU_BYTES = 8192  # the first processor; the kernel writes about all others if asked
_DEPTH = 16  # of Include, as for ssh
_SYSTEM = "/etc/ssh"
_ANSWER_S = 5.0


@functools.cache
def preferred() -> str | None:
    """A value for `Ciphers` of ssh_config(5); None: whatever ssh does is right.

    So if this machine has no instructions for AES, if a file of ssh's configuration names ciphers,
    for any host (it wins), or if ssh does not accept the value.
    """
    is_right = _has_aes() and not _is_chosen() and _is_accepted()
    return PREFERRED if is_right else None


def _is_chosen() -> bool:
    try:
        home = os.path.join(_home(), ".ssh")
    except KeyError:
        return True  # ssh does not work without an entry in passwd(5)
    files = (home, f"{home}/config"), (_SYSTEM, f"{_SYSTEM}/ssh_config")
    return any(names_ciphers(path, folder) for folder, path in files)


def _home() -> str:
    """As ssh finds it, which does not read HOME; KeyError."""
    return pwd.getpwuid(os.getuid()).pw_dir


def _is_accepted() -> bool:
    """Whether ssh takes the value: before OpenSSH 8.1, or without OpenSSL, it would end with it."""
    import subprocess

    words = ["ssh", "-G", "-T", "-F", "none", "-o", f"Ciphers={PREFERRED}", "host"]
    try:
        done = subprocess.run(
            words, stdin=subprocess.DEVNULL, capture_output=True, timeout=_ANSWER_S, check=False
        )
    except (OSError, subprocess.SubprocessError):
        return False
    return f"\nciphers {PREFERRED[1:]},".encode() in done.stdout


def names_ciphers(path: str, folder: str, depth: int = 0) -> bool:
    """Whether `Ciphers` is in a file of ssh's configuration, or may be in what it includes.

    `folder` is where relative paths begin.
    """
    if depth > _DEPTH:
        return False
    for keyword, value in _settings(path):
        if keyword == "ciphers":
            return True
        if keyword == "include" and _includes_ciphers(value, folder, depth):
            return True
    return False


def _includes_ciphers(value: str, folder: str, depth: int) -> bool:
    import glob

    for word in value.split():
        pattern = word.strip('"')
        if "%" in pattern or "$" in pattern:
            return True  # only ssh can say: it may depend on the host
        if pattern.startswith("~/"):
            pattern = _home() + pattern[1:]
        found = glob.glob(os.path.join(folder, os.path.expanduser(pattern)))
        if any(names_ciphers(one, folder, depth + 1) for one in found):
            return True
    return False


def _settings(path: str) -> Iterator[tuple[str, str]]:
    """The keywords in lower case, with what follows them; nothing if it cannot be read."""
    with contextlib.suppress(OSError), open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            keyword, *value = line.replace("=", " ", 1).split(None, 1) or [""]
            yield keyword.lower(), "".join(value)


def _has_aes() -> bool:
    """Whether the first processor has them, as x86-64 and aarch64 call them."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", "rb", buffering=0) as file:
        return b"aes" in file.read(_CPU_BYTES).split()
    return False
