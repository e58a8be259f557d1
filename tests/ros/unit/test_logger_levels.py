"""The nodes of a process whose names and endpoints are discovered one by one."""

from __future__ import annotations

import os
from typing import Any

import pytest

from launcher.ros import node_tables
from launcher.ros.helpers import logger_levels, parameter_check
from launcher.ros.helpers.parameter_check import NodeToCheck, ParameterComparison
from launcher.ros.node_tables import Owner

OURS = os.getpid()
FIRST, SECOND = Owner(node="/first", pid=OURS), Owner(node="/second", pid=OURS)
NAME_OF_SECOND = Owner(node="/second", undiscovered=True)
ANOTHER = Owner(node="/another_host")
CALLER: Any = None  # `owners` is replaced


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[list[Owner]]:
    """What is found at each look, the last of them again and again."""
    found: list[list[Owner]] = []
    monkeypatch.setattr(
        node_tables, "owners", lambda *_, **__: found.pop(0) if len(found) > 1 else found[0]
    )
    monkeypatch.setattr(logger_levels, "PERIOD_S", 0.0)
    return found


def asked(find_s: float = 60.0) -> list[str | None]:
    question = {"node": None, "pid": OURS}
    return logger_levels._nodes(CALLER, question, logger_levels.time.monotonic() + find_s)


def test_a_node_whose_name_alone_is_known_is_waited_for(looks: list[list[Owner]]):
    looks += [[], [NAME_OF_SECOND], [FIRST, NAME_OF_SECOND], [FIRST, SECOND, ANOTHER]]
    assert asked() == ["/first", "/second"]


def test_a_node_that_never_has_an_endpoint_is_waited_for_only_for_a_while(
    looks: list[list[Owner]], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(logger_levels, "NO_SERVICE_S", 0.01)
    looks += [[FIRST, NAME_OF_SECOND]]
    assert asked() == ["/first"]


def test_a_process_without_a_node_has_none(looks: list[list[Owner]]):
    looks += [[ANOTHER]]
    assert asked(find_s=0.01) == [None]


def test_parameters_are_those_of_a_node_only_if_it_is_the_only_one(looks: list[list[Owner]]):
    process = NodeToCheck(place="a.launch.py:1", pid=OURS, argv=["node"])
    comparison = ParameterComparison([process], lambda text: None)
    looks += [[FIRST, NAME_OF_SECOND], [FIRST, SECOND]]
    for _ in range(2):
        comparison._find_names(CALLER, [process])
        assert process.name is None


def test_parameters_are_compared_where_a_node_never_has_an_endpoint(
    looks: list[list[Owner]], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(parameter_check, "NO_SERVICES_S", -1.0)
    process = NodeToCheck(place="a.launch.py:1", pid=OURS, argv=["node"])
    looks += [[FIRST, NAME_OF_SECOND]]
    ParameterComparison([process], lambda text: None)._find_names(CALLER, [process])
    assert process.name == "/first"
