"""Sentences that describe the results of requests."""

from __future__ import annotations

import errno
import signal

import pytest

from launcher.base.model.events import Outcome
from launcher.run.output.screen_filters import FilterChange, Shown
from launcher.run.processes.machine_events import ProcessState
from launcher.run.requests.request_result import Kind, Result
from launcher.run.requests.result_sentences import sentence, shown_sentences

INT, KILL = signal.SIGINT, signal.SIGKILL


def result(kind: Kind, **fields: object) -> Result:
    return Result("robot-1", kind, done=True, **fields)


STOPPED = result(Kind.STOPPED, elapsed_s=0.123, signum=INT, exit=Outcome(returncode=-INT))
CLEAN = result(Kind.STOPPED, elapsed_s=0.123, signum=INT, exit=Outcome(returncode=0))
REFUSED = Outcome(spawn_errno=errno.ENOENT)


@pytest.mark.parametrize(
    ("one", "text"),
    [
        (STOPPED, "stopped in 0.12 s (SIGINT)"),
        (CLEAN, "stopped in 0.12 s (SIGINT, exit code 0)"),
        (
            result(Kind.STOPPED, signum=INT, restart_disabled=True),
            "stopped in 0.00 s (SIGINT); automatic restart is off",
        ),
        (
            result(Kind.STOPPED, exit=REFUSED),
            "could not be started: No such file or directory",
        ),
        (result(Kind.STARTED, pid=7), "started with pid 7"),
        (result(Kind.OVERTAKEN), "is not started: a later request stops it"),
        (
            result(Kind.NOT_RUNNING, state=ProcessState.BACKOFF),
            "is not running (BACKOFF): `stop` keeps it from being started",
        ),
        (
            result(Kind.UNREACHABLE, host="bot1", stopped=STOPPED),
            "stopped in 0.12 s (SIGINT), but was not started again: bot1 is unreachable",
        ),
        (
            result(Kind.UNREACHABLE, host="bot1", elapsed_s=4.2),
            "is on bot1, which is unreachable (4 s): nothing was done",
        ),
        (
            result(Kind.STOP_WAITS, host="bot1", elapsed_s=4.2),
            "is on bot1, which is unreachable (4 s): it will be stopped when bot1 can be reached",
        ),
        (
            result(Kind.LINK_LOST, host="bot1", elapsed_s=4.2),
            "is on bot1, which has become unreachable (4 s): the request may take effect there",
        ),
        (
            result(Kind.STARTED, pid=8, old_pid=7, stopped=STOPPED),
            "stopped in 0.12 s (SIGINT), started with pid 8 instead of 7",
        ),
        (
            result(Kind.RUN_STOPPING, stopped=CLEAN),
            "stopped in 0.12 s (SIGINT, exit code 0), but was not started again: "
            "the run is being stopped",
        ),
        (
            result(Kind.START_FAILED, exit=REFUSED),
            "could not be started: No such file or directory",
        ),
        (result(Kind.ALREADY_RUNNING, pid=7), "is already running (pid 7)"),
        (result(Kind.ALREADY_RUNNING), "is already running"),
        (result(Kind.NOT_RUNNING, state=ProcessState.FATAL), "is not running (FATAL)"),
        (
            result(Kind.ENDED_BY_SIGNAL, signum=KILL, exit=Outcome(returncode=-KILL)),
            "ended in 0.00 s (SIGKILL)",
        ),
        (result(Kind.WRITTEN, written=1), "received 1 byte on its standard input"),
        (
            result(Kind.NOT_WRITTEN, errno=errno.EPIPE),
            "cannot receive standard input: Broken pipe",
        ),
    ],
)
def test_a_result_has_a_sentence(one: Result, text: str):
    assert sentence(one) == f"robot-1 {text}"


@pytest.mark.parametrize("kind", Kind)
def test_there_is_a_sentence_for_each_kind(kind: Kind):
    text = sentence(result(kind, pid=7, signum=INT, state=ProcessState.STOPPED, exit=REFUSED))
    assert text.startswith("robot-1 ")
    assert "None" not in text and "{" not in text


@pytest.mark.parametrize(
    ("changes", "lines"),
    [
        (
            [FilterChange.MUTED, FilterChange.MUTED],
            ["every process is muted; its log files continue"],
        ),
        ([FilterChange.NOT_MUTED, FilterChange.NOT_MUTED], ["no process was muted"]),
        (
            [FilterChange.UNMUTED, FilterChange.NOT_MUTED],
            ["a is shown again; 0 lines were not shown"],
        ),
        ([FilterChange.NOT_HIDDEN, FilterChange.NOT_HIDDEN], ["nothing was hidden"]),
        (
            [FilterChange.EVERYTHING, FilterChange.NOT_HIDDEN],
            ["a is shown again; 0 lines were not shown"],
        ),
    ],
)
def test_a_result_common_to_all_processes_is_reported_once(
    changes: list[FilterChange], lines: list[str]
):
    shown = [Shown(name, change) for name, change in zip("ab", changes, strict=True)]
    assert shown_sentences(shown, is_everyone=True) == lines


@pytest.mark.parametrize("change", FilterChange)
def test_there_is_a_sentence_for_each_change(change: FilterChange):
    (line,) = shown_sentences([Shown("a", change, 2, 3, "x")], is_everyone=False)
    assert line.startswith("a ")


WARN = 2  # its index
SHOWS = "`show` shows everything"


@pytest.mark.parametrize(
    ("shown", "text"),
    [
        (
            Shown("a", FilterChange.LEVEL, level=WARN, outside=True),
            "shows WARN and above, but `solo` hides it",
        ),
        (Shown("a", FilterChange.LEVEL, muted=True), "shows all levels, but `mute` hides it"),
        (
            Shown("a", FilterChange.LEVEL, level=WARN, pattern="x"),
            "shows WARN and above; `grep 'x'` still hides lines",
        ),
        (
            Shown("a", FilterChange.PATTERN, level=WARN, pattern="x"),
            "shows only lines that match 'x'; `level WARN` still hides lines",
        ),
        (
            Shown("a", FilterChange.UNMUTED, 1, WARN, "x"),
            "is shown again; 1 line was not shown; `level WARN` and `grep 'x'` still hide lines",
        ),
        (Shown("a", FilterChange.ALONE), f"is shown alone; {SHOWS}"),
        (
            Shown("a", FilterChange.ALONE, was_muted=True),
            f"is shown alone and no longer muted; {SHOWS}",
        ),
        (
            Shown("a", FilterChange.MUTED, level=WARN, muted=True),
            "is muted; its log files continue",
        ),
    ],
)
def test_an_answer_tells_what_else_hides_lines(shown: Shown, text: str):
    assert shown_sentences([shown], is_everyone=False) == [f"a {text}"]


def test_unmute_without_effect_tells_what_hides_the_lines():
    shown = [Shown(name, FilterChange.NOT_MUTED, 0, WARN, "x") for name in "ab"]
    assert shown_sentences(shown, is_everyone=True) == [
        f"no process was muted; `level WARN` and `grep 'x'` still hide lines: {SHOWS}"
    ]


def test_the_level_under_solo_tells_who_is_shown_at_all():
    shown = [Shown("a", FilterChange.LEVEL, level=WARN)]
    shown += [Shown(name, FilterChange.LEVEL, level=WARN, outside=True) for name in "bcd"]
    shown += [Shown("e", FilterChange.LEVEL, level=WARN, muted=True)]
    assert shown_sentences(shown, is_everyone=True) == [
        "a shows WARN and above",
        f"3 processes are hidden by `solo`: {SHOWS}",
        f"1 process is hidden by `mute`: {SHOWS}",
    ]
