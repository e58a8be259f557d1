"""Facts about ROS 2's public classes that scripts and tests of other people rely on."""

from __future__ import annotations

import asyncio
import io
import os
import signal
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar
from unittest.mock import Mock, NonCallableMock, patch
from xml.etree import ElementTree

import pytest
from ament_index_python.packages import PackageNotFoundError

from launcher.language import session
from launcher.language.compat import vocabulary


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


# ---- front ends


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "<executable cmd='ls'><what/></executable>",
            [
                "<what> is not allowed inside",
                "Unexpected nested tag(s) found in `executable`: {'what'}",
            ],
        ),
        (
            "<executable cmd='ls' nope='1'/>",
            [
                "<executable> has no attribute 'nope'",
                "Unexpected attribute(s) found in `executable`: {'nope'}",
            ],
        ),
        ("<what/>", ["unknown action 'what'", "Unrecognized entity of the type: what"]),
    ],
)
def test_errors_about_xml_have_the_words_of_ros_2_too(text, words):
    from launch.frontend import Parser

    with pytest.raises((ValueError, RuntimeError)) as error:
        entity, parser = Parser.load(io.StringIO(f"<launch>{text}</launch>"))
        parser.parse_description(entity)

    assert all(word in str(error.value) for word in words)


def test_an_unknown_key_in_yaml_has_the_words_of_ros_2_too():
    from launch.frontend import Parser

    with pytest.raises(ValueError, match=r"Unexpected key\(s\) found in `executable`: {'nope'}"):
        entity, parser = Parser.load(io.StringIO("launch: [{executable: {cmd: ls, nope: 1}}]"))
        parser.parse_description(entity)


@pytest.mark.parametrize("method", ["load_launch_extensions", "load_parser_implementations"])
def test_a_package_that_cannot_be_loaded_is_a_warning(method):
    from launch.frontend import Parser

    point = Mock()
    point.name, point.value = "broken", "some.package:x"
    point.load.side_effect = ValueError("does not load")
    with (
        patch("importlib.metadata.entry_points", return_value=[point]),
        pytest.warns(UserWarning, match=r"Failed to load .* broken: does not load"),
    ):
        getattr(Parser, method)()


def test_an_entity_can_be_made_of_what_somebody_else_has_read():
    import launch_xml
    import launch_yaml

    root = launch_xml.Entity(ElementTree.fromstring("<a><b list='1;2' list-sep=';'/></a>"))
    tree = launch_yaml.Entity({"list": [1, 2]}, "a")

    (tag,) = root.children
    assert (root.type_name, tree.type_name, root.parent, tree.parent) == ("a", "a", None, None)
    for entity in (tag, tree):
        assert entity.get_attr("list", data_type=list[int]) == [1, 2]
        assert entity.get_attr("other", optional=True) is None
        with pytest.raises(AttributeError):
            entity.get_attr("other")


@pytest.mark.parametrize(("given", "value"), [(True, "True"), (False, "False"), ("true", "true")])
def test_a_boolean_argument_has_a_truth_value(given, value):
    from launch import LaunchContext
    from launch.actions import DeclareBooleanLaunchArgument

    context = LaunchContext()
    DeclareBooleanLaunchArgument("flag", default_value=given, description="A flag").visit(context)
    assert context.launch_configurations["flag"] == value
    context.launch_configurations["flag"] = "perhaps"
    with pytest.raises(RuntimeError, match="is not valid"):
        DeclareBooleanLaunchArgument("flag").visit(context)
    with pytest.raises(RuntimeError, match="not in provided choices"):
        DeclareBooleanLaunchArgument("flag", default_value="perhaps")
    with pytest.raises(TypeError, match="multiple values for keyword argument 'choices'"):
        DeclareBooleanLaunchArgument("flag", choices=["a", "b"])


def test_a_loop_yields_one_for_each_of_its_indices():
    from launch import LaunchContext
    from launch.actions import ForEach, ForLoop

    seen: list[int] = []
    loop = ForLoop("2", name="number", function=lambda index: seen.append(index) or [])
    (each,) = loop.visit(LaunchContext())

    assert (loop.name, seen) == ("number", [])
    assert each.visit(LaunchContext()) == []
    assert seen == [0, 1]
    assert loop.describe().startswith("ForLoop")
    assert isinstance(each, ForEach)
    assert each.describe().startswith("ForEach")


# ---- ROS


def test_settings_for_nodes_work_with_a_context_of_two_attributes():
    from launch_ros.actions import (
        SetParameter,
        SetParametersFromFile,
        SetRemap,
        SetUseSimTime,
    )
    from launch_ros.actions.load_composable_nodes import get_composable_node_load_request
    from launch_ros.descriptions import ComposableNode

    class Context:
        def __init__(self) -> None:
            self.launch_configurations: dict[str, Any] = {}

        def perform_substitution(self, substitution: Any) -> str:
            return substitution.perform(None)

    context = Context()
    SetParameter(name="a", value="1").execute(context)
    SetRemap(src="from", dst="to").execute(context)
    SetUseSimTime(True).execute(context)

    request = get_composable_node_load_request(
        ComposableNode(package="p", plugin="q", name="n", parameters=[{"b": "2"}]), context
    )
    assert [(p.name, p.value.string_value) for p in request.parameters] == [("a", "1"), ("b", "2")]
    assert list(request.remap_rules) == ["from:=to"]
    SetParametersFromFile("some.yaml").execute(context)
    assert context.launch_configurations["global_params"] == [("a", "1"), "some.yaml"]


def test_a_load_request_has_the_shape_of_the_message():
    from launch import LaunchContext
    from launch.conditions import IfCondition
    from launch_ros.actions.load_composable_nodes import get_composable_node_load_request
    from launch_ros.descriptions import ComposableNode

    node = ComposableNode(
        package="p",
        plugin="q",
        name="n",
        namespace="s",
        parameters=[{"i": 1, "d": [1.5], "s": "text", "b": True}],
        remappings=[("from", "to")],
        extra_arguments=[{"use_intra_process_comms": True}],
    )
    request = get_composable_node_load_request(node, LaunchContext())

    assert (request.package_name, request.plugin_name) == ("p", "q")
    assert (request.node_name, request.node_namespace) == ("n", "/s")
    assert list(request.remap_rules) == ["from:=to"]
    values = {parameter.name: parameter.value for parameter in request.parameters}
    assert (values["i"].type, values["i"].integer_value) == (2, 1)
    assert (values["d"].type, list(values["d"].double_array_value)) == (8, [1.5])
    assert (values["s"].string_value, values["b"].bool_value) == ("text", True)
    assert request.extra_arguments[0].value.bool_value
    left_out = ComposableNode(package="p", plugin="q", condition=IfCondition("false"))
    assert get_composable_node_load_request(left_out, LaunchContext()) is None


@pytest.mark.parametrize("allow_substs", [True, False])
def test_a_parameter_file_is_evaluated_with_a_context_that_only_substitutes(
    allow_substs: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    from launch_ros.descriptions import ParameterFile

    class Context:
        environment: ClassVar = {"SPEED": "3"}

        def perform_substitution(self, substitution: Any) -> str:
            return substitution.perform(self)

    given = tmp_path / "given.yaml"
    given.write_text("/**: {ros__parameters: {speed: $(env SPEED)}}")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    file = ParameterFile(str(given), allow_substs=allow_substs)

    made = file.evaluate(Context())

    assert (made == given) is not allow_substs
    assert ("speed: 3" in made.read_text()) is allow_substs
    file.cleanup()
    assert list(tmp_path.iterdir()) == [given]


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The prefix of a package `tools` with a file in share and a resource of another type."""
    for kind in ("packages", "plugins"):
        marker = tmp_path / "share" / "ament_index" / "resource_index" / kind / "tools"
        marker.parent.mkdir(parents=True)
        marker.touch()
    file = tmp_path / "share" / "tools" / "config" / "a.yaml"
    file.parent.mkdir(parents=True)
    file.touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    return tmp_path


def test_a_path_below_a_package_is_written_with_slashes(tools: Path):
    from launch import LaunchContext
    from launch.substitutions import TextSubstitution
    from launch_ros.substitutions import AmentIndexResource, ExecutableInPackage, FindPackageShare

    path = FindPackageShare("tools") / "config" / [TextSubstitution(text="a"), ".yaml"]
    prefix = AmentIndexResource("plugins", "tools") / "lib"

    assert path.perform(LaunchContext()) == f"{tools}/share/tools/config/a.yaml"
    assert prefix.perform(LaunchContext()) == f"{tools}/lib"
    assert "ExecInPkg" in (ExecutableInPackage("run", "tools") / "x").describe()


@pytest.mark.parametrize("kind", ["packages", "plugins"])
def test_a_resource_of_the_ament_index_is_found_with_its_prefix(kind: str, tools: Path):
    from launch import LaunchContext
    from launch.substitutions import SubstitutionFailure
    from launch_ros.substitutions import AmentIndexResource

    found = AmentIndexResource(kind, ["to", "ols"])
    assert found.perform(LaunchContext()) == str(tools)
    assert found.describe() == f"AmentIndexResource('{kind}', 'to' + 'ols')"
    for names in ((kind, "no_such_thing"), ("no_such_type", "tools"), (kind, ""), (kind, "../x")):
        with pytest.raises(SubstitutionFailure, match="the ament index has no resource"):
            AmentIndexResource(*names).perform(LaunchContext())


def test_a_file_of_a_package_is_found_if_it_exists(tools: Path):
    from launch import LaunchContext
    from launch.substitutions import SubstitutionFailure
    from launch_ros.substitutions import FindPackageFile

    context = LaunchContext()
    found = FindPackageFile("tools", "config/a.yaml")
    assert found.perform(context) == f"{tools}/share/tools/config/a.yaml"
    assert found.describe() == "FindPackageFile(pkg='tools', file='config/a.yaml')"
    assert FindPackageFile("tools", "config").perform(context) == f"{tools}/share/tools/config"
    for file, message in (("config/b.yaml", "not found in the share"), ("/etc", "is absolute")):
        with pytest.raises(SubstitutionFailure, match=message):
            FindPackageFile("tools", file).perform(context)
    with pytest.raises(PackageNotFoundError):
        FindPackageFile("no_such_package", "a").perform(context)


def test_substitutions_parse_the_words_of_their_tags():
    from launch_ros.substitutions import AmentIndexResource, FindPackageFile

    words = {"package": "tools", "file": "a"}
    assert FindPackageFile.parse(["tools", "a"]) == (FindPackageFile, words)
    words = {"resource_type": "plugins", "resource_name": "tools"}
    assert AmentIndexResource.parse(["plugins", "tools"]) == (AmentIndexResource, words)
    with pytest.raises(AttributeError, match="2 arguments"):
        FindPackageFile.parse(["tools"])
    with pytest.raises(TypeError, match="2 arguments"):
        AmentIndexResource.parse(["plugins"])


class Node:
    """What a script's session opens for a ROSAdapter."""

    opened: ClassVar[list[Node]] = []

    def __init__(self, argv: list[str]) -> None:
        self.argv, self.closed = argv, 0
        self.context, self.node, self.executor = object(), object(), object()
        self.opened.append(self)

    def close(self) -> None:
        self.closed += 1


def test_a_ros_adapter_starts_and_ends_as_often_as_asked(monkeypatch: pytest.MonkeyPatch):
    from launch_ros.ros_adapters import ROSAdapter

    monkeypatch.setattr(session.current(), "open_ros_node", Node)
    monkeypatch.setattr(Node, "opened", [])
    adapter = ROSAdapter(argv=["--ros-args"], autostart=False)
    assert (adapter.ros_node, adapter.ros_context, adapter.ros_executor) == (None, None, None)
    with pytest.raises(RuntimeError, match="not running"):
        adapter.shutdown()

    for _ in range(2):
        adapter.start()
        node = Node.opened[-1]
        parts = (adapter.ros_node, adapter.ros_context, adapter.ros_executor)
        assert parts == (node.node, node.context, node.executor)
        assert adapter.argv is node.argv
        with pytest.raises(RuntimeError, match="already running"):
            adapter.start()
        adapter.shutdown()
        assert (node.closed, adapter.ros_node) == (1, None)
    assert len(Node.opened) == 2


def test_a_shutdown_ends_the_ros_node_of_the_context(monkeypatch: pytest.MonkeyPatch):
    from launch import LaunchContext
    from launch.events import Shutdown
    from launch_ros.ros_adapters import get_ros_adapter, get_ros_node

    monkeypatch.setattr(session.current(), "open_ros_node", Node)
    monkeypatch.setattr(Node, "opened", [])
    context = LaunchContext()
    first = get_ros_node(context)
    assert get_ros_node(context) is first

    for handler in context._event_handlers:
        assert handler.matches(Shutdown())
        handler.handle(Shutdown(), context)
        handler.handle(Shutdown(), context)

    assert (Node.opened[0].closed, get_ros_adapter(context).ros_node is first) == (1, False)
    assert (len(context._event_handlers), len(Node.opened)) == (1, 2)


def test_a_launch_file_has_no_ros_node():
    from launch import LaunchContext
    from launch_ros.ros_adapters import ROSAdapter, get_ros_node

    for made in (ROSAdapter, lambda: get_ros_node(LaunchContext())):
        with pytest.raises(RuntimeError, match="no ROS node of its own in a launch file"):
            made()


# ---- launch_testing


def test_a_parametrized_description_yields_one_for_each_set_of_values():
    import launch_testing

    def description(first: int, second: int = 0) -> tuple[int, int]:
        """What is tested."""
        return first, second

    one = launch_testing.parametrize("first", [1, (2,)])(description)
    both = launch_testing.parametrize("first, second", [(1, 2), (3, 4)])(description)
    named = launch_testing.parametrize(["first", "second"], [(5, 6)])(description)

    assert [(made(), arguments) for made, arguments in one()] == [
        ((1, 0), {"first": 1}),
        ((2, 0), {"first": 2}),
    ]
    assert [made() for made, _ in both()] == [(1, 2), (3, 4)]
    assert [made() for made, _ in named()] == [(5, 6)]
    assert [made(second=9) for made, _ in one()] == [(1, 9), (2, 9)]
    assert one.__parametrized__ and one.__doc__ == "What is tested."


def test_the_marks_of_a_description_survive_one_another():
    import launch_testing
    from launch_testing.markers import keep_alive

    def description(value: int) -> None: ...

    timeout = launch_testing.ready_to_test_action_timeout(10)
    values = launch_testing.parametrize("value", [1])

    for mark, other in ((timeout, values), (values, timeout)):
        made: Any = mark(keep_alive(other(description)))
        assert made.__parametrized__
        assert made.__ready_to_test_action_timeout__ == 10
        assert made.__markers__ == {"keep_alive": True}


def test_test_cases_of_launch_testing_are_marked_and_repeated():
    import launch_testing
    from launch_testing.markers import retry_on_failure

    @launch_testing.post_shutdown_test()
    class Cases:
        calls = 0

        @retry_on_failure(times=3)
        def test(self, passes_at: int) -> None:
            self.calls += 1
            assert self.calls >= passes_at

    cases = Cases()
    cases.test(2)
    assert (cases.calls, Cases.__post_shutdown_test__) == (2, True)
    with pytest.raises(AssertionError):
        Cases().test(4)
    with pytest.raises(TypeError, match="class of tests"):
        launch_testing.post_shutdown_test()(lambda: None)
    with pytest.raises(ValueError, match="positive"):
        retry_on_failure(times=0)


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
    from launcher.interpreter.core import MAX_EVENTS
    from launcher.language.actions.events import EmitEvent, OpaqueFunction, RegisterEventHandler
    from launcher.language.actions.timer import TimerAction
    from launcher.language.events.base import Event, EventHandler
    from launcher.model import events as model
    from tests.unit.interpreter.interpreting import interpreting

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
