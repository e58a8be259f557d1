"""What the launcher has of a watcher: whether it watches, which faults there may be."""

from __future__ import annotations

import json
import time
from types import SimpleNamespace
from typing import Any, cast

import pytest

from launcher.base.errors import UsageError
from launcher.base.run_verb import BadCallError
from launcher.faults import fault_watch, verb
from launcher.faults.fault_watch import SILENT_S, FaultWatch


class Run(SimpleNamespace):
    """With the processes robot_1-3 and robot_2-4; `now_s` is the time of the reactor."""

    def __init__(self) -> None:
        super().__init__(now_s=100.0, processes=[SimpleNamespace(name=n) for n in NAMES])
        self.reactor = SimpleNamespace(now=lambda: self.now_s)


NAMES = ("robot_1-3", "robot_2-4")


@pytest.fixture
def watch(monkeypatch: pytest.MonkeyPatch) -> FaultWatch:
    monkeypatch.setattr(fault_watch, "settings_of", lambda run: {"expect": None})
    monkeypatch.setattr(
        fault_watch, "AnsweringProcess", lambda *given, **named: SimpleNamespace(pid=7)
    )
    return FaultWatch(cast("Any", Run()))


def greeting(watch: FaultWatch) -> Any:
    return json.loads(watch._process.greeting or b"")


def test_a_watcher_that_has_written_nothing_for_some_beats_does_not_watch(watch: FaultWatch):
    run = cast("Run", watch.run)
    assert watch.is_watching and SILENT_S < 10
    run.now_s += SILENT_S + 0.1
    assert not watch.is_watching
    watch._heard({"alive": True})
    assert watch.is_watching


def test_a_new_watcher_gets_the_time_of_the_last_report(watch: FaultWatch):
    assert greeting(watch) == {"do": "begin", "written_s": None}
    watch._heard({"left": []})  # it has judged nothing yet
    assert greeting(watch)["written_s"] is None
    begin_s = time.time()
    watch._heard({"alive": True})
    assert greeting(watch)["written_s"] >= begin_s


def test_a_fault_of_a_process_may_come_if_the_run_has_that_process(watch: FaultWatch):
    watch._heard({"names": ["no deaths: *", "responds: *", "QoS: *", "disk"]})
    for name in ("no deaths: robot_1-3", "responds: robot_2-4", "QoS: /t", "disk"):
        assert watch.may_come(name), name
    for name in ("no deaths: robot_1", "no deaths: *", "not suspended: robot_1-3", "QoS: "):
        assert not watch.may_come(name), name
    with pytest.raises(BadCallError) as refused:
        fault_watch._serve_change(watch, "mute", {"mute": "no deaths: robot_1"}, cast("Any", None))
    assert refused.value.hint == "did you mean 'no deaths: robot_1-3'?"


@pytest.mark.parametrize(
    "options",
    [
        {"reason": "x"},
        {"for_s": 5.0},
        {"acknowledge": "x", "for_s": 5.0},
        {"unmute": "x", "reason": "y"},
        {"mute": "x", "unmute": "x"},
        {"mute": "x", "follow": True},
        {"follow": True, "reason": "x"},
    ],
)
def test_options_that_do_not_belong_together_are_refused(options: dict[str, Any]):
    with pytest.raises(BadCallError):
        fault_watch._change_in(options)


def test_a_check_changes_nothing():
    for words in (["--mute", "x"], ["--unmute", "x"], ["--acknowledge", "x"], ["-f"]):
        with pytest.raises(UsageError, match="exclude each other"):
            verb.COMMAND.parse(["--check", *words])
    assert fault_watch._change_in({"mute": "x", "for_s": 5.0, "reason": "y"}) == "mute"
