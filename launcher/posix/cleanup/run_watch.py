"""The watchdog's data of its run, and how it ends the run.

The rules of the watchdog for imports apply.
"""

from __future__ import annotations

import os
import time

from launcher.posix import proc
from launcher.posix.cleanup import cgroup, sweep

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
else:
    import _signal as signal  # see `watchdog`

CLEAN_SCANS = 3  # a process that was forking during one scan shows in the next
MOST_SCANS = 200  # of processes that fork in a loop while they are moved or suspended
SCAN_PAUSE_S = 0.01
REMOVAL_S = 0.3  # the launcher waits for it, and kills us after a second
TIMEOUT_S = 10.0  # a process in uninterruptible sleep cannot be killed
NOTE_ADOPTED_S = 0.1
NOTE_ALL_S = 1.0  # reads a file of every thread


class RunWatch:
    """The run of `launcher`, our parent; `kind` as in `cgroup.make`, or `none`.

    The launcher is in a control group of the run. Where none can be made, its descendants are
    noted: it adopts orphans, so that all that the run started descends from it while it lives.
    `before` are children that it had before the run.
    """

    def __init__(self, run_id: str, launcher: int, kind: str, before: frozenset[int]) -> None:
        self._run_id = run_id
        self._launcher = launcher
        self._before = before
        self._keep: set[int] = set()
        self._kin: dict[int, int] = {}  # pid -> start
        self._last_pid = b""
        self._noted_all_s = 0.0
        self._group: cgroup.Cgroup | None = None
        is_alive = os.getppid() == launcher
        if is_alive and kind != "none":
            self._group = cgroup.make(run_id, launcher, kind)
        self._is_noting = is_alive and self._group is None
        if self._group is not None:
            self._enclose(self._group)

    @property
    def pause_s(self) -> float | None:
        """Until the next call of `note`; None if none is needed."""
        return NOTE_ADOPTED_S if self._is_noting else None

    def keep(self, pid: int) -> None:
        """Never kill this process, a helper that exits by itself when the launcher is gone."""
        self._keep.add(pid)

    def _enclose(self, group: cgroup.Cgroup) -> None:
        """Move what the launcher had started before it was in the group itself."""
        left_out = {os.getpid()}
        clean = 0
        for _ in range(MOST_SCANS):
            outside = proc.family(self._children()).keys() - left_out - set(group.pids())
            clean = 0 if outside else clean + 1
            if clean == CLEAN_SCANS:
                return
            left_out.update(pid for pid in outside if not group.add(pid))

    def note(self) -> None:
        """Note the descendants of the launcher: adopted ones now, the others once a second."""
        for pid in self._children():
            if pid not in self._kin:
                self._note(pid, proc.start_ticks(pid))
        last_pid = proc.read(".", "loadavg").rpartition(b" ")[2]
        now = time.monotonic()
        if last_pid == self._last_pid or now - self._noted_all_s < NOTE_ALL_S:
            return  # nothing was started on this machine
        self._last_pid, self._noted_all_s = last_pid, now
        self._kin.clear()
        for pid, started in proc.family(self._children()).items():
            self._note(pid, started)

    def _children(self) -> list[int]:
        return [pid for pid in proc.children(self._launcher) if pid not in self._before]

    def _note(self, pid: int, started: int | None) -> None:
        if started is not None and pid != os.getpid() and pid not in self._keep:
            self._kin[pid] = started

    def release_launcher(self) -> None:
        """Move it out of the group, which takes some milliseconds, before the end of the run."""
        if self._group is not None:
            self._group.release(self._launcher)
            self._is_noting = True

    def close(self) -> None:
        """Remove the group. What is still in it was started by the launch file itself."""
        if self._group is not None:
            for pid in self._group.pids():
                self._group.release(pid)
            self._group.remove(REMOVAL_S)

    def kill(self) -> None:
        """Kill everything that the run has started."""
        if self._group is not None:
            self._group.kill(self._keep)
        deadline = time.monotonic() + TIMEOUT_S
        clean = 0
        while clean < CLEAN_SCANS and time.monotonic() < deadline:
            self._suspend()
            found = sweep.signal_all(self._run_id, signal.SIGKILL, kin=self._kin)
            clean = 0 if sweep.signal_newest(self._run_id, signal.SIGKILL) or found else clean + 1
            time.sleep(SCAN_PAUSE_S)
        if self._group is not None:
            self._group.remove(TIMEOUT_S)

    def _suspend(self) -> None:
        """Suspend the run: the child of a process that is killed first could not be found."""
        done: set[int] = set()
        for _ in range(MOST_SCANS):
            found, _ = sweep.find(self._run_id, kin=self._kin)
            new = set(found) - done
            if not new:
                return
            sweep.signal_all(self._run_id, signal.SIGSTOP, kin=self._kin)
            done |= new
            for pid, started in proc.family(found).items():
                self._note(pid, started)
