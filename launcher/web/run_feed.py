"""What the control socket sends, for the pages: processes, lines, events, the plan."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.base.model.event_entries import entry_of
from launcher.base.model.run_events import Ended, Reloaded, Started
from launcher.control.answer_lines import event_line
from launcher.web.batch import Batch
from launcher.web.fault_feed import FaultFeed
from launcher.web.hub import Hub, Message
from launcher.web.log_store import LogStore
from launcher.web.page_plan_tree import Tree, named, numbered, read_tree
from launcher.web.run_client import RunClient

KEEP_SAMPLES = 120  # two minutes: so many are drawn
KEEP_EVENTS = 4000  # as many as the run itself
LINES_PER_S = 500  # of one process; more are counted only
_EARLIER_LINES = 10_000
_BATCH_S = 0.1
_BEAT_S = 2.0  # so often, pages get a message
_SAMPLED = ("cpu", "memory", "lines")  # what a sample holds, in this order
_FIRST_LINES = 3000  # a page that opens gets these at once, and asks for older ones
_PLAN_DELAY_S = 0.5
_EXPECTATIONS = "expectations.json"  # of smoke, in the log folder of the run


class RunFeed:
    """Follows a run and passes changes to the hub. `on_end` is called when the run has ended."""

    def __init__(self, hub: Hub, on_end: Callable[[], None]) -> None:
        self.log = LogStore()
        self.events: deque[dict[str, Any]] = deque(maxlen=KEEP_EVENTS)
        self.rows: list[dict[str, Any]] = []
        self.ended: Message | None = None
        self.plan: dict[str, Any] | None = None
        self.expectations: Message | None = None
        self.faults = FaultFeed(hub)
        self._hub = hub
        self._on_end = on_end
        self._requests = RunClient(self._has_ended)
        # A separate connection: a flood of lines must not displace events and answers.
        self._lines = RunClient(self._has_ended)
        self._open = 2  # connections
        self._walls: deque[float] = deque(maxlen=KEEP_SAMPLES)
        self._samples: dict[str, deque[tuple[Any, Any, Any]]] = {}
        self._counted: dict[str | None, int] = {}
        self._batch: Batch[Any] = Batch(_BATCH_S, self._send_lines)
        self._socket = Path()
        self._is_closing = False
        self._is_plan_old = False
        self._heard_s = time.monotonic()
        self._beating: asyncio.Task[None] | None = None
        self._planning: asyncio.Task[None] | None = None
        self._tree: Tree | None = None
        self._reading_tree: asyncio.Task[None] | None = None
        self._expectations_read: int | None = None

    @property
    def run(self) -> dict[str, Any]:
        """What the run says of itself in its first line."""
        found: dict[str, Any] = self._requests.hello["run"]
        return found

    @property
    def launcher(self) -> str:
        """The version of the launcher."""
        return str(self._requests.hello.get("launcher", ""))

    @property
    def ros(self) -> str:
        """Which ROS 2 is in use there."""
        return str(self._requests.hello.get("ros", ""))

    async def start(self, socket: Path) -> None:
        """Connect; ControlError."""
        self._socket = socket
        await self._requests.connect(socket)
        await self._lines.connect(socket)
        self._requests.follow("events", self._take_event)
        self._requests.follow("top", self._take_processes)
        self._lines.follow("logs", self._take_line, lines=_EARLIER_LINES, max_rate=LINES_PER_S)
        self.faults.start(self._requests)
        self._plan_soon()
        self._beating = self._hub.start(self._beat())

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(_BEAT_S)
            silent_s = round(time.monotonic() - self._heard_s, 1)
            self._hub.send({"event": "alive", "silent_s": silent_s})

    async def close(self) -> None:
        self._is_closing = True
        if self._beating is not None:
            self._beating.cancel()
        if self._reading_tree is not None:
            self._reading_tree.cancel()
        await self._requests.close()
        await self._lines.close()

    async def connect_page(self) -> RunClient:
        """A connection for the requests of one page, which end with it; ControlError."""
        client = RunClient(lambda: None)
        await client.connect(self._socket)
        return client

    # ---- what comes in

    def _take_line(self, item: dict[str, Any]) -> None:
        self._batch.add(self.log.add(item))

    def _send_lines(self, lines: list[Any]) -> None:
        first = self.log.next_number - len(lines)
        self._hub.send({"event": "lines", "first": first, "lines": lines})

    def flush(self) -> None:
        """Send the lines and faults that have been collected."""
        self._batch.flush()
        self.faults.flush()

    def _take_event(self, item: dict[str, Any]) -> None:
        entry = entry_of(item)
        if entry is None:  # events were not read in time
            self._send_event({"event": "other", "wall_s": time.time(), "text": event_line(item)})
            return
        if entry.event.is_sample:
            return  # `top` has them
        self._send_event({**item, "text": entry.event.text})
        match entry.event:
            case Started() | Ended():
                self._change(entry.process, entry.event)
                self._plan_soon()
            case Reloaded() if self._reading_tree is not None:
                self._reading_tree = self._hub.start(self._read_tree())

    def _send_event(self, shown: dict[str, Any]) -> None:
        self.events.append(shown)
        self._hub.send({"event": "run_events", "items": [shown], "reset": False})

    def _change(self, name: str | None, event: Started | Ended) -> None:
        """Change the row of a process that has started or ended: the last rows of a run are old."""
        for row in self.rows:
            if row["name"] != name:
                continue
            if isinstance(event, Started):
                row.update(state="RUNNING", pid=event.pid)
            elif event.restart_in_s is not None:
                row.update(state="BACKOFF", pid=None)
            else:
                state = "STOPPED" if event.asked else "EXITED"
                row.update(state=state, pid=None, uptime_s=None, cpu_percent=None)

    def _take_processes(self, item: dict[str, Any]) -> None:
        if "dropped" in item:
            return
        wall = time.time()
        self._heard_s = time.monotonic()
        elapsed = max(wall - self._walls[-1], 0.1) if self._walls else 1.0
        for row in item["processes"]:
            name = row["name"]
            count = self.log.lines[name]
            row["lines_per_s"] = (count - self._counted.get(name, count)) / elapsed
            self._counted[name] = count
            row["last_error"] = self.log.errors.get(name)
        self.rows = item["processes"]
        self._keep_samples(wall)
        self._hub.send(self._processes(wall))
        self._read_expectations()

    def _keep_samples(self, wall: float) -> None:
        self._walls.append(wall)
        for row in self.rows:
            samples = self._samples.get(row["name"])
            if samples is None:
                missing = [(None, None, None)] * (len(self._walls) - 1)
                samples = deque(missing, maxlen=KEEP_SAMPLES)
                self._samples[row["name"]] = samples
            samples.append((row["cpu_percent"], row["uss_bytes"], row["lines_per_s"]))
        gone = self._samples.keys() - {row["name"] for row in self.rows}
        for name in gone:
            del self._samples[name]

    def _read_expectations(self) -> None:
        """What smoke expects of this run, if it has started it."""
        folder = self.run.get("log_dir")
        if folder is None:
            return
        path = Path(folder, _EXPECTATIONS)
        try:
            changed = path.stat().st_mtime_ns
            if changed == self._expectations_read:
                return
            items = strict_json.loads(path.read_text(encoding="utf-8"))["items"]
        except (OSError, ValueError, KeyError, TypeError):
            return  # of most runs there are none
        self._expectations_read = changed
        self.expectations = {"event": "expectations", "items": items}
        self._hub.send(self.expectations)

    def _plan_soon(self) -> None:
        self._is_plan_old = True
        if self._planning is None or self._planning.done():
            self._planning = self._hub.start(self._read_plan())

    async def _read_plan(self) -> None:
        while self._is_plan_old:
            await asyncio.sleep(_PLAN_DELAY_S)  # several processes start together
            self._is_plan_old = False
            answer = await self._requests.ask("plan")
            if answer.get("ok"):
                plan = dict(answer["result"])
                self.plan = {"event": "plan", **plan, "processes": numbered(plan["processes"])}
                self._send_plan()

    def _send_plan(self) -> None:
        if self.plan is not None:
            self.plan["tree"] = named(self._tree, self.plan["processes"])
            self._hub.send(self.plan)

    def want_tree(self) -> None:
        """Read the tree, unless that was done: for it the launch file is evaluated once more."""
        if self._reading_tree is None:
            self._reading_tree = self._hub.start(self._read_tree())

    async def _read_tree(self) -> None:
        self._tree = await read_tree(str(self.run["target"]), self.run["arguments"])
        self._send_plan()

    def _has_ended(self) -> None:
        self._open -= 1
        for client in (self._requests, self._lines):
            if client.failure is not None:
                self._hub.fail(client.failure)
        if not self._is_closing and not self._open:
            self.end("ended" if self._requests.said_goodbye else "lost")

    def end(self, how: str) -> None:
        """Report to the pages once that the run has ended, or (`lost`) was killed."""
        if self.ended is not None:
            return
        text = "The run has ended." if how == "ended" else "The launcher was killed."
        self.ended = {"event": "ended", "wall": time.time(), "how": how, "text": text}
        with contextlib.suppress(RuntimeError):
            self.flush()
            self._hub.send(self._processes(time.time()))
            self._hub.send(self.ended)
        self._on_end()

    # ---- what a page gets when it opens

    def opening(self, after: int | None) -> list[Message]:
        """Everything so far; `after`: the number of the last line that the page has."""
        first, lines = self.log.after(after or 0, _FIRST_LINES)
        last = self._walls[-1] if self._walls else time.time()
        messages: list[Message] = [
            self._processes(last),  # the first picture
            self._history(),
            {"event": "run_events", "items": list(self.events), "reset": True},
            {"event": "lines", "first": first, "lines": lines},
        ]
        messages += [one for one in (self.plan, self.expectations) if one is not None]
        messages += self.faults.opening()
        if self.ended is not None:
            messages.append(self.ended)
        return messages

    def _processes(self, wall: float) -> Message:
        return {"event": "processes", "wall": wall, "processes": self.rows}

    def _history(self) -> Message:
        processes = {
            name: {key: [one[i] for one in samples] for i, key in enumerate(_SAMPLED)}
            for name, samples in self._samples.items()
            if samples
        }
        return {"event": "history", "wall": list(self._walls), "processes": processes}
