"""Threads that record events, log lines and resource usage from a run's control socket."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from launcher.base.model.event_entries import entry_of
from launcher.control.active_runs import ListedRun, wait_for_run
from launcher.control.client import Connection
from launcher.posix.socket_directory import ControlError
from launcher.smoke.observe import log_files
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import LogLine, UsageSample
from launcher.smoke.observe.last_state import LastState
from launcher.smoke.observe.left_behind import SharedMemory

if TYPE_CHECKING:
    from launcher.smoke.run.launcher_process import LauncherProcess

CONNECT_RETRY_S = 0.1
SAMPLE_S = 1.0
ANSWER_S = 5.0  # a run that does not answer `ps` within this time is no longer sampled
WHOLE_LOG = 1_000_000  # lines: all that the run keeps


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
        self.dropped_lines = 0
        self.is_over = threading.Event()
        self._listens = threading.Event()
        self._threads: list[threading.Thread] = []
        self._start(self._connect)
        self._start(self._note_memory)

    def _start(self, work: Callable[..., None], *args: object, **options: object) -> None:
        name = " ".join([work.__name__, *map(str, args[:1])])
        thread = threading.Thread(target=work, args=args, kwargs=options, daemon=True, name=name)
        self._threads.append(thread)
        thread.start()

    def wait_for_run(self, within_s: float) -> ListedRun:
        """ControlError if the run cannot be connected to in time."""
        self._listens.wait(within_s)
        if self.run is None:
            raise ControlError("the launcher has not opened a control socket")
        return self.run

    def join(self, within_s: float) -> None:
        """Record what is still in the sockets; the launcher has exited."""
        self.is_over.set()
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
            self._start(self._follow, "events", self._event, history=True)
            self._start(self._follow, "logs", self._line, lines=WHOLE_LOG)
            self._start(self._sample)
        self._listens.set()

    def _follow(self, verb: str, take: Callable[[Mapping[str, Any]], None], **options: Any) -> None:
        assert self.run is not None
        try:
            with self.run.connect() as connection:
                for item in connection.follow(verb, **options):
                    take(item)
        except ControlError:
            pass  # the run is over; its files have the rest

    def _event(self, item: Mapping[str, Any]) -> None:
        entry = entry_of(item)
        if entry is not None:  # else some were not read in time
            self._recorder.add(log_files.event_of(entry, self._recorder))

    def _line(self, item: Mapping[str, Any]) -> None:
        if "dropped" in item:
            self.dropped_lines += int(item["dropped"])
            return
        self._recorder.add(
            LogLine(
                at_s=self._recorder.of_wall(item["wall_s"]),
                process=item["process"],
                text=item["text"],
                stream=item["stream"],
            )
        )

    def _sample(self) -> None:
        assert self.run is not None
        try:
            with self.run.connect() as connection:
                while not self.is_over.is_set():
                    self._take_sample(connection)
                    self.is_over.wait(SAMPLE_S)
        except ControlError:
            pass  # the run is over

    def _take_sample(self, connection: Connection) -> None:
        rows = connection.ask("ps", timeout_s=ANSWER_S).result["processes"]
        at_s = self._recorder.now_s
        self._last_state.take_rows(rows)
        samples = [
            UsageSample(at_s, row["name"], row["cpu_percent"], row["uss_bytes"])
            for row in rows
            if row["pid"] is not None
        ]
        nodes = {row["name"]: tuple(row["node_names"]) for row in rows}
        self._recorder.add_samples(samples, nodes)

    def _note_memory(self) -> None:
        while self._launcher.is_alive and not self.is_over.is_set():
            self._memory.note(self._launcher.pid)
            self.is_over.wait(SAMPLE_S)
