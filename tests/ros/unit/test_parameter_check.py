"""Parameters that were set, against those that nodes declare."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.model.ros_arguments import full_node_name, ros_options
from launcher.ros.helpers.parameter_check import NodeToCheck, ParameterComparison, file_parameters


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("exe", None),
        ("exe -r __node:=a", None),
        ("exe --ros-args -r __node:=a", "/a"),
        ("exe --ros-args -r __node:=a --ros-args -r __node:=b", "/a"),
        ("exe --ros-args --remap __name:=a -r __ns:=/x/y", "/x/y/a"),
        ("exe --ros-args -r __ns:=/ -r __node:=a", "/a"),
        ("exe --ros-args -- -r __node:=a", None),
        ("exe --ros-args -r", None),
    ],
)
def test_the_full_name_of_a_node_is_that_of_its_first_remapping(words: str, name: str | None):
    assert full_node_name(words.split()) == name


def test_options_behind_the_flag_are_found_in_all_spellings():
    words = "exe -p no:=1 --ros-args -p a:=1 --param b:=2 --params-file f x -- -p no:=1"
    found = [("-p", "a:=1"), ("-p", "b:=2"), ("--params-file", "f")]
    assert list(ros_options(words.split())) == found


FILE = """\
x:
  a:
    ros__parameters:
      p: 1
      group: {q: [1, 2]}
/x/b: {ros__parameters: {other: 1}}
/**:
  ros__parameters:
    r: 1
"""


def test_parameters_of_a_file_have_their_line(tmp_path: Path):
    file = tmp_path / "p.yaml"
    file.write_text(FILE)
    assert list(file_parameters(str(file), "/x/a")) == [("p", 4), ("group.q", 5), ("r", 9)]
    for text in ("[", "x: [1]", ""):
        file.write_text(text)
        assert list(file_parameters(str(file), "/x/a")) == []
    assert list(file_parameters(str(tmp_path / "none.yaml"), "/x/a")) == []


def node(name: str, *words: str, declared: set[str] | None) -> NodeToCheck:
    argv = ["exe", "--ros-args", "-r", f"__node:={name}", *words]
    one = NodeToCheck(pid=1, argv=argv, place="a.launch.py:3", generated=[])
    one.declared = None if declared is None else frozenset(declared)
    one.is_done = True
    return one


def reported(*nodes: NodeToCheck) -> list[str]:
    said: list[str] = []
    comparison = ParameterComparison(list(nodes), said.append)
    for one in nodes:
        comparison._report(one, [s for s in one.missing if not comparison._shared(s)])
    comparison._report_shared()
    return said


def test_a_similar_name_is_suggested_that_was_not_set():
    one = node("n", "-p", "duration:=1", "-p", "n:rats:=2", declared={"duration_s", "rate"})
    set_in = "was set in a.launch.py:3 but the node does not declare it; did you mean"
    assert reported(one) == [
        f"n: parameter 'duration' {set_in} 'duration_s'?",
        f"n: parameter 'rats' {set_in} 'rate'?",
    ]


def test_a_setting_for_another_node_of_the_process_is_none():
    assert reported(node("n", "-p", "other:x:=1", declared=set())) == []
    # The name in front of a parameter has no namespace.
    in_namespace = ("-r", "__ns:=/s", "-p", "n:x:=1")
    assert reported(node("n", *in_namespace, declared=set())) == []


def test_what_nodes_share_is_reported_only_if_all_are_known_and_none_declares_it():
    shared = ("-p", "x:=1")
    assert reported(node("a", *shared, declared={"x"}), node("b", *shared, declared=set())) == []
    assert reported(node("a", *shared, declared=None), node("b", *shared, declared=set())) == []
    nodes = [node("a", *shared, declared=set()), node("b", *shared, declared=set())]
    assert [text.partition(":")[0] for text in reported(*nodes)] == ["a", "b"]


class Graph:
    """The part of a ServiceCaller that a comparison uses; time passes with each question."""

    def __init__(self, declared: list[set[str]], monkeypatch: pytest.MonkeyPatch) -> None:
        self._declared = declared
        self._now_s = 0.0
        self.observer = self.node = self
        monkeypatch.setattr("launcher.ros.parameters.list_names", self._list)
        monkeypatch.setattr("launcher.ros.parameters.get", lambda *words: [])
        monkeypatch.setattr(
            "launcher.ros.helpers.parameter_check.time.monotonic", lambda: self._now_s
        )
        monkeypatch.setattr("launcher.ros.helpers.parameter_check.time.sleep", self._pass)

    def _pass(self, duration_s: float) -> None:
        self._now_s += duration_s

    def _list(self, *words: object) -> set[str]:
        return self._declared.pop(0) if len(self._declared) > 1 else self._declared[0]

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [("/n/list_parameters", ["rcl_interfaces/srv/ListParameters"])]


@pytest.mark.parametrize(
    ("declared", "warnings"), [([set(), set(), {"x"}], 0), ([set()], 1), ([{"x"}], 0)]
)
def test_a_parameter_that_is_declared_late_is_not_reported(
    declared: list[set[str]], warnings: int, monkeypatch: pytest.MonkeyPatch
):
    said: list[str] = []
    one = node("n", "-p", "x:=1", declared=None)
    one.is_done = False
    ParameterComparison([one], said.append).run(Graph(declared, monkeypatch), lambda: False)
    assert len(said) == warnings
