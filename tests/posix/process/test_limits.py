"""Resource limits, staggered starts, and stop signals and timeouts of a process."""

from __future__ import annotations

import errno
import itertools
import json
import os
import re
import resource
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from launcher.base.model.spec import UNLIMITED, Limits
from launcher.posix.limits import command_prefix, parse_refusal
from tests.support.benches import Bench
from tests.support.waiting import wait_until

TELL = """
import os, resource
print("nice", os.getpriority(os.PRIO_PROCESS, 0), "cpus", sorted(os.sched_getaffinity(0)))
print("nofile", resource.getrlimit(resource.RLIMIT_NOFILE))
print("core", resource.getrlimit(resource.RLIMIT_CORE))
print("as", resource.getrlimit(resource.RLIMIT_AS))
"""


def _tell(bench: Bench) -> str:
    (bench.folder / "tell.py").write_text(TELL)
    return f'ExecuteProcess(cmd=[sys.executable, "{bench.folder}/tell.py"], output="screen")'


def test_limits_apply_to_the_named_processes_only(bench: Bench):
    options = ["--nice", "python=5", "--cpus=*-1=0", "--limit", "python:nofile=64/128,core=0"]
    limit = ["--limit", "python-1:as=4G"]
    done = bench.run(f"{_tell(bench)}, sh('nice; ulimit -n')", *options, *limit)
    out = done.stdout.decode()
    assert done.returncode == 0, out
    assert "[python-1] nice 5 cpus [0]\n" in out
    assert "[python-1] nofile (64, 128)\n" in out
    assert "[python-1] core (0, 0)\n" in out
    assert f"[python-1] as ({4 << 30}, {4 << 30})\n" in out
    nice, files = os.getpriority(os.PRIO_PROCESS, 0), resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    # The processes write at the same time: their lines may alternate.
    unlimited = [line for line in out.splitlines() if line.startswith("[sh-2]")]
    assert unlimited == [f"[sh-2] {nice}", f"[sh-2] {files}"]


@pytest.mark.thorough
def test_a_process_with_limits_has_the_environment_and_the_command_of_one_without(bench: Bench):
    for name in ("LC_ALL", "LC_CTYPE", "LANG"):
        bench.env.pop(name, None)
    bench.env["BAD"] = os.fsdecode(b"\xff\xfe")
    bench.env["LAUNCHER_TEST_QUOTE"] = "a 'b' \"c\"\n"
    script = "env -0 | grep -zv LAUNCHER_RUN_ID | sort -z | od -c; grep Sig[BIC] /proc/self/status"
    shell = f'ExecuteProcess(cmd=["{script}"], shell=True, output="screen", name="it")'
    said = [
        [
            line
            for line in bench.run(shell, *words).stdout.splitlines()
            if line.startswith(b"[it-1]")
        ]
        for words in (["--no-log-files"], ["--no-log-files", "--nice", "*=0"])
    ]
    assert said[0] == said[1]
    assert any(b"SigIgn" in line for line in said[0])


@pytest.mark.thorough
def test_a_missing_program_is_reported_with_limits_too(bench: Bench):
    folder = bench.folder / "script"
    folder.write_text("no interpreter is named here\n")
    folder.chmod(0o755)
    actions = f'ExecuteProcess(cmd=["/no/such"]), ExecuteProcess(cmd=["{folder}"])'
    done = bench.run(actions, "--nice", "*=3")
    out = done.stdout.decode()
    assert "[such-1]: process could not be started: No such file or directory" in out
    assert "[script-2]: process could not be started: Exec format error" in out
    assert "process started with pid" not in out
    assert done.returncode == 1


def test_a_limit_above_the_maximum_starts_nothing(bench: Bench):
    done = bench.run('sh("echo ran")', "--limit", "sh:nofile=unlimited")
    assert b"'nofile=unlimited' is more than is allowed here" in done.stderr
    assert b"ran" not in done.stdout
    assert done.returncode == 2


def test_a_limit_that_is_refused_later_is_named_as_it_is_written():
    read_end, write_end = os.pipe()
    limits = Limits(rlimits=(("nofile", 5, UNLIMITED),))
    command = [*command_prefix(limits, write_end, os.environ), "true"]
    with subprocess.Popen(command, pass_fds=[write_end]) as stage:
        os.close(write_end)
        said = os.read(read_end, 4096)
        stage.wait(60)
    os.close(read_end)
    assert parse_refusal(said) == (errno.EPERM, "nofile=5/unlimited")
    assert parse_refusal(b"1 nproc=-1/-1") == (errno.EPERM, "nproc=unlimited")
    assert parse_refusal(b"1 nice=-1") == (errno.EPERM, "nice=-1")


@pytest.mark.thorough
def test_restarts_have_the_limits_too_and_leave_no_descriptor(bench: Bench):
    actions = 'sh("ulimit -n; ls /proc/$PPID/fd | wc -l; exit 1")'
    restart = ["--restart", "sh=always,max=20", "--limit", "sh:nofile=77"]
    out = bench.run(actions, *restart).stdout.decode()
    assert out.count("[sh-1] 77\n") == 21
    counts = [int(number) for number in re.findall(r"\[sh-1\] (\d+)\n", out) if number != "77"]
    # The run's files and watchdog open at first, others come and go: what leaks stays and adds up.
    assert min(counts[-7:]) <= max(counts[2:9]), counts


@pytest.mark.thorough
def test_a_stop_during_the_stage_ends_the_process(bench: Bench):
    done = bench.run('sh("exec sleep 1000")', "--nice", "*=1", "--timeout", "0.001")
    assert done.returncode == 0
    assert bench.survivors() == []


# ---- pacing


def _starts(bench: Bench) -> list[float]:
    lines = (bench.folder / "log/latest/events.jsonl").read_text().splitlines()
    events = [json.loads(line) for line in lines]
    return [event["monotonic_s"] for event in events if event["event"] == "started"]


def test_starts_are_a_stagger_apart(bench: Bench):
    done = bench.run('sh("exit 0"), sh("exit 0"), sh("exit 0")', "--stagger", "0.4")
    assert done.returncode == 0
    starts = _starts(bench)
    assert len(starts) == 3
    assert all(later - earlier >= 0.4 for earlier, later in itertools.pairwise(starts))


# The first thread sleeps, as that of a node does while its others find their peers.
BUSY_START = """
import sys, threading, time
def tell(what): print(what, time.monotonic(), flush=True)
def work():
    while time.process_time() < 0.4: pass
tell("busy")
thread = threading.Thread(target=work)
thread.start()
thread.join()
tell("calm")
sys.stdin.read()
"""


@pytest.mark.alone  # a start that gets no processor looks like one that is over
@pytest.mark.thorough
def test_no_more_than_the_given_number_start_at_the_same_time(bench: Bench):
    (bench.folder / "node.py").write_text(BUSY_START)
    command = f'[sys.executable, "{bench.folder}/node.py"]'
    nodes = f'*[ExecuteProcess(cmd={command}, output="screen") for _ in range(5)]'
    terminal = bench.terminal(nodes, "--max-starting", "2", "--no-console")
    for _ in range(5):
        terminal.wait_for("calm ")
    terminal.ctrl_c()
    terminal.exit_code()
    stamps = {
        what: sorted(map(float, re.findall(rf"\] {what} ([\d.]+)", terminal.text)))
        for what in ("busy", "calm")
    }
    for number, busy_s in enumerate(stamps["busy"]):
        calm = sum(calm_s < busy_s for calm_s in stamps["calm"])
        assert number - calm < 2, stamps


@pytest.mark.thorough
def test_processes_queued_for_their_start_do_not_start_after_a_stop(bench: Bench):
    terminal = bench.terminal(
        '*[sh("echo ready; exec sleep 1000") for _ in range(5)]', "--stagger", "60"
    )
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert terminal.text.count("process started with pid") == 1
    assert terminal.text.count("process was not started") == 4
    assert terminal.text.count("SIGINT' to process") == 1
    assert bench.survivors() == []


@pytest.mark.thorough
def test_a_process_that_is_always_busy_does_not_block_other_starts(bench: Bench):
    actions = 'sh("while :; do :; done"), sh("echo second")'
    done = bench.run(actions, "--max-starting", "1", "--required", "sh-2")
    assert b"[sh-2] second\n" in done.stdout


# ---- stopping as asked


def test_a_process_is_stopped_with_the_signals_and_times_that_were_asked_for(bench: Bench):
    traps = "trap 'echo got USR1' USR1; trap 'echo got TERM' TERM"
    script = f"{traps}; echo ready; while :; do sleep 0.05; done"
    terminal = bench.terminal(f'sh("{script}")', "--stop", "sh=usr1:3,term:3")
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130
    assert terminal.text.index("got USR1") < terminal.text.index("got TERM")
    assert "sending signal 'SIGINT'" not in terminal.text
    assert "'3' seconds after receiving 'SIGTERM', escalating to 'SIGKILL'" in terminal.text


def test_a_kill_that_was_asked_for_is_no_failure(bench: Bench):
    terminal = bench.terminal('sh("echo ready; exec sleep 1000")', "--stop", "sh=kill")
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert "[INFO] [sh-1]: process was stopped" in terminal.text


# ---- the launcher's own limit of open files

TELL_FILES = "import resource; print(*resource.getrlimit(resource.RLIMIT_NOFILE))"
# Each process takes three or four descriptors of the launcher.
RUNS = [
    pytest.param(40, 64, id="40"),
    pytest.param(420, 1024, id="420", marks=pytest.mark.thorough),
]


@pytest.mark.parametrize(("count", "soft"), RUNS)
def test_the_soft_limit_of_open_files_limits_no_run_and_stays_that_of_processes(
    bench: Bench, count: int, soft: int
):
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    (bench.folder / "tell.py").write_text(f"{TELL_FILES}\nimport time; time.sleep(1000)")
    shells = 'sh("echo $(ulimit -Sn) $(ulimit -Hn); exec sleep 1000", cwd="/" if n % 2 else None)'
    python = 'ExecuteProcess(cmd=[sys.executable, "tell.py"], cwd=folder, output="screen")'
    actions = f"*[{shells} for n in range({count})], *[{python} for _ in range(2)]"
    options = ("--warm", "--nice", "sh-1=0", "--nice", "python-*1=0")
    command = bench.command(actions.replace("folder", repr(str(bench.folder))), *options)
    with (bench.folder / "screen").open("wb") as screen:
        launcher = subprocess.Popen(
            ["sh", "-c", f'ulimit -Sn {soft}; exec "$@"', "sh", *command],
            env=bench.env,
            stdout=screen,
        )
    told = f"] {soft} {hard}\n"
    shown = (bench.folder / "screen").read_text
    wait_until(lambda: shown().count(told) == count + 2, "all have told their limits")
    assert psutil.Process(launcher.pid).rlimit(psutil.RLIMIT_NOFILE) == (hard, hard)
    launcher.send_signal(signal.SIGINT)
    assert launcher.wait(60) == 0
    assert "could not be started" not in shown()
    assert bench.survivors() == []


HELPER = f"""
import resource, subprocess
from launcher.run.helpers.popen import start_module
from launcher.posix.spawn import most_open_files

hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (64, hard))
assert most_open_files(32) == 64
assert most_open_files(33) == hard
files = [open("/dev/null") for _ in range(80)]
helper = start_module(["tell_files"], stdout=subprocess.PIPE)
assert helper.communicate()[0].split() == [b"64", b"%d" % hard]
{TELL_FILES}
"""


def test_helpers_have_the_soft_limit_of_open_files_that_the_launcher_had(tmp_path: Path):
    (tmp_path / "tell_files.py").write_text(TELL_FILES)
    done = subprocess.run(
        [sys.executable, "-c", HELPER],
        env={**os.environ, "PYTHONPATH": f"{os.getcwd()}:{tmp_path}"},
        capture_output=True,
        text=True,
    )
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    assert done.stdout == f"{hard} {hard}\n", done.stderr


def test_a_limit_that_a_launch_file_sets_for_its_processes_stays(bench: Bench):
    limit = "__import__('resource').setrlimit(7, (48, 4096))"
    done = bench.run(f"OpaqueFunction(function=lambda c: {limit}), sh('ulimit -Sn; ulimit -Hn')")
    assert b"[sh-1] 48\n[sh-1] 4096\n" in done.stdout
