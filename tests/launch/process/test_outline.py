"""The tree of a launch file as data, which a process of its own prints."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys

from launcher.web.page_plan_tree import read_tree
from tests.support.benches import TIMEOUT_S, Workspace


def outline(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "launcher.launch.outline", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)


def test_the_tree_alone_is_on_standard_output_and_nothing_is_started(workspace: Workspace):
    file = workspace.write('OpaqueFunction(function=lambda context: print("printed")),')
    done = outline(file)
    tree = json.loads(done.stdout)
    assert [one["text"] for one in tree if one["kind"] == "process"]
    assert not workspace.started.exists()
    assert asyncio.run(read_tree(str(file), ())) == tree


def test_a_failing_file_has_no_tree(workspace: Workspace):
    file = workspace.write("OpaqueFunction(function=lambda context: 1 / 0),")
    done = outline(file)
    assert (done.returncode, done.stdout) == (2, "")
    assert asyncio.run(read_tree(str(file), ())) is None
