"""Whether something may still start what a run waits for."""

from __future__ import annotations

from typing import Any

import pytest

from launcher.run.requests.process_selection import ProcessNames
from launcher.smoke.preflight.forecast import Forecast, ForecastTime
from launcher.smoke.preflight.loader import parse
from launcher.smoke.run.pending_starts import lost
from tests.smoke.unit.facts import EMPTY, ended, graph, running, started

ROBOT = ProcessNames("robot_1-1", "robot_1", ("/robot_1",), "/")
LATE = ProcessNames("robot_2-2", "robot_2", ("/robot_2",), "/")
ANY = ProcessNames("tool-3", "tool")
NODE = "expect: [{node: /robot_2, within: 3 s}]"
STEP = "scenario: [{at: 20 s, do: start robot_2, name: s}%s]\n" + NODE


def forecast(*processes: ProcessNames, is_certain: bool = True, **more: Any) -> Forecast:
    return Forecast(processes=processes, is_certain=is_certain, **more)


def verdict(text: str, foreseen: Forecast | None, now_s: float = 4.0, **facts: Any) -> str | None:
    script = parse(text, "x.yaml")
    facts = {"graphs": (EMPTY,), **facts}
    found = lost(script.presence(), running(now_s, **facts), foreseen, script.steps)
    return None if found is None else str(found.subject)


AT_ONCE, TIMED, AFTER_EXIT = (
    ForecastTime(time_s=0.0),
    ForecastTime(time_s=60.0),
    ForecastTime(cause="robot_1"),
)
GONE = (*started("robot_1-1"), ended("robot_1-1", 0, 1.0))
RESTARTING = ended("robot_2-2", 1, 2.0, restart_in_s=9.0)
BOTH = started("robot_1-1", "robot_2-2")
WAITS: dict[str, tuple[str, Forecast | None, dict[str, Any]]] = {
    "its time is not over": (NODE, forecast(ROBOT), {"now_s": 3.1}),
    "it is there": (NODE, forecast(ROBOT), {"graphs": (graph(nodes=("/robot_2",)),)}),
    "a timer or a handler starts it": (NODE, forecast(ROBOT, LATE), {}),
    "a process without a known node": (NODE, forecast(ROBOT, ANY), {}),
    "a pattern": ("expect: [{node: /rob*_2, within: 3 s}]", forecast(ROBOT, LATE), {}),
    "any process may have the topic": (
        "expect: [{topic: /t, within: 3 s}]",
        forecast(ROBOT, LATE),
        {},
    ),
    "an event may do anything": (NODE, forecast(ROBOT, is_certain=False), {}),
    "no forecast": (NODE, None, {}),
    "it is restarted": (NODE, forecast(ROBOT, LATE), {"events": (*BOTH, RESTARTING)}),
    "a step starts it": (STEP % "", forecast(ROBOT), {}),
    "a step after a step": (
        STEP % ", {after: s, at: 1 s, do: start robot_2}",
        forecast(ROBOT),
        {},
    ),
    "it is started when another one exits": (
        NODE,
        forecast(ROBOT, LATE, moments=(TIMED, AFTER_EXIT)),
        {},
    ),
    "the other one has just exited": (
        NODE.replace("3 s", "1 s"),
        forecast(ROBOT, LATE, moments=(TIMED, AFTER_EXIT)),
        {"events": GONE, "now_s": 2.9},
    ),
    "a condition may be true later": (NODE, forecast(ROBOT, conditions=(TIMED,)), {}),
    "a condition may be true at any time": (
        NODE,
        forecast(ROBOT, conditions=(ForecastTime(),)),
        {},
    ),
    "a condition may be true at an exit": (NODE, forecast(ROBOT, conditions=(AFTER_EXIT,)), {}),
    "timers count from a start that waits": (
        NODE,
        forecast(ROBOT, moments=(AT_ONCE,), conditions=(ForecastTime(time_s=1.0),)),
        {"events": ()},
    ),
    "timers count from a late start": (
        NODE,
        forecast(ROBOT, moments=(AT_ONCE,), conditions=(ForecastTime(time_s=1.0),)),
        {"events": started("robot_1-1", at_s=2.0)},
    ),
    "a component": (NODE, forecast(ROBOT, components=("/robot_2",)), {}),
    "a component that names itself": (NODE, forecast(ROBOT, components=(None,)), {}),
}
LOST: dict[str, tuple[str, Forecast | None, dict[str, Any]]] = {
    "nothing starts it": (NODE, forecast(ROBOT), {}),
    "its process runs without it": (NODE, forecast(ROBOT, LATE), {"events": BOTH}),
    "its process has exited": (
        NODE,
        forecast(ROBOT, LATE),
        {"events": (*BOTH, ended("robot_2-2", 1, 2.0))},
    ),
    "another one is still started": (
        NODE,
        forecast(ROBOT, ProcessNames("robot_3-2", "robot_3", ("/robot_3",), "/")),
        {},
    ),
    "a step after it is ready": (
        STEP.replace("at: 20 s", "after: ready") % "",
        forecast(ROBOT),
        {},
    ),
    "a step that starts nothing": (
        "scenario: [{at: 20 s, do: kill robot_1}]\n" + NODE,
        forecast(ROBOT),
        {},
    ),
    "the other one has exited, and did not start it": (
        NODE,
        forecast(ROBOT, LATE, moments=(TIMED, AFTER_EXIT)),
        {"events": GONE},
    ),
    "a condition was false": (
        NODE,
        forecast(ROBOT, conditions=(ForecastTime(time_s=1.0), AFTER_EXIT)),
        {"events": GONE},
    ),
    "a condition was false, some time after the start": (
        NODE,
        forecast(ROBOT, moments=(AT_ONCE,), conditions=(ForecastTime(time_s=1.0),)),
        {"events": started("robot_1-1", at_s=0.5)},
    ),
    "a component of a container that is gone": (
        NODE,
        forecast(ROBOT, components=("/robot_2",)),
        {"events": (*started("robot_1-1"), ended("robot_1-1", 0, 2.0))},
    ),
}


@pytest.mark.parametrize(("text", "foreseen", "facts"), WAITS.values(), ids=WAITS)
def test_it_is_worth_waiting(text: str, foreseen: Forecast | None, facts: dict[str, Any]):
    assert verdict(text, foreseen, **facts) is None


@pytest.mark.parametrize(("text", "foreseen", "facts"), LOST.values(), ids=LOST)
def test_nothing_can_still_start_it(text: str, foreseen: Forecast | None, facts: dict[str, Any]):
    assert verdict(text, foreseen, **facts) == "/robot_2"


def test_a_topic_is_lost_when_everything_has_been_started():
    text = "expect: [{topic: /t, within: 3 s}]"
    assert verdict(text, forecast(ROBOT)) == "/t"


def test_the_first_of_several_is_told_and_others_may_wait():
    text = "expect: [{node: /robot_1, within: 60 s}, {node: /a, within: 1 s}, {node: /b}]"
    assert verdict(text, forecast(ROBOT)) == "/a"
