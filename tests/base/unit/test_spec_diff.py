"""What differs between two specifications, and which processes are the same."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from launcher.base.model.record import replace
from launcher.base.model.spec import (
    Limits,
    ParameterSource,
    ProcessSpec,
    RestartMode,
    RestartPolicy,
    RosIdentity,
    StopPolicy,
)
from launcher.base.model.spec_diff import comparable, differences, match, needs_restart

SPEC = ProcessSpec(name="a-1", label="a", argv=("a", "--x", "1"), env={"A": "1"}, place="f:1")


def node(label: str, name: str | None, place: str, *, file: str = "", **parameters: object):
    generated = {"/**": {"ros__parameters": parameters}}
    words = ("--params-file", file) if file else ()
    sources = (ParameterSource(file=file, generated=generated),) if file else ()
    ros = RosIdentity(node_name=name, parameters=sources)
    argv = (label, "--ros-args", "-r", f"__node:={name}", *words)
    return ProcessSpec(name=f"{label}-1", label=label, argv=argv, env={}, ros=ros, place=place)


@pytest.mark.parametrize(
    ("changes", "texts", "restarts"),
    [
        ({}, [], False),
        ({"name": "a-9", "place": "f:2", "output_given": "screen"}, [], False),
        ({"argv": ("a", "--x", "2")}, ["command line"], True),
        ({"env": {"A": "2", "B": "1"}}, ["environment (A, B)"], True),
        ({"env": {}}, ["environment (A)"], True),
        ({"cwd": "/tmp"}, ["working directory"], True),
        ({"shell": True}, ["shell"], True),
        ({"emulate_tty": True}, ["emulate_tty"], True),
        ({"limits": Limits(nice=3)}, ["limits"], True),
        ({"restart": RestartPolicy(mode=RestartMode.ALWAYS)}, ["restart policy"], False),
        ({"stop": StopPolicy(polite=((signal.SIGTERM, 1.0),))}, ["stop policy"], False),
    ],
)
def test_differences(changes: dict[str, object], texts: list[str], restarts: bool):
    found = differences(comparable(SPEC), comparable(replace(SPEC, **changes)))

    assert found == texts
    assert needs_restart(found) is restarts


@pytest.mark.parametrize(
    ("before", "after", "texts"),
    [
        ({"a": 1}, {"a": 1}, []),
        ({"a": 1}, {"a": 2}, ["parameter a: 1 -> 2"]),
        ({"a": 1}, {"a": 1.0, "b": "x"}, ["parameter b is new: 'x'"]),
        ({"a": 1, "g": {"k": 2}}, {"a": 1}, ["parameter g.k is gone"]),
    ],
)
def test_parameters_are_compared_by_value_not_by_the_path_of_their_file(
    before: dict[str, object], after: dict[str, object], texts: list[str]
):
    old = node("r", "r", "f:1", file="/tmp/launch_params_1", **before)
    new = node("r", "r", "f:1", file="/tmp/launch_params_2", **after)

    assert differences(comparable(old), comparable(new)) == texts


def test_a_temporary_file_of_a_launch_file_is_compared_by_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_text("same")
    two.write_text("same")
    old = comparable(replace(SPEC, argv=("a", f"--config={one}")))

    assert differences(old, comparable(replace(SPEC, argv=("a", f"--config={two}")))) == []
    two.write_text("other")
    assert differences(old, comparable(replace(SPEC, argv=("a", str(f"--config={two}"))))) == [
        "command line"
    ]


def labels(*labels: str) -> list[ProcessSpec]:
    return [
        ProcessSpec(name=f"{label}-{n}", label=label, argv=(label,), env={}, place=f"f:{n}")
        for n, label in enumerate(labels)
    ]


@pytest.mark.parametrize(
    ("old", "new", "pairs"),
    [
        (labels("a", "b"), labels("a", "b"), {0: 0, 1: 1}),
        (labels("a", "b"), labels("b", "c", "a"), {0: 1, 2: 0}),
        (labels("a", "a"), labels("a"), {0: 0}),
        (labels("a"), labels("a", "a"), {0: 0}),
        ([], labels("a"), {}),
        (labels("a"), [], {}),
        # One of three alike is taken out: the nodes decide, not the order.
        (
            [node("r", "one", "f:1"), node("r", "two", "f:2"), node("r", "three", "f:3")],
            [node("r", "one", "f:1"), node("r", "three", "f:2")],
            {0: 0, 1: 2},
        ),
        # A node got another name in its place; the other one has moved.
        (
            [node("r", "one", "f:1"), node("r", "two", "f:2")],
            [node("r", "two", "f:1"), node("r", "uno", "f:2")],
            {0: 1, 1: 0},
        ),
        # Parameters of one have changed; it is found by its node.
        (
            [node("r", "one", "f:1", file="/t/1", a=1), node("r", "two", "f:1", file="/t/2", a=1)],
            [node("r", "two", "f:1", file="/t/3", a=2), node("r", "one", "f:1", file="/t/4", a=1)],
            {0: 1, 1: 0},
        ),
        # A node is another program now: not the same process.
        ([node("r", "one", "f:1")], [node("s", "one", "f:1")], {}),
    ],
)
def test_which_processes_are_the_same(
    old: list[ProcessSpec], new: list[ProcessSpec], pairs: dict[int, int]
):
    assert match([comparable(one) for one in old], [comparable(one) for one in new]) == pairs
