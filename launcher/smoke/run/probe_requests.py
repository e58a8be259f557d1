"""Requests to the probe for expectations: subscriptions, and polling of parameters and services."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from launcher.base.errors import LauncherError
from launcher.smoke.expect.expectation import Decision, Expectation
from launcher.smoke.expect.expectation_kinds import OF_MESSAGES, OTHER_TOPICS
from launcher.smoke.judges import judge
from launcher.smoke.judges.common import window
from launcher.smoke.observe.facts import QueryAnswer
from launcher.smoke.observe.probe_client import ProbeClient
from launcher.smoke.run.system import System

POLL_S = 0.5
ANSWER_S = 2.0  # a busy node may answer the next time


def subscribed(probe: ProbeClient, expectations: Iterable[Expectation]) -> Iterator[Expectation]:
    """Subscribe to topics; `watch` of an expectation is its subscription.

    `other_watch` is that to the other topic of a relation. There is one subscription for all that
    need the same type and QoS of a topic.
    """
    subs: dict[object, str] = {}
    numbers = itertools.count(1)

    def watch(topic: str, type_: str | None = None, given: Any = None) -> str:
        qos = None if given is None else {name: str(word).upper() for name, word in given.items()}
        depth = {}
        if qos is not None and qos.pop("depth", ""):
            depth = {"depth": int(given["depth"].high)}
        key = (topic, type_, qos and tuple(sorted(qos.items())), str(depth))
        if key not in subs:
            subs[key] = f"{topic} {next(numbers)}"
            probe.send("subscribe", sub=subs[key], topic=topic, type=type_, qos=qos, **depth)
        return subs[key]

    for one in expectations:
        if one.kind not in OF_MESSAGES:
            yield one
            continue
        more = {"watch": watch(one.subject, one.get("type"), one.get("qos"))}
        for topic in filter(None, map(one.get, OTHER_TOPICS)):
            more["other_watch"] = watch(topic)
        yield replace(one, values={**one.values, **more})


class AnswerPoller:
    """Requests parameters and calls services until the answer is the expected one."""

    def __init__(self, system: System, is_over: threading.Event) -> None:
        self._system = system
        self._is_over = is_over

    def begin(self, expectations: Iterable[Expectation]) -> None:
        for expectation in expectations:
            is_asked = expectation.kind in ("parameter", "service")
            if is_asked and expectation.get("call") is not False:
                threading.Thread(
                    target=self._poll, args=(expectation,), daemon=True, name=expectation.name
                ).start()

    def _poll(self, expectation: Expectation) -> None:
        recorder = self._system.recorder
        while not self._is_over.is_set():
            facts = self._system.facts()
            when = window(expectation, facts)
            if when is not None and facts.now_s >= when.from_s:
                recorder.add_answer(expectation.key, self._answer(expectation))
                verdict = judge(expectation, self._system.facts())
                if verdict.outcome is not Decision.OPEN:
                    return
            self._is_over.wait(POLL_S)

    def _answer(self, expectation: Expectation) -> QueryAnswer:
        recorder, name = self._system.recorder, expectation.subject
        try:
            if expectation.kind == "parameter":
                value = self._system.parameter(expectation.get("node"), name, ANSWER_S)
            else:
                type_, request = expectation.get("type"), expectation.get("request")
                value = self._system.call(name, type_, request, ANSWER_S)
        except LauncherError as error:
            return QueryAnswer(at_s=recorder.now_s, error=error.message, hint=error.hint)
        return QueryAnswer(at_s=recorder.now_s, value=value)
