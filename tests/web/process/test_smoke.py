"""A page beside a run of `smoke`: expectations as they come true."""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.smoke.process.bench import PATIENT, Bench
from tests.support.controlled_run import sockets_below
from tests.support.waiting import wait_until
from tests.support.web_page import PageClient, get

LINK = re.compile(r"http://\S+token=\S+")
EXPECTED = """
    for: 1000 s
    expect:
      - {name: heard, log: here I am, process: patient}
      - {name: later, log: woke up}
      - {name: never, log: nowhere}
"""
LATER = 'sh("later", "until test -e {go}; do sleep 0.05; done; echo woke up; exec sleep 1000"),'


@contextlib.contextmanager
def page_beside(bench: Bench, screen: Path) -> Iterator[str]:
    """The link of `launcher web` beside the only run."""
    with screen.open("w") as output:
        server = subprocess.Popen(
            [sys.executable, "-m", "launcher", "web", "--port", "0"],
            env=bench.environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
    try:
        wait_until(lambda: LINK.search(screen.read_text()) or server.poll() is not None, "a link")
        found = LINK.search(screen.read_text())
        assert found is not None, screen.read_text()
        yield found[0]
    finally:
        server.send_signal(signal.SIGINT)
        server.wait(30)


@pytest.fixture
def runtime() -> Iterator[Path]:
    """A folder whose path is short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="run-") as folder:
        yield Path(folder)


@pytest.mark.thorough
def test_expectations_are_shown_as_they_come_true(tmp_path: Path, runtime: Path):
    bench = Bench(tmp_path)
    bench.environment["XDG_RUNTIME_DIR"] = str(runtime)
    go = tmp_path / "go"
    bench.write(PATIENT, LATER.format(go=go))
    bench.expect(EXPECTED)
    smoke = bench.start()
    try:
        wait_until(lambda: sockets_below(runtime) or smoke.poll() is not None, "a socket")
        with page_beside(bench, tmp_path / "screen") as link, PageClient(link) as page:
            page.open()

            def states() -> list[str]:
                messages = page.of("expectations")
                return [one["state"] for one in messages[-1]["items"][:3]] if messages else []

            wait_until(lambda: states() == ["passed", "open", "open"], "the first that came true")
            go.touch()
            wait_until(lambda: states() == ["passed", "passed", "open"], "the next one")
            page.ask("tree")
            wait_until(lambda: page.of("plan") and page.of("plan")[-1]["tree"], "the tree")
            assert [one["name"] for one in page.of("plan")[-1]["tree"]] == ["patient-1", "later-2"]
            token = link.partition("token=")[2]
            text = get(link, f"/metrics?token={token}")[2]
            assert 'launcher_expectations{state="passed"} ' in text
    finally:
        smoke.send_signal(signal.SIGINT)
        smoke.communicate(timeout=60)
