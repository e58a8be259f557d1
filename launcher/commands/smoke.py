"""`smoke TARGET [name:=value ...]`: bring a system up, look at it, take it down, tell the truth."""

from __future__ import annotations

import contextlib
import os
import sys
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from launcher.commands.launch import LENIENT, NONINTERACTIVE, PATIENCE, PREFIX, PREFIX_FILTER
from launcher.commands.launch import target as command_line
from launcher.commands.launch.options import HELP as RUN_HELP
from launcher.commands.launch.options import take_run_options
from launcher.engine.screen import wants_colour
from launcher.errors import ExitCode, LauncherError, UsageError
from launcher.smoke import checks, forecast, loader, options
from launcher.smoke.expectation import Expectation
from launcher.smoke.fields import near
from launcher.smoke.quantities import DURATION
from launcher.smoke.script import Script
from launcher.smoke.steps import Chaos, ChaosType

if TYPE_CHECKING:
    from launcher.smoke.session import Session

USAGE = f"""usage: python -m launcher smoke TARGET [name:=value ...] [options]

Starts the launch file in a ROS domain of its own, looks whether what is expected is seen, stops
it, and looks what is left. docs/smoke.md tells how expectations are written.

options:
  --for S              watch for S seconds once it is ready (default: as the expectations need)
  --expect FILE        the expectations (default: NAME.expect.yaml beside the launch file)
  --no-file            only the expectations that options give
  --ready-within S     give up if the system is not ready by then
  --artifacts DIR      keep the evidence there: logs, events, plan, graph, report
  --junit FILE         the results for CI servers
  --github             annotations for a workflow of GitHub
  --repeat N           N runs, and a report of what is flaky
  --baseline FILE      fail on regressions; written if it is not there
  --update-baseline    write the baseline anew
  --chaos TEXT         'kill one of robot_* every 5 s'; --seed N chooses the same again
  --schema             print the JSON Schema of files of expectations

expectations:
{options.HELP}

What else is an option of the launcher (--restart, --lenient ...) is handed on.

exit codes: 0 all met, 1 a process died unasked or had to be killed, 2 bad command line or file,
3 not met, 124 not ready in time, 130 stopped by Ctrl-C, 143 by SIGTERM, SIGHUP or SIGQUIT"""

_VALUED = (
    "--for",
    "--expect",
    "--ready-within",
    "--artifacts",
    "--junit",
    "--repeat",
    "--baseline",
    "--chaos",
    "--seed",
)
_ONCE = ("--expect", "--chaos")  # of the others the last one counts
_PLAIN = ("--no-file", "--github", "--update-baseline", "--schema")
_LAUNCHER_PLAIN = (LENIENT, NONINTERACTIVE)
_LAUNCHER_VALUED = (PREFIX, PREFIX_FILTER, PATIENCE)


class _Words:
    """What the command line says: our options, expectations, and the rest."""

    def __init__(self) -> None:
        self.values: dict[str, str] = {}
        self.expectations: list[Expectation] = []
        self.rest: list[str] = []

    def read(self, words: Sequence[str]) -> None:
        """Sort the words; UsageError."""
        queue = deque(words)
        while queue:
            word = queue.popleft()
            name, has_value, value = word.partition("=")
            if name in _PLAIN and not has_value:
                self.values[name] = ""
            elif name in options.PLAIN:
                self.expectations.append(options.expectation_of(name, value))
            elif name in (*_VALUED, *options.VALUED):
                if not has_value:
                    if not queue:
                        raise UsageError(f"{name} needs a value", hint=USAGE.splitlines()[0])
                    value = queue.popleft()
                self._take(name, value)
            else:
                self.rest.append(word)

    def _take(self, name: str, value: str) -> None:
        if name in options.VALUED:
            self.expectations.append(options.expectation_of(name, value))
        elif name in _ONCE and name in self.values:
            raise UsageError(f"{name} is there twice: '{self.values[name]}' and '{value}'")
        else:
            self.values[name] = value

    def has(self, name: str) -> bool:
        """Whether an option is given."""
        return name in self.values

    def path(self, name: str) -> Path | None:
        """The path that an option names; UsageError for an empty one, which would mean here."""
        if name not in self.values:
            return None
        if not self.values[name].strip():
            raise UsageError(f"{name} needs a path")
        return Path(self.values[name])

    def seconds(self, name: str) -> float | None:
        """The time that an option gives; UsageError."""
        found: float | None = _parsed(name, DURATION.parse, self.values.get(name))
        return found

    def count(self, name: str, default: int, least: int = 0) -> int:
        """The number that an option gives; UsageError."""
        text = self.values.get(name)
        if text is None:
            return default
        if not text.isdecimal() or int(text) < least:
            raise UsageError(f"{name} takes a number from {least} on, not '{text}'")
        return int(text)


def _parsed(name: str, parse: Any, text: str | None) -> Any:
    if text is None:
        return None
    try:
        return parse(text)
    except ValueError as error:
        raise UsageError(f"{name}: {error}", hint=getattr(error, "hint", None)) from None


def main(words: Sequence[str]) -> int:
    """One smoke command; the exit code."""
    if command_line.wants_help(words):
        print(USAGE)
        return ExitCode.OK
    given = _Words()
    given.read(words)
    if given.has("--schema"):
        return _print_schema()
    try:
        session = _session(given)
    except LauncherError as error:
        _tell_refusal(given, error)
        raise
    return session.run()


def _session(given: _Words) -> Session:
    """What is to be run; LauncherError for everything that is wrong beforehand."""
    _refuse_mistyped(given.rest)
    _, launch_words = take_run_options(given.rest)
    request = command_line.read(
        launch_words,
        verb="smoke",
        usage=USAGE.splitlines()[0],
        flags=_LAUNCHER_PLAIN,
        valued=_LAUNCHER_VALUED,
    )
    script = _script(given, request.path)
    more = {n: v for n, v in script.arguments.items() if n not in dict(request.arguments)}
    arguments = [f"{name}:={value}" for name, value in more.items()]
    words = (*given.rest, *arguments, *script.options)
    from launcher.smoke.session import Options, Session

    options = Options(
        words=words,
        target=Path(request.path).name,
        junit=given.path("--junit"),
        artifacts=given.path("--artifacts"),
        github=given.has("--github"),
        repeat=given.count("--repeat", 1, least=1),
        baseline=given.path("--baseline"),
        update_baseline=given.has("--update-baseline"),
    )
    _refuse_what_cannot_be(script, take_run_options(words)[1])
    options.refuse_unwritable()
    return Session(script, options, colour=wants_colour(1, os.environ))


def _tell_refusal(given: _Words, error: LauncherError) -> None:
    """A server that reads reports learns from them why there was no run, not what was before."""
    from launcher.smoke.reports import github, junit

    path = given.path("--junit")
    if path is not None:
        with contextlib.suppress(OSError):  # that may be what is wrong
            junit.write_refusal(path, error, Path(given.rest[0]).name if given.rest else "smoke")
    if given.has("--github"):
        print("\n".join(github.refusal(error)))


def _refuse_what_cannot_be(script: Script, words: Sequence[str]) -> None:
    """What can be known to be wrong before anything is started; LauncherError."""
    found = [checks.of_script(script)]
    if any(forecast.mentions(script)):
        foreseen = forecast.ask(words)
        found += [] if foreseen is None else [forecast.compare(script, foreseen)]
    for warning in (text for findings in found for text in findings.warnings):
        print(f"smoke: warning: {warning}", file=sys.stderr)
    errors = [error for findings in found for error in findings.errors]
    if errors:
        raise checks.together(errors)


def _refuse_mistyped(rest: Sequence[str]) -> None:
    """A near miss of one of our options would be told as an option of the launcher."""
    known = [*_VALUED, *_PLAIN, *options.VALUED, *options.PLAIN]
    theirs = {word for option in (*_LAUNCHER_PLAIN, *_LAUNCHER_VALUED) for word in option}
    for word in rest:
        name = word.partition("=")[0]
        hint = near(name, known) or ""
        is_theirs = name in theirs or name in RUN_HELP
        if name.startswith("--") and hint.startswith("did") and not is_theirs:
            raise UsageError(f"unknown option '{name}'", hint=hint)


def _print_schema() -> int:
    import json

    from launcher.smoke.grammar import json_schema

    print(json.dumps(json_schema(), indent=2, ensure_ascii=False))
    return ExitCode.OK


def _script(given: _Words, launch_file: str) -> Script:
    """From the file and the options; an option wins."""
    script = Script()
    path = given.values.get("--expect")
    if path is None and not given.has("--no-file"):
        found = loader.beside(launch_file)
        path = None if found is None else str(found)
    if path is not None:
        script = loader.load(path)
    script = replace(script, expectations=(*script.expectations, *given.expectations))
    for_s, ready_s = given.seconds("--for"), given.seconds("--ready-within")
    if for_s is not None:
        script = replace(script, for_s=for_s)
    if ready_s is not None:
        script = replace(script, ready_within_s=ready_s)
    chaos = _chaos(given, script)
    script = script if chaos is None else replace(script, chaos=chaos)
    if not script.expectations:
        print("smoke: nothing is expected but that no process dies", file=sys.stderr)
    return script


def _chaos(given: _Words, script: Script) -> Chaos | None:
    chaos: Chaos | None = _parsed("--chaos", ChaosType().parse, given.values.get("--chaos"))
    chaos = chaos or script.chaos
    if given.has("--seed"):
        if chaos is None:
            raise UsageError("--seed decides about --chaos, which is missing")
        chaos = replace(chaos, seed=given.count("--seed", 0))
    return chaos
