"""The doctor on the real machine: what it finds, repairs and leaves alone."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from launcher.packages.distribution import title
from launcher.posix.domain_lease import leased_domain
from launcher.run.monitor.shared_memory import FOLDER, free, held
from tests.support import ended_main_thread
from tests.support.benches import MARK, Bench
from tests.support.children import children_with, is_alive
from tests.support.waiting import wait_until

pytestmark = pytest.mark.alone

NODE = "import rclpy; rclpy.init(); n = rclpy.create_node('n'); print('ready', flush=True); input()"


def doctor(
    *words: str, prefix: tuple[str, ...] = (), **env: str | None
) -> tuple[int, dict[str, dict[str, str]], list[str]]:
    """(exit code, findings by name, what was done); an environment value of None is unset."""
    merged = {**os.environ, **env}
    result = subprocess.run(
        [*prefix, sys.executable, "-m", "launcher", "doctor", "--json", *words],
        env={name: value for name, value in merged.items() if value is not None},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode in (0, 1), result.stderr
    report = json.loads(result.stdout)
    assert report["well"] == (result.returncode == 0)
    return result.returncode, {f["check"]: f for f in report["findings"]}, report["fixed"]


def test_this_environment_is_found_to_be_in_order():
    _, found, done = doctor()
    in_order = ("ROS 2", "wheels", "library path", "AMENT_PREFIX_PATH", "launcher", "log folder")
    assert [found[name]["level"] for name in in_order] == ["ok"] * 6, found
    assert found["ROS 2"]["text"] == title()
    assert done == []


@pytest.mark.parametrize(
    ("name", "env", "text"),
    [
        ("AMENT_PREFIX_PATH", {"AMENT_PREFIX_PATH": "/gone/away"}, "/gone/away does not exist"),
        ("ROS 2", {"ROS_DISTRO": "moonshot"}, "ROS_DISTRO is moonshot, but the rclpy in "),
        ("ROS_DOMAIN_ID", {"ROS_DOMAIN_ID": "abc"}, "'abc' is not a domain id"),
        ("log folder", {"ROS_LOG_DIR": f"{__file__}/log"}, "test_doctor.py is not a folder"),
        ("log folder", {"ROS_LOG_DIR": None, "ROS_HOME": "/proc"}, "/proc/log cannot be written"),
        ("environment", {"FASTRTPS_DEFAULT_PROFILES_FILE": "/gone.xml"}, "/gone.xml: No such file"),
        ("environment", {"RMW_IMPLEMENTATION": "rmw_x"}, "a middleware that is not installed"),
    ],
)
def test_a_spoilt_environment_is_a_problem(name: str, env: dict[str, str], text: str):
    code, found, _ = doctor(**env)
    assert (code, found[name]["level"]) == (1, "problem")
    assert text in found[name]["text"]


def test_it_works_without_psutil_and_reports_that(tmp_path: Path):
    (tmp_path / "psutil.py").write_text("raise ModuleNotFoundError(\"No module named 'psutil'\")")
    command = [sys.executable, "-c", NODE]
    with leased_domain() as domain:
        env = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        with subprocess.Popen(command, env=env, **pipes) as node:
            assert node.stdout is not None
            assert node.stdout.readline() == b"ready\n"
            code, found, _ = doctor(PYTHONPATH=str(tmp_path), ROS_DOMAIN_ID=str(domain))
            node.kill()
    assert (code, found["wheels"]["level"]) == (1, "problem")
    assert found["wheels"]["advice"] == "pip install psutil"


def test_loopback_that_is_down_is_a_problem():
    """As in a network namespace that nobody has set up."""
    code, found, _ = doctor(prefix=("unshare", "--map-root-user", "--net"))
    assert (code, found["loopback"]["level"]) == (1, "problem")
    assert "127.0.0.1 cannot be reached (Network is unreachable)" in found["loopback"]["text"]
    _, found, _ = doctor()
    assert found["loopback"]["level"] == "ok"


def test_libraries_that_were_dropped_on_the_way_are_explained():
    code, found, _ = doctor(LD_LIBRARY_PATH=None, _ROS_WHEELS_BOOTSTRAP_COMPLETE="1")
    assert code == 1
    assert "cannot open shared object file" in found["wheels"]["text"]
    assert "LD_LIBRARY_PATH is gone" in found["library path"]["text"]


def test_what_a_killed_node_left_is_found_and_freed(tmp_path: Path):
    with leased_domain() as domain_id:
        env = {**os.environ, "ROS_DOMAIN_ID": str(domain_id), "ROS_LOG_DIR": str(tmp_path)}
        command = [sys.executable, "-c", NODE]
        pipe = subprocess.PIPE
        with subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe) as node:
            assert node.stdout.readline() == b"ready\n"
            names = {n for n, pid in held().items() if pid == node.pid and "_port" not in n}
            doctor("--fix")
            assert names and all((Path(FOLDER) / name).exists() for name in names)
            node.kill()
        assert doctor()[1]["stale shared memory"]["level"] == "problem"
        _, found, done = doctor("--fix")
        assert not any((Path(FOLDER) / name).exists() for name in names), (found, done)
        free(names)


def test_a_node_whose_files_were_removed_is_named(tmp_path: Path):
    with leased_domain() as domain_id:
        env = {**os.environ, "ROS_DOMAIN_ID": str(domain_id), "ROS_LOG_DIR": str(tmp_path)}
        pipe = subprocess.PIPE
        with subprocess.Popen(
            [sys.executable, "-c", NODE], env=env, stdin=pipe, stdout=pipe
        ) as node:
            assert node.stdout.readline() == b"ready\n"
            assert f"[{node.pid}]" not in doctor()[1]["unreachable nodes"]["text"]
            for name in {n for n, pid in held().items() if pid == node.pid and "_port" not in n}:
                (Path(FOLDER) / name).unlink()
                (Path(FOLDER) / f"{name}_el").unlink()
            code, found, _ = doctor()
            node.communicate(b"\n")
    assert (code, found["unreachable nodes"]["level"]) == (1, "problem")
    assert f"[{node.pid}]" in found["unreachable nodes"]["text"]


LEFT = 'sh("echo ready; sleep 100; :"), sh("trap \'\' INT; sleep 100; :"), '
LEFT += f'ExecuteProcess(cmd=[sys.executable, "{ended_main_thread.PROGRAM}"], output="screen"), '
# Has neither the run id nor the session, but a parent that has.
LEFT += f'sh("env -i {MARK}=${MARK} setsid sleep 100; :")'


def test_processes_of_a_run_whose_launcher_and_watchdog_were_killed_are_ended(bench: Bench):
    bench.env["LAUNCHER_CGROUP"] = "none"
    launcher = bench.terminal(LEFT, "--no-console")
    launcher.wait_for("ready")
    launcher.wait_for("ready")
    wait_until(
        lambda: sum(one.startswith("sleep 100 ") for one in bench.survivors()) == 3, "all sleep"
    )
    watchdog = wait_for_watchdog(launcher.pid)
    watchdog.suspend()
    launcher.kill()
    watchdog.kill()
    wait_until(lambda: not is_alive(watchdog.pid), "the watchdog is gone")
    wait_until(lambda: len(bench.survivors()) == 7, "three shells, what they run, and the other")
    left = bench.survivors()
    _, found, _ = doctor()
    assert found["leftover processes"]["level"] == "problem"
    assert bench.survivors() == left
    _, _, done = doctor("--fix")
    assert any("stopping leftover processes" in sentence for sentence in done)
    assert bench.survivors() == []


def wait_for_watchdog(pid: int) -> psutil.Process:
    def watchdogs() -> list[psutil.Process]:
        return children_with(pid, "watchdog.py")

    wait_until(watchdogs, "the watchdog runs")
    return watchdogs()[0]


def test_a_run_that_lives_is_left_alone(bench: Bench):
    launcher = bench.terminal('sh("echo ready; while :; do sleep 0.05; done")')
    launcher.wait_for("ready")
    doctor("--fix")
    (child,) = (p for p in psutil.Process(launcher.pid).children() if p.name() == "sh")
    assert child.is_running()
    launcher.signal(signal.SIGINT)
    assert launcher.exit_code() == 0
