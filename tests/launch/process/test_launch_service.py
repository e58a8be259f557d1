"""LaunchService in scripts that import `launcher.api`, or that the launcher starts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from tests.support.waiting import wait_until

DEADLINE_S = 60.0

HEAD = """
import asyncio, os, sys, threading, time
from launch import LaunchDescription, LaunchService
from launch.actions import *
from launch.event_handlers import OnProcessExit, OnProcessIO, OnShutdown
from launch.events.process import ShutdownProcess
from launch.events import matches_action
import launch.logging

def sleeper(**options):
    return ExecuteProcess(cmd=["sleep", "1000"], **options)  # ends by SIGINT at any time
"""


def write(tmp_path: Path, text: str, head: str = "import launcher.api") -> Path:
    script = tmp_path / "script.py"
    script.write_text(head + HEAD + textwrap.dedent(text))
    return script


def completed(words: list[str], tmp_path: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
        stdin=subprocess.DEVNULL,
    )


def lines_of(result: subprocess.CompletedProcess[str], mark: str = "> ") -> list[str]:
    return [line[len(mark) :] for line in result.stdout.splitlines() if line.startswith(mark)]


TWICE = """
print("> before", flush=True)
launch.logging.get_logger("mine").info("printed at once")
service = LaunchService(argv=["some:=argument"])
out = []

def description(code):
    process = ExecuteProcess(cmd=["sh", "-c", f"echo said; exit {code}"], output="screen")
    respawned = ExecuteProcess(
        cmd=["sh", "-c", "echo again"], respawn=True, respawn_delay=0.01, respawn_max_retries=2
    )
    ended = lambda event, context: out.append(("exit", event.returncode))
    note = lambda context, what: out.append((what,))
    stopped = lambda event, context: out.append(("shutdown", event.reason))
    ready = lambda event: out.append(("io", event.text.decode()))
    return LaunchDescription([
        process,
        respawned,
        TimerAction(period=0.05, actions=[OpaqueFunction(function=note, args=["timer"])]),
        RegisterEventHandler(OnProcessExit(target_action=process, on_exit=ended)),
        RegisterEventHandler(OnProcessIO(target_action=respawned, on_stdout=ready)),
        RegisterEventHandler(OnShutdown(on_shutdown=stopped)),
    ])

for code in (0, 3):
    service.include_launch_description(description(code))
    print(">", service.run(), service.event_loop, service.context.is_shutdown, flush=True)
    print(">", sorted(out), flush=True)
    out.clear()
print(">", service.context.argv)
"""


@pytest.mark.parametrize("how", ["import", "launcher"])
def test_a_script_runs_a_service_twice(how, tmp_path: Path):
    if how == "import":
        words = [sys.executable, str(write(tmp_path, TWICE))]
    else:
        script = write(tmp_path, TWICE, head="import sys; print('>', sys.argv[1:])")
        words = [sys.executable, "-m", "launcher", str(script), "a:=b", "--no-console"]

    result = completed(words, tmp_path)

    said = lines_of(result)
    if how == "launcher":
        assert said.pop(0) == "['a:=b']"
    happened = [("io", "again\n")] * 3 + [("shutdown", "idle"), ("timer",)]
    assert said == [
        "before",
        "0 None True",
        str(sorted([("exit", 0), *happened])),
        "0 None True",
        str(sorted([("exit", 3), *happened, ("shutdown", "idle")])),
        "['some:=argument']",
    ], result.stderr
    assert result.returncode == 0
    assert result.stdout.index("[INFO] [mine]: printed at once") < result.stdout.index("All log")
    assert "\n[sh-1] said\n" in result.stdout


INTERRUPTED = """
from launch.event_handlers import OnProcessStart
from launch.events import Shutdown as ShutdownEvent

for noninteractive in (False, True):
    codes = []
    ended = lambda event, context: codes.append(event.returncode)
    process = sleeper(sigterm_timeout="0.1", on_exit=ended)
    stop = EmitEvent(event=ShutdownEvent(reason="over", due_to_sigint=True))
    handler = OnProcessStart(target_action=process, on_start=[stop])
    service = LaunchService(noninteractive=noninteractive)
    service.include_launch_description(LaunchDescription([process, RegisterEventHandler(handler)]))
    print(">", service.run(), codes, flush=True)
"""


def test_a_shutdown_due_to_sigint_sends_none_where_the_terminal_has(tmp_path: Path):
    result = completed([sys.executable, str(write(tmp_path, INTERRUPTED))], tmp_path)

    assert lines_of(result) == ["0 [-15]", "0 [-2]"], result.stderr


FROM_THREADS = """
service = LaunchService()
one, two = sleeper(), sleeper()
seen = []
started = threading.Event()
note = lambda event, context: (seen.append("started"), started.set())[0]
from launch.event_handlers import OnProcessStart
service.include_launch_description(LaunchDescription([
    RegisterEventHandler(OnProcessStart(on_start=note)),
    RegisterEventHandler(OnProcessExit(on_exit=lambda e, c: seen.append(e.returncode))),
    RegisterEventHandler(OnShutdown(on_shutdown=lambda e, c: seen.append(e.reason))),
]))

def work():
    for process in (one, two):
        started.clear()
        service.include_launch_description(LaunchDescription([process]))
        assert started.wait(60)
    service.emit_event(ShutdownProcess(process_matcher=matches_action(one)))
    while one.return_code not in seen:  # it is known before the handler is called
        time.sleep(0.01)
    try:
        service.run()
    except RuntimeError as error:
        seen.append(str(error))
    service.shutdown()

thread = threading.Thread(target=MAIN)
thread.start()
CODE
thread.join()
print(">", code)
print(">", seen)
"""


@pytest.mark.parametrize("main", [True, False])
def test_events_and_the_shutdown_come_from_another_thread(main, tmp_path: Path):
    run = "service.run(shutdown_when_idle=False)"
    if main:
        text = FROM_THREADS.replace("MAIN", "work").replace("CODE", f"code = {run}")
    else:  # the service runs in a thread
        text = FROM_THREADS.replace("MAIN", f"lambda: globals().update(code={run})")
        text = text.replace("CODE", "work()")
    result = completed([sys.executable, str(write(tmp_path, text))], tmp_path)

    code, seen = lines_of(result)
    assert code == "0", result.stderr
    assert seen == str(
        [
            "started",
            "started",
            -2,
            "this LaunchService is already running",
            "LaunchService.shutdown() called",
            -2,
        ]
    )


ASYNC = """
from launch.event_handlers import OnProcessStart

def started(function):
    return RegisterEventHandler(OnProcessStart(on_start=lambda event, context: function()))

async def main():
    service = LaunchService()
    ready = asyncio.Event()

    async def ask():
        await ready.wait()
        for _ in range(10):
            await asyncio.sleep(0.001)
        print("> task", service.task is running, service.event_loop is not None)
        await service.shutdown()

    asking = asyncio.create_task(ask())
    service.include_launch_description(LaunchDescription([started(ready.set), sleeper()]))
    running = asyncio.create_task(service.run_async())
    print(">", await running, service.task)

    def cancel():
        cancelled.cancel()

    service.include_launch_description(LaunchDescription([
        RegisterEventHandler(OnProcessExit(on_exit=lambda e, c: print("> ended", e.returncode))),
        started(cancel),
        sleeper(),
    ]))
    cancelled = asyncio.create_task(service.run_async())
    print("> cancelled", await cancelled)

asyncio.run(main())

# The loop pauses between two calls of run_until_complete.
loop, service, ready = asyncio.new_event_loop(), LaunchService(), asyncio.Event()
service.include_launch_description(LaunchDescription([started(ready.set), sleeper()]))
running = loop.create_task(service.run_async())
loop.run_until_complete(ready.wait())
stopping = loop.create_task(service.shutdown())
print("> paused", loop.run_until_complete(running), stopping.done(), service.shutdown())
"""


def test_a_service_runs_within_an_asyncio_loop(tmp_path: Path):
    result = completed([sys.executable, str(write(tmp_path, ASYNC))], tmp_path)

    assert lines_of(result) == [
        "task True True",
        "0 None",
        "ended -2",
        "cancelled 1",
        "paused 0 True None",
    ], result.stderr


WAITED_FOR = """
from launch.event_handlers import OnProcessStart

loop, service = asyncio.new_event_loop(), LaunchService()

def waited_for(*entities):
    ready = asyncio.Event()
    set_ready = OpaqueFunction(function=lambda context: ready.set())
    service.include_launch_description(LaunchDescription([*entities, set_ready]))
    running = loop.create_task(service.run_async())
    loop.run_until_complete(ready.wait())
    return running

running = waited_for()
loops = service.event_loop, service.context.asyncio_loop
print("> seen", *(one is loop for one in loops), service._is_idle())
print(">", loop.run_until_complete(running), service.event_loop, service._is_idle())

running = waited_for(ExecuteProcess(cmd=["true"]))
started = lambda event, context: print("> started")
service.context.register_event_handler(OnProcessStart(on_start=started))
print(">", loop.run_until_complete(running))

def later(context):
    future = context.asyncio_loop.create_future()
    context.add_completion_future(future)
    context.asyncio_loop.call_later(0.1, future.set_result, None)

print(">", loop.run_until_complete(waited_for(OpaqueFunction(function=later))))
"""


def test_who_waits_for_an_action_within_an_asyncio_loop_sees_the_rest(tmp_path: Path):
    result = completed([sys.executable, str(write(tmp_path, WAITED_FOR))], tmp_path)

    assert lines_of(result) == ["seen True True False", "0 None True", "started", "0", "0"], (
        result.stderr
    )


ROS_NODE = """
from launch_ros.ros_adapters import get_ros_adapter, get_ros_node

on_interrupt = lambda: __import__("signal").getsignal(2)
before, nodes, names, service = on_interrupt(), [], [], LaunchService()

def ask(context):
    nodes.append(get_ros_node(context))
    names.append(nodes[-1].get_name())
    assert get_ros_node(context) is nodes[-1]
    nodes[-1].create_timer(0.001, service.shutdown)  # called by the thread of the node

for _ in range(2):
    actions = [OpaqueFunction(function=ask), sleeper()]
    service.include_launch_description(LaunchDescription(actions))
    print(">", service.run(), names[-1] == f"launch_ros_{os.getpid()}")
print(">", nodes[0] is nodes[1], get_ros_adapter(service.context).ros_node in nodes)
print(">", on_interrupt() is before)
"""


def test_a_script_has_a_ros_node_if_it_asks_for_one(tmp_path: Path):
    result = completed([sys.executable, str(write(tmp_path, ROS_NODE))], tmp_path)

    assert lines_of(result) == ["0 True", "0 True", "False False", "True"], result.stderr
    assert result.returncode == 0


SIGNALLED = """
signal_is = lambda: __import__("signal").getsignal(2)
before = signal_is()
service = LaunchService()
service.include_launch_description(LaunchDescription([
    sleeper(),
    RegisterEventHandler(OnProcessStart(on_start=lambda e, c: print(f"> {e.pid}", flush=True))),
    RegisterEventHandler(OnShutdown(on_shutdown=lambda e, c: print(f"> {e.reason}", flush=True))),
]))
code = service.run()
print(">", code, signal_is() is before, flush=True)
"""


@pytest.mark.parametrize(
    ("signum", "reason", "code"),
    [(signal.SIGINT, "ctrl-c (SIGINT)", 0), (signal.SIGTERM, "SIGTERM", 1)],
)
def test_a_signal_stops_the_service_in_order(signum, reason, code, tmp_path: Path):
    text = "from launch.event_handlers import OnProcessStart\n" + textwrap.dedent(SIGNALLED)
    script = write(tmp_path, text)
    output = tmp_path / "output"
    with output.open("w") as file:
        process = subprocess.Popen(
            [sys.executable, str(script)], stdout=file, stderr=subprocess.STDOUT, cwd=tmp_path
        )

    def said() -> list[str]:
        return [line[2:] for line in output.read_text().splitlines() if line.startswith("> ")]

    try:
        wait_until(said, "the process is started")
        process.send_signal(signum)
        process.wait(DEADLINE_S)
    finally:
        process.kill()
    pid, *rest = said()
    assert rest == [reason, f"{code} True"], output.read_text()
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid), 0)


FAILS = """
service = LaunchService()
def fail(context):
    raise ValueError("on purpose")
async def coroutine(context):
    await asyncio.sleep(0.01)
    ended.append("coroutine")
ended = []
service.include_launch_description(LaunchDescription([OpaqueCoroutine(coroutine=coroutine)]))
print(">", service.run(), ended)
ended.clear()
service.include_launch_description(LaunchDescription([
    sleeper(on_exit=lambda event, context: ended.append(event.returncode)),
    OpaqueFunction(function=fail),
    sleeper(),
]))
print(">", service.run(), ended)
"""


def test_an_exception_in_the_launch_is_1_after_what_had_started_has_ended(tmp_path: Path):
    script = write(tmp_path, FAILS)

    result = completed([sys.executable, str(script)], tmp_path)

    line = 1 + script.read_text().splitlines().index('    raise ValueError("on purpose")')
    assert lines_of(result) == ["0 ['coroutine']", "1 [-2]"]
    assert f"error: {script}:{line}: on purpose" in result.stderr


def test_a_launch_file_cannot_run_a_service(tmp_path: Path):
    text = """
        def generate_launch_description():
            LaunchService().run()
    """
    script = write(tmp_path, text, head="")
    result = completed([sys.executable, "-m", "launcher", "plan", str(script)], tmp_path)

    assert result.returncode == 2
    assert "LaunchService.run() is not available inside of a launch file" in result.stderr


def test_a_service_may_name_its_log_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    script = write(
        tmp_path,
        """
service = LaunchService(log_file_name="svc")
service.include_launch_description(LaunchDescription([LogInfo(msg="a fact")]))
raise SystemExit(service.run())
""",
    )
    done = completed([sys.executable, str(script)], tmp_path)

    assert done.returncode == 0, done.stderr
    assert "[INFO] [svc]: All log files can be found below" in done.stdout
    assert "a fact" in (tmp_path / "log/latest/svc.log").read_text()
    logs = completed([sys.executable, "-m", "launcher", "logs"], tmp_path)
    assert logs.stderr.endswith("/svc.log\n")
