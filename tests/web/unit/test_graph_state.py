"""Nodes that went stay for a while, with their process and what they used."""

from __future__ import annotations

from typing import Any

from launcher.web.graph_state import GONE_CLEAN_S, GONE_S, GraphState, process_of


def graph(*nodes: str, ghosts: tuple[str, ...] = (), pid: int = 7) -> dict[str, Any]:
    return {
        "event": "graph",
        "complete": True,
        "nodes": [
            {
                "name": name,
                "hidden": "/_" in name,
                "ghost": name in ghosts,
                "pid": pid,
                "count": 1,
            }
            for name in nodes
        ],
        "topics": [
            {"name": f"{name}/out", "types": ["std_msgs/msg/String"], "publishers": 1}
            for name in nodes
        ],
        "services": [],
        "endpoints": [
            {"topic": f"{name}/out", "node": name, "direction": "publisher", "ghost": False}
            for name in nodes
        ],
        "mismatches": [],
    }


def row(**fields: Any) -> dict[str, Any]:
    return {"name": "a-1", "pid": 7, "state": "RUNNING", "last_exit": None, **fields}


DIED = row(pid=None, state="FATAL", last_exit={"asked": False, "returncode": -11})
STOPPED = row(pid=None, state="STOPPED", last_exit={"asked": True, "returncode": -2})


def states(state: GraphState, rows: list[dict[str, Any]], wall: float) -> dict[str, str]:
    document = state.document(rows, wall)
    assert document is not None
    return {node["name"]: node["state"] for node in document["nodes"]}


def gone_state() -> GraphState:
    state = GraphState()
    state.take(graph("/a", "/b"), [row()], 100.0)
    state.take(graph("/b"), [row()], 110.0)
    return state


def test_a_node_that_went_is_kept_with_its_endpoints_topics_and_process() -> None:
    document = gone_state().document([DIED], 111.0)
    assert document is not None
    (node,) = [one for one in document["nodes"] if one["name"] == "/a"]
    assert (node["state"], node["process"], node["since"]) == ("gone", "a-1", 110.0)
    assert "endpoints" not in node
    assert [e["ghost"] for e in document["endpoints"] if e["node"] == "/a"] == [True]
    (topic,) = [one for one in document["topics"] if one["name"] == "/a/out"]
    assert topic == {
        "name": "/a/out",
        "types": ["std_msgs/msg/String"],
        "publishers": 0,
        "subscriptions": 0,
    }


def test_a_node_whose_process_died_is_kept_for_minutes() -> None:
    state = gone_state()
    assert states(state, [DIED], 110.0 + GONE_S) == {"/b": "running", "/a": "gone"}
    assert states(state, [DIED], 111.0 + GONE_S) == {"/b": "running"}


def test_a_node_that_was_closed_or_stopped_or_is_not_ours_is_kept_shortly() -> None:
    for rows in ([row()], [STOPPED], []):
        state = gone_state()
        assert states(state, rows, 110.0 + GONE_CLEAN_S)["/a"] == "gone"
        assert "/a" not in states(state, rows, 111.0 + GONE_CLEAN_S)


def test_a_node_that_comes_back_runs_again() -> None:
    state = gone_state()
    state.take(graph("/a", "/b"), [row()], 120.0)
    assert states(state, [row()], 120.0) == {"/a": "running", "/b": "running"}


def test_a_ghost_that_vanishes_is_gone_since_it_became_one() -> None:
    state = GraphState()
    state.take(graph("/a"), [row()], 100.0)
    state.take(graph("/a", ghosts=("/a",)), [DIED], 105.0)
    assert states(state, [DIED], 106.0) == {"/a": "ghost"}
    state.take(graph(), [DIED], 115.0)
    document = state.document([DIED], 116.0)
    assert document is not None
    assert [(n["state"], n["since"]) for n in document["nodes"]] == [("gone", 105.0)]


def test_forget_removes_a_node_that_went() -> None:
    state = gone_state()
    assert state.forget("/a")
    assert not state.forget("/b")
    assert states(state, [DIED], 112.0) == {"/b": "running"}


def test_hidden_nodes_and_those_of_an_earlier_probe_do_not_stay() -> None:
    state = GraphState()
    state.take(graph("/_tool"), [], 100.0)
    state.take(graph("/a"), [], 101.0)
    state.restart()
    assert state.document([], 101.5) is None
    state.take(graph("/b"), [], 102.0)
    assert states(state, [], 102.0) == {"/b": "running"}


def test_the_process_of_a_node_is_found_by_pid_then_by_name() -> None:
    rows = [row(node_names=["/x"]), row(name="b-2", pid=8, node_names=["/y"])]
    assert process_of("/y", 7, rows) == "a-1"
    assert process_of("/y", None, rows) == "b-2"
    assert process_of("/z", 9, rows) is None


def test_endpoints_that_went_just_before_their_node_are_kept_with_it() -> None:
    state = GraphState()
    state.take(graph("/a"), [row()], 100.0)
    state.take({**graph("/a"), "endpoints": []}, [row()], 101.0)
    state.take(graph(), [DIED], 101.5)
    document = state.document([DIED], 102.0)
    assert document is not None
    assert [(one["node"], one["ghost"]) for one in document["endpoints"]] == [("/a", True)]


def test_what_is_not_shown_any_more_is_forgotten():
    state = GraphState()
    for number in range(100):
        state.take(graph("/stays", f"/short_{number}"), [STOPPED], 10.0 * number)
        state.take(graph("/stays"), [STOPPED], 10.0 * number + 5.0)
        states(state, [STOPPED], 10.0 * number + 5.0)
    sizes = [len(kept) for kept in vars(state).values() if isinstance(kept, dict | list)]
    assert max(sizes) < 10
