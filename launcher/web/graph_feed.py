"""What the probe observes, for the pages: the graph, rates, messages, numbers to plot."""

from __future__ import annotations

import asyncio
import math
import re
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from launcher.base import strict_json
from launcher.web import layout
from launcher.web.graph_state import GraphState, Rows
from launcher.web.hub import Hub, Message
from launcher.web.page_probe import Answer, PageProbe

MAX_RESTARTS = 3  # in so many seconds:
RESTARTS_S = 60.0
_RESTART_S = 1.0
TRAFFIC_S = 1.0
ECHO_HZ = 10
PLOT_HZ = 50
_POINTS_S = 0.2
_FIRST_PICTURE_S = 1.0
_MESSAGE_KEYS = ("topic", "wall", "sent", "data", "skipped", "error", "bytes")
# Requests of pages to the probe; the second ones change something.
READING = frozenset({"explain", "frames", "get_parameters", "describe_parameters", "form"})
CHANGING = frozenset({"set_parameters", "call", "publish"})
KEEP_POINTS = 20_000
KEEP_S = 600.0
Point = tuple[float, float | None]
_NOT_FINITE = ("nan", "inf", "-inf")  # as the probe sends them: JSON has no such numbers
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


class GraphFeed:
    """Starts the probe when the first page opens, and subscribes to what pages show."""

    def __init__(self, hub: Hub, rows: Callable[[], Rows] = list) -> None:
        self.environment: dict[str, str] = {}  # of the probe, besides ours
        self.reason: str | None = None  # why there is no graph
        self.graph: Message | None = None
        self.traffic: dict[str, dict[str, Any]] = {}
        self._hub = hub
        self._rows = rows  # of `ps`
        self._state = GraphState()
        self._layout = layout.Layout()
        self._has_graphviz = True
        self._arranging: asyncio.Task[None] | None = None
        self._probe: PageProbe | None = None
        self._deaths: deque[float] = deque()  # of the probe, of the last RESTARTS_S
        self._starting: asyncio.Task[None] | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._subscribed: set[tuple[str, str]] = set()
        self._series: dict[tuple[str, str], Series] = {}
        self._watch_until = 0.0  # of the clients that are no pages

    async def start(self) -> None:
        """Start the probe, unless it runs already or has failed too often."""
        if self._probe is not None or self._dies_too_often():
            return
        self._probe = probe = PageProbe(self._take, self._died, self.environment)
        try:
            await probe.start()
        except OSError as error:
            self._died(error.strerror or str(error))
            return
        if not self._tasks:
            self._tasks = [
                self._hub.start(self._send_traffic()),
                self._hub.start(self._send_points()),
            ]
            self._arranging = self._hub.start(self._warm_up())

    def start_soon(self) -> None:
        """Start the probe when the first picture is drawn, for which it leaves the processor."""
        if self._probe is None and (self._starting is None or self._starting.done()):
            self._starting = self._hub.start(self._start_later(_FIRST_PICTURE_S))

    async def _start_later(self, pause_s: float) -> None:
        await asyncio.sleep(pause_s)
        if len(self._hub):
            await self.start()

    async def close(self) -> None:
        if self._starting is not None:
            self._starting.cancel()
        for task in self._tasks:
            task.cancel()
        if self._arranging is not None:
            self._arranging.cancel()
        if self._probe is not None:
            await self._probe.close()

    def available(self) -> dict[str, Any]:
        return {"available": self.reason is None, "reason": self.reason}

    def opening(self) -> list[Message]:
        """What a page gets when it opens."""
        messages = [] if self.graph is None else [self.graph]
        if self.traffic:
            messages.append({"event": "topics", "wall": time.time(), "topics": self.traffic})
        return messages

    async def ask(
        self, request: dict[str, Any], on_id: Callable[[int], None] | None = None
    ) -> Answer:
        """An answer of the probe; `on_id` gets the id of the request there."""
        await self.start()
        if self._probe is None:
            message = f"the ROS graph cannot be read: {self.reason}"
            return {"ok": False, "error": {"message": message, "hint": None}}
        return await self._probe.ask(request, on_id)

    async def cancel(self, number: int) -> Answer:
        """End a request to the probe before it is done."""
        return await self.ask({"do": "cancel", "of": number})

    def cancel_all(self, numbers: Iterable[int]) -> None:
        """The same for several, when nobody waits for the answers."""
        if self._probe is not None:
            for number in numbers:
                self._probe.send({"do": "cancel", "of": number})

    def watch_topics(self, duration_s: float) -> None:
        """Measure all topics for so long even if no page shows them."""
        self._watch_until = time.monotonic() + duration_s
        self.subscribe()

    # ---- what comes in

    def _take(self, event: dict[str, Any]) -> None:
        kind = event["event"]
        if kind == "ready":
            self._send_reason(None)
        elif kind == "graph":
            self._state.take(event, self._rows(), time.time())
            self._show()
            self.subscribe()
        elif kind == "message":
            self._take_message(event)

    def _take_message(self, event: dict[str, Any]) -> None:
        kind, topic = event["sub"][0], event["topic"]
        if kind == "e":
            message = {key: event.get(key) for key in _MESSAGE_KEYS}
            self._hub.send({"event": "message", **message}, to=("echo", topic))
            return
        for (of, field), series in self._series.items():
            if of == topic:
                series.add(event["wall"], numbers_at(event["data"], field))

    def _died(self, reason: str) -> None:
        self._probe = None
        self._state.restart()
        self._subscribed = set()
        self.traffic = {}
        self._deaths.append(time.monotonic())
        if self._dies_too_often():
            many = f"it ended {len(self._deaths)} times in {RESTARTS_S:g} s"
            self._send_reason(f"{reason} ({many}, and is not started again for now)")
            return
        self._send_reason(reason)
        self._starting = self._hub.start(self._start_later(_RESTART_S))

    def _dies_too_often(self) -> bool:
        while self._deaths and time.monotonic() - self._deaths[0] > RESTARTS_S:
            self._deaths.popleft()
        return len(self._deaths) > MAX_RESTARTS

    def _send_reason(self, reason: str | None) -> None:
        """Keep why there is no graph, and send it to the pages if that has changed."""
        if reason != self.reason:
            self.reason = reason
            self._hub.send({"event": "probe", **self.available()})

    # ---- the picture

    def forget(self, node: str) -> bool:
        """Stop showing a node that has gone."""
        known = self._state.forget(node)
        self._show()
        return known

    def arrange(self) -> bool:
        """Arrange the picture anew; False if that is the browser's part."""
        if self._has_graphviz and self.graph is not None and not self._is_arranging():
            self._arranging = self._hub.start(self._arrange())
        return self._has_graphviz

    def _show(self) -> None:
        """Send the graph if it has changed."""
        graph = self._state.document(self._rows(), time.time())
        if graph is None:
            return
        if not self._has_graphviz:
            self._send_graph({**graph, "positions": None})
            return
        if not self._is_arranging() and self._layout.wants_arrangement(graph, time.monotonic()):
            self._arranging = self._hub.start(self._arrange())
        self._layout.place(graph)
        self._send_graph({**graph, "positions": self._layout.positions()})

    def _send_graph(self, graph: Message) -> None:
        if graph != self.graph:
            self.graph = graph
            self._hub.send(graph)

    def _is_arranging(self) -> bool:
        return self._arranging is not None and not self._arranging.done()

    async def _warm_up(self) -> None:
        """The first drawing takes seconds, because WebAssembly is compiled."""
        self._has_graphviz = await asyncio.to_thread(layout.render, "digraph g {}") is not None
        self._arranging = None
        self._show()

    async def _arrange(self) -> None:
        graph = self._state.document(self._rows(), time.time())
        if graph is None:
            return
        drawn = await asyncio.to_thread(layout.render, layout.source(graph))
        if drawn is not None:
            self._layout.take(graph, drawn)
        self._arranging = None
        self._show()

    # ---- subscriptions

    def subscribe(self) -> None:
        """Make the probe's subscriptions those of the pages."""
        if self._probe is None:
            return
        wanted = self._wanted()
        for kind, topic in self._subscribed - wanted:
            self._probe.send({"do": "unsubscribe", "sub": f"{kind}:{topic}"})
        for kind, topic in wanted - self._subscribed:
            self._probe.send(_subscription(kind, topic))
        self._subscribed = wanted

    def _wanted(self) -> set[tuple[str, str]]:
        plots = self._hub.subscribed("plot")
        pairs = {(topic, field) for topic, _, field in (one.partition("\n") for one in plots)}
        for gone in self._series.keys() - pairs:
            del self._series[gone]
        for new in pairs - self._series.keys():
            self._series[new] = Series()
        wanted = {("e", topic) for topic in self._hub.subscribed("echo")}
        wanted |= {("p", topic) for topic, _ in pairs}
        is_watched = self._hub.subscribed("topics") or time.monotonic() < self._watch_until
        if is_watched and self.graph is not None:
            wanted |= {("t", topic["name"]) for topic in self.graph["topics"]}
        return wanted

    async def _send_traffic(self) -> None:
        while True:
            await asyncio.sleep(TRAFFIC_S)
            self._show()  # nodes that have gone are forgotten, and `ps` learns names
            if self._probe is None or not any(kind == "t" for kind, _ in self._subscribed):
                self.traffic = {}
                continue
            answer = await self._probe.ask({"do": "traffic"})
            if answer.get("ok"):
                subs = answer["result"]["subs"]
                self.traffic = {
                    one["topic"]: one for key, one in subs.items() if key.startswith("t:")
                }
                message = {"event": "topics", "wall": time.time(), "topics": self.traffic}
                self._hub.send(message, to=("topics", ""))
            self.subscribe()

    async def _send_points(self) -> None:
        while True:
            await asyncio.sleep(_POINTS_S)
            for (topic, field), series in self._series.items():
                points = series.take_new()
                if points:
                    self._hub.send(
                        _points(topic, field, points, reset=False),
                        to=("plot", f"{topic}\n{field}"),
                    )

    def earlier_points(self, topic: str, field: str) -> Message | None:
        """All points of a plot, for a page that begins to show it."""
        series = self._series.get((topic, field))
        return None if series is None else _points(topic, field, series.all(), reset=True)


def _points(topic: str, field: str, points: list[Point], *, reset: bool) -> Message:
    return {"event": "points", "topic": topic, "field": field, "points": points, "reset": reset}


def _subscription(kind: str, topic: str) -> dict[str, Any]:
    request: dict[str, Any] = {"do": "subscribe", "sub": f"{kind}:{topic}", "topic": topic}
    if kind == "t":
        return {**request, "messages": False}
    return {**request, "most_hz": ECHO_HZ if kind == "e" else PLOT_HZ}


def numbers_at(data: object, path: str) -> float | None:
    """The number (or truth value) at this path of a message; None if there is none."""
    value = data
    for name, index in _STEP.findall(path):
        value = _opened(value)
        try:
            value = value[int(index)] if index else value[name]
        except (KeyError, IndexError, TypeError):
            return None
    value = _opened(value)
    if not isinstance(value, (int, float)) and value not in _NOT_FINITE:
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _opened(value: object) -> Any:
    """What a string of JSON holds, or the value itself."""
    if isinstance(value, str):
        try:
            return strict_json.unpacked(value)
        except ValueError:
            return value
    return value


class Series:
    """The points (wall time, value) of one plot in the last minutes.

    NaN and infinity become a gap, whose value is None.
    """

    def __init__(self) -> None:
        self._points: deque[Point] = deque(maxlen=KEEP_POINTS)
        self._new: list[Point] = []

    def add(self, wall: float, value: float | None) -> None:
        if value is None:
            return
        point = (wall, value if math.isfinite(value) else None)
        if point[1] is None and (not self._points or self._points[-1][1] is None):
            return
        self._points.append(point)
        self._new.append(point)
        while wall - self._points[0][0] > KEEP_S:
            self._points.popleft()

    def take_new(self) -> list[Point]:
        """The points since the last call."""
        new, self._new = self._new, []
        return new

    def all(self) -> list[Point]:
        return list(self._points)
