"""The expectations that all recorded runs meet, by sections of the file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from launcher.smoke.expect.expectation import Decision, Expectation
from launcher.smoke.expect.message_conditions import Fields, json_of, values_at
from launcher.smoke.judges.common import shorten
from launcher.smoke.judges.run import clean_shutdown
from launcher.smoke.observe.facts import LogLine, ObservedMessage
from launcher.smoke.record import topic_expectations
from launcher.smoke.record.name_patterns import is_pattern
from launcher.smoke.record.observed_run import SEND_GOAL, ObservedRun
from launcher.smoke.record.recorded_runs import (
    RecordedExpectation,
    Runs,
    after_text,
    note,
    rounded_up_s,
    within,
)
from launcher.smoke.record.timeliness_expectations import timeliness
from launcher.smoke.record.topic_expectations import MANY_MESSAGES, names_of
from launcher.smoke.record.watched_run import GET_STATE

EARLY = 0.6  # of the watched time: what comes later may come after the end of another run
MEMORY_FACTOR, MEMORY_MORE_MB, MEMORY_STEP_MB = 1.5, 20.0, 10
_MB = 1024 * 1024
LEAST_STOP_S, STOP_FACTOR = 10.0, 3.0
SHOWN = 60  # characters of a line
_OF_LIFECYCLE = "lifecycle_msgs/srv/"


def sections(runs: Runs) -> Iterator[tuple[str, list[RecordedExpectation]]]:
    """Title and entries of each section that has any."""
    for title, make in _SECTIONS.items():
        found = list(make(runs))
        if found:
            yield title, found


# ---- nodes and processes


def _nodes(runs: Runs) -> Iterator[RecordedExpectation]:
    for name in runs.nodes.common():
        times_s = [
            min(run.node_since(node) for node in run.nodes if runs.nodes.of(node, number) == name)
            for number, run in enumerate(runs)
        ]
        several = max(run.nodes[name] for run in runs)
        seen = after_text(times_s) + (f", {several} nodes of this name" if several > 1 else "")
        yield RecordedExpectation({"node": name, "within": within(times_s)}, seen)
    for name in runs.nodes.missing():
        yield note(f"{name}: not in every run")


def _of_label(name: str, runs: Runs) -> list[tuple[ObservedRun, str]]:
    """(run, label) of the processes of this label or pattern."""
    return [
        (run, label)
        for number, run in enumerate(runs)
        for label in run.processes
        if runs.labels.of(label, number) == name
    ]


def _processes(runs: Runs) -> Iterator[RecordedExpectation]:
    names = runs.labels.common()
    alive = [
        name for name in names if all(run.are_alive(one) for run, one in _of_label(name, runs))
    ]
    if alive == names and not runs.labels.missing():
        counts = " and ".join(dict.fromkeys(str(len(run.facts.processes())) for run in runs))
        yield RecordedExpectation({"process": "*", "alive": True}, f"{counts} processes")
        return
    for name in names:
        yield (
            RecordedExpectation({"process": name, "alive": True}, "")
            if name in alive
            else _ended(name, runs)
        )
    for name in runs.labels.missing():
        yield note(f"{name}: not in every run")


def _ended(name: str, runs: Runs) -> RecordedExpectation:
    found = _of_label(name, runs)
    if any(run.was_restarted(label) for run, label in found):
        return note(f"{name}: it was restarted")
    ends = [(run, run.ended_s(label)) for run, label in found]
    times_s = [end_s for _, end_s in ends if end_s is not None]
    if len(times_s) < len(ends) or any(_is_late(run, end_s or 0.0) for run, end_s in ends):
        return note(f"{name}: it exited late or not in every run")
    return RecordedExpectation(
        {"process": name, "exits": 0}, after_text(times_s).replace("seen", "exited")
    )


def _is_late(run: ObservedRun, at_s: float) -> bool:
    """Unless the system ended by itself, which it does whenever its processes have exited."""
    ending = run.facts.ending
    was_stopped = ending is not None and ending.asked_s is not None
    return was_stopped and at_s > _early_until_s(run)


def _early_until_s(run: ObservedRun) -> float:
    """From the begin of the watched time: the start takes longer on a busy machine."""
    return run.begin_s + EARLY * run.for_s


def _memory(runs: Runs) -> Iterator[RecordedExpectation]:
    for name in runs.labels.common():
        found = _of_label(name, runs)
        if any(run.measured_s(label) > _early_until_s(run) for run, label in found):
            continue  # it exited before it was measured, or the run was too short
        most_mb = max(run.memory_bytes(label) for run, label in found) / _MB
        limit = MEMORY_STEP_MB * math.ceil(
            (MEMORY_FACTOR * most_mb + MEMORY_MORE_MB) / MEMORY_STEP_MB
        )
        yield RecordedExpectation(
            {"memory": name, "below": f"{limit} MB"}, f"seen {most_mb:.0f} MB at most"
        )


def _lines(runs: Runs) -> Iterator[RecordedExpectation]:
    for name in runs.labels.common():
        by_run = [
            [
                line
                for run, label in _of_label(name, runs)
                if run is one
                for line in run.lines(label)
            ]
            for one in runs
        ]
        if not all(by_run):
            continue  # it printed nothing
        ready = readiness(by_run)
        if ready is None:
            yield note(f"{name}: no first line that every run has")
            continue
        pattern, first = ready
        times_s = [max(0.0, line.at_s) for line in first]
        if any(line.at_s > _early_until_s(run) for line, run in zip(first, runs, strict=True)):
            yield note(f"{name}: its first line came late")
            continue
        values = {"log": pattern, "process": name, "within": within(times_s)}
        yield RecordedExpectation(
            values, f"{after_text(times_s)}: {shorten(message(first[0]), SHOWN)}"
        )


# ---- services


def _services(runs: Runs) -> Iterator[RecordedExpectation]:
    names = runs.services.common()
    for name in names:
        if is_pattern(name):
            yield note(f"{name}: another name in each run")
            continue
        types = {one for run in runs for one in run.services[name]}
        entry = _state(name, types, runs)
        if entry is not None:
            yield entry
        elif not _is_of_known_lifecycle(name, types, runs):
            values: dict[str, Any] = {"service": name}
            if len(types) == 1 and not name.endswith(SEND_GOAL):
                values["type"] = next(iter(types))
            times_s = [run.service_since(name) for run in runs]
            values |= {"call": False, "within": within(times_s)}
            yield RecordedExpectation(values, after_text(times_s))
    for name in runs.services.missing():
        yield note(f"{name}: not in every run")


def _state(name: str, types: set[str], runs: Runs) -> RecordedExpectation | None:
    """The state of a lifecycle node; to ask for it has no effect."""
    states = {run.states.get(name) for run in runs}
    if GET_STATE not in types or len(states) != 1 or None in states:
        return None
    state = states.pop()
    values = {
        "service": name,
        "type": GET_STATE,
        "where": f"m.current_state.label == '{state}'",
        "within": within([run.begin_s for run in runs]),
    }
    return RecordedExpectation(values, f"the lifecycle node was {state}")


def _is_of_known_lifecycle(name: str, types: set[str], runs: Runs) -> bool:
    """Whether it is one of the services of a lifecycle node whose state is expected."""
    node = name.rpartition("/")[0]
    is_known = all(f"{node}/get_state" in run.states for run in runs)
    return is_known and all(one.startswith(_OF_LIFECYCLE) for one in types)


# ---- errors and the end


def _end(runs: Runs) -> Iterator[RecordedExpectation]:
    yield RecordedExpectation({"no_errors": "*"}, "")
    yield RecordedExpectation({"no_tracebacks": "*"}, "")
    took_s = [run.facts.ending.down_s - run.facts.stop_s for run in runs if run.facts.ending]
    limit_s = rounded_up_s(max(LEAST_STOP_S, STOP_FACTOR * max(took_s)))
    if all(_stops_cleanly(run, limit_s) for run in runs):
        seen = " and ".join(dict.fromkeys(f"{time_s:.1f}" for time_s in took_s))
        yield RecordedExpectation({"clean_shutdown": f"{limit_s:g} s"}, f"seen {seen} s")
    else:
        yield note("clean_shutdown: a process needed more than the first signal")
    if all(run.facts.ending is not None and not run.facts.ending.left_memory for run in runs):
        yield RecordedExpectation({"shared_memory": "clean"}, "")


def _stops_cleanly(run: ObservedRun, limit_s: float) -> bool:
    wanted = Expectation(kind="clean_shutdown", subject=limit_s)
    return clean_shutdown(wanted, run.facts).outcome is Decision.MET


def identities(runs: Runs) -> Iterator[RecordedExpectation]:
    """`unique`, for fields that are called an id; numbers and times may not repeat by chance."""
    for name in names_of(runs):
        received = [run.facts.received(name) for run in runs]
        if min(map(len, received)) < MANY_MESSAGES:
            continue
        for field in _ids(received[0][0].content):
            if all(_are_unique(messages, field) for messages in received):
                numbers = " and ".join(str(len(messages)) for messages in received)
                yield RecordedExpectation(
                    {"unique": name, "key": field}, f"seen {numbers} messages"
                )


def _ids(content: object) -> list[str]:
    parts = (part for part in (content, json_of(content)) if isinstance(part, Mapping | Fields))
    fields = dict.fromkeys(name for part in parts for name in part)
    return [str(name) for name in fields if str(name).lower().endswith("id")]


def _are_unique(messages: Sequence[ObservedMessage], field: str) -> bool:
    try:
        values = [values_at(message.content, [field])[0] for message in messages]
    except LookupError:
        return False
    is_plain = all(isinstance(value, str | int) for value in values)
    return is_plain and len(set(values)) == len(values)


SEARCHED = 50  # lines of each process
MIN_LETTERS = 6  # fewer are in any line
# `[INFO] [1795229956.758952768] [robot_3]: ` of rclpy and rclcpp.
_HEAD = re.compile(r"^\[(?:DEBUG|INFO)\] \[[\d.]+\] \[[^\]]*\]: |^\[[\d.]+\] \[[^\]]*\]: ")
_READY = re.compile(
    r"\b(?:ready|started|starting up|initiali[sz]ed|listening|running|configured|activated|active"
    r"|connected|loaded|online|up)\b",
    re.IGNORECASE,
)
# What may be another one in the next run: a word with a digit, a quotation, a value.
_VARYING = re.compile(r"""\S*\d\S*|["'`{(\[<=].*""")


def readiness(runs: Sequence[Sequence[LogLine]]) -> tuple[str, list[LogLine]] | None:
    """A regular expression and the line of each run that it matches first.

    The first line that says `ready` or the like, or else the first one at all, that every run has.
    """
    found = [dict(_texts(lines)) for lines in runs]
    if not found:
        return None
    common = [text for text in found[0] if all(text in other for other in found)]
    text = next((one for one in common if _READY.search(one)), next(iter(common), None))
    if text is None:
        return None
    pattern = re.sub(r"\\([ \-/:#&~])", r"\1", re.escape(text))  # where it need not be escaped
    return pattern, [texts[text] for texts in found]


def _texts(lines: Sequence[LogLine]) -> Iterator[tuple[str, LogLine]]:
    """The constant beginning of each line, and the first line that has it."""
    seen: set[str] = set()
    for line in lines[:SEARCHED]:
        text = constant(line)
        if text is not None and text not in seen:
            seen.add(text)
            yield text, line


def message(line: LogLine) -> str:
    """What the node said, without level, time and name."""
    return _HEAD.sub("", line.plain)


def constant(line: LogLine) -> str | None:
    """The part of the message before what may vary; None if it says too little, or a warning."""
    if line.level not in (None, "INFO", "DEBUG") or line.plain[:1].isspace():
        return None
    text = message(line)
    varying = _VARYING.search(text)
    text = (text if varying is None else text[: varying.start()]).strip()
    letters = sum(char.isalpha() for char in text)
    return text if letters >= MIN_LETTERS and "Traceback" not in text else None


_SECTIONS: Mapping[str, Callable[[Runs], Iterator[RecordedExpectation]]] = {
    "nodes": _nodes,
    "processes": _processes,
    "topics": topic_expectations.topics,
    "quality of service": topic_expectations.qualities,
    "rates": topic_expectations.rates,
    "gaps and latencies": timeliness,
    "ids that do not repeat": identities,
    "services": _services,
    "the first line that says that a process is ready": _lines,
    "memory": _memory,
    "errors and the end": _end,
}
