"""The timeline of the page shows every event of a run, and entries of other versions."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from launcher.base.model.event_entries import entry_of
from launcher.base.model.run_event import TYPES
from launcher.base.model.run_events import Resources
from launcher.web.frozen import FrozenRun, freeze
from tests.support.browser import page_at
from tests.support.run_events import T0, entry, event, line, odd_items, variants

pytestmark = pytest.mark.browser

RUN = {"id": "r", "pid": None, "target": "/w/x.launch.py", "arguments": [], "started_wall_s": T0,
       "log_dir": None, "domain_id": None}  # fmt: skip
HELLO = {"event": "hello", "server": "s", "read_only": True, "run": RUN,
         "frozen": {"made": T0 + 9, "report": None},
         "graph": {"available": True, "reason": ""}}  # fmt: skip


def report(items: list[dict[str, Any]], folder: Path) -> str:
    """The address of a file of the page with these entries."""
    messages = [
        HELLO,
        {"event": "processes", "wall": T0 + 99, "processes": []},
        {"event": "run_events", "reset": True, "items": items},
    ]
    file = folder / "report.html"
    file.write_text(freeze([FrozenRun(label="x", messages=messages)], title="x"), encoding="utf-8")
    return f"{file.as_uri()}#/timeline"


def shown(item: Any) -> dict[str, Any]:
    """As the server sends an entry."""
    found = entry_of(item)
    assert found is not None
    return {**item, "text": found.event.text}


@pytest.mark.parametrize("kind", [kind for kind in TYPES if kind != Resources.event])
def test_every_event_has_a_mark_and_its_words(started: Browser, tmp_path: Path, kind: str):
    entries = [entry(one, n, host=None) for n, one in enumerate(variants(TYPES[kind]))]
    items = [shown(json.loads(line(one))) for one in entries]
    size = {"width": 1280, "height": 1600}
    with page_at(started, report(items, tmp_path), viewport=size) as page:
        rows = page.locator(".event")
        expect(rows).to_have_count(len(items))
        for number, item in enumerate(items):
            row = rows.nth(number)
            text = item["text"].replace("\udcff", "\ufffd")  # what is no character is replaced
            assert row.locator(".event-text").text_content() == text
            assert "undefined" not in (row.text_content() or "")
            path = row.locator("svg path").get_attribute("d") or ""
            assert path.startswith("M") and "undefined" not in path


def test_an_entry_of_another_version_is_an_event_like_others(started: Browser, tmp_path: Path):
    odd = [shown(one) for one in odd_items() if entry_of(one) is not None]
    odd = [one for one in odd if one["event"] != Resources.event]
    items = [*odd, {"event": "other", "wall_s": T0 + 5, "text": "3 were lost"}]
    items.append(shown(entry(event("finished", exit_code=0), 6.0).item))
    with page_at(started, report(items, tmp_path)) as page:
        expect(page.locator("[data-count]")).to_have_text(f"{len(items)} events")
        for text in ("3 were lost", "the run has ended with exit code 0"):
            expect(page.locator(".event-text", has_text=text)).to_be_visible()
