"""Log levels of real nodes: --log-level at their start, `loglevel` while they run."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from launcher.posix.domain_lease import leased_domain
from launcher.posix.socket_directory import ControlError
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

pytest.importorskip("rclpy")


def node(process: str, *words: str, **options: object) -> str:
    """The action that starts a logging node."""
    given = "".join(f", {key}={value!r}" for key, value in options.items())
    program = ["-m", "tests.support.logging_node", *words]
    return (
        "__import__('launch_ros').actions.Node(executable=sys.executable, output='screen', "
        f"exec_name={process!r}, arguments={program!r}, cwd={str(REPOSITORY)!r}{given})"
    )


@pytest.fixture
def bench(control_bench: ControlBench) -> Iterator[ControlBench]:
    with leased_domain() as domain_id:
        control_bench.env["ROS_DOMAIN_ID"] = str(domain_id)
        yield control_bench


def lines(run: ControlledRun, process: str, logger: str) -> set[str]:
    """The levels of the lines of a logger so far."""
    found = re.findall(rf"\[{process}\] \[(\w+)\] \[[\d.]+\] \[{re.escape(logger)}\]", run.screen)
    return set(found)


def test_the_command_line_wins_over_the_launch_file(bench: ControlBench):
    own = ["--log-level", "logging_node:=fatal"]
    actions = ", ".join(
        [
            node("a"),
            node("b", ros_arguments=own),
            node("c", ros_arguments=["--log-level", "debug"]),
            node("d", ros_arguments=["--log-level", "error"]),
            "sh('exec sleep 1000', name='e')",
        ]
    )
    level = "a=debug,e=debug,d:logging_node.part=debug,*=WARNING"
    with bench.launch(actions, "--log-level", level) as run:
        for process in ("a-1", "b-2", "c-3", "d-4"):
            wait_until(lambda name=process: "ERROR" in lines(run, name, "logging_node"), process)
        wait_until(lambda: "DEBUG" in lines(run, "d-4", "logging_node.part"), "debug lines of d")
        run.wait_for("--log-level 'e' does not apply to e-5: it is not started as a ROS node")
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
    assert lines(run, "a-1", "logging_node") == {"DEBUG", "INFO", "ERROR"}
    assert lines(run, "b-2", "logging_node") == {"ERROR"}
    assert lines(run, "c-3", "logging_node") == {"ERROR"}
    assert lines(run, "d-4", "logging_node") == {"ERROR"}  # named only with a logger


@pytest.mark.thorough
def test_levels_of_running_nodes_are_set_and_printed(bench: ControlBench):
    actions = ", ".join(
        [
            node("a", "--service", name="talker", namespace="fleet"),
            node("b", "--service", "--twice"),
            node("c", name="quiet"),
        ]
    )
    with bench.launch(actions) as run:
        for process in ("a-1", "b-2", "c-3"):
            run.wait_for(f"[{process}] [ERROR]")
        assert run.ask_text("loglevel", "a") == (
            "a-1: logger fleet.talker is at INFO (from its process)"
        )
        assert run.shell("loglevel", "a", "debug").stdout == (
            "a-1: logger fleet.talker is now at DEBUG\n"
        )
        wait_until(lambda: "DEBUG" in lines(run, "a-1", "fleet.talker.part"), "debug lines")
        run.ask("loglevel", "a", logger="fleet.talker.part", level="fatal")
        assert run.ask_text("loglevel", "a", logger="fleet.talker.part.deep") == (
            "a-1: logger fleet.talker.part.deep is at FATAL (from fleet.talker.part)"
        )
        answers = run.ask("loglevel", "b-2", level="warning")["levels"]
        assert {(one["node"], one["level"]) for one in answers} == {
            ("/logging_node", "WARN"),
            ("/second_node", "WARN"),
        }
        done = run.shell("loglevel", "c", "debug")
        assert "/quiet does not offer to set its levels" in done.stderr
        assert "--log-level quiet=debug" in done.stderr
        assert done.returncode != 0
        with pytest.raises(ControlError, match="unknown level 'debgu'"):
            run.ask("loglevel", "a", level="debgu")
        run.ask("stop", "c")
        with pytest.raises(ControlError, match="c-3 is not running"):
            run.ask("loglevel", "c", level="debug")
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
    assert "DEBUG" not in lines(run, "c-3", "quiet")


def test_the_run_ends_while_a_node_is_asked(bench: ControlBench):
    silent = "import time; time.sleep(1000)"
    action = (
        "__import__('launch_ros').actions.Node(executable=sys.executable, exec_name='a', "
        f"arguments=['-c', {silent!r}])"
    )
    with bench.launch(action) as run:
        asking = run.shell_start("loglevel", "a", "debug")
        wait_until(lambda: "logger_levels" in _children(run), "the process that asks")
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
        asking.communicate(timeout=60)
        assert asking.returncode != 0
    assert bench.survivors() == []


def _children(run: ControlledRun) -> str:
    import psutil

    found = []
    for one in psutil.Process(run.process.pid).children(recursive=True):
        try:
            found += one.cmdline()
        except psutil.NoSuchProcess:
            continue
    return " ".join(found)
