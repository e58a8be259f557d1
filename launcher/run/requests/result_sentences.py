"""The results of requests, which the engine returns as data, as sentences for users."""

from __future__ import annotations

import os
from collections.abc import Sequence

from launcher.base.model.events import signal_name
from launcher.base.text import count
from launcher.output.filters import LEVELS
from launcher.run.output.screen_filters import FilterChange, Shown
from launcher.run.processes.machine_events import ProcessState
from launcher.run.requests.request_result import Kind, Result


def sentence(result: Result) -> str:
    """`robot_1-2 stopped in 0.12 s (SIGINT)`."""
    middle = f"{_how_it_stopped(result.stopped)}, " if result.stopped is not None else ""
    return f"{result.process} {middle}{_what(result)}{_remark(result)}"


def _what(result: Result) -> str:
    match result.kind:
        case Kind.STOPPED:
            return _how_it_stopped(result)
        case Kind.STARTED:
            instead = "" if result.old_pid is None else f" instead of {result.old_pid}"
            return f"started with pid {result.pid}{instead}"
        case Kind.START_FAILED:
            return str(result.exit)
        case Kind.RUN_STOPPING if result.stopped is not None:
            return "but was not started again: the run is being stopped"
        case Kind.UNREACHABLE if result.stopped is not None:
            return f"but was not started again: {result.host} is unreachable"
        case Kind.NOT_RUNNING if result.state in _COMING:
            return f"is not running ({result.state.value}): `stop` keeps it from being started"
        case Kind.ALREADY_RUNNING:
            pid = "" if result.pid is None else f" (pid {result.pid})"
            return f"is already running{pid}"
        case Kind.ENDED_BY_SIGNAL:
            return f"ended in {result.elapsed_s:.2f} s ({_signal_and_exit(result)})"
        case Kind.WRITTEN:
            return f"received {count(result.written, 'byte')} on its standard input"
    return _SENTENCES[result.kind].format(
        pid=result.pid,
        state=result.state and result.state.value,
        signal=signal_name(result.signum),
        written=result.written,
        size=result.size,
        error=os.strerror(result.errno),
        host=result.host,
        silent_s=result.elapsed_s,
    )


_COMING = (ProcessState.STARTING, ProcessState.BACKOFF)
_SENTENCES = {
    Kind.NOT_RUNNING: "is not running ({state})",
    Kind.ENDED: "has ended",
    Kind.STUCK: "is stuck: SIGKILL has not ended it",
    Kind.RESTART_CANCELLED: "was waiting for its restart, which is cancelled",
    Kind.START_CANCELLED: "was stopped before it had started",
    Kind.RUN_STOPPING: "was not started: the run is being stopped",
    Kind.QUEUED: "is queued to start",
    Kind.OVERTAKEN: "is not started: a later request stops it",
    Kind.UNDER_DEBUGGER: "is under a debugger and runs on as it is; `restart` it, then `reload`",
    Kind.EXISTS: "is running (pid {pid})",
    Kind.SIGNALLED: "received {signal}",
    Kind.SURVIVED: "received {signal} and is still running",
    Kind.ALREADY_SUSPENDED: "is already paused",
    Kind.NOT_SUSPENDED: "is not paused",
    Kind.SUSPENDED: "paused with {signal}",
    Kind.RESUMED: "resumed with {signal}",
    Kind.WITHOUT_EFFECT: "received {signal}, without effect so far",
    Kind.PARTLY_WRITTEN: "received {written} of {size} bytes: it does not read its standard input",
    Kind.NOT_WRITTEN: "cannot receive standard input: {error}",
    Kind.NO_INPUT: "is composed, and has no standard input",
    Kind.UNREACHABLE: "is on {host}, which is unreachable ({silent_s:.0f} s): nothing was done",
    Kind.STOP_WAITS: "is on {host}, which is unreachable ({silent_s:.0f} s): it will be stopped "
    "when {host} can be reached",
    Kind.LINK_LOST: "is on {host}, which has become unreachable ({silent_s:.0f} s): the request "
    "may take effect there",
    Kind.HOST_LOST: "cannot be started: {host} cannot be used any more in this run",
}


def _how_it_stopped(result: Result) -> str:
    if result.exit is not None and result.exit.returncode is None:
        return str(result.exit)  # no signal was sent: there was no process yet
    return f"stopped in {result.elapsed_s:.2f} s ({_signal_and_exit(result)})"


def _signal_and_exit(result: Result) -> str:
    """`SIGINT`, or `SIGINT, exit code 1` if the signal itself did not end it."""
    name, end = signal_name(result.signum), str(result.exit or "")
    return name if end in ("", name) else f"{name}, {end}"


def _remark(result: Result) -> str:
    return "; automatic restart is off" if result.restart_disabled else ""


# ---- screen filters

SHOW = "`show` shows everything"
_NO_EFFECT = {
    FilterChange.NOT_MUTED: "no process was muted",
    FilterChange.NOT_HIDDEN: "nothing was hidden",
}
# Verbs of which it matters whether another one hides the process.
_OF_LINES = (FilterChange.LEVEL, FilterChange.PATTERN)


def shown_sentence(shown: Shown) -> str:
    """`robot_1-2 is muted; its log files continue`."""
    return f"{shown.process} {_shown(shown)}"


def _shown(shown: Shown) -> str:
    return _changed(shown) + _but(shown)


def _changed(shown: Shown) -> str:
    match shown.change:
        case FilterChange.MUTED:
            return "is muted; its log files continue"
        case FilterChange.NOT_MUTED:
            return "was not muted"
        case FilterChange.NOT_HIDDEN:
            return "was not hidden"
        case FilterChange.UNMUTED | FilterChange.EVERYTHING:
            verb = "was" if shown.hidden_lines == 1 else "were"
            return f"is shown again; {count(shown.hidden_lines, 'line')} {verb} not shown"
        case FilterChange.ALONE:
            unmuted = " and no longer muted" if shown.was_muted else ""
            return f"is shown alone{unmuted}; {SHOW}"
        case FilterChange.LEVEL:
            level = f"{LEVELS[shown.level]} and above" if shown.level else "all levels"
            return f"shows {level}"
        case FilterChange.PATTERN:
            if shown.pattern is None:
                return "shows all lines"
            return f"shows only lines that match {shown.pattern!r}"


def _but(shown: Shown) -> str:
    """What else hides lines of the process."""
    hider = _hider(shown)
    if shown.change in _OF_LINES and hider:
        return f", but {hider} hides it"
    filters = [] if shown.change is FilterChange.MUTED else _line_filters(shown)
    return f"; {_still_hide(filters)}" if filters else ""


def _still_hide(filters: Sequence[str]) -> str:
    return f"{' and '.join(filters)} still hide{'s' if len(filters) == 1 else ''} lines"


def _hider(shown: Shown) -> str:
    """The verb that hides all its lines."""
    return "`solo`" if shown.outside else "`mute`" if shown.muted else ""


def _line_filters(shown: Shown) -> list[str]:
    """The filters of lines that are active, without the one that was just set."""
    filters = []
    if shown.level and shown.change is not FilterChange.LEVEL:
        filters.append(f"`level {LEVELS[shown.level]}`")
    if shown.pattern is not None and shown.change is not FilterChange.PATTERN:
        filters.append(f"`grep {shown.pattern!r}`")
    return filters


def shown_sentences(changes: Sequence[Shown], *, is_everyone: bool) -> list[str]:
    """One line per process; fewer if it `is_everyone` and lines would be alike."""
    if not is_everyone or len(changes) < 2:
        return [shown_sentence(one) for one in changes]
    if all(one.change in _NO_EFFECT for one in changes):
        return [_without_effect(changes)]
    if len({_shown(one) for one in changes}) == 1:
        return [f"every process {_shown(changes[0])}"]
    if changes[0].change in _OF_LINES:
        return _of_lines(changes)
    return [shown_sentence(one) for one in changes if one.change not in _NO_EFFECT]


def _without_effect(changes: Sequence[Shown]) -> str:
    filters = dict.fromkeys(text for one in changes for text in _line_filters(one))
    text = _NO_EFFECT[changes[0].change]
    return f"{text}; {_still_hide(list(filters))}: {SHOW}" if filters else text


def _of_lines(changes: Sequence[Shown]) -> list[str]:
    """Those that are shown, and how many are hidden altogether."""
    lines = [shown_sentence(one) for one in changes if not _hider(one)]
    for verb in ("`solo`", "`mute`"):
        hidden = sum(_hider(one) == verb for one in changes)
        if hidden:
            are = "is" if hidden == 1 else "are"
            lines.append(f"{count(hidden, 'process')} {are} hidden by {verb}: {SHOW}")
    return lines
