"""`smoke TARGET [name:=value ...]`: start a system, check what is expected of it, and stop it."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.github import GITHUB_EXCLUSIVE, GITHUB_OPTIONS, add_summary, wants_github
from launcher.base.option import Option, count, lazy, option
from launcher.base.verb_table import VERBS
from launcher.launch.launch_options import RUN_GROUPS, RUN_OPTIONS, run_options
from launcher.launch.target import (
    ABOUT_TARGET,
    READING_OPTIONS,
    SYNOPSIS,
    TARGET,
    LaunchRequest,
    read_words,
)
from launcher.output.logs.run_directory import provide_log_root
from launcher.output.stdout import wants_colour
from launcher.run.part_options import CHAOS, PRIVATE, RECORDING
from launcher.smoke.smoke_options import EXPECTATIONS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.smoke.expect.script import Script
    from launcher.smoke.expect.steps import Chaos
    from launcher.smoke.record.recording_session import RecordSession
    from launcher.smoke.run.smoke_session import Session

_duration = lazy("launcher.base.document.quantities:parse_duration")


def _path(text: str) -> Path:
    if not text.strip():
        raise ValueError("a path is missing")
    return Path(text)


OPTIONS = (
    option(
        "--for S",
        "watch for S seconds once the system is ready (default: as the expectations need)",
        _duration,
        name="for_s",
    ),
    option(
        "--expect FILE",
        "file of expectations (default: NAME.expect.yaml beside the launch file)",
        repeat="once",
    ),
    option("--no-file", "use no file, only the expectations of options"),
    option(
        "--ready-within S",
        "exit with 124 if the system is not ready after S seconds",
        _duration,
        name="ready_within_s",
    ),
    option("--artifacts DIR", "keep logs, events, plan, graph and report in DIR", _path),
    option(
        "--bag",
        "record all topics: if a run fails, its evidence has the messages of the last minute, with "
        "logs, events and an index",
    ),
    option("--junit FILE", "write a JUnit report", _path),
    option(
        "--html FILE",
        "write the run as one page for a browser: processes, log, graph, plan, expectations",
        _path,
    ),
    *GITHUB_OPTIONS,
    option(
        "--repeat N", "run N times (once), and report what is flaky", lambda word: count(word, 1)
    ),
    option(
        "--baseline FILE",
        "fail on regressions against FILE, which is written if it does not exist",
        _path,
    ),
    option("--update-baseline", "write the baseline again"),
    option(
        "--chaos TEXT",
        "cause failures, as in 'kill one of robot_* every 5 s'",
        lazy("launcher.smoke.expect.steps:parse_chaos"),
        repeat="once",
    ),
    option("--seed N", "with --chaos: repeat its choices", count),
    option(
        "--record FILE",
        "watch 2 healthy runs (--repeat), each for 15 s (--for), and write what they have in "
        "common to FILE as expectations",
        _path,
    ),
    option("--force", "with --record: replace FILE if it exists"),
    option("--schema", "print the JSON Schema of files of expectations"),
)
_RUN_GROUPS = tuple(  # --bag and --chaos are theirs; a private domain, always
    (title, tuple(one for one in group if one not in (*RECORDING, PRIVATE, CHAOS)))
    for title, group in RUN_GROUPS
)
COMMAND = Command(
    "smoke",
    VERBS["smoke"],
    arguments=(TARGET,),
    synopsis=SYNOPSIS,
    about=f"""\
Start the launch file in a separate ROS domain, check the expectations, stop it, and check
what is left behind. Expectations are described in docs/reference/smoke.md.

{ABOUT_TARGET}""",
    options=OPTIONS,
    groups=(
        ("expectations", EXPECTATIONS),
        ("options about the launch file", READING_OPTIONS),
        *_RUN_GROUPS,
    ),
    exclusive=(GITHUB_EXCLUSIVE,),
    epilog="""\
exit codes: 0 all met, 1 a process exited unexpectedly or was killed, or there is no control socket,
2 bad command line or file, 3 not met, 124 not ready in time, 130 stopped by Ctrl-C, 143 by SIGTERM,
SIGHUP or SIGQUIT""",
)
_NOT_RECORDED = (
    *("--expect FILE", "--no-file", "--junit FILE", "--html FILE", "--github"),
    *("--bag", "--baseline FILE", "--update-baseline", "--chaos TEXT", "--seed N"),
)
# The words for the launcher, from the command line and from a file.
_WORDS_OF_RUNS = tuple(one for one in RUN_OPTIONS if one is not PRIVATE)
LAUNCH = Command("smoke", VERBS["smoke"], (TARGET,), (*READING_OPTIONS, *_WORDS_OF_RUNS))


def main(words: Sequence[str]) -> int:
    parsed = read_words(COMMAND, words)
    if parsed.schema:
        return _print_schema()
    provide_log_root(os.environ)
    try:
        if parsed.problem is not None:
            raise parsed.problem
        session = _session(parsed) if parsed.record is None else _recording(parsed)
        return session.run()
    except LauncherError as error:
        _report_refusal(parsed, error)
        raise


def _words_for(parsed: Parsed, options: Sequence[Option]) -> list[str]:
    """The words that are arguments, or belong to one of the options."""
    given = (words for one, words, _ in parsed.given if one is None or one in options)
    return [word for words in given for word in words]


def _session(parsed: Parsed) -> Session:
    """The session of a parsed command line; LauncherError."""
    if parsed.force:
        raise UsageError("--force needs --record")
    if parsed.html is not None:
        from launcher.packages import extras

        extras.require("web", "nicegui", "--html")
    run_options(parsed)
    request = LaunchRequest.of(parsed)
    script = _script(parsed, request.path)
    more = {n: v for n, v in script.arguments.items() if n not in dict(request.arguments)}
    arguments = [f"{name}:={value}" for name, value in more.items()]
    recorded = ("--record",) if parsed.bag else ()
    words = (*_words_for(parsed, LAUNCH.options), *arguments, *script.options, *recorded)
    from launcher.smoke.run.smoke_session import Options, Session

    launch = LAUNCH.parse(words)
    run_options(launch)
    plan_words = _words_for(launch, READING_OPTIONS)
    options = Options(
        words=words,
        target=Path(request.path).name,
        plan_words=tuple(plan_words),
        junit=parsed.junit,
        html=parsed.html,
        artifacts=parsed.artifacts,
        github=wants_github(github=parsed.github, no_github=parsed.no_github),
        repeat=parsed.repeat or 1,
        baseline=parsed.baseline,
        update_baseline=parsed.update_baseline,
    )
    _check(script)
    options.refuse_unwritable()
    if script.needs_ros():
        from launcher.packages import absent_ros

        absent_ros.require("an expectation or step about ROS", {})
    return Session(script, options, colour=wants_colour(1, os.environ))


def _recording(parsed: Parsed) -> RecordSession:
    """The session of `--record`; LauncherError."""
    for one, words, _ in parsed.given:
        if one is not None and (one in EXPECTATIONS or one.spelling in _NOT_RECORDED):
            hint = "a recording has no expectations but that its runs are healthy"
            raise UsageError(f"--record excludes {words[0].partition('=')[0]}", hint=hint)
    from launcher.packages import absent_ros

    absent_ros.require("smoke --record", {})
    run_options(parsed)
    request = LaunchRequest.of(parsed)
    from launcher.smoke.record import recording_session as recording
    from launcher.smoke.record.document import Head

    words = _words_for(parsed, LAUNCH.options)
    wanted = recording.RecordingOptions(
        path=parsed.record,
        words=tuple(words),
        head=Head(
            target=Path(request.path).name,
            arguments=dict(request.arguments),
            options=_option_words(parsed),
            for_s=recording.FOR_S if parsed.for_s is None else parsed.for_s,
        ),
        ready_within_s=parsed.ready_within_s or recording.READY_WITHIN_S,
        repeat=parsed.repeat or recording.RUNS,
        artifacts=parsed.artifacts,
        is_forced=parsed.force,
    )
    wanted.refuse_unwritable()
    return recording.RecordSession(wanted, colour=wants_colour(1, os.environ))


def _option_words(parsed: Parsed) -> list[str]:
    """The words of the options for the launcher, each in one."""
    given = (words for one, words, _ in parsed.given if one in LAUNCH.options)
    return ["=".join(words) for words in given]


def _report_refusal(parsed: Parsed, error: LauncherError) -> None:
    """Put the error into the reports, so that a CI server does not show those of the last run."""
    from launcher.smoke.reports import github, junit

    name = Path(parsed.words[0]).name if parsed.words else "smoke"
    if parsed.html is not None:
        from launcher.smoke.reports import html_report

        with contextlib.suppress(OSError, LauncherError):  # these may be what is wrong
            html_report.write_refusal(parsed.html, error, name)
    if parsed.junit is not None:
        with contextlib.suppress(OSError):  # that may be what is wrong
            junit.write_refusal(parsed.junit, error, name)
    if wants_github(github=parsed.github, no_github=parsed.no_github):
        print("\n".join(github.refusal(error)))
        if problem := add_summary(os.environ, github.refusal_summary(error, name)):
            print(f"smoke: warning: {problem}", file=sys.stderr)


def _check(script: Script) -> None:
    """LauncherError for mistakes that can be found before the launch; prints warnings."""
    from launcher.base.document.document_reader import together
    from launcher.smoke.preflight import script_checks

    found = script_checks.of_script(script)
    for warning in found.warnings:
        print(f"smoke: warning: {warning}", file=sys.stderr)
    if found.errors:
        raise together(found.errors)


def _print_schema() -> int:
    from launcher.base import strict_json
    from launcher.smoke.expect.expectation_entries import json_schema

    print(strict_json.dumps(json_schema(), indent=2, ensure_ascii=False))
    return ExitCode.OK


def _script(parsed: Parsed, launch_file: str) -> Script:
    """The script from the file and the options, which take precedence."""
    from dataclasses import replace

    from launcher.smoke.expect.script import Script
    from launcher.smoke.preflight import loader

    script = Script()
    path, absent = parsed.expect, ""
    if path is None and not parsed.no_file:
        found = loader.beside(launch_file)
        path = None if found is None else str(found)
        absent = f" (there is no {loader.usual(launch_file)})" if found is None else ""
    if path is not None:
        script = loader.load(path)
    script = replace(script, expectations=(*script.expectations, *parsed.expectations))
    if parsed.for_s is not None:
        script = replace(script, for_s=parsed.for_s)
    if parsed.ready_within_s is not None:
        script = replace(script, ready_within_s=parsed.ready_within_s)
    script = replace(script, chaos=_chaos(parsed, script))
    if not script.expectations:
        text = f"no expectations{absent}, except that no process exits unexpectedly"
        print(f"smoke: {text}", file=sys.stderr)
    return script


def _chaos(parsed: Parsed, script: Script) -> Chaos | None:
    chaos: Chaos | None = parsed.chaos or script.chaos
    if parsed.seed is None:
        return chaos
    if chaos is None:
        raise UsageError("--seed needs --chaos")
    from dataclasses import replace

    return replace(chaos, seed=parsed.seed)
