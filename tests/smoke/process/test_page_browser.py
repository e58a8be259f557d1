"""The page of `smoke --html` in a real browser, opened from disk, without a network."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import BrowserContext, Page, sync_playwright

from tests.smoke.process.bench import PATIENT, Bench

pytestmark = pytest.mark.browser

HOSTILE = "</script><img src=x onerror=alert(1)><script>alert(2)</script>"
ACTIONS = f"""
    sh("hostile", "echo '{HOSTILE}'; exec sleep 1000"),
"""
EXPECTED = """
    for: 2 s
    expect:
      - {name: heard, log: here I am, process: patient}
      - {name: "never <b>heard</b>", log: nowhere}
"""
# What the modules of the page know: they are the page's own, by the import map.
STATE = """
async () => {
  const store = await import("page/store.js");
  return {
    link: store.link.state,
    lines: store.log.rows.map((row) => row.text),
    expectations: store.expectations.value.map((one) => [one.title, one.state]),
    history: [...store.history.keys()],
    plan: store.plan.value?.tree.map((one) => one.name),
  };
}
"""


# The log searches in a worker, which is a file of its own as well.
SEARCH = """
() => new Promise((found) => {
  const worker = new Worker(window.frozenFiles["/page/log/search_worker.js"]);
  worker.onmessage = (event) => found([...event.data]);
  worker.postMessage({ source: "b", flags: "" });
  worker.postMessage({ texts: ["a", "b"] });
})
"""


class Seen:
    """What a browser asks for, and what it complains about."""

    def __init__(self, context: BrowserContext) -> None:
        self.schemes: set[str] = set()
        self.problems: list[str] = []
        context.on("request", lambda request: self.schemes.add(urlsplit(request.url).scheme))
        context.on("dialog", lambda dialog: self.problems.append(dialog.message))
        context.on("weberror", lambda error: self.problems.append(str(error.error)))
        context.on("console", self._said)

    def _said(self, message: Any) -> None:
        if message.type in ("error", "warning"):
            self.problems.append(message.text)


@pytest.fixture
def context() -> Iterator[BrowserContext]:
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        context = browser.new_context(offline=True)
        yield context
        browser.close()


def opened(context: BrowserContext, address: str) -> Page:
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector("[data-process]")
    return page


def show(page: Page, panel: str) -> None:
    page.evaluate("name => (location.hash = `#/${name}`)", panel)
    page.wait_for_selector(f"[data-shown={panel}] > *")


def test_the_page_opens_from_disk_and_asks_for_nothing(bench: Bench, context: BrowserContext):
    bench.write(PATIENT, ACTIONS)
    bench.expect(EXPECTED)
    path = bench.folder / "page.html"
    assert bench.smoke(f"--html={path}").returncode == 3
    seen = Seen(context)
    page = opened(context, path.as_uri())
    shown = page.locator("[data-process]").evaluate_all(
        "rows => rows.map((row) => row.dataset.process)"
    )
    assert set(shown) == {"patient-1", "hostile-2"}
    assert re.match(
        r"cancel\s+failed\s+report of \d{4}-", page.locator("[data-report]").inner_text()
    )
    assert "before the run was stopped" in page.locator(".app-note").inner_text()
    assert "was running" in page.locator("[data-process]").first.inner_text()
    state = page.evaluate(STATE)
    assert state["link"] == "frozen"
    assert {"here I am", HOSTILE} <= set(state["lines"])
    verdicts = [["heard", "passed"], ["never <b>heard</b>", "failed"]]
    assert [one for one in state["expectations"] if one in verdicts] == verdicts
    assert state["history"] == state["plan"] == ["patient-1", "hostile-2"]
    panels = page.locator("[data-panel]").evaluate_all("all => all.map((one) => one.dataset.panel)")
    assert len(panels) == 8
    for panel in panels:
        show(page, panel)
        assert not page.locator("img[src=x]").count()
    show(page, "log")
    page.get_by_text("here I am").wait_for()
    page.get_by_text(HOSTILE).first.wait_for()
    show(page, "timeline")
    page.get_by_text("expectation passed: heard").filter(visible=True).first.wait_for()
    page.get_by_text("expectation failed: never <b>heard</b>").filter(visible=True).first.wait_for()
    assert page.evaluate(SEARCH) == [1]
    assert seen.problems == []
    assert seen.schemes <= {"file", "blob", "data"}


def test_a_list_selects_the_run(bench: Bench, context: BrowserContext):
    bench.write(PATIENT)
    bench.expect("{for: 1 s, expect: [{log: nowhere, name: never}]}")
    path = bench.folder / "page.html"
    bench.smoke(f"--html={path}", "--repeat=2")
    seen = Seen(context)
    page = opened(context, path.as_uri())

    def pid() -> str:
        return str(page.evaluate("import('page/store.js').then((s) => s.hello.value.run.pid)"))

    first = pid()
    with page.expect_navigation():
        page.get_by_label("Run").select_option("run 2: failed, exit code 3")
    page.wait_for_selector("[data-process]")
    assert pid() != first
    assert page.get_by_label("Run").input_value() == "1"
    assert seen.problems == []
