"""Judges of expectations about ROS, on made-up facts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from launcher.smoke.expect.expectation import Decision
from launcher.smoke.expect.expectation_kinds import KINDS
from launcher.smoke.observe.facts import GraphSeen, ObservedMessage, QueryAnswer
from tests.smoke.unit.cases import STEPS, Case, answers, graphs
from tests.smoke.unit.facts import (
    ended,
    expectation,
    graph,
    lines,
    publisher,
    samples,
    started,
    subscription,
    texts,
    ticks,
    verdict,
)


def doubled(*nodes: str) -> GraphSeen:
    """A graph in which a name may be there twice."""
    one = graph(nodes=nodes)
    return replace(one, snapshot=replace(one.snapshot, nodes=nodes))


def late(topic: str, *delays: float, stamped: bool = False) -> tuple[ObservedMessage, ...]:
    """Messages half a second apart, that are so late."""
    found = texts(topic, *range(len(delays)), period_s=0.5)
    return tuple(
        replace(m, **{"stamp_s" if stamped else "sent_s": m.at_s - delay_s})
        for m, delay_s in zip(found, delays, strict=True)
    )


PAIR = (publisher("/t"), subscription("/t"))
WEAK = publisher("/t", reliability="BEST_EFFORT")
CASES = {
    "node": Case(
        "node: /robot_1",
        graphs(graph(nodes=("/robot_1",))),
        graphs(graph(nodes=("/robot_2",)), graph(nodes=("/robot_1",), at_s=11)),
        "never; known nodes: /robot_1",
    ),
    "node by pattern": Case(
        "node: '*/robot_?'",
        graphs(graph(nodes=("/site/robot_1",))),
        graphs(graph(nodes=("/robot",))),
        "never; known nodes: /robot",
    ),
    "node whose process is gone": Case(
        "node: /robot_1, after: kill, within: 3 s",
        {**graphs(graph(nodes=("/robot_1",), at_s=6)), **STEPS},
        {**graphs(graph(nodes=("/robot_1",), ghosts=("/robot_1",), at_s=4)), **STEPS},
        "never",
    ),
    "node absent": Case(
        "node: /robot_1, absent: true, after: kill, within: 3 s",
        {**graphs(graph(nodes=("/robot_1",)), graph(at_s=6)), **STEPS},
        {**graphs(graph(nodes=("/robot_1",))), **STEPS},
        "it stayed in the graph",
    ),
    "node too early": Case(
        "node: /robot_3, within: 5 to 8 s",
        graphs(graph(nodes=("/robot_3",), at_s=6)),
        graphs(graph(nodes=("/robot_3",), at_s=4)),
        "too early, after 4.0 s",
    ),
    "node never there": Case(
        "node: /robot_3, absent: true",
        graphs(graph(nodes=("/robot_1",))),
        graphs(graph(nodes=("/robot_3",)), graph(at_s=3)),
        "it was there after 2.0 s",
    ),
    "node that is there once": Case(
        "node: /robot_1, count: 1",
        graphs(doubled("/robot_1", "/robot_2")),
        graphs(doubled("/robot_1", "/robot_1")),
        "2 of them; known nodes: /robot_1",
    ),
    "node of a dead process": Case(
        "node: /robot_1",
        graphs(graph(nodes=("/robot_1",))),
        {
            "events": (*started("robot_1-1"), ended("robot_1-1", 1, 0.5)),
            "lines": lines("Traceback (most recent call last):", "ValueError: no such dock"),
            **graphs(),
        },
        "never",
        "its process robot_1-1 ended at 0.5 s (exit code 1); it raised ValueError: no such dock",
    ),
    "topic": Case(
        "topic: /t, type: std_msgs/msg/String, publishers: 1, subscriptions: '>= 1'",
        graphs(graph(*PAIR)),
        graphs(graph(publisher("/t"))),
        "0 subscriptions: none",
    ),
    "topic of a type": Case(
        "topic: /t, type: std_msgs/msg/String",
        graphs(graph(publisher("/t"))),
        graphs(graph(publisher("/t", type="std_msgs/msg/Int32"))),
        "its type is std_msgs/msg/Int32",
        "the topic has another type: /talker uses std_msgs/msg/Int32",
    ),
    "topic elsewhere": Case(
        "topic: /fleet/tasks",
        graphs(graph(publisher("/fleet/tasks"))),
        graphs(graph(publisher("/tasks"))),
        "no topic /fleet/tasks",
        "there is a topic of that name elsewhere: /tasks",
    ),
    "qos of publishers": Case(
        "qos: /t, publishers: {reliability: reliable, durability: volatile}",
        graphs(graph(*PAIR)),
        graphs(graph(WEAK, subscription("/t"))),
        "/talker has reliability BEST_EFFORT",
        "receives nothing from /talker: reliability is BEST_EFFORT, but RELIABLE is requested",
    ),
    "deadline of publishers": Case(
        "qos: /t, publishers: {deadline: 2 s}",
        graphs(graph(publisher("/t", deadline_ns=2_000_000_000))),
        graphs(graph(publisher("/t"))),
        "/talker has deadline INFINITE",
    ),
    "qos of one node": Case(
        "qos: /t, node: /probe, subscriptions: {reliability: reliable}",
        graphs(graph(subscription("/t", "/probe"), subscription("/t", "/x", reliability="B"))),
        graphs(graph(subscription("/t", "/x"))),
        "it has no subscriptions there",
    ),
    "pairs match": Case(
        "qos: /t, compatible: true",
        graphs(graph(*PAIR)),
        graphs(graph(WEAK, subscription("/t"))),
        "/listener receives nothing from /talker",
    ),
    "a pair does not match": Case(
        "qos: /t, compatible: false",
        graphs(graph(WEAK, subscription("/t"))),
        graphs(graph(*PAIR)),
        "all pairs match",
    ),
    "rate": Case(
        "rate: /t, is: 1 Hz ± 20 %",
        {"messages": ticks("/t", 1.0)},
        {"messages": ticks("/t", 1.5)},
        "0.667 Hz (13 messages in 18.0 s)",
    ),
    "gap": Case(
        "gap: /t, below: 1.5 s",
        {"messages": ticks("/t", 1.0)},
        {"messages": (*ticks("/t", 1.0, to_s=5), *ticks("/t", 1.0, from_s=7))},
        "2.0 s from 5.0 s of the run (18 messages)",
    ),
    "gap at the end": Case(
        "gap: /t, below: 3 s",
        {"messages": ticks("/t", 1.0, to_s=18)},
        {"messages": ticks("/t", 1.0, to_s=16), **graphs(graph(publisher("/t")), graph(at_s=17))},
        "silent since 16.0 s of the run, for 4.0 s (15 messages)",
        "/talker published it and does not any more",
    ),
    "gap after a step": Case(
        "gap: /t, below: 3 s, after: kill, within: 10 s",
        {"messages": ticks("/t", 1.0), **STEPS},
        {"messages": ticks("/t", 1.0, from_s=9), **STEPS},
        "4.0 s from 5.0 s of the run (7 messages)",
    ),
    "gap of nothing": Case(
        "gap: /t, below: 3 s",
        {"messages": ticks("/t", 1.0)},
        {},
        "no message",
        "it has no publisher",
    ),
    "latency": Case(
        "latency: /t, below: 50 ms",
        {"messages": late("/t", *[0.04] * 19, 0.5)},
        {"messages": late("/t", *[0.04] * 18, 0.5, 0.4)},
        "400 ms in 95 % of 20 messages",
    ),
    "latency of stamps": Case(
        "latency: /t, below: 500 ms",
        {"messages": late("/t", *[0.4] * 3, stamped=True)},
        {"messages": late("/t", *[9e8] * 3, stamped=True)},
        "in 95 % of 3 messages",
        "simulated time?",
    ),
    "latency of few messages": Case(
        "latency: /t, below: 50 ms",
        {"messages": late("/t", 0.04, 0.04, 0.04)},
        {"messages": late("/t", 0.04, 0.04)},
        "2 messages are too few for a latency",
    ),
    "rate of a drifting timer": Case(
        "rate: /t, is: 1 Hz ± 3 %",
        {"messages": ticks("/t", 1.02)},
        {"messages": ticks("/t", 1.05)},
        "0.952 Hz",
    ),
    "rate that stops": Case(
        "rate: /t, is: 1 Hz ± 20 %",
        {"messages": ticks("/t", 1.0)},
        {"messages": ticks("/t", 1.0, to_s=10.0)},
        "0.444 Hz (9 messages in 18.0 s)",
    ),
    "rate that begins late": Case(
        "rate: /t, is: 1 Hz ± 20 %, after: kill, within: 10 s",
        {"messages": ticks("/t", 1.0), **STEPS},
        {"messages": ticks("/t", 1.0, from_s=11.0), **STEPS},
        "0.4 Hz",
    ),
    "rate of some messages": Case(
        "rate: /t, is: 0.5 Hz, where: json % 2 == 0",
        {"messages": ticks("/t", 1.0)},
        {"messages": ticks("/t", 2.0)},
        "0.25 Hz",
    ),
    "rate of silence": Case(
        "rate: /t, is: 1 Hz",
        {"messages": ticks("/t", 1.0)},
        {**graphs(graph(publisher("/t"))), "messages": ()},
        "0 messages are too few",
        "/talker has a publisher, but it published nothing",
    ),
    "rate of a busy process": Case(
        "rate: /t, is: 10 Hz",
        {"messages": ticks("/t", 0.1)},
        {
            "messages": ticks("/t", 0.2),
            "samples": samples("talker-1", (99, 10), (100, 10)),
            "events": started("talker-1"),
            **graphs(graph(publisher("/t"))),
        },
        "5 Hz",
        "talker-1 was busy: 100 % of a core on average",
    ),
    "rate of messages for which the condition fails": Case(
        "rate: /t, is: 10 Hz, where: 1 / float(m.data) > 0",
        {"messages": ticks("/t", 0.1)[1:]},
        {"messages": tuple(replace(one, content={"data": 0}) for one in ticks("/t", 0.1))},
        "do not match (ZeroDivisionError: ",
    ),
    "message": Case(
        "message: /t, where: \"json['a'] == 1 and json.b > 2\", within: 5 s",
        {"messages": texts("/t", {"a": 0}, {"a": 1, "b": 3})},
        {"messages": texts("/t", {"a": 1, "b": 2})},
        "0 of 1 messages match; the last one was",
    ),
    "message that came too late": Case(
        "message: /t, within: 5 s",
        {"messages": texts("/t", 1)},
        {"messages": texts("/t", 1, at_s=6.0)},
        "no message",
    ),
    "message that came too early": Case(
        "message: /t, fields: {n: 1}, within: 5 to 8 s",
        {"messages": texts("/t", {"n": 0}, {"n": 1}, at_s=4.5)},
        {"messages": texts("/t", {"n": 1}, {"n": 1}, at_s=4.5)},
        "too early, after 4.5 s",
    ),
    "fields of a message": Case(
        "message: /t, fields: {status: [busy, done], n: {min: 1, max: 2}, task: {matches: ^pick}}",
        {"messages": texts("/t", {"status": "done", "n": 1, "task": "pick_1"})},
        {"messages": texts("/t", {"status": "done", "n": 3, "task": "pick_1"})},
        "n is 3",
    ),
    "number of messages": Case(
        "message: /t, count: 2 to 3",
        {"messages": texts("/t", 1, 2, 3)},
        {"messages": texts("/t", 1, 2, 3, 4)},
        "4, one too many after 5.0 s: 4",
    ),
    "too few messages": Case(
        "message: /t, count: '>= 2'",
        {"messages": texts("/t", 1, 2)},
        {"messages": texts("/t", 1)},
        "1 of 1 messages match",
    ),
    "no message": Case(
        "message: /t, count: 0",
        {"messages": ()},
        {"messages": texts("/t", 1)},
        "one too many after 2.0 s: 1",
    ),
    "every message": Case(
        "message: /t, all: true, where: 'json.n > 0'",
        {"messages": texts("/t", {"n": 1}, {"n": 2})},
        {"messages": texts("/t", {"n": 1}, {"n": 0})},
        'message 2 after 3.0 s: {"n": 0}',
    ),
    "every message of none": Case(
        "message: /t, all: true, where: m.data",
        {"messages": texts("/t", 1)},
        {**graphs(), "messages": ()},
        "no message",
        "it has no publisher",
    ),
    "a broken expression": Case(
        "message: /t, where: 'json.n.x'",
        {"messages": texts("/t", {"n": {"x": True}})},
        {"messages": texts("/t", {"n": {}})},
        "AttributeError: unknown field 'x'",
    ),
    "unique": Case(
        "unique: /t, key: id",
        {"messages": texts("/t", {"id": "a-1"}, {"id": "a-2"})},
        {"messages": texts("/t", {"id": "a-1"}, {"id": "a-2"}, {"id": "a-1"})},
        '"a-1" was there after 2.0 s, and again after 4.0 s: {"id": "a-1"}',
    ),
    "unique pairs of some messages": Case(
        "unique: /t, key: [id, n], where: json.is_new",
        {
            "messages": texts(
                "/t", *({"id": 1, "n": n, "is_new": new} for n, new in ((1, 1), (2, 1), (1, 0)))
            )
        },
        {"messages": texts("/t", *[{"id": 1, "n": {"x": 1}, "is_new": True}] * 2)},
        '1, {"x": 1} was there after 2.0 s, and again',
    ),
    "unique without its field": Case(
        "unique: /t, key: id",
        {"messages": texts("/t", {"id": 1})},
        {"messages": texts("/t", {"idd": 1})},
        "unknown field 'id'; known: data, idd",
    ),
    "unique messages of none": Case(
        "unique: /t, key: id",
        {"messages": texts("/t", {"id": 1})},
        {**graphs(), "messages": ()},
        "no message",
        "it has no publisher",
    ),
    "refers": Case(
        "refers: /t, to: /tasks, key: id, where: json.id",
        {"messages": (*texts("/tasks", {"id": 1}), *texts("/t", {"id": 1}, {"id": 0}))},
        {"messages": (*texts("/tasks", {"id": 1}), *texts("/t", {"id": 1}, {"id": 2}))},
        '2 was not on /tasks before, but after 3.0 s: {"id": 2}',
    ),
    "refers to what comes later": Case(
        "refers: /t, to: /tasks, key: id",
        {"messages": (*texts("/tasks", {"id": 1}, at_s=2.5), *texts("/t", {"id": 1}))},
        {"messages": (*texts("/tasks", {"id": 1}, at_s=3.5), *texts("/t", {"id": 1}))},
        "1 was not on /tasks before, but after 2.0 s",
    ),
    "tally": Case(
        "tally: /t, in: /report, number: '(\\d+) tasks', key: id, where: json.id",
        {
            "messages": (
                *texts("/t", {"id": 1}, {"id": 1}, {"id": 2}, {"id": 0}, period_s=2),
                *texts("/report", "1 tasks", "1 tasks", "2 tasks", at_s=3, period_s=2),
            )
        },
        {
            "messages": (
                *texts("/t", {"id": 1}, {"id": 2}, period_s=4),
                *texts("/report", "1 tasks", "2 tasks", at_s=3),
            )
        },
        '2 instead of 1 after 4.0 s: "2 tasks"',
    ),
    "tally with a lag": Case(
        "tally: /t, in: /report, number: 'n: (\\d+)', key: id, lag: 3 s",
        {"messages": (*texts("/t", {"id": 1}), *texts("/report", "n: 0", at_s=4))},
        {"messages": (*texts("/t", {"id": 1}), *texts("/report", "n: 0", at_s=6))},
        "0 instead of 1",
    ),
    "tally of lists": Case(
        "tally: /t, in: /report, number: 'n: (\\d+)', key: done, after: kill",
        {
            "messages": (
                *texts("/t", {"done": []}, {"done": [1, 2]}),
                *texts("/report", "n: 2", at_s=6),
            )
        }
        | STEPS,
        {
            "messages": (
                *texts("/t", {"done": [1]}, {"done": [1]}),
                *texts("/report", "n: 2", at_s=6),
            )
        }
        | STEPS,
        "2 instead of 1",
    ),
    "tally without a number": Case(
        "tally: /t, in: /report, number: 'n: (\\d+)', key: id",
        {"messages": (*texts("/t", {"id": 1}), *texts("/report", "n: 1", at_s=4))},
        {"messages": (*texts("/t", {"id": 1}), *texts("/report", "m: 1", at_s=4))},
        'no number after 4.0 s: "m: 1"',
    ),
    "message with another quality": Case(
        "message: /t, qos: {reliability: reliable}",
        {"messages": texts("/t", 1)},
        {**graphs(graph(WEAK)), "messages": ()},
        "no message",
        "reliability is BEST_EFFORT, while the expectation requests RELIABLE",
    ),
    "parameter": Case(
        "name: p, parameter: speed, node: /talker, is: 1.5",
        answers("parameter p", QueryAnswer(at_s=3, value=1.0), QueryAnswer(at_s=4, value=1.5)),
        answers("parameter p", QueryAnswer(at_s=3, value=1.0)),
        "the answer was 1.0",
    ),
    "parameter within limits": Case(
        "name: p, parameter: speed, node: /talker, is: {min: 1}",
        answers("parameter p", QueryAnswer(at_s=3, value=1.5)),
        answers("parameter p", QueryAnswer(at_s=3, error="no node /talker")),
        "no node /talker",
    ),
    "service": Case(
        "name: s, service: /switch, fields: {success: true}",
        answers("service s", QueryAnswer(at_s=3, value={"success": True})),
        answers("service s", QueryAnswer(at_s=3, value={"success": False})),
        "the answer was {'success': False} (success is False)",
    ),
    "service called once": Case(
        "name: s, service: /switch, once: true, where: m.success",
        answers(
            "service s",
            QueryAnswer(at_s=3, error="busy"),
            QueryAnswer(at_s=3, value={"success": True}),
        ),
        answers(
            "service s",
            QueryAnswer(at_s=3, value={"success": False}),
            QueryAnswer(at_s=4, value={"succes": 1}),
        ),
        "the answer was",
    ),
    "service that is not called": Case(
        "service: /switch, type: std_srvs/SetBool, call: false",
        graphs(graph(services={"/switch": ("std_srvs/srv/SetBool",)})),
        graphs(graph(services={"/switch": ("std_srvs/srv/Empty",)})),
        "its type is std_srvs/srv/Empty",
    ),
    "service that does not exist": Case(
        "service: /switch, call: false",
        graphs(graph(services={"/switch": ("std_srvs/srv/SetBool",)})),
        {**graphs(graph()), "services": ("/site/switch",)},
        "no service /switch",
        "there is a service of that name elsewhere: /site/switch",
    ),
    "service of every node": Case(
        "service: /cam/get_parameters, type: rcl_interfaces/srv/GetParameters, call: false",
        graphs(graph(nodes=("/cam",))),
        graphs(graph(nodes=("/cam",), ghosts=("/cam",))),
        "no service /cam/get_parameters",
    ),
    "service of nobody": Case(
        "name: s, service: /switch",
        answers("service s", QueryAnswer(at_s=3, value={})),
        {"services": ("/site/switch",)},
        "there was no answer",
        "there is a service of that name elsewhere: /site/switch",
    ),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_an_expectation_is_met_or_not_and_says_what_was_seen(case: Case):
    case.check()


def test_every_kind_is_there():
    judged = {expectation(case.entry).kind for case in CASES.values()}
    own = {"like"}  # it needs bags: test_like
    assert judged | own == {kind.name for kind in KINDS if kind.needs_ros}


def test_times_of_publishers_count_for_rates_where_they_are_known():
    bursts = tuple(replace(tick, at_s=20.0, sent_s=tick.at_s) for tick in ticks("/t", 1.0))
    assert verdict("rate: /t, is: 1 Hz", messages=bursts).outcome is Decision.MET
