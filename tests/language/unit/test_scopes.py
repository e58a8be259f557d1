"""Scopes: changes inside a group end with it. Property tests."""

from __future__ import annotations

import os
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from launcher.base.model.events import TimerFired
from launcher.language.actions.configuration import (
    AppendEnvironmentVariable,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
)
from launcher.language.actions.event_actions import OpaqueFunction
from launcher.language.actions.group import GroupAction
from launcher.language.actions.timer import TimerAction
from launcher.language.context import LaunchContext
from launcher.language.launch_session import current
from launcher.language.ros.node_and_topic_names import make_namespace_absolute, prefix_namespace
from launcher.language.ros.scope import PushROSNamespace
from tests.language.unit.interpreter.interpreting import interpreting
from tests.support.examples import examples

NAMES = st.sampled_from(["a", "b", "c"])
VALUES = st.sampled_from(["1", "2", ""])
VARIABLE_PREFIX = "LAUNCHER_TEST_"

changes = st.one_of(
    st.builds(SetLaunchConfiguration, NAMES, VALUES),
    st.builds(UnsetLaunchConfiguration, NAMES),
    st.builds(lambda: ResetLaunchConfigurations()),
    st.builds(lambda n, v: SetEnvironmentVariable(VARIABLE_PREFIX + n, v), NAMES, VALUES),
    st.builds(lambda n: UnsetEnvironmentVariable(VARIABLE_PREFIX + n), NAMES),
    st.builds(lambda n, v: AppendEnvironmentVariable(VARIABLE_PREFIX + n, v), NAMES, VALUES),
    st.builds(PushROSNamespace, NAMES),
)


def groups(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.builds(
        lambda actions, forwarding, given: GroupAction(
            actions, forwarding=forwarding, launch_configurations=given
        ),
        st.lists(inner, max_size=4),
        st.booleans(),
        st.dictionaries(NAMES, VALUES, max_size=2),
    )


entities = st.recursive(changes, groups, max_leaves=12)


def state(context: LaunchContext) -> tuple[dict[str, Any], dict[str, str]]:
    return context.launch_configurations.copy(), dict(os.environ)


def states_around(entity: Any, *, before: list[Any]) -> tuple[Any, Any]:
    """(state before, state after) the visit of an entity, after some others."""
    seen: list[Any] = []
    look = [OpaqueFunction(function=lambda context: seen.append(state(context))) for _ in "12"]
    with interpreting([*before, look[0], entity, look[1]]) as interpreter:
        interpreter.start()
    return seen[0], seen[1]


@settings(max_examples=examples(150))
@given(before=st.lists(changes, max_size=4), inside=st.lists(entities, max_size=5))
def test_nothing_leaves_a_scoped_group(before: list[Any], inside: list[Any]):
    first, last = states_around(GroupAction(inside), before=before)

    assert first == last


@settings(max_examples=examples(100))
@given(before=st.lists(changes, max_size=4), inside=st.lists(changes, max_size=5))
def test_an_unscoped_group_is_the_same_as_its_actions(before: list[Any], inside: list[Any]):
    _, grouped = states_around(GroupAction(inside, scoped=False), before=before)
    _, plain = states_around(GroupAction([], scoped=False), before=[*before, *inside])

    assert grouped == plain


@settings(max_examples=examples(60))
@given(before=st.lists(changes, max_size=6), inside=st.lists(entities, max_size=3))
def test_a_run_gives_the_environment_back(before: list[Any], inside: list[Any]):
    environment = dict(os.environ)

    states_around(GroupAction(inside, scoped=False), before=before)

    assert dict(os.environ) == environment


@given(
    given_values=st.dictionaries(NAMES, VALUES),
    outside=st.dictionaries(NAMES, VALUES, min_size=1),
)
def test_without_forwarding_only_what_is_given_exists_inside(
    given_values: dict[str, str], outside: dict[str, str]
):
    seen: list[dict[str, Any]] = []
    look = OpaqueFunction(
        function=lambda context: seen.append(context.launch_configurations.copy())
    )
    group = GroupAction([look], forwarding=False, launch_configurations=given_values)
    with interpreting([*(SetLaunchConfiguration(*p) for p in outside.items()), group]) as run:
        run.start()

    assert seen == [given_values]


segments = st.lists(st.sampled_from(["a", "b1", "c_d"]), min_size=1, max_size=3).map("/".join)
namespaces = st.builds(
    lambda head, path, tail: head + path + tail,
    st.sampled_from(["", "/"]),
    segments,
    st.sampled_from(["", "/"]),
)


@given(outer=namespaces.map(lambda namespace: namespace.rstrip("/")), inner=namespaces)
def test_namespaces_join_to_a_well_formed_one(outer: str, inner: str):
    joined = make_namespace_absolute(prefix_namespace(outer, inner))

    assert joined is not None
    assert joined.startswith("/")
    assert not joined.endswith("/")
    assert "//" not in joined
    expected = inner if inner.startswith("/") else f"{outer.rstrip('/')}/{inner}"
    assert joined.strip("/") == expected.strip("/")


@pytest.mark.parametrize(
    ("outer", "inner", "joined"),
    [
        (None, None, None),
        ("g", None, "g"),
        (None, "", ""),
        ("/", "n", "/n"),
        ("/g", "", "/g"),
        ("/g", "/", "/"),
        ("", "n", "n"),
    ],
)
def test_special_namespaces_join_as_in_ros_2(outer: Any, inner: Any, joined: Any):
    assert prefix_namespace(outer, inner) == joined


@pytest.mark.parametrize(
    ("distribution", "inside"), [(None, "outside"), ("kilted", "outside"), ("lyrical", "group")]
)
def test_a_timer_has_the_environment_of_its_visit_since_lyrical(
    distribution: str | None, inside: str
):
    seen: list[str | None] = []
    look = [OpaqueFunction(function=lambda _: seen.append(os.environ.get("COLOUR"))) for _ in "12"]
    change = SetEnvironmentVariable("COLOUR", "changed")
    timers = [TimerAction(period=1.0, actions=[look[0], change])]
    timers += [TimerAction(period=2.0, actions=[look[1]])]
    group = GroupAction([SetEnvironmentVariable("COLOUR", "group"), timers[0]])
    actions = [SetEnvironmentVariable("COLOUR", "outside"), group, timers[1]]
    with interpreting(actions) as interpreter:
        current().target = distribution or "jazzy"
        interpreter.start()
        for timer_id in list(interpreter.host.timers):
            interpreter.handle(TimerFired(timer_id=timer_id))

    assert seen == [inside, "changed" if inside == "outside" else "outside"]


def test_configurations_that_a_launch_file_keeps_are_those_of_their_scope():
    kept: list[Any] = []
    keep = OpaqueFunction(function=lambda context: kept.append(context.launch_configurations))
    inside = [SetLaunchConfiguration("a", "2"), SetLaunchConfiguration("b", "3"), keep]
    with interpreting([SetLaunchConfiguration("a", "1"), GroupAction(inside), keep]) as interpreter:
        interpreter.start()
    assert [dict(one) for one in kept] == [{"a": "2", "b": "3"}, {"a": "1"}]


def test_a_group_that_removes_names_gives_them_back_in_their_order():
    def names(context: LaunchContext) -> None:
        found.append(list(context.launch_configurations))

    found: list[list[str]] = []
    inside = [
        SetLaunchConfiguration("c", "1"),
        UnsetLaunchConfiguration("a"),
        OpaqueFunction(function=names),
    ]
    sets = [SetLaunchConfiguration(name, "1") for name in "ab"]
    with interpreting([*sets, GroupAction(inside), OpaqueFunction(function=names)]) as interpreter:
        interpreter.start()
    assert found == [["b", "c"], ["a", "b"]]
