"""`service echo`: prints the events that services and clients with introspection publish."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.discovery.completeness import settled_graph
from launcher.ros.messages.classes import type_name
from launcher.ros.messages.interfaces import load
from launcher.ros.messages.to_yaml import dump, to_plain
from launcher.ros.snapshot.ros_graph import Direction, GraphSnapshot, is_hidden
from launcher.ros.topics.echo import Writer
from launcher.ros.topics.listener import Listener
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import GraphAccess, observing, say
from launcher.ros.verbs.awaited_topics import TopicSubscriber
from launcher.ros.verbs.streams import ListeningLimit, nothing_came, until_interrupted

_NAMES = ("REQUEST_SENT", "REQUEST_RECEIVED", "RESPONSE_SENT", "RESPONSE_RECEIVED")


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceEchoOptions:
    """What `service echo` was asked for."""

    access: GraphAccess
    service: str
    type: str | None
    writer: EventWriter
    qos: QosOptions
    timeout_s: float | None


class EventWriter(Writer):
    """Writes the names of events instead of their numbers, but in CSV, as ros2cli does."""

    def _plain(self, value: object) -> Any:
        plain = to_plain(value, self.style)
        if type_name(type(value)).endswith("_Event"):
            with contextlib.suppress(IndexError):
                plain["info"]["event_type"] = _NAMES[plain["info"]["event_type"]]
        return plain

    def _body(self, value: object) -> Iterator[str]:
        if self.csv:
            yield from super()._body(value)
        else:
            yield dump(self._plain(value), flow=self.style.flow)


def echo(options: ServiceEchoOptions) -> int:
    """Print events until Ctrl-C, or the end of `timeout_s`."""
    service = full_name(options.service)
    topic = f"{service}/_service_event"
    is_silent = True

    def enough(graph: GraphSnapshot) -> bool:
        return service in graph.service_types() and bool(graph.on(topic, Direction.PUBLISHER))

    with (
        until_interrupted(is_end=options.timeout_s is None),
        observing(options.access, enough, listens=True) as observer,
    ):
        graph = settled_graph(observer, options.access.spin_time_s, enough)
        listener = Listener(observer, raw=False)
        is_json = options.writer.json
        subscriber = TopicSubscriber(
            observer, listener, options.qos, options.access.spin_time_s, json=is_json
        )
        subscriber.subscribe_now(topic, f"{_type(graph, service, options.type)}_Event")
        if not graph.on(topic, Direction.PUBLISHER):
            say(
                f"No publishers on topic '{topic}'; "
                "is service introspection on the client or server enabled?",
                json=is_json,
            )
        limit = ListeningLimit(options.timeout_s)
        for sample in listener.samples(limit.tick):
            is_silent, limit.is_fresh = False, True
            sys.stdout.writelines(options.writer.pieces(sample, options.writer.values(sample)))
    if is_silent and options.timeout_s is not None:
        return nothing_came([topic], options.timeout_s)
    return ExitCode.OK


def _type(graph: GraphSnapshot, service: str, given: str | None) -> str:
    """The full type of the service; VerbError with the text of ros2cli."""
    types = graph.service_types().get(service, [])
    if given is None and not types:
        known = [name for name in graph.service_types() if not is_hidden(name)]
        hint = did_you_mean(service, known)
        raise VerbError(f"Cannot find type for '{service}'", hint=hint)
    if given is None and len(types) > 1:
        raise VerbError(
            f"service '{service}' has more than one type: {', '.join(types)}",
            hint="name one of them after the service",
        )
    name = types[0] if given is None else given
    return type_name(load(name, "srv", f"The service type '{name}' is invalid"))
