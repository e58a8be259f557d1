"""Facts about launch_ros and launch_testing that scripts and tests of other people rely on."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from launcher.language import launch_session
from launcher.language.compat import vocabulary


@pytest.fixture(autouse=True)
def _open_vocabulary() -> Iterator[None]:
    with vocabulary():
        yield


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
        parameters=[{"i": 1, "d": [1.5], "s": "text", "b": True, "y": b"ab"}],
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
    assert (values["y"].type, values["y"].byte_array_value) == (5, [b"a", b"b"])
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
    """The prefix of a package `tools` with a file in share."""
    marker = tmp_path / "share" / "ament_index" / "resource_index" / "packages" / "tools"
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
    from launch_ros.substitutions import ExecutableInPackage, FindPackagePrefix, FindPackageShare

    path = FindPackageShare("tools") / "config" / [TextSubstitution(text="a"), ".yaml"]
    prefix = FindPackagePrefix("tools") / "lib"

    assert path.perform(LaunchContext()) == f"{tools}/share/tools/config/a.yaml"
    assert prefix.perform(LaunchContext()) == f"{tools}/lib"
    assert "ExecInPkg" in (ExecutableInPackage("run", "tools") / "x").describe()


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

    monkeypatch.setattr(launch_session.current(), "open_ros_node", Node)
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

    monkeypatch.setattr(launch_session.current(), "open_ros_node", Node)
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
        with pytest.raises(RuntimeError, match="runs a launch file without a ROS node"):
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


def test_an_error_about_a_value_has_the_short_name_of_its_type():
    from launch import LaunchContext
    from launch.substitutions import LaunchConfiguration
    from launch_ros.utilities import evaluate_parameters, normalize_parameters

    context = LaunchContext()
    context.launch_configurations["x"] = "{b: 1}"
    with pytest.raises(TypeError, match='Got dict for "a"'):
        evaluate_parameters(context, normalize_parameters([{"a": LaunchConfiguration("x")}]))
