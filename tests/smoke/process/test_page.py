"""`--html`: the page of a run as one file, and what a page that follows the run is told."""

from __future__ import annotations

import base64
import contextlib
import gzip
import json
import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.smoke.process.bench import DONE, PATIENT, SHORT, Bench
from tests.support.waiting import wait_until

HEARD = """
    for: 1 s
    expect:
      - {name: heard, log: here, process: patient, within: 60 s}
      - {process: done, exits: 0, within: 60 s}
"""


def messages(path: Path, run: int = 0) -> dict[str, dict[str, Any]]:
    """The messages in a page by their events."""
    found = re.search(rf'id="frozen-{run}">([^<]*)<', path.read_text(encoding="utf-8"))
    assert found is not None
    decoded = json.loads(gzip.decompress(base64.b64decode(found[1])))
    return {message["event"]: message for message in decoded}


@contextlib.contextmanager
def interrupted(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """A smoke command that is interrupted at the end."""
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


def texts(found: dict[str, dict[str, Any]]) -> list[str]:
    return [row[4] for row in found["lines"]["lines"]]


def test_the_page_has_what_the_run_showed(bench: Bench):
    bench.write(PATIENT, DONE)
    bench.expect(HEARD)
    path = bench.folder / "deep" / "page.html"
    done = bench.smoke(f"--html={path}")
    assert done.returncode == 0, done.stdout + done.stderr
    found = messages(path)
    rows = {row["label"]: row for row in found["processes"]["processes"]}
    assert (rows["patient"]["state"], rows["done"]["state"]) == ("RUNNING", "EXITED")
    assert "here I am" in texts(found)
    assert {"started", "ended"} <= {one["event"] for one in found["run_events"]["items"]}
    assert found["history"]["processes"].keys() == {"patient-1", "done-2"}
    names = [entry["name"] for entry in found["plan"]["tree"]]
    assert names == ["patient-1", "done-2"]
    heard = next(one for one in found["expectations"]["items"] if one["title"] == "heard")
    assert heard["state"] == "passed" and "after" in heard["detail"]
    run = found["hello"]["run"]
    assert run["started_wall_s"] - 1 < heard["wall"] < found["hello"]["wall"]
    assert found["hello"]["frozen"]["report"] == bench.report()


@pytest.mark.thorough
def test_the_page_of_a_run_that_failed_early_says_why(bench: Bench):
    bench.write('sh("x", "echo", cwd=1 / 0),')
    path = bench.folder / "page.html"
    done = bench.smoke(f"--html={path}")
    assert done.returncode == 2
    found = messages(path)
    assert any("division by zero" in text for text in texts(found))
    assert {one["state"] for one in found["expectations"]["items"]} == {"failed"}
    bench.write(PATIENT)
    bench.expect("{expect: [{logg: x}]}")
    assert bench.smoke(f"--html={path}").returncode == 2
    assert any("logg" in text for text in texts(messages(path)))


@pytest.mark.thorough
def test_all_repetitions_are_in_one_page(bench: Bench):
    bench.write(SHORT)
    path = bench.folder / "page.html"
    assert bench.smoke(f"--html={path}", "--repeat=2").returncode == 1
    for number in range(2):
        (row,) = messages(path, number)["processes"]["processes"]
        assert (row["state"], row["last_exit"]["returncode"]) == ("EXITED", 3)


@pytest.mark.thorough
def test_an_interrupted_run_has_its_page(bench: Bench):
    bench.write(PATIENT)
    path = bench.folder / "page.html"
    log = bench.evidence / "smoke.log"
    with interrupted(bench.start(f"--html={path}", "--for=1000")) as process:
        wait_until(lambda: log.exists() and "] ready" in log.read_text(), "ready")
    assert process.returncode == 130
    items = messages(path)["expectations"]["items"]
    assert ("the run", "interrupted") in [(one["title"], one["detail"]) for one in items]


@pytest.mark.thorough
def test_a_page_that_cannot_be_written_is_refused_before_the_run(bench: Bench):
    bench.write(PATIENT)
    (bench.folder / "file").touch()
    done = bench.smoke(f"--html={bench.folder}/file/page.html")
    assert done.returncode == 2
    assert f"--html {bench.folder}/file/page.html: " in done.stderr
    assert not (bench.evidence / "smoke.log").exists()


@pytest.mark.thorough
def test_without_the_extra_the_error_has_the_command(bench: Bench):
    bench.write(PATIENT)
    hidden = bench.folder / "hidden"
    hidden.mkdir()
    (hidden / "sitecustomize.py").write_text(
        "import importlib.util as util\n"
        "find = util.find_spec\n"
        "util.find_spec = lambda name, *more: None if name == 'nicegui' else find(name, *more)\n"
    )
    bench.environment["PYTHONPATH"] = str(hidden)
    done = bench.smoke("--html=page.html")
    assert done.returncode == 2
    assert "--html needs the Python package 'nicegui', which is not installed" in done.stderr
    assert re.search(r"hint: .*install.*\[web\]", done.stderr)


def test_a_page_that_follows_the_run_is_told_what_is_decided(bench: Bench):
    bench.write(PATIENT)
    bench.expect("{for: 100 s, expect: [{name: heard, log: here}, {name: never, log: nowhere}]}")

    def states() -> dict[str, str]:
        (file,) = bench.evidence.glob("log/*-*/expectations.json")
        items = json.loads(file.read_text(encoding="utf-8"))["items"]
        return {one["title"]: one["state"] for one in items}

    with interrupted(bench.start()):
        wait_until(lambda: [*bench.evidence.glob("log/*-*/expectations.json")], "the file")
        wait_until(lambda: states()["heard"] == "passed", "the first expectation")
        assert states()["never"] == "open"
