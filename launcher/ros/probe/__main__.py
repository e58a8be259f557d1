"""The probe's loop: requests, messages, changes of the graph."""

from __future__ import annotations

import os
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

from rclpy.executors import ExternalShutdownException

from launcher.base.errors import LauncherError
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.base.text import typed_error
from launcher.posix import dispositions
from launcher.posix.stdio import keep_for_messages
from launcher.ros.discovery.observer import Observer
from launcher.ros.probe import request_handlers
from launcher.ros.probe.frames import ProbeFrames
from launcher.ros.probe.jobs import Handler, Jobs
from launcher.ros.probe.probe_snapshot import GraphWatcher, ProbeSnapshot
from launcher.ros.probe.protocol import Inbox, LineOutbox, ProbeRequest, Waker, moment
from launcher.ros.probe.subscriptions import Subscriptions
from launcher.ros.snapshot.qos_matching import explain, mismatches
from launcher.ros.snapshot.ros_graph import Direction, TopicGraph
from launcher.ros.topics import qos
from launcher.ros.topics.listener import full_topic
from launcher.ros.topics.listing import endpoint_document, mismatch_documents

PROTOCOL = 1
_PROFILE = Path(__file__).with_name("participant.xml")
GRAPH_PERIOD_S = 0.1
LONGEST_PERIOD_S = 10.0
_COUNT_PERIODS = 5  # of the graph, between two counts of participants: it costs more
_SHORTEST_S = 0.001
_FLUSH_S = 1.0


class Probe:
    def __init__(self, observer: Observer, inbox: Inbox, outbox: LineOutbox) -> None:
        self._observer = observer
        self._inbox = inbox
        self._outbox = outbox
        self._waker = Waker()
        self._graph_s = GRAPH_PERIOD_S
        self._graph = GraphWatcher(observer)
        self._snapshot = ProbeSnapshot(snapshot=TopicGraph(nodes=(), endpoints=()))
        self._subscriptions = Subscriptions(observer, outbox)
        self._frames = ProbeFrames(observer)
        self._jobs = Jobs(observer, self._answer_later)
        self._number = 0
        self._next_graph_s = 0.0
        self._is_ended = False
        self._immediate: dict[str, Callable[[ProbeRequest], dict[str, Any]]] = {
            "subscribe": lambda request: self._subscriptions.subscribe(request, self._snapshot),
            "unsubscribe": self._subscriptions.unsubscribe,
            "rate": self._subscriptions.rate,
            "graph": lambda _: self._fresh().document(),
            "services": lambda _: {"services": self._snapshot.document()["services"]},
            "traffic": lambda _: self._subscriptions.traffic(),
            "arrivals": self._subscriptions.arrivals,
            "listen": self._listen,
            "cancel": lambda request: {"cancelled": self._jobs.cancel(request.of)},
            "explain": self._explain,
            "frames": lambda _: self._frames.answer(),
            "clock": lambda _: moment(),
        }
        later = request_handlers.Handlers(lambda: self._snapshot, self._subscriptions)
        self._jobs_by_name: dict[str, Handler] = {
            "get_parameters": request_handlers.get_parameters,
            "describe_parameters": request_handlers.describe_parameters,
            "set_parameters": request_handlers.set_parameters,
            "form": request_handlers.describe_type,
            "call": later.call,
            "publish": later.publish,
            "draw": later.draw,
        }

    def end(self, signum: int, frame: FrameType | None) -> None:
        """Handle a signal: stop after this pass of the loop."""
        self._is_ended = True
        self._waker.wake()

    def run(self) -> None:
        self._outbox.send(
            {
                "event": "ready",
                "protocol": PROTOCOL,
                "pid": os.getpid(),
                "domain_id": self._observer.domain_id,
                **moment(),
            }
        )
        while not (self._is_ended or self._inbox.is_closed or self._outbox.is_broken):
            self._write_graph()
            self._subscriptions.take()
            self._frames.rest()
            self._outbox.flush()
            self._wait()
        self._graph.close()
        self._jobs.close()
        self._flush()

    def _flush(self) -> None:
        """Write what is left, as far as the reader takes it within a second."""
        end_s = time.monotonic() + _FLUSH_S
        while not (self._outbox.is_empty or self._outbox.is_broken) and time.monotonic() < end_s:
            select.select([], [sys.stdout.fileno()], [], _SHORTEST_S)
            self._outbox.flush()

    def _wait(self) -> None:
        """Sleep until a request comes, the output takes more, or something is due."""
        due_s = min(self._next_graph_s, self._subscriptions.due_s)
        pause_s = max(_SHORTEST_S, due_s - time.monotonic())
        readers = [sys.stdin.fileno(), self._waker.descriptor]
        writers = [] if self._outbox.is_empty else [sys.stdout.fileno()]
        readable, _, _ = select.select(readers, writers, [], pause_s)
        if self._waker.descriptor in readable:
            self._waker.reset()
        for line in self._inbox.lines() if sys.stdin.fileno() in readable else ():
            self._handle(line)

    def _write_graph(self) -> None:
        """Write the graph if it has changed."""
        now_s = time.monotonic()
        if now_s >= self._next_graph_s:
            # in step with the subscriptions, so that both need one pass of the loop
            self._next_graph_s = (now_s // self._graph_s + 1) * self._graph_s
            if self._graph.has_changed():
                self._take_graph()

    def _take_graph(self) -> None:
        snapshot = self._graph.take()
        if snapshot != self._snapshot or self._number == 0:
            self._snapshot = snapshot
            self._number += 1
            head = {"event": "graph", "number": self._number, **moment()}
            self._outbox.show({**head, **snapshot.document()})
            self._subscriptions.fit(snapshot)

    def _fresh(self) -> ProbeSnapshot:
        self._take_graph()
        return self._snapshot

    def _listen(self, request: ProbeRequest) -> dict[str, Any]:
        """How often messages are read, and the graph is looked at."""
        self._subscriptions.listen_s = _period(request, "period_s", self._subscriptions.listen_s)
        self._graph_s = _period(request, "graph_s", self._graph_s)
        self._graph.count_s = _COUNT_PERIODS * self._graph_s
        self._next_graph_s = min(self._next_graph_s, time.monotonic() + self._graph_s)
        return {"period_s": self._subscriptions.listen_s, "graph_s": self._graph_s}

    def _handle(self, line: bytes) -> None:
        try:
            request = ProbeRequest(line)
        except VerbError as error:
            self._outbox.send(_refusal(None, error))
            return
        name = request.word
        if name in self._jobs_by_name:
            self._jobs.send(self._jobs_by_name[name], request)
        else:
            self._answer(request, lambda: self._do(name, request))

    def _do(self, name: str, request: ProbeRequest) -> dict[str, Any]:
        if name not in self._immediate:
            known = [*self._immediate, *self._jobs_by_name]
            raise VerbError(f"unknown request '{name}'", hint=did_you_mean(name, known))
        # messages that have arrived go out before the answer
        self._subscriptions.take(everything=True)
        return self._immediate[name](request)

    def _answer_later(self, request: ProbeRequest, work: Callable[[], dict[str, Any]]) -> None:
        """The same from another thread."""
        self._answer(request, work)
        self._waker.wake()

    def _answer(self, request: ProbeRequest, work: Callable[[], dict[str, Any]]) -> None:
        try:
            self._outbox.send({"id": request.id, "ok": True, "result": work()})
        except LauncherError as error:
            self._outbox.send(_refusal(request.id, error))
        except ExternalShutdownException:
            raise
        except Exception as error:  # every request gets an answer
            if not self._observer.context.ok():
                raise ExternalShutdownException from error  # the probe ended during a call
            text = typed_error(error)
            self._outbox.send(_refusal(request.id, VerbError(text, hint="this is a bug")))
            traceback.print_exc()

    def _explain(self, request: ProbeRequest) -> dict[str, Any]:
        """How the endpoints of a topic match each other, or one like `as`."""
        topic = full_topic(request.text("topic"))
        there = self._snapshot.on(topic)
        known = there
        if (other := request.mapping("as")) is not None:
            direction = _direction(other)
            type_name = other.get("type") or "".join(self._snapshot.types_of(topic)[:1])
            profile = qos.from_words(other.get("qos") or {}, 10)
            own = qos.endpoint_of(profile, direction, topic, type_name, node="the expectation")
            known = [own, *(e for e in there if e.direction != direction.value)]
        return {
            "endpoints": [endpoint_document(e) for e in there],
            "mismatches": mismatch_documents(mismatches(known)),
            "text": explain(known),
        }


def _period(request: ProbeRequest, name: str, now: float) -> float:
    period_s = request.number(name, now)
    if not _SHORTEST_S <= period_s <= LONGEST_PERIOD_S:
        raise VerbError(f"'{name}' must be from {_SHORTEST_S} to {LONGEST_PERIOD_S:g} seconds")
    return period_s


def _direction(words: dict[str, Any]) -> Direction:
    word = str(words.get("direction", "subscription")).lower()
    if word not in [direction.value for direction in Direction]:
        raise VerbError(f"unknown direction '{word}'", hint="publisher or subscription")
    return Direction(word)


def _refusal(request_id: object, error: LauncherError) -> dict[str, Any]:
    text = {"message": error.message, "hint": error.hint}
    return {"id": request_id, "ok": False, "error": text}


def main() -> None:
    dispositions.ignore((signal.SIGINT, signal.SIGHUP))  # they are meant for the system
    keep_for_messages()
    inbox, outbox = Inbox(sys.stdin.fileno()), LineOutbox(sys.stdout.fileno())
    os.set_blocking(sys.stdout.fileno(), False)
    try:
        # announces us more often; a profile of the user takes precedence
        with Observer(purpose="probe", profile=str(_PROFILE)) as observer:
            probe = Probe(observer, inbox, outbox)
            signal.signal(signal.SIGTERM, probe.end)
            probe.run()
    finally:
        os.set_blocking(sys.stdout.fileno(), True)


if __name__ == "__main__":
    main()
