"""What has just come, by the judges of smoke: lines that must not be printed, and messages that
all have to satisfy conditions.
"""

from __future__ import annotations

import re
from collections import deque
from dataclasses import replace

from launcher.faults.checks.check import ExpectationCheck
from launcher.faults.checks.message_times import MOST_WAITING
from launcher.faults.model.fault import FaultFinding
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import Story
from launcher.smoke.expect.expectation import START, Decision, Expectation, Verdict
from launcher.smoke.judges import judge
from launcher.smoke.judges.common import forget
from launcher.smoke.observe.facts import Facts, LogLine, ObservedMessage

HOLD_S = 0.3  # the last line of a traceback, which names the error, comes a moment later
MOST_LINES = 2000  # that are judged at once: more are left out in a flood


class LineCheck(ExpectationCheck):
    """`log` with `count: 0`, `no_errors`, `no_tracebacks`: none of the new lines is one."""

    debounce = Debounce(confirm_s=0.0, heal_s=5.0)

    def __init__(self, expectation: Expectation) -> None:
        self._now = replace(expectation, within=None, after=START)
        super().__init__(expectation, judge(self._now, Facts()).expected)
        self._waiting: deque[LogLine] = deque(maxlen=MOST_LINES)
        self._since_s = 0.0  # when the first of them was taken: the clock may be set meanwhile

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        # What the launcher itself reports of processes is another fault.
        if not self._waiting:
            self._since_s = story.now_s
        self._waiting.extend(line for line in story.facts.lines if line.process is not None)
        if not self._waiting or story.now_s - self._since_s < HOLD_S:
            return True, None
        lines = tuple(self._waiting)
        self._waiting.clear()
        first_s = min(line.at_s for line in lines)
        names = {row["name"]: tuple(row["node_names"]) for row in story.rows}
        facts = Facts(
            now_s=story.now_s,
            lines=lines,
            events=tuple(story.events),
            steps={START: min(first_s, story.now_s) - 1.0},
            node_names=names,
        )
        verdict = judge(self._now, facts)
        if verdict.outcome is not Decision.VIOLATED:
            return True, None
        return True, FaultFinding(
            seen=_without_time(verdict),
            processes=verdict.about,
            guess=verdict.guess,
            certain=True,
            settles=False,
            times=int(verdict.value or 1),
        )


class MessageCheck(ExpectationCheck):
    """`message` with `all`: each new message satisfies the conditions."""

    debounce = Debounce(times=1, heal_s=3.0)

    def __init__(self, expectation: Expectation) -> None:
        self._now = replace(expectation, within=None, after=START)
        super().__init__(expectation, judge(self._now, Facts()).expected)
        self._waiting: deque[ObservedMessage] = deque(maxlen=MOST_WAITING)

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        topic, watch = self.expectation.subject, self.expectation.get("watch")
        received = Facts(messages=story.facts.messages).received(topic, watch)
        self._waiting += received
        if not self._waiting:
            return False, None
        facts = Facts(
            now_s=story.now_s,
            messages=tuple(self._waiting),
            graphs=() if story.graph is None else (story.graph,),
            steps={START: min(m.at_s for m in self._waiting) - 1.0},
        )
        verdict = judge(self._now, facts)
        if verdict.outcome is Decision.OPEN and "being evaluated" in verdict.seen:
            return False, None  # the next look has the result
        last = self._waiting[-1]
        forget(self.expectation, [message.content for message in self._waiting])
        self._waiting.clear()
        if verdict.outcome is not Decision.VIOLATED:
            return True, None
        nodes = story.publishers(topic)
        return True, FaultFinding(
            seen=_reason(verdict),
            processes=story.processes_of(nodes),
            nodes=nodes,
            topics=(topic,),
            message=last.content,
        )


def _without_time(verdict: Verdict) -> str:
    """What was seen; `after 1.0 s` counts from the start of the look, which says nothing."""
    return _TIME.sub("", verdict.seen)


def _reason(verdict: Verdict) -> str:
    """Why a message is not as expected, without the message."""
    found = _REASON.search(verdict.seen)
    return found[1] if found else _without_time(verdict)


_TIME = re.compile(r"^(?:message )?(?:\d+[^a-z]*)?[a-z ]*after [^:]*: ")
_REASON = re.compile(r" \(([^()]*)\)$")
