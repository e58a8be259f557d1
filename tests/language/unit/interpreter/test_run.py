"""The interpreter: order of effects, events, and the end of a run."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import ExitCode, LaunchFileError
from launcher.base.model import events as model
from launcher.base.model.spec import RestartMode
from launcher.language.actions.coroutine import OpaqueCoroutine
from launcher.language.actions.event_actions import (
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launcher.language.actions.process import (
    ExecuteProcess,
    OnProcessExit,
    OnProcessIO,
    OnProcessStart,
)
from launcher.language.actions.timer import TimerAction
from launcher.language.events.handlers import OnShutdown
from launcher.language.events.launch import Shutdown as ShutdownEvent
from launcher.language.events.launch import matches_action
from launcher.language.events.process import ProcessStdin, ShutdownProcess, SignalProcess
from launcher.language.ros.node import Node
from launcher.language.substitution import TextSubstitution
from launcher.language.substitutions.configuration import LaunchConfiguration
from tests.language.unit.interpreter.interpreting import (
    interpreting,
    kinds,
    notices,
    started,
    texts,
)


def process(name: str = "p", **options: Any) -> ExecuteProcess:
    return ExecuteProcess(cmd=["program"], name=name, **options)


def test_processes_start_after_everything_was_visited():
    with interpreting([process("a"), LogInfo(msg="b"), process("c")]) as interpreter:
        effects = interpreter.start()

    assert kinds(effects) == ["LogMessage", "StartProcess", "StartProcess"]
    assert [effect.spec.name for effect in started(effects)] == ["a-1", "c-2"]


def test_a_fault_in_the_static_part_starts_nothing_and_names_the_line():
    with interpreting([process(), LogInfo(msg=LaunchConfiguration("nope"))]) as interpreter:
        with pytest.raises(LaunchFileError, match="'nope' does not exist") as caught:
            interpreter.start()

        assert interpreter.take_effects() == []
    assert caught.value.exit_code == ExitCode.USAGE
    assert str(caught.value.where).startswith(f"{__file__}:")


def test_a_started_process_wakes_its_handler():
    first = process("first")
    handler = RegisterEventHandler(OnProcessStart(target_action=first, on_start=[process("next")]))
    with interpreting([handler, first]) as interpreter:
        effects = interpreter.start()
        answer = model.ProcessStarted(process_id=started(effects)[0].process_id, pid=7)

        assert [e.spec.name for e in started(interpreter.handle(answer))] == ["next-2"]
    assert first.process_details is not None
    assert first.process_details["pid"] == 7


def test_only_handlers_of_the_launch_file_may_start_more():
    quiet = ExecuteProcess(cmd=["a"])
    reacting = ExecuteProcess(cmd=["a"], on_exit=[ExecuteProcess(cmd=["b"])])
    for action, may_start_more in ((quiet, False), (reacting, True)):
        with interpreting([action]) as interpreter:
            interpreter.start()
            assert interpreter.may_start_more is may_start_more


def test_an_exit_reaches_on_exit_with_its_code():
    def tell(event: Any, context: Any) -> LogInfo:
        return LogInfo(msg=f"{event.process_name} gave {event.returncode}")

    with interpreting([process("p", on_exit=tell), process("other")]) as interpreter:
        first = started(interpreter.start())[0].process_id
        exited = model.ProcessExited(process_id=first, pid=1, returncode=3)

        assert texts(interpreter.handle(exited)) == ["p-1 gave 3"]


def test_a_process_that_is_restarted_keeps_the_run_alive():
    with interpreting([process(respawn=True, respawn_delay=1.5)]) as interpreter:
        (start,) = started(interpreter.start())
        ended = model.ProcessExited(
            process_id=start.process_id, pid=1, returncode=0, will_restart=True
        )

        assert start.spec.restart.mode is RestartMode.ALWAYS
        assert start.spec.restart.delay_s == 1.5
        assert interpreter.handle(ended) == []
        assert interpreter.handle(model.ProcessStarted(process_id=start.process_id, pid=2)) == []


def test_a_run_without_processes_is_shut_down_as_idle():
    with interpreting([process()]) as interpreter:
        (start,) = started(interpreter.start())
        effects = interpreter.handle(
            model.ProcessExited(process_id=start.process_id, pid=1, returncode=0)
        )

    assert effects == [model.RequestShutdown(reason="idle")]


def test_a_file_without_processes_ends_at_once():
    with interpreting([LogInfo(msg="hi")]) as interpreter:
        effects = interpreter.start()
        assert texts(effects) == ["hi"]
        assert notices(effects) == ["no process was started"]
        assert kinds(effects)[-1] == "RequestShutdown"


def test_a_timer_is_asked_for_and_its_actions_come_when_it_fires():
    with interpreting([TimerAction(period=2.5, actions=[LogInfo(msg="now")])]) as interpreter:
        (later,) = interpreter.start()
        assert isinstance(later, model.CallLater)
        assert later.delay_s == 2.5

        assert texts(interpreter.handle(model.TimerFired(timer_id=later.timer_id))) == ["now"]
        assert interpreter.handle(model.TimerFired(timer_id=later.timer_id)) == []


def test_a_cancelled_timer_never_fires():
    timer = TimerAction(period=1.0, actions=[LogInfo(msg="never")])
    cancel = OpaqueFunction(function=lambda context: timer.cancel())
    soon = TimerAction(period=0.5, actions=[cancel])
    with interpreting([timer, soon, process()]) as interpreter:
        first, second = [e for e in interpreter.start() if isinstance(e, model.CallLater)]

        effects = interpreter.handle(model.TimerFired(timer_id=second.timer_id))
        assert effects == [model.CancelTimer(timer_id=first.timer_id)]
        assert interpreter.handle(model.TimerFired(timer_id=first.timer_id)) == []


def test_a_timer_outlives_a_shutdown_if_the_launch_file_says_so():
    actions = [LogInfo(msg="late"), process("not started")]
    cancelled = TimerAction(period=3.0, actions=[LogInfo(msg="never")])
    kept = TimerAction(period=3.0, actions=actions, cancel_on_shutdown=False)
    with interpreting([cancelled, kept, process()]) as interpreter:
        first, second = [e for e in interpreter.start() if isinstance(e, model.CallLater)]
        assert (first.outlives_shutdown, second.outlives_shutdown) == (False, True)

        effects = interpreter.handle(model.SignalReceived(signum=signal.SIGINT))
        assert effects[0] == model.CancelTimer(timer_id=first.timer_id)
        assert kinds(effects) == ["CancelTimer", "RequestShutdown"]
        effects = interpreter.handle(model.TimerFired(timer_id=second.timer_id))
        assert (texts(effects), started(effects)) == (["late"], [])


def test_ctrl_c_runs_the_shutdown_handlers_before_the_request():
    handler = OnShutdown(on_shutdown=[LogInfo(msg="bye"), process("saver")])
    with interpreting([RegisterEventHandler(handler), process()]) as interpreter:
        interpreter.start()
        effects = interpreter.handle(model.SignalReceived(signum=signal.SIGINT))

    assert kinds(effects) == ["LogMessage", "RequestShutdown", "StartProcess"]
    assert [e.reason for e in effects if isinstance(e, model.RequestShutdown)] == [
        "ctrl-c (SIGINT)"
    ]


def test_shutdown_in_the_list_starts_none_of_its_processes():
    with interpreting([process(), Shutdown(reason="enough"), process()]) as interpreter:
        message, shutdown = interpreter.start()
        assert notices([message]) == [
            "no process was started, since the launch file requests a shutdown: enough"
        ]
        assert shutdown == model.RequestShutdown(reason="enough")


def test_the_reason_of_a_shutdown_may_be_substitutions():
    reason = [TextSubstitution(text="no "), LaunchConfiguration("what", default="map")]
    with interpreting([process(), Shutdown(reason=reason)]) as interpreter:
        assert interpreter.start()[-1] == model.RequestShutdown(reason="no map")


@pytest.mark.parametrize(
    ("event", "reason"), [(ShutdownEvent, "reason not given"), (ShutdownEvent(reason=5), "5")]
)
def test_a_class_or_any_reason_shuts_down_as_in_ros2(event: Any, reason: str):
    with interpreting([process(), EmitEvent(event=event)]) as interpreter:
        assert interpreter.start()[-1] == model.RequestShutdown(reason=reason)


@pytest.mark.parametrize("noninteractive", [False, True])
def test_a_shutdown_due_to_sigint_means_that_the_terminal_has_signalled(noninteractive):
    event = ShutdownEvent(reason="ctrl-c", due_to_sigint=True)
    emits = EmitEvent(event=event)
    with interpreting([process(), emits], noninteractive=noninteractive) as interpreter:
        shutdown = interpreter.start()[-1]
    assert shutdown == model.RequestShutdown(reason="ctrl-c", is_interrupted=not noninteractive)


def test_a_sigint_of_the_launcher_alone_has_not_reached_the_processes():
    with interpreting([process()]) as interpreter:
        interpreter.start()
        effects = interpreter.handle(model.SignalReceived(signum=signal.SIGINT))
    assert effects == [model.RequestShutdown(reason="ctrl-c (SIGINT)")]


def test_a_fault_in_a_handler_ends_the_run_and_is_kept():
    broken = OpaqueFunction(function=lambda context: 1 / 0)
    with interpreting([process(on_exit=[broken]), process()]) as interpreter:
        first = started(interpreter.start())[0].process_id
        effects = interpreter.handle(model.ProcessExited(process_id=first, pid=1, returncode=0))

        assert kinds(effects) == ["LogMessage", "RequestShutdown"]
        assert interpreter.failure is not None
        assert "division by zero" in interpreter.failure.message


def test_a_fault_without_a_text_is_named_by_its_class():
    def fail(context: Any) -> None:
        raise AssertionError

    with interpreting([TimerAction(period=1.0, actions=[OpaqueFunction(function=fail)])]) as run:
        (later,) = run.start()
        assert isinstance(later, model.CallLater)
        (notice,) = notices(run.handle(model.TimerFired(timer_id=later.timer_id)))
    assert notice.endswith("(see debug for traceback): AssertionError")


def test_a_shutdown_handler_that_fails_too_does_not_stop_the_stopping():
    broken = OpaqueFunction(function=lambda context: 1 / 0)
    handler = RegisterEventHandler(OnShutdown(on_shutdown=[broken]))
    timer = TimerAction(period=600.0, actions=[], cancel_on_shutdown=False)
    with interpreting([handler, timer, process(on_exit=[broken]), process()]) as interpreter:
        first = started(interpreter.start())[0].process_id
        effects = interpreter.handle(model.ProcessExited(process_id=first, pid=1, returncode=0))

    assert kinds(effects)[-2:] == ["CancelTimer", "RequestShutdown"]


@pytest.mark.parametrize(
    ("event", "effect"),
    [
        (
            lambda p: SignalProcess(signal_number="SIGUSR1", process_matcher=matches_action(p)),
            lambda i: model.SignalProcess(process_id=i, signum=signal.SIGUSR1),
        ),
        (
            lambda p: ShutdownProcess(process_matcher=matches_action(p)),
            lambda i: model.StopProcess(process_id=i),
        ),
        (
            lambda p: ProcessStdin(text=b"go\n", **{**p.process_details, "pid": 1}),
            lambda i: model.WriteStdin(process_id=i, data=b"go\n"),
        ),
    ],
    ids=["signal", "stop", "stdin"],
)
def test_events_for_a_process_become_effects(event: Any, effect: Any):
    target = process()
    emit = OpaqueFunction(function=lambda context: [EmitEvent(event=event(target))])
    timer = TimerAction(period=1.0, actions=[emit])
    with interpreting([target, process("other"), timer]) as interpreter:
        effects = interpreter.start()
        (later,) = [e for e in effects if isinstance(e, model.CallLater)]
        answered = interpreter.handle(model.TimerFired(timer_id=later.timer_id))

    assert effect(started(effects)[0].process_id) in answered


def test_only_output_that_a_handler_wants_is_asked_for():
    loud, quiet = process("loud"), process("quiet")
    handler = OnProcessIO(
        target_action=loud, on_stdout=lambda event: LogInfo(msg=event.text.decode())
    )
    with interpreting([RegisterEventHandler(handler), loud, quiet]) as interpreter:
        first, second = (start.process_id for start in started(interpreter.start()))
        written = model.ProcessOutput(process_id=first, stream="stdout", data=b"ready")

        assert interpreter.watches_output(first)
        assert not interpreter.watches_output(second)
        assert texts(interpreter.handle(written)) == ["ready"]


def test_cached_output_can_be_read_after_the_end():
    noisy = process(cached_output=True)
    with interpreting([noisy]) as interpreter:
        (start,) = started(interpreter.start())
        for stream, data in (("stdout", b"out"), ("stderr", b"err")):
            interpreter.handle(
                model.ProcessOutput(process_id=start.process_id, stream=stream, data=data)
            )

    assert (noisy.get_stdout(), noisy.get_stderr()) == ("out", "err")


def test_a_process_that_cannot_be_spawned_ends_without_ending_the_others():
    with interpreting([process("a"), process("b")]) as interpreter:
        first, _ = started(interpreter.start())
        failed = model.SpawnFailed(process_id=first.process_id, errno=2, reason="no such file")

        assert interpreter.handle(failed) == []


def test_a_coroutine_sleeps_on_the_drivers_timers():
    import asyncio

    async def wait(context: Any) -> None:
        await asyncio.sleep(4.0)
        context.emit_event_sync(ShutdownProcess(process_matcher=lambda action: True))

    with interpreting([process(), OpaqueCoroutine(coroutine=wait)]) as interpreter:
        effects = interpreter.start()
        (later,) = [e for e in effects if isinstance(e, model.CallLater)]
        assert later.delay_s == 4.0

        stop = model.StopProcess(process_id=started(effects)[0].process_id)
        assert interpreter.handle(model.TimerFired(timer_id=later.timer_id)) == [stop]


def test_generated_files_are_there_during_the_run_and_gone_after_it():
    with interpreting([Node(executable="x", parameters=[{"a": 1}])]) as interpreter:
        (start,) = started(interpreter.start())
        assert start.spec.ros is not None
        (source,) = start.spec.ros.parameters
        assert source.generated == {"/**": {"ros__parameters": {"a": 1}}}
        assert Path(str(source.file)).read_text() == "/**:\n  ros__parameters:\n    a: 1\n"

    assert not Path(str(source.file)).exists()


def test_the_environment_of_the_run_is_given_back(monkeypatch: pytest.MonkeyPatch):
    from launcher.language.actions.configuration import SetEnvironmentVariable

    monkeypatch.setenv("KEPT", "before")
    changes = [SetEnvironmentVariable("KEPT", "after"), SetEnvironmentVariable("NEW", "x")]
    with interpreting([*changes, process()]) as interpreter:
        (start,) = started(interpreter.start())
        assert os.environ["KEPT"] == "after"

    assert (start.spec.env["KEPT"], start.spec.env["NEW"]) == ("after", "x")
    assert os.environ["KEPT"] == "before"
    assert "NEW" not in os.environ


def test_an_environment_can_be_handed_in():
    with interpreting([process()], environment={"ONLY": "this"}) as interpreter:
        (start,) = started(interpreter.start())

    assert dict(start.spec.env) == {"ONLY": "this"}


def test_an_on_exit_handler_registered_later_is_asked_first():
    first = process("p", on_exit=[LogInfo(msg="own")])
    late = RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[LogInfo(msg="late")]))
    with interpreting([first, late, process()]) as interpreter:
        start = started(interpreter.start())[0]
        ended = model.ProcessExited(process_id=start.process_id, pid=1, returncode=0)

        assert texts(interpreter.handle(ended)) == ["late", "own"]


def test_what_a_launch_file_sets_while_it_is_loaded_counts_as_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    from launcher.launch.plan import plan_json
    from launcher.launch.plan.planner import make_plan

    monkeypatch.delenv("SET_WHILE_LOADING", raising=False)
    file = tmp_path / "sets.launch.py"
    file.write_text(
        "import os\n"
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess, GroupAction\n"
        "def generate_launch_description():\n"
        "    os.environ['SET_WHILE_LOADING'] = 'yes'\n"
        "    clean = GroupAction([ExecuteProcess(cmd=['b'])], forwarding=False)\n"
        "    return LaunchDescription([ExecuteProcess(cmd=['a']), clean])\n"
    )

    first, second = plan_json.document(make_plan(str(file), []))["processes"]

    assert first["env_set"] == {"SET_WHILE_LOADING": "yes"}
    assert second["env_set"] == {}
    assert "SET_WHILE_LOADING" not in os.environ
