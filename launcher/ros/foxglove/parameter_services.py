"""Parameters of all nodes under the names of ROS's bridge for Foxglove: `/node.parameter`."""

from __future__ import annotations

import asyncio
import base64
import binascii
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
)
from rclpy.serialization import deserialize_message

from launcher.base.ros_errors import VerbError
from launcher.ros import parameter_values
from launcher.ros import parameters as ros_parameters
from launcher.ros.foxglove.feeds import TopicFeeds
from launcher.ros.foxglove.service_calls import ServiceCalls
from launcher.ros.verb import to_json_plain

LIMIT_S = 2.0  # for the answer of a node
_TYPES = {
    parameter_values.BYTES: "byte_array",
    parameter_values.DOUBLE: "float64",
    parameter_values.DOUBLES: "float64_array",
}
_TOPIC, _TYPE = "/parameter_events", "rcl_interfaces/msg/ParameterEvent"


class Parameters:
    """Asks the nodes, all at the same time; those that do not answer are left out."""

    def __init__(self, calls: ServiceCalls) -> None:
        self._calls = calls
        self.nodes: set[str] = set()  # those that have parameter services

    async def get(self, names: Iterable[str]) -> list[dict[str, Any]]:
        """These parameters, or all without names, as clients get them."""
        wanted: dict[str, list[str] | None] = _by_node(names)
        asked = wanted or dict.fromkeys(sorted(self.nodes))
        found = await asyncio.gather(
            *(self._of_node(node, asked[node]) for node in asked if node in self.nodes)
        )
        return [to_json(name, value) for values in found for name, value in values.items()]

    async def set(self, items: Iterable[Mapping[str, Any]]) -> tuple[list[Any], list[str]]:
        """Set them; their values afterwards, and what was refused, as sentences."""
        by_node: dict[str, list[Mapping[str, Any]]] = {}
        problems: list[str] = []
        for item in items:
            node = _split(item["name"])[0]
            if node in self.nodes:
                by_node.setdefault(node, []).append(item)
            else:
                problems.append(f"{item['name']}: there is no node {node} with parameters")
        refused = await asyncio.gather(*(self._set(*entry) for entry in by_node.items()))
        problems += [problem for some in refused for problem in some]
        names = [item["name"] for items in by_node.values() for item in items]
        return (await self.get(names) if names else []), problems

    async def _set(self, node: str, items: list[Mapping[str, Any]]) -> list[str]:
        """What was refused."""
        names = [_split(item["name"])[1] for item in items]
        try:
            declared = await self._answers(
                DescribeParameters, f"{node}/describe_parameters", "descriptors", names
            )
        except VerbError as error:
            return [error.message]
        wanted, problems = [], []
        for name, item in zip(names, items, strict=True):
            try:
                known = declared[name]
                kind = parameter_values.type_for_json(known) if known else parameter_values.NOT_SET
                wanted.append(to_parameter(name, item, kind))
            except VerbError as error:
                problems.append(f"{item['name']}: {error.message}")
        if not wanted:
            return problems
        request = SetParameters.Request(parameters=wanted)
        try:
            answer = await asyncio.wait_for(
                self._calls.call(SetParameters, f"{node}/set_parameters", request), LIMIT_S
            )
        except asyncio.TimeoutError:
            return [*problems, f"{node} did not answer within {LIMIT_S:g} s"]
        except VerbError as error:
            return [*problems, error.message]
        results = ros_parameters.results_of(answer, len(wanted))
        for one, result in zip(wanted, results, strict=True):
            if not result.successful:
                problems.append(f"{node}.{one.name}: {result.reason or 'refused'}")
        return problems

    async def _of_node(self, node: str, names: list[str] | None) -> dict[str, Any]:
        """Name -> ParameterValue of those that the node has; nothing if it does not answer."""
        try:
            listed = await self._calls.ask(
                ListParameters, f"{node}/list_parameters", ListParameters.Request(), LIMIT_S
            )
            known = set(listed.result.names)
            asked = sorted(known if names is None else known.intersection(names))
            values = await self._answers(GetParameters, f"{node}/get_parameters", "values", asked)
        except VerbError:
            return {}
        return {f"{node}.{name}": value or ParameterValue() for name, value in values.items()}

    async def _answers(
        self, kind: Any, service: str, field: str, names: list[str]
    ) -> dict[str, Any]:
        """Name -> what the node answers for it, None for nothing; VerbError."""
        asking = ros_parameters.answers(names)
        try:
            asked = next(asking)
            while True:
                request = kind.Request(names=asked)
                answer = await self._calls.ask(kind, service, request, LIMIT_S)
                asked = asking.send(getattr(answer, field))
        except StopIteration as end:
            found: dict[str, Any] = end.value
            return found


def changed_by(event: Any) -> list[dict[str, Any]]:
    """What a message of /parameter_events says, as clients get it."""
    changed = [*event.new_parameters, *event.changed_parameters]
    return [
        *(to_json(f"{event.node}.{one.name}", one.value) for one in changed),
        *({"name": f"{event.node}.{one.name}"} for one in event.deleted_parameters),
    ]


def to_json(name: str, value: Any) -> dict[str, Any]:
    """A ParameterValue as clients get it; no value if it is not set."""
    if value.type not in parameter_values.KINDS:
        return {"name": name}
    plain = parameter_values.plain_value(value)
    if value.type == parameter_values.BYTES:
        plain = base64.b64encode(bytes(plain)).decode()
    kind = {"type": _TYPES[value.type]} if value.type in _TYPES else {}
    return {"name": name, "value": to_json_plain(plain), **kind}


def to_parameter(name: str, item: Mapping[str, Any], declared: int) -> Any:
    """The value that a client requests for a parameter; VerbError if it cannot have it."""
    value, kind = item.get("value"), item.get("type")
    if value is None:
        return Parameter(name=name, value=ParameterValue())
    try:
        if kind == "byte_array":
            value, declared = list(base64.b64decode(value, validate=True)), parameter_values.BYTES
        elif kind == "float64":
            value = float(value)
        elif kind == "float64_array":
            value = [float(one) for one in value]
    except (TypeError, ValueError, binascii.Error):
        raise VerbError(f"the value is no {kind}") from None
    return parameter_values.plain_parameter(name, value, declared)


def _split(name: str) -> tuple[str, str]:
    """The node, whose name has no dots, and the name that it has for the parameter."""
    node, _, own = name.partition(".")
    return f"/{node.lstrip('/')}", own


def _by_node(names: Iterable[str]) -> dict[str, list[str] | None]:
    found: dict[str, list[str]] = {}
    for name in names:
        node, own = _split(name)
        found.setdefault(node, []).append(own)
    return dict(found)


class ParameterEvents:
    """Follows /parameter_events while a client subscribes to changes.

    `notify` is called in the event loop with what has changed, as clients get it.
    """

    def __init__(self, feeds: TopicFeeds, notify: Callable[[list[dict[str, Any]]], None]) -> None:
        self._feeds = feeds
        self._notify = notify
        self._loop = asyncio.get_running_loop()

    def follow(self, wanted: bool) -> None:
        """In the thread of the feeds."""
        if wanted:
            self._feeds.subscribe(_TOPIC, _TYPE, self, self._deliver)
        else:
            self._feeds.unsubscribe(_TOPIC, self)

    def _deliver(self, time_ns: int, payload: bytes) -> None:
        changed = changed_by(deserialize_message(payload, ParameterEvent))
        if changed and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._notify, changed)
