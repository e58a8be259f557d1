"""Checks of a script before anything is started: times, types and fields."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from launcher.base.document.fields import near
from launcher.base.document.source_location import Origin
from launcher.base.errors import LauncherError, UsageError
from launcher.smoke.expect.expectation import STOP, Expectation
from launcher.smoke.expect.likeness import Likeness
from launcher.smoke.expect.script import Script
from launcher.smoke.expect.steps import Step
from launcher.smoke.preflight.interface_types import (
    UnknownTypeError,
    full_name,
    is_of_topic,
    load,
    of_topics,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """`errors` are certain; `warnings` may be intended."""

    errors: tuple[LauncherError, ...] = ()
    warnings: tuple[str, ...] = ()


def of_script(script: Script) -> Findings:
    types = _Types(script)
    types.check()
    errors = (*_late(script), *_unreadable(script), *types.errors)
    return Findings(errors=errors, warnings=tuple(types.warnings))


# ---- times


def _late(script: Script) -> Iterator[LauncherError]:
    """Steps and expectations whose time is after the end of the run."""
    if script.for_s is None:
        return
    end_s, times = script.for_s, script.earliest_s()
    if end_s <= 0:
        yield UsageError("nothing can be observed in 0 s", hint="increase 'for' (or --for)")
        return
    over, earliest = f"the system is observed for {end_s:g} s only", "s at the earliest"
    late: set[str] = set()  # moments of reported steps: what waits for them is late, too
    for step in script.steps:
        at_s = times[step.name]
        if at_s >= end_s:
            if step.after not in late:
                message = f"{over}, and '{step.command.text}' comes after {at_s:g} {earliest}"
                yield step.origin.error(message, _longer(at_s), "at")
            late.update(step.moments)
    for expectation in script.expectations:
        at_s = times.get(expectation.after, 0.0)
        at_s += 0.0 if expectation.within is None else expectation.within.low
        if at_s >= end_s and expectation.after not in late | {STOP}:
            message = f"{over}, and this is expected after {at_s:g} {earliest}"
            yield expectation.origin.error(message, _longer(at_s), "within")
    if script.chaos is not None and script.chaos.every_s >= end_s:
        message = f"{over}, and '{script.chaos.text}' starts later"
        yield UsageError(message, hint=_longer(script.chaos.every_s))


def _longer(at_s: float) -> str:
    return f"use 'for' (or --for) of more than {at_s:g} s, or an earlier time"


# ---- bags


def _unreadable(script: Script) -> Iterator[LauncherError]:
    """Bags that cannot be read, or that lack the topics that are named."""
    for expectation in script.expectations:
        likeness = expectation.subject
        if not isinstance(likeness, Likeness):
            continue
        try:
            unknown, known = likeness.unknown(), likeness.known
            is_empty = not likeness.reference
        except LauncherError as error:
            yield expectation.origin.error(error.message, error.hint, "like")
            continue
        for topic in unknown:
            text = f"{likeness} has no topic {topic}"
            yield expectation.origin.error(text, near(topic, known), "like")
        if is_empty and not unknown:
            text = f"{likeness} has no topic to compare"
            yield expectation.origin.error(text, "'topics' selects those of every node", "like")


# ---- types and fields


class _Types:
    def __init__(self, script: Script) -> None:
        self._script = script
        self._of_topics = of_topics(script)
        self.errors: list[LauncherError] = []
        self.warnings: list[str] = []

    def check(self) -> None:
        for expectation in self._script.expectations:
            if is_of_topic(expectation):
                self._topic(expectation)
            elif expectation.kind == "service":
                self._service(expectation)
        for step in self._script.steps:
            self._step(step)

    def _topic(self, expectation: Expectation) -> None:
        given = expectation.get("type")
        name = given or self._of_topics.get(expectation.subject)
        if name is None or "/msg/" not in name:
            return
        try:
            message = load(name, "msg")
        except UnknownTypeError as error:
            if given is not None:
                self._unknown(expectation, error)
            return
        self._conditions(expectation, message)

    def _unknown(self, expectation: Expectation, error: UnknownTypeError) -> None:
        """If only the name of the type is compared, it need not be installed."""
        is_compared = expectation.kind == "topic" or expectation.get("call") is False
        if is_compared and error.is_missing:
            if "did you mean" in (error.hint or ""):
                self.warnings.append(f"{expectation.origin}: {error.message}; {error.hint}")
            return
        self._note(expectation.origin, error, "type")

    def _service(self, expectation: Expectation) -> None:
        name = expectation.get("type")
        if name is None:
            return
        try:
            service = load(name, "srv")
        except UnknownTypeError as error:
            self._unknown(expectation, error)
            return
        if service is not None:
            self._conditions(expectation, service.Response)
            fault = _misfit(service.Request, expectation.get("request"))
            self._note(expectation.origin, fault, "request")

    def _conditions(self, expectation: Expectation, message: object) -> None:
        where, fields = expectation.get("where"), expectation.get("fields")
        if message is None or (where is None and fields is None):
            return
        from launcher.smoke.preflight import message_fields

        if where is not None:
            fault = message_fields.fault_of_expression(where, message)
            self._note(expectation.origin, fault, "where")
        for path, fault in (
            () if fields is None else message_fields.faults_of_fields(fields, message)
        ):
            self._note(expectation.origin, fault, "fields", path)

    def _step(self, step: Step) -> None:
        words, verb = step.command.words, step.command.verb
        kind = {"publish": "msg", "call": "srv"}.get(verb)
        if kind is None:
            return
        try:
            found = load(full_name(words["type"], kind), kind)
        except UnknownTypeError as error:
            self._note(step.origin, error, "do")
            return
        message = getattr(found, "Request", None) if kind == "srv" else found
        if message is not None:
            self._note(step.origin, _misfit(message, words.get("value")), "do")

    def _note(self, origin: Origin, error: LauncherError | None, *keys: object) -> None:
        if error is not None:
            self.errors.append(origin.error(error.message, error.hint, *keys))


def _misfit(message: Any, values: Any) -> LauncherError | None:
    """The error if the values do not fit the message."""
    from launcher.base.ros_errors import VerbError
    from launcher.ros.messages.from_yaml import fill

    try:
        fill(message(), {} if values is None else values)
    except VerbError as error:
        return error
    return None
