"""The requests that run as jobs: parameters, service calls, publishing, drawing."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros import parameter_values, parameters
from launcher.ros.draw.filter import Filter, Mode
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.form import form
from launcher.ros.messages.from_yaml import Stamp, fill, stamp_all
from launcher.ros.messages.interfaces import full_type, load, load_message
from launcher.ros.messages.to_yaml import to_plain
from launcher.ros.probe.jobs import pause, pause_or_refuse
from launcher.ros.probe.probe_snapshot import ProbeSnapshot
from launcher.ros.probe.protocol import ProbeRequest
from launcher.ros.probe.subscriptions import Subscriptions
from launcher.ros.service_caller import ANSWER_S, NoAnswerError, ServiceCaller
from launcher.ros.snapshot.diff import to_document
from launcher.ros.snapshot.qos_matching import explain, mismatches
from launcher.ros.snapshot.ros_graph import Direction, Endpoint
from launcher.ros.topics import qos
from launcher.ros.topics.listener import full_topic
from launcher.ros.verb import to_json_plain

if TYPE_CHECKING:
    from rclpy.publisher import Publisher

_PERIOD_S = 0.01
_DEPTH = 100
# A publisher discovers a subscription up to half a second before the subscription discovers it
# (measured on a busy machine); what is published in between is lost, even if RELIABLE.
DISCOVERY_S = 0.8


def get_parameters(caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
    """Values and types of a node's parameters; `missing` are unknown names."""
    node = full_topic(request.text("node"))
    caller.answer_s = request.number("timeout_s", ANSWER_S)
    known = parameters.list_names(caller, node)
    asked = request.names("names")
    names = [name for name in (known if asked is None else asked) if name in known]
    found = parameters.values_of(caller, node, names)
    return {
        "values": {name: parameter_values.plain_value(value) for name, value in found.items()},
        "types": {name: parameter_values.type_name(value.type) for name, value in found.items()},
        "missing": [name for name in asked or () if name not in known],
    }


def describe_parameters(caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
    """What a form for the parameters of a node needs."""
    node = full_topic(request.text("node"))
    caller.answer_s = request.number("timeout_s", ANSWER_S)
    return {"parameters": parameters.documents(caller, node)}


def describe_type(caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
    """What a form for the values of a type needs."""
    return form(request.text("type"))


def set_parameters(caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
    node, values = full_topic(request.text("node")), request.values()
    caller.answer_s = request.number("timeout_s", ANSWER_S)
    outcomes = parameters.set_values(
        caller, node, values, parameter_values.plain_parameter, parameter_values.type_for_json
    )
    return {
        "results": {
            name: {"successful": one.result.successful, "reason": one.result.reason}
            for name, one in outcomes.items()
        }
    }


@dataclass(slots=True, kw_only=True)
class ProbePublisher:
    """A publisher, its endpoint, and how many subscriptions it has known since when."""

    publisher: Publisher
    endpoint: Endpoint
    known: int = 0
    since_s: float = field(default_factory=time.monotonic)

    def is_steady(self) -> bool:
        """Whether the subscriptions that it has discovered have had time to discover it."""
        count = self.publisher.get_subscription_count()
        if count != self.known:
            self.known, self.since_s = count, time.monotonic()
        return time.monotonic() - self.since_s >= DISCOVERY_S


class Handlers:
    """The requests that need the newest snapshot."""

    def __init__(self, snapshot: Callable[[], ProbeSnapshot], subscriptions: Subscriptions) -> None:
        self._snapshot = snapshot
        self._subscriptions = subscriptions
        self._lock = threading.Lock()
        self._publishers: dict[tuple[str, str, str], ProbePublisher] = {}

    def call(self, caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
        name = full_topic(request.text("service"))
        end_s = time.monotonic() + request.number("timeout_s", ANSWER_S)
        type_name = self._service_type(caller, request, name, end_s)
        kind = with_library(load(type_name, "srv", "The passed service type is invalid"))
        message = kind.Request()
        stamps = fill(message, request.values())
        if not caller.wait_for(caller.client(kind, name), end_s - time.monotonic()):
            raise NoAnswerError(f"service '{name}' is not available")
        stamp_all(stamps, caller.observer.node.get_clock().now().to_msg())
        asked_s = time.monotonic()
        answer = caller.call(kind, name, message, max(0.0, end_s - asked_s))
        took_s = time.monotonic() - asked_s
        return {"type": type_name, "values": to_json_plain(to_plain(answer)), "took_s": took_s}

    def _service_type(
        self, caller: ServiceCaller, request: ProbeRequest, name: str, end_s: float
    ) -> str:
        """The type of the service; VerbError if another one is wanted."""
        wanted = request.optional_text("type")
        while name not in self._snapshot().services and time.monotonic() < end_s:
            pause_or_refuse(caller, request, _PERIOD_S)
        offered = self._snapshot().services.get(name, ())
        if wanted is not None:
            wanted = full_type(wanted, "srv")
        if not offered:
            hint = did_you_mean(name, self._snapshot().services)
            raise NoAnswerError(f"service '{name}' is not available", hint=hint)
        if wanted is not None and wanted not in offered:
            raise VerbError(f"service '{name}' has the type {', '.join(offered)}, not {wanted}")
        return wanted or offered[0]

    def publish(self, caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
        """Publish messages once `matched` subscriptions receive them."""
        topic = full_topic(request.text("topic"))
        end_s = time.monotonic() + request.number("timeout_s", ANSWER_S)
        type_name = self._topic_type(caller, request, topic, end_s)
        message = with_library(load_message(type_name))()
        stamps = fill(message, request.values())
        publisher = self._publisher(caller, topic, type_name, request.mapping("qos"))
        matched = self._await_matched(caller, request, publisher, end_s)
        published = _repeat(caller, request, publisher.publisher, message, stamps)
        return {"published": published, "matched": matched, "type": full_type(type_name)}

    def _topic_type(
        self, caller: ServiceCaller, request: ProbeRequest, topic: str, end_s: float
    ) -> str:
        wanted = request.optional_text("type")
        while wanted is None and time.monotonic() < end_s:
            if types := self._snapshot().types_of(topic):
                return types[0]
            pause_or_refuse(caller, request, _PERIOD_S)
        if wanted is None:
            near = did_you_mean(topic, self._snapshot().snapshot.topics())
            raise VerbError(f"unknown type: topic '{topic}' does not exist", hint=near)
        return full_type(wanted)

    def _publisher(
        self, caller: ServiceCaller, topic: str, type_name: str, words: dict[str, Any] | None
    ) -> ProbePublisher:
        if words is None:
            asked = {e.durability for e in self._snapshot().on(topic) if not e.is_publisher}
            words = {"durability": "TRANSIENT_LOCAL" if "TRANSIENT_LOCAL" in asked else "VOLATILE"}
        profile = qos.from_words(words, _DEPTH)
        key = (topic, type_name, strict_json.dumps(words, sort_keys=True))
        with self._lock:
            if key not in self._publishers:
                node, kind = caller.observer.node, load_message(type_name)
                endpoint = qos.endpoint_of(
                    profile, Direction.PUBLISHER, topic, type_name, node="this publisher"
                )
                self._publishers[key] = ProbePublisher(
                    publisher=node.create_publisher(kind, topic, profile), endpoint=endpoint
                )
        return self._publishers[key]

    def _await_matched(
        self, caller: ServiceCaller, request: ProbeRequest, publisher: ProbePublisher, end_s: float
    ) -> int:
        """The number of subscriptions but ours; VerbError with the reason if it is too small."""
        wanted = int(request.number("matched", 1))
        while True:
            is_steady = publisher.is_steady()
            matched = max(0, publisher.known - self._subscriptions.matching(publisher.endpoint))
            if matched >= wanted and (is_steady or wanted == 0):
                return matched
            if matched < wanted and time.monotonic() >= end_s:
                raise VerbError(
                    f"{matched} of {wanted} subscriptions on '{publisher.endpoint.topic}' match",
                    hint=self._reason(publisher.endpoint),
                )
            pause_or_refuse(caller, request, _PERIOD_S)

    def _reason(self, own: Endpoint) -> str:
        there = [e for e in self._snapshot().on(own.topic) if not e.is_publisher]
        if not there:
            return f"{own.topic} has no subscriptions"
        return explain([*there, own]) if mismatches([*there, own]) else "the others do not exist"

    def draw(self, caller: ServiceCaller, request: ProbeRequest) -> dict[str, Any]:
        """Write the graph to files; `notes` say why a drawing is not possible."""
        snapshot = self._snapshot().snapshot
        data, drawing = request.optional_text("json"), request.optional_text("svg")
        notes: list[str] = []
        if data is not None:
            text = strict_json.dumps(to_document(snapshot), indent=2, ensure_ascii=False)
            _write(data, f"{text}\n")
        if drawing is not None:
            from launcher.ros.draw.dot import to_dot, to_svg

            try:
                _write(drawing, to_svg(to_dot(Filter().apply(snapshot), Mode.ALL)))
            except LauncherError as error:
                notes.append(": ".join(filter(None, [error.message, error.hint])))
                drawing = None
        return {"json": data, "svg": drawing, "notes": notes}


def _repeat(
    caller: ServiceCaller,
    request: ProbeRequest,
    publisher: Publisher,
    message: Any,
    stamps: Sequence[Stamp],
) -> int:
    """Publish as often as the request says; how often, which is less if it is cancelled."""
    times = int(request.number("times", 1))
    pause_s = 1.0 / (request.number("rate_hz", 1.0) or 1)
    for number in range(times):
        if pause(caller, request, pause_s if number else 0.0):
            return number
        stamp_all(stamps, caller.observer.node.get_clock().now().to_msg())
        publisher.publish(message)
    return times


def _write(path: str, text: str) -> None:
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise VerbError(f"{path}: {error.strerror}") from None
