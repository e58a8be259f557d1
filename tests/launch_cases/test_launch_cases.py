"""Every development case: the plan is compared with what the real ROS 2 does, field by field.

All cases run in this one process, so whatever a case leaves behind would show in the next ones.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.launch.needed_release import FIRST
from launcher.launch.plan import plan_json
from launcher.launch.plan.plan import Plan
from launcher.launch.plan.planner import make_plan

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import compare  # noqa: E402

CASES = compare.load_cases()
NEWER = json.loads((HERE / "newer.json").read_text(encoding="utf-8"))


@pytest.fixture
def run_folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, str]]:
    """The environment of one run, with folders of its own; nothing of it stays."""
    folder = os.path.realpath(tempfile.mkdtemp(prefix="launch_case_"))
    environment = compare.run_environment(folder)
    for name in list(os.environ):
        monkeypatch.delenv(name)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.syspath_prepend(str(HERE / "prefix" / "python"))
    monkeypatch.chdir(environment["HOME"])
    monkeypatch.setattr(tempfile, "tempdir", None)
    yield environment
    shutil.rmtree(folder)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_the_plan_of_a_case_is_what_ros_2_does(case: dict, run_folder: dict[str, str]):
    expected = json.loads((HERE / case["expected"]).read_text(encoding="utf-8"))
    before = dict(os.environ), set(os.listdir(run_folder["TMPDIR"]))

    _, found = planned(HERE / case["file"], case["args"], run_folder)

    assert list(compare.differences(expected, found, strict=True)) == []
    assert dict(os.environ) == before[0]
    left_behind = {name for name in os.listdir(run_folder["TMPDIR"]) if "launch_params_" in name}
    assert left_behind == set()


@pytest.mark.parametrize("case", NEWER, ids=lambda case: case["id"])
def test_the_plan_of_a_newer_case_is_what_is_specified(case: dict, run_folder: dict[str, str]):
    file = HERE / "newer" / case["id"].partition("+")[0]
    plan, found = planned(file, case.get("args", []), run_folder, target=case.get("target"))

    newer = {name: FIRST[name] for name, _ in plan.uses if FIRST.get(name, "jazzy") != "jazzy"}
    assert newer == case.get("needs", {})
    error = found["error"] and {key: found["error"][key] for key in ("type", "stage")}
    assert error == case.get("error"), found["error"]
    logs = [[log["time"], log["message"]] for log in found["logs"]]
    assert logs == [[pytest.approx(time), text] for time, text in case.get("logs", [])]
    for section in ("processes", "loads", "lifecycle"):
        expected = case.get(section, [])
        assert len(found[section]) == len(expected), found[section]
        for one, wanted in zip(found[section], expected, strict=True):
            assert {field: one[field] for field in wanted} == wanted


def planned(
    path: Path, words: list[str], run_folder: dict[str, str], target: str | None = None
) -> tuple[Plan, dict]:
    """The plan of a launch file, and its document without what differs between machines."""
    arguments = [tuple(word.split(":=", 1)) for word in words]
    plan = make_plan(str(path), arguments, target=target)
    document = json.loads(json.dumps(plan_json.document(plan)))
    rules = compare.text_rules(run_folder, sys.executable)
    rules.append((re.compile(re.escape(str(HERE / "newer"))), "<newer>"))
    return plan, compare.canonical(document, rules)
