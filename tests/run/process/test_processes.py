"""Sessions, daemons, fork loops, failed starts, odd output and log files of real processes."""

from __future__ import annotations

import ast
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

import launcher
from tests.support.benches import Bench
from tests.support.children import children_with
from tests.support.waiting import wait_until

FLOOD = "while :; do echo 'a line of some length that is not very short'; done"


def test_the_launcher_has_one_thread_and_each_child_a_session_and_group_of_its_own(bench: Bench):
    sleeper = 'sh("echo ready; exec sleep 1000")'
    terminal = bench.terminal(f"{sleeper}, {sleeper}", "--no-console")
    terminal.wait_for("ready")
    wait_until(lambda: sum(x.startswith("sleep 1000") for x in bench.survivors()) == 2, "both")
    assert psutil.Process(terminal.pid).num_threads() == 1
    sleeps = children_with(terminal.pid, "sleep")
    assert len(sleeps) == 2
    assert all(os.getsid(p.pid) == os.getpgid(p.pid) == p.pid for p in sleeps)


def test_an_exit_is_reported_while_a_grandchild_still_writes_to_the_pipe(bench: Bench):
    terminal = bench.terminal('sh("(sleep 1; echo late; exec sleep 1000) & echo bye")')
    terminal.wait_for("bye")
    terminal.wait_for("process has finished cleanly")
    terminal.exit_code()
    assert bench.survivors() == []


# They stamp entries and lines, and compare the times of files.
WALL_CLOCK_READERS = {
    "__main__",  # of the file watcher
    "host_agent",
    "cgroup",
    "child",
    "client_process",
    "core_file",
    "event_log",
    "ledger",
    "line_format",
    "systemd_link",
    "reload",
    "run",  # when it has begun
    "run_directory",
    "process_driver",
    "shared_memory",
    "warm_starts",
    "watching",
}


@pytest.mark.parametrize("room", ["run", "posix", "output", "hosts/agent", "hosts/engine"])
def test_no_deadline_uses_the_wall_clock(room: str):
    readers = set()
    paths = [*Path(launcher.__file__).parent.joinpath(room).rglob("*.py")]
    assert paths
    for path in paths:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Attribute) and node.attr in ("time", "time_ns", "now"):
                is_wall = isinstance(node.value, ast.Name) and node.value.id in ("time", "datetime")
                readers |= {path.stem} if is_wall else set()
    assert readers <= WALL_CLOCK_READERS


@pytest.mark.thorough
@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGHUP])
def test_a_clean_stop_by_a_signal_is_0_and_143_where_something_had_to_be_killed(bench, signum):
    ready = 'sh("echo ready; exec sleep 1000")'
    deaf = "sh(\"trap '' INT TERM; echo ready; while :; do sleep 0.1; done\")"
    for actions, stop, code in [(ready, "int:600", 0), (deaf, "int:0.1,term:0.1", 143)]:
        terminal = bench.terminal(actions, "--stop", f"*={stop}")
        terminal.wait_for("ready")
        terminal.signal(signum)
        assert terminal.exit_code() == code
    assert bench.survivors() == []


def test_a_run_with_a_failed_process_ends_with_130_after_ctrl_c(bench: Bench):
    terminal = bench.terminal('sh("exit 3"), sh("echo ready; exec sleep 1000")')
    terminal.wait_for_all("ready", "process has died")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130


# ---- descendants that do not want to go

HOPPER = """
import os, signal, sys, time
for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(signum, signal.SIG_IGN)
os.close(1), os.close(2)
log = os.open("hops", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
until = time.monotonic() + 180  # longer than any test waits for its end
while time.monotonic() < until:
    if os.fork():
        os._exit(0)
    os.setsid()
    os.write(log, b".")
    time.sleep(float(sys.argv[1]))
"""
BREEDER = """
import os, signal, time
def breed(*_):
    for _ in range(5):
        if os.fork() == 0:
            os.setsid()
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            time.sleep(60)
            os._exit(0)
signal.signal(signal.SIGINT, breed)
signal.signal(signal.SIGTERM, breed)
print("ready", flush=True)
while True:
    time.sleep(1)
"""


@pytest.mark.thorough
def test_a_daemon_that_ignores_everything_is_named_and_killed(bench: Bench):
    ready = bench.folder / "ready"
    script = f"trap '' INT TERM HUP; : > {ready}; while :; do sleep 0.1; done"
    (bench.folder / "daemon.sh").write_text(script)
    leave = f"setsid -f sh {bench.folder}/daemon.sh >/dev/null 2>&1"
    done = bench.run(f'sh("{leave}; until [ -e {ready} ]; do sleep 0.05; done")')
    assert b"stopping leftover processes: " in done.stdout
    assert re.search(
        rb"leftover processes still running, sending SIGKILL: .*sh \[\d+\]", done.stdout
    )
    assert bench.survivors() == []


class Hopper:
    """A process that is always about to be another one, in another session."""

    def __init__(self, folder: Path, rest_s: str) -> None:
        (folder / "hopper.py").write_text(HOPPER)
        words = f'[sys.executable, "-S", "hopper.py", "{rest_s}"]'
        self.actions = f'ExecuteProcess(cmd={words}, cwd="{folder}")'
        self.log = folder / "hops"
        self._sizes: list[int] = []

    def has_begun(self) -> bool:
        return self.log.exists() and self.log.stat().st_size > 0

    def has_stopped(self) -> bool:
        """Whether it has not forked in the last ten polls; a list of processes cannot show it."""
        self._sizes.append(self.log.stat().st_size)
        return len(self._sizes) > 10 and self._sizes[-10] == self._sizes[-1] > 0


@pytest.mark.thorough
@pytest.mark.parametrize("rest_s", ["0.002", "0"])
def test_a_process_that_forks_into_new_sessions_in_a_loop_is_killed(bench: Bench, rest_s):
    hopper = Hopper(bench.folder, rest_s)
    done = bench.run(hopper.actions)
    assert b"stopping leftover processes: " in done.stdout
    wait_until(hopper.has_stopped, "it does not hop any more")
    assert bench.survivors() == []


@pytest.mark.thorough
@pytest.mark.parametrize("rest_s", ["0.002", "0"])
def test_a_process_that_forks_in_a_loop_does_not_outlive_a_killed_launcher(
    bench: Bench, rest_s: str
):
    hopper = Hopper(bench.folder, rest_s)
    terminal = bench.terminal(f'{hopper.actions}, sh("sleep 0.5; echo ready; exec sleep 1000")')
    terminal.wait_for("ready")
    wait_until(hopper.has_begun, "it hops")
    terminal.kill()
    wait_until(hopper.has_stopped, "it does not hop any more")
    wait_until(lambda: bench.survivors() == [], "nothing is left")


ORPHAN = """
import os, sys
from launcher.posix.socket_directory import ControlError
from launcher.control.active_runs import wait_for_run
parent = os.getpid()
if os.fork():
    os._exit(0)
try:
    wait_for_run(parent, 600.0)
except ControlError as error:
    print(error, flush=True)
"""


@pytest.mark.thorough
def test_a_console_that_is_starting_does_not_outlive_its_launcher():
    with subprocess.Popen(
        [sys.executable, "-c", ORPHAN], stdout=subprocess.PIPE, text=True
    ) as launcher_process:
        output, _ = launcher_process.communicate(timeout=60)
    assert output == f"process {launcher_process.pid} has ended\n"


@pytest.mark.thorough
def test_a_process_that_forks_when_it_is_stopped_leaves_nothing(bench: Bench):
    (bench.folder / "breeder.py").write_text(BREEDER)
    breeder = f'ExecuteProcess(cmd=[sys.executable, "{bench.folder}/breeder.py"], output="screen")'
    terminal = bench.terminal(breeder, "--stop", "*=int:0.3,term:0.3")
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 130
    assert bench.survivors() == []


def test_a_suspended_grandchild_ends_too(bench: Bench):
    terminal = bench.terminal(
        "sh(\"(kill -STOP $(exec sh -c 'echo $PPID'); sleep 1000) & echo ready; wait\")",
        "--stop",
        "*=int:0.3,term:0.3",
    )
    terminal.wait_for("ready")
    terminal.ctrl_c()
    terminal.exit_code()
    assert bench.survivors() == []


# ---- starts that fail, ends that are told

REFUSED = {
    'cmd=["echo", "y" * 200_000]': "Argument list too long",
    'cmd=["true"], additional_env={"BIG": "z" * 200_000}': "Argument list too long",
    'cmd=["/etc/passwd"]': "Permission denied",
    'cmd=["/"]': "Permission denied",
    'cmd=["no-such-program"]': "No such file or directory",
    'cmd=["true"], cwd="/no/such/folder"': "working directory '/no/such/folder': No such file",
    'cmd=["echo", "a\\0b"]': "embedded null byte",
    'cmd=["true"], additional_env={"A=B": "c"}': "illegal environment variable name",
    'cmd=["echo", "\\ud800"]': "'utf-8' codec can't encode",
}


@pytest.mark.thorough
@pytest.mark.parametrize("what", REFUSED)
def test_a_failed_start_is_reported_with_its_reason_and_the_others_run(bench: Bench, what: str):
    done = bench.run(f'ExecuteProcess({what}), sh("echo hello")')
    assert f"process could not be started: {REFUSED[what]}" in done.stdout.decode(), done.stderr
    assert b"[sh-2] hello\n" in done.stdout
    assert done.returncode == 1
    assert b"Traceback" not in done.stderr


@pytest.mark.thorough
def test_a_core_dump_is_reported_if_the_system_wrote_one(bench: Bench):
    script = f"cd {bench.folder}; ulimit -c unlimited; kill -ABRT $$"
    child = subprocess.Popen(["sh", "-c", script])  # the same death, as the system tells it
    _, status = os.waitpid(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    said = " (SIGABRT, core dumped)" if os.WCOREDUMP(status) else " (SIGABRT)"
    done = bench.run(f'sh("{script}")')
    assert f"exit code -6, cmd 'sh -c {script}'].{said}\n" in done.stdout.decode()


def test_a_pipe_and_the_log_get_every_byte(bench: Bench):
    (bench.folder / "bytes").write_bytes(
        b"\xff\xfe nul \0 end\r\n10%\r50%\r100%\na\xc2\x85b\x0bc\x0c\n\xe2\x82\n"
    )
    done = bench.run(f'sh("cat {bench.folder}/bytes")')
    lines = b"[sh-1] \xff\xfe nul \0 end\r\n[sh-1] 10%\r50%\r100%\n"
    lines += b"[sh-1] a\xc2\x85b\x0bc\x0c\n[sh-1] \xe2\x82\n"
    assert b"\n" + lines in done.stdout
    log = (bench.folder / "log/latest/sh-1.log").read_bytes()
    assert log == lines


PROGRESS = """
import sys, time
for word in ("loading 0%", "\\r10%", "\\r20%", "\\rdone\\n"):
    sys.stdout.write(word)
    sys.stdout.flush()
    time.sleep(0.3)  # an unfinished line is shown meanwhile
"""


def test_what_a_pipe_has_of_a_progress_bar_is_completed(bench: Bench):
    done = bench.run(f"py({PROGRESS!r}, name='bar')")
    assert done.stdout.count(b"loading 0%") == 1
    assert b"[bar-1] loading 0%\r10%\r20%\rdone\n" in done.stdout


SLOW_TRACEBACK = """
import sys, time
lines = ["Traceback (most recent call last):", "  File 'x', line 1", "    f()"]
for _ in range(20):
    begun_s = time.monotonic()
    for line in lines:
        print(line, file=sys.stderr, flush=True)
        time.sleep(0.003)
    print("ValueError: after", time.monotonic() - begun_s, file=sys.stderr, flush=True)
    time.sleep(0.003)
"""


@pytest.mark.thorough
def test_a_traceback_that_comes_slowly_is_not_torn_by_the_lines_of_others(bench: Bench):
    (bench.folder / "slow.py").write_text(SLOW_TRACEBACK)
    slow = f'ExecuteProcess(cmd=[sys.executable, "{bench.folder}/slow.py"], output="screen")'
    done = bench.run(f'{slow}, sh("{FLOOD}")', "--required", "python-1")
    lines = done.stdout.decode().splitlines()
    starts = [n for n, line in enumerate(lines) if line.startswith("[python-1] Traceback")]
    took = [line.rpartition(" ")[2] for line in lines if "[python-1] ValueError: after" in line]
    assert len(starts) == len(took) == 20
    # One that was held up itself, for a second, does not count as slow but as silent.
    judged = [n for n, seconds in zip(starts, took, strict=True) if float(seconds) < 0.5]
    assert judged
    assert all(line.startswith("[python-1] ") for n in judged for line in lines[n : n + 4])


@pytest.mark.thorough
def test_odd_names_break_neither_lines_nor_log_files(bench: Bench):
    names = [
        "a/b",
        "../up",
        "x" * 300,
        "new\nline",
        "esc\x1b[2Jape",
        "\u00fcn\u00ef",
        "sp ace",
        "..",
    ]
    actions = ", ".join(f'sh("echo hello", name={name!r}, output="full")' for name in names)
    done = bench.run(actions)
    run = bench.folder / "log" / "latest"
    assert done.returncode == 0
    assert b"no log files" not in done.stdout
    assert done.stdout.count(b"] hello\n") == len(names)
    assert b"\x1b" not in done.stdout and b"[new\\nline-4] hello\n" in done.stdout
    assert len(list(run.glob("*-stdout.log"))) == len(names)
    assert not list(bench.folder.glob("log/*up*"))


@pytest.mark.thorough
def test_a_flood_does_not_hold_up_a_stop(bench: Bench):
    process = bench.start(f'*[sh("{FLOOD}") for _ in range(6)]')
    assert process.stdout is not None
    for _ in range(1000):
        process.stdout.readline()
    process.terminate()
    process.communicate(timeout=60)
    assert process.returncode == 0
    log = (bench.folder / "log/latest/launch.log").read_bytes()
    assert log.count(b"sending signal 'SIGINT'") == 6
    assert bench.survivors() == []


@pytest.mark.thorough
@pytest.mark.parametrize("stdin", ["/dev/null", "an empty file"])
def test_a_standard_input_that_has_nothing_does_no_harm(bench: Bench, stdin: str):
    empty = bench.folder / "empty"
    empty.touch()
    source = str(empty) if stdin == "an empty file" else stdin
    fd = os.open(source, os.O_RDONLY)
    done = subprocess.run(
        bench.command('sh("echo hello")'),
        env=bench.env,
        stdin=fd,
        capture_output=True,
        timeout=60,
        check=False,
    )
    os.close(fd)
    assert done.returncode == 0, done.stderr
    assert b"[sh-1] hello\n" in done.stdout


@pytest.mark.parametrize("log_root", ["absolute", "relative", "~"])
def test_the_logs_of_the_nodes_go_into_the_folder_of_the_run(bench: Bench, log_root: str):
    bench.env["HOME"] = str(bench.folder)
    if log_root != "absolute":
        relative = os.path.relpath(bench.folder / "log")
        bench.env["ROS_LOG_DIR"] = "~/log" if log_root == "~" else relative
    done = bench.run('sh("echo logs go to $ROS_LOG_DIR", cwd="/")')
    run = (bench.folder / "log" / "latest").resolve()
    assert f"[sh-1] logs go to {run}\n" in done.stdout.decode()


def test_events_record_signals_restarts_and_the_stop_with_both_clocks(bench: Bench):
    (bench.folder / "node.sh").write_text(
        "if [ -e again ]; then echo ready; exec sleep 1000; fi; touch again; exit 3"
    )
    actions = f'sh(". ./node.sh", cwd="{bench.folder}")'
    terminal = bench.terminal(actions, "--restart", "sh=on-failure,delay=0.1")
    terminal.wait_for("ready")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    lines = (bench.folder / "log/latest/events.jsonl").read_text().splitlines()
    events = [entry for entry in map(json.loads, lines) if entry["event"] != "resources"]
    assert [entry["event"] for entry in events] == [
        *("started", "ended", "started", "stopping", "signal", "ended", "finished")
    ]
    first, last = (entry for entry in events if entry["event"] == "ended")
    assert (first["returncode"], first["asked"], first["restart_in_s"]) == (3, False, 0.1)
    assert (last["returncode"], last["asked"], last["restart_in_s"]) == (-2, True, None)
    assert next(e for e in events if e["event"] == "signal")["signal"] == signal.SIGINT
    assert all({"wall_s", "monotonic_s"} <= entry.keys() for entry in events)
