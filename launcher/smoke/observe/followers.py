"""Threads that record events, log lines and resource usage from a run's control socket."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from launcher.control.active_runs import ListedRun, wait_for_run
from launcher.posix.socket_directory import ControlError
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.last_state import LastState
from launcher.smoke.observe.left_behind import SharedMemory
from launcher.smoke.observe.run_follower import RunFollower

if TYPE_CHECKING:
    from launcher.smoke.run.launcher_process import LauncherProcess

CONNECT_RETRY_S = 0.1
NOTE_S = 1.0


class Followers:
    """Connects to the run, then follows its events, its log and its resource usage.

    `run` is set as soon as it can be connected to. All threads end with the launcher.
    """

    def __init__(
        self,
        launcher: LauncherProcess,
        recorder: FactRecorder,
        memory: SharedMemory,
        last_state: LastState,
    ) -> None:
        self._launcher = launcher
        self._last_state = last_state
        self._recorder = recorder
        self._memory = memory
        self.run: ListedRun | None = None
        self._follower: RunFollower | None = None
        self.is_over = threading.Event()
        self._listens = threading.Event()
        self._threads: list[threading.Thread] = []
        self._start(self._connect)
        self._start(self._note_memory)

    def _start(self, work: Callable[[], None]) -> None:
        thread = threading.Thread(target=work, daemon=True, name=work.__name__)
        self._threads.append(thread)
        thread.start()

    def wait_for_run(self, within_s: float) -> ListedRun:
        """ControlError if the run cannot be connected to in time."""
        self._listens.wait(within_s)
        if self.run is None:
            raise ControlError("the launcher has not opened a control socket")
        return self.run

    @property
    def dropped_lines(self) -> int:
        return 0 if self._follower is None else self._follower.dropped_lines

    def join(self, within_s: float) -> None:
        """Record what is still in the sockets; the launcher has exited."""
        self.is_over.set()
        if self._follower is not None:
            self._follower.end()
        deadline_s = time.monotonic() + within_s
        for thread in list(self._threads):
            thread.join(max(0.0, deadline_s - time.monotonic()))

    # ---- threads

    def _connect(self) -> None:
        while self._launcher.is_alive and not self.is_over.is_set():
            try:
                self.run = wait_for_run(self._launcher.pid, CONNECT_RETRY_S)
                break
            except ControlError:
                continue  # not yet
        self._last_state.run = self.run
        if self.run is not None:
            follower = RunFollower(self.run.connect, self._recorder, self._last_state.take_rows)
            self._follower = follower
            self._threads += follower.threads
        self._listens.set()

    def _note_memory(self) -> None:
        while self._launcher.is_alive and not self.is_over.is_set():
            self._memory.note(self._launcher.pid)
            self.is_over.wait(NOTE_S)
