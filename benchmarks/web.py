"""The page in the browser: what it costs, and how fast it is."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from statistics import median

from benchmarks.footprint import cpu_s
from benchmarks.harness import NotHereError, Row, interleaved, ratio, scratch
from benchmarks.ros.verbs import ros_domain
from tests.support.browser import browser, chromium, page_at
from tests.support.children import children_with
from tests.support.waiting import wait_until
from tests.support.web_page import PageClient

PROCESSES, TOPICS, TALKERS = 100, 200, 4
SETTLED_S, MEASURED_S = 15.0, 20.0
FLOOD_LINES, FLOOD_PER_S = 500_000, 50_000
TABS, TABS_S = 10, 60.0
FIRST_S, FIRST_RATIO, SERVER_CORE, LAUNCHER_CORE = 0.6, 2.3, 0.10, 0.01
ANSWER_MS, SLOWED = 200.0, 1.03

_LINK = re.compile(r"page: (http\S+)")

TALKER = """
import sys, rclpy
from std_msgs.msg import String
first, count = int(sys.argv[1]), int(sys.argv[2])
rclpy.init()
node = rclpy.create_node(f"talker_{first}")
outs = [node.create_publisher(String, f"/topic_{i}", 10) for i in range(first, first + count)]
node.create_timer(1.0, lambda: [out.publish(String(data="x" * 50)) for out in outs])
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""
HUNDRED = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess
def generate_launch_description():
    sleepers = [ExecuteProcess(cmd=["sleep", "600"], name=f"s_{{i}}") for i in range({sleepers})]
    talkers = [
        ExecuteProcess(cmd=[sys.executable, {program!r}, str(i), "{each}"], name=f"t_{{i}}")
        for i in range(0, {topics}, {each})
    ]
    return LaunchDescription([*talkers, *sleepers])
"""
WRITER = """
import os, sys, time
lines, per_s = {lines}, {per_s}
line = b"[INFO] [1700000000.123456789] [flood]: line %d of a flood, as a node writes it\\n"
start, done = time.monotonic(), 0
while done < lines:
    due = min(lines, int((time.monotonic() - start) * per_s))
    if due > done:
        os.write(1, b"".join([line % i for i in range(done, due)]))
        done = due
    else:
        time.sleep(0.001)
open({out!r}, "w").write(str(time.monotonic() - start))
time.sleep({stays})
"""
FLOOD = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess
def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, {program!r}], name="flood", output="screen"),
        ExecuteProcess(cmd=["sleep", "600"], name="quiet"),
    ])
"""


@contextlib.contextmanager
def web_run(target: str, *words: str) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    """A run, with the file of its screen."""
    with scratch() as folder:
        screen = folder / "screen"
        with open(screen, "wb") as out:
            run = subprocess.Popen(
                [sys.executable, "-m", "launcher", target, "--no-console", *words],
                stdout=out,
                stderr=subprocess.STDOUT,
            )
        try:
            yield run, screen
        finally:
            run.send_signal(signal.SIGINT)
            run.wait()


def link_of(screen: Path) -> str:
    wait_until(lambda: _LINK.search(screen.read_text(errors="replace")), "the link")
    found = _LINK.search(screen.read_text(errors="replace"))
    assert found is not None
    return found[1]


def needs_browser() -> None:
    try:
        browser()
    except AssertionError as error:
        raise NotHereError(str(error)) from None


def first(runs: int) -> list[Row]:
    """From the link to the first picture with data, in a browser without a cache.

    A page with one word, of the simplest server there is, shows what of that is the browser's.
    """
    needs_browser()
    run = web_run("system", "--web", "--web-port", "0")
    with ros_domain(), _one_word() as empty, run as (_, screen):
        link = link_of(screen)
        kinds = {"ours": lambda: _first(link), "empty": lambda: _first(empty)}
        found = interleaved(runs, kinds)
    ours, empty_s = found["ours"], median(found["empty"])
    detail = f"{min(ours):.2f} to {max(ours):.2f} s; Chromium runs already, without a cache"
    what = "page, from the link to the first data"
    return [
        Row(what, median(ours), "s", FIRST_S, detail),
        Row(
            f"{what}, against a page with one word",
            ratio(ours, found["empty"]),
            "x",
            FIRST_RATIO,
            f"that takes {empty_s:.2f} s",
        ),
    ]


def _first(link: str) -> float:
    with chromium() as started:
        began = time.monotonic()
        with page_at(started, link) as page:
            page.wait_for_selector("[data-process]")
            return time.monotonic() - began


class _OneWord(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        body = b"<!doctype html><link rel=icon href='data:,'><p data-process>empty"
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *words: object) -> None:
        pass


@contextlib.contextmanager
def _one_word() -> Iterator[str]:
    """The address of such a page."""
    with ThreadingHTTPServer(("127.0.0.1", 0), _OneWord) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def hundred(runs: int) -> list[Row]:
    """CPU of the server with its probe and of the launcher: 100 processes, 200 topics at 1 Hz."""
    kinds = {"with": lambda: _hundred(page=True), "without": lambda: _hundred(page=False)}
    with ros_domain():
        found = interleaved(min(runs, 2), kinds)
    server = median([one["server"] + one["probe"] for one in found["with"]])
    parts = ", ".join(
        f"{name} {median([one[name] for one in found['with']]):.1%}" for name in ("server", "probe")
    )
    with_s = median([one["launcher"] for one in found["with"]])
    without_s = median([one["launcher"] for one in found["without"]])
    what = f"page of {PROCESSES} processes, {TOPICS} topics at 1 Hz"
    return [
        Row(f"{what}: its server", server, "cores", SERVER_CORE, parts),
        Row(
            f"{what}: the launcher's extra CPU",
            with_s - without_s,
            "cores",
            LAUNCHER_CORE,
            f"{with_s:.2%}, without {without_s:.2%}",
        ),
    ]


def _hundred(*, page: bool) -> dict[str, float]:
    """CPU time of each process for a second."""
    with scratch() as folder, contextlib.ExitStack() as stack:
        program, file = folder / "talker.py", folder / "hundred.launch.py"
        program.write_text(TALKER)
        each = TOPICS // TALKERS
        counts = {"each": each, "topics": TOPICS, "sleepers": PROCESSES - TALKERS}
        text = HUNDRED.format(program=str(program), **counts)
        file.write_text(text)
        words = ["--web", "--web-port", "0"] if page else []
        run, screen = stack.enter_context(web_run(str(file), *words))
        pids = {"launcher": run.pid}
        if page:
            client = stack.enter_context(PageClient(link_of(screen)))
            client.open()
            client.ask("topics", on=True)
            pids["server"] = children_with(run.pid, "launcher.web.web_server")[0].pid
            wait_until(lambda: children_with(pids["server"], "launcher.ros.probe"), "the probe")
            pids["probe"] = children_with(pids["server"], "launcher.ros.probe")[0].pid
            wait_until(lambda: _measured(client) >= TOPICS, f"{TOPICS} topics with a rate")
        time.sleep(SETTLED_S)
        before = {name: cpu_s(pid) for name, pid in pids.items()}
        time.sleep(MEASURED_S)
        return {name: (cpu_s(pid) - before[name]) / MEASURED_S for name, pid in pids.items()}


def _measured(client: PageClient) -> int:
    """How many topics have a rate."""
    latest = client.of("topics")
    return sum(bool(one["rate_hz"]) for one in latest[-1]["topics"].values()) if latest else 0


def flood(runs: int) -> list[Row]:
    """A flood of lines, with the log open in a browser: how long it takes, answers to input."""
    needs_browser()
    answers: list[float] = []
    kinds = {"with": lambda: _flood(answers), "without": lambda: _flood(None)}
    with ros_domain():
        found = interleaved(min(runs, 3), kinds)
    slowed = ratio(found["with"], found["without"])
    detail = f"{median(found['with']):.2f} s, without {median(found['without']):.2f} s"
    what = f"page in a flood of {FLOOD_PER_S} lines/s"
    worst = f"median {median(answers):.0f} ms of {len(answers)} inputs, the slowest is shown"
    return [
        Row(f"{what}: the time of the run", slowed, "x", SLOWED, detail),
        Row(f"{what}: an input is answered", max(answers), "ms", ANSWER_MS, worst),
    ]


def _flood(answers: list[float] | None) -> float:
    """Seconds that the writer took; `answers` gets those to inputs in the page, in ms."""
    with scratch() as folder, contextlib.ExitStack() as stack:
        program, file, out = folder / "writer.py", folder / "flood.launch.py", folder / "took"
        text = WRITER.format(lines=FLOOD_LINES, per_s=FLOOD_PER_S, out=str(out), stays=60)
        program.write_text(text)
        file.write_text(FLOOD.format(program=str(program)))
        if answers is None:
            stack.enter_context(web_run(str(file)))
        else:
            started = stack.enter_context(chromium())
            _, screen = stack.enter_context(web_run(str(file), "--web", "--web-port", "0"))
            page = stack.enter_context(page_at(started, f"{link_of(screen)}#/log"))
            page.wait_for_selector("[data-line]")
            while not out.is_file():
                # Measured in the page: from the key to the frame after its effect.
                answers.append(page.evaluate(_KEY))
                time.sleep(0.25)
        wait_until(out.is_file, "the end of the flood")
        return float(out.read_text())


_KEY = """() => new Promise((resolve) => {
  const input = document.querySelector("[data-search] input, input[data-search]");
  const began = performance.now();
  input.focus();
  input.value = input.value ? "" : "line";
  input.dispatchEvent(new Event("input", { bubbles: true }));
  requestAnimationFrame(() => requestAnimationFrame(() => resolve(performance.now() - began)));
})"""


def tabs(runs: int) -> list[Row]:
    """Ten open pages for a minute: memory of the server after it against before."""
    seconds = float(os.environ.get("WEB_TABS_S", TABS_S))  # an hour shows slow leaks
    with ros_domain(), contextlib.ExitStack() as stack:
        run, screen = stack.enter_context(web_run("system", "--web", "--web-port", "0"))
        link = link_of(screen)
        (server,) = children_with(run.pid, "launcher.web.web_server")
        clients = [stack.enter_context(PageClient(link)) for _ in range(TABS)]
        for client in clients:
            client.open()
            client.ask("topics", on=True)
            client.ask("echo", topic="/fleet/status", on=True)
        time.sleep(SETTLED_S)
        before, cpu = server.memory_full_info().uss, cpu_s(server.pid)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            time.sleep(1.0)
            for client in clients:
                client.events.clear()
        grown = (server.memory_full_info().uss - before) / 1e6
        used = (cpu_s(server.pid) - cpu) / seconds
    detail = f"{before / 1e6:.0f} MB before, {used:.1%} of a core, {seconds:.0f} s"
    return [Row(f"{TABS} pages: the server's memory grows by", grown, "MB", 5.0, detail)]
