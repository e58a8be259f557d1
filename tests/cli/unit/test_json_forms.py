"""The forms of verbs that need neither a run nor nodes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from launcher.doctor.checks import check_all
from launcher.doctor.verb import as_document
from launcher.hosts.check.check_report import as_document as document_of_hosts
from launcher.hosts.check.examine import Examination
from launcher.posix.json_output import json_line
from tests.doctor.unit.test_doctor import HEALTHY
from tests.hosts.unit.test_check_judges import LOCAL, member, survey
from tests.support.bags import counting, write_bag
from tests.support.json_forms import fit
from tests.support.verbs import in_process

LAUNCH_FILE = """\
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, ExecuteProcess, LogInfo
from launch.events import Shutdown

def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("a", default_value="1", description="an argument"),
        LogInfo(msg="text"),
        ExecuteProcess(cmd=["true"], additional_env={"A": "1"}),
        EmitEvent(event=Shutdown(reason="done")),
    ])
"""
EVENTS = """\
{"wall_s": 1.0, "monotonic_s": 1.0, "event": "started", "process": "a-1", "pid": 7, "restarts": 0}
{"wall_s": 2.0, "monotonic_s": 2.0, "event": "finished", "exit_code": 0}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with files for the verbs below."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.launch.py").write_text(LAUNCH_FILE, encoding="utf-8")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "events.jsonl").write_text(EVENTS, encoding="utf-8")
    write_bag(tmp_path / "bag", counting("/a", 3))
    write_bag(tmp_path / "other", counting("/b", 3))
    return tmp_path


CASES = {
    "plan": "plan a.launch.py",
    "analyze": "analyze run",
    "env": "env",
    "bag info": "bag info -v bag other",
    "bag check": "bag check bag other",
    "bag compare": "bag compare bag other",
    "interface list": "interface list",
    "interface package": "interface package std_msgs",
    "interface packages": "interface packages",
    "interface show": "interface show std_msgs/msg/String",
    "interface proto": "interface proto std_msgs/msg/String",
}


@pytest.mark.parametrize("verb", CASES)
def test_the_form_of_a_verb(folder: Path, verb: str):
    answer = in_process(*CASES[verb].split(), "--json")
    assert answer.code in (0, 1), answer
    fit(verb, answer.out)


def test_the_form_of_a_plan_that_fails(folder: Path):
    (folder / "a.launch.py").write_text("1 / 0", encoding="utf-8")
    (plan,) = fit("plan", in_process("plan", "a.launch.py", "--json").out)
    assert plan["error"]["stage"] == "load"


def test_the_form_of_the_doctor():
    fit("doctor", json_line(as_document(check_all(HEALTHY), ["a sentence"])))


def test_the_form_of_a_check_of_hosts():
    found = Examination(survey=survey(member(LOCAL), member("bot")), findings=(), mode=None)
    (document,) = fit("hosts check", json_line(document_of_hosts(found)))
    assert [one["name"] for one in document["hosts"]] == [LOCAL, "bot"]


def test_version_comes_first():
    assert json.loads(json_line({"a": 1})) == {"version": 1, "a": 1}
    assert json_line({"a": 1}).startswith('{"version": 1, ')
