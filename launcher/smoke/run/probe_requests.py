"""Questions: what expectations want to know that does not come by itself."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterable
from dataclasses import replace

from launcher.errors import LauncherError
from launcher.smoke.expect.expectation import Expectation, Outcome, period
from launcher.smoke.expect.expectation_kinds import judge
from launcher.smoke.observe.facts import Answer
from launcher.smoke.observe.probe_client import ProbeClient
from launcher.smoke.run.system import System

ASK_AGAIN_S = 0.5
PATIENCE_S = 2.0  # a node that is busy may answer the next time


def subscribed(probe: ProbeClient, expectations: Iterable[Expectation]) -> list[Expectation]:
    """Subscribe to what is to be heard; the expectations know their subscription then.

    One subscription for all that ask for the same type and QoS of a topic.
    """
    subs: dict[object, str] = {}
    numbers = itertools.count(1)
    found = []
    for expectation in expectations:
        if expectation.kind in ("rate", "message"):
            expectation = _watched(probe, expectation, subs, numbers)
        found.append(expectation)
    return found


def _watched(
    probe: ProbeClient, expectation: Expectation, subs: dict[object, str], numbers: Iterable[int]
) -> Expectation:
    topic, type_ = expectation.subject, expectation.get("type")
    qos = expectation.get("qos")
    words = None
    depth = {}
    if qos is not None:
        words = {name: str(word).upper() for name, word in qos.items() if name != "depth"}
        depth = {"depth": int(qos["depth"].high)} if "depth" in qos else {}
    key = (topic, type_, tuple(sorted((words or {}).items())), qos is None, tuple(depth.items()))
    if key not in subs:
        subs[key] = f"{topic} {next(iter(numbers))}"
        probe.tell("subscribe", sub=subs[key], topic=topic, type=type_, qos=words, **depth)
    return replace(expectation, values={**expectation.values, "watch": subs[key]})


class AnswerPoller:
    """Asks for parameters and services again and again until the answer is the expected one."""

    def __init__(self, system: System, is_over: threading.Event) -> None:
        self._system = system
        self._is_over = is_over

    def begin(self, expectations: Iterable[Expectation]) -> None:
        """One thread for each."""
        for expectation in expectations:
            if expectation.kind in ("parameter", "service"):
                threading.Thread(
                    target=self._ask, args=(expectation,), daemon=True, name=expectation.name
                ).start()

    def _ask(self, expectation: Expectation) -> None:
        while not self._is_over.is_set():
            facts = self._system.facts()
            when = period(expectation, facts)
            if when is not None and facts.now_s >= when.from_s:
                self._ask_once(expectation)
                verdict = judge(expectation, self._system.facts())
                if verdict.outcome is not Outcome.OPEN:
                    return
            self._is_over.wait(ASK_AGAIN_S)

    def _ask_once(self, expectation: Expectation) -> None:
        recorder = self._system.recorder
        try:
            value = self._value(expectation)
            answer = Answer(at_s=recorder.now_s, value=value)
        except LauncherError as error:
            answer = Answer(at_s=recorder.now_s, error=error.message, hint=error.hint)
        recorder.add_answer(expectation.key, answer)

    def _value(self, expectation: Expectation) -> object:
        if expectation.kind == "parameter":
            node = expectation.get("node")
            return self._system.parameter(node, expectation.subject, PATIENCE_S)
        request = expectation.get("request")
        value: object = self._system.call(
            expectation.subject, expectation.get("type"), request, PATIENCE_S
        )
        return value
