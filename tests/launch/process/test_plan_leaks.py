"""Many plans in one process leave nothing behind."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from tests.support.repository import REPOSITORY

pytestmark = pytest.mark.thorough

CASES = REPOSITORY / "tests/launch_cases"
ROUNDS = 4
GROWTH_KIB = 4096  # of resident memory from the second round to the last; a round is 433 plans
TIMEOUT_S = 300

# Runs in a process of its own: the test runner's caches and threads are none of its business.
SCRIPT = """
import contextlib, gc, json, os, sys, tempfile
from pathlib import Path
import psutil
cases, rounds = Path(sys.argv[1]), int(sys.argv[2])
from launcher.launch.plan.planner import make_plan
from launcher.launch.plan import plan_json
from launcher.language.compat import TOP_NAMES

def state():
    gc.collect()
    own = psutil.Process()
    return {
        "descriptors": own.num_fds(),
        "temporary": sorted(n for n in os.listdir(tempfile.gettempdir()) if "launch_" in n),
        "environment": dict(os.environ),
        "modules": sorted(n for n in sys.modules if n.partition(".")[0] in TOP_NAMES),
        "meta_path": len(sys.meta_path),
        "folder": os.getcwd(),
        "children": [child.pid for child in own.children()],
        "memory_kib": own.memory_info().rss // 1024,
    }

states = []
recorded, newer = (json.loads((cases / f"{name}.json").read_text()) for name in ("cases", "newer"))
runs = [(cases / run["file"], run["args"]) for run in recorded]
for run in newer:
    runs.append((cases / "newer" / run["id"].partition("+")[0], run.get("args", [])))
for _ in range(rounds):
    for file, words in runs:
        arguments = [tuple(word.split(":=", 1)) for word in words]
        plan_json.document(make_plan(str(file), arguments))
    states.append(state())
json.dump(states, sys.__stdout__)
"""


@pytest.fixture(scope="module")
def states(tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    """What the process held after each round of planning every case."""
    folder = tmp_path_factory.mktemp("plans")
    prefix = CASES / "prefix"
    environment = {
        **os.environ,
        "AMENT_PREFIX_PATH": str(prefix),
        "PATH": f"{prefix / 'bin'}:{os.environ['PATH']}",
        "PYTHONPATH": f"{CASES.parents[1]}:{prefix / 'python'}",
        "PYTHONDONTWRITEBYTECODE": "1",
        "TMPDIR": str(folder),
        "HOME": str(folder),
    }
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(CASES), str(ROUNDS)],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    result: list[dict] = json.loads(done.stdout)
    return result


@pytest.mark.parametrize(
    "what",
    ["descriptors", "temporary", "environment", "modules", "meta_path", "folder", "children"],
)
def test_every_round_leaves_the_process_as_the_first_one_did(states: list[dict], what: str):
    assert [state[what] for state in states] == [states[0][what]] * ROUNDS


def test_no_generated_file_and_no_module_of_ours_stays(states: list[dict]):
    assert [name for name in states[-1]["temporary"] if name.startswith("launch_params_")] == []
    assert states[-1]["modules"] == []
    assert states[-1]["children"] == []


def test_memory_does_not_grow_with_the_number_of_plans(states: list[dict]):
    memory = [state["memory_kib"] for state in states]
    assert memory[-1] - memory[1] < GROWTH_KIB, memory
