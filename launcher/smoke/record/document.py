"""The text of a recorded file of expectations."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from launcher.base.errors import LauncherError
from launcher.base.text import count, escape
from launcher.base.yaml_dumper import Dumper
from launcher.smoke.expect.expectation import Decision, Expectation
from launcher.smoke.expect.script import Script
from launcher.smoke.judges import judge
from launcher.smoke.preflight import forecast, script_checks
from launcher.smoke.preflight.forecast import Forecast
from launcher.smoke.preflight.loader import parse_entry
from launcher.smoke.record.entries import sections
from launcher.smoke.record.recorded_runs import RecordedExpectation, Runs, limit_s, note

WIDTH = 100
MORE_S, TIMES_SLOWER = 1.0, 1.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """What the file says besides the expectations; `arguments` and `options` of the launch."""

    target: str
    arguments: Mapping[str, str]
    options: Sequence[str]
    for_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Document:
    """`expected` and `left_out` are numbers of expectations."""

    text: str
    expected: int
    left_out: int


def document_of(runs: Runs, head: Head, foreseen: Forecast | None = None) -> Document:
    lines = [*_head_lines(runs, head), "", "expect:"]
    expected = left_out = 0
    for title, entries in sections(runs):
        kept = [_checked(entry, runs, foreseen) for entry in entries]
        lines += [*([""] if expected or left_out else []), f"  # --- {title}"]
        lines += [line for entry in kept for line in _entry_lines(entry)]
        expected += sum(bool(entry.values) for entry in kept)
        left_out += sum(not entry.values for entry in kept)
    text = "\n".join([*lines, ""])
    return Document(text=text, expected=expected, left_out=left_out)


def _head_lines(runs: Runs, head: Head) -> Iterator[str]:
    day = time.strftime("%Y-%m-%d")
    watched = f"{count(len(runs), 'run')}, each watched for {head.for_s:g} s"
    yield f"# Expectations of {head.target}, recorded on {day} from {watched}."
    yield "# The comments say what was seen. What differed between the runs is left out, with the"
    yield "# reason, or has a wide limit. Tighten what matters, and remove what does not."
    if head.arguments:
        yield f"arguments: {_flow(dict(head.arguments))}"
    if head.options:
        yield f"options: {_flow(list(head.options))}"
    yield f"for: {_for_s(runs, head):g} s"
    yield f"ready_within: {limit_s([run.begin_s for run in runs]):g} s"


def _for_s(runs: Runs, head: Head) -> float:
    """Longer where something comes after all nodes and topics, as a process without a node."""
    more_s = max(run.begin_s - run.presence_s for run in runs)
    return head.for_s + (math.ceil(TIMES_SLOWER * more_s) if more_s >= MORE_S else 0.0)


def _flow(value: Any) -> str:
    """As YAML in one line."""
    text: str = yaml.dump(
        value,
        Dumper=Dumper,
        default_flow_style=True,
        sort_keys=False,
        allow_unicode=True,
        width=float("inf"),
    )
    return text.strip()


def _entry_lines(entry: RecordedExpectation) -> Iterator[str]:
    seen = escape(entry.seen, keep="")
    if not entry.values:
        yield f"  # left out: {seen}"
        return
    line = f"  - {_flow(dict(entry.values))}"
    if seen and len(line) + len(seen) + 4 <= WIDTH:
        yield f"{line}  # {seen}"
        return
    if seen:
        yield f"  # {seen}"
    if len(line) <= WIDTH:
        yield line
        return
    for number, item in enumerate(entry.values.items()):
        yield f"  {' ' if number else '-'} {_flow(dict([item]))[1:-1]}"


# ---- the check of what is written


def _checked(
    entry: RecordedExpectation, runs: Runs, foreseen: Forecast | None
) -> RecordedExpectation:
    """The entry, or why it is left out: each run must meet what is recorded from it."""
    if not entry.values:
        return entry
    kind, subject = next(iter(entry.values.items()))
    try:
        expectation = parse_entry(dict(entry.values), "recorded")
    except LauncherError as error:
        return note(f"{kind} {subject}: {error.message}")
    script = Script(expectations=(expectation,))
    errors = [*script_checks.of_script(script).errors]
    if foreseen is not None:
        errors += forecast.compare(script, foreseen).errors
    if errors:
        return note(f"{kind} {subject}: {errors[0].message}")
    for run in runs:
        verdict = judge(expectation, run.as_judged())
        if not _is_asked(expectation) and verdict.outcome is not Decision.MET:
            return note(f"{kind} {subject}: {verdict.seen}")
    return entry


def _is_asked(expectation: Expectation) -> bool:
    """Whether its judge needs an answer, which a recorded run has got in another way."""
    return expectation.kind == "service" and expectation.get("call") is not False
