"""Runs with a page, and a browser, as for the tests of the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.support.browser import chromium
from tests.web.process.conftest import Start, starting


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """`start(target, *words)`: a run and the link of its page; it ends with the test."""
    with starting(tmp_path) as begin:
        yield begin


@pytest.fixture(scope="session")
def started() -> Iterator[Browser]:
    """A browser that all tests share."""
    with chromium() as browser:
        yield browser
