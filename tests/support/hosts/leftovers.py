"""Names of labs, and removal of all that belongs to one.

A name has the pid and the start time of the process that made the lab, so that a later process
recognises and removes what a killed one left behind.
"""

from __future__ import annotations

import fcntl
import itertools
import os
import re
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from launcher.posix import proc
from tests.support.hosts.cgroups import groups, processes_in_groups, remove_groups
from tests.support.hosts.tool import run_tool
from tests.support.waiting import wait_until

# Not in /tmp, which systemd empties, and not in /run, of which every host has its own.
STATE = Path(os.environ.get("LAUNCHER_LAB_STATE", "/var/lib/launcher-lab"))
_NAMESPACES = Path("/run/netns")
_NAME = re.compile(r"lab-(\d+)-(\d+)-\d+")
_numbers = itertools.count()


def new_name() -> str:
    """`lab-PID-START-NUMBER`, where START is in clock ticks since boot."""
    pid = os.getpid()
    return f"lab-{pid}-{proc.start_ticks(pid)}-{next(_numbers)}"


def remove_leftovers() -> None:
    """Remove the labs of processes that no longer exist."""
    with undisturbed():  # another process may want to remove the same
        for name in _names():
            if not _has_owner(name):
                remove(name)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Nobody else on the machine removes leftovers meanwhile, as each new lab does."""
    STATE.mkdir(parents=True, exist_ok=True)
    with open(STATE / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def remove(name: str) -> None:
    """End and remove all that belongs to a lab, whatever state it is in."""
    namespaces = [path.name for path in _paths(_NAMESPACES) if path.name.startswith(f"{name}.")]
    wait_until(lambda: not _kill(name, namespaces), f"the processes of {name} end")
    wait_until(lambda: remove_groups(name), f"the control groups of {name} are empty")
    for path in _mounts(STATE / name):
        run_tool("umount", "--lazy", path)
    for namespace in namespaces:
        with suppress(FileNotFoundError):
            (_NAMESPACES / namespace).stat()
            run_tool("ip", "netns", "del", namespace)
    shutil.rmtree(STATE / name, ignore_errors=True)


def processes_in(namespace: str) -> list[int]:
    """Pids of the processes in a network namespace, zombies not included."""
    wanted = _identity(_NAMESPACES / namespace)
    if wanted is None or wanted == _namespace(os.getpid(), "net"):
        return []
    return [pid for pid in proc.pids() if _namespace(pid, "net") == wanted and proc.is_alive(pid)]


def _names() -> set[str]:
    found = itertools.chain(_paths(STATE), _paths(_NAMESPACES), groups("lab-*"))
    return {match[0] for path in found if (match := _NAME.match(path.name))}


def _has_owner(name: str) -> bool:
    match = _NAME.fullmatch(name)
    return match is not None and proc.start_ticks(int(match[1])) == int(match[2])


def _kill(name: str, namespaces: list[str]) -> list[int]:
    """Kill what runs, and return it; first what runs inside of hosts, then what started it.

    The first process of a host stays a zombie until the parents of all others have collected them.
    """
    pids = [pid for namespace in namespaces for pid in processes_in(namespace)]
    pids = pids or [pid for pid in processes_in_groups(name) if proc.is_alive(pid)]
    own = _namespace(os.getpid(), "pid")
    inside = [pid for pid in pids if _namespace(pid, "pid") not in (None, own)]
    for pid in inside or pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return pids


def _namespace(pid: int, kind: str) -> tuple[int, int] | None:
    """Which namespace the process is in; None if it has exited."""
    return _identity(Path(f"/proc/{pid}/ns/{kind}"))


def _identity(path: Path) -> tuple[int, int] | None:
    with suppress(OSError):
        status = path.stat()
        return status.st_dev, status.st_ino
    return None


def _mounts(folder: Path) -> list[str]:
    """Where something is mounted in the folder, the innermost first."""
    lines = Path("/proc/self/mountinfo").read_text(encoding="utf-8").splitlines()
    points = [line.split()[4] for line in lines]
    return [point for point in reversed(points) if folder in Path(point).parents]


def _paths(folder: Path) -> Iterator[Path]:
    return folder.iterdir() if folder.is_dir() else iter(())


if __name__ == "__main__":
    remove_leftovers()
