"""Processes on robots as units of systemd: lines, states, restarts, no traces."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path

import pytest

from launcher.hosts.engine.systemd.host_facts import hello, read_facts
from launcher.hosts.engine.systemd.scripts import Scripts
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.file.order import Order
from tests.hosts.lab.systemd.conftest import (
    COUNT,
    SCREEN,
    Start,
    assert_no_traces,
    launch_file,
    pid_there,
    systemctl,
)
from tests.support.hosts import Lab, Robot
from tests.support.hosts.remote_run import RemoteRun
from tests.support.waiting import wait_until


def test_a_process_runs_there_and_leaves_nothing(robot: Robot, start: Start, user: str):
    script = "echo I am $(id -un) on $(hostname) in $HOME; echo warning >&2; exit 3"
    run = start(("talker", script), user=user)

    assert run.wait() == 1
    home = "/root" if user == "root" else "/home/robot"
    assert f"[talker-1] I am {user} on bot1 in {home}\n[talker-1] warning\n" in run.text
    assert "exit code 3" in run.text
    assert_no_traces(robot, user)


def test_the_end_of_a_run_names_what_is_left_and_spares_other_runs(robot: Robot):
    facts = read_facts(robot.run(["sh", "-c", hello(Host("bot1", "b"))]).stdout)
    mine, other = (Scripts(run, Host("bot1", "b"), facts) for run in ("mine", "other"))
    order = Order(name="a@b c-1", label="a", words=(("/bin/sleep",), ("1000",)), environment={})
    for scripts in (mine, other):
        robot.run(["sh", "-c", f"{scripts.prepare()}\n{scripts.files(1, order)}"])
        robot.run(["sh", "-c", scripts.start(1, order, "t")])

    assert systemctl(robot, "root", "list-units", "--no-legend", "launcher.slice") == ""
    found = robot.run(["sh", "-c", mine.finish([order.name], "me", at_once=False)]).stdout
    assert found == mine.unit(order.name) + "\n"
    assert mine.unit(order.name) not in systemctl(robot, "root", "list-units", "launcher*")
    shown = systemctl(robot, "root", "show", "-p", "ActiveState", other.unit(order.name))
    assert shown == "ActiveState=active\n"
    robot.run(["sh", "-c", other.finish([order.name], "me", at_once=True)])
    assert_no_traces(robot, "root")


def test_a_budget_counts_the_memory_of_all_processes_of_a_unit(
    robot: Robot, start: Start, user: str
):
    hungry = "python3 -c 'import time; kept = bytearray(60_000_000); time.sleep(1000)' & wait"
    budget = ("--budget", "hungry:memory=40M,for=0.1,action=stop-run")
    run = start(("hungry", hungry), user=user, options=budget)

    assert run.wait() == 1
    uses = r"hungry-1 uses (\d+\.\d) MiB \(USS\), more than its budget of 40"
    found = re.search(uses, run.text)
    assert found, run.text
    assert 40 < float(found[1]) < 80  # measured while the array grows, or after
    assert_no_traces(robot, user)


def test_every_line_and_byte_comes(robot: Robot, start: Start, user: str):
    script = r"printf 'caf\351 \033[1mbold\033[0m\n'; head -c 60000 /dev/zero | tr '\0' x; echo"
    run = start(("talker", f"{script}; seq 20000; printf unfinished"), user=user)

    assert run.wait() == 0
    text = run._screen.read_bytes()
    assert b"[talker-1] caf\xe9 " in text
    assert b"x" * 60000 in text
    assert run.numbers("talker-1") == list(range(1, 20001))
    assert "[talker-1] unfinished\n" in run.text


def test_a_process_that_exits_at_once_is_heard(start: Start, user: str):
    names = [f"p{number}" for number in range(12)]
    run = start(*((name, f"echo {name} was here") for name in names), user=user)

    assert run.wait() == 0
    for number, name in enumerate(names):
        assert f"[{name}-{number + 1}] {name} was here\n" in run.text


def test_names_of_any_kind_and_length(robot: Robot, start: Start):
    names = ["ü", "a b", "50%n", "x" * 300]
    script = "echo hello {}; until test -e /run/seen; do sleep 0.1; done"
    run = start(*((name, script.format(n)) for n, name in enumerate(names)))

    run.wait_for("process started with pid", len(names))
    shown = systemctl(robot, "root", "show", "-p", "Description", "launcher-*-3.service")
    robot.run(["touch", "/run/seen"])
    assert shown.startswith("Description=50%n-3 of launcher run ")
    assert run.wait() == 0
    robot.run(["rm", "/run/seen"])
    for number, name in enumerate(names):
        assert f"[{name}-{number + 1}] hello {number}\n" in run.text


def test_the_environment_arrives_whatever_is_in_it(start: Start, user: str):
    values = {
        "NEWLINE": "one\ntwo",
        "QUOTES": "a 'b' \"c\" `d` \\",
        "DOLLAR": "$HOME ${X} %n $$",
        "CONTROL": "\x1b[1m\r\x01",
        "UMLAUT": "grün ☃",
        "EMPTY": "",
    }
    command = "; ".join(
        f'echo "{name}=$(printf %s "${name}" | od -An -v -tx1 | tr -d " \\n")"' for name in values
    )
    run = start(("shows", command, SCREEN, f"additional_env={values!r}"), user=user)

    assert run.wait() == 0
    for name, value in values.items():
        assert f"[shows-1] {name}={value.encode().hex()}\n" in run.text


def test_streams_are_told_apart_where_somebody_asks(start: Start, tmp_path: Path):
    script = "echo out; echo err >&2"
    run = start(("two", script, "output={'stdout': 'log', 'stderr': 'screen'}"))

    assert run.wait() == 0
    assert "[two-1] err\n" in run.text
    assert "[two-1] out\n" not in run.text


def test_standard_input(lab: Lab, start: Start):
    run = start(("reader", "read line; echo got $line"))
    run.wait_for("process started")
    assert lab.operator.launcher("send", "reader", "some words").returncode == 0
    run.wait_for(r"^\[reader-1\] got some words$")
    assert run.wait() == 0


def test_a_signal_that_is_lost_with_the_link_is_told(lab: Lab, robot: Robot, start: Start):
    run = start(("counter", f"trap 'echo got' USR1; {COUNT}"))
    run.wait_for(r"\] 3$")
    robot.link_down()
    assert lab.operator.launcher("kill", "counter", "-s", "USR1").returncode == 0
    run.wait_for("counter-1: SIGUSR1 may not have arrived: the link was lost meanwhile")
    robot.link_up()
    run.wait_for("bot1 is reachable again")
    assert run.interrupt() == 0, run.text


def test_systemd_restarts_it_and_a_user_ends_it(lab: Lab, robot: Robot, start: Start, user: str):
    run = start(("counter", COUNT, SCREEN, "respawn=True", "respawn_delay=0.5"), user=user)
    run.wait_for(r"\] 3$")
    systemctl(robot, user, "kill", "--signal=KILL", "launcher-*-counter-1.service")
    run.wait_for("process started with pid", 2)
    assert "SIGKILL" in run.text
    assert "restart 1 in 0.5 s" in run.text
    assert lab.operator.launcher("kill", "counter", "-s", "INT").returncode == 0
    run.wait_for("process was stopped")
    assert lab.operator.launcher("start", "counter").returncode == 0
    run.wait_for("process started with pid", 3)
    assert run.interrupt() == 0, run.text
    assert_no_traces(robot, user)


def test_restarts_end_where_the_policy_says(robot: Robot, start: Start):
    run = start(("mad", "echo mad; exit 7", SCREEN, "respawn=True", "respawn_max_retries=2"))

    assert run.wait() == 1
    assert run.text.count("[mad-1] mad\n") == 3
    assert_no_traces(robot, "root")


def test_a_stop_ends_what_waits_for_its_restart(robot: Robot, start: Start, user: str):
    slow = "trap 'sleep 3; exit 0' INT; echo ready; while :; do sleep 0.1; done"
    more = (SCREEN, "respawn=True", "respawn_delay=1.0")
    run = start(("slow", slow), ("mad", "echo up; exit 1", *more), user=user)
    run.wait_for("ready")
    run.wait_for("restart 1 in 1 s")
    assert run.interrupt() in (0, 130), run.text
    assert run.text.count("[mad-2] up\n") == run.text.count("[mad-2]: process started")
    assert_no_traces(robot, user)


def test_a_stop_on_the_robot_is_a_stop_by_a_user(lab: Lab, robot: Robot, start: Start):
    run = start(("counter", COUNT, SCREEN, "respawn=True"))
    run.wait_for(r"\] 3$")
    systemctl(robot, "root", "stop", "launcher-*-counter-1.service")
    run.wait_for("process was stopped|finished cleanly")
    assert "stopped" in lab.operator.launcher("ps").stdout
    assert run.interrupt() == 0


def test_a_stop_on_the_robot_of_what_waits_for_its_restart(
    lab: Lab, robot: Robot, start: Start, user: str
):
    more = (SCREEN, "respawn=True", "respawn_delay=900.0")
    run = start(("mad", "exit 1", *more), user=user)
    run.wait_for("restart 1 in 900 s")
    systemctl(robot, user, "stop", "launcher-*-mad-1.service")
    wait_until(lambda: "stopped" in lab.operator.launcher("ps").stdout, "it is stopped")
    assert "systemd does not restart it" not in run.text
    assert run.interrupt() == 0, run.text


def test_processors_that_a_robot_does_not_have_are_refused(start: Start):
    run = start(("picky", "true", SCREEN), options=("--cpus", "picky=1023"))
    assert run.wait() == 1
    assert "[picky-1]: process could not be started: cpus=1023: Invalid argument" in run.text


def test_a_stubborn_process_is_killed(robot: Robot, start: Start):
    script = "trap '' INT TERM; echo ready; while :; do sleep 0.1; done"
    more = (SCREEN, "sigterm_timeout='0.3'", "sigkill_timeout='0.3'")
    run = start(("stubborn", script, *more))
    run.wait_for("ready")
    assert run.interrupt() == 130
    assert "escalating to 'SIGTERM'" in run.text
    assert "escalating to 'SIGKILL'" in run.text
    assert_no_traces(robot, "root")


@pytest.mark.parametrize("kind", ["robot", "host"])
def test_the_host_decides_on_the_engine(lab: Lab, robot: Robot, tmp_path: Path, kind: str):
    host = robot if kind == "robot" else lab.host("plain")
    lab.hosts_file(tmp_path / "hosts.yaml", [host], {"*": host.name})
    script = 'test -n "$INVOCATION_ID" && echo a unit || echo no unit'
    (tmp_path / "t.launch.py").write_text(launch_file((("asks", script),)), encoding="utf-8")

    with RemoteRun(lab, tmp_path / "screen", "t.launch.py", "--hosts", "hosts.yaml") as run:
        assert run.wait() == 0
    assert f"[asks-1] {'a unit' if kind == 'robot' else 'no unit'}\n" in run.text


def test_a_host_without_systemd_refuses_it(lab: Lab, tmp_path: Path):
    host = lab.hosts.get("plain") or lab.host("plain")
    lab.hosts_file(tmp_path / "hosts.yaml", {host: {"engine": "systemd"}}, {"*": host.name})
    (tmp_path / "t.launch.py").write_text(launch_file((("none", "true"),)), encoding="utf-8")

    with RemoteRun(lab, tmp_path / "screen", "t.launch.py", "--hosts", "hosts.yaml") as run:
        assert run.wait() == 1
    assert "set `engine: ssh` for it in the hosts file" in run.text


def test_enabled_processes_start_at_boot_and_are_removed(
    lab: Lab, robot: Robot, tmp_path: Path, user: str
):
    secret = {"API_TOKEN": "s3 $cret"}
    settings = {"user": user, "engine": "systemd", "environment": secret}
    lab.hosts_file(tmp_path / "hosts.yaml", {robot: settings}, {"*": robot.name})
    script = 'echo "token $API_TOKEN"; exec sleep 1000'
    # Not by its line: systemd's journal may not know the unit of a process that has exited.
    processes = (("sleeps", script), ("brief", 'echo once >> "$HOME/brief-runs"'))
    (tmp_path / "boots.launch.py").write_text(launch_file(processes), encoding="utf-8")
    launch = ("boots.launch.py", "--hosts", "hosts.yaml")
    unit = "launcher-boots-sleeps.service"

    enabled = lab.operator.launcher(*launch, "--enable", "--discovery=server", cwd=tmp_path)
    assert enabled.returncode == 0, enabled.stderr
    assert "not installed: --discovery: discovery server: " in enabled.stderr
    field = "_SYSTEMD_UNIT" if user == "root" else "_SYSTEMD_USER_UNIT"
    read = ["journalctl", "--boot", "--output=cat", f"{field}={unit}"]
    home = "/root" if user == "root" else "/home/robot"

    def brief_runs() -> int:
        return robot.run(["cat", f"{home}/brief-runs"], check=False).stdout.count("once\n")

    for boot in (1, 2):
        wait_until(lambda boot=boot: brief_runs() >= boot, "the short one has run")
        wait_until(lambda: systemctl(robot, user, "is-active", unit) == "active\n", "it runs")
        wait_until(lambda: "token s3 $cret\n" in robot.run(read).stdout, "its line")
        assert "s3" not in systemctl(robot, user, "cat", unit)
        assert brief_runs() == boot
        robot.power_off()
        robot.power_on()
    with RemoteRun(lab, tmp_path / "screen", *launch) as run:
        run.wait_for("bot1: launcher-boots.target is installed there")
        run.interrupt()
    skipped = lab.operator.launcher(*launch, "--disable", "--skip-host=bot1", cwd=tmp_path)
    assert (skipped.stdout, skipped.returncode) == ("bot1: skipped; left as it is\n", 0)
    assert systemctl(robot, user, "is-active", unit) == "active\n"
    disabled = lab.operator.launcher(*launch, "--disable", cwd=tmp_path)
    assert disabled.returncode == 0, disabled.stderr
    assert systemctl(robot, user, "list-units", "--all", "--no-legend", "launcher-boots*") == ""
    found = robot.run(["find", "/etc", "/home/robot/.config", "-name", "launcher*"], check=False)
    assert [line for line in found.stdout.splitlines() if "boots" in line] == []


def test_what_fails_at_once_is_not_told_to_be_started(lab: Lab, robot: Robot, tmp_path: Path):
    lab.hosts_file(tmp_path / "hosts.yaml", {robot: {"user": "root"}}, {"*": robot.name})
    processes = (("lost", "sleep 1000", "cwd='/missing'"),)
    (tmp_path / "lost.launch.py").write_text(launch_file(processes), encoding="utf-8")
    launch = ("lost.launch.py", "--hosts", "hosts.yaml")

    enabled = lab.operator.launcher(*launch, "--enable", cwd=tmp_path)
    assert enabled.returncode == 1
    assert "cannot install units: launcher-lost-lost.service has failed" in enabled.stderr
    assert lab.operator.launcher(*launch, "--disable", cwd=tmp_path).returncode == 0
    assert systemctl(robot, "root", "list-units", "--all", "--no-legend", "launcher-lost*") == ""


def test_a_full_disk_for_the_journal_loses_lines_and_no_states(
    robot: Robot, start: Start, tmp_path: Path
):
    run = start(("counter", COUNT, SCREEN, "respawn=True", "respawn_delay=0.2"))
    run.wait_for(r"\] 3$")
    robot.full_disk("/var/log/journal")
    robot.run(["systemctl", "restart", "systemd-journald"])
    try:
        pid = pid_there(robot, COUNT)
        os.kill(pid, signal.SIGKILL)
        run.wait_for("process started with pid", 2)
    finally:
        robot.free_disk("/var/log/journal")
        robot.run(["systemctl", "restart", "systemd-journald"])
    assert run.interrupt() in (0, 130)
    assert_no_traces(robot, "root")


def test_a_flood_comes_completely_and_before_the_exits(start: Start):
    script = "seq 60000"
    run = start(*((f"p{number}", script) for number in range(3)))

    assert run.wait() == 0, run.text[-3000:]
    for number in range(3):
        assert run.numbers(f"p{number}-{number + 1}") == list(range(1, 60001))
        _, _, after = run.text.partition(f"[p{number}-{number + 1}]: process has finished")
        assert f"[p{number}-{number + 1}] " not in after


def test_output_of_a_child_that_ended_before_the_journal_looked_comes(robot: Robot, start: Start):
    """The journal looks up the unit of who has written, and of users' units it is told none."""
    journal = pid_there(robot, "systemd-journald")
    os.kill(journal, signal.SIGSTOP)
    try:
        run = start(("counter", "seq 300; : > /tmp/done; exec sleep 1000"), user="robot")
        is_done = ["test", "-e", "/tmp/done"]
        wait_until(lambda: robot.run(is_done, check=False).returncode == 0, "all is written")
    finally:
        os.kill(journal, signal.SIGCONT)
    run.wait_for(r"^\[counter-1\] 300$")

    assert run.interrupt() == 0
    assert run.numbers("counter-1") == list(range(1, 301))
    assert "launcher: output of" not in run.text


def test_a_flood_of_a_user_is_told_to_be_more_than_the_journal_takes(start: Start):
    run = start(("flood", "seq 30000"), user="robot")

    assert run.wait() == 0
    assert "set RateLimitBurst=0" in run.text
