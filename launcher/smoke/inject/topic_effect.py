"""Messages of a topic that are dropped or late, by a process between the node and its listeners.

Fast DDS cannot do it for a running node: its XML profiles are read when a participant is made, and
have nothing that drops or delays; rules of the kernel (netem) would miss its shared memory.
"""

from __future__ import annotations

from collections.abc import Callable

from launcher.base.model.spec import ProcessSpec
from launcher.run.requests.process_selection import nodes_of
from launcher.run.requests.request_queue import ProcessRequest, Purpose
from launcher.run.requests.request_result import Kind, Result
from launcher.run.requests.result_sentences import sentence
from launcher.smoke.inject.effects import HelperEffect, Report
from launcher.smoke.inject.remapping import hidden_name, refusal, renamed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

PROXY = "launcher.ros.helpers.topic_proxy"
MATCHED_S = 15.0  # from the start of the process until it publishes


class TopicEffect(HelperEffect):
    """The process is restarted with its topic renamed, and at the end without that."""

    survives = True
    program = PROXY
    _before: ProcessSpec | None = None
    _changed: ProcessSpec | None = None

    def request(self) -> dict[str, Any]:
        topic, child = self.injection.topic, self.target.child
        assert topic is not None
        return {
            **dict(self.injection.values),
            "hidden": hidden_name(topic),
            "pid": child and child.pid,
            "nodes": list(nodes_of(self.target.spec)[0]),
        }

    def begin(self, acts: Callable[[], None], done: Report) -> None:
        problem = refusal(self.target.spec)
        if self.target.is_debugged:
            problem = problem or "it runs under a debugger"
        if problem:
            done(problem)
        else:
            self.start(acts, done, self.target.spec.env)
            if self.pid is not None:
                self.run.adopt_helper(self.pid)  # its shared memory is freed if it is killed

    def heard(self, answer: dict[str, Any]) -> None:
        if "ready" in answer:
            self.acts()
            self._rename()
        elif "matched" in answer:
            if answer["subscribes"]:
                self.run.log.log(
                    "WARNING",
                    self.target.name,
                    f"subscribes to {self.injection.topic}, too: until the end of the injection it "
                    "receives only its own messages there",
                )
            self.in_force()

    def _rename(self) -> None:
        process, topic = self.target, self.injection.topic
        assert topic is not None
        self._before = process.spec
        self._changed = renamed(process.spec, topic)
        process.adopt(self._changed)
        self._restart(self._renamed)

    def _restart(self, done: Callable[[Result], None]) -> None:
        """The launch file is not informed of the exit, as with a change of a file."""
        request = ProcessRequest(Purpose.RESTART, done, is_replacement=True)
        self.run.process_control.ask(self.target, request)

    def _renamed(self, result: Result) -> None:
        if result.kind is Kind.STARTED:
            self.run.reactor.call_later(MATCHED_S, self._unmatched)
        else:
            self.fail(sentence(result))

    def _unmatched(self) -> None:
        if self.is_beginning:
            self.fail(f"it does not publish {self.injection.topic} again after {MATCHED_S:g} s")

    def undo(self, done: Callable[[], None]) -> None:
        """Restart the process as it was, if it runs; then the proxy is of no use any more."""
        process = self.target
        is_ours = self._changed is not None and process.spec is self._changed
        if is_ours and self._before is not None:
            process.adopt(self._before)
        self._changed = None
        if is_ours and process.child is not None and not self.run.shutdown.has_begun:
            self._restart(lambda result: super(TopicEffect, self).undo(done))
        else:
            super().undo(done)

    def exited(self, code: int) -> None:
        if code:
            self.run.housekeeper.ledger.died(code, self.started_s)
