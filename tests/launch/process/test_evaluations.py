"""A launch file is loaded and evaluated once for each run, plan, export and reload.

A tally has a line for each execution of the module of a file, and of each function and command.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from tests.support.benches import TIMEOUT_S, ControlBench, bench_with_sockets
from tests.support.loopback.bench import HostsBench
from tests.support.variations import few_of
from tests.support.waiting import wait_until

LAUNCH = """
import os
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.substitutions import *

HERE = os.path.dirname(__file__)


def note(word):
    with open(os.path.join(HERE, "tally"), "a") as tally:
        tally.write(f"{word}\\n")


def command(word):
    return LogInfo(msg=Command(["sh -c 'echo ", word, f" >> {HERE}/tally'"]))


def sleeper(name, **more):
    return ExecuteProcess(cmd=["sleep", "1000"], name=name, **more)


def included(name, **more):
    return IncludeLaunchDescription(f"{HERE}/{name}", **more)
"""
FILES = {
    "a.launch.py": """
note("load")


def declare(context):
    note("function")
    return [DeclareLaunchArgument("inner", default_value="1")]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("plain", default_value="1"),
        SetEnvironmentVariable("FROM_LAUNCH_FILE", "1"),
        OpaqueFunction(function=declare),
        command("command"),
        included("child.launch.py", launch_arguments=[("of_grandchild", "1")]),
        included("off.launch.py", condition=IfCondition("0")),
        sleeper("bot1_a"),
        sleeper("here", on_exit=[LogInfo(msg="over")]),
        TimerAction(period=900.0, actions=[sleeper("bot1_late")]),
    ])
""",
    "child.launch.py": """
note("child")


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("of_child", default_value="1"),
        included("grandchild.launch.py"),
    ])
""",
    "grandchild.launch.py": """
note("grandchild")


def generate_launch_description():
    return LaunchDescription([DeclareLaunchArgument("of_grandchild", default_value="1")])
""",
    "off.launch.py": """
note("off")


def generate_launch_description():
    return LaunchDescription([DeclareLaunchArgument("of_off", default_value="1")])
""",
}
ONCE = {"load": 1, "function": 1, "command": 1, "child": 1, "grandchild": 1}
ALL = {**ONCE, "off": 1}


class Tallied:
    """A folder with the launch files, and what they have tallied."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.env = {**os.environ, "ROS_LOG_DIR": str(folder / "log"), "TMPDIR": str(folder)}
        for name, text in FILES.items():
            (folder / name).write_text(LAUNCH + text)

    def call(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "launcher", *words],
            env=self.env,
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
        )

    def take(self) -> dict[str, int]:
        """What was tallied since the last call."""
        tally = self.folder / "tally"
        lines = tally.read_text().splitlines() if tally.exists() else []
        tally.unlink(missing_ok=True)
        return dict(Counter(lines))


@pytest.fixture
def tallied(tmp_path: Path) -> Tallied:
    return Tallied(tmp_path)


SUPERVISION = "bot1_a: {after: here}\nhere: {ready_when: {command: 'true'}}\n"
RUNS: dict[str, Sequence[str]] = {
    "plain": [],
    "a declared argument": ["plain:=2"],
    "an argument that a function declares": ["inner:=2"],
    "an argument of an include": ["of_child:=2", "of_grandchild:=2"],
    "a required process": ["--required", "here"],
    "composed nodes": ["--compose", "bot1_*"],
    "a supervision file": ["--supervise", "order.yaml"],
    "limits, prefixes, restarts": ["--nice", "here=5", "--restart", "here=always"],
    "any name": ["bogus:=1", "--lenient"],
}


@pytest.mark.parametrize(
    "name", few_of(RUNS, ["plain", "an argument of an include", "a supervision file"])
)
def test_a_run_evaluates_its_launch_file_once(tallied: Tallied, name: str):
    (tallied.folder / "order.yaml").write_text(SUPERVISION)
    done = tallied.call("a.launch.py", "--timeout", "0.5", *RUNS[name])
    assert "process started with pid" in done.stdout, done.stdout + done.stderr
    assert tallied.take() == (ALL if "--supervise" in RUNS[name] else ONCE)


def test_a_file_behind_a_false_condition_is_loaded_for_its_arguments(tallied: Tallied):
    done = tallied.call("a.launch.py", "--timeout", "0.5", "of_off:=1")
    assert "process started with pid" in done.stdout
    assert tallied.take() == ALL


def test_a_misspelt_argument_is_refused_after_the_evaluation(tallied: Tallied):
    done = tallied.call("a.launch.py", "innner:=1")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == ("error: unknown launch argument 'innner'\nhint: did you mean 'inner'?\n")
    assert tallied.take() == ALL


def test_a_file_that_comes_later_is_loaded_once(tallied: Tallied):
    file = tallied.folder / "a.launch.py"
    timer = 'TimerAction(period=0.3, actions=[included("off.launch.py")]),'
    text = file.read_text().replace('sleeper("bot1_a"),', timer)
    file.write_text(text.replace('included("off.launch.py", condition=IfCondition("0")),', ""))
    done = tallied.call("a.launch.py", "--timeout", "2", "of_off:=1", "--exit-when-any-dies")
    assert done.returncode == 0
    assert tallied.take() == ALL


# Three dozen nodes, some of them later: there is a warning that they do not find each other.
CROWD = """
note("load")


def generate_launch_description():
    from launch_ros.actions import Node

    nodes = [Node(executable="/bin/true", name=f"n{number}") for number in range(40)]
    return LaunchDescription([*nodes[:20], TimerAction(period=900.0, actions=nodes[20:])])
"""


def test_a_crowd_is_counted_without_another_evaluation(tallied: Tallied):
    (tallied.folder / "crowd.launch.py").write_text(LAUNCH + CROWD)
    tallied.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    done = tallied.call("crowd.launch.py", "--timeout", "0.1")
    assert "warning: 40 nodes on domain" in done.stderr
    assert tallied.take() == {"load": 1}


HOSTS = "hosts: {bot1: {address: 127.0.0.1}}\nplace: {'bot1_*': bot1}\n"
PLANS: dict[str, tuple[Sequence[str], dict[str, int]]] = {
    "plan": (["plan", "a.launch.py"], ALL),
    "plan with arguments": (["plan", "a.launch.py", "inner:=2", "of_off:=1"], ALL),
    "plan with an unknown argument": (["plan", "a.launch.py", "innner:=2"], ALL),
    "plan as a document": (["plan", "a.launch.py", "--json"], ALL),
    "plan with hosts": (["plan", "a.launch.py", "--hosts", "hosts.yaml", "inner:=2"], ALL),
    "plan with composed nodes": (["plan", "a.launch.py", "--compose", "bot1_*"], ALL),
    "print": (["a.launch.py", "--print"], ALL),
    "export": (["export", "systemd", "a.launch.py", "inner:=2"], ALL),
    "export with hosts": (["export", "systemd", "a.launch.py", "--hosts", "hosts.yaml"], ALL),
    "args": (["args", "a.launch.py"], {"load": 1, "child": 1, "grandchild": 1, "off": 1}),
    "show-args": (["a.launch.py", "-s"], {"load": 1, "child": 1, "grandchild": 1, "off": 1}),
    "hosts check": (["hosts", "check", "a.launch.py", "--hosts", "hosts.yaml"], ALL),
}


@pytest.mark.parametrize(
    "name", few_of(PLANS, ["plan", "plan with hosts", "export", "args", "hosts check"])
)
def test_what_only_looks_at_a_launch_file_evaluates_it_once(tallied: Tallied, name: str):
    (tallied.folder / "hosts.yaml").write_text(HOSTS)
    words, expected = PLANS[name]
    done = tallied.call(*words)
    assert "Traceback" not in done.stderr
    assert tallied.take() == expected, done.stdout + done.stderr


def test_an_argument_of_a_file_that_fails_is_judged_without_another_evaluation(tallied: Tallied):
    file = tallied.folder / "a.launch.py"
    file.write_text(
        file.read_text().replace('sleeper("bot1_a"),', 'LogInfo(msg=Command("false")),')
    )
    done = tallied.call("a.launch.py", "innner:=1")
    assert done.returncode == 2
    assert "unknown launch argument 'innner'\nhint: did you mean 'inner'?" in done.stderr
    assert "executed command failed. Command: false" in done.stderr
    assert tallied.take() == ALL


# ---- tests of launch files

EXPECTATIONS = """
for: 1 s
scenario: [{at: 0.1 s, do: stop here}]
expect: [{process: bot1_a, alive: true}]
"""


@pytest.mark.thorough
def test_smoke_evaluates_the_launch_file_once_in_each_run(tallied: Tallied):
    (tallied.folder / "a.expect.yaml").write_text(EXPECTATIONS)
    done = tallied.call("smoke", "a.launch.py", "inner:=2", "--repeat", "2")
    assert done.returncode == 0, done.stdout + done.stderr
    assert tallied.take() == dict.fromkeys(ONCE, 2)


def test_a_name_that_smoke_does_not_know_is_refused_after_the_evaluation(tallied: Tallied):
    (tallied.folder / "a.expect.yaml").write_text(EXPECTATIONS.replace("stop here", "stop heer"))
    done = tallied.call("smoke", "a.launch.py", "--junit", "out.xml")
    assert done.returncode == 2
    assert "a.expect.yaml:3: the launch file starts no process 'heer'" in done.stderr
    assert "did you mean 'here'?" in done.stderr
    assert "heer" in (tallied.folder / "out.xml").read_text()
    assert "process started" not in done.stdout and "evidence is in" not in done.stdout
    assert tallied.take() == ONCE


@pytest.mark.thorough
def test_recorded_expectations_are_those_of_runs_that_evaluate_once(tallied: Tallied):
    done = tallied.call("smoke", "a.launch.py", "--record", "new.yaml", "--for", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    assert tallied.take() == dict.fromkeys(ONCE, 2)


PYTEST = """
def test_it_runs(launched_system):
    system = launched_system("a.launch.py", probe=False, inner="2")
    system.wait_until(lambda: len(system.processes()) == 2, "both processes")
"""


@pytest.mark.thorough
def test_the_fixture_of_pytest_evaluates_the_launch_file_once(tallied: Tallied):
    (tallied.folder / "test_it.py").write_text(PYTEST)
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_it.py"]
    done = subprocess.run(
        words, env=tallied.env, cwd=tallied.folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    assert tallied.take() == ONCE


# ---- runs that go on


class _Tallying(ControlBench):
    """A bench whose launch file is that of the tally; the actions are not used."""

    @functools.cached_property
    def tallied(self) -> Tallied:
        return Tallied(self.folder)

    def command(self, actions: str, *words: str) -> Sequence[str]:
        found = super().command(actions, *words)
        (self.tallied.folder / "bench.launch.py").write_text(LAUNCH + FILES["a.launch.py"])
        (self.folder / "order.yaml").write_text(SUPERVISION)
        return found


class _TallyingHosts(_Tallying, HostsBench):
    hosts_text = HOSTS


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[_Tallying]:
    with bench_with_sockets(_Tallying, tmp_path) as one:
        yield one


@pytest.fixture
def hosts_bench(tmp_path: Path) -> Iterator[_TallyingHosts]:
    with bench_with_sockets(_TallyingHosts, tmp_path) as one:
        one.hosts_text = HOSTS
        yield one


@pytest.mark.parametrize(
    "words", few_of([[], ["inner:=2"], ["--supervise", "{}/order.yaml"]], [["inner:=2"]])
)
def test_a_run_on_several_hosts_evaluates_its_launch_file_once(
    hosts_bench: _TallyingHosts, words: Sequence[str]
):
    words = [word.format(hosts_bench.folder) for word in words]
    with hosts_bench.launch("", *words) as run:
        wait_until(lambda: run.row("bot1_a")["state"] == "RUNNING", "the process of bot1")
        assert run.row("bot1_a")["host"] == "bot1"
        run.ask("quit")
        assert run.exit_code() == 0
    assert hosts_bench.tallied.take() == ALL


@pytest.mark.parametrize(
    ("words", "each"),
    [
        pytest.param([], ONCE, marks=pytest.mark.thorough),
        (["inner:=2"], ONCE),
        (["of_off:=1"], ALL),
    ],
)
def test_each_reload_evaluates_the_launch_file_once(
    bench: _Tallying, words: Sequence[str], each: dict[str, int]
):
    with bench.launch("", *words) as run:
        wait_until(lambda: run.row("here")["state"] == "RUNNING", "a running process")
        assert bench.tallied.take() == each
        for options in ({"dry_run": True}, {}):
            changes = {one["change"] for one in run.ask("reload", **options)["processes"]}
            assert changes == {"same"}
            assert bench.tallied.take() == each
        assert run.ask("plan")["processes"]
        assert bench.tallied.take() == {}


def test_an_edited_launch_file_that_is_watched_is_evaluated_once(bench: _Tallying):
    with bench.launch("", "--watch", "inner:=2") as run:
        wait_until(lambda: len(run.ask("watch")["launch_files"]) >= 3, "the launch files")
        assert bench.tallied.take() == ONCE
        file = bench.folder / "child.launch.py"
        text = file.read_text()
        file.write_text(text.replace('included("grand', 'sleeper("new"), included("grand'))
        run.wait_for("the launch file was reloaded: new: new-")
        assert bench.tallied.take() == ONCE
