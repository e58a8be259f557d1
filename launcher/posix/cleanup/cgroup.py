"""The control group of a run: whatever a process does, its children stay in it.

Made by the watchdog: its rules for imports apply. Version 2 is preferred, since the kernel kills a
whole group of it at once.
"""

from __future__ import annotations

import os
import time

from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from collections.abc import Collection, Iterator
else:
    import _signal as signal  # see `watchdog`

# Of version 1: the hierarchy must only exist, no controller is needed.
_V1 = ("name=systemd", "pids", "freezer", "cpuacct")
_NAME = r"launcher-([0-9]+-[0-9a-f]+)"
PAUSE_S = 0.005
TIMEOUT_S = 5.0  # a process in uninterruptible sleep cannot be killed


class Cgroup:
    """The group with the folder `path`, in the group `home`, which the launcher came from."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._home = os.path.dirname(path)

    def add(self, pid: int) -> bool:
        """Move a process with all its threads into it; whether that is allowed."""
        return _move(self.path, pid)

    def release(self, pid: int) -> bool:
        """Move a process back to where the launcher came from."""
        return _move(self._home, pid)

    def pids(self) -> list[int]:
        """Its processes, those of groups in it, too; 0 for one of another pid namespace."""
        found: list[int] = []
        for folder, _, _ in os.walk(self.path):
            try:
                with open(f"{folder}/cgroup.procs", "rb") as file:
                    found += [int(line) for line in file]
            except OSError:
                continue  # it has just been removed
        return found

    def age_s(self) -> float:
        """Since it was made; 0 if it does not exist."""
        try:
            return time.time() - os.stat(self.path).st_ctime
        except OSError:
            return 0.0

    def kill(self, keep: Collection[int]) -> None:
        """Kill all processes but `keep`, and wait until they are gone."""
        staying = {pid for pid in keep if not self.release(pid) and proc.is_alive(pid)}
        if staying or not _write(f"{self.path}/cgroup.kill", b"1"):
            staying |= {0, os.getpid()}
        else:
            staying = {0}
        deadline = time.monotonic() + TIMEOUT_S
        while time.monotonic() < deadline:
            pids = [pid for pid in self.pids() if pid not in staying]
            if not pids:
                return
            # After `cgroup.kill` they are exiting already.
            for pid in pids:
                try:
                    os.kill(pid, signal.SIGKILL)
                except OSError:
                    continue
            time.sleep(PAUSE_S)

    def remove(self, timeout_s: float = 0.0) -> bool:
        """Remove it, with the groups in it; False if a process is in one of them.

        A process that has exited and is not reaped yet counts, and cannot be seen.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            for folder, _, _ in os.walk(self.path, topdown=False):
                try:
                    os.rmdir(folder)
                except OSError:
                    continue
            is_removed = not os.path.isdir(self.path)
            if is_removed or time.monotonic() >= deadline:
                return is_removed
            time.sleep(PAUSE_S)


def make(run_id: str, launcher: int, kind: str = "") -> Cgroup | None:
    """A new group in ours with the process `launcher` in it; None where that is not allowed.

    `kind` is the version, `v2` or `v1`; by default the first of them where it is allowed. A group
    that exists already is taken, even if we are in it.
    """
    name = f"launcher-{run_id}"
    for each, own in _own_groups():
        if kind not in ("", each):
            continue
        home = os.path.dirname(own) if os.path.basename(own) == name else own
        group = Cgroup(f"{home}/{name}")
        try:
            os.mkdir(group.path)
        except FileExistsError:
            group.release(os.getpid())
        except OSError:  # no permission, or mounted read-only
            continue
        if group.add(launcher):
            return group
        group.remove()
    return None


def groups() -> Iterator[tuple[str, Cgroup]]:
    """(run id, group) of every run on this machine that we can see."""
    import re  # not for the watchdog, whose memory it would double

    for folder in sorted({mount for _, _, mount in _mounts()}):
        for parent, names, _ in os.walk(folder):
            for name in names:
                match = re.fullmatch(_NAME, name)
                if match is not None:
                    yield match[1], Cgroup(f"{parent}/{name}")


def _own_groups() -> Iterator[tuple[str, str]]:
    """(kind, folder) of the groups that we are in, the best first."""
    paths = {}
    for line in _lines("cgroup"):
        _, names, path = line.split(":", 2)
        paths[names] = path
    ranked = []
    for names, root, mount in _mounts():
        path = paths.get(names, "")
        inside = path if root == "/" else path.removeprefix(root)
        if (root != "/" and inside == path) or not path or ".." in path:
            continue  # the mount does not show our group
        rank = -1 if not names else min(map(_V1.index, set(_V1) & set(names.split(","))))
        ranked.append((rank, mount + inside.rstrip("/")))
    for rank, folder in sorted(ranked):
        yield ("v2" if rank < 0 else "v1"), folder


def _mounts() -> Iterator[tuple[str, str, str]]:
    """(controllers, root, mount point) of the hierarchies that are useful; version 2 has none."""
    known = [line.split(":", 2)[1] for line in _lines("cgroup")]
    for line in _lines("mountinfo"):
        before, _, after = line.partition(" - ")
        kind, _, options = after.split(" ", 2)
        root, mount = before.split(" ")[3:5]
        if kind == "cgroup2":
            yield "", root, _unescape(mount)
        elif kind == "cgroup":
            words = set(options.split(","))
            for names in known:
                if names and set(names.split(",")) <= words and set(_V1) & set(names.split(",")):
                    yield names, root, _unescape(mount)


def _lines(name: str) -> list[str]:
    return proc.read("self", name).decode(errors="replace").splitlines()


def _unescape(path: str) -> str:
    if "\\" not in path:
        return path  # nearly always
    import re

    return re.sub(r"\\([0-7]{3})", lambda match: chr(int(match[1], 8)), path)


def _move(folder: str, pid: int) -> bool:
    return _write(f"{folder}/cgroup.procs", b"%d" % pid)


def _write(path: str, data: bytes) -> bool:
    try:
        fd = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        os.write(fd, data)
    except OSError:
        return False
    finally:
        os.close(fd)
    return True
