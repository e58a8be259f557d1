"""Injections into real processes: what they do, and that nothing is left of them."""

from __future__ import annotations

import signal
from typing import Any

import psutil
import pytest

from launcher.control.client import RefusedError
from launcher.smoke.inject import processors
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

ACTIONS = (
    'sh("exec sleep 1000", name="first"), sh("exec sleep 1000", name="idle", respawn=True), '
    'sh("exec sleep 1000", name="other"),'
)


def active(run: ControlledRun) -> list[str]:
    found = run.ask("inject")["injections"]
    return [f"{one['name']} {one['injection']}" for one in found]


def events(run: ControlledRun, kind: str) -> list[dict[str, Any]]:
    return [one for one in run.ask("events")["events"] if one["event"] == kind]


def over(run: ControlledRun, what: str) -> dict[str, Any]:
    """The event that says that it has ended."""
    found: list[dict[str, Any]] = []

    def is_over() -> bool:
        found[:] = [one for one in events(run, "injection ended") if one["what"] == what]
        return bool(found)

    wait_until(is_over, f"the end of {what}")
    return found[-1]


def helpers(run: ControlledRun) -> list[str]:
    """Command lines of processes that injections have started."""
    lines = [" ".join(one.cmdline()) for one in children(run)]
    return [line for line in lines if "smoke.inject" in line]


def children(run: ControlledRun) -> list[psutil.Process]:
    return psutil.Process(run.process.pid).children(recursive=True)


def test_processes_are_paused_slowed_and_killed(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        run.ask("inject", "first", what="slow 10", for_s=60.0)
        row = run.row("first")
        assert (row["injected"], row["paused"]) == (["slow 10"], False)
        assert "running, injected: slow 10" in run.shell("ps").stdout
        first = psutil.Process(row["pid"])
        wait_until(lambda: first.status() == psutil.STATUS_STOPPED, "it is suspended at times")
        with pytest.raises(RefusedError, match="first-1: slow 10 is active"):
            run.ask("inject", "first", what="pause")
        run.ask("inject", "idle", what="pause", for_s=0.2)
        assert over(run, "pause")["lasted_s"] >= 0.2
        assert not run.row("idle")["paused"]
        assert active(run) == ["first-1 slow 10"]
        assert "first-1: slow 10 is over" in run.shell("inject", "--end").stdout
        assert (active(run), helpers(run)) == ([], [])
        before = run.row("idle")["pid"]
        run.ask("inject", "idle", what="kill")
        wait_until(lambda: run.row("idle")["pid"] not in (before, None), "its restart")
        (ended,) = events(run, "ended")
        assert (ended["returncode"], ended["asked"]) == (-signal.SIGKILL, False)
        assert [one["what"] for one in events(run, "injection")] == ["slow 10", "pause", "kill"]
        assert first.status() != psutil.STATUS_STOPPED


def test_what_is_taken_counts_as_the_process_and_is_given_back(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        run.ask("inject", "idle", what="memory 60M", for_s=60.0)
        wait_until(lambda: (run.row("idle")["uss_bytes"] or 0) > 60 << 20, "its memory")
        run.ask("inject", "other", what="cpu 1", for_s=60.0)
        wait_until(lambda: (run.row("other")["cpu_percent"] or 0) > 5, "its CPU")
        run.ask("inject", "machine", what="cpu 1", for_s=60.0)
        run.ask("inject", "machine", end=True)
        run.ask("kill", "idle")  # its restart policy does not apply
        assert over(run, "memory 60M")["why"] == "the process has ended"
        assert len(helpers(run)) == 2  # and its burner
        with pytest.raises(RefusedError, match="would make the kernel kill processes"):
            run.ask("inject", "other", what="memory 9999G")
        most = processors.MOST_PER_CORE * processors.usable()
        with pytest.raises(RefusedError, match=f"cpu: with the 1 of others, {most + 1} are more"):
            run.ask("inject", "other", what=f"cpu {most}")
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
        assert "injection over: cpu 1 (the run is being stopped)" in run.screen
    assert control_bench.survivors() == []


def test_what_a_user_does_meanwhile_counts(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        run.ask("inject", "first", what="slow 10", for_s=1000.0)
        run.ask("pause", "first")
        assert over(run, "slow 10")["why"] == "it was paused"
        wait_until(lambda: run.row("first")["paused"], "that it stays suspended")
        run.ask("inject", "idle", what="pause", for_s=1000.0)
        run.ask("resume", "idle")
        assert over(run, "pause")["why"] == "it was resumed"
        run.ask("inject", "other", what="slow 2", for_s=1000.0)
        (helper,) = (one for one in children(run) if "smoke.inject" in " ".join(one.cmdline()))
        helper.kill()
        assert "it failed" in over(run, "slow 2")["why"]
        wait_until(lambda: not run.row("other")["paused"], "that it runs on")
        before = children(run)
        run.ask("inject", "other", what="cpu 1", for_s=1000.0)
        next(one for one in children(run) if "smoke.inject" in " ".join(one.cmdline())).suspend()
        run.ask("inject", "other", end=True)  # it does not answer, and is killed
        wait_until(lambda: children(run) == before, "the end of all that burn")


def test_nothing_is_left_when_the_launcher_is_killed(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        for name, what in (("first", "slow 5"), ("idle", "cpu"), ("other", "pause")):
            run.ask("inject", name, what=what, for_s=1000.0)
        run.process.kill()
        wait_until(lambda: control_bench.survivors() == [], "the end of all processes")


def test_mistakes_are_explained(control_bench: ControlBench):
    with control_bench.launch(ACTIONS) as run:
        for words, says in (
            (("idle", "slwo", "4"), "unknown injection 'slwo'\nhint: did you mean 'slow'?"),
            (("idel", "pause"), "unknown process 'idel'"),
            (("pause",), "pause: a name is missing in front"),
            (("machine", "pause"), "pause is about a process"),
            (("idle", "kill", "--for", "3s"), "kill takes no time"),
            (("--end",), "nothing is injected"),
            (("idle", "pause", "--for", "0"), "--for: the time must be longer than 0 s"),
            (("machine", "cpu", "9999"), "for each processor that may be used"),
        ):
            assert says in run.shell("inject", *words).stderr


def test_a_plan_of_chaos_is_carried_out(control_bench: ControlBench):
    plan = control_bench.folder / "plan.yaml"
    plan.write_text(
        "{seed: 3, every: 0.2 s, for: 0.4 s, injections: [{inject: idle pause, for: 0.1 s}]}"
    )
    with control_bench.launch(ACTIONS, "--chaos", str(plan)) as run:
        run.wait_for("chaos: the plan is over")
        wait_until(lambda: len(events(run, "injection ended")) == 2, "both")
        assert "chaos: seed 3: 0.2 s idle pause for 0.1 s, 0.4 s idle pause for 0.1 s" in run.screen
        assert not run.row("idle")["paused"]
        assert "chaos: " not in run.screen.partition("the plan is over")[2]
    plan.write_text("{every: 1 s, injections: [{inject: idle puase}]}")
    with control_bench.launch(ACTIONS, "--chaos", str(plan)) as run:
        assert run.exit_code() == 2
        assert "unknown injection 'puase'" in run.screen
