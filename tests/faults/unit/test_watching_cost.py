"""What a watched run takes is little, and what it sees is as recent as it can be."""

from __future__ import annotations

import os
import subprocess
from typing import Any

import pytest

from launcher.faults.checks.live_checks import checks_of, watched
from launcher.faults.checks.traffic import GapCheck
from launcher.faults.watcher import topic_watch
from launcher.faults.watcher.machine_facts import StopWatch
from launcher.faults.watcher.observations import Observations
from launcher.faults.watcher.parameter_watch import EVENTS, ParameterWatch
from launcher.faults.watcher.story import Story, TopicArrivals
from launcher.smoke.observe.facts import ObservedMessage
from launcher.smoke.observe.probe_client import ProbeError
from launcher.smoke.preflight import loader
from tests.support.waiting import wait_until


def expectations(tmp_path: Any, text: str) -> Any:
    file = tmp_path / "a.expect.yaml"
    file.write_text(f"expect:\n  - {text}\n")
    return watched(loader.load(str(file)).completed())[0]


@pytest.fixture
def gap(tmp_path):
    script = expectations(tmp_path, "{gap: /a, below: 300 ms}")
    return next(one for one in checks_of(script) if isinstance(one, GapCheck))


def test_silence_counts_until_arrivals_are_known(gap):
    story = Story()
    story.arrivals["/a"] = TopicArrivals()
    story.arrivals["/a"].sent += [20.0, 20.1, 20.2]
    story.arrivals_s, story.now_s = 20.25, 20.7
    assert gap.judge(story) == (True, None)
    story.arrivals_s = 20.6
    is_known, finding = gap.judge(story)
    assert is_known
    assert finding.seen.startswith("silent for")


def test_topics_are_judged_again_only_when_something_can_have_changed(gap, monkeypatch):
    story, looks = Story(), []
    story.arrivals["/a"] = TopicArrivals()
    monkeypatch.setattr(gap, "judged", lambda story, known_s: looks.append(known_s) or (True, None))
    for known_s in (20.0, 20.0, 20.5, 20.5):
        story.arrivals_s = known_s
        gap.judge(story)
    assert looks == [20.0, 20.5]


class Probe:
    """Answers requests for parameters."""

    is_alive = True

    def __init__(self) -> None:
        self.asked: list[str] = []

    def send(self, do: str, **fields: Any) -> None:
        assert (do, fields["topic"]) == ("subscribe", EVENTS)

    def ask(self, do: str, *, node: str, names: list[str], timeout_s: float) -> dict[str, Any]:
        self.asked.append(node)
        return {"missing": [], "values": dict.fromkeys(names, 1)}


def test_a_probe_that_does_not_answer_is_ended(monkeypatch):
    class HungProbe:
        is_alive = True

        def send(self, do: str, **fields: Any) -> None: ...

        def ask(self, do: str, **fields: Any) -> dict[str, Any]:
            raise ProbeError(f"the ROS probe did not answer '{do}'")

        def close(self) -> None:
            self.is_alive = False

    monkeypatch.setattr(topic_watch, "IDLE_S", 0.0)
    probe = HungProbe()
    watch = topic_watch.TopicWatch(probe, Observations(), ())  # type: ignore[arg-type]
    try:
        wait_until(lambda: not probe.is_alive, "the probe is ended")
    finally:
        watch.close()


def test_a_node_is_asked_for_parameters_when_it_appears_and_when_it_reports_a_change(tmp_path):
    script = expectations(tmp_path, "{parameter: p, node: /n, is: 1}")
    probe, observations = Probe(), Observations()
    watch = ParameterWatch(probe, observations, script.expectations)  # type: ignore[arg-type]
    try:
        watch.see([{"name": "/n", "pid": 1}])
        wait_until(lambda: len(probe.asked) == 1, "the node is asked")
        watch.see([{"name": "/n", "pid": 1}])
        event = ObservedMessage(at_s=1.0, topic=EVENTS, content={"node": "/n"}, watch=EVENTS)
        watch.take([event])
        wait_until(lambda: len(probe.asked) == 2, "the node is asked again")
        watch.see([{"name": "/n", "pid": 2}])
        wait_until(lambda: len(probe.asked) == 3, "another process is asked")
    finally:
        watch.close()


def test_files_of_processes_that_have_ended_are_closed():
    watch = StopWatch()
    with subprocess.Popen(["sleep", "60"]) as process:
        before = len(os.listdir("/proc/self/fd"))
        watch.look([process.pid])
        assert watch.share(process.pid) == 0.0
        process.kill()
    watch.look([process.pid])
    assert len(os.listdir("/proc/self/fd")) == before
