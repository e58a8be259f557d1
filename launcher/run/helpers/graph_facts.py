"""Starts the process that looks at the ROS graph for a run (launcher.ros.ready).

One for each domain. It is restarted once if it dies, and ends when nothing has been asked of it for
a while.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.base.model.record import as_dict
from launcher.base.model.supervision import Fact
from launcher.base.text import how_it_ended
from launcher.posix.reactor import Reactor, Timer
from launcher.run.helpers.helper_programs import READY
from launcher.run.helpers.json_lines import JsonLinesProcess, without_shared_memory

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    Report = Callable[[bool, str], None]  # whether it holds, and what is seen instead

MAX_STARTS = 2
IDLE_S = 10.0
GOODBYE_S = 2.0  # one that does not exit at EOF of its input is killed after this


class GraphFacts:
    """`warn` is called with texts for the user."""

    def __init__(self, reactor: Reactor, warn: Callable[[str], None]) -> None:
        self._reactor = reactor
        self._warn = warn
        self._helpers: dict[str, _Helper] = {}
        self._of_number: dict[int, _Helper] = {}
        self._last = 0

    def watch(self, fact: Fact, env: Mapping[str, str], since_s: float, report: Report) -> int:
        """Report from now on what is seen of a fact, in the domain of this environment."""
        domain = env.get("ROS_DOMAIN_ID") or "0"
        if domain not in self._helpers or self._helpers[domain].has_left:
            self._helpers[domain] = _Helper(self._reactor, self._warn, env)
        self._last += 1
        self._of_number[self._last] = self._helpers[domain]
        request = {"watch": self._last, "fact": as_dict(fact), "since_s": since_s}
        self._helpers[domain].watch(self._last, request, report)
        return self._last

    def unwatch(self, number: int) -> None:
        self._of_number.pop(number).unwatch(number)

    def close(self) -> None:
        for helper in self._helpers.values():
            helper.close()


class _Helper:
    """One process; a request is kept until it is withdrawn, for a process that is restarted."""

    def __init__(
        self, reactor: Reactor, warn: Callable[[str], None], env: Mapping[str, str]
    ) -> None:
        self._reactor = reactor
        self._warn = warn
        self._env = without_shared_memory(env)
        self._requests: dict[int, tuple[dict[str, Any], Report]] = {}
        self._starts = 0
        self._timer: Timer | None = None
        self.has_left = False
        self._process: JsonLinesProcess | None = None
        self._start()

    def _start(self) -> None:
        self._starts += 1
        try:
            self._process = JsonLinesProcess(
                self._reactor, READY, self._env, on_message=self._seen, on_end=self._died
            )
        except OSError as error:
            self._warn(f"nothing is known of the ROS graph: {error.strerror}")
            return
        for request, _ in self._requests.values():
            self._process.send(request)

    def watch(self, number: int, request: dict[str, Any], report: Report) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._requests[number] = (request, report)
        if self._process is None:
            self._reactor.call_later(0, self._report_unknown)
        else:
            self._process.send(request)

    def unwatch(self, number: int) -> None:
        del self._requests[number]
        if self._process is not None:
            self._process.send({"unwatch": number})
        if not self._requests:
            self._timer = self._reactor.call_later(IDLE_S, self._leave)

    def _leave(self) -> None:
        """Let it end; another one is started when it is needed again."""
        if self._process is not None:
            self.has_left = True
            self._process.close_input()

    def _seen(self, seen: dict[str, Any]) -> None:
        if seen["watch"] in self._requests:
            self._requests[seen["watch"]][1](seen["holds"], seen["text"])

    def _died(self, code: int, line: str) -> None:
        self._process = None
        if self.has_left:
            return
        how = how_it_ended(code)
        reason = f"{how}: {line}" if line else how
        is_restarted = self._starts < MAX_STARTS
        what = "restarting it" if is_restarted else "waits for ROS facts end by their timeouts"
        self._warn(f"the process that looks at the ROS graph died ({reason}); {what}")
        if is_restarted:
            self._start()
        else:
            self._report_unknown()

    def _report_unknown(self) -> None:
        for _, report in list(self._requests.values()):
            report(False, "it is not known: what looks at the ROS graph has died")

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        if self._process is not None:
            self._process.close(GOODBYE_S)
            self._process = None
