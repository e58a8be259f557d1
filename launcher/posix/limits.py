"""Starts processes with limits through a bare interpreter that sets them (`limits_exec`).

Limits that are set from outside come too late for the first steps of a program, and running Python
between fork and exec is slow in a large process. So only a process with limits pays for this, with
about 8 ms for the bare interpreter.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from launcher.base.model.spec import UNLIMITED, Limits

_SCRIPT = Path(__file__).with_name("limits_exec.py")
_COERCED = "LC_CTYPE"  # which Python sets where the locale is C, and the program would inherit


def command_prefix(limits: Limits, status: int, env: Mapping[str, str]) -> list[str]:
    """The words before a command that start it with the limits.

    `status` is the descriptor that is closed on exec; `env` is the environment of the program.
    """
    start = [sys.executable, "-I", "-S", str(_SCRIPT), str(status)]
    unset = [] if _COERCED in env else [f"unset={_COERCED}"]
    return [*start, *settings_of(limits), *unset, "--"]


def settings_of(limits: Limits) -> Iterator[str]:
    """The limits as `limits_exec` takes them."""
    if limits.nice is not None:
        yield f"nice={limits.nice}"
    if limits.cpus is not None:
        yield f"cpus={','.join(map(str, limits.cpus))}"
    for name, soft, hard in limits.rlimits:
        yield f"{name}={soft}/{hard}"


def parse_refusal(message: bytes) -> tuple[int, str]:
    """(errno, the limit that was refused or "") from the message of `limits_exec`."""
    number, _, setting = message.decode(errors="replace").partition(" ")
    return (int(number) if number.isdigit() else errno.EIO), _as_given(setting)


def _as_given(setting: str) -> str:
    """`nofile=unlimited` for `nofile=-1/-1`."""
    name, is_limit, amounts = setting.partition("=")
    if "/" not in amounts:
        return setting
    shown = ["unlimited" if one == str(UNLIMITED) else one for one in amounts.split("/")]
    return f"{name}{is_limit}{'/'.join(dict.fromkeys(shown))}"
