"""Facts about ROS 2's front ends that scripts and tests of other people rely on."""

from __future__ import annotations

import io
from collections.abc import Iterator
from unittest.mock import Mock, patch
from xml.etree import ElementTree

import pytest

from launcher.language.compat import vocabulary


@pytest.fixture(autouse=True)
def _open_vocabulary() -> Iterator[None]:
    with vocabulary():
        yield


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
