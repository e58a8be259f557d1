"""`--responsive` and `top`: which real nodes do not answer, and what they are doing."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from launcher.posix.domain_lease import leased_domain
from tests.support.benches import ControlBench
from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

pytest.importorskip("rclpy")
HELPER = "launcher.ros.helpers.responsiveness"


@pytest.fixture
def bench(control_bench: ControlBench) -> Iterator[ControlBench]:
    with leased_domain() as domain_id:
        control_bench.env["ROS_DOMAIN_ID"] = str(domain_id)
        control_bench.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        yield control_bench


def node(bench: ControlBench, name: str, *words: str, options: str = "") -> str:
    """The action that starts a node which hangs when the file of its name says how."""
    program = ["-m", "tests.support.hanging_node", str(bench.folder), *words]
    return (
        "__import__('launch_ros').actions.Node(executable=sys.executable, output='screen', "
        f"name={name!r}, exec_name={name!r}, arguments={program!r}, cwd={str(REPOSITORY)!r}"
        f"{options}), "
    )


def helpers(run: ControlledRun) -> list[psutil.Process]:
    """The processes of this run that ask its nodes."""
    return children_with(run.process.pid, HELPER)


def hang(bench: ControlBench, name: str, how: str) -> Path:
    """Let a node hang; the file, which ends it in case of `sleep`."""
    file = bench.folder / name
    new = file.with_suffix(".new")
    new.write_text(how)
    new.rename(file)
    return file


def silent_s(run: ControlledRun, name: str) -> float | None:
    value: float | None = run.row(name)["not_responding_s"]
    return value


def wait_until_watched(run: ControlledRun, *names: str) -> None:
    """A node counts from its first answer on."""
    for name in names:
        wait_until(lambda name=name: silent_s(run, name) == 0, f"{name} answers")


@pytest.mark.thorough
def test_a_blocked_callback_is_told_with_its_place_until_it_returns(bench: ControlBench):
    with bench.launch(node(bench, "arm"), "--responsive") as run:
        wait_until_watched(run, "arm")
        file = hang(bench, "arm", "sleep")
        run.wait_for("it is in sleep (")
        assert "does not respond: /arm has not answered for " in run.screen
        assert (silent_s(run, "arm") or 0) >= 3
        assert "running, not responding " in run.shell("ps").stdout
        assert "RUNNING, not responding " in run.ask_text("info", "arm")
        file.unlink()
        run.wait_for("responds again, after ")
        wait_until_watched(run, "arm")
        events = {event["event"] for event in run.ask("events")["events"]}
        assert {"not responding", "responds"} <= events


@pytest.mark.thorough
def test_the_stack_of_a_node_that_had_to_be_killed_is_in_the_report(bench: ControlBench):
    quick = ", sigterm_timeout='0.3', sigkill_timeout='0.3'"
    with bench.launch(node(bench, "arm", options=quick), "--responsive") as run:
        wait_until_watched(run, "arm")
        hang(bench, "arm", "call")
        run.wait_for("it is in call (")
        run.process.send_signal(signal.SIGINT)
        run.exit_code()
        assert "escalating to 'SIGKILL'" in run.screen
        _, _, report = run.screen.partition("processes of this run:")
        assert "arm-1 had not responded for " in report
        assert "call (" in report
    assert bench.survivors() == []


@pytest.mark.thorough
def test_a_deadlock_is_told_and_both_threads_are_in_the_log(bench: ControlBench):
    with bench.launch(node(bench, "arm"), "--responsive") as run:
        wait_until_watched(run, "arm")
        hang(bench, "arm", "deadlock")
        run.wait_for("it is in deadlock (")
        run.process.send_signal(signal.SIGINT)  # the main thread is in a lock of Python
        run.exit_code()
    log = (Path(bench.env["ROS_LOG_DIR"]) / "latest/launch.log").read_text()
    assert "other (" in log.partition("had not responded for")[2]


@pytest.mark.thorough
def test_of_a_node_that_dies_while_it_hangs_the_stack_is_in_the_report(bench: ControlBench):
    with bench.launch(node(bench, "arm"), "--responsive") as run:
        wait_until_watched(run, "arm")
        hang(bench, "arm", "call")
        run.wait_for("it is in call (")
        os.kill(run.row("arm")["pid"], signal.SIGKILL)
        run.exit_code()
        _, _, report = run.screen.partition("processes of this run:")
        assert "arm-1 had not responded for " in report
        assert "hanging_node.py:" in report
        log = Path(bench.env["ROS_LOG_DIR"]) / "latest/launch.log"
        assert log.read_text().count("had not responded for") == 2


@pytest.mark.thorough
def test_nodes_that_cannot_be_expected_to_answer_are_no_false_alarm(bench: ControlBench):
    names = ("seen", "paused", "debugged", "mute", "late")
    words = {"mute": ["--no-services"], "late": ["--late"]}
    actions = "".join(node(bench, name, *words.get(name, [])) for name in names)
    hang(bench, "late", "sleep")
    with bench.launch(actions + 'sh("exec sleep 1000", name="other")', "--responsive") as run:
        wait_until_watched(run, "seen", "paused", "debugged")
        run.ask("pause", "paused")
        run.ask("debug", "debugged")
        hang(bench, "mute", "sleep")
        hang(bench, "seen", "sleep")
        wait_until(lambda: (silent_s(run, "seen") or 0) > 6, "that the others would be noticed")
        assert run.screen.count("does not respond") == 1
        assert [silent_s(run, name) for name in names[1:]] == [None] * 4


@pytest.mark.thorough
def test_it_is_watched_while_somebody_looks_only(bench: ControlBench, monkeypatch):
    with bench.launch(node(bench, "arm")) as run:
        run.wait_for("ready")
        run.ask("ps")
        assert helpers(run) == []
        with run.connect() as connection:
            connection.send("top", follow=True, period_s=0.2)
            wait_until(lambda: helpers(run), "a helper")
            (helper,) = helpers(run)
        wait_until(lambda: not helper.is_running() and not helpers(run), "its end")
        assert run.row("arm")["state"] == "RUNNING"


@pytest.mark.thorough
def test_ps_asks_on_request_also_a_node_that_never_answered(bench: ControlBench):
    names = ("arm", "late", "mute")
    words = {"late": ["--late"], "mute": ["--no-services"]}
    hang(bench, "late", "sleep")
    with bench.launch("".join(node(bench, name, *words.get(name, [])) for name in names)) as run:
        wait_until(lambda: run.screen.count("ready") == 3, "all have begun")
        assert silent_s(run, "late") is None
        result = run.ask("ps", responsive=True)
        rows = {row["name"].rpartition("-")[0]: row for row in result["processes"]}
        assert rows["late"]["not_responding_s"] >= 3
        assert rows["arm"]["not_responding_s"] == 0
        assert result["unknown_response"] == [rows["mute"]["name"]]
        hang(bench, "arm", "sleep")  # what is known of it is out of date
        said = run.shell("ps", "--responsive").stdout
        assert said.count("running, not responding") == 2
        assert f"has never answered: {rows['mute']['name']} (started " in said


@pytest.mark.thorough
def test_ps_says_which_processes_it_does_not_ask_and_why(bench: ControlBench):
    late, anonymous = node(bench, "late", "--late"), node(bench, "own")
    anonymous = anonymous.replace("name='own', ", "", 1)
    hang(bench, "late", "sleep")
    actions = late + anonymous + node(bench, "held") + 'sh("exec sleep 1000", name="other")'
    with bench.launch(actions, "--responsive") as run:
        wait_until_watched(run, "held")
        run.ask("pause", "held")
        found = run.ask("ps", responsive=True)["unanswered"]
        assert found == [
            {"name": "late-1", "asked": True, "reason": "has never answered"},
            {"name": "own-2", "asked": False, "reason": "no node name in the launch file"},
            {"name": "held-3", "asked": False, "reason": "paused"},
            {"name": "other-4", "asked": False, "reason": "no node name in the launch file"},
        ]
        said = run.shell("ps", "--responsive").stdout
        assert "not asked, no node name in the launch file: own-2, other-4\n" in said
        assert "has never answered: late-1 (started " in said


@pytest.mark.thorough
def test_ps_says_that_a_name_of_two_nodes_is_asked_once(bench: ControlBench):
    with bench.launch(node(bench, "arm") + node(bench, "arm")) as run:
        wait_until(lambda: run.screen.count("ready") == 2, "all have begun")
        (left,) = run.ask("ps", responsive=True)["unanswered"]
        reason = "another process has the same node name"
        assert left == {"name": "arm-1", "asked": False, "reason": reason}


@pytest.mark.thorough
def test_a_helper_that_dies_is_told_and_the_run_goes_on(bench: ControlBench):
    with bench.launch(node(bench, "arm"), "--responsive") as run:
        wait_until_watched(run, "arm")
        hang(bench, "arm", "sleep")
        wait_until(lambda: silent_s(run, "arm"), "its silence")
        (helper,) = helpers(run)
        helper.kill()
        run.wait_for("it is not watched any more whether nodes respond")
        assert silent_s(run, "arm") is None
        assert run.row("arm")["state"] == "RUNNING"


@pytest.mark.thorough
def test_a_process_that_somebody_else_suspends_is_told(bench: ControlBench):
    with bench.launch(node(bench, "arm"), "--responsive") as run:
        wait_until_watched(run, "arm")
        os.kill(run.row("arm")["pid"], signal.SIGSTOP)
        run.wait_for("[arm-1]: does not respond")
        assert "paused, not responding " in run.shell("ps").stdout
        os.kill(run.row("arm")["pid"], signal.SIGCONT)
        run.wait_for("responds again")


@pytest.mark.thorough
def test_twenty_healthy_nodes_under_load_are_no_false_alarm(bench: ControlBench):
    names = [f"arm_{number}" for number in range(20)]
    busy = 'ExecuteProcess(cmd=[sys.executable, "-c", "while True: pass"]), ' * 4
    actions = "".join(node(bench, name) for name in names)
    with bench.launch(actions + busy, "--responsive") as run:
        wait_until(lambda: run.screen.count("ready") == 20, "all nodes", timeout_s=240)
        wait_until_watched(run, *names)
        ready_s = run.row("arm_0")["uptime_s"]
        wait_until(lambda: run.row("arm_0")["uptime_s"] > ready_s + 30, "half a minute")
        assert "does not respond" not in run.screen
        hang(bench, "arm_19", "sleep")
        run.wait_for("[arm_19-20]: does not respond")
        assert run.screen.count("does not respond") == 1
