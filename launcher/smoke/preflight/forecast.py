"""Forecast of the processes that a launch file starts, to find misspelt names in a script.

The launcher makes it when it has evaluated the launch file, before it starts anything.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.base.document.fields import near
from launcher.base.document.source_location import Origin
from launcher.base.run_verb import BadCallError
from launcher.run.requests.process_selection import ProcessNames, resolve
from launcher.smoke.expect.expectation import LAUNCHER
from launcher.smoke.expect.expectation_kinds import BY_NAME
from launcher.smoke.expect.script import Script
from launcher.smoke.observe.facts import label_of, matches
from launcher.smoke.preflight.script_checks import Findings


@dataclass(frozen=True, slots=True, kw_only=True)
class ForecastTime:
    """When something is due: a time after the start, or the exit of processes of a label.

    With neither, at any time.
    """

    time_s: float | None = None
    cause: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """`is_certain`: no event of the run can start other processes.

    `moments`: when each of the `processes` is started. `conditions`: when those are evaluated that
    are false at the start, and may be true then. `components`: full names of nodes that
    containers load, None where a component names its own.
    """

    processes: tuple[ProcessNames, ...]
    is_certain: bool
    moments: tuple[ForecastTime, ...] = ()
    conditions: tuple[ForecastTime, ...] = ()
    components: tuple[str | None, ...] = ()

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Forecast:
        """From what the launcher says."""
        processes = document["processes"]
        return cls(
            processes=tuple(
                ProcessNames(one["name"], one["label"], tuple(one["nodes"]), one["namespace"])
                for one in processes
            ),
            is_certain=document["is_certain"],
            moments=tuple(ForecastTime(**one["moment"]) for one in processes),
            conditions=tuple(ForecastTime(**one) for one in document["conditions"]),
            components=tuple(document["components"]),
        )

    def starts(self, word: str) -> bool:
        with contextlib.suppress(BadCallError):
            return bool(resolve([word], self.processes))
        label = label_of(word)  # the number of a process may depend on timing
        return any(
            matches(word, one.name, one.nodes) or matches(label, one.label, ())
            for one in self.processes
        )


def mentions(script: Script) -> Iterator[tuple[str, Origin, tuple[str, ...]]]:
    """(word, origin, keys) of every word of a script that must match a process.

    `keys` lead to the word from the entry at `origin`.
    """
    for step in script.steps:
        if "name" in step.command.words:
            yield step.command.words["name"], step.origin, ("do",)
        if step.process is not None:
            yield step.process, step.origin, ("process",)
    if script.chaos is not None:
        yield script.chaos.pattern, Origin(text=f"chaos '{script.chaos.text}'"), ()
    for e in script.expectations:
        of_process = BY_NAME[e.kind].of_process
        word, key = (e.subject, e.kind) if of_process else (e.get("process"), "process")
        if isinstance(word, str) and word != "*" and (key, word) != ("process", LAUNCHER):
            yield word, e.origin, (key,)


def compare(script: Script, forecast: Forecast) -> Findings:
    """Words that match no process: errors if the forecast is certain, else warnings."""
    errors, warnings = [], []
    for word, origin, keys in mentions(script):
        if forecast.starts(word):
            continue
        message = f"the launch file starts no process '{word}'"
        labels = dict.fromkeys(one.label for one in forecast.processes)
        hint = near(word, labels) or "it starts none"
        if forecast.is_certain:
            errors.append(origin.error(message, hint, *keys))
        else:
            warnings.append(f"{origin}: {message}, unless an event makes it do so; {hint}")
    return Findings(errors=tuple(errors), warnings=tuple(warnings))
