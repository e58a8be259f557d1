"""`--use-sim-time`, and topics with a history, against a simulation."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from tests.support.ros_domain import ros_domain, talking
from tests.support.simulation import AGE_S, BEGIN_NS
from tests.support.verbs import Answer, eventually, launcher

Run = Callable[..., Answer]


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with (
        ros_domain(tmp_path_factory.mktemp("log")) as env,
        talking(env, "tests.support.simulation"),
    ):
        yield env


@pytest.fixture
def run(simulated: dict[str, str]) -> Run:
    return lambda *words: launcher(simulated, *words)


def last_rate(answer: Answer) -> float:
    return float(json.loads(answer.lines[-1])["mean_hz"]) if answer.lines else 0.0


@pytest.mark.thorough
def test_hz_counts_in_simulated_time(run):
    words = ("topic", "hz", "/texts", "--for", "3", "--json")
    fast = eventually(lambda: run(*words), lambda answer: last_rate(answer) > 8)
    slow = eventually(lambda: run(*words, "-s"), lambda answer: 0 < last_rate(answer) < 4)
    assert last_rate(fast) > 2 * last_rate(slow)


@pytest.mark.thorough
def test_delay_compares_with_simulated_time(run):
    words = ("topic", "delay", "/points", "--for", "2.5", "-s", "--json")
    answer = eventually(lambda: run(*words), lambda answer: answer.lines)
    assert json.loads(answer.lines[0])["min_s"] >= AGE_S - 1


@pytest.mark.thorough
def test_bw_takes_simulated_time(run):
    words = ("topic", "bw", "/texts", "--for", "2.5", "--json")
    fast, slow = (
        json.loads(eventually(measuring, lambda answer: answer.lines).lines[-1])["bytes_per_s"]
        for measuring in (lambda: run(*words), lambda: run(*words, "-s"))
    )
    assert fast > 2 * slow


@pytest.mark.thorough
def test_pub_stamps_with_simulated_time_and_waits_by_it(run, simulated):
    # 30 s of the simulation are 3 s; without it, the messages would take four minutes
    values = '{"header": "auto"}'
    words = ("topic", "pub", "/stamped", "geometry_msgs/msg/PointStamped", values, "-s")
    command = [sys.executable, "-m", "launcher", *words, "-r", "0.0333", "-w", "0"]
    with subprocess.Popen(command, env=simulated, stdout=subprocess.PIPE, text=True) as publishing:
        try:
            lines = iter(publishing.stdout.readline, "")
            found = [re.search(r"\(sec=(\d+)", line) for line in lines_of(lines, 9)]
        finally:
            publishing.terminate()
    seconds = [int(one[1]) for one in found if one]
    assert all(second * 10**9 >= BEGIN_NS for second in seconds), seconds
    assert seconds[1] - seconds[0] >= 20  # 0.1 s of the machine may pass before the first stamp


def lines_of(lines: Iterator[str], most: int) -> list[str]:
    return [line for line, _ in zip(lines, range(most), strict=False)]


@pytest.mark.thorough
def test_without_a_clock_the_verb_says_what_it_waits_for(tmp_path):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.sample_nodes"):
        words = ("topic", "hz", "/chatter", "-s", "--for", "5")
        answer = eventually(lambda: launcher(env, *words), lambda answer: answer.err)
    assert (answer.out, "no time on /clock for 3 s" in answer.err) == ("", True), answer


@pytest.mark.thorough
def test_hz_does_not_count_the_history(run):
    answer = eventually(
        lambda: run("topic", "hz", "/latched", "--for", "5", "--json"),
        lambda answer: last_rate(answer) > 0,
    )
    verdict = json.loads(answer.lines[-1])
    assert verdict["mean_hz"] < 2.5, answer  # 50 messages of history, then 1 Hz
    assert verdict["messages"] <= 10
