"""`topic list`, `topic info`, `node list` and `node info` against real nodes."""

from __future__ import annotations

import re

import pytest
from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from launcher.ros.snapshot.qos_matching import faults
from launcher.ros.snapshot.ros_graph import Endpoint
from tests.support.verbs import launcher

TOPICS = ["/chatter", "/latched", "/numbers", "/parameter_events", "/points", "/rosout", "/weak"]

WEAK_PUBLISHER = """Type: std_msgs/msg/String

Publisher count: 1

Node name: talker
Node namespace: /
Topic type: std_msgs/msg/String
Topic type hash: RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18
Endpoint type: PUBLISHER
GID: XX
QoS profile:
  Reliability: BEST_EFFORT
  History (Depth): UNKNOWN
  Durability: VOLATILE
  Lifespan: Infinite
  Deadline: Infinite
  Liveliness: AUTOMATIC
  Liveliness lease duration: Infinite

Subscription count: 1

Node name: listener
Node namespace: /site/east
Topic type: std_msgs/msg/String
Topic type hash: RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18
Endpoint type: SUBSCRIPTION
GID: XX
QoS profile:
  Reliability: RELIABLE
  History (Depth): UNKNOWN
  Durability: VOLATILE
  Lifespan: Infinite
  Deadline: Infinite
  Liveliness: AUTOMATIC
  Liveliness lease duration: Infinite

QoS: 1 of 1 pair of publisher and subscription does not match
  /site/east/listener receives nothing from /talker
    RELIABILITY: the publisher offers BEST_EFFORT, the subscription asks for RELIABLE
    to repair: set the subscription's reliability to BEST_EFFORT, or the publisher's to RELIABLE
"""

TALKER = """/talker
  Subscribers:

  Publishers:
    /chatter: std_msgs/msg/String
    /latched: std_msgs/msg/Int32
    /numbers: std_msgs/msg/Float64MultiArray
    /parameter_events: rcl_interfaces/msg/ParameterEvent
    /points: geometry_msgs/msg/PointStamped
    /rosout: rcl_interfaces/msg/Log
    /weak: std_msgs/msg/String
  Service Servers:
    /occupy: std_srvs/srv/Trigger
    /switch: std_srvs/srv/SetBool
    /talker/describe_parameters: rcl_interfaces/srv/DescribeParameters
    /talker/get_parameter_types: rcl_interfaces/srv/GetParameterTypes
    /talker/get_parameters: rcl_interfaces/srv/GetParameters
    /talker/get_type_description: type_description_interfaces/srv/GetTypeDescription
    /talker/list_parameters: rcl_interfaces/srv/ListParameters
    /talker/set_parameters: rcl_interfaces/srv/SetParameters
    /talker/set_parameters_atomically: rcl_interfaces/srv/SetParametersAtomically
  Service Clients:

  Action Servers:

  Action Clients:

"""


def test_the_list_has_every_topic_and_nothing_hidden(verb):
    answer = verb("topic", "list")
    assert (answer.lines, answer.err, answer.code) == (TOPICS, "", 0)


def test_hidden_topics_come_when_asked_for(verb):
    assert verb("topic", "list", "--include-hidden-topics").lines == ["/_secret", *TOPICS]


def test_the_list_with_types_and_the_count(verb):
    typed = verb("topic", "list", "-t").lines
    assert typed[0] == "/chatter [std_msgs/msg/String]"
    assert verb("topic", "list", "-t", "-c").out == f"{len(TOPICS)}\n"


def test_the_verbose_list_counts_users_by_direction(verb):
    published, subscribed = verb("topic", "list", "-v").out.split("\n\n", 1)
    assert published.splitlines()[:2] == [
        "Published topics:",
        " * /chatter [std_msgs/msg/String] 1 publisher",
    ]
    assert " * /parameter_events [rcl_interfaces/msg/ParameterEvent] 5 publishers" in published
    assert subscribed == (
        "Subscribed topics:\n"
        " * /chatter [std_msgs/msg/String] 1 subscriber\n"
        " * /weak [std_msgs/msg/String] 1 subscriber\n\n"
    )


def test_an_empty_domain_says_why_and_where_to_look(empty_domain, env):
    answer = launcher(empty_domain, "topic", "list")
    assert answer.lines == ["/parameter_events", "/rosout"]
    assert f"0 nodes on domain {empty_domain['ROS_DOMAIN_ID']} (localhost only); " in answer.err
    assert re.search(r"active: add --domain \d+$", answer.err.strip())
    elsewhere = ("-d", env["ROS_DOMAIN_ID"], "--spin-time", "60")
    there = launcher(empty_domain, "node", "list", *elsewhere)
    assert "/talker" in there.lines


def test_info_in_brief(verb):
    assert verb("topic", "info", "/chatter").out == (
        "Type: std_msgs/msg/String\nPublisher count: 1\nSubscription count: 1\n"
    )


def test_verbose_info_ends_with_the_mismatch_in_words(verb):
    answer = verb("topic", "info", "/weak", "-v")
    assert re.sub(r"GID: [0-9a-f.]{47}", "GID: XX", answer.out) == WEAK_PUBLISHER


def test_the_explanation_can_be_asked_for_alone(verb):
    assert verb("topic", "info", "/chatter", "--explain").lines[-1] == "QoS: the pair matches"


def test_info_as_json_names_both_sides_and_the_repair(verb):
    document = verb("topic", "info", "/weak", "--json").json()
    assert [e["node"] for e in document["endpoints"]] == ["/talker", "/site/east/listener"]
    assert document["mismatches"][0]["policies"][0]["policy"] == "RELIABILITY"


@pytest.mark.parametrize("name", ["chater", "/chater"])
def test_an_unknown_topic_is_an_error_that_knows_the_near_miss(verb, name):
    answer = verb("topic", "info", name)
    assert (answer.out, answer.code) == ("", 1)
    assert answer.err == "Unknown topic '/chater'\nhint: did you mean '/chatter'?\n"


def test_nodes_are_listed_and_a_shared_name_is_warned_about(verb):
    answer = verb("node", "list")
    assert answer.lines == ["/site/east/listener", "/talker", "/twin", "/twin"]
    assert answer.err.startswith("WARNING: Be aware that there are nodes in the graph that share")


def test_hidden_nodes_and_the_count(verb):
    assert verb("node", "list", "-a").lines[0] == "/_shy"
    counted = verb("node", "list", "-c")
    assert (counted.out, counted.err) == ("4\n", "")


def test_node_info_as_ros2_prints_it(verb):
    assert verb("node", "info", "/talker").out == TALKER


def test_node_info_of_a_shared_name_says_so(verb):
    err = verb("node", "info", "/twin").err
    assert err.startswith('There are 2 nodes in the graph with the exact name "/twin".')


def test_an_unknown_node_is_an_error(verb):
    answer = verb("node", "info", "tolker")
    assert (answer.out, answer.code) == ("", 1)
    assert answer.err == "Unable to find node '/tolker'\nhint: did you mean '/talker'?\n"


@pytest.mark.parametrize(
    "line",
    [
        "node info talker",
        "topic info -v chatter",
        "topic type chatter",
        "service type switch",
        "service info switch",
        "param list talker",
        "param dump talker",
    ],
)
def test_a_name_may_lack_its_slash(verb, line):
    *words, name = line.split()
    relative, absolute = verb(*words, name), verb(*words, f"/{name}")
    assert (relative.out, relative.code) == (absolute.out, 0)


def test_a_bad_command_line_says_what_to_type(verb):
    answer = verb("topic", "lsit")
    assert answer.code == 2
    assert "hint: did you mean 'list'?" in answer.err


@pytest.mark.parametrize("word", ["abc", "233", "-1"])
def test_an_invalid_domain_is_an_error(verb, word):
    answer = verb("node", "list", f"--domain={word}")
    assert answer.code == 2
    assert "a domain is a number from 0 to 232" in answer.err


SECOND_NS = 10**9
VALUES = [
    {"reliability": reliability, "durability": durability, "liveliness": liveliness, **times}
    for reliability in ("BEST_EFFORT", "RELIABLE")
    for durability in ("VOLATILE", "TRANSIENT_LOCAL")
    for liveliness in ("AUTOMATIC", "MANUAL_BY_TOPIC")
    for times in (
        {},
        {"deadline_ns": SECOND_NS},
        {"deadline_ns": 2 * SECOND_NS, "lease_ns": SECOND_NS},
    )
]


def test_qos_compatibility_agrees_with_the_middleware():
    def endpoint(direction, values):
        return Endpoint(topic="/t", node="/n", type="T", direction=direction, **values)

    def profile(values):
        return QoSProfile(
            depth=1,
            reliability=ReliabilityPolicy[values["reliability"]],
            durability=DurabilityPolicy[values["durability"]],
            liveliness=LivelinessPolicy[values["liveliness"]],
            **{
                name: Duration(nanoseconds=values[key])
                for key, name in (
                    ("deadline_ns", "deadline"),
                    ("lease_ns", "liveliness_lease_duration"),
                )
                if key in values
            },
        )

    for offered in VALUES:
        for asked in VALUES:
            verdict, reason = qos_check_compatible(profile(offered), profile(asked))
            ours = faults(endpoint("publisher", offered), endpoint("subscription", asked))
            assert (verdict == QoSCompatibility.ERROR) == bool(ours), (offered, asked, reason)
