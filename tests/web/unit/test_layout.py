"""Positions of nodes and topics: they stay put, and nothing lies on something else."""

from __future__ import annotations

from typing import Any

from launcher.web.layout import SETTLE_S, Layout, render, source
from tests.support.drawing import CAN_DRAW


def graph(edges: dict[str, tuple[str, ...]], alone: tuple[str, ...] = ()) -> dict[str, Any]:
    """`edges`: topic -> its publisher, then its subscribers."""
    nodes = dict.fromkeys([*(name for ends in edges.values() for name in ends), *alone])
    return {
        "nodes": [{"name": name, "hidden": False} for name in nodes],
        "topics": [{"name": name} for name in edges],
        "endpoints": [
            {
                "topic": topic,
                "node": node,
                "direction": "subscription" if index else "publisher",
            }
            for topic, ends in edges.items()
            for index, node in enumerate(ends)
        ],
    }


def drawn(document: dict[str, Any]) -> str:
    """What Graphviz makes of it; where it cannot be installed, a row of all elements."""
    plain = render(source(document))
    assert (plain is not None) is CAN_DRAW
    count = len(document["nodes"]) + len(document["topics"])
    row = [f"node n{i} {3 * i} 1 2 0.5" for i in range(count)]
    return plain or "\n".join([f"graph 1 {3 * count} 2", *row])


def arranged(document: dict[str, Any]) -> Layout:
    layout = Layout()
    layout.take(document, drawn(document))
    return layout


def test_data_flows_from_left_to_right() -> None:
    at = arranged(graph({"/t": ("/a", "/b")})).positions()
    if CAN_DRAW:
        assert at["nodes"]["/a"][0] < at["topics"]["/t"][0] < at["nodes"]["/b"][0]


def test_hostile_names_are_no_source() -> None:
    name = '/"]; x -> y; "<b>\\'
    at = arranged(graph({name: ("/a\nb", "/c")})).positions()
    assert set(at["topics"]) == {name}
    assert set(at["nodes"]) == {"/a\nb", "/c"}


def test_a_new_node_is_put_beside_its_neighbours_and_nothing_moves() -> None:
    layout = arranged(graph({"/t": ("/a", "/b")}))
    before = layout.positions()
    layout.place(graph({"/t": ("/a", "/b", "/c"), "/u": ("/c",), "/rosout": ("/a",)}))
    after = layout.positions()
    assert {name: after["nodes"][name] for name in before["nodes"]} == before["nodes"]
    assert after["topics"]["/t"] == before["topics"]["/t"]
    assert after["topics"]["/t"][0] < after["nodes"]["/c"][0] < after["topics"]["/u"][0]
    assert after["nodes"]["/c"][1] != after["nodes"]["/b"][1]


def test_a_node_that_returns_has_its_old_place() -> None:
    layout = arranged(graph({"/t": ("/a", "/b"), "/u": ("/c", "/b")}))
    before = layout.positions()["nodes"]["/c"]
    layout.place(graph({"/t": ("/a", "/b")}))
    layout.place(graph({"/t": ("/a", "/b"), "/u": ("/c", "/b")}))
    assert layout.positions()["nodes"]["/c"] == before


def test_elements_without_neighbours_do_not_cover_each_other() -> None:
    layout = arranged(graph({"/t": ("/a", "/b")}))
    layout.place(graph({"/t": ("/a", "/b")}, alone=tuple(f"/alone_{i}" for i in range(7))))
    places = list(map(tuple, layout.positions()["nodes"].values()))
    assert len(set(places)) == len(places) == 9


def test_arranged_at_the_start_and_when_much_was_added() -> None:
    first = graph({"/t": ("/a", "/b")})
    layout = Layout()
    assert layout.wants_arrangement(first, 10.0)
    layout.take(first, drawn(first))
    more = graph({"/t": ("/a", "/b", "/c")})
    assert not layout.wants_arrangement(first, 11.0)
    assert layout.wants_arrangement(more, 11.0)
    assert not layout.wants_arrangement(more, 10.0 + SETTLE_S)
    layout.place(more)
    crowd = graph({f"/t{i}": ("/a", f"/n{i}") for i in range(8)})
    assert layout.wants_arrangement(crowd, 10.0 + SETTLE_S)


def test_a_long_chain_is_no_strip() -> None:
    chain = {f"/t{i}": (f"/n{i}", f"/n{i + 1}") for i in range(60)}
    at = arranged(graph(chain)).positions()
    xs, ys = zip(*[*at["nodes"].values(), *at["topics"].values()], strict=True)
    if CAN_DRAW:
        assert 1 / 6 < (max(xs) - min(xs)) / (max(ys) - min(ys)) < 6


def test_arranged_when_most_have_gone() -> None:
    crowd = graph({f"/t{i}": (f"/n{i}", f"/n{i + 1}") for i in range(20)})
    layout = arranged(crowd)
    assert not layout.wants_arrangement(
        graph({f"/t{i}": ("/n0", f"/n{i}") for i in range(8)}), 99.0
    )
    assert layout.wants_arrangement(graph({"/t0": ("/n0", "/n1")}), 99.0)
