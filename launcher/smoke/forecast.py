"""Forecast: which processes a launch file is going to start, and whether a script means others.

The launch file is planned in a process of its own, as `plan` does: it is code of somebody else.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from launcher.control.names import Named, resolve
from launcher.control.verbs import BadCallError
from launcher.smoke.checks import Findings
from launcher.smoke.facts import means
from launcher.smoke.fields import near
from launcher.smoke.judges.logs import LAUNCHER
from launcher.smoke.places import Origin
from launcher.smoke.script import Script

PLAN_S = 20.0  # a launch file that takes longer is not planned, but launched all the same
_NUMBER = re.compile(r"-\d+$")
_OF_PROCESSES = ("process", "cpu", "memory", "no_errors", "no_tracebacks")


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """`is_certain`: what is started does not depend on what happens while the system runs."""

    processes: tuple[Named, ...]
    is_certain: bool

    def knows(self, word: str) -> bool:
        """Whether one of the processes is meant."""
        with contextlib.suppress(BadCallError):
            return bool(resolve([word], self.processes))
        label = _NUMBER.sub("", word)  # which number a process gets may depend on its turn
        return any(
            means(word, one.name, one.nodes) or means(label, one.label, ())
            for one in self.processes
        )

    def names(self) -> list[str]:
        """What the processes are called, for suggestions."""
        return list(dict.fromkeys(one.label for one in self.processes))


@dataclass(frozen=True, slots=True, kw_only=True)
class Mention:
    """A word for processes; `keys` lead to it from the entry where it stands."""

    word: str
    origin: Origin
    keys: tuple[str, ...]


def mentions(script: Script) -> Iterator[Mention]:
    """Every word of a script that has to mean a process."""
    for step in script.steps:
        if "name" in step.command.words:
            yield Mention(word=step.command.words["name"], origin=step.origin, keys=("do",))
        if step.process is not None:
            yield Mention(word=step.process, origin=step.origin, keys=("process",))
    if script.chaos is not None:
        origin = Origin(text=f"chaos '{script.chaos.text}'")
        yield Mention(word=script.chaos.pattern, origin=origin, keys=())
    for e in script.expectations:
        word = e.subject if e.kind in _OF_PROCESSES else e.get("process")
        key = e.kind if e.kind in _OF_PROCESSES else "process"
        if isinstance(word, str) and word != "*" and (key, word) != ("process", LAUNCHER):
            yield Mention(word=word, origin=e.origin, keys=(key,))


def ask(words: Sequence[str]) -> Forecast | None:
    """What the plan of a launch file says; None if there is none, which its launch will explain.

    `words` are a target, launch arguments, and the options that decide how it is read.
    """
    command = [sys.executable, "-m", "launcher.commands.launch.forecast", *words]
    with subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            told = json.loads(process.communicate(timeout=PLAN_S)[0])
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # it is ours until somebody waits for it
            return None
        except ValueError:
            return None
    return Forecast(
        processes=tuple(
            Named(one["name"], one["label"], tuple(one["nodes"]), one["namespace"])
            for one in told["processes"]
        ),
        is_certain=told["is_certain"],
    )


def compare(script: Script, forecast: Forecast) -> Findings:
    """Words that mean no process: mistakes if the forecast is certain, else worth a warning."""
    errors, warnings = [], []
    for mention in mentions(script):
        if forecast.knows(mention.word):
            continue
        message = f"the launch file starts no process '{mention.word}'"
        hint = near(mention.word, forecast.names()) or "it starts none at all"
        origin = mention.origin
        if forecast.is_certain:
            errors.append(origin.error(message, hint, *mention.keys))
        else:
            later = "unless something that happens meanwhile makes it do so"
            warnings.append(f"{origin}: {message}, {later}; {hint}")
    return Findings(errors=tuple(errors), warnings=tuple(warnings))
