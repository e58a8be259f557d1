"""--compose: several nodes of real programs in one process, on real DDS."""

from __future__ import annotations

import ctypes
import itertools
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from launcher.posix import proc
from launcher.posix.domain_lease import leased_domain
from launcher.posix.socket_directory import ControlError
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.node_process import shared_memory_of
from tests.support.repository import REPOSITORY
from tests.support.waiting import rest_of, wait_until

pytest.importorskip("rclpy")

PROGRAM = REPOSITORY / "tests/support" / "plain_node.py"
NODE = "__import__('launch_ros').actions.Node"
LOGGED = r"\[{}\] \[INFO\] \[[\d.]+\] \[{}\]: (.*)"


def plain(style: str, *, name: str | None = None, more: str = "") -> str:
    """The action that starts a plain node, which is named after its style."""
    name = name or style
    return (
        f"{NODE}(executable=sys.executable, arguments=[{str(PROGRAM)!r}, {style!r}, {name!r}], "
        f"exec_name={name!r}, output='screen'{more})"
    )


@pytest.fixture
def bench(control_bench: ControlBench) -> Iterator[ControlBench]:
    with leased_domain() as domain_id:
        control_bench.env["ROS_DOMAIN_ID"] = str(domain_id)
        control_bench.env["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        yield control_bench
        assert control_bench.survivors() == []


def logged(run: ControlledRun, process: str, node: str) -> list[str]:
    """What a node has logged so far, with the prefix of its process."""
    return re.findall(LOGGED.format(re.escape(process), re.escape(node)), run.screen)


def pid_of(run: ControlledRun, name: str = "composed-1") -> int:
    pid: int = run.row(name)["pid"]
    return pid


def end(run: ControlledRun, *, by: int = signal.SIGINT) -> None:
    run.process.send_signal(by)
    assert run.exit_code() == 0, run.screen


def test_robots_in_one_process_work_as_robots_of_their_own(bench: ControlBench):
    robot = f"{NODE}(package='group_gp1', output='screen', "
    actions = (
        f"{NODE}(package='group_gp1', executable='dispatcher', "
        "parameters=[{'dispatch_rate_hz': 5.0, 'robot_ids': ['robot_1', 'robot_2', 'robot_3']}]), "
        f"{robot} executable='robot_1', parameters=[{{'task_duration_s': 0.1}}]), "
        f"{robot} executable='robot_2', parameters=[{{'task_duration_s': 0.9}}]), "
        f"{robot} executable='robot_3')"
    )
    robots = {"robot_1-2": 0.1, "robot_2-3": 0.9, "robot_3-4": 0.3}
    with bench.launch(actions, "--compose", "robot_*") as run:
        for process in robots:
            done = f"task of {process}"
            wait_until(lambda p=process: "complete" in " ".join(_tasks(run, p)), done)
        row = run.row("composed-1")
        files = shared_memory_of(row["pid"])
        assert len(run.ask("ps")["processes"]) == 2
        end(run)
    for process, duration_s in robots.items():
        assert min(_durations(run, process)) >= duration_s * 0.99
    assert min(_durations(run, "robot_1-2")) < min(_durations(run, "robot_2-3"))
    assert files
    assert [path for path in files if "_port" not in path.name and path.exists()] == []
    for process in robots:
        assert f"[INFO] [{process}]: node has finished cleanly in composed-1" in run.screen
    assert "[composed-1] [INFO]" not in run.screen  # each line has the prefix of its node


def _tasks(run: ControlledRun, process: str) -> list[str]:
    return logged(run, process, process.rpartition("-")[0])


def _durations(run: ControlledRun, process: str) -> list[float]:
    found = re.findall(rf"\[{process}\] \[INFO\] \[([\d.]+)\] \[\w+\]: (Received|Task)", run.screen)
    pairs = itertools.pairwise(found)
    return [float(b[0]) - float(a[0]) for a, b in pairs if (a[1], b[1]) == ("Received", "Task")]


STYLES = ("usual", "careful", "threads", "loop", "client", "rate", "words")


def test_programs_of_any_style_run_as_they_are(bench: ControlBench):
    actions = ", ".join(
        plain(
            style,
            more=f", name={style!r}, namespace={'fleet' if style == 'careful' else ''!r}, "
            f"parameters=[{{'speed': {number}.5}}]",
        )
        for number, style in enumerate(STYLES, 1)
    )
    with bench.launch(actions, "--compose", "*") as run:
        for text in (
            "[words-7] words words words and 10\n",
            "[words-7] to stderr\n",
            "[INFO] [words-7]: node has finished cleanly in composed-1",
            "[threads-3] threads has a thread",
            "[client-5] client got True",
            "]: has another context",
            "[rate-6] rate has slept",
        ):
            run.wait_for(text)
        # Each has its own parameters, names and executor.
        for number, style in enumerate(STYLES[:4], 1):
            name = "fleet.careful" if style == "careful" else style
            own = f"heard /{name.replace('.', '/')} at {number}.5"
            wait_until(lambda p=f"{style}-{number}", n=name, t=own: t in logged(run, p, n), own)
        wait_until(
            lambda: "heard /usual at 3.5" in logged(run, "threads-3", "threads"), "a message"
        )
        end(run)
    # This one is called as the other by the words of the process.
    assert re.search(r"\[client-5\] .*\[client\]: has another context", run.screen)
    assert "[careful-2] careful was stopped" in run.screen
    assert "[threads-3] threads was stopped" in run.screen
    assert "[INFO] [usual-1]: node was stopped in composed-1 (SIGINT)" in run.screen
    assert "Traceback" not in run.screen


def test_sigterm_is_what_each_node_makes_of_it(bench: ControlBench):
    actions = ", ".join(plain(style) for style in ("careful", "loop", "threads"))
    with bench.launch(actions, "--compose", "*", "--stop", "*=term:30") as run:
        for name in ("careful-1", "loop-2", "threads-3"):
            run.wait_for(f"[{name}] [INFO]")
        end(run)
    assert "[loop-2] loop got SIGTERM" in run.screen
    assert "[loop-2] loop is not ok any more" in run.screen
    assert "[INFO] [loop-2]: node was stopped in composed-1 (exit code 1)" in run.screen
    assert "[careful-1] careful was stopped" in run.screen
    assert "threads was stopped" not in run.screen  # this executor returns without an exception


def test_a_signal_counts_whichever_thread_it_interrupts(bench: ControlBench):
    """The kernel may deliver it to any thread; the main thread, which acts on it, sleeps then."""
    with bench.launch(f"{plain('careful')}, {plain('threads')}", "--compose", "*") as run:
        for name in ("careful-1", "threads-2"):
            run.wait_for(f"[{name}] [INFO]")
        pid = pid_of(run)
        threads = [one.id for one in psutil.Process(pid).threads() if one.id != pid]
        tid = next(tid for tid in threads if not _blocks(pid, tid, signal.SIGINT))
        assert ctypes.CDLL(None).tgkill(pid, tid, signal.SIGINT) == 0
        assert run.exit_code() == 0
    assert "[INFO] [careful-1]: node has finished cleanly in composed-1" in run.screen


def _blocks(pid: int, tid: int, signum: int) -> bool:
    status = proc.read(f"{pid}/task/{tid}", "status").decode()  # empty if it has ended
    mask = re.search(r"^SigBlk:\s+(\w+)", status, re.MULTILINE)
    return mask is None or bool(int(mask[1], 16) & 1 << (signum - 1))


@pytest.mark.parametrize(
    ("style", "text", "code"),
    [("fails", "IndexError", 1), ("exits", "", 3)],
    ids=["fails", "exits"],
)
def test_a_node_that_fails_takes_the_others_with_it(bench: ControlBench, style, text, code):
    handler = (
        "RegisterEventHandler(OnProcessExit(target_action=node, on_exit=lambda event, context: "
        "LogInfo(msg=f'{event.process_name} ended with {event.returncode}')))"
    )
    actions = (
        f"*(lambda node, other: [other, node, {handler}, {handler.replace('=node', '=other')}])"
        f"({plain(style)}, {plain('careful')})"
    )
    with bench.launch(actions, "--compose", "*") as run:
        assert run.exit_code() == 1
    assert f"[ERROR] [{style}-2]: node has died in composed-1 (exit code {code})" in run.screen
    assert "[careful-1] careful was stopped" in run.screen
    assert f"{style}-2 ended with {code}" in run.screen
    assert "careful-1 ended with 0" in run.screen
    assert f"exit code 1: composed-1 ended unexpectedly (exit code {code})" in run.screen
    assert not text or re.search(rf"\[{style}-2\] {text}: ", run.screen)


def test_a_restart_is_that_of_the_group(bench: ControlBench):
    actions = f"{plain('exits')}, {plain('careful')}"
    policy = "*=on-failure,max=1,delay=0.1"
    with bench.launch(actions, "--compose", "*", "--restart", policy) as run:
        assert run.exit_code() == 1
    assert run.screen.count("\n[careful-2] careful was stopped") == 2
    assert run.screen.count("\n[ERROR] [exits-1]: node has died in composed-1 (exit code 3)") == 2


def test_a_required_node_ends_the_run_and_another_does_not(bench: ControlBench):
    actions = f"{plain('words')}, {plain('words', name='more')}, {plain('careful')}"
    with bench.launch(actions, "--compose", "*") as run:
        run.wait_for("[INFO] [more-2]: node has finished cleanly in composed-1")
        run.wait_for("[careful-3] [INFO]")
        end(run)
    with bench.launch(actions, "--compose", "*", "--required", "more") as run:
        assert run.exit_code() == 0, run.screen
    assert "[INFO] [composed-1]: process has finished cleanly" in run.screen


DESTRUCTOR = """
import time
class Slow:
    def __del__(self):
        print("ready", flush=True)
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            pass
try:
    Slow()
    while True:
        time.sleep(0.01)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
# Its import takes until the signal has come, and holds the lock that other imports need.
IMPORT = """
import time
print("ready", flush=True)
end = time.monotonic() + 1.0
while time.monotonic() < end:
    pass
"""
IMPORTING = """
import sys
sys.path.insert(0, {folder!r})
try:
    import slow_to_import
    import time
    while True:
        time.sleep(0.01)
except KeyboardInterrupt:
    print("interrupted", "slow_to_import" in sys.modules, flush=True)
"""
# It hardly does anything but start threads.
STARTING = """
import threading
print("ready", flush=True)
try:
    while True:
        threading.Thread(target=int).start()
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
# Timers that would end a process of its own, and those that it handles.
TIMERS = """
import signal
for which in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
    assert signal.setitimer(which, 0.001) == (0.0, 0.0)
assert signal.alarm(1) == 0
signal.signal(signal.SIGALRM, lambda *_: None)
for call in (lambda: signal.alarm(1), lambda: signal.setitimer(signal.ITIMER_REAL, 1.0)):
    try:
        call()
    except RuntimeError as error:
        print(error, flush=True)
signal.setitimer(signal.ITIMER_PROF, 2.0)
print("all tried", flush=True)
"""


def script(path: Path, text: str) -> str:
    """The action that runs a Python program."""
    path.write_text(text, encoding="utf-8")
    name = path.stem
    return (
        f"{NODE}(executable=sys.executable, arguments=[{str(path)!r}], exec_name={name!r}, "
        "output='screen')"
    )


def test_an_interrupt_that_a_destructor_drops_comes_again(bench: ControlBench, tmp_path: Path):
    action = script(tmp_path / "slow.py", DESTRUCTOR)
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[slow-1] ready")
        end(run)
    assert "[slow-1] interrupted" in run.screen
    assert "escalating" not in run.screen


def test_a_timer_is_refused_if_its_node_would_be_called(bench: ControlBench, tmp_path: Path):
    action = script(tmp_path / "timers.py", TIMERS)
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[timers-1] all tried")
        end(run)
    for name in ("alarm", "setitimer"):
        text = f"[timers-1] signal.{name} does not work in a composed node: it is of the process"
        assert run.screen.count(text) == 1, run.screen


def test_an_interrupt_waits_for_the_end_of_an_import(bench: ControlBench, tmp_path: Path):
    (tmp_path / "slow_to_import.py").write_text(IMPORT, encoding="utf-8")
    action = script(tmp_path / "importing.py", IMPORTING.format(folder=str(tmp_path)))
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[importing-1] ready")
        end(run)
    assert "[importing-1] interrupted True" in run.screen
    assert "escalating" not in run.screen


def test_an_interrupt_reaches_a_thread_that_starts_others(bench: ControlBench, tmp_path: Path):
    """Python gives a new thread the identity of the one that starts it, until it runs."""
    actions = ", ".join(script(tmp_path / f"starting_{n}.py", STARTING) for n in range(8))
    with bench.launch(f"{actions}, {plain('careful')}", "--compose", "*") as run:
        for number in range(8):
            run.wait_for(f"[starting_{number}-{number + 1}] ready")
        end(run)
    assert run.screen.count("] interrupted\n") == 8
    assert "Exception ignored" not in run.screen
    assert "escalating" not in run.screen


def test_a_launch_file_stops_one_node_and_the_others_go_on(bench: ControlBench):
    stop = (
        "RegisterEventHandler(__import__('launch').event_handlers.OnProcessIO("
        "target_action=cat, on_stdout=lambda io: __import__('launch').actions.EmitEvent(event="
        "__import__('launch').events.process.ShutdownProcess("
        "process_matcher=lambda action: action is node))))"
    )
    cat = "sh('exec cat', name='cat')"
    actions = (
        f"*(lambda node, cat: [node, cat, {stop}])({plain('careful')}, {cat}), "
        f"{plain('careful', name='other')}, {plain('words')}"
    )
    with bench.launch(actions, "--compose", "*") as run:
        for process in ("careful-1", "other-3"):
            wait_until(lambda p=process: len(_tasks(run, p)) == 2, "each hears both")
        run.ask("send", "cat", text="go")
        run.wait_for("[INFO] [careful-1]: node has finished cleanly in composed-1")
        assert run.row("composed-1")["state"] == "RUNNING"
        end(run)
    assert len(logged(run, "other-3", "other")) == 2  # in its only life
    assert run.screen.index("careful was stopped") < run.screen.index("other was stopped")


CRASHING = """
import os, signal, time
signal.signal(signal.SIGINT, lambda *_: os.kill(os.getpid(), signal.SIGSEGV))
print("ready", flush=True)
while True:
    time.sleep(0.01)
"""


def test_a_crash_of_a_group_that_is_stopped_is_a_death(bench: ControlBench, tmp_path: Path):
    action = script(tmp_path / "crashing.py", CRASHING)
    handler = (
        "RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: "
        "LogInfo(msg=f'{event.process_name} ended with {event.returncode}')))"
    )
    with bench.launch(f"{action}, {plain('careful')}, {handler}", "--compose", "*") as run:
        run.wait_for("[crashing-1] ready")
        run.wait_for("[careful-2] [INFO]")
        run.ask("quit")
        assert run.exit_code() == 1
    assert "exit code 1: composed-1 ended unexpectedly (SIGSEGV" in run.screen
    assert "crashing-1 ended with -11" in run.screen


TALKATIVE = REPOSITORY / "tests/support" / "talkative_node.py"
NODES, LINES = 16, 40
STREAMS = {
    "pipe": "output='screen'",
    "two pipes": "output={'both': {'screen', 'own_log'}}",
    "terminal": "output='screen', emulate_tty=True",
}


@pytest.mark.parametrize(
    ("streams", "times"),
    [
        ("pipe", 1),
        *(pytest.param(streams, 3, marks=pytest.mark.thorough) for streams in STREAMS),
    ],
)
def test_no_line_of_python_is_torn_and_no_end_is_lost(
    bench: ControlBench, streams: str, times: int
):
    actions = ", ".join(
        f"{NODE}(executable=sys.executable, arguments=[{str(TALKATIVE)!r}, 'n{n}', '{LINES}'], "
        f"exec_name='n{n}', {STREAMS[streams]})"
        for n in range(NODES)
    )
    for _ in range(times):
        with bench.launch(actions, "--compose", "*") as run:
            assert run.exit_code() == 0, run.screen
        log = (bench.folder / "log" / "latest" / "launch.log").read_text(errors="replace")
        for text in (run.screen, log):
            _check_talk(text.replace("\x1b[0m", ""))


def _check_talk(text: str) -> None:
    assert "\x1e" not in text, "a mark is seen"
    lines = [re.sub(r"^\d+\.\d{7} ", "", line) for line in text.splitlines()]
    places = {line: place for place, line in enumerate(lines)}
    logged = set(re.findall(r"<log (n\d+) (\d+)>$", text, re.MULTILINE))
    for n in range(NODES):
        name, own = f"n{n}", f"n{n}-{n + 1}"
        for number in range(LINES):
            assert f"[{own}] <print {name} {number} {'x' * (number * 997 % 9000)}>" in places
            assert f"[{own}] <error {name} {number}>" in places
            assert (
                name,
                str(number),
            ) in logged  # perhaps behind a piece
        end = f"[INFO] [{own}]: node has finished cleanly in composed-1"
        assert places[f"[{own}] last of {name}"] < places[end]
        assert lines.count(end) == 1
    assert len(re.findall("<piece ", text)) == NODES * LINES


CHILD = """
import os, subprocess, sys
print("children have", subprocess.getoutput("ls -l /proc/self/fd | grep -c socket:"), flush=True)
print("and read", repr(subprocess.run(["cat"], capture_output=True, timeout=60).stdout), flush=True)
print("it reads", repr(sys.stdin.read()), flush=True)
"""


def test_nobody_but_the_process_itself_gets_the_connection_to_the_launcher(
    bench: ControlBench, tmp_path: Path
):
    action = script(tmp_path / "child.py", CHILD)
    with bench.launch(f"{action}, {plain('careful')}", "--compose", "*") as run:
        run.wait_for("[INFO] [child-1]: node has finished cleanly in composed-1")
        run.wait_for("[careful-2] [INFO]")
        with pytest.raises(ControlError, match="composed-1 is composed, and has no standard input"):
            run.ask("send", "composed-1", text="1 15")
        assert run.row("composed-1")["state"] == "RUNNING"
        end(run)
    for text in ("children have 0", "and read b''", "it reads ''"):
        assert f"[child-1] {text}\n" in run.screen


def test_a_killed_group_leaves_nothing(bench: ControlBench):
    with bench.launch(f"{plain('careful')}, {plain('usual')}", "--compose", "*") as run:
        run.wait_for("[usual-2] [INFO]")
        os.kill(pid_of(run), signal.SIGKILL)
        assert run.exit_code() == 1
    assert "composed-1 ended unexpectedly (SIGKILL)" in run.screen


@pytest.mark.thorough
def test_verbs_are_about_the_group(bench: ControlBench):
    actions = f"{plain('careful', more=', name=' + repr('careful'))}, {plain('usual')}"
    with bench.launch(actions, "--compose", "*") as run:
        run.wait_for("[usual-2] [INFO]")
        assert run.row("composed-1")["node_names"] == ["/careful"]
        with pytest.raises(ControlError, match="composed-1 is the process of 2 nodes: careful-1"):
            run.ask("stop", "careful")
        with pytest.raises(ControlError, match="is the process of 2 nodes: careful-1"):
            run.ask("debug", "careful")
        refusal = run.shell("loglevel", "careful", "debug").stderr
        assert "careful does not offer" in refusal
        assert "--log-level careful=debug" in refusal
        before = pid_of(run)
        run.ask("restart", "composed-1")
        assert pid_of(run) != before
        started = f"process started with pid [{pid_of(run)}]"
        wait_until(lambda: "[usual-2] [INFO]" in run.screen.partition(started)[2], "its lines")
        lines = [line["text"] for line in run.ask("logs", "composed-1")["lines"]]
        assert "[careful-1] careful was stopped" in lines
        folder = Path(run.connect().hello["run"]["log_dir"])
        with pytest.raises(ControlError, match="a run with composed nodes cannot be reloaded"):
            run.ask("reload")
        end(run)
    assert "[careful-1] careful was stopped" in (folder / "launch.log").read_text()


@pytest.mark.parametrize("verb", ["stop", pytest.param("kill", marks=pytest.mark.thorough)])
def test_a_group_that_a_user_stops_is_held_and_may_be_started_again(bench: ControlBench, verb: str):
    actions = f"{plain('careful')}, {plain('careful', name='other')}"
    with bench.launch(actions, "--compose", "*") as run:
        wait_until_both_log(run)
        options = {"signal": int(signal.SIGINT)} if verb == "kill" else {}
        run.ask(verb, "composed-1", **options)
        assert run.row("composed-1")["state"] == "STOPPED"
        run.ask("start", "composed-1")
        wait_until_both_log(run)
        before = pid_of(run)
        run.ask("restart", "composed-1")
        wait_until_both_log(run)
        assert pid_of(run) != before
        end(run)
    assert run.screen.count("\n[careful-1] careful was stopped") == 3
    assert run.screen.count("\n[other-2] other was stopped") == 3


def wait_until_both_log(run: ControlledRun) -> None:
    """In the life of their process that runs now."""
    started = f"process started with pid [{pid_of(run)}]"
    for name in ("careful-1", "other-2"):
        text = f"[{name}] [INFO]"
        wait_until(lambda text=text: text in run.screen.partition(started)[2], text)


def test_an_edit_of_one_program_restarts_the_group(bench: ControlBench):
    program = bench.folder / "edited.py"
    text = PROGRAM.read_text()
    program.write_text(text)
    on_exit = ", on_exit=__import__('launch').actions.Shutdown()"
    edited = plain("careful", more=on_exit).replace(str(PROGRAM), str(program))
    with bench.launch(f"{edited}, {plain('usual')}", "--compose", "*", "--watch") as run:
        run.wait_for("[careful-1] [INFO]")
        run.wait_for("[usual-2] [INFO]")
        before = pid_of(run)
        wait_until(lambda: "edited.py" in str(run.ask("watch")), "it is watched")
        program.write_text(text.replace("was stopped", "was ended"))
        run.wait_for("[careful-1] careful was stopped")
        wait_until(lambda: pid_of(run) not in (None, before), "the new process")
        started = f"process started with pid [{pid_of(run)}]"
        wait_until(lambda: "[careful-1] [INFO]" in run.screen.partition(started)[2], "its lines")
        run.ask("quit")
        assert run.exit_code() == 0, run.screen
    assert "[careful-1] careful was ended" in run.screen


def test_log_levels_are_those_of_each_node(bench: ControlBench):
    program = ["-m", "tests.support.logging_node"]
    nodes = ", ".join(
        f"{NODE}(executable=sys.executable, arguments={program!r}, exec_name={name!r}, "
        f"name={name!r}, cwd={str(REPOSITORY)!r}, output='screen')"
        for name in ("a", "b")
    )
    with bench.launch(nodes, "--compose", "*", "--log-level", "a=debug,b=error") as run:
        for process, level in (("a-1", "DEBUG"), ("b-2", "ERROR")):
            run.wait_for(f"[{process}] [{level}]")
        end(run)
    assert "[b-2] [INFO]" not in run.screen
    assert "[b-2] [DEBUG]" not in run.screen


def test_what_is_started_later_and_what_is_not_there_is_told(bench: ControlBench):
    late = f"TimerAction(period=0.5, actions=[{plain('words', name='late')}])"
    actions = f"{plain('words')}, {plain('words', name='more')}, {late}, sh('true', name='tool')"
    with bench.launch(actions, "--compose", "[wmlt]*", "--compose", "robto_*") as run:
        assert run.exit_code() == 0, run.screen
    assert "composed-1 is one process for 2 nodes: words-1, more-2" in run.screen
    assert "late-4 is not composed: it is not started at the beginning of the run" in run.screen
    assert "tool-3 is not composed: it is not started as a ROS node" in run.screen
    assert "--compose 'robto_*' matches no process of the whole run" in run.screen


def test_a_plan_tells_of_the_groups(bench: ControlBench):
    late = f"TimerAction(period=0.5, actions=[{plain('words', name='late')}])"
    words = ["--compose", "*", "-p"]
    done = bench.run(f"{plain('words')}, {plain('words', name='more')}, {late}", *words)
    out = done.stdout.decode()
    assert done.returncode == 0, done.stderr
    assert "note: composed-1 is one process for 2 nodes: words-1, more-2" in out
    assert "note: late-3 is not composed: it is not started at the beginning of the run" in out


@pytest.mark.thorough
def test_nodes_that_pkg_create_makes(bench: ControlBench, tmp_path: Path):
    env = {**bench.env, "TMPDIR": str(bench.runtime)}
    create = ["pkg", "create", "demo", "--node-name", "talker", "--node-name", "listener"]
    launcher = [sys.executable, "-m", "launcher"]
    subprocess.run([*launcher, *create], cwd=tmp_path, env=env, check=True, capture_output=True)
    run = subprocess.Popen(
        [*launcher, "demo/launch/demo.launch.py", "--compose", "*", "period_s:=0.1"],
        cwd=tmp_path,
        env=env,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert run.stdout is not None
    seen = ""
    for line in run.stdout:
        seen += line
        if {"[talker-1] [INFO]", "[listener-2] [INFO]"} <= set(
            re.findall(r"\[\S+\] \[INFO\]", seen)
        ):
            run.send_signal(signal.SIGINT)
            break
    seen += rest_of(run)[0]
    assert run.returncode == 0, seen
    for name in ("talker-1", "listener-2"):
        assert f"[INFO] [{name}]: node has finished cleanly in composed-1" in seen


@pytest.mark.thorough
def test_the_whole_system_in_one_process(bench: ControlBench):
    """The monitor has a MultiThreadedExecutor with callback groups of its own."""
    names = ("dispatcher", "monitor", "robot_1", "robot_2", "robot_3")
    actions = ", ".join(
        f"{NODE}(package='group_gp1', executable={name!r}, output='screen')" for name in names
    )
    with bench.launch(actions, "--compose", "*") as run:
        for number in (1, 2, 3):
            report = rf"\[monitor-2\].*robot_{number}: [1-9]\d* tasks"
            wait_until(lambda r=report: re.search(r, run.screen), f"tasks of robot {number}")
        assert len(run.ask("ps")["processes"]) == 1
        end(run)
    assert run.screen.count("node has finished cleanly in composed-1") == len(names)
