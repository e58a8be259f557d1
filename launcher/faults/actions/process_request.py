"""Restarts, stops or starts processes of the run for a fault, as a user does."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.model.fault_action import FaultAction
from launcher.faults.actions.outside_program import Done
from launcher.run.processes.process import Process
from launcher.run.requests.process_selection import refuse_part
from launcher.run.requests.request_queue import ProcessRequest
from launcher.run.requests.request_result import Kind, Result
from launcher.run.requests.result_sentences import sentence
from launcher.run.run import Run

_AS_WANTED = (Kind.ALREADY_RUNNING, Kind.NOT_RUNNING)  # there was nothing to do


class ProcessRequests:
    """One request for each process; calls `done` once, at the latest after the time limit.

    BadCallError where one is the process of several nodes, of which only some are named.
    """

    def __init__(
        self, run: Run, action: FaultAction, processes: Sequence[Process], done: Done
    ) -> None:
        self._run = run
        self._within_s = action.within_s
        self._number = len(processes)
        self._results: list[Result] = []
        self._requests: list[tuple[Process, ProcessRequest]] = []
        self._done: Done | None = done
        for process in processes:
            refuse_part(action.kind, action.names, process.spec)
        self._timer = run.reactor.call_later(action.within_s, self._late)
        control = run.process_control
        ask = {"restart": control.restart, "stop": control.stop, "start": control.start}
        for process in processes:
            self._requests.append((process, ask[action.kind](process, self._answered)))

    def _answered(self, result: Result) -> None:
        self._results.append(result)
        if len(self._results) == self._number:
            ok = all(one.done or one.kind in _AS_WANTED for one in self._results)
            self._end(ok, "; ".join(map(sentence, self._results)))

    def _late(self) -> None:
        """What has not begun is not done any more."""
        self._end(False, f"not done within {self._within_s:g} s")
        for process, request in self._requests:
            self._run.process_control.withdraw(process, request)

    def _end(self, ok: bool, detail: str) -> None:
        done, self._done = self._done, None
        if done is not None:
            self._timer.cancel()
            done(ok, detail)
