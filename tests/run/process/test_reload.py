"""A launch file that is changed and evaluated again while its processes run."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

import pytest

from launcher.control.client import RefusedError
from tests.support.benches import ControlBench
from tests.support.controlled_run import TIMEOUT_S, ControlledRun, state_of
from tests.support.waiting import wait_until

SLEEP = 'sh("exec sleep {}", name="{}")'
A, B, C = (SLEEP.format(1000 + number, name) for number, name in enumerate("abc"))


def edit(bench: ControlBench, run: ControlledRun, actions: str) -> Sequence[str]:
    """Write the launch file again, when the run has read it."""
    assert run.socket
    return bench.command(actions)


def changes(run: ControlledRun, **options: Any) -> dict[str, str]:
    found = run.ask("reload", **options)["processes"]
    return {one["name"]: one["change"] for one in found}


def pids(run: ControlledRun) -> dict[str, int | None]:
    return {row["name"]: row["pid"] for row in run.ask("ps")["processes"]}


def test_only_what_has_changed_is_touched(control_bench: ControlBench):
    with control_bench.launch(f"{A}, {B}, {C}") as run:
        before = pids(run)
        assert set(changes(run).values()) == {"same"}
        assert pids(run) == before

        edit(control_bench, run, f"{SLEEP.format(7, 'new')}, {C}, {SLEEP.format(8, 'b')}")
        expected = {"c-3": "same", "b-2": "changed", "a-1": "gone", "new-4": "new"}
        assert changes(run, dry_run=True) == expected
        assert pids(run) == before, "a dry run has changed something"
        assert changes(run) == expected

        after = pids(run)
        assert list(after) == ["b-2", "c-3", "new-4"]
        assert after["c-3"] == before["c-3"]
        assert after["b-2"] not in before.values()
        assert not state_of(before["a-1"]) and not state_of(before["b-2"])
        assert "new-4" in run.ask_text("plan")
        run.ask_text("quit")
        assert run.exit_code() == 0


def test_a_process_that_comes_back_gets_a_number_of_its_own(control_bench: ControlBench):
    with control_bench.launch(f"{A}, {B}") as run:
        edit(control_bench, run, A)
        assert changes(run) == {"a-1": "same", "b-2": "gone"}
        edit(control_bench, run, f"{B}, {A}")
        assert changes(run) == {"b-3": "new", "a-1": "same"}


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ("(", "bench.launch.py:21: closing parenthesis"),
        pytest.param(
            "no_such_name", "name 'no_such_name' is not defined", marks=pytest.mark.thorough
        ),
        ("ExecuteProcess(cmd=['true'], env={1: 2})", "bench.launch.py:20: an int where a text"),
    ],
)
def test_an_error_in_the_launch_file_changes_nothing(
    control_bench: ControlBench, wrong: str, says: str
):
    with control_bench.launch(A) as run:
        before = pids(run)
        edit(control_bench, run, f"{A},\n{wrong}")
        with pytest.raises(RefusedError) as error:
            run.ask("reload")
        assert error.value.code == "bad-launch-file"
        assert says in error.value.render()
        assert pids(run) == before
        edit(control_bench, run, f"{A}, {B}")
        assert changes(run) == {"a-1": "same", "b-2": "new"}


def test_handlers_of_the_new_file_act_and_those_of_the_old_one_do_not(
    control_bench: ControlBench,
):
    handled = """one := sh("exec sleep 1000", name="one", respawn=True),
        RegisterEventHandler(OnProcessExit(target_action=one, on_exit=[LogInfo(msg="{}")]))"""
    with control_bench.launch(handled.format("old handler")) as run:
        edit(control_bench, run, handled.format("new handler"))
        assert changes(run) == {"one-1": "same"}
        run.ask("kill", "one", signal=9, as_crash=True)
        run.wait_for("new handler")
        assert "old handler" not in run.screen


def test_on_exit_of_a_process_that_is_restarted_does_not_end_the_run(
    control_bench: ControlBench,
):
    one = 'sh("exec sleep {}", name="one", on_exit=Shutdown())'
    with control_bench.launch(one.format(1000)) as run:
        edit(control_bench, run, one.format(2000))
        assert changes(run) == {"one-1": "changed"}
        assert run.row("one")["state"] == "RUNNING"
        run.ask("kill", "one", signal=9, as_crash=True)
        assert run.exit_code() == 1  # now it has exited by itself


def test_timers_count_from_the_start_of_the_run(control_bench: ControlBench):
    timed = 'TimerAction(period={}, actions=[sh("exec sleep 1000", name="{}")])'
    with control_bench.launch(f"{A}, {timed.format(0.1, 'past')}") as run:
        wait_until(lambda: "past-2" in pids(run), "the timer")
        before = pids(run)
        later = f"{timed.format(0.1, 'past')}, {timed.format(0.2, 'missed')}"
        edit(control_bench, run, f"{A}, {later}, {timed.format(600.0, 'future')}")
        wait_until(lambda: "missed" in run.ask_text("reload", dry_run=True), "0.2 s of the run")
        assert changes(run) == {"a-1": "same", "past-2": "same", "missed-3": "new"}
        assert before.items() <= pids(run).items()


def test_what_an_exit_has_started_runs_on(control_bench: ControlBench):
    actions = """first := sh("exit 0", name="first"), {}
        RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[
            sh("exec sleep 1000", name="second")]))"""
    with control_bench.launch(actions.format(f"{A},")) as run:
        wait_until(lambda: "second-3" in pids(run), "the second process")
        before = pids(run)
        edit(control_bench, run, actions.format(f"{B}, {A},"))
        assert changes(run)["second-3"] == "same"
        assert before.items() <= pids(run).items()


def test_a_process_that_a_user_has_stopped_stays_stopped(control_bench: ControlBench):
    with control_bench.launch(f"{A}, {B}") as run:
        run.ask("stop", "b")
        edit(control_bench, run, f"{A}, {SLEEP.format(77, 'b')}")
        assert changes(run) == {"a-1": "same", "b-2": "changed"}
        assert run.row("b")["state"] == "STOPPED"
        run.ask("start", "b")
        assert run.ask("info", "b")["processes"][0]["cmd"][-1] == "exec sleep 77"


def test_a_policy_applies_without_a_restart(control_bench: ControlBench):
    with control_bench.launch(A) as run:
        before = pids(run)
        edit(control_bench, run, A.replace("name=", "respawn=True, name="))
        assert changes(run) == {"a-1": "changed"}
        assert pids(run) == before
        run.ask("kill", "a", signal=9, as_crash=True)
        wait_until(lambda: run.row("a")["restarts"] == 1, "the restart")


def test_a_module_beside_the_launch_file_is_imported_again(control_bench: ControlBench):
    module = control_bench.folder / "bench_settings.py"
    uses = """*(sys.path.insert(0, {!r}) or ()), *__import__("bench_settings").ACTIONS(sh)"""
    # Of another size: Python compiles no file again of the same second and size.
    module.write_text('def ACTIONS(sh): return [sh("exec sleep 500", name="one")]\n')
    with control_bench.launch(uses.format(str(control_bench.folder))) as run:
        assert run.socket
        module.write_text('def ACTIONS(sh): return [sh("exec sleep 5001", name="one")]\n')
        assert changes(run) == {"one-1": "changed"}


def test_when_nothing_is_left_the_run_ends(control_bench: ControlBench):
    with control_bench.launch(A) as run:
        edit(control_bench, run, "")
        assert changes(run) == {"a-1": "gone"}
        assert run.exit_code() == 0


def test_plan_diff_shows_what_reload_would_do(control_bench: ControlBench):
    with control_bench.launch(A) as run:
        words = edit(control_bench, run, f"{A}, {B}")

        def diff(*more: str) -> subprocess.CompletedProcess[str]:
            return subprocess.run(
                [sys.executable, "-m", "launcher", "plan", "--diff", *more],
                env=run.env,
                capture_output=True,
                text=True,
                timeout=TIMEOUT_S,
                check=False,
            )

        assert diff(words[3]).stdout.splitlines()[-1] == "the same: a-1"
        found = json.loads(diff("--json").stdout)["processes"]
        assert {one["name"]: one["change"] for one in found} == {"a-1": "same", "b-2": "new"}
        refused = diff(words[3], "x:=1")
        assert refused.returncode == 2
        assert "--diff takes no arguments: x:=1" in refused.stderr
