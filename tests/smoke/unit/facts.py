"""Made-up facts of a run for the tests of judges."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph
from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.judges import judge
from launcher.smoke.observe.facts import (
    Ending,
    Facts,
    GraphSeen,
    LogLine,
    ObservedMessage,
    ProcessEvent,
    UsageSample,
)
from launcher.smoke.preflight.loader import parse
from tests.support import run_events

STRING = "std_msgs/msg/String"
MB = 1024 * 1024
END_S = 20.0
OVER = Ending(asked_s=END_S, down_s=END_S + 0.5, returncode=0)


def expectation(entry: str) -> Expectation:
    scenario = "scenario: [{do: kill robot_1, name: kill}]"
    (found,) = parse(f"{scenario}\nexpect: [{{{entry}}}]", "x.yaml").expectations
    return found


def verdict(entry: str, **facts: Any) -> Verdict:
    """The verdict at the end of a run of 20 s, unless the facts say otherwise."""
    return judge(expectation(entry), seen(**facts))


def seen(**facts: Any) -> Facts:
    steps = {"start": 0.0, "ready": 1.0, "stop": END_S, **facts.pop("steps", {})}
    given = {"now_s": END_S + 1, "ending": OVER, "events": started("robot_1-1"), **facts}
    return Facts(steps=steps, **given)


def running(now_s: float, **facts: Any) -> Facts:
    """A run that goes on."""
    steps = {"start": 0.0, **facts.pop("steps", {})}
    return Facts(now_s=now_s, steps=steps, **{"events": started("robot_1-1"), **facts})


def event(kind: str, name: str, at_s: float, **details: Any) -> ProcessEvent[Any]:
    return ProcessEvent(at_s=at_s, event=run_events.event(kind, **details), process=name)


def started(*names: str, at_s: float = 0.1) -> tuple[ProcessEvent[Any], ...]:
    return tuple(event("started", name, at_s) for name in names)


def ended(name: str, returncode: int, at_s: float, **details: Any) -> ProcessEvent[Any]:
    given = {"asked": False, "restart_in_s": None, **details}
    return event("ended", name, at_s, returncode=returncode, **given)


def ready(name: str, at_s: float) -> ProcessEvent[Any]:
    return event("ready", name, at_s, ready_s=1.0)


def unready(name: str, at_s: float) -> ProcessEvent[Any]:
    return event("started", name, at_s, ready_when=("publisher on /t",))


def signalled(name: str, signum: int, at_s: float) -> ProcessEvent[Any]:
    return event("signal", name, at_s, signal=signum)


def lines(*texts: str, process: str | None = "robot_1-1", at_s: float = 1.0) -> tuple[LogLine, ...]:
    """Lines of a process, a second apart."""
    return tuple(
        LogLine(at_s=at_s + number, process=process, text=text) for number, text in enumerate(texts)
    )


def publisher(topic: str, node: str = "/talker", **qos: Any) -> Endpoint:
    return _endpoint(topic, node, "publisher", **qos)


def subscription(topic: str, node: str = "/listener", **qos: Any) -> Endpoint:
    return _endpoint(topic, node, "subscription", **qos)


def _endpoint(topic: str, node: str, direction: str, **qos: Any) -> Endpoint:
    given = {"type": STRING, "reliability": "RELIABLE", "durability": "VOLATILE", **qos}
    return Endpoint(topic=topic, node=node, direction=direction, **given)


def graph(
    *endpoints: Endpoint,
    nodes: tuple[str, ...] = (),
    ghosts: tuple[str, ...] = (),
    at_s: float = 2,
    services: Mapping[str, tuple[str, ...]] | None = None,
) -> GraphSeen:
    names = {*nodes, *(e.node for e in endpoints)}
    snapshot = TopicGraph(nodes=tuple(sorted(names)), endpoints=endpoints, ghosts=ghosts)
    topics = {e.topic: (e.type,) for e in endpoints}
    return GraphSeen(at_s=at_s, snapshot=snapshot, topics=topics, services=services or {})


EMPTY = graph(at_s=0.0)


def texts(topic: str, *contents: Any, at_s: float = 2.0, period_s: float = 1.0) -> Any:
    """Messages of std_msgs/String with JSON in them."""
    return tuple(
        ObservedMessage(
            at_s=at_s + n * period_s, topic=topic, content={"data": json.dumps(content)}
        )
        for n, content in enumerate(contents)
    )


def ticks(topic: str, period_s: float, *, from_s: float = 2.0, to_s: float = END_S) -> Any:
    """Messages of a timer."""
    count = int((to_s - from_s) / period_s) + 1
    return texts(topic, *range(count), at_s=from_s, period_s=period_s)


def samples(name: str, *values: tuple[float, int]) -> tuple[UsageSample, ...]:
    """(CPU in percent, MB) once a second."""
    return tuple(
        UsageSample(at_s=1.0 + number, process=name, cpu_percent=cpu, memory_bytes=mb * MB)
        for number, (cpu, mb) in enumerate(values)
    )
