"""Which of the nodes that rmw lists belong to participants that have gone."""

from __future__ import annotations

from launcher.ros.discovery.stale_nodes import StaleNodes


class Graph:
    """A graph over time: `owners` of each look, and the participants that there are."""

    def __init__(self) -> None:
        self.stale = StaleNodes()

    def look(self, *nodes: str, **owners: str) -> list[str]:
        """Nodes by their listed names; `owners`: the participants of each, by a letter."""
        there = set("".join(owners.values())) | {"own"}
        by_name = {name: set(letters) for name, letters in owners.items()}
        return self.stale.without(nodes, by_name, lambda: there)


def test_a_node_that_is_listed_after_its_participant_has_gone_is_stale():
    graph = Graph()
    assert graph.look("a", "b", a="A", b="B") == ["a", "b"]
    assert graph.look("a", "b", b="B") == ["b"]
    assert graph.look("a", "b", b="B") == ["b"]
    assert graph.look("b", b="B") == ["b"]


def test_a_node_that_has_restarted_is_there_once():
    graph = Graph()
    assert graph.look("a", a="A") == ["a"]
    assert graph.look("a", "a", a="B") == ["a"]
    assert graph.look("a", "a", a="BC") == ["a", "a"]  # and a namesake
    assert graph.look("a", "a", "a", a="BC") == ["a", "a"]


def test_a_node_that_restarts_often_leaves_no_more_than_are_stale():
    graph = Graph()
    for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ":
        assert graph.look("a", a=letter) == ["a"]
    assert graph.look("a", "a", a="Z") == ["a"]
    assert graph.look("a") == []


def test_a_node_without_endpoints_whose_participant_is_there_is_no_stale_one():
    stale = StaleNodes()
    assert stale.without(["a"], {"a": {"A"}}, lambda: {"A"}) == ["a"]
    assert stale.without(["a"], {}, lambda: {"A"}) == ["a"]
    assert stale.without(["a"], {}, lambda: {"B"}) == []


def test_namesakes_of_one_participant_stay():
    graph = Graph()
    assert graph.look("a", "a", a="A") == ["a", "a"]


def test_nothing_is_known_of_nodes_that_never_had_endpoints_or_without_participants():
    assert Graph().look("a", "b", b="B") == ["a", "b"]
    stale = StaleNodes()
    assert stale.without(["a"], {"a": {"A"}}, set) == ["a"]
    assert stale.without(["a"], {}, set) == ["a"]  # a middleware that is not DDS


def test_the_participants_are_asked_for_only_if_a_node_lacks_endpoints():
    def fail() -> set[str]:
        raise AssertionError

    assert StaleNodes().without(["a", "b"], {"a": {"A"}, "b": {"A"}}, fail) == ["a", "b"]


def test_what_is_remembered_is_bounded():
    graph = Graph()
    for number in range(3000):
        graph.look(f"n{number}", **{f"n{number}": chr(200 + number)})
    assert len(graph.stale._owners) <= 1000
