"""Drawings of a graph as tree, dot, mermaid and page, without ROS."""

from __future__ import annotations

import json
import os
import re

import psutil
import pytest

from launcher.base.errors import UsageError
from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.gids import ghosts, pid_low16, scheme_holds
from launcher.ros.discovery.reannounce import disposal, silent_ports
from launcher.ros.draw.dot import to_dot, to_html
from launcher.ros.draw.filter import Filter, Mode
from launcher.ros.draw.graph_text import to_tree
from launcher.ros.draw.mermaid import to_mermaid
from launcher.ros.node_tables import vitals
from launcher.ros.snapshot.diff import difference, load, to_document
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph


def end(node: str, direction: str, topic: str = "/t", reliability: str = "RELIABLE") -> Endpoint:
    return Endpoint(
        topic=topic,
        node=node,
        direction=direction,
        type="T",
        reliability=reliability,
        durability="VOLATILE",
    )


GRAPH = TopicGraph(
    nodes=("/a", "/b", "/ns/c", "/twin", "/twin"),
    endpoints=(
        end("/a", "publisher"),
        end("/b", "subscription"),
        end("/a", "publisher", "/weak", "BEST_EFFORT"),
        end("/ns/c", "subscription", "/weak"),
        end("/a", "publisher", "/alone"),
        end("/a", "publisher", "/rosout"),
        end("/a", "publisher", "/_hidden"),
    ),
    ghosts=("/b",),
)


def test_debug_and_hidden_topics_are_left_out_unless_asked_for():
    assert Filter().apply(GRAPH).topics() == ("/alone", "/t", "/weak")
    everything = Filter(debug=True, hidden=True).apply(GRAPH)
    assert everything.topics() == ("/_hidden", "/alone", "/rosout", "/t", "/weak")


def test_the_active_mode_leaves_out_topics_with_one_side():
    assert Filter(mode=Mode.ACTIVE).apply(GRAPH).topics() == ("/t", "/weak")


def test_names_can_be_included_with_their_neighbours_and_excluded():
    included = Filter(include="weak").apply(GRAPH)
    assert (included.nodes, included.topics()) == (("/a", "/ns/c"), ("/weak",))
    assert Filter(exclude="^/ns").apply(GRAPH).nodes == ("/a", "/b", "/twin", "/twin")


def test_a_bad_pattern_is_a_usage_error():
    with pytest.raises(UsageError, match="invalid regular expression"):
        Filter(include="[").check()


def test_the_tree_shows_connections_and_edges_on_which_nothing_arrives():
    assert to_tree(Filter(exclude="alone").apply(GRAPH)) == (
        "/a\n"
        "├─ -> /t [T] -> /b\n"
        "└─ -> /weak [T] -> /ns/c (nothing arrives: RELIABILITY)\n"
        "/b  GHOST: its process is gone\n"
        "└─ <- /t [T] <- /a\n"
        "/ns/c\n"
        "└─ <- /weak [T] <- /a (nothing arrives: RELIABILITY)\n"
        "/twin  (2 nodes of this name)\n"
        "5 nodes, 2 topics, 1 connection on which nothing arrives, 1 ghost\n"
    )


def test_the_tree_of_nodes_names_the_topics_between_them():
    assert "├─ -> /b by /t\n" in to_tree(Filter(mode=Mode.NODES).apply(GRAPH), Mode.NODES)


def test_dot_has_clusters_ellipses_boxes_and_red_ghosts():
    dot = to_dot(Filter().apply(GRAPH))
    assert 'subgraph "cluster /ns" {' in dot
    assert re.search(r'"node /b" \[label="/b\\nghost: .* color="#c53030"', dot)
    assert 'label="/twin\\n2 nodes of this name" shape=ellipse' in dot
    assert '"topic /t" [label="/t\\nT" shape=box' in dot


def test_dot_of_nodes_alone_labels_the_edges_with_topics():
    dot = to_dot(Filter(mode=Mode.NODES).apply(GRAPH), Mode.NODES)
    assert '"node /a" -> "node /b" [label="/t"];' in dot
    assert 'label="/weak\\nnothing arrives: RELIABILITY"' in dot
    assert "shape=box" not in dot


def test_mermaid_marks_the_edge_on_which_nothing_arrives():
    lines = to_mermaid(Filter(mode=Mode.ACTIVE).apply(GRAPH)).splitlines()
    edges = [line for line in lines if re.match(r"  [nt]\d+ -", line)]
    red = next(index for index, line in enumerate(edges) if "nothing arrives" in line)
    assert lines[0] == "flowchart LR"
    assert f"  linkStyle {red} stroke:#c53030,color:#c53030" in lines
    assert '  n0(["/a"])' in lines


def test_a_saved_graph_comes_back_as_it_was(tmp_path):
    path = tmp_path / "graph.json"
    path.write_text(json.dumps(to_document(GRAPH)), encoding="utf-8")
    again = load(str(path))
    assert difference(GRAPH, again) == []
    assert again.ghosts == GRAPH.ghosts


def test_the_difference_names_what_came_and_went():
    after = TopicGraph(
        nodes=("/a", "/b", "/ns/c", "/new", "/twin"),
        endpoints=GRAPH.endpoints[1:],
        ghosts=("/b",),
    )
    assert difference(GRAPH, after) == [
        "- /a publishes /t [T] RELIABLE VOLATILE AUTOMATIC",
        "+ node /new",
        "- node /twin",
    ]


@pytest.mark.parametrize("text", ["", "[]", '{"nodes": []}', '{"nodes": 5, "endpoints": []}'])
def test_a_file_that_is_no_graph_is_an_error(tmp_path, text):
    path = tmp_path / "graph.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(VerbError, match="is not a saved graph"):
        load(str(path))


def test_a_missing_file_is_an_error():
    with pytest.raises(VerbError, match="No such file"):
        load("/nonexistent/graph.json")


def test_the_page_carries_everything_and_escapes_its_title():
    page = to_html('<?xml?>\n<svg viewBox="0 0 1 1"></svg>', title="<x>", caption="1 & 2")
    assert "&lt;x&gt;" in page
    assert "1 &amp; 2" in page
    assert not re.search(r"(src|href)=|https?://|@import", page)


OWN = bytes([1, 15, 7, 7]) + (os.getpid() & 0xFFFF).to_bytes(2, "little") + bytes(10)


def test_a_gid_of_fast_dds_contains_the_process_id():
    assert scheme_holds(OWN, os.getpid())
    assert pid_low16(b"\x01\x10" + bytes(14)) is None


def test_a_ghost_is_of_this_host_and_of_no_running_process():
    living = {pid & 0xFFFF for pid in psutil.pids()}
    dead = next(low for low in range(1, 65536) if low not in living)
    ghost = OWN[:4] + dead.to_bytes(2, "little") + bytes(10)
    elsewhere = bytes([1, 15, 8, 8]) + ghost[4:]
    assert ghosts({OWN, ghost, elsewhere}, OWN, os.getpid()) == {ghost}
    assert ghosts({ghost}, bytes(16), os.getpid()) == set()  # the scheme does not hold


def test_ports_of_participants_that_were_not_discovered_are_silent():
    first, third = (OWN[:8] + number.to_bytes(4, "little") for number in (0, 2))
    owned = {os.getpid(): [7410, 7412, 7414], os.getpid() + 1: [7416]}
    assert silent_ports(owned, {first, third}) == {7412, 7416}


def test_an_announcement_is_taken_back_as_a_participant_does_at_its_end():
    message = disposal(OWN[:12])
    assert message[:20] == b"RTPS\x02\x03\x01\x0f" + OWN[:12]
    assert message[20:22] == b"\x15\x03"  # DATA, little endian, with inline QoS and no payload
    assert int.from_bytes(message[22:24], "little") == len(message) - 24
    assert OWN[:12] + bytes.fromhex("000001c1") in message  # the key: who is gone
    assert bytes.fromhex("7100040000000003") in message  # disposed and unregistered


def test_the_vitals_of_this_process_make_sense():
    found = vitals(os.getpid())
    assert found is not None
    assert found.status in ("running", "sleeping", "disk-sleep")
    assert found.uss_bytes is not None and found.uss_bytes > 1_000_000
    assert 0 < found.cpu_s < found.uptime_s * (os.cpu_count() or 1) + 1
    assert found.program


def test_a_topic_below_a_namespace_with_nodes_is_in_its_box():
    topic = Endpoint(
        topic="/ns/costmap/footprint",
        node="/ns/planner",
        direction="publisher",
        type="T",
        reliability="RELIABLE",
        durability="VOLATILE",
    )
    dot = to_dot(TopicGraph(nodes=("/ns/planner",), endpoints=(topic,)))
    box = dot[dot.index('subgraph "cluster /ns" {') : dot.index("  }")]
    assert '"topic /ns/costmap/footprint"' in box
