"""Makes the launcher the parent of orphans: nothing that a run starts can leave its family tree.

A daemon is otherwise adopted by init, and nothing shows where it came from if it has cleared its
environment and left its session.
"""

from __future__ import annotations

import os

from launcher.posix import proc, spawn

_PR_SET_CHILD_SUBREAPER = 36  # linux/prctl.h
_is_active = False  # of this whole process, as the attribute of the kernel


def become() -> bool:
    """Adopt orphans of our descendants from now on; whether that is possible here."""
    global _is_active
    _is_active = _set(1)
    return _is_active


def resign() -> None:
    """No longer adopt orphans."""
    global _is_active
    if _is_active:
        _set(0)
        _is_active = False


def is_active() -> bool:
    """Whether orphans of our descendants become our children."""
    return _is_active


def _set(value: int) -> bool:
    try:
        # ctypes itself takes 5 ms to import, and every start waits for it.
        import _ctypes

        prctl = _ctypes.dlsym(_ctypes.dlopen(None, 0), "prctl")  # type: ignore[arg-type]
        result: int = _ctypes.call_cdeclfunction(prctl, (_PR_SET_CHILD_SUBREAPER, value, 0, 0, 0))
    except (ImportError, AttributeError, OSError):
        return False
    return result == 0


def adopted() -> list[int]:
    """Pids of the orphans that are our children; those that have exited are reaped.

    Children in our session were started by the launch file itself, which waits for them.
    """
    if not _is_active:
        return []
    session = os.getsid(0)
    found = []
    for pid in proc.children(os.getpid()):
        if pid in spawn.started or _session_of(pid) in (session, None):
            continue
        if proc.is_alive(pid):
            found.append(pid)
        else:
            os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG)
    return found


def orphans() -> dict[int, int]:
    """Pid -> start of all adopted processes and their descendants."""
    return proc.family(adopted())


def _session_of(pid: int) -> int | None:
    try:
        return os.getsid(pid)
    except OSError:
        return None
