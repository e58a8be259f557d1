"""Pairs of names and what a node answers for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import SetParametersResult

from launcher.ros.parameters import answers, named, results_of

Node = Callable[[Sequence[str], set[str]], list[str]]


def all_or_none(names: Sequence[str], unset: set[str]) -> list[str]:
    """As rclpy and rclcpp answer."""
    return [] if unset & set(names) else [f"value of {name}" for name in names]


def up_to_the_first(names: Sequence[str], unset: set[str]) -> list[str]:
    first = next((i for i, name in enumerate(names) if name in unset), len(names))
    return [f"value of {name}" for name in names[:first]]


def without_them(names: Sequence[str], unset: set[str]) -> list[str]:
    return [f"value of {name}" for name in names if name not in unset]


@pytest.mark.parametrize("node", [all_or_none, up_to_the_first, without_them])
@given(st.integers(0, 20), st.sets(st.integers(0, 19)))
def test_every_name_gets_its_own_answer_and_none_if_there_is_nothing(
    node: Node, count: int, numbers: set[int]
):
    names, unset = [f"p{i}" for i in range(count)], {f"p{i}" for i in numbers}
    asking, asked = answers(names), []
    try:
        request = next(asking)
        while True:
            asked.append(request)
            request = asking.send(node(request, unset))
    except StopIteration as end:
        found = end.value
    expected = {name: None if name in unset else f"value of {name}" for name in names}
    assert found == expected and list(found) == names
    assert len(asked) == (1 if names else 0) or unset & set(names)


def test_a_parameter_that_a_node_has_not_judged_is_not_set():
    judged = SetParametersResult(successful=True)
    fewer = results_of(SimpleNamespace(results=[judged]), 2)
    assert [one.successful for one in fewer] == [True, False]
    assert fewer[1].reason == "the node has not answered for it"
    assert results_of(SimpleNamespace(results=[judged, judged]), 1) == [judged]


@pytest.mark.parametrize(
    ("reason", "names", "shown"),
    [
        ("Invalid access to undeclared parameter(s): []", ["a"], "'a'"),
        ("Invalid access to undeclared parameter(s): ['b']", ["a", "b"], "'a', 'b'"),
        ("Invalid access to undeclared parameter(s): ['b']", [], "'b'"),
    ],
)
def test_what_is_not_declared_is_named(reason: str, names: list[str], shown: str):
    result = SetParametersResult(successful=False, reason=reason)

    assert named(result, names).reason == f"Invalid access to undeclared parameter(s): [{shown}]"


def test_other_reasons_stay():
    assert named(SetParametersResult(reason="too fast"), ["a"]).reason == "too fast"
