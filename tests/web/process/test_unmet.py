"""The report of a failed run: what was not met comes first."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from launcher.web.frozen import FrozenRun, freeze
from tests.web.process.test_fleet_page import show

pytestmark = pytest.mark.browser

AT = 1_700_000_000.0
RUN = {
    "id": "r",
    "pid": None,
    "target": "/w/two.launch.py",
    "arguments": ["a:=1", "b:=2"],
    "started_wall_s": AT,
    "log_dir": None,
    "domain_id": None,
}
FROZEN = {
    "event": "hello",
    "server": "s",
    "read_only": True,
    "run": RUN,
    "frozen": {"made": AT + 9, "report": {"exit_code": 1}},
    "graph": {"available": True, "reason": ""},
}
ITEMS = [
    {"title": "heard", "state": "passed", "wall": AT + 1, "detail": ""},
    {"title": "<b>never</b>", "state": "failed", "wall": AT + 3, "detail": "expected: x"},
]
TOPIC = {"name": "/big", "types": ["std_msgs/msg/String"], "publishers": 1, "subscriptions": 0}
SILENT = {**TOPIC, "name": "/silent"}
GRAPH = {
    "event": "graph",
    "wall": AT,
    "nodes": [],
    "topics": [TOPIC, SILENT],
    "endpoints": [],
    "services": [],
    "actions": [],
    "mismatches": [],
}
LARGE = {
    "event": "message",
    "topic": "/big",
    "wall": AT + 1,
    "sent": None,
    "skipped": 0,
    "type": "std_msgs/msg/String",
    "data": None,
    "bytes": 10_000_000,
}


@pytest.fixture
def report(started: Browser, tmp_path: Path) -> Iterator[Page]:
    messages = [
        FROZEN,
        {"event": "processes", "wall": AT + 5, "processes": []},
        {"event": "expectations", "items": ITEMS},
        GRAPH,
        LARGE,
    ]
    path = tmp_path / "report.html"
    path.write_text(freeze([FrozenRun(label="r", messages=messages)], title="two: failed"))
    page = started.new_page()
    page.goto(path.as_uri())
    yield page
    page.close()


def test_what_was_not_met_comes_first(report: Page):
    unmet = report.locator("[data-unmet]")
    expect(unmet).to_contain_text("1 of 2 expectations was not met")
    expect(unmet.locator("li")).to_have_count(1)
    expect(unmet.locator("li")).to_contain_text("<b>never</b>")
    unmet.locator('[data-action="unmet-to-timeline"]').click()
    expect(report.locator("[data-moment]")).to_be_visible()
    for words in ("expectation not met", "expectation failed"):
        report.get_by_label("Filter the events").fill(words)
        expect(report.locator('.event[data-event="expectation"]')).to_have_count(1)


def test_a_message_without_data_says_why(report: Page):
    show(report, "topics")
    report.locator('tr[data-topic="/big"]').click()
    expect(report.locator('[data-field="fault"]')).to_have_text("10 MB, too large to show")
    report.keyboard.press("1")
    report.keyboard.press("4")
    expect(report.locator('[data-field="fault"]')).to_be_visible()
    report.locator('tr[data-topic="/silent"]').click()
    expect(report.locator(".echo")).to_contain_text("No message was kept.")
