"""Mistakes in supervise files, each reported with its line and its repair."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.errors import LauncherError, LaunchFileError
from launcher.launch.supervise.supervise_reader import parse, read
from tests.launch.unit.test_supervise_file import rendered, rules


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("a:\n  cpu: 1\n  memroy: 2M\n", "s.yaml:3: unknown key 'memroy' of 'a'"),
        ("a:\n  cpu: hot\n", "s.yaml:2: invalid value 'hot' for 'cpu'"),
        ("a:\n  for: 3\n", "s.yaml:2: no limit for 'a'"),
        ("a:\n  cpu: [1]\n", "s.yaml:2: 'cpu' takes one value"),
        ("a: 3\n", "s.yaml:1: 'a' must be a mapping of settings"),
        ("a:\n", "s.yaml:1: 'a' must be a mapping of settings"),
        ("- a\n", "s.yaml:1: a supervision file must be a mapping"),
        ("a: {nice: 1}\na: {nice: 2}\n", "s.yaml:2: duplicate key 'a'"),
        ("a:\n  cpu: {1\nb: 2", "s.yaml:3: invalid YAML"),
        ("a: \x00", "s.yaml:1: invalid YAML: the character U+0000"),
        (
            "a: {restart: sometimes}",
            "s.yaml:1: invalid value 'sometimes' for 'restart': the mode is one of",
        ),
        ("a: {stop: 'int:soon'}", "s.yaml:1: invalid value 'int:soon' for 'stop': 'soon'"),
        ("a: {ready_when: soon}", "s.yaml:1: 'soon' is not a fact"),
        ("a: {ready_when: {}}", "s.yaml:1: {} is not a fact"),
        ("a: {ready_when: {publsher: /t}}", "s.yaml:1: unknown kind of fact 'publsher'"),
        ("a: {ready_when: {publisher: tasks}}", "s.yaml:1: 'tasks' is not the full name of a"),
        ("a: {ready_when: {publisher: {node: /n}}}", "s.yaml:1: 'publisher' needs 'topic'"),
        ("a: {ready_when: {message: {topic: /t, type: String}}}", "s.yaml:1: 'String' is not a m"),
        ("a: {ready_when: {service: {name: /s, call: maybe}}}", "s.yaml:1: 'maybe' is not true"),
        ("a: {ready_when: {service: {name: /s, request: 3}}}", "s.yaml:1: '3' is not a request"),
        ("a: {ready_when: {lifecycle: activ}}", "s.yaml:1: 'activ' is not one of unconfigured"),
        ("a: {ready_when: {log: '('}}", "s.yaml:1: invalid regular expression '(': missing )"),
        ("a: {ready_when: {port: http}}", "s.yaml:1: 'http' is not a TCP port"),
        ("a: {ready_when: {port: 70000}}", "s.yaml:1: '70000' is not a TCP port"),
        ("a: {ready_when: {port: 'robot:80'}}", "s.yaml:1: 'robot' is not an IP address"),
        ("a: {ready_when: {command: []}}", "s.yaml:1: [] is not a command"),
        ("a: {ready_when: {command: {run: x, every: 1 ms}}}", "s.yaml:1: '1 ms' is too often"),
        ("a: {ready_when: {exit: 300}}", "s.yaml:1: '300' is not an exit code"),
        ("a: {after: {timeout: 3}}", "s.yaml:1: 'after' needs 'processes'"),
        ("a: {after: {processes: b, timeout: soon}}", "s.yaml:1: invalid time 'soon'"),
        ("a: {after: {processes: b, on_timeout: fale}}", "s.yaml:1: 'fale' is not one of start"),
        ("a: {after: [b, {}]}", "s.yaml:1: {} is not the name of a process"),
        ("a: {restart_with: ''}", "s.yaml:1: '' is not the name of a process"),
        ("a: {after: a}", "s.yaml:1: 'a' waits for itself"),
        (
            "a: {after: b}\nb: {after: c}\nc: {after: a}\n",
            "s.yaml:1: circle: a waits for b, which waits for c, which waits for a",
        ),
        (
            "dispatcher: {after: 'robot_*'}\nrobot_1: {after: dispatcher}\n",
            "s.yaml:1: circle: dispatcher waits for robot_1, which waits for dispatcher",
        ),
        (
            "a: {restart_with: b}\nb: {restart_with: a}\n",
            "s.yaml:1: circle: a is restarted with b, which is restarted with a",
        ),
    ],
)
def test_a_mistake_is_reported_with_its_line(text: str, first: str):
    assert rendered(text).startswith(f"error: {first}")


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("on:\n- {fault: x, do: restrt a}\n", "s.yaml:2: unknown action 'restrt'"),
        ("on: 3", "s.yaml:1: 'on' must be a list of what is done for faults"),
        ("on: {memory: 3}", "s.yaml:1: unknown key 'memory' of 'on'"),
        ("on: {fault: x}", "s.yaml:1: 'on' needs 'do'"),
        ("on: {do: snapshot}", "s.yaml:1: 'on' needs 'fault'"),
        ("on: {fault: '', do: snapshot}", "s.yaml:1: '' is not the name of a fault"),
        ("on: {fault: x, do: restart}", "s.yaml:1: 'restart': it needs the name of a process"),
        ("on: {fault: x, do: {restart: [a, {}]}}", "s.yaml:1: 'restart': {} is not a process"),
        ("on: {fault: x, do: {fly: a}}", "s.yaml:1: unknown action 'fly'"),
        ("on: {fault: x, do: snapshot now}", "s.yaml:1: 'snapshot': 'now' is too much"),
        ("on: {fault: x, do: run}", "s.yaml:1: 'run': '' is not a command"),
        ("on: {fault: x, do: webhook ftp://h/}", "s.yaml:1: 'webhook': expected an address"),
        ("on: {fault: x, do: webhook 'http://u:p@h'}", "s.yaml:1: 'webhook': expected an address"),
        ("on: {fault: x, do: desktop, within: 0 s}", "s.yaml:1: '0 s' is not a time limit"),
        ("on: {fault: x, do: desktop, when: heald}", "s.yaml:1: 'heald' is not one of confirmed"),
        ("on: {fault: x, do: desktop, at_most: 3}", "s.yaml:1: '3' is not a budget"),
        ("on: {fault: x, do: desktop, at_most: 0 per 3 s}", "s.yaml:1: '0 per 3 s' is not a b"),
        ("on: {fault: x, do: desktop, headers: {A: B}}", "s.yaml:1: only a webhook has headers"),
        (
            "on: {fault: x, do: webhook $H, headers: {A: Bearer x}}",
            "s.yaml:1: 'A' takes the name of an environment variable",
        ),
    ],
)
def test_mistakes_in_actions_for_faults(text: str, first: str):
    assert rendered(text).startswith(f"error: {first}")


def test_all_mistakes_are_reported_together_each_with_its_repair():
    text = (
        "a:\n"
        "  memroy: 2M\n"
        "  after: {processes: b, on_timeout: fale, tiemout: 3}\n"
        "  ready_when:\n"
        "    - servce: /x\n"
        "    - publisher: {topic: x, nod: '*'}\n"
    )
    lines = rendered(text).splitlines()
    assert [line for line in lines if line.startswith("error:")] == [
        "error: s.yaml:2: unknown key 'memroy' of 'a'",
        "error: s.yaml:3: 'fale' is not one of start, fail, stop-run",
        "error: s.yaml:3: 'after' has no 'tiemout'",
        "error: s.yaml:5: unknown kind of fact 'servce'",
        "error: s.yaml:6: 'x' is not the full name of a topic",
        "error: s.yaml:6: 'publisher' has no 'nod'",
    ]
    hints = [line for line in lines if line.startswith("hint:")]
    assert hints == [
        "hint: did you mean 'memory'?",
        "hint: did you mean 'fail'?",
        "hint: did you mean 'timeout'?",
        "hint: did you mean 'service'?",
        "hint: as in /fleet/tasks or /{name}/status",
        "hint: did you mean 'node'?",
    ]
    assert lines[2] == "      ^"  # below the key


def test_a_missing_file_is_reported(tmp_path: Path):
    with pytest.raises(LaunchFileError, match="cannot read the supervision file"):
        read(str(tmp_path / "nope.yaml"))


def test_a_chain_of_a_thousand_names_is_no_circle_and_a_long_circle_is_cut():
    chain = "".join(f"n{i}: {{after: n{i + 1}}}\n" for i in range(1000))
    assert len(rules(chain)) == 1000
    message = rendered(f"{chain}n1000: {{after: n0}}\n").splitlines()[0]
    assert "n0 waits for n1, which" in message
    assert len(message) < 500


def test_aliases_that_repeat_each_other_are_refused_in_short():
    bomb = "x0: &x0 [a, a]\n" + "".join(
        f"x{i}: &x{i} [{', '.join([f'*x{i - 1}'] * 9)}]\n" for i in range(1, 30)
    )
    text = rendered(f"{bomb}y: {{after: *x29, ready_when: {{command: *x29}}, cpu: *x29}}\n")
    assert len(text) < 100_000  # written out it would be 9 ** 29 entries


@given(st.text())
def test_any_content_is_read_or_a_clean_error(text: str):
    try:
        parse(text, "s.yaml")
    except LauncherError as error:
        assert error.exit_code == 2


@given(
    st.dictionaries(
        st.sampled_from(["after", "ready_when", "restart_with", "memory", "restart"]),
        st.recursive(
            st.none() | st.integers() | st.text(max_size=5),
            lambda inner: (
                st.lists(inner, max_size=3)
                | st.dictionaries(
                    st.sampled_from(["publisher", "port", "topic", "processes", "timeout", "run"]),
                    inner,
                    max_size=3,
                )
            ),
            max_leaves=6,
        ),
        min_size=1,
    )
)
def test_any_values_are_read_or_a_clean_error(entry: dict[str, Any]):
    try:
        parse(yaml.safe_dump({"a": entry}, allow_unicode=True), "s.yaml")
    except LauncherError as error:
        assert error.exit_code == 2
