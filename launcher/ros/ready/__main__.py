"""Reports which facts of the ROS graph hold: `python -m launcher.ros.ready`, started by a run.

It reads requests from standard input and writes what it sees, a JSON object a line, and ends with
its input.

| request | |
|---|---|
| `{"watch": N, "fact": {...}, "since_s": S}` | report each change of what is seen of it: |
| | `{"watch": N, "holds": bool, "text": T}`; when it holds, for the last time |
| `{"unwatch": N}` | |

It reads discovery messages itself where that is possible (`DiscoveryFollower`), and loads rclpy
only for facts that need a node, or where discovery is not plain RTPS.
"""

from __future__ import annotations

import contextlib
import os
import select
from typing import TYPE_CHECKING, Any

from launcher.base import strict_json
from launcher.base.model.supervision import Fact
from launcher.posix import dispositions
from launcher.posix.domains import environment_domain, is_plain, localhost_only
from launcher.posix.stdio import keep_for_messages
from launcher.ros.discovery.discovery_reader import UnsupportedDiscovery
from launcher.ros.discovery.follower import DiscoveryFollower
from launcher.ros.ready.graph_conditions import Seen, WatchedFact, in_graph
from launcher.ros.ready.views import GraphView, followed

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.ready.node_facts import Calls, Introductions
    from launcher.ros.ready.views import ObservedView

_GRAPH_S = 0.1  # at most until a change of the graph is noticed
_CALLS_S = 0.02  # the same, of a message or an answer
_IDLE_S = 1.0  # while nothing is watched


class FactWatcher:
    """Watches facts until its input ends."""

    def __init__(self, stack: contextlib.ExitStack) -> None:
        self._stack = stack
        self._partial = b""
        self._watched: dict[int, WatchedFact] = {}
        self._reported: dict[int, Seen] = {}
        self._follower: DiscoveryFollower | None = None
        self._observed: ObservedView | None = None
        self._calls: Calls | None = None
        self._introductions: Introductions | None = None
        self._version: object = None
        self._last_view = GraphView(())
        if is_plain():
            follower = DiscoveryFollower(environment_domain(), remote=not localhost_only())
            with contextlib.suppress(OSError):  # no network: then rclpy reads the graph
                self._follower = stack.enter_context(follower)

    def run(self) -> None:
        while True:
            is_busy = self._calls is not None and self._calls.is_busy
            period_s = _CALLS_S if is_busy else _GRAPH_S if self._watched else _IDLE_S
            sources: list[Any] = [0]
            if self._follower is not None and self._watched:
                sources.append(self._follower)
            readable, _, _ = select.select(sources, [], [], period_s)
            if 0 in readable and not self._read():
                return
            self._look()

    # ---- requests

    def _read(self) -> bool:
        """Take requests; False at the end of the input."""
        chunk = os.read(0, 65536)
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        for line in lines:
            request = strict_json.unpacked(line)
            if "unwatch" in request:
                self._forget(request["unwatch"])
            else:
                fact = Fact(**{**request["fact"], "words": ()})
                self._watched[request["watch"]] = WatchedFact(fact, request["since_s"])
        return bool(chunk)

    def _forget(self, number: int) -> None:
        self._watched.pop(number, None)
        self._reported.pop(number, None)
        if self._calls is not None:
            self._calls.forget(number)

    # ---- looking

    def _look(self) -> None:
        if any(watched.needs_node for watched in self._watched.values()):
            self._open_calls()
        view = self._view()
        if self._calls is not None:
            if self._follower is not None and self._introductions is not None and self._watched:
                self._introductions.introduce(self._follower.participants)
            self._calls.spin()
        for number, watched in list(self._watched.items()):
            seen = in_graph(watched, view)
            if seen.holds and watched.needs_node:
                assert self._calls is not None
                seen = self._calls.look(number, watched, view)
            self._report(number, seen)

    def _report(self, number: int, seen: Seen) -> None:
        if self._reported.get(number) == seen:
            return
        self._reported[number] = seen
        if seen.holds:
            self._forget(number)
        line = {"watch": number, "holds": seen.holds, "text": seen.text}
        print(strict_json.packed(line), flush=True)

    def _view(self) -> GraphView:
        if self._follower is not None:
            try:
                self._follower.poll()
                if self._follower.version != self._version:
                    self._version = self._follower.version
                    self._last_view = followed(self._follower)
                return self._last_view
            except UnsupportedDiscovery:
                self._follower = None
        if self._observed is None:
            from launcher.ros.ready.views import ObservedView

            self._observed = ObservedView(self._observer())
        return self._observed.view()

    def _open_calls(self) -> None:
        if self._calls is None:
            from launcher.ros.ready.node_facts import Calls, Introductions

            self._calls = Calls(self._observer())
            if self._follower is not None:
                self._introductions = Introductions(self._calls.observer)

    def _observer(self) -> Observer:
        """The one node of this process, for the graph and for calls."""
        if self._calls is not None:
            return self._calls.observer
        if self._observed is not None:
            return self._observed.observer
        from launcher.ros import probe
        from launcher.ros.discovery.observer import Observer

        # announces us more often, to nodes that start later; a profile of the user takes precedence
        profile = os.path.join(os.path.dirname(probe.__file__), "participant.xml")
        return self._stack.enter_context(Observer(purpose="ready", profile=profile))


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    with contextlib.ExitStack() as stack:
        FactWatcher(stack).run()


if __name__ == "__main__":
    main()
