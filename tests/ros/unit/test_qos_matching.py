"""QoS compatibility and its explanation, without ROS."""

import pytest

from launcher.posix.ports import participants_of
from launcher.ros.draw.dot import to_dot
from launcher.ros.snapshot.qos_matching import (
    REQUESTS,
    RESPONSES,
    explain,
    mismatched_policy,
    mismatches,
    silent_subscriptions,
)
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph
from launcher.ros.topics.qos import publisher_options


def endpoint(node: str, direction: str, **changes: str) -> Endpoint:
    fields = {
        "topic": "/t",
        "type": "std_msgs/msg/String",
        "reliability": "RELIABLE",
        "durability": "VOLATILE",
    }
    return Endpoint(node=node, direction=direction, **{**fields, **changes})


@pytest.mark.parametrize(
    ("offered", "asked", "policy"),
    [
        ({}, {}, None),
        ({}, {"reliability": "BEST_EFFORT"}, None),
        ({"durability": "TRANSIENT_LOCAL"}, {}, None),
        ({"reliability": "BEST_EFFORT"}, {}, "RELIABILITY"),
        ({}, {"durability": "TRANSIENT_LOCAL"}, "DURABILITY"),
        ({}, {"type": "std_msgs/msg/Bool"}, "TYPE"),
    ],
)
def test_a_subscription_may_not_ask_for_more_than_is_offered(offered, asked, policy):
    publisher = endpoint("/a", "publisher", **offered)
    subscription = endpoint("/b", "subscription", **asked)
    assert mismatched_policy(publisher, subscription) == policy


@pytest.mark.parametrize(
    ("roles", "writer", "reader", "nothing"),
    [
        (REQUESTS, "client", "server", "no requests"),
        (RESPONSES, "server", "client", "no responses"),
    ],
)
def test_clients_and_servers_are_called_so(roles, writer, reader, nothing):
    pair = endpoint("/a", "publisher", reliability="BEST_EFFORT"), endpoint("/b", "subscription")

    assert explain(pair, roles).splitlines() == [
        f"QoS: 1 of 1 pair of {writer} and {reader} does not match",
        f"  /b receives {nothing} from /a",
        f"    RELIABILITY: the {writer} offers BEST_EFFORT, the {reader} asks for RELIABLE",
        f"    to repair: set the {reader}'s reliability to BEST_EFFORT, "
        f"or the {writer}'s to RELIABLE",
    ]


@pytest.mark.parametrize(
    ("asked", "options"),
    [
        ({}, []),
        ({"durability": "TRANSIENT_LOCAL"}, ["--qos-durability transient_local"]),
        ({"type": "std_msgs/msg/Bool"}, []),
    ],
)
def test_the_options_for_a_publisher_offer_what_the_subscription_asks_for(asked, options):
    pair = endpoint("/a", "publisher"), endpoint("/b", "subscription", **asked)
    assert publisher_options(mismatches(pair)) == options


def test_a_subscription_is_silent_only_if_no_publisher_suits_it():
    weak = endpoint("/a", "publisher", reliability="BEST_EFFORT")
    strong = endpoint("/c", "publisher")
    subscription = endpoint("/b", "subscription")
    alone = TopicGraph(nodes=("/a", "/b"), endpoints=(weak, subscription))
    both = TopicGraph(nodes=("/a", "/b", "/c"), endpoints=(weak, strong, subscription))
    assert silent_subscriptions(alone) == {subscription: "RELIABILITY"}
    assert silent_subscriptions(both) == {}


def test_the_drawing_shows_nodes_topics_and_the_edge_on_which_nothing_arrives():
    weak = endpoint("/a", "publisher", reliability="BEST_EFFORT")
    subscription = endpoint("/b", "subscription")
    dot = to_dot(TopicGraph(nodes=("/a", "/b"), endpoints=(weak, subscription)))
    assert '"node /a" -> "topic /t";' in dot
    assert '"topic /t" -> "node /b" [color="#c53030"' in dot
    assert "nothing arrives: RELIABILITY" in dot


def test_names_cannot_break_out_of_the_drawing():
    dot = to_dot(TopicGraph(nodes=('/a"];evil[',), endpoints=()))
    assert '"node /a\\"];evil["' in dot


def test_an_explanation_names_the_pairs_the_policies_and_the_repair():
    weak = [endpoint(name, "publisher", reliability="BEST_EFFORT") for name in ("/a", "/b")]
    assert explain([*weak, endpoint("/c", "subscription", durability="TRANSIENT_LOCAL")]) == (
        "QoS: 2 of 2 pairs do not match\n"
        "  /c receives nothing from /a, /b\n"
        "    RELIABILITY: the publisher offers BEST_EFFORT, the subscription asks for RELIABLE\n"
        "    to repair: set the subscription's reliability to BEST_EFFORT, "
        "or the publisher's to RELIABLE\n"
        "    DURABILITY: the publisher offers VOLATILE, "
        "the subscription asks for TRANSIENT_LOCAL\n"
        "    to repair: set the subscription's durability to VOLATILE, "
        "or the publisher's to TRANSIENT_LOCAL"
    )


def test_an_explanation_of_a_healthy_topic_says_so():
    pair = [endpoint("/a", "publisher"), endpoint("/b", "subscription")]
    assert explain(pair) == "QoS: the pair matches"
    assert explain(pair[:1]) == "QoS: no pair of publisher and subscription to compare"


def test_participants_are_found_by_pairs_of_ports():
    pair_of_domain_0 = {7410, 7411}
    two_of_domain_42 = {17910, 17911, 17914, 17915}
    multicast_and_a_stranger = {7400, 7401, 8000}
    assert participants_of(pair_of_domain_0 | two_of_domain_42 | multicast_and_a_stranger) == {
        0: 1,
        42: 2,
    }
