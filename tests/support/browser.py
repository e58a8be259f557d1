"""A real Chromium, driven by Playwright."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from typing import Any

from playwright.sync_api import Browser, Page, expect, sync_playwright

TIMEOUT_MS = 30_000  # a probe starts, and nodes are discovered, beside other processes
_running: list[Browser] = []
expect.set_options(timeout=TIMEOUT_MS)


def browser() -> str:
    """The browser's path; the test fails where there is none, and says what to do."""
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if path := shutil.which(name):
            return path
    raise AssertionError("no Chromium on PATH: apt-get install chromium")


@contextlib.contextmanager
def chromium() -> Iterator[Browser]:
    """A browser without a window: of a process, one at a time, which further callers share."""
    if _running:
        yield _running[0]
        return
    with sync_playwright() as playwright:
        # Containers lack what the sandbox needs, and have a small /dev/shm.
        started = playwright.chromium.launch(
            executable_path=browser(), args=["--no-sandbox", "--disable-dev-shm-usage"]
        )
        _running.append(started)
        yield started
        _running.remove(started)
        started.close()


@contextlib.contextmanager
def page_at(
    started: Browser, url: str, *, problems_allowed: bool = False, **context: Any
) -> Iterator[Page]:
    """An open page, in a new session; AssertionError if it reports problems on its console.

    `context` is for `Browser.new_context`: `viewport`, `color_scheme`.
    """
    session = started.new_context(**context)
    page = session.new_page()
    page.set_default_timeout(TIMEOUT_MS)
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(f"{error.name}: {error.message}"))
    page.on(
        "console",
        lambda message: problems.append(message.text) if message.type == "error" else None,
    )
    page.on("dialog", lambda dialog: problems.append(f"dialog: {dialog.message}"))
    page.goto(url)
    yield page
    session.close()
    assert problems_allowed or not problems, problems
