"""`--private`: a ROS domain that no other run has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from launcher.posix import domain_lease
from launcher.posix.domain_lease import NoFreeDomainError
from launcher.ros.discovery import free_domain as module
from launcher.ros.discovery.free_domain import free_domain
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun

SAYS = 'sh("echo domain $ROS_DOMAIN_ID; exec sleep 1000", name="says"),'
SAID = re.compile(
    r"this run has ROS domain (\d+) for itself; in other shells: export ROS_DOMAIN_ID=(\d+), "
    r"or --domain (\d+) behind a verb"
)


def domain_of(run: ControlledRun) -> int:
    run.wait_for("] domain ")
    found = SAID.search(run.screen)
    assert found is not None, run.screen
    assert len(set(found.groups())) == 1
    assert run.screen.index(found[0]) < run.screen.index("process started")
    run.wait_for(f"[says-1] domain {found[1]}\n")
    return int(found[1])


def test_processes_and_clients_have_the_domain_that_is_said(control_bench: ControlBench):
    control_bench.env["ROS_DOMAIN_ID"] = "7"
    with (
        control_bench.launch(SAYS, "--private") as one,
        control_bench.launch(SAYS, "--private") as other,
    ):
        domains = {domain_of(run) for run in (one, other)}
        assert len(domains - {7}) == 2
        for run in (one, other):
            with run.connect() as connection:
                assert connection.hello["run"]["domain_id"] == domain_of(run)


@pytest.mark.parametrize(
    ("actions", "words", "errors"),
    [
        ("", ("--hosts", "hosts.yaml"), ["--private and --hosts exclude each other"]),
        ("", ("--enable",), ["--private and --enable exclude each other"]),
        (
            'sh("true", name="other", additional_env={"ROS_DOMAIN_ID": "7"}),',
            (),
            [
                "--private does not apply: other-1 (",
                "launch.py:12) has ROS_DOMAIN_ID=7",
                "hint: leave out",
            ],
        ),
        (
            '__import__("launch").actions.SetEnvironmentVariable("ROS_DOMAIN_ID", "8"),\n'
            'sh("true", name="other"),',
            (),
            ["has ROS_DOMAIN_ID=8"],
        ),
    ],
)
def test_what_it_cannot_be_combined_with_is_refused(
    control_bench: ControlBench, actions: str, words: tuple[str, ...], errors: list[str]
):
    done = control_bench.run(actions, "--private", *words)
    text = done.stderr.decode()
    assert done.returncode == 2, text
    assert all(error in text for error in errors), text
    assert b"process started" not in done.stdout


def test_a_domain_of_a_run_or_of_other_machines_is_not_free(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(domain_lease, "_DOMAIN_IDS", range(301, 306))  # that no other test leases
    monkeypatch.setattr(module, "greetings", lambda: iter([{"domain_id": 302}, {"domain_id": 303}]))
    monkeypatch.setattr(module, "_answers", lambda domain_id: domain_id in (301, 304))
    with free_domain() as domain_id:
        assert domain_id == 305
        with pytest.raises(NoFreeDomainError), free_domain():
            pass


def test_a_script_gets_it_as_well(control_bench: ControlBench, tmp_path: Path):
    script = tmp_path / "script.py"
    script.write_text(
        "import os\n"
        "from launch import LaunchDescription, LaunchService\n"
        "from launch.actions import ExecuteProcess\n"
        "service = LaunchService()\n"
        "action = ExecuteProcess(cmd=['sh', '-c', 'echo domain $ROS_DOMAIN_ID'], output='screen')\n"
        "service.include_launch_description(LaunchDescription([action]))\n"
        "raise SystemExit(service.run())\n"
    )
    python, *_ = control_bench.command("")
    words = [python, "-m", "launcher", str(script), "--private"]
    run = ControlledRun(
        words, env=control_bench.env, runtime=control_bench.runtime, screen=tmp_path / "screen"
    )
    with run:
        assert run.exit_code() == 0
        found = SAID.search(run.screen)
        assert found is not None, run.screen
        assert f"domain {found[1]}\n" in run.screen
