"""The page in a real Chromium: its token, the end of the run, a launcher that was killed."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from launcher.web.run_feed import KEEP_EVENTS
from tests.support.browser import page_at
from tests.support.web_page import server_of
from tests.web.process.conftest import Start

pytestmark = pytest.mark.browser


def test_without_the_token_there_is_no_page(started: Browser, start: Start, sleeper: Path):
    _, link = start(sleeper)
    with page_at(started, link.partition("?")[0], problems_allowed=True) as page:
        expect(page.locator("body")).to_contain_text("Open the link that the launcher has printed")
        assert page.locator("#app").count() == 0


def test_the_token_leaves_the_address(started: Browser, start: Start, sleeper: Path):
    _, link = start(sleeper)
    with page_at(started, link) as page:
        expect(page.locator(".app-link")).to_have_text("open")
        assert "token" not in page.url
        page.reload()
        expect(page.locator(".app-link")).to_have_text("open")


def test_the_end_of_the_run_is_told_and_its_last_state_stays(
    started: Browser, start: Start, sleeper: Path
):
    run, link = start(sleeper)
    with page_at(started, link) as page:
        page.wait_for_selector('body[data-loaded="all"]')
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
        expect(page.get_by_role("alert").first).to_contain_text("The run has ended.")
        expect(page.locator('[data-process="cat-1"]').first).to_be_visible()


def test_a_killed_launcher_is_told(started: Browser, start: Start, sleeper: Path):
    run, link = start(sleeper)
    with page_at(started, link) as page:
        page.wait_for_selector('body[data-loaded="all"]')
        run.process.send_signal(signal.SIGKILL)
        expect(page.get_by_role("alert").first).to_contain_text("The launcher was killed.")


def test_a_connection_that_was_lost_comes_back_and_misses_nothing(
    started: Browser, start: Start, sleeper: Path
):
    run, link = start(sleeper)
    server = server_of(run.process.pid)
    assert server is not None
    with page_at(started, f"{link}#/log", problems_allowed=True) as page:
        run.ask("send", "cat", text="before")
        expect(page.locator("[data-line]").filter(has_text="before")).to_have_count(1)
        os.kill(server, signal.SIGSTOP)  # as a laptop that sleeps: silence, and no end
        expect(page.get_by_role("alert").first).to_contain_text("lost", timeout=20_000)
        run.ask("send", "cat", text="meanwhile")
        os.kill(server, signal.SIGCONT)
        expect(page.locator(".app-link")).to_have_text("open", timeout=20_000)
        run.ask("send", "cat", text="after")
        for text in ("before", "meanwhile", "after"):
            expect(page.locator("[data-line]").filter(has_text=text)).to_have_count(1)


def test_a_server_that_was_killed_comes_back_to_an_open_page(
    started: Browser, start: Start, sleeper: Path
):
    run, link = start(sleeper)
    server = server_of(run.process.pid)
    assert server is not None
    with page_at(started, link, problems_allowed=True) as page:
        expect(page.locator('[data-process="cat-1"]').first).to_be_visible()
        os.kill(server, signal.SIGKILL)
        expect(page.locator(".app-link")).to_have_text("lost")
        expect(page.locator(".app-link")).to_have_text("open", timeout=20_000)
        run.ask("stop", "cat")
        row = page.locator('[data-process="cat-1"]').first
        expect(row).to_have_attribute("data-state", "STOPPED")


MANY_EVENTS = """
async () => {
  const store = await import("page/store.js");
  for (let number = 1; number <= 5000; number += 1) {
    const items = [{ event: "other", wall_s: number, text: "" }];
    store.apply({ event: "run_events", items, reset: false });
  }
  return [store.runEvents.value.length, store.runEvents.value.at(-1).wall_s];
}
"""


def test_a_page_that_stays_open_keeps_the_last_events(
    started: Browser, start: Start, sleeper: Path
):
    _, link = start(sleeper)
    with page_at(started, link) as page:
        page.wait_for_selector('body[data-loaded="all"]')
        assert page.evaluate(MANY_EVENTS) == [KEEP_EVENTS, 5000]


# To be done before the server is stopped: the module comes from there.
LOAD_STORE = "import('page/store.js').then(() => null)"
SILENT = """
async () => (await import("page/store.js")).apply({ event: "alive", silent_s: 65 })
"""


def test_a_launcher_that_is_suspended_is_reported(started: Browser, start: Start, sleeper: Path):
    run, link = start(sleeper)
    server = server_of(run.process.pid)
    assert server is not None
    with page_at(started, link) as page:
        expect(page.locator(".app-link")).to_have_text("open")
        page.evaluate(LOAD_STORE)
        os.kill(server, signal.SIGSTOP)  # it would say that the launcher is not
        try:
            page.evaluate(SILENT)
            expect(page.get_by_role("alert").first).to_contain_text("nothing for 1 min")
        finally:
            os.kill(server, signal.SIGCONT)


NAMES = """
() => performance.getEntriesByType("resource").map((one) => new URL(one.name).pathname)
"""


def test_the_first_picture_needs_few_requests(started: Browser, start: Start, sleeper: Path):
    _, link = start(sleeper)
    with page_at(started, link) as page:
        page.wait_for_selector("[data-process]")
        names = [name for name in page.evaluate(NAMES) if "echarts" not in name]
    # In a new browser a request takes longer than what it brings.
    files = ["/lib/icons.woff2", "/lib/quasar.js", "/lib/vue.js", "/page/main.js", "/page/page.css"]
    assert sorted(names) == files


MANY_PROCESSES = """
async () => {
  const store = await import("page/store.js");
  const [row] = store.processes.value;
  const processes = Array.from({ length: 300 }, (_, i) => ({ ...row, name: `many-${i}` }));
  store.apply({ event: "processes", wall: store.wall.value + 1, processes });
}
"""


def test_of_many_processes_those_in_view_are_drawn_whole(
    started: Browser, start: Start, sleeper: Path
):
    run, link = start(sleeper)
    server = server_of(run.process.pid)
    assert server is not None
    with page_at(started, link) as page:
        page.wait_for_selector('[data-process="cat-1"]')
        page.evaluate(LOAD_STORE)
        os.kill(server, signal.SIGSTOP)  # else its processes would replace these
        try:
            page.evaluate(MANY_PROCESSES)
            expect(page.locator("tr[data-process]")).to_have_count(300)
            whole = page.locator("tr[data-process] .process-actions")
            assert whole.count() < 100
            focused = page.locator('[data-process="many-3"] .process-name')
            focused.focus()
            last = page.locator('tr[data-process="many-299"]')
            last.scroll_into_view_if_needed()
            expect(last.locator(".process-actions")).to_be_visible()
            expect(page.locator('[data-process="many-0"] .process-actions')).to_have_count(0)
            assert whole.count() < 100
            expect(focused).to_be_focused()
            page.evaluate("dispatchEvent(new Event('beforeprint'))")
            expect(whole).to_have_count(300)
            page.evaluate("dispatchEvent(new Event('afterprint'))")
            expect(page.locator('[data-process="many-0"] .process-actions')).to_have_count(0)
        finally:
            os.kill(server, signal.SIGCONT)
