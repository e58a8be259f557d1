"""`topic hz`, `bw` and `delay` of topics without a publisher, or with a late one."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.support.node_process import line_of
from tests.support.verbs import TIMEOUT_S, eventually

pytestmark = pytest.mark.thorough

TOPIC = (sys.executable, "-m", "launcher", "topic")
UNPUBLISHED = "WARNING: topic [{}] does not appear to be published yet\n"


@pytest.mark.parametrize("name", ["hz", "bw", "delay"])
def test_the_wait_for_a_topic_ends_with_the_measurement(verb, name):
    answer = verb("topic", name, "/nosuch", "--for", "0.3")
    assert answer.out == UNPUBLISHED.format("/nosuch")
    assert answer.err.endswith("no message on /nosuch within 0.3 s\n")
    assert answer.code == 1


def test_a_topic_that_is_missing_is_below_the_minimum_and_hides_no_other(verb):
    def last_two(answer) -> list[dict[str, object]]:
        return [json.loads(line) for line in answer.lines[-2:]]

    words = ("topic", "hz", "/nosuch", "/chatter", "--for", "2", "--min", "1", "--json")
    answer = eventually(lambda: verb(*words), lambda answer: last_two(answer)[1]["mean_hz"] > 1)
    missing, there = last_two(answer)
    assert (missing["topic"], missing["messages"]) == ("/nosuch", 0)
    assert (there["topic"], answer.code) == ("/chatter", 1)


def test_a_topic_is_measured_as_soon_as_somebody_publishes_it(verb, env):
    bw = subprocess.Popen([*TOPIC, "bw", "/later"], env=env, stdout=subprocess.PIPE, text=True)
    assert line_of(bw.stdout) == UNPUBLISHED.format("/later")
    words = ("/later", "std_msgs/msg/String", "data: x", "--rate", "20", "--times", "40")
    verb("topic", "pub", *words)  # waits for the subscription
    assert line_of(bw.stdout) == "Subscribed to [/later]\n"
    assert "B/s from" in line_of(bw.stdout)
    bw.terminate()
    assert bw.wait(timeout=TIMEOUT_S) == 0
    bw.stdout.close()
