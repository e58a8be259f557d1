"""Kinds of expectations about ROS, met and not met by a real node."""

from __future__ import annotations

import pytest

from tests.smoke.process.bench import Bench, talking
from tests.support.drawing import is_drawn

EXPECTATIONS = r"""
    for: 10 s
    scenario:
      - {after: ready, do: 'publish /orders std_msgs/msg/String {data: go on}', name: order}
      - {after: ready, do: set /talker speed 2.5, name: faster}
      - {after: faster, do: 'call /switch std_srvs/srv/SetBool {data: true}', name: switched}
    expect:
      - {name: good node, node: /talker, within: 60 s}
      - {name: bad node, node: /talker, absent: true, within: 0.1 s, after: ready}
      - {name: good absence, node: /nobody, absent: true}
      - {name: bad absence, node: /talker, absent: true}
      - {name: good topic, topic: /steady, type: std_msgs/msg/String, publishers: 1,
         within: 60 s}
      - {name: bad type, topic: /steady, type: std_msgs/msg/Int32, after: ready}
      - {name: bad count, topic: /steady, publishers: 2, after: ready, within: 3 s}
      - {name: good qos, qos: /drifting, publishers: {reliability: best_effort}, within: 60 s}
      - {name: bad qos, qos: /drifting, publishers: {reliability: reliable}, after: ready}
      - {name: good mismatch, qos: /drifting, compatible: false, within: 60 s}
      - {name: bad match, qos: /drifting, compatible: true, after: ready, within: 2 s}
      - {name: good rate, rate: /steady, is: 5 Hz ± 40 %}
      - {name: bad rate, rate: /drifting, is: 5 Hz ± 3 %}
      - {name: good drift, rate: /drifting, is: 4.717 Hz ± 40 %}
      - {name: good gap, gap: /steady, below: 9 s}
      - {name: bad gap, gap: /steady, below: 150 ms}
      - {name: good latency, latency: /steady, below: 9 s}
      - {name: bad latency, latency: /drifting, below: 0 s}
      - {name: good single, node: /talker, count: 1, within: 60 s}
      - {name: bad double, node: /talker, count: 2, after: ready, within: 3 s}
      - {name: bad growth, memory: talker, growth: 100 MB/min}
      - {name: good message, message: /steady, where: json.count > 5}
      - {name: bad message, message: /steady, where: json.count < 0}
      - {name: good fields, message: /steady, fields: {speed: 2.5}, after: faster}
      - {name: bad fields, message: /steady, fields: {speed: {min: 3}}}
      - {name: good order, message: /steady, fields: {switched: true}, after: switched}
      - {name: good every, message: /steady, all: true, where: json.count > 0}
      - {name: bad every, message: /steady, all: true, where: json.speed < 2}
      - {name: good unique, unique: /steady, key: count}
      - {name: bad unique, unique: /steady, key: speed}
      - {name: good refers, refers: /drifting, key: data, to: /drifting}
      - {name: bad refers, refers: /steady, key: data, to: /drifting}
      - {name: good tally, tally: /drifting, key: data, in: /drifting, number: 'data": (1)'}
      - {name: bad tally, tally: /drifting, key: data, in: /steady, number: 'count": (\d+)'}
      - {name: bad expense, message: /steady, where: 9**9**9 > json.count}
      - {name: bad reliable, message: /drifting, qos: {reliability: reliable}}
      - {name: good log, log: 'ordered: go on', level: WARN, process: talker, after: ready}
      - {name: good parameter, parameter: speed, node: /talker, is: 2.5, after: ready,
         within: 60 s}
      - {name: bad parameter, parameter: speed, node: /talker, is: 9, after: ready, within: 3 s}
      - {name: good service, service: /switch, request: {data: true}, fields: {success: true},
         within: 60 s}
      - {name: bad service, service: /swich, after: ready, within: 3 s}
      - {name: bad spelling, parameter: sped, node: /talker, is: 9, after: ready, within: 3 s}
      - {name: good once, service: /switch, once: true, request: {data: true}, where: m.success,
         within: 60 s}
      - {name: good memory, shared_memory: clean}
      - {name: good shutdown, clean_shutdown: 60 s}
"""


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """One run for all of them."""
    bench = Bench(tmp_path_factory.mktemp("ros"))
    bench.write(talking())
    bench.expect(EXPECTATIONS)
    done = bench.smoke()
    assert done.returncode == 3, done.stdout + done.stderr
    return bench


NAMES = [line.partition("name: ")[2].partition(",")[0] for line in EXPECTATIONS.splitlines()]


@pytest.mark.parametrize("name", [n for n in NAMES if n.startswith(("good", "bad"))])
def test_a_kind_is_met_or_not(judged: Bench, name: str):
    wanted = "violated" if name.startswith("bad") else "met"
    assert judged.judged(name)["outcome"] == wanted, judged.judged(name)


@pytest.mark.parametrize(
    ("name", "guess"),
    [
        ("bad type", "the topic has another type: /talker uses std_msgs/msg/String"),
        ("bad qos", "reliability is BEST_EFFORT, but RELIABLE is requested"),
        ("bad reliable", "BEST_EFFORT"),
        ("bad service", "did you mean '/switch'?"),
        ("bad spelling", "did you mean 'speed'?"),
    ],
)
def test_a_failure_guesses_why(judged: Bench, name: str, guess: str):
    assert guess in judged.judged(name)["guess"]


def test_an_expensive_expression_is_named(judged: Bench):
    seen = "the evaluation of '9**9**9 > json.count' takes more than 1 s of CPU time"
    assert judged.judged("bad expense")["seen"] == seen


def test_the_graph_is_among_the_evidence(judged: Bench):
    assert '"/talker"' in (judged.evidence / "graph.json").read_text("utf-8")
    assert is_drawn(judged.evidence / "graph.svg", "/steady")
