"""Runs requests that have to wait for other nodes in threads.

Each thread has a hidden node, because an executor takes everything that arrives for its
node: on the node that listens it would take the messages as well.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from rclpy.executors import ExternalShutdownException

from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.observer import Observer
from launcher.ros.helpers.clean_up import limited_clean_up
from launcher.ros.probe.protocol import ProbeRequest
from launcher.ros.service_caller import ServiceCaller

if TYPE_CHECKING:
    from rclpy.node import Node

MAX_THREADS = 8
JOIN_S = 3.0
_CANCELLABLE = frozenset({"publish"})

Handler = Callable[[ServiceCaller, ProbeRequest], dict[str, Any]]
Answer = Callable[[ProbeRequest, Callable[[], dict[str, Any]]], None]


def pause(caller: ServiceCaller, request: ProbeRequest, pause_s: float) -> bool:
    """Wait; True at once if the request is cancelled.

    ExternalShutdownException if the probe has ended.
    """
    is_cancelled = request.cancelled.wait(min(pause_s, threading.TIMEOUT_MAX))
    if not caller.observer.context.ok():
        raise ExternalShutdownException
    return is_cancelled


def pause_or_refuse(caller: ServiceCaller, request: ProbeRequest, pause_s: float) -> None:
    """Wait; VerbError if the request is cancelled."""
    if pause(caller, request, pause_s):
        raise VerbError("the request was cancelled")


class Jobs:
    """Up to 8 threads, started on demand; `answer` runs a job and sends its result."""

    def __init__(self, observer: Observer, answer: Answer) -> None:
        self._observer = observer
        self._answer = answer
        self._queue: queue.SimpleQueue[tuple[Handler, ProbeRequest] | None] = queue.SimpleQueue()
        self._threads: list[threading.Thread] = []
        self._idle = threading.Semaphore(0)
        self._open: list[ProbeRequest] = []  # waiting or running

    def send(self, work: Handler, request: ProbeRequest) -> None:
        """Hand the request to an idle thread, or to a new one."""
        if not self._idle.acquire(blocking=False) and len(self._threads) < MAX_THREADS:
            self._start_thread()
        self._open.append(request)
        self._queue.put((work, request))

    def cancel(self, request_id: object) -> bool:
        """End the publishing with this id; False if there is none."""
        found = [r for r in list(self._open) if r.id == request_id and r.word in _CANCELLABLE]
        for request in found:
            request.cancelled.set()
        return bool(found)

    def _start_thread(self) -> None:
        number = len(self._threads)
        # rclpy cannot create nodes in several threads at the same time
        node = self._observer.helper(f"jobs_{number}")
        thread = threading.Thread(target=self._run, args=(node,), daemon=True)
        self._threads.append(thread)
        thread.start()

    def _run(self, node: Node) -> None:
        try:
            with ServiceCaller(self._observer, node) as caller:
                while (job := self._queue.get()) is not None:
                    work, request = job
                    self._answer(request, partial(self._done, work, caller, request))
        except ExternalShutdownException:
            pass  # the probe ended during a job
        finally:
            node.destroy_node()

    def _done(self, work: Handler, caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
        """The result. The thread is idle before it is sent, so that the next request takes it.

        Another thread would need clients for the same services, whose discovery costs more.
        """
        try:
            return work(caller, request)
        finally:
            self._open.remove(request)
            self._idle.release()

    def close(self) -> None:
        """Shut the context down, which ends all waiting, and join the threads."""
        with limited_clean_up(cpu_s=10.0, wall_s=2 * MAX_THREADS * JOIN_S):
            self._observer.context.try_shutdown()
            for request in list(self._open):
                request.cancelled.set()
            for _ in self._threads:
                self._queue.put(None)
            for thread in self._threads:
                thread.join(JOIN_S)
