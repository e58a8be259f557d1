"""Supervision files: what they say, and each mistake with its place and its repair."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest
import yaml

from launcher.base.errors import LauncherError
from launcher.base.model.fault_action import FaultAction
from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.spec import ProcessSpec, RestartMode, RosIdentity
from launcher.base.model.supervision import After, Fact, StartRule, rule_for
from launcher.launch.launch_options import supervision_file, with_settings_beside
from launcher.launch.plan.planner import make_plan
from launcher.launch.supervise.circles import circle_among
from launcher.launch.supervise.ready_fields import KINDS
from launcher.launch.supervise.supervise_fields import json_schema
from launcher.launch.supervise.supervise_reader import parse, read
from launcher.run.monitor.budget_parser import parse_words
from launcher.run.option_warnings import unmatched
from tests.support.repository import REPOSITORY


def rules(text: str) -> list[StartRule]:
    return [value for field, value in parse(text, "s.yaml") if field == "start_rules"]


def facts(text: str) -> tuple[Fact, ...]:
    (rule,) = rules(f"a:\n  ready_when:\n    {text}\n")
    assert rule.ready_when is not None
    return rule.ready_when


def spec(name: str, node: str | None = None, namespace: str | None = None) -> ProcessSpec:
    ros = None if node is None else RosIdentity(node_name=node, namespace=namespace)
    return ProcessSpec(name=name, label=name.rpartition("-")[0], argv=("x",), env={}, ros=ros)


def rendered(text: str) -> str:
    with pytest.raises(LauncherError) as caught:
        parse(text, "s.yaml")
    assert caught.value.exit_code == 2
    return caught.value.render()


# ---- what it says


def test_budgets_and_policies_are_those_of_the_options():
    text = "# limits\nrobot_*:\n  memory: 200M\n  cpu: 80%\nmonitor: {fds: 64, action: restart}\n"
    found = parse(f"{text}\ndispatcher: {{restart: 'on-failure,max=5', nice: 5}}\n", "s.yaml")
    budgets = [value for field, value in found if field == "file_budgets"]
    assert budgets == parse_words(["robot_*:memory=200M,cpu=80%", "monitor:fds=64,action=restart"])
    (restart,) = [value for field, value in found if field == "restart"]
    assert (restart[0], restart[1].mode, restart[1].max_restarts) == (
        "dispatcher",
        RestartMode.ON_FAILURE,
        5,
    )
    (limits,) = [value for field, value in found if field == "limits"]
    assert limits[1].nice == 5
    assert [value for field, value in found if field == "file_names"] == [
        ("robot_*", "s.yaml:2"),
        ("monitor", "s.yaml:5"),
        ("dispatcher", "s.yaml:7"),
    ]


@pytest.mark.parametrize("text", ["", "# nothing yet\n", "{}\n"])
def test_an_empty_file_says_nothing(text: str):
    assert parse(text, "s.yaml") == []


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        ("{node: /x}", Fact(kind="node", subject="/x")),
        ("{publisher: /t}", Fact(kind="publisher", subject="/t")),
        (
            "{subscription: {topic: /t, node: '*'}}",
            Fact(kind="subscription", subject="/t", node="*"),
        ),
        (
            "{message: {topic: /t, type: std_msgs/msg/String}}",
            Fact(kind="message", subject="/t", type="std_msgs/msg/String"),
        ),
        ("{service: /s}", Fact(kind="service", subject="/s")),
        (
            "{service: {name: /s, type: a/srv/B, request: {data: true, n: [1, x]}}}",
            Fact(
                kind="service", subject="/s", type="a/srv/B", request={"data": True, "n": [1, "x"]}
            ),
        ),
        ("{service: {name: /s, call: false}}", Fact(kind="service", subject="/s", call=False)),
        ("{lifecycle: active}", Fact(kind="lifecycle", subject="active")),
        (
            "{lifecycle: {state: inactive, node: /n}}",
            Fact(kind="lifecycle", subject="inactive", node="/n"),
        ),
        ("{log: 'is ready$'}", Fact(kind="log", subject="is ready$")),
        ("{port: 8080}", Fact(kind="port", subject="127.0.0.1:8080")),
        (
            "{port: {address: '[::1]:80', every: 200 ms}}",
            Fact(kind="port", subject="[::1]:80", every_s=0.2),
        ),
        (
            "{command: test -e x}",
            Fact(kind="command", subject="test -e x", words=("/bin/sh", "-c", "test -e x")),
        ),
        (
            "{command: {run: [test, -e, 'a b'], every: 2}}",
            Fact(kind="command", subject="test -e a b", words=("test", "-e", "a b"), every_s=2.0),
        ),
        ("{exit: 0}", Fact(kind="exit", subject="0")),
    ],
)
def test_each_kind_of_fact(text: str, fact: Fact):
    assert facts(text) == (fact,)
    jsonschema.validate({"a": {"ready_when": yaml.safe_load(text)}}, json_schema())


def test_every_kind_of_fact_is_tried_above():
    parameters = test_each_kind_of_fact.pytestmark[0].args[1]
    assert {fact.kind for _, fact in parameters} == {kind.name for kind in KINDS}


def test_several_facts_in_one_mapping_or_in_a_list():
    both = (Fact(kind="publisher", subject="/t"), Fact(kind="log", subject="up"))
    assert facts("{publisher: /t, log: up}") == both
    assert facts("[{publisher: /t}, {log: up}]") == both


@pytest.mark.parametrize(
    ("text", "after"),
    [
        ("b", After(names=("b",))),
        ("[b, c_*]", After(names=("b", "c_*"))),
        ("[]", After(names=())),
        (
            "{processes: b, timeout: 500 ms, on_timeout: stop-run}",
            After(names=("b",), timeout_s=0.5, on_timeout="stop-run"),
        ),
    ],
)
def test_what_a_process_waits_for(text: str, after: After):
    (rule,) = rules(f"a: {{after: {text}}}")
    assert rule.after == after


def test_names_that_are_waited_for_are_known_by_their_places():
    found = parse("a:\n  nice: 1\n  after: [b]\n", "s.yaml")
    names = [value for field, value in found if field == "file_names"]
    assert names == [("a", "s.yaml:1"), ("b", "s.yaml:3")]


def test_of_each_entry_the_last_rule_that_matches_counts():
    found = rules(
        "robot_*: {after: dispatcher, ready_when: {log: up}}\n"
        "robot_1: {after: []}\n"
        "robot_2: {ready_when: {port: 80}}\n"
    )
    one, two, three = (rule_for(found, spec(f"robot_{n}-{n}")) for n in (1, 2, 3))
    assert one.after == After(names=())
    assert [fact.kind for fact in one.ready_when or ()] == ["log"]
    assert two.after == three.after == After(names=("dispatcher",))
    assert [fact.kind for fact in two.ready_when or ()] == ["port"]
    assert rule_for(found, spec("monitor-9")).is_empty


def test_a_fact_has_the_names_of_its_process():
    (rule,) = rules(
        "robot_*:\n"
        "  ready_when: {publisher: '{namespace}/status', node: '{node}', command: 'true {name}'}\n"
    )
    found = rule_for([rule], spec("robot_1-3", "body", "/robot_1")).ready_when
    assert found is not None
    publisher, node, command = found
    assert (publisher.subject, publisher.node, publisher.is_own) == (
        "/robot_1/status",
        "/robot_1/body",
        True,
    )
    assert (node.subject, node.is_own) == ("/robot_1/body", True)
    assert command.words == ("/bin/sh", "-c", "true robot_1")


def test_what_another_node_has_may_be_older_than_the_process():
    (rule,) = rules("a: {ready_when: {publisher: {topic: /map, node: '*'}, node: /other}}")
    found = rule_for([rule], spec("a-1", "a", "/")).ready_when or ()
    assert [fact.is_own for fact in found] == [False, False]


# ---- processes of the launch file


def test_patterns_make_circles_among_the_processes_of_a_launch_file():
    found = rules("'*_a': {after: 'x_*'}\n'x_?':\n  after: ['*_a', '*_b']\n")
    assert circle_among(found, [spec("y_b-1"), spec("x_b-2"), spec("y_a-3")]) is not None
    error = circle_among(found, [spec("x_b-1"), spec("y_a-2")])
    assert error is not None
    assert error.where == "s.yaml:3"
    assert error.message == "circle: x_b-1 waits for y_a-2, which waits for x_b-1"
    assert circle_among(found, [spec("y_b-1"), spec("x_c-2")]) is None


def test_a_process_does_not_wait_for_itself_by_a_pattern():
    found = rules("'robot_*': {after: robot_1}\n")
    assert circle_among(found, [spec("robot_1-1"), spec("robot_2-2")]) is None


def test_the_example_is_about_the_processes_of_the_fleet():
    path = REPOSITORY / "examples" / "system.supervise.yaml"
    names = [value for field, value in read(str(path)) if field == "file_names"]
    launched = [
        one.spec for one in make_plan(str(REPOSITORY / "launch/system.launch.py"), ()).processes
    ]
    assert all(any(matches(name, one) for one in launched) for name, _ in names)
    jsonschema.validate(yaml.safe_load(path.read_text(encoding="utf-8")), json_schema())
    assert not (
        REPOSITORY / "launch" / "system.supervise.yaml"
    ).exists()  # robots start at once there


# ---- where it is


@pytest.mark.parametrize(
    ("launch_file", "file"),
    [
        ("/a/system.launch.py", "/a/system.supervise.yaml"),
        ("/a/system_launch.xml", "/a/system.supervise.yaml"),
        ("/a/a.b.launch.yaml", "/a/a.b.supervise.yaml"),
        ("run.py", "run.supervise.yaml"),
    ],
)
def test_the_file_stands_beside_the_launch_file(launch_file: str, file: str):
    assert supervision_file(launch_file) == file


def test_the_file_beside_is_overridden_by_options(tmp_path: Path):
    (tmp_path / "a.supervise.yaml").write_text("x: {restart: always}\ny: {after: x}\n")
    given = RunOptions(restart=(("x", "by option"),))  # type: ignore[arg-type]
    options = with_settings_beside(given, str(tmp_path / "a.launch.py"))
    assert [pattern for pattern, _ in options.restart] == ["x", "x"]
    assert options.restart[-1][1] == "by option"
    assert [rule.pattern for rule in options.start_rules] == ["y"]


def test_a_file_of_the_command_line_replaces_the_one_beside(tmp_path: Path):
    (tmp_path / "a.supervise.yaml").write_text("[broken")
    target = str(tmp_path / "a.launch.py")
    for options in (RunOptions(file_names=(("x", "b.yaml:1"),)), RunOptions(settings_beside=False)):
        assert with_settings_beside(options, target) == options


# ---- actions for faults


def actions(text: str) -> list[FaultAction]:
    return [value for field, value in parse(text, "s.yaml") if field == "fault_actions"]


def test_what_is_done_for_a_fault():
    # `on` is a text here; many readers of YAML take it for true.
    found = actions(
        "on:\n"
        "- {fault: robot_1 reports, do: restart robot_1 robot_2}\n"
        "- {fault: 'no deaths: *', do: {run: [date, -u]}, within: 2 min, at_most: 2 per 5 s}\n"
        "- {fault: '*', do: 'run echo {a}: b', when: healed}\n"
        "- {fault: '*', do: webhook https://h/secret, headers: {Authorization: TOKEN}}\n"
        "- {fault: '*', do: webhook $HOOK}\n"
        "- {fault: '*', do: snapshot}\n"
    )
    restart, date, shell, web, _, snapshot = found
    assert (restart.kind, restart.names) == ("restart", ("robot_1", "robot_2"))
    assert (restart.when, restart.within_s, restart.times, restart.period_s) == (
        "confirmed",
        10.0,
        3,
        600.0,
    )
    assert (date.words, date.within_s, date.times, date.period_s) == (("date", "-u"), 120, 2, 5)
    assert (shell.words, shell.when) == (("/bin/sh", "-c", "echo {a}: b"), "healed")
    assert web.headers == (("Authorization", "TOKEN"),)
    assert [one.text for one in found] == [
        "restart robot_1 robot_2",
        "run date -u",
        "run echo {a}: b",
        "webhook h",
        "webhook $HOOK",
        "snapshot",
    ]
    assert snapshot.where == "s.yaml:7"
    assert actions("on: {fault: x, do: stop a}") == actions("'on': {fault: x, do: {stop: [a]}}")


def test_a_fault_that_follows_from_another_is_meant_only_by_its_name():
    (exact, pattern, odd) = actions(
        "on: [{fault: a, do: snapshot}, {fault: 'a*', do: snapshot}, {fault: '[x]', do: snapshot}]"
    )
    assert exact.fits("a", follows=True) and not exact.fits("ab", follows=False)
    assert pattern.fits("ab", follows=False) and not pattern.fits("a", follows=True)
    assert odd.fits("[x]", follows=True) and odd.fits("x", follows=False)


def test_processes_of_actions_are_known_by_their_places():
    found = parse("on:\n- {fault: x, do: restart dispacher}\n", "s.yaml")
    names = tuple(value for field, value in found if field == "file_names")
    assert names == (("dispacher", "s.yaml:2"),)
    ((text, meant),) = unmatched(RunOptions(file_names=names), [spec("dispatcher-1")])
    assert "dispacher" in text and "did you mean 'dispatcher'?" in meant


def test_a_file_with_actions_alone_replaces_the_one_beside(tmp_path: Path):
    (tmp_path / "a.supervise.yaml").write_text("[broken")
    options = RunOptions(fault_actions=tuple(actions("on: {fault: x, do: desktop}")))
    assert with_settings_beside(options, str(tmp_path / "a.launch.py")) == options


# ---- the schema


def test_the_schema_in_the_repository_is_the_one_that_is_printed():
    path = REPOSITORY / "launcher/launch/supervise/supervise.schema.json"
    assert json.loads(path.read_text(encoding="utf-8")) == json_schema()


@pytest.mark.parametrize(
    "text",
    [
        "a: {memroy: 3}",
        "a: {ready_when: {publsher: /t}}",
        "a: 3",
        "a: {after: {timeout: 3}}",
        "'on': {fault: x, do: restrt a}",
        "'on': [{do: snapshot}]",
    ],
)
def test_the_schema_refuses_mistakes_as_well(text: str):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(yaml.safe_load(text), json_schema())
