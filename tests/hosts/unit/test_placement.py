"""Rules of a hosts file, and what is wrong with them for what a launch file would start."""

from __future__ import annotations

from textwrap import dedent

import pytest

from launcher.base.errors import UsageError
from launcher.base.model.spec import ProcessSpec, RosIdentity, Scope
from launcher.hosts.file import hosts_reader
from launcher.hosts.file.placement import Candidates, Component, Placement, PlacementFindings


def node(name: str | None, namespace: str | None = None, **more: object) -> ProcessSpec:
    ros = RosIdentity(
        package=str(more.pop("package", "demo")),
        executable="program",
        node_name=name,
        namespace=namespace,
    )
    return ProcessSpec(name="program-1", label="program", argv=(), env={}, ros=ros, **more)


def process(label: str, number: int = 1, *argv: str, **more: object) -> ProcessSpec:
    return ProcessSpec(name=f"{label}-{number}", label=label, argv=argv, env={}, **more)


def placement(rules: str) -> Placement:
    hosts = "hosts: {a: 10.0.0.1, b: 10.0.0.2}\nplace:\n"
    return Placement(hosts_reader.parse(hosts + rules, "hosts.yaml", {}))


def host(rules: str, spec: ProcessSpec) -> str | None:
    found = placement(rules).host_of(spec)
    return None if found is None else found.name


MATCHES = {
    # name, label, name with its number
    "robot_1": [node("robot_1"), node("robot_1", "/ns"), process("robot_1")],
    "program": [node("robot_1"), node(None)],
    "program-1": [node("robot_1")],
    '"robot_*"': [node("robot_1"), process("robot_2")],
    "process:program": [node("robot_1")],
    # full names and namespaces
    "/robot_1": [node("robot_1"), node("robot_1", "/")],
    "/ns/robot_1": [node("robot_1", "/ns"), process("x", 1, "x", "--ros-args", "-r", "__ns:=/ns")],
    "/ns/**": [node("robot_1", "/ns"), node("robot_1", "/ns/deep/er"), node(None, "/ns")],
    "/robot_1/**": [node("robot_1"), node("robot_1", "/robot_1"), node(None, "/robot_1")],
    "/*/arm/**": [node("arm", "/ns"), node("x", "/ns/arm")],
    "/ns/*": [node("robot_1", "/ns"), node(None, "/ns")],
    "/**/robot_1": [node("robot_1"), node("robot_1", "/ns"), node("robot_1", "/ns/deep")],
    "/*/cam": [node("cam", "/robot_1")],
    "/**": [node("robot_1"), node(None), node("x", "/ns")],
    '"**"': [node("robot_1"), process("rviz2")],
    # packages, includes and groups
    "package:demo": [node("x")],
    "package:de*": [node("x")],
    "include:robot.launch.py": [process("x", scopes=(Scope("/a/b/robot.launch.py"),))],
    "include:b/robot.*": [process("x", scopes=(Scope("/a/b/robot.launch.py"),))],
    "group:/robot_1": [process("x", scopes=(Scope("/a.launch.py", 7, "/robot_1"),))],
    "group:a.launch.py:7": [process("x", scopes=(Scope("/x/a.launch.py", 7), Scope("/b")))],
}
MATCHES["/ns/robot_1"][1] = process(
    "x", 1, "x", "--ros-args", "-r", "__ns:=/ns", "-r", "__node:=robot_1"
)


@pytest.mark.parametrize("pattern", MATCHES)
def test_what_a_pattern_matches(pattern: str):
    for spec in MATCHES[pattern]:
        assert host(f"  {pattern}: a", spec) == "a", spec


@pytest.mark.parametrize(
    ("pattern", "spec"),
    [
        ("robot_1", node("robot_10")),
        ("robot", node("robot_1")),
        ("demo", node("x")),
        ("process:robot_1", node("robot_1")),
        ("/robot_1", node("robot_1", "/ns")),
        ("/ns/robot_1", node(None, "/ns")),
        ("/ns/**", node("ns_2")),
        ("/ns/**", node("ns", "/other")),
        ("/ns/*", node("x", "/ns/deep")),
        ("/**", process("rviz2")),
        ("package:demo", process("demo")),
        ("include:robot.launch.py", process("x", scopes=(Scope("/my_robot.launch.py"),))),
        ("include:a.launch.py", process("x", scopes=(Scope("/a.launch.py", 7),))),
        ("group:/robot_1", process("x", scopes=(Scope("/a.launch.py", 7),))),
        ("group:a.launch.py:7", process("x", scopes=(Scope("/a.launch.py", 17),))),
    ],
)
def test_what_a_pattern_does_not_match(pattern: str, spec: ProcessSpec):
    assert host(f"  {pattern}: a", spec) is None


@pytest.mark.parametrize(
    ("rules", "spec"),
    [
        # An exact name decides, a full name more than others; `**` is the default.
        ("  robot_1: a\n  'robot_*': b", node("robot_1")),
        ("  /ns/robot_1: a\n  robot_1: b", node("robot_1", "/ns")),
        ("  program-1: a\n  program: b", node("robot_1")),
        ("  '**': b\n  /**: a", node("robot_1")),
        ("  '**': b\n  package:demo: a", node("robot_1")),
        ("  '*': b\n  monitor: local\n  robot_1: a", node("robot_1")),
        # What is inside is an exception from what is around it.
        ("  /ns/**: b\n  /ns/arm/**: a", node("x", "/ns/arm")),
        ("  /ns/**: b\n  /ns/arm/**: a", node("arm", "/ns")),
        ("  /robot_1/**: b\n  robot_1: a", node("robot_1")),
        (
            "  group:/ns: b\n  include:arm.launch.py: a",
            process("x", scopes=(Scope("/f", 3, "/ns"), Scope("/arm.launch.py"))),
        ),
        # Agreement is no conflict.
        ("  package:demo: a\n  'robot_*': a", node("robot_1")),
    ],
)
def test_the_more_exact_rule_decides(rules: str, spec: ProcessSpec):
    assert host(rules, spec) == "a"


def test_local_is_the_default_and_can_be_named():
    assert host("  robot_1: a", node("other")) is None
    assert host("  '**': a\n  monitor: local", node("monitor")) is None


def test_rules_of_equal_rank_that_disagree_are_an_error_with_both_places():
    with pytest.raises(UsageError) as caught:
        host("  'robot_*': a\n  package:demo: b\n", node("robot_1", "/ns"))

    assert caught.value.render() == dedent("""\
        error: hosts.yaml:4: two hosts for program-1: 'package:demo' places it on b, \
and 'robot_*' in line 3 on a
              package:demo: b
              ^
        hint: an exact name decides: '/ns/robot_1: b'""")


# ---- mistakes


def findings(rules: str, *specs: ProcessSpec, **more: object) -> PlacementFindings:
    return placement(rules).check(Candidates(specs=specs, **more))


def only_error(found: PlacementFindings) -> tuple[str, str | None]:
    (error,) = found.errors
    assert error.exit_code == 2 and error.column is not None
    return f"{error.where}: {error.message}", error.hint


@pytest.mark.parametrize(
    ("pattern", "hint"),
    [
        ("robot_12", "did you mean 'robot_1'?"),
        ("arm", "'/arm' is a namespace: write '/arm/**'"),
        ("/arn/**", "did you mean '/arm/**'?"),
        ("package:demoo", "did you mean 'package:demo'?"),
        ("include:robt.launch.py", "did you mean 'include:robot.launch.py'?"),
        ("group:robot.launch.py:8", "did you mean 'group:robot.launch.py:7'?"),
        ("process:rviz", "did you mean 'process:rviz2'?"),
        ("xyz", "known: robot_1, program, x, rviz2"),
    ],
)
def test_a_pattern_without_a_match_is_an_error_with_a_suggestion(pattern: str, hint: str):
    scopes = (Scope("/a/robot.launch.py"), Scope("/a/robot.launch.py", 7))
    specs = (node("robot_1"), node("x", "/arm"), process("rviz2", 3, scopes=scopes))

    found = findings(f"  {pattern}: a\n  x: b\n", *specs)

    assert only_error(found) == (f"hosts.yaml:3: '{pattern}' matches no process", hint)


def test_what_a_condition_keeps_away_is_a_remark():
    off = (node("robot_2", place="a.launch.py:9"),)

    found = findings("  robot_2: a\n  x: b\n", node("x"), off=off)

    assert found == PlacementFindings(
        remarks=(
            "hosts.yaml:3: 'robot_2' matches only what a condition keeps away: "
            "/robot_2 at a.launch.py:9",
        )
    )


def test_the_number_of_a_process_that_is_switched_off_is_not_known():
    assert findings("  program-7: a\n  x: b\n", node("x"), off=(node("y"),)).errors == ()


def test_where_functions_may_start_more_a_pattern_without_a_match_is_a_warning():
    found = findings("  robot_2: a\n  x: b\n", node("x"), is_complete=False)

    assert found.errors == ()
    assert found.warnings == (
        "hosts.yaml:3: 'robot_2' matches nothing that can be foreseen; functions may start more",
    )


def test_a_component_runs_where_its_container_does():
    found = findings("  camera: a\n  x: b\n", node("x"), components=(Component("/camera", "/box"),))

    assert only_error(found) == (
        "hosts.yaml:3: 'camera' is a component, which runs where its container does",
        "place the container: '/box: a'",
    )


def test_a_host_that_no_rule_names_is_a_warning():
    found = findings("  x: a\n", node("x"))

    assert found == PlacementFindings(
        warnings=("hosts.yaml:1: no rule of 'place' names the host 'b'",)
    )


def test_a_conflict_is_told_once():
    specs = (node("robot_1"), node("robot_2"))

    found = findings("  'robot_*': a\n  package:demo: b\n", *specs)

    assert len(found.errors) == 1
