"""Texts full of markup and escapes wherever a node may put them: nothing becomes markup.

The messages are replayed by a file of the page, so that texts can be tried that DDS or the launcher
would refuse as names.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from launcher.web.assets import PAGE
from launcher.web.frozen import FrozenRun, freeze
from tests.support.browser import page_at
from tests.support.watcher_stand_in import fault

pytestmark = pytest.mark.browser

SEEDS = range(4)
_ROW = re.compile(r'^  \["(\w+)", "', re.MULTILINE)
PANELS = _ROW.findall((PAGE / "app.js").read_text(encoding="utf-8"))
PIECES = (
    "<img src=x onerror=alert(1)>",
    "<script>alert(2)</script>",
    "</script></textarea></title><svg onload=alert(3)>",
    "<iframe srcdoc='<script>parent.alert(4)</script>'></iframe>",
    "{{constructor.constructor('alert(5)')()}}",
    "${alert(6)}",
    "javascript:alert(7)",
    '" onmouseover="alert(8)" x="',
    "' autofocus onfocus=alert(9) '",
    "&lt;b&gt;&#60;i&#62;",
    "\x1b[31;1mred\x1b[0m\x1b[999m\x1b]0;title\x07",
    "\x1b[38;2;1;2;999999999m",
    "\u202edesrever\u2066",
    "\u2028\u2029\ufeff\u0000\u0008",
    "\ud800",
    "a" * 250,
    "{a|b}{c|{d}}%s%n",
    "__proto__",
    "constructor",
    "é漢字🤖" * 5,
)


def messages(text: Callable[[], str]) -> list[dict[str, Any]]:
    """The messages of a run in which `text` makes every text."""
    wall = 1795810000.0
    names = [text() for _ in range(6)]
    topics = [f"/{text()}" for _ in range(4)]
    nodes = [f"/{text()}/{text()}" for _ in range(4)]
    row = {
        "label": text(), "state": "RUNNING", "pid": 7, "restarts": 1, "uptime_s": 5.0,
        "cpu_percent": 1.0, "uss_bytes": 10**7, "rss_bytes": 10**7, "threads": 1, "fds": 3,
        "namespace": text(), "muted": True, "hidden_by": text(), "muted_by_name": True,
        "hidden_lines": 3, "level": text(), "grep": text(), "paused": False, "debugger": text(),
        "start": text(), "not_responding_s": 3.0, "waiting_for": text(), "lacks": text(),
        "lines_per_s": 3.0, "host": text(), "unit": text(), "unreachable_s": 4.0, "ready": False,
    }  # fmt: off
    error = {"time": wall, "text": text(), "number": 3}
    endpoint = {
        "reliability": "RELIABLE", "durability": "TRANSIENT_LOCAL", "liveliness": text(),
        "deadline_ns": 1, "lease_ns": 1, "gid": "01.0f", "ghost": False,
    }  # fmt: off
    return [
        {
            "event": "hello", "protocol": 1, "server": "1", "launcher": text(), "wall": wall,
            "read_only": False, "ended": None, "graph": {"available": True, "reason": text()},
            "frozen": {"made": wall, "report": None},
            "run": {"id": "1-a", "pid": 1, "target": f"/{text()}", "arguments": [text()],
                    "started_wall_s": wall, "log_dir": text(), "domain_id": 0},
        },
        {"event": "history", "wall": [wall],
         "processes": {n: {"cpu": [1.0], "memory": [1.0], "lines": [None]} for n in names}},
        {"event": "processes", "wall": wall + 1,
         "processes": [{**row, "name": n, "node_names": [text()], "last_error": error,
                        "last_exit": text()} for n in names]},
        {"event": "run_events", "reset": True, "items": [
            {"event": kind, "wall_s": wall + i, "monotonic_s": 1.0, "process": name, "pid": 7,
             "verb": text(), "signal": text(), "reason": text(), "message": text(),
             "returncode": 1, "asked": False, "path": text(), "text": text(), "host": text()}
            for i, name in enumerate(names)
            for kind in ("started", "ended", "asked", "signal", "snapshot", "shutdown", text())]},
        {"event": "lines", "first": 1, "lines": [
            [names[i % 6], "stdout", wall + i, "ERROR" if i % 5 else "INFO", text()]
            for i in range(200)] + [[None, "skipped", None, None, text()]]},
        {"event": "graph", "complete": True, "positions": {
            "nodes": {n: [100.0 * i, 50.0] for i, n in enumerate(nodes)},
            "topics": {t: [100.0 * i, 150.0] for i, t in enumerate(topics)}},
         "nodes": [{"name": n, "hidden": False, "ghost": False, "pid": 7, "count": 1,
                    "state": "gone" if i == 3 else "running", "process": names[0], "since": wall}
                   for i, n in enumerate(nodes)],
         "topics": [{"name": t, "types": [text(), text()], "publishers": 1, "subscriptions": 1}
                    for t in topics],
         "services": [{"name": f"/{text()}", "types": [text()]}],
         "endpoints": [{**endpoint, "topic": t, "node": n, "direction": d, "type": text()}
                       for t, n, d in zip(topics * 2, nodes * 2,
                                          ["publisher"] * 4 + ["subscription"] * 4, strict=True)],
         "mismatches": [{"topic": topics[0], "publisher": nodes[0], "subscription": nodes[1],
                         "publishers": [nodes[0]], "policy": text(), "text": text(),
                         "policies": [text()], "offered": text(), "requested": text(),
                         "repair": text(), "reasons": [text()]}]},
        {"event": "topics", "wall": wall, "topics": {
            t: {"topic": t, "rate_hz": 1.0, "bytes_per_s": 3.0, "age_s": 1.0, "count": 4,
                "state": "failed" if i == 1 else "subscribed", "error": text()}
            for i, t in enumerate(topics)}},
        *({"event": "message", "topic": t, "wall": wall, "sent": wall, "skipped": 1,
           "type": text(), "data": {text(): text(), "data": f'{{"a": "{i}"}}', "x": [text(), 1]}}
          for i, t in enumerate(topics)),
        {"event": "plan", "declared": {text(): text()}, "error": {
            "type": text(), "message": text(), "stage": "run", "phase": text()},
         "arguments": [{"name": text(), "description": text(), "has_default": True,
                        "default": text(), "choices": [text()]}],
         "processes": [{"name": names[0], "label": text(), "package": text(), "executable": text(),
                        "node_name": text(), "namespace": text(), "cmd": [text()], "time": 0.0,
                        "phase": "run", "cause": None, "parameters": [], "remappings": []}],
         "loads": [], "lifecycle": [{"node": text(), "transition": text()}],
         "logs": [{"message": text(), "time": 0.0}], "shutdowns": [{"reason": text()}],
         "tree": [{"kind": kind, "text": text(), "detail": text(), "place": text(), "name": name,
                   "children": []} for kind, name in (("scope", None), ("process", names[1]))]},
        {"event": "expectations", "items": [
            {"title": text(), "state": state, "wall": wall, "detail": text()}
            for state in ("passed", "failed", "open")]},
        {"event": PANELS[-1], "gone": [], "reset": True, "items": [
            {**fault(text()), "expected": text(), "seen": text(), "unit": text(), "cause": text(),
             "rule": text(), "place": text(), "kind": text(), "lines": [text()], "nodes": [text()],
             "processes": [text()], "topics": [text()], "message": {text(): text()}, "state": state,
             "follows": text(), "acknowledged": {"wall_s": wall, "reason": text()},
             "muted": {"reason": text(), "until_s": wall}}
            for state in ("active", "suspected", "healed")]},
    ]  # fmt: off


@pytest.mark.parametrize("seed", SEEDS)
def test_no_text_becomes_markup(started: Browser, tmp_path: Path, seed: int):
    chance = random.Random(seed)

    def text() -> str:
        return "".join(chance.choice(PIECES) for _ in range(chance.randint(1, 3)))

    file = tmp_path / "report.html"
    run = FrozenRun(label=text(), messages=messages(text))
    file.write_text(freeze([run], title=text()), encoding="utf-8")

    with page_at(started, file.as_uri(), viewport={"width": 1280, "height": 800}) as page:
        for panel in PANELS:
            page.evaluate("(name) => { location.hash = `#/${name}`; }", panel)
            page.wait_for_selector(f'[data-shown="{panel}"]')
            expect(page.locator(".app-page > *").first).to_be_visible()
            press_what_can_be_pressed(page)
            assert page.evaluate(FOREIGN) == [], panel


# Elements and attributes that only a text could have made.
FOREIGN = """() => [...document.body.querySelectorAll("*")].filter((one) =>
  ["IMG", "IFRAME", "OBJECT", "EMBED", "TITLE"].includes(one.tagName) ||
  (one.tagName === "SCRIPT" && !one.id && !["importmap", "module", "text/plain"].includes(one.type)
    && !one.src.startsWith("blob:") && one.textContent.includes("alert")) ||
  [...one.attributes].some((attribute) =>
    attribute.name.startsWith("on") ||
    (["href", "src"].includes(attribute.name) && /^\\s*javascript:/i.test(attribute.value)))
).map((one) => one.outerHTML.slice(0, 200))"""


def press_what_can_be_pressed(page: Any) -> None:
    """Open rows and entries: details show more texts."""
    rows = ("tr[data-process]", "tr[data-topic]", "tr[data-fault]")
    for kind in (*rows, "[data-line]", ".graph-item"):
        entries = page.locator(kind)
        if entries.count():
            entries.first.click(position={"x": 60, "y": 8})
    page.mouse.move(500, 400)
