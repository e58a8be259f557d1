"""Facts about ROS 2's public classes that scripts and tests of other people rely on."""

from __future__ import annotations

import asyncio
import io
import os
import signal
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import Mock, NonCallableMock, patch

import pytest

from launcher.language.compat import vocabulary
from tests.language.unit.interpreter.interpreting import texts


@pytest.fixture(autouse=True)
def _open_vocabulary() -> Iterator[None]:
    with vocabulary():
        yield


class Bare:
    """A context as small as tests of actions make it."""

    def would_handle_event(self, event: Any) -> bool:
        return False

    def get_locals_as_dict(self) -> dict[str, Any]:
        return {}


# ---- entities


def test_an_entity_has_nothing_and_does_not_describe_itself():
    from launch import LaunchDescriptionEntity

    entity = LaunchDescriptionEntity()

    with pytest.raises(NotImplementedError):
        entity.describe()
    assert entity.visit(Bare()) is None
    assert (entity.describe_sub_entities(), entity.get_asyncio_future()) == ([], None)


def test_actions_and_descriptions_are_visited_with_any_context():
    from launch import Action, LaunchDescription, LaunchDescriptionEntity

    assert Action().visit(Bare()) is None
    assert "Action" in Action().describe()
    old = LaunchDescription([LaunchDescriptionEntity(), Action()], deprecated_reason="use another")
    assert len(old.visit(Bare())) == 2
    assert (old.deprecated, old.deprecated_reason) == (True, "use another")


def test_futures_are_collected_in_the_order_of_the_visits():
    from launch import LaunchContext, LaunchDescriptionEntity
    from launch.utilities import visit_all_entities_and_collect_futures

    class Leaf(LaunchDescriptionEntity):
        def get_asyncio_future(self) -> str:
            return "leaf"

    class Branch(LaunchDescriptionEntity):
        def __init__(self, left: int) -> None:
            self.left = left

        def get_asyncio_future(self) -> str:
            return f"branch {self.left}"

        def visit(self, context: Any) -> Any:
            below = [Leaf(), LaunchDescriptionEntity(), Branch(self.left - 1)]
            return below if self.left else None

    found = visit_all_entities_and_collect_futures(Branch(2), LaunchContext())

    assert [future for _, future in found] == ["branch 2", "leaf", "branch 1", "leaf", "branch 0"]


@pytest.mark.parametrize(
    ("name", "value", "equal"),
    [("a", "x", True), ("a", None, False), ("a", "y", False), ("b", None, True), ("b", "", False)],
)
def test_the_old_conditions_are_deprecated_and_work_with_any_context(name, value, equal):
    from launch.conditions import LaunchConfigurationEquals, LaunchConfigurationNotEquals

    class Context:
        launch_configurations = {"a": "x"}

        def perform_substitution(self, substitution: Any) -> str:
            return substitution.perform(self)

    with pytest.warns(UserWarning, match="EqualsSubstitution"):
        assert LaunchConfigurationEquals(name, value).evaluate(Context()) is equal
    with pytest.warns(UserWarning, match="LaunchConfigurationNotEquals is deprecated"):
        assert LaunchConfigurationNotEquals(name, value).evaluate(Context()) is not equal


@pytest.mark.parametrize("name", ["Info", "Debug", "Warning", "Error"])
def test_a_log_action_has_its_level(name):
    import launch.actions
    from launch import LaunchContext
    from launch.utilities import perform_substitutions

    action = getattr(launch.actions, f"Log{name}")(msg="text")

    assert perform_substitutions(LaunchContext(), action.level) == name.upper()
    with pytest.raises(KeyError, match="Invalid log level"):
        launch.actions.Log(msg="text", level="loud")
    with pytest.raises(KeyError, match="Invalid log level 'LOUD'"):
        launch.actions.Log(msg="text", level=["lo", "ud"]).execute(LaunchContext())


@pytest.mark.parametrize(
    ("debug", "level", "shown"),
    [(False, None, ["info"]), (True, None, ["debug", "info"]), (False, "DEBUG", ["debug", "info"])],
)
def test_debug_messages_are_shown_on_request(debug: bool, level: str | None, shown: list[str]):
    from launch import LaunchDescription
    from launch.actions import LogDebug, LogInfo
    from launch.logging import get_logger, launch_config

    from launcher.language.interpreter import Interpreter
    from launcher.language.launch_session import current

    current().is_debug = debug
    if level is not None:
        launch_config.level = level
    actions = [LogDebug(msg="debug"), LogInfo(msg="info")]
    interpreter = Interpreter(LaunchDescription(actions))
    try:
        assert texts(interpreter.start()) == shown
        assert get_logger("mine").isEnabledFor(10) is ("debug" in shown)
    finally:
        interpreter.close()


@pytest.mark.parametrize(
    ("given", "name"),
    [("warn", "WARNING"), ("Warning", "WARNING"), ("FATAL", "CRITICAL"), ("error", "ERROR")],
)
def test_a_level_with_two_names_is_printed_as_in_ros_2(given: str, name: str):
    from launch import LaunchDescription
    from launch.actions import Log

    from launcher.language.interpreter import Interpreter

    interpreter = Interpreter(LaunchDescription([Log(msg="x", level=given)]))
    try:
        effects = interpreter.start()
        assert [one.level for one in effects if getattr(one, "text", "") == "x"] == [name]
    finally:
        interpreter.close()


def test_a_log_tag_without_a_level_is_a_log_action_that_newer_releases_deprecate():
    from launch.actions import Log, LogInfo
    from launch.frontend import Parser

    tags = "<log message='a'/><log_info message='b'/><log level='DEBUG' message='c'/>"
    entity, parser = Parser.load(io.StringIO(f"<launch>{tags}</launch>"))
    with pytest.warns(PendingDeprecationWarning, match="<log_info>") as warned:
        actions = parser.parse_description(entity).entities

    assert [type(action) for action in actions] == [LogInfo, LogInfo, Log]
    assert all(isinstance(action, Log) for action in actions)
    assert len(warned) == 1


@pytest.mark.parametrize(
    ("text", "name", "original"),
    [
        ("$(path-join)", "VisitError", ValueError),
        ("$(string-join .)", "VisitError", TypeError),
        ("$(no-such-thing)", "VisitError", RuntimeError),
        ("$(eval '1' '2' '3')", "VisitError", TypeError),
        ("$(not $(env", "UnexpectedEOF", None),
        ("$(not ))", "UnexpectedCharacters", None),
    ],
)
def test_errors_of_substitutions_are_those_of_the_grammar_in_ros_2(text, name, original):
    import lark.exceptions
    from launch.frontend.parse_substitution import parse_substitution

    with pytest.raises(getattr(lark.exceptions, name)) as error:
        parse_substitution(text)

    assert str(error.value) == error.value.message
    assert original is None or isinstance(error.value.orig_exc, original)


def test_the_command_of_an_executable_is_known_without_a_process():
    from launch import LaunchContext
    from launch.descriptions import Executable

    executable = Executable(cmd=["ls", 'one "word"'])
    executable.apply_context(LaunchContext())

    assert executable.final_cmd == ["ls", 'one "word"']


_DETAILS = {"name": "p", "cmd": [], "cwd": None, "env": None, "pid": 1}


def test_a_handler_reacts_to_its_action_and_to_no_other():
    from launch import Action, LaunchContext
    from launch.actions import ExecuteProcess
    from launch.event_handlers import OnProcessExit
    from launch.events.process import ProcessExited

    mine, context, reaction = NonCallableMock(spec=ExecuteProcess), Mock(spec=LaunchContext), Mock()
    handler = OnProcessExit(target_action=mine, on_exit=reaction, handle_once=True)

    event = ProcessExited(action=mine, returncode=0, **_DETAILS)
    assert handler.matches(event)
    assert not handler.matches(ProcessExited(action=Action(), returncode=0, **_DETAILS))
    handler.handle(event, context)
    reaction.assert_called_once_with(event, context)
    context.extend_locals.assert_called_once_with({"event": event})
    context.unregister_event_handler.assert_called_once_with(handler)
    with pytest.raises(TypeError):
        OnProcessExit(target_action=NonCallableMock(), on_exit=reaction)


@pytest.mark.parametrize("what", ["Start", "IO"])
def test_a_target_that_can_be_called_decides_even_if_it_is_an_action(what):
    from launch import event_handlers
    from launch.actions import ExecuteProcess
    from launch.events.process import ProcessIO, ProcessStarted

    class Picky(ExecuteProcess):
        def __call__(self, action: Any) -> bool:
            return action is chosen

    target, chosen = Picky(cmd=["a"]), ExecuteProcess(cmd=["b"])
    on_start = {"on_start": Mock()} if what == "Start" else {}
    handler = getattr(event_handlers, f"OnProcess{what}")(target_action=target, **on_start)
    event, details = (ProcessStarted, {}) if on_start else (ProcessIO, {"text": b"", "fd": 1})

    assert handler.matches(event(action=chosen, **details, **_DETAILS))
    assert not handler.matches(event(action=target, **details, **_DETAILS))


# ---- signals


@pytest.fixture
def _harmless_signals() -> Iterator[None]:
    before = {n: signal.signal(n, lambda *_: None) for n in (signal.SIGUSR1, signal.SIGUSR2)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("_harmless_signals")
def test_a_signal_manager_calls_handlers_in_the_loop_while_it_is_open():
    from launch.utilities import AsyncSafeSignalManager

    loop = asyncio.new_event_loop()
    manager, seen = AsyncSafeSignalManager(loop), []

    def send(signum: int) -> None:
        os.kill(os.getpid(), signum)
        for _ in range(3):  # the loop reads what has been written by now
            loop.run_until_complete(asyncio.sleep(0))

    try:
        assert manager.handle(signal.SIGUSR1, seen.append) is None
        send(signal.SIGUSR1)
        assert seen == []
        with manager:
            send(signal.SIGUSR1)
            with AsyncSafeSignalManager(loop) as inner:
                inner.handle(signal.SIGUSR2, lambda signum: seen.append("inner"))
                send(signal.SIGUSR1)
                send(signal.SIGUSR2)
            assert manager.handle(signal.SIGUSR1, None) == seen.append
            send(signal.SIGUSR1)
        assert seen == [signal.SIGUSR1, signal.SIGUSR1, "inner"]
        with pytest.raises(ValueError):
            manager.handle(signal.SIGUSR1, 5)  # type: ignore[arg-type]
    finally:
        loop.close()


# ---- futures and arguments


def test_a_future_without_a_loop_belongs_to_that_of_the_thread():
    from launch.utilities import create_future

    async def within() -> bool:
        return create_future(None).get_loop() is asyncio.get_running_loop()

    future = create_future(None)
    assert isinstance(future, asyncio.Future)
    assert asyncio.run(within())


@pytest.mark.parametrize("types", [[123, str], [str, 123], "str", (t for t in (str, None)), None])
def test_types_of_an_argument_are_types(types: Any):
    from launch.utilities import ensure_argument_type

    with pytest.raises(TypeError, match=r"'ensure_argument_type\(\)' expected 'types'"):
        ensure_argument_type("a", types, "name")


def test_types_of_an_argument_may_be_generic():
    from launch.utilities import ensure_argument_type

    ensure_argument_type(["a"], (str, typing.List), "name")  # noqa: UP006
    ensure_argument_type(1, str | int, "name")


def test_a_condition_needs_only_a_context_that_performs_substitutions():
    from launch.conditions import IfCondition, InvalidConditionExpressionError

    class Performing:
        def perform_substitution(self, substitution: Any) -> str:
            return substitution.perform(self)

    with pytest.raises(InvalidConditionExpressionError):
        IfCondition("tru").evaluate(Performing())


def test_launch_files_may_be_given_as_paths(tmp_path: Path):
    from launch.launch_description_sources import (
        get_launch_description_from_any_launch_file,
        get_launch_description_from_frontend_launch_file,
        get_launch_description_from_python_launch_file,
    )

    python, markup = tmp_path / "a.launch.py", tmp_path / "a.launch.xml"
    python.write_text("import launch\ngenerate_launch_description = launch.LaunchDescription\n")
    markup.write_text("<launch/>")
    assert get_launch_description_from_python_launch_file(python).entities == []
    assert get_launch_description_from_frontend_launch_file(markup).entities == []
    assert get_launch_description_from_any_launch_file(markup).entities == []


def test_tests_of_extensions_patch_the_entry_points():
    from launch.frontend.parser import Parser, importlib_metadata

    class Broken:
        name = "broken"

        def load(self) -> None:
            raise ValueError("no")

    with (
        patch(importlib_metadata.__name__ + ".entry_points", return_value=[Broken()]),
        pytest.warns(UserWarning, match="Failed to load the launch extension broken"),
    ):
        Parser.load_launch_extensions()


def test_a_description_is_formatted_without_addresses():
    from launch import LaunchDescription, LaunchIntrospector
    from launch.actions import DeclareLaunchArgument, OpaqueFunction

    def make_nodes(context: Any) -> None:
        """Nothing."""

    entities = [
        DeclareLaunchArgument("count", default_value="3", description="of robots"),
        OpaqueFunction(function=make_nodes),
    ]
    assert LaunchIntrospector().format_launch_description(LaunchDescription(entities)) == (
        "LaunchDescription(2 entities)\n"
        "├── DeclareLaunchArgument(name='count', default_value='3', description='of robots')\n"
        "└── OpaqueFunction(function='make_nodes')"
    )


# ---- the queue


def test_handlers_that_emit_for_ever_let_others_have_their_turn():
    from launcher.base.model import events as model
    from launcher.language.actions.event_actions import (
        EmitEvent,
        OpaqueFunction,
        RegisterEventHandler,
    )
    from launcher.language.actions.timer import TimerAction
    from launcher.language.events.base import Event, EventHandler
    from launcher.language.interpreter.interpreter import MAX_EVENTS
    from tests.language.unit.interpreter.interpreting import interpreting

    class Again(Event):
        """Emitted again by its handler."""

    seen: list[int] = []
    entities = [OpaqueFunction(function=lambda _: seen.append(1)), EmitEvent(event=Again())]
    handler = EventHandler(matcher=lambda event: isinstance(event, Again), entities=entities)
    timer = TimerAction(period=1.0, actions=[EmitEvent(event=Again())])
    with interpreting([RegisterEventHandler(handler), timer]) as interpreter:
        (first,) = [e for e in interpreter.start() if isinstance(e, model.CallLater)]
        effects = interpreter.handle(model.TimerFired(timer_id=first.timer_id))
        assert 0 < len(seen) <= MAX_EVENTS
        (later,) = [e for e in effects if isinstance(e, model.CallLater)]
        assert later.delay_s == 0
        interpreter.handle(model.TimerFired(timer_id=later.timer_id))
        assert len(seen) > MAX_EVENTS
