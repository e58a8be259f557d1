"""Whether an expectation holds in this moment, by the judges of smoke on the facts of it."""

from __future__ import annotations

import re
from dataclasses import replace

from launcher.faults.checks.check import ExpectationCheck, absence
from launcher.faults.model.fault import FaultFinding
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import Story
from launcher.smoke.expect.expectation import START, Decision, Expectation, Verdict
from launcher.smoke.judges import judge
from launcher.smoke.observe.facts import Facts, GraphSeen, QueryAnswer, matches

_NEVER = re.compile("never; known nodes: .*")  # which may include it, if its process is gone
STALE_S = 22.0  # an answer that is older says nothing of now


class GraphCheck(ExpectationCheck):
    """Kinds about the ROS graph: it holds if it does in the last graph."""

    debounce = Debounce(confirm_s=0.7, heal_s=3.0)

    def __init__(self, expectation: Expectation) -> None:
        # Whatever the time was until it had to hold: now it does, or does not.
        self._now = replace(expectation, within=None, after=START)
        self._holds = Decision.OPEN if expectation.get("absent") else Decision.MET
        super().__init__(expectation, judge(self._now, Facts()).expected)
        self._good_graph: GraphSeen | None = None  # in which it holds

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        graph = story.graph
        if graph is None:
            return False, None
        if graph is self._good_graph:
            return True, None
        verdict = self._verdict(story)
        if verdict.outcome is not self._holds:
            return True, self._finding(story, verdict)
        self._good_graph = graph
        return True, None

    def _verdict(self, story: Story) -> Verdict:
        assert story.graph is not None
        seen = replace(story.graph, at_s=story.now_s)
        names = {row["name"]: tuple(row["node_names"]) for row in story.rows}
        facts = Facts(
            now_s=story.now_s,
            graphs=(seen,),
            events=tuple(story.events),
            steps={START: story.now_s},
            node_names=names,
        )
        return judge(self._now, facts)

    def _finding(self, story: Story, verdict: Verdict) -> FaultFinding:
        subject = str(self.expectation.subject)
        if self.expectation.kind == "node":
            processes = story.processes_of([subject])
            nodes: tuple[str, ...] = (subject,)
            topics: tuple[str, ...] = ()
        else:
            nodes = story.publishers(subject)
            processes, topics = story.processes_of(nodes), (subject,)
        return FaultFinding(
            seen=_NEVER.sub("it is not there", verdict.seen),
            processes=processes,
            nodes=nodes,
            topics=topics,
            guess=verdict.guess,
        )


class AnswerCheck(ExpectationCheck):
    """A parameter, by the last answer of its node, which `parameter_watch` asks for."""

    debounce = Debounce(confirm_s=1.0, heal_s=2.0)

    def __init__(self, expectation: Expectation) -> None:
        self._now = replace(expectation, within=None, after=START)
        super().__init__(expectation, judge(self._now, Facts()).expected)
        self._last: QueryAnswer | None = None
        self._good_answer: QueryAnswer | None = None  # with which it holds

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        node = str(self.expectation.get("node"))
        answers = story.facts.answers.get(self.expectation.key, ())
        if answers:
            self._last = answers[-1]
        if self._last is None and story.document and not story.has_node(node):
            return True, FaultFinding(seen=f"there is no node {node}", nodes=(node,))
        if self._last is None or story.now_s - self._last.at_s > STALE_S:
            return False, None
        if self._last is self._good_answer:
            return True, None
        facts = Facts(
            now_s=story.now_s,
            answers={self.expectation.key: (replace(self._last, at_s=story.now_s),)},
            steps={START: story.now_s},
        )
        verdict = judge(self._now, facts)
        if verdict.outcome is Decision.MET:
            self._good_answer = self._last
            return True, None
        if self._last.error is not None:
            return False, None  # whether the node is still there is another question
        return True, FaultFinding(
            seen=f"{self.expectation.subject} is {self._last.value!r}",
            nodes=(node,),
            processes=story.processes_of([node]),
        )


class ProcessCheck(ExpectationCheck):
    """A process that is expected to run: it does, or will after a restart in a moment."""

    debounce = Debounce(confirm_s=1.0, heal_s=2.0)

    def __init__(self, expectation: Expectation) -> None:
        super().__init__(expectation, f"process {expectation.subject} runs")

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        pattern = str(self.expectation.subject)
        if (absent := absence(pattern, story)) is not None:
            return True, absent
        rows = [r for r in story.rows if matches(pattern, r["name"], tuple(r["node_names"]))]
        if not rows:
            return False, None
        bad = [row for row in rows if row["state"] not in ("RUNNING", "STARTING")]
        if not bad:
            return True, None
        names = tuple(str(row["name"]) for row in bad)
        text = ", ".join(f"{row['name']} {_state_text(row['state'])}" for row in bad)
        return True, FaultFinding(seen=text, processes=names)


def _state_text(state: str) -> str:
    return "has exited" if state == "EXITED" else f"is {state.lower()}"
