"""The page of a large run, and of one that has gone on for a day."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from playwright.sync_api import CDPSession, Page

from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, scratch
from benchmarks.ros.verbs import ros_domain
from benchmarks.web import HUNDRED, TALKER, link_of, needs_browser, web_run
from tests.support.browser import chromium, page_at
from tests.support.children import children_with
from tests.support.waiting import wait_until

PROCESSES, TOPICS = 300, 500
SETTLED_S, MEASURED_S = 10.0, 10.0
FIRST_S, SERVER_CORE, LAUNCHER_CORE, BROWSER_CORE = 1.0, 0.10, 0.01, 0.12
FRAME_MS, ELEMENTS, BYTES_PER_S = 50.0, 10_000, 600.0
DAY_S, QUARTER_S = 86_400, 21_600
GROWN = 1.1


# ---- many processes and topics


def many(runs: int) -> list[Row]:
    """300 processes, 500 topics at 1 Hz: server, launcher, browser; `runs` is not used."""
    needs_browser()
    with ros_domain():
        without = _launcher_alone()
        found = _with_page()
    what = f"page of {PROCESSES} processes, {TOPICS} topics"
    processes, topics = found.panels
    return [
        Row(f"{what}: link to the first data", found.first_s, "s", FIRST_S, ""),
        Row(f"{what}: its server", topics.cores["server"], "cores", SERVER_CORE, topics.detail),
        Row(
            f"{what}: the launcher's extra CPU",
            processes.cores["launcher"] - without,
            "cores",
            LAUNCHER_CORE,
            f"without {without:.2%}",
        ),
        *(
            row
            for panel in found.panels
            for row in (
                Row(f"{what}: browser, {panel.name}", panel.busy, "cores", BROWSER_CORE, ""),
                Row(f"{what}: a second's longest frame", panel.frame_ms, "ms", FRAME_MS, ""),
                Row(f"{what}: its elements", panel.elements, "", ELEMENTS, ""),
                Row(f"{what}: messages", panel.bytes_per_s / 1e3, "kB/s", BYTES_PER_S, ""),
            )
        ),
    ]


class _Panel(NamedTuple):
    """What a panel costs while nobody touches it."""

    name: str
    cores: dict[str, float]  # server, probe, launcher
    busy: float  # share of the time in which the page's main thread works
    frame_ms: float
    elements: float
    bytes_per_s: float

    @property
    def detail(self) -> str:
        return ", ".join(f"{name} {used:.1%}" for name, used in self.cores.items())


class _Large(NamedTuple):
    first_s: float
    panels: list[_Panel]


@contextlib.contextmanager
def _large_run(*words: str) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    with scratch() as folder:
        program, file = folder / "talker.py", folder / "many.launch.py"
        program.write_text(TALKER)
        counts = {"each": TOPICS, "topics": TOPICS, "sleepers": PROCESSES - 1}
        file.write_text(HUNDRED.format(program=str(program), **counts))
        with web_run(str(file), *words) as found:
            yield found


def _launcher_alone() -> float:
    with _large_run() as (run, _):
        time.sleep(SETTLED_S)
        before = cpu_s(run.pid)
        time.sleep(MEASURED_S)
        return (cpu_s(run.pid) - before) / MEASURED_S


def _with_page() -> _Large:
    with (
        _large_run("--web", "--web-port", "0") as (run, screen),
        chromium() as started,
        page_at(started, "about:blank") as page,
    ):
        link = link_of(screen)
        time.sleep(SETTLED_S)
        began = time.monotonic()
        page.goto(link)
        page.wait_for_selector("[data-process]")
        first_s = time.monotonic() - began
        (server,) = children_with(run.pid, "launcher.web.web_server")
        wait_until(lambda: children_with(server.pid, "launcher.ros.probe"), "the probe")
        (probe,) = children_with(server.pid, "launcher.ros.probe")
        pids = {"server": server.pid, "probe": probe.pid, "launcher": run.pid}
        processes = _measured("processes", page, pids)
        page.keyboard.press("4")
        page.wait_for_selector("tr[data-topic]")
        return _Large(first_s, [processes, _measured("topics", page, pids)])


_FRAMES = """(ms) => new Promise((resolve) => {
  let last = performance.now();
  const [end, found] = [last + ms, []];
  const frame = () => {
    const now = performance.now();
    found.push(now - last);
    last = now;
    if (now < end) requestAnimationFrame(frame);
    else resolve(found.sort((a, b) => b - a)[Math.floor(ms / 1000)]);
  };
  requestAnimationFrame(frame);
})"""


def _measured(name: str, page: Page, pids: dict[str, int]) -> _Panel:
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable")
    devtools.send("Network.enable")
    sizes: list[int] = []
    devtools.on(
        "Network.webSocketFrameReceived",
        lambda event: sizes.append(len(event["response"]["payloadData"])),
    )
    page.wait_for_timeout(SETTLED_S * 1000)
    sizes.clear()
    used = {one: cpu_s(pid) for one, pid in pids.items()}
    before, began = _metrics(devtools), time.monotonic()
    frame_ms = page.evaluate(_FRAMES, MEASURED_S * 1000)
    took_s, after = time.monotonic() - began, _metrics(devtools)
    devtools.detach()
    return _Panel(
        name,
        {one: (cpu_s(pid) - used[one]) / took_s for one, pid in pids.items()},
        (after["TaskDuration"] - before["TaskDuration"]) / took_s,
        frame_ms,
        after["Nodes"],
        sum(sizes) / took_s,
    )


def _metrics(devtools: CDPSession) -> dict[str, float]:
    found = devtools.send("Performance.getMetrics")["metrics"]
    return {one["name"]: one["value"] for one in found}


# ---- a day


def day(runs: int) -> list[Row]:
    """Memory of page and server after a day against a quarter of it, by a fast clock."""
    needs_browser()
    page, page_detail = _day_of_page()
    server, server_detail = _day_of_server()
    what = "memory after a day against its first quarter"
    return [
        Row(f"page, {what}", page, "x", GROWN, page_detail),
        Row(f"server of the page, {what}", server, "x", GROWN, server_detail),
    ]


_HELLO: dict[str, Any] = {
    "event": "hello",
    "server": "1",
    "launcher": "1",
    "ros": "",
    "wall": 0.0,
    "read_only": False,
    "frozen": {"made": 0.0, "report": None},
    "ended": None,
    "graph": {"available": True, "reason": None},
    "run": {"id": "1", "target": "day.launch.py"},
}

# Ten processes that restart, ten lines and a plotted message of five numbers a second, twenty
# topics, and a graph with a new node every five minutes, when it is drawn; another panel each
# quarter of an hour.
_PAGE_DAY = """async ([from, to]) => {
  const store = await import("page/store.js");
  const range = (count) => Array.from({ length: count }, (_, index) => index);
  const panels = ["processes", "log", "graph", "topics", "timeline", "plan"];
  const names = range(10).map((i) => `p-${i}`);
  const topics = range(20).map((i) => `/t_${i}`);
  const row = (name, s) => ({
    name, state: "RUNNING", pid: s, host: null, uptime_s: s % 80, restarts: s, lines_per_s: 1,
    cpu_percent: Math.random() * 100, uss_bytes: 1e7 + s, rss_bytes: 1e7, last_error: null,
    last_exit: null, node_names: [],
  });
  const graph = (s) => ({
    event: "graph", complete: true, services: [], mismatches: [], positions: null,
    nodes: [{ name: `/n_${s}`, hidden: false, ghost: false, pid: 1, count: 1, state: "running",
              process: "p-0", since: null }],
    topics: topics.map((name) => ({ name, types: ["std_msgs/msg/String"], publishers: 1,
                                    subscriptions: 0 })),
    endpoints: topics.map((topic) => ({ topic, node: `/n_${s}`, direction: "publisher",
                                        ghost: false, qos: {} })),
  });
  for (let s = from; s < to; s++) {
    store.apply({ event: "processes", wall: s, processes: names.map((name) => row(name, s)) });
    const lines = names.map((name) => [name, "stdout", s, "INFO", `line of ${name} at ${s}`]);
    store.apply({ event: "lines", first: s * 10 + 1, lines });
    if (s % 8 === 0) {
      const one = { wall_s: s, monotonic_s: s, process: "p-1", text: "" };
      const items = [{ ...one, event: "ended", pid: s, returncode: 1, asked: false,
                       restart_in_s: 1 }, { ...one, event: "started", pid: s, restarts: s }];
      store.apply({ event: "run_events", items, reset: false });
    }
    store.apply({ event: "topics", topics: Object.fromEntries(topics.map((name) => [
      name, { rate_hz: 1, bytes_per_s: s, age_s: 0, count: s, state: "ok" }])) });
    store.apply({ event: "message", topic: "/t_1", wall: s, data: { data: s }, skipped: 0 });
    if (s % 10 === 0) {
      const points = range(50).map((i) => [s + i / 5, Math.random()]);
      store.apply({ event: "points", topic: "/t_1", field: "data", points, reset: false });
    }
    store.apply({ event: "alive", silent_s: 0 });
    if (s % 300) continue;
    store.apply(graph(s));
    if (s % 900 === 0) location.hash = `#/${panels[(s / 900) % panels.length]}`;
    await new Promise((resolve) => setTimeout(resolve, 30)); // Vue draws, and the browser
    void document.body.offsetHeight;
  }
}"""


def _day_of_page() -> tuple[float, str]:
    from launcher.web.frozen import FrozenRun, freeze

    with scratch() as folder, chromium() as started:
        file = folder / "day.html"
        file.write_text(freeze([FrozenRun(label="day", messages=[_HELLO])], title="day"))
        with page_at(started, file.as_uri()) as page:
            page.set_default_timeout(0)
            page.locator("[data-panel]").first.wait_for()
            sizes = []
            for begin, end in ((0, QUARTER_S), (QUARTER_S, DAY_S)):
                page.evaluate(_PAGE_DAY, [begin, end])
                page.evaluate("location.hash = '#/processes'")
                page.locator("[data-process]").first.wait_for()  # a handle would keep it
                sizes.append(_memory(page))
    heap, elements, listeners = zip(*sizes, strict=True)
    detail = (
        f"{heap[1] / 1e6:.0f} MB, was {heap[0] / 1e6:.0f}; elements {elements[1]:.0f}, "
        f"was {elements[0]:.0f}; listeners {listeners[1]:.0f}, was {listeners[0]:.0f}"
    )
    return max(heap[1] / heap[0], elements[1] / elements[0], listeners[1] / listeners[0]), detail


def _memory(page: Page) -> tuple[float, float, float]:
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable")
    for _ in range(3):  # what the first collection frees holds what the next one does
        devtools.send("HeapProfiler.collectGarbage")
    found = _metrics(devtools)
    devtools.detach()
    return found["JSHeapUsedSize"], found["Nodes"], found["JSEventListeners"]


# The feeds of the server with a clock that they share, and a page that reads.
_SERVER_DAY = """
import asyncio, json, sys, time, types
import psutil
from launcher.web import graph_feed, run_feed
from launcher.web.hub import Hub, PageOutbox

now = 1.7e9
clock = types.SimpleNamespace(time=lambda: now, monotonic=lambda: now)
graph_feed.time = run_feed.time = clock

def graph(s):
    node = {"name": f"/n_{s}", "hidden": False, "ghost": False, "pid": 1, "count": 1}
    topics = [{"name": f"/n_{s}/t", "types": ["a/msg/B"], "publishers": 1, "subscriptions": 0}]
    ends = [{"topic": f"/n_{s}/t", "node": node["name"], "direction": "publisher", "ghost": False}]
    return {"event": "graph", "complete": True, "nodes": [node], "topics": topics,
            "services": [], "endpoints": ends, "mismatches": []}

def row(name, s):
    return {"name": name, "state": "RUNNING", "pid": s, "cpu_percent": s % 100 + 0.5,
            "uss_bytes": 10_000_000 + s, "restarts": s, "node_names": [], "last_exit": None}

async def second(run, graphs, s):
    global now
    now += 1.0
    for name in NAMES:
        text = f"[INFO] [{now}] [{name}]: line at {s}"
        run._take_line({"process": name, "stream": "stdout", "wall_s": now, "text": text})
    run._take_processes({"processes": [row(name, s) for name in NAMES]})
    if s % 8 == 0:
        one = {"wall_s": now, "monotonic_s": now, "process": "p-1"}
        run._take_event({**one, "event": "ended", "pid": s, "returncode": 1, "asked": False,
                         "restart_in_s": 1.0})
        run._take_event({**one, "event": "started", "pid": s, "restarts": s})
    if s % 60 == 0:
        graphs._take(graph(s))
        run.flush()
        await asyncio.sleep(0)

async def main(quarter, day):
    hub = Hub(lambda: None)
    run = run_feed.RunFeed(hub, lambda: None)
    run._requests.hello = {"run": {"log_dir": None}}
    run._plan_soon = lambda: None
    graphs = graph_feed.GraphFeed(hub, lambda: run.rows)
    graphs._has_graphviz = True
    graphs._arranging = asyncio.create_task(asyncio.sleep(1e9))  # Graphviz is no part of this
    reading = PageOutbox()
    hub.join(reading)
    async def read():
        while True:
            await reading.get()
    reader = asyncio.create_task(read())
    for s in range(1, day + 1):
        await second(run, graphs, s)
        if s in (quarter, day):
            await asyncio.sleep(0.2)
            print(psutil.Process().memory_full_info().uss, flush=True)

NAMES = [f"p-{i}" for i in range(10)]
asyncio.run(main(int(sys.argv[1]), int(sys.argv[2])))
"""


def _day_of_server() -> tuple[float, str]:
    words = [sys.executable, "-c", _SERVER_DAY, str(QUARTER_S), str(DAY_S)]
    output = subprocess.run(words, capture_output=True, text=True, check=True, env=os.environ)
    before, after = (int(line) for line in output.stdout.split())
    return after / before, f"{after / 1e6:.0f} MB, was {before / 1e6:.0f}"
