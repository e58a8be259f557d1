"""Which sections of a parameter file are for a node; tests/ros/ros compares with rcl."""

from __future__ import annotations

import pytest
import yaml

from launcher.base.model.parameter_sections import Section, parameters, parameters_for, sections


@pytest.mark.parametrize(
    ("selector", "node", "matches"),
    [
        ("/a", "/a", True),
        ("/a", "/x/a", False),
        ("/x/a", "/x/a", True),
        ("/**", "/x/y/a", True),
        ("/**/a", "/x/y/a", True),
        ("/**/a", "/a", True),
        ("/x/a/**", "/x/a", True),
        ("/*/a", "/x/a", True),
        ("/*/a", "/x/y/a", False),
        ("/*", "/x/a", False),
        ("/a.b", "/axb", False),
    ],
)
def test_a_selector_matches_the_full_name(selector: str, node: str, matches: bool):
    assert Section(selector, {}).is_for(node) is matches


FILE = """\
x:
  a:
    ros__parameters:
      p: 1
      group: {q: [1, 2]}
/x/b: {ros__parameters: {other: 1}}
"/":
  c: {ros__parameters: {ros__parameters: 3}}
/**:
  ros__parameters: {p: 2, r: 1}
ros__parameters: {lost: 1}
"""


def test_keys_are_joined_to_a_selector():
    for tree in (yaml.safe_load(FILE), yaml.compose(FILE)):
        found = list(sections(tree))
        assert [one.selector for one in found] == ["/x/a", "/x/b", "/c", "/**"]
        names = [[name for name, _, _ in parameters(one.parameters)] for one in found]
        assert names == [["p", "group.q"], ["other"], ["ros__parameters"], ["p", "r"]]
    for text in ("", "[1]", "a", "a: 1"):
        assert list(sections(yaml.safe_load(text))) == list(sections(yaml.compose(text))) == []


def test_what_is_for_the_node_alone_comes_after_wildcards():
    known = list(sections(yaml.safe_load(FILE)))
    found = [(name, value) for name, _, value in parameters_for("/x/a", known)]
    assert found == [("p", 2), ("r", 1), ("p", 1), ("group.q", [1, 2])]


@pytest.mark.parametrize(
    ("text", "node"),
    [
        ("/**: {ros__parameters: {p: 1}}", "/ns/n"),
        ("/n: {ros__parameters: {p: 1}}", "/n"),
        ("n: {ros__parameters: {p: 1}}", "/n"),
        ("/ns/n: {ros__parameters: {p: 1}}", "/ns/n"),
        ("/ns: {n: {ros__parameters: {p: 1}}}", "/ns/n"),
        ("/ns/deep: {n: {ros__parameters: {p: 1}}}", "/ns/deep/n"),
        ("/*: {n: {ros__parameters: {p: 1}}}", "/ns/n"),
        ("/**/n: {ros__parameters: {p: 1}}", "/ns/deep/n"),
    ],
    ids=str,
)
def test_keys_that_ros2_param_load_takes(text: str, node: str):
    # those of rclpy 7.1.11 and 10.0.10, for the node that is named
    known = list(sections(yaml.safe_load(text)))
    assert [(name, value) for name, _, value in parameters_for(node, known)] == [("p", 1)]
    assert not list(parameters_for("/other/m", [one for one in known if one.selector != "/**"]))
