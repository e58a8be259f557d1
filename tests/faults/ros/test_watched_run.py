"""Real runs that are watched: what is found, and what survives the death of the watcher."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import pytest

from tests.smoke.process.bench import talking
from tests.support.benches import ControlBench
from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

WATCHER, PROBE = "launcher.faults.watcher", "launcher.ros.probe"
IDLE = 'sh("exec sleep 1000", name="idle"), sh("exec sleep 1000", name="patient")'


def faults(run: ControlledRun) -> dict[str, Any]:
    return {one["fault"]: one for one in run.ask("faults")["faults"]}


def wait_for_fault(run: ControlledRun, name: str, state: str = "active") -> dict[str, Any]:
    found: dict[str, Any] = {}

    def is_there() -> bool:
        found.update(faults(run).get(name, {}))
        return found.get("state") == state and (state != "active" or found["incident"] is not None)

    wait_until(is_there, f"{name} {state}; screen:\n{run.screen}")
    return found


def helper(run: ControlledRun, module: str, but: int = 0) -> int:
    """The pid of the watcher, or of the probe below it."""
    found: list[int] = []

    def is_there() -> bool:
        parents = [run.process.pid, *(one.pid for one in children_with(run.process.pid, WATCHER))]
        those = [one.pid for parent in parents for one in children_with(parent, module)]
        found[:] = [pid for pid in those if pid != but]
        return bool(found)

    wait_until(is_there, module)
    return found[0]


def begun(run: ControlledRun) -> None:
    """When the watch looks at what happens."""
    wait_until(lambda: run.ask("faults")["watching"], "the watch")
    helper(run, PROBE)


def log_of(run: ControlledRun) -> list[dict[str, Any]]:
    with run.connect() as connection:
        folder = connection.hello["run"]["log_dir"]
    lines = Path(folder, "events.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


@pytest.mark.thorough
def test_processes_without_ros_and_the_end_of_the_run(control_bench: ControlBench):
    with control_bench.launch(IDLE, "--watchful") as run:
        begun(run)
        assert run.shell("faults", "--check").returncode == 0
        os.kill(run.row("patient")["pid"], signal.SIGSTOP)
        suspended = wait_for_fault(run, "not suspended: patient-2")
        assert suspended["cause"] == "patient-2 is suspended (SIGSTOP)"
        os.kill(run.row("patient")["pid"], signal.SIGCONT)
        wait_for_fault(run, "not suspended: patient-2", "healed")
        os.kill(run.row("idle")["pid"], signal.SIGKILL)
        died = wait_for_fault(run, "no deaths: idle-1")
        assert (died["cause"], died["rule"]) == ("idle-1 died (SIGKILL)", "death")
        assert run.shell("faults", "--check").returncode == 1

        watcher = helper(run, WATCHER)
        os.kill(watcher, signal.SIGKILL)  # a new one goes on
        again = helper(run, WATCHER, but=watcher)
        helper(run, PROBE)
        run.ask("restart", "idle")
        wait_for_fault(run, "no deaths: idle-1", "healed")
        os.kill(run.row("patient")["pid"], signal.SIGKILL)
        second = wait_for_fault(run, "no deaths: patient-2")
        assert second["incident"] > died["incident"]
        wait_until(lambda: "no deaths: patient-2" in confirmed(run), "its entry in the event log")
        events = [one for one in log_of(run) if one["event"].startswith("fault")]
        assert [(one["event"], one["fault"]) for one in events] == [
            ("fault", "not suspended: patient-2"),
            ("fault healed", "not suspended: patient-2"),
            ("fault", "no deaths: idle-1"),
            ("fault healed", "no deaths: idle-1"),
            ("fault", "no deaths: patient-2"),
        ]
        with run.connect() as connection:
            folder = Path(connection.hello["run"]["log_dir"])
        run.process.send_signal(signal.SIGINT)
        run.process.wait(60)
        ends = [json.loads(line) for line in (folder / "events.jsonl").open(encoding="utf-8")]
        assert sum(one["event"].startswith("fault") for one in ends) == len(events)
        assert not Path(f"/proc/{again}").exists()
        incident = json.loads((folder / "incidents" / f"{second['incident']}.json").read_text())
        assert incident["faults"][0]["fault"] == "no deaths: patient-2"


def confirmed(run: ControlledRun) -> list[str]:
    """The faults in the event log, which is written a moment later."""
    return [one["fault"] for one in log_of(run) if one["event"] == "fault"]


@pytest.mark.thorough
def test_nodes_of_ros_and_the_death_of_the_probe(control_bench: ControlBench, tmp_path: Path):
    expect = tmp_path / "fleet.expect.yaml"
    expect.write_text("expect: [{rate: /steady, is: 3 to 12 Hz, name: steady}]\n", encoding="utf-8")
    with control_bench.launch(f"{talking()} {IDLE}", "--expect", str(expect)) as run:
        begun(run)
        mismatch = wait_for_fault(run, "QoS: /drifting")  # of the node, with itself
        assert "reliability is BEST_EFFORT, but RELIABLE is requested" in mismatch["cause"]

        probe = helper(run, PROBE)
        os.kill(probe, signal.SIGKILL)
        helper(run, PROBE, but=probe)
        pid = run.row("talker")["pid"]
        wait_until(lambda: "is started again" in run.screen, "the note")
        os.kill(pid, signal.SIGKILL)
        died = wait_for_fault(run, "no deaths: talker-1")
        silent = wait_for_fault(run, "steady")
        assert silent["follows"] == "no deaths: talker-1" and silent["incident"] == died["incident"]
        wait_until(lambda: confirmed(run).count("steady") == 1, "its entry in the event log")
        run.ask("restart", "talker")
        wait_for_fault(run, "steady", "healed")
        os.kill(run.row("talker")["pid"], signal.SIGSTOP)
        wait_for_fault(run, "steady")
        run.process.send_signal(signal.SIGINT)  # during a fault
        assert run.process.wait(60) is not None
        assert not children_with(run.process.pid, WATCHER)


def test_mistakes_in_expectations_are_refused_before_anything_starts(
    control_bench: ControlBench, tmp_path: Path
):
    expect, proof = tmp_path / "bad.expect.yaml", tmp_path / "started"
    expect.write_text("expect: [{rate: /t, is: quick}, {no_such: x}]\n", encoding="utf-8")
    done = control_bench.run(f'sh("touch {proof}", name="one")', "--expect", str(expect))

    assert done.returncode == 2, done.stderr
    assert b"bad.expect.yaml" in done.stderr and not proof.exists()
