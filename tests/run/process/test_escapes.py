"""Daemons that clear their environment and leave their session: they do not escape their run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from launcher.posix.cleanup import cgroup
from tests.support.benches import Bench
from tests.support.children import children, is_alive
from tests.support.waiting import wait_until

PID_NAMESPACE = ("unshare", "--map-root-user", "--pid", "--fork", "--mount-proc")
TRY = """
import os, sys
from launcher.posix.cleanup import cgroup
group = cgroup.make(f"{os.getpid()}-0", os.getpid(), sys.argv[1])
if group is None or not group.release(os.getpid()) or not group.remove():
    sys.exit(1)
"""
# Its parent exits at once; it holds no descriptor of the run and knows nothing of it.
ESCAPE = "setsid env -i sh -c 'echo $$ > {0}.new; mv {0}.new {0}; exec sleep 1000'"
ESCAPE += " < /dev/null > /dev/null 2>&1 & exit 0"


def is_possible(kind: str) -> bool:
    """Whether a control group of this kind can be made here."""
    return not subprocess.run([sys.executable, "-c", TRY, kind], check=False).returncode


def needs(kind: str) -> None:
    if kind in ("v1", "v2") and not is_possible(kind):
        pytest.skip(f"no control group of {kind} can be made here")


def escaped(file: Path) -> psutil.Process:
    wait_until(file.exists, "the daemon is running")
    daemon = psutil.Process(int(file.read_text()))
    wait_until(lambda: daemon.name() == "sleep", "its shell has become sleep")
    return daemon


def is_gone(process: psutil.Process) -> bool:
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


def group_of(pid: int) -> str | None:
    """The folder of the run that the process is in; None if it is in none."""
    found = [group for _, group in cgroup.groups() if pid in group.pids()]
    return found[0].path if found else None


def watchdog_of(launcher: int) -> psutil.Process:
    children = psutil.Process(launcher).children()
    return next(p for p in children if "watchdog.py" in " ".join(p.cmdline()))


def wait_until_known(launcher: int, daemon: psutil.Process, kind: str) -> None:
    """Wait until the watchdog knows the daemon."""
    wait_until(lambda: daemon.ppid() == launcher, "the launcher has adopted it")
    if kind != "none" and is_possible(kind):
        wait_until(lambda: group_of(daemon.pid) is not None, "it is in the group")
        return
    watchdog = watchdog_of(launcher)
    before = watchdog.num_ctx_switches().voluntary
    wait_until(lambda: watchdog.num_ctx_switches().voluntary > before + 2, "it has looked twice")


@pytest.mark.parametrize("kind", ["v2", "v1", "none"])
def test_an_escaped_daemon_is_killed_with_its_launcher(bench: Bench, kind: str):
    needs(kind)
    bench.env["LAUNCHER_CGROUP"] = kind
    file = bench.folder / "pid"
    run = bench.start(f'sh("{ESCAPE.format(file)}"), sh("exec sleep 1001")')
    daemon = escaped(file)
    wait_until_known(run.pid, daemon, kind)
    group = group_of(run.pid)
    run.kill()
    wait_until(lambda: is_gone(daemon), "the daemon is gone")
    wait_until(lambda: bench.survivors() == [], "nothing is left")
    assert (group is None) == (kind == "none")
    wait_until(lambda: group is None or not os.path.exists(group), "the group is gone")


def kill_in_a_namespace(file: str, kind: str, *command: str) -> None:
    """What the next test does in a pid namespace, where we are pid 1."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as run:
        daemon = escaped(Path(file))
        wait_until_known(run.pid, daemon, kind)
        watchdog = watchdog_of(run.pid)
        run.kill()
        wait_until(lambda: is_gone(daemon), "the daemon is gone")
        wait_until(lambda: is_gone(watchdog), "its group is gone, too")
    print("gone")


@pytest.mark.parametrize("kind", ["", "none"])
def test_an_escaped_daemon_is_killed_with_its_launcher_in_a_pid_namespace(bench: Bench, kind: str):
    if subprocess.run([*PID_NAMESPACE, "true"], stderr=subprocess.DEVNULL, check=False).returncode:
        pytest.skip("this machine does not allow a pid namespace")
    file = bench.folder / "pid"
    command = bench.command(f'sh("{ESCAPE.format(file)}"), sh("exec sleep 1001")')
    module = "tests.run.process.test_escapes"
    call = f"import sys; from {module} import *; kill_in_a_namespace(*sys.argv[1:])"
    done = subprocess.run(
        [*PID_NAMESPACE, sys.executable, "-c", call, str(file), kind, *command],
        env={**bench.env, "LAUNCHER_CGROUP": kind},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.stdout == "gone\n", done.stderr


@pytest.mark.parametrize("kind", ["", "none"])
def test_an_escaped_daemon_is_stopped_at_the_end_of_the_run(bench: Bench, kind: str):
    bench.env["LAUNCHER_CGROUP"] = kind
    file = bench.folder / "pid"
    run = bench.start(f'sh("{ESCAPE.format(file)}"), sh("exec sleep 1001")')
    daemon = escaped(file)
    wait_until_known(run.pid, daemon, kind)
    group = group_of(run.pid)
    run.send_signal(signal.SIGINT)
    output, _ = run.communicate(timeout=60)
    assert run.returncode == 0
    assert f"stopping leftover processes: sleep [{daemon.pid}]" in output.decode()
    assert not daemon.is_running()
    assert group is None or not os.path.exists(group)


def test_what_its_shell_had_started_before_is_not_of_the_run(bench: Bench):
    """A script that starts a server, and then is replaced by the launcher, as in containers."""
    file = bench.folder / "pid"
    command = bench.command('sh("echo ready; exec sleep 1001")')
    script = f'(setsid sh -c "echo \\$\\$ > {file}; exec sleep 1000" > /dev/null &); '
    script += 'setsid sleep 1002 > /dev/null & exec "$@"'
    with subprocess.Popen(
        ["sh", "-c", script, "sh", *command], env=bench.env, stdout=subprocess.PIPE
    ) as run:
        assert run.stdout is not None
        assert any(b"ready" in line for line in run.stdout)
        server = next(p for p in psutil.Process(run.pid).children() if "1002" in p.cmdline())
        watchdog = watchdog_of(run.pid)
        run.kill()
        wait_until(lambda: is_gone(watchdog), "the watchdog is done")
        assert not is_gone(server)
        server.kill()
        escaped(file).kill()


def test_orphans_that_exit_are_reaped(bench: Bench):
    run = bench.start('sh("(setsid true &); echo ready; exec sleep 1001")')
    assert run.stdout is not None
    assert any(b"ready" in line for line in run.stdout)
    wait_until(lambda: all(map(is_alive, children(run.pid))), "no zombie")
    run.send_signal(signal.SIGINT)
    assert run.wait(60) == 0


@pytest.mark.alone
def test_doctor_ends_what_a_killed_watchdog_has_left(bench: Bench):
    needs("v2")
    bench.env["LAUNCHER_CGROUP"] = "v2"
    file = bench.folder / "pid"
    run = bench.start(f'sh("{ESCAPE.format(file)}"), sh("exec sleep 1001")')
    daemon = escaped(file)
    wait_until_known(run.pid, daemon, "v2")
    group = group_of(run.pid)
    assert group is not None

    def doctor(*words: str) -> str:
        command = [sys.executable, "-m", "launcher", "doctor", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout

    assert group not in doctor("--fix"), "that of a running launcher is not stale"
    assert not is_gone(daemon)
    watchdog = watchdog_of(run.pid)
    watchdog.suspend()
    run.kill()
    run.wait()
    watchdog.kill()
    assert f"sleep 1000 [{daemon.pid}]" in " ".join(doctor().split())
    assert group in doctor("--fix")
    assert is_gone(daemon)
    assert not os.path.exists(group)
