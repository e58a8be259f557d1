"""Checks: what of a script can never come true, found before anything is started."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.errors import LauncherError, SeveralErrors, UsageError
from launcher.smoke.expectation import Expectation
from launcher.smoke.facts import STOP
from launcher.smoke.interface_types import UnknownTypeError, full_name, is_of_topic, load, of_topics
from launcher.smoke.script import Script
from launcher.smoke.steps import Step


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """`errors` are certain; `warnings` are sentences about what may be meant so."""

    errors: tuple[LauncherError, ...] = ()
    warnings: tuple[str, ...] = ()


def of_script(script: Script) -> Findings:
    """What is wrong with its times, types and fields."""
    types = _Types(script)
    types.look()
    errors = (*_late(script), *types.errors)
    return Findings(errors=errors, warnings=tuple(types.warnings))


# ---- times


def _late(script: Script) -> Iterator[LauncherError]:
    """Steps and expectations whose time comes when the run is over."""
    if script.for_s is None:
        return
    end_s, times = script.for_s, script.earliest_s()
    if end_s <= 0:
        yield UsageError("nothing can be seen in 0 s", hint="'for' (or --for) is longer than that")
        return
    over, earliest = f"the system is watched for {end_s:g} s only", "s at the earliest"
    late: set[str] = set()  # moments of steps that are told: what waits for them is late, too
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
        message = f"{over}, and '{script.chaos.text}' strikes later for the first time"
        yield UsageError(message, hint=_longer(script.chaos.every_s))


def _longer(at_s: float) -> str:
    return f"'for' (or --for) of more than {at_s:g} s, or an earlier time"


# ---- types and fields


class _Types:
    """Looks at all types and fields that a script names."""

    def __init__(self, script: Script) -> None:
        self._script = script
        self._of_topics = of_topics(script)
        self.errors: list[LauncherError] = []
        self.warnings: list[str] = []

    def look(self) -> None:
        """Everything that stands in the script."""
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
        """A type whose name alone is compared need not be installed."""
        if expectation.kind == "topic" and error.is_missing:
            if "did you mean" in (error.hint or ""):
                self.warnings.append(f"{expectation.origin}: {error.message}; {error.hint}")
            return
        self.errors.append(expectation.origin.error(error.message, error.hint, "type"))

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
            if fault is not None:
                self.errors.append(expectation.origin.error(*fault, "request"))

    def _conditions(self, expectation: Expectation, message: Any) -> None:
        where, fields = expectation.get("where"), expectation.get("fields")
        if message is None or (where is None and fields is None):
            return
        from launcher.smoke import shapes

        if where is not None:
            fault = shapes.fault_of_expression(where, message)
            if fault is not None:
                self.errors.append(expectation.origin.error(*fault, "where"))
        for path, fault in () if fields is None else shapes.faults_of_fields(fields, message):
            self.errors.append(expectation.origin.error(*fault, "fields", path))

    def _step(self, step: Step) -> None:
        words, verb = step.command.words, step.command.verb
        kind = {"publish": "msg", "call": "srv"}.get(verb)
        if kind is None:
            return
        try:
            found = load(full_name(words["type"], kind), kind)
        except UnknownTypeError as error:
            self.errors.append(step.origin.error(error.message, error.hint, "do"))
            return
        message = getattr(found, "Request", None) if kind == "srv" else found
        fault = None if message is None else _misfit(message, words.get("value"))
        if fault is not None:
            self.errors.append(step.origin.error(*fault, "do"))


def _misfit(message: Any, values: Any) -> tuple[str, str | None] | None:
    """Why these values are none of such a message."""
    from launcher.ros.errors import VerbError
    from launcher.ros.messages.from_yaml import fill

    try:
        fill(message(), {} if values is None else values)
    except VerbError as error:
        return error.message, error.hint
    return None


def together(errors: Sequence[LauncherError]) -> LauncherError:
    """One error that tells all, in the order of their lines."""
    in_order = sorted(errors, key=_line)
    return in_order[0] if len(in_order) == 1 else SeveralErrors(in_order)


def _line(error: LauncherError) -> int:
    line = (error.where or "").rpartition(":")[2]
    return int(line) if line.isdigit() else 0
