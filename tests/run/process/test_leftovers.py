"""Descendants that outlive their process during a run, and processes that survive SIGKILL."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from launcher.base.errors import ExitCode
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import ProcessSpec, StopPolicy
from launcher.output.stdout import StdoutWriter
from launcher.posix import proc
from launcher.posix.cleanup import RUN_ID_VARIABLE, sweep
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import Child, StartSettings, start
from launcher.run.ending.leftovers import Leftovers
from launcher.run.processes.machine_events import MachineCommand
from launcher.run.processes.process import Process
from launcher.run.run import Launched, Run
from tests.support.benches import Bench
from tests.support.waiting import wait_until

# Ignored already when it is forked. It is seen as a shell before it has become `sleep`.
DEAF = (
    'trap "" INT TERM; sleep {} & until grep -q sleep /proc/$!/comm; do :; done; trap - INT TERM; '
)
QUICK = 'sigkill_timeout="0.3"'
EVENTS = "__import__('launch.events.process').events.process"
EMIT = "__import__('launch.actions').actions.EmitEvent"
ON_OUTPUT = "__import__('launch.event_handlers').event_handlers.OnProcessIO"


@contextlib.contextmanager
def sleeping(env: dict[str, str]) -> Iterator[int]:
    """A process with this environment, at first in the middle of exec."""
    pid = os.posix_spawn("/bin/sleep", ["sleep", "1000"], env)
    try:
        yield pid
    finally:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)


# In a process that has the run id, like the parents of leftovers: just before its exec, a child has
# the environment of its parent.
SPAWN_AND_FIND = f"""
import collections, os, signal, time
from launcher.posix import proc
from launcher.posix.cleanup import sweep

seen = collections.Counter()
until_s = time.monotonic() + 60
# On a machine with one processor, an exec is seldom interrupted.
while seen.total() < 300 or not seen["in exec"] and time.monotonic() < until_s:
    pid = os.posix_spawn("/bin/sleep", ["sleep", "1000"], os.environ)
    proc.pids = lambda: [pid]  # reading all takes longer
    found, in_exec = sweep.find(os.environ["{RUN_ID_VARIABLE}"])
    seen["found" if found else "in exec" if in_exec else "missed"] += 1
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
print("ok" if seen["in exec"] and not seen["missed"] else seen)
"""
# The session of a process in it is led from outside, as with bubblewrap: getsid() is 0.
PID_NAMESPACE = ("unshare", "--map-root-user", "--pid", "--fork", "--mount-proc")


@pytest.mark.parametrize("container", [(), PID_NAMESPACE], ids=["", "pid namespace"])
def test_a_process_in_exec_is_not_missed(container: tuple[str, ...]):
    if (
        container
        and subprocess.run([*container, "true"], stderr=subprocess.DEVNULL, check=False).returncode
    ):
        pytest.skip("this machine does not allow a pid namespace")
    result = subprocess.run(
        [*container, sys.executable, "-c", SPAWN_AND_FIND],
        env={**os.environ, RUN_ID_VARIABLE: "a run"},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert result.stdout == "ok\n"


def test_a_process_without_variables_is_not_in_exec_for_ever():
    with sleeping({}) as pid:
        wait_until(lambda: not proc.was_in_exec(pid), "its exec is complete")
        assert pid not in [*sweep.find("a run")[0], *sweep.find("a run")[1]]
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda: proc.state(pid) == "Z", "it is a zombie")
        assert not proc.was_in_exec(pid)


class Listener:
    """What the leftovers of a run report."""

    def __init__(self, reactor: Reactor) -> None:
        self.lines: list[str] = []
        self._reactor = reactor

    def report(self, level: str, text: str) -> None:
        self.lines.append(text)

    def killing(self) -> None:
        self.lines.append("killing")

    def finished(self) -> None:
        self.lines.append("finished")
        self._reactor.stop()


@pytest.mark.parametrize("turns_up", [True, False])
def test_a_process_in_exec_is_looked_at_again(monkeypatch: pytest.MonkeyPatch, turns_up: bool):
    scans = iter([([], [11]), ([], [11]), ([11] if turns_up else [], [])])
    monkeypatch.setattr(sweep, "find", lambda *words, **more: next(scans, ([], [])))
    monkeypatch.setattr(sweep, "signal_all", lambda *words, **more: True)
    with Reactor() as reactor:
        listener = Listener(reactor)
        leftovers = Leftovers(
            "test",
            reactor=reactor,
            listener=listener,
            ignore=frozenset(),
            policy=StopPolicy(),
            session=11,
        )
        leftovers.check()
        reactor.run()
    assert len(listener.lines) == 1 + turns_up
    assert listener.lines[0].startswith("stopping leftover" if turns_up else "finished")


def _sleeping(bench: Bench, seconds: int) -> bool:
    return any(line.startswith(f"sleep {seconds} ") for line in bench.survivors())


def test_what_a_restarted_process_leaves_behind_ends_while_its_successor_runs(bench: Bench):
    (bench.folder / "node.sh").write_text(
        f"if [ ! -e again ]; then touch again; {DEAF.format(1001)} exit 1; fi\n"
        "echo successor; exec sleep 1002\n"
    )
    terminal = bench.terminal(f'sh(". ./node.sh", cwd="{bench.folder}", respawn=True, {QUICK})')
    terminal.wait_for_all("successor", "stopping leftover processes: ")
    wait_until(lambda: not _sleeping(bench, 1001), "what was left is gone")
    wait_until(lambda: _sleeping(bench, 1002), "it sleeps")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130, "something was killed"


def test_what_a_process_leaves_behind_that_was_stopped_ends_at_once(bench: Bench):
    script = f"{DEAF.format(1001)} echo ready; exec sleep 1000"
    stop = f"{EMIT}(event={EVENTS}.ShutdownProcess(process_matcher=lambda action: action is it))"
    on_ready = f"RegisterEventHandler({ON_OUTPUT}(target_action=it, on_stdout=lambda io: [{stop}]))"
    both = f"*(lambda it: [{on_ready}, it])"
    both = f"{both}(sh('{script}', {QUICK}))"
    terminal = bench.terminal(f'sh("exec sleep 1003"), {both}')
    terminal.wait_for_all("ready", "stopping leftover processes: ")
    wait_until(lambda: not _sleeping(bench, 1001), "what was left is gone")
    wait_until(lambda: _sleeping(bench, 1003), "it sleeps")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130, "something was killed"


def test_what_a_process_leaves_behind_that_ended_by_itself_stays_until_the_end(bench: Bench):
    terminal = bench.terminal(
        f"sh('{DEAF.format(1001)} exit 0', {QUICK}), sh('exec sleep 1002', {QUICK})",
    )
    terminal.wait_for("process has finished cleanly")
    wait_until(lambda: _sleeping(bench, 1001), "it sleeps")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130, "something was killed"
    assert "stopping leftover processes: " in terminal.text
    assert bench.survivors() == []


DEAF_DAEMON = """
setsid sh -c 'trap "" INT TERM; echo deaf; touch deaf; exec sleep 1001' &
"""
SIGKILLED = (
    r"leftover processes still running, sending SIGKILL: (sleep|sh) \["  # before it is `sleep`
)


def _leaving(bench: Bench, rest: str, options: str = "") -> str:
    """A process with a daemon that ignores every polite signal; it goes on with `rest`."""
    (bench.folder / "daemon.sh").write_text(DEAF_DAEMON + rest)
    return f'sh(". ./daemon.sh", cwd="{bench.folder}", {options})'


@pytest.mark.thorough
def test_what_is_left_behind_is_stopped_with_the_timeouts_of_the_run(bench: Bench):
    waits = "while [ ! -e deaf ]; do sleep 0.05; done"
    done = bench.run(_leaving(bench, waits, 'sigterm_timeout="0.2", sigkill_timeout="0.3"'))
    assert done.returncode == 1, "something was killed"
    assert re.search(SIGKILLED, done.stdout.decode())
    assert bench.survivors() == []
    events = (bench.folder / "log" / "latest" / "events.jsonl").read_text().splitlines()
    finished = json.loads(events[-1])
    assert (finished["event"], finished["exit_code"]) == ("finished", 1)


@pytest.mark.thorough
def test_what_is_left_behind_of_processes_that_are_killed_is_killed_at_once(bench: Bench):
    terminal = bench.terminal(_leaving(bench, "exec sleep 1002"), "--stop", "*=kill")
    terminal.wait_for("deaf")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, "it was asked for"
    assert "stopping leftover processes: " in terminal.text
    assert "still there" not in terminal.text
    assert bench.survivors() == []


@pytest.mark.thorough
def test_earlier_ctrl_c_presses_count_for_leftovers(bench: Bench):
    """The second of them is for the daemon, too, which nobody has found yet."""
    talks = "trap 'echo asked' INT; trap 'exit 0' TERM; echo ready; while :; do sleep 0.05; done"
    patient = f'sh("{talks}", sigterm_timeout="60", sigkill_timeout="2")'
    terminal = bench.terminal(f"{_leaving(bench, 'exec sleep 1002')}, {patient}")
    terminal.wait_for_all("deaf", "ready")
    terminal.ctrl_c()
    terminal.wait_for("asked")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130
    said = terminal.text.partition("stopping leftover processes")
    assert "again, not waiting any longer" in said[0]
    assert re.search(SIGKILLED.replace("KILL:", "TERM:"), said[2])
    assert re.search(SIGKILLED, said[2])
    first, second = re.findall(r"(\d+\.\d+) \[ERROR\] \[launch\]: leftover", _log(bench))
    assert float(second) - float(first) > 1.0, "only as many steps as there were presses"


def _log(bench: Bench) -> str:
    return (bench.folder / "log" / "latest" / "launch.log").read_text()


class Unreachable(Child):
    """A child that no signal reaches, as one in uninterruptible sleep."""

    def signal_group(self, signum: int) -> None:
        """It is sent, and nothing comes of it."""


class Stage:
    """The engine around one process, without a launch file."""

    def __init__(self, folder: Path) -> None:
        self.output = os.open(folder / "output", os.O_RDWR | os.O_CREAT)
        self.path = folder / "output"
        self.reactor = Reactor()
        screen = StdoutWriter(self.reactor, self.output, colour=False)
        spec = ProcessSpec(
            name="stuck-1",
            label="stuck",
            argv=("sleep", "1000"),
            env=os.environ,
            stop=StopPolicy(polite=()),
        )
        self.process = Process(1, spec, number=0, prefix=b"")
        launched = Launched(target="stuck")
        self.run = Run(cast(Any, self), self.reactor, screen, RunOptions(), launched, os.environ)
        self.run.all_processes[1] = self.process
        self.run.spawner.spawn = self.spawn  # type: ignore[method-assign]
        self.driver, self.shutdown = self.run.driver, self.run.shutdown

    def spawn(self, process: Process) -> Child:
        child = start(process.spec, StartSettings(process.spec.env, merge=True))
        child.__class__ = Unreachable
        return child

    def __getattr__(self, name: str) -> Callable[..., object]:
        """An interpreter that answers every event with nothing to do."""
        return lambda *words: ()

    def close(self) -> None:
        assert self.process.child is not None
        os.killpg(self.process.child.pid, signal.SIGKILL)
        self.process.child.reap()
        self.driver.release(self.process)
        self.reactor.close()
        os.close(self.output)


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    one = Stage(tmp_path)
    yield one
    one.close()


@pytest.mark.thorough
def test_a_process_that_sigkill_does_not_end_is_named_and_the_run_ends_without_it(stage: Stage):
    stage.driver.advance(stage.process, MachineCommand.START)
    stage.reactor.call_later(0, lambda: stage.shutdown.decided("the test"))
    alarms: list[str] = []
    stage.reactor.call_later(60.0, lambda: (alarms.append("60 s"), stage.reactor.stop()))
    stage.reactor.run()
    assert alarms == [], "the run did not end by itself"
    said = stage.path.read_text()
    pid = stage.process.child.pid if stage.process.child else 0
    assert f"process[stuck-1] [{pid}] still exists 5 s after SIGKILL: state S (sleeping)" in said
    assert stage.shutdown.exit_code() is ExitCode.PROCESS_FAILED
