"""Which processes wait for which, when they are ready, and what timeouts do: with a fake clock."""

from __future__ import annotations

import itertools
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.base.model.supervision import After, Fact, StartRule, circle
from launcher.run.ready.start_order import (
    Action,
    Circle,
    Expire,
    ReleaseStart,
    ReportReady,
    RestartWith,
    StartOrder,
)

LOG = Fact(kind="log", subject="up")
TOPIC = Fact(kind="publisher", subject="/fleet/tasks")


def spec(name: str, node: str | None = None) -> ProcessSpec:
    ros = None if node is None else RosIdentity(node_name=node)
    return ProcessSpec(name=name, label=name.rpartition("-")[0], argv=("x",), env={}, ros=ros)


def rule(
    pattern: str, *after: str, ready: tuple[Fact, ...] | None = None, **more: Any
) -> StartRule:
    given = {key: more.pop(key) for key in ("timeout_s", "on_timeout") if key in more}
    waits = After(names=after, **given) if after else None
    return StartRule(pattern=pattern, ready_when=ready, after=waits, **more)


class Run:
    """A run with a fake clock; `told` are the actions so far."""

    def __init__(self, *rules: StartRule, off: tuple[ProcessSpec, ...] = ()) -> None:
        self.order = StartOrder(rules, lambda: off)
        self.now = 100.0
        self.told: list[Action] = []

    def tell(self, actions: list[Action]) -> list[Action]:
        self.told += actions
        return actions

    def start(self, *names: str) -> None:
        """The launch file starts these processes."""
        for name in names:
            self.tell(self.order.add(spec(name)))
            if self.order.admit(name, self.now):
                self.runs(name)
        self.check()

    def runs(self, name: str) -> None:
        self.tell(self.order.started(name, self.now))

    def check(self) -> list[Action]:
        actions = self.order.check(self.now)
        for action in self.tell(actions):
            if isinstance(action, ReleaseStart):
                self.runs(action.name)
        if actions:
            self.check()
        return actions

    def fact(self, name: str, index: int = 0, *, holds: bool = True, text: str = "") -> None:
        self.tell(self.order.fact(name, index, self.now, holds=holds, text=text))
        self.check()

    def ends(
        self, name: str, code: int | None = 1, *, asked: bool = False, final: bool = True
    ) -> None:
        text = f"exit code {code}"
        self.tell(
            self.order.ended(name, self.now, code, text, asked=asked, final=final and not asked)
        )
        self.check()

    @property
    def waiting(self) -> list[str]:
        return [entry.name for entry in self.order.waiting]

    def kinds(self, kind: type) -> list[str]:
        return [action.name for action in self.told if isinstance(action, kind)]


def test_a_process_waits_until_another_is_ready():
    run = Run(rule("dispatcher", ready=(TOPIC,)), rule("robot_*", "dispatcher"))
    run.start("robot_1-1", "dispatcher-2", "robot_2-3", "monitor-4")
    assert run.waiting == ["robot_1-1", "robot_2-3"]
    assert run.order.reason("robot_1-1") == "dispatcher: no publisher on /fleet/tasks"
    run.now += 1.5
    run.fact("dispatcher-2")
    assert run.told == [
        ReportReady("dispatcher-2", 1.5),
        ReleaseStart("robot_1-1", 1.5),
        ReleaseStart("robot_2-3", 1.5),
    ]


def test_without_facts_a_process_is_ready_when_it_runs():
    run = Run(rule("b", "a"))
    run.start("b-1", "a-2")
    assert run.told == [ReleaseStart("b-1", 0.0)]


def test_all_facts_have_to_hold_in_any_order():
    run = Run(rule("a", ready=(TOPIC, LOG)), rule("b", "a"))
    run.start("a-1", "b-2")
    run.fact("a-1", 1)
    assert run.waiting == ["b-2"]
    assert run.order.reason("b-2") == "a: no publisher on /fleet/tasks"
    run.fact("a-1", 0)
    assert run.waiting == []


def test_what_is_seen_instead_of_a_fact_is_told():
    run = Run(rule("a", ready=(TOPIC,)), rule("b", "a"))
    run.start("a-1", "b-2")
    run.fact("a-1", holds=False, text="no publisher on /fleet/tasks, only of /other")
    assert run.order.reason("b-2") == "a: no publisher on /fleet/tasks, only of /other"
    assert run.order.reason("a-1") == "no publisher on /fleet/tasks, only of /other"


def test_a_pattern_means_all_that_the_launch_file_starts_at_once():
    run = Run(rule("late", "robot_*"), rule("robot_*", ready=(LOG,)))
    run.start("robot_1-1", "late-2", "robot_2-3")
    run.fact("robot_1-1")
    assert run.waiting == ["late-2"]
    run.fact("robot_2-3")
    assert run.waiting == []


def test_several_that_are_waited_for_are_counted():
    run = Run(rule("z", "a", "b", "c"), rule("?", ready=(LOG,)))
    run.start("z-1", "a-2", "b-3")
    assert run.order.reason("z-1") == "a: no line with 'up', and for 2 more"
    run.fact("a-2")
    assert run.order.reason("z-1") == "b: no line with 'up', and for c"


def test_who_waits_for_one_that_waits_is_told_so():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a"), rule("c", "b"))
    run.start("c-1", "b-2", "a-3")
    assert run.order.reason("c-1") == "b, which waits for a"
    run.fact("a-3")
    assert run.kinds(ReleaseStart) == ["b-2", "c-1"]


def test_one_that_is_about_to_be_released_waits_for_nothing():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a"), rule("c", "b"))
    run.start("c-1", "b-2", "a-3")
    run.tell(run.order.fact("a-3", 0, run.now, holds=True, text=""))  # before the next look
    assert run.order.reason("c-1") == "b: it has not been started"


def test_a_process_does_not_wait_for_itself():
    run = Run(rule("robot_*", "robot_1"))
    run.start("robot_2-1", "robot_1-2")
    assert run.kinds(ReleaseStart) == ["robot_1-2", "robot_2-1"]


# ---- timeouts


def test_after_the_timeout_its_consequence_is_due_once():
    for consequence in ("start", "fail", "stop-run"):
        run = Run(rule("a", ready=(LOG,)), rule("b", "a", timeout_s=5.0, on_timeout=consequence))
        run.start("a-1", "b-2")
        assert run.order.deadline == 105.0
        run.now = 104.9
        assert run.check() == []
        run.now = 105.0
        assert run.check() == [Expire("b-2", consequence, "a: no line with 'up'", 5.0)]
        assert run.order.deadline is None
        run.now = 300.0
        assert run.check() == []


def test_the_time_limit_begins_when_nobody_that_is_waited_for_waits_itself():
    run = Run(
        rule("a", ready=(LOG,)),
        rule("b", "a", ready=(LOG,), timeout_s=60.0),
        rule("c", "b", timeout_s=10.0),
    )
    run.start("a-1", "b-2", "c-3")
    assert run.order.deadline == 160.0
    run.now = 150.0
    assert run.check() == []
    run.fact("a-1")
    assert run.order.deadline == 160.0  # that of c, 10 s after the start of b
    run.now = 160.0
    assert [action.name for action in run.check()] == ["c-3"]


def test_one_that_ends_before_it_is_ready_is_not_waited_for():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a", on_timeout="fail"))
    run.start("a-1", "b-2")
    run.now += 1.0
    run.ends("a-1", 0)
    assert run.told == [Expire("b-2", "fail", "a: it has ended (exit code 0)", 1.0)]


def test_one_that_could_not_be_started_is_not_waited_for():
    run = Run(rule("b", "a"), rule("a", ready=(LOG,)))
    run.tell(run.order.add(spec("a-1")))
    run.order.admit("a-1", run.now)
    run.start("b-2")
    run.ends("a-1", None)
    assert run.kinds(Expire) == ["b-2"]


def test_one_that_is_restarted_or_was_stopped_by_a_user_is_waited_for_on():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a"))
    run.start("a-1", "b-2")
    run.ends("a-1", 1, final=False)
    assert run.order.reason("b-2") == "a: it has ended (exit code 1)"
    run.runs("a-1")
    run.ends("a-1", -2, asked=True)
    assert run.order.reason("b-2") == "a: it was stopped"
    run.runs("a-1")
    run.fact("a-1")
    assert run.kinds(ReleaseStart) == ["b-2"]


def test_one_that_has_done_its_work_need_not_run_any_more():
    run = Run(rule("b", "a"), rule("c", "a"))
    run.start("a-1")
    run.ends("a-1", 0)
    run.start("b-2")
    assert run.kinds(ReleaseStart) == ["b-2"]
    failed = Run(rule("b", "a"))
    failed.start("a-1")
    failed.ends("a-1", 1)
    failed.start("b-2")
    assert failed.kinds(Expire) == ["b-2"]


def test_an_exit_can_be_what_is_waited_for():
    done = Fact(kind="exit", subject="0")
    run = Run(rule("setup", ready=(done,)), rule("b", "setup"))
    run.start("setup-1", "b-2")
    assert run.order.reason("b-2") == "setup: it has not exited with code 0"
    run.now += 2.0
    run.ends("setup-1", 0)
    assert run.told == [ReportReady("setup-1", 2.0), ReleaseStart("b-2", 2.0)]
    failed = Run(rule("setup", ready=(done,)), rule("b", "setup"))
    failed.start("setup-1", "b-2")
    failed.ends("setup-1", 3)
    assert failed.kinds(Expire) == ["b-2"]


def test_a_name_that_no_process_has_is_waited_for_until_the_timeout():
    run = Run(rule("b", "dispacher", timeout_s=3.0))
    run.start("b-1", "dispatcher-2")
    assert run.order.reason("b-1") == "dispacher: it has not been started"
    run.now += 3.0
    assert [action.name for action in run.check()] == ["b-1"]


def test_a_process_that_a_condition_keeps_away_is_not_waited_for():
    run = Run(rule("b", "monitor", "a"), off=(spec("monitor-0"),))
    run.start("b-1", "a-2")
    assert run.kinds(ReleaseStart) == ["b-1"]


# ---- users


def test_a_start_by_a_user_does_not_wait():
    run = Run(rule("b", "a"))
    run.start("b-1")
    assert run.order.skip("b-1", run.now)
    assert run.waiting == []
    assert not run.order.skip("b-1", run.now)


def test_a_process_that_was_stopped_while_it_waited_is_released_by_nothing():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a"), rule("c", "b", timeout_s=5.0))
    run.start("a-1", "b-2", "c-3")
    assert run.order.withdraw("b-2")
    assert not run.order.withdraw("b-2")
    run.fact("a-1")
    assert run.kinds(ReleaseStart) == []
    assert run.order.reason("c-3") == "b: it was stopped"
    run.now += 5.0
    assert [action.name for action in run.check()] == ["c-3"]


# ---- restarts


def test_a_restarted_process_is_ready_again_and_its_start_waits_for_nobody():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a", ready=(LOG,)))
    run.start("a-1", "b-2")
    run.fact("a-1")
    run.fact("b-2")
    run.ends("a-1", 1, final=False)
    run.ends("b-2", 1, final=False)
    assert run.order["a-1"].ready_s is None
    assert run.order.admit("b-2", run.now)
    run.runs("b-2")
    assert run.order.reason("b-2") == "no line with 'up'"
    run.fact("b-2")
    assert run.kinds(ReportReady) == ["a-1", "b-2", "b-2"]


def test_a_fact_of_the_last_life_does_not_count():
    run = Run(rule("a", ready=(LOG, TOPIC)))
    run.start("a-1")
    run.fact("a-1", 0)
    run.ends("a-1", 1, final=False)
    run.fact("a-1", 1)  # told too late
    run.runs("a-1")
    run.fact("a-1", 1)
    assert run.kinds(ReportReady) == []


def test_a_process_is_restarted_when_another_is_ready_again():
    run = Run(rule("a", ready=(LOG,)), rule("b", restart_with=("a",)), rule("c"))
    run.start("a-1", "b-2", "c-3")
    run.fact("a-1")
    assert run.kinds(RestartWith) == []
    run.ends("a-1", 1, final=False)
    run.runs("a-1")
    assert run.kinds(RestartWith) == []
    run.fact("a-1")
    assert run.told[-1] == RestartWith("b-2", "a-1")
    assert run.kinds(RestartWith) == ["b-2"]


def test_only_a_running_process_is_restarted_with_another():
    run = Run(rule("b", restart_with=("a",)))
    run.start("a-1", "b-2")
    run.ends("b-2", 1)
    run.ends("a-1", 1, final=False)
    run.runs("a-1")
    assert run.kinds(RestartWith) == []


def test_a_process_that_was_started_after_the_one_it_follows_is_not_restarted():
    run = Run(
        rule("a", ready=(LOG,)), rule("b", restart_with=("a",)), rule("c", restart_with=("a",))
    )
    run.start("a-1", "b-2", "c-3")
    run.fact("a-1")
    run.ends("a-1", asked=True)
    run.ends("b-2", asked=True)
    run.now += 1.0
    run.runs("a-1")
    run.now += 1.0
    run.runs("b-2")
    run.fact("a-1")
    assert run.kinds(RestartWith) == ["c-3"]


# ---- reloads


def test_one_that_the_launch_file_does_not_have_any_more_is_not_waited_for():
    run = Run(rule("a", ready=(LOG,)), rule("b", "a"))
    run.start("a-1", "b-2")
    run.ends("a-1", asked=True)
    run.order.forget("a-1")
    assert not run.order.withdraw("a-1")
    run.check()
    assert run.kinds(ReleaseStart) == ["b-2"]


def test_names_and_facts_are_those_of_the_new_spec():
    fact = Fact(kind="node", subject="{node}")
    run = Run(rule("*", ready=(fact,)), rule("b", "new", ready=()))
    run.tell(run.order.add(spec("a-1", "old")))
    run.order.admit("a-1", run.now)
    run.runs("a-1")
    run.start("b-2")
    assert run.order.reason("b-2") == "new: it has not been started"
    run.tell(run.order.adopt(spec("a-1", "new")))
    assert run.order.reason("b-2") == "new: no node /new"
    run.runs("a-1")
    run.fact("a-1")
    assert run.kinds(ReleaseStart) == ["b-2"]


# ---- circles


def test_a_circle_that_a_late_process_closes_is_told_and_does_not_wait():
    run = Run(rule("*_a", "x_*"), rule("x_?", "*_a"))
    run.start("x_1-1", "y_a-2")
    assert run.told[0] == Circle("y_a-2", ("y_a-2", "x_1-1", "y_a-2"))
    assert run.kinds(ReleaseStart) == ["x_1-1"]


@given(
    st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=12),
    st.permutations(range(8)),
    st.lists(st.integers(0, 7), max_size=20),
)
def test_everything_starts_at_last_and_never_before_what_it_waits_for(pairs, arrival, ready):
    """Random graphs of waits, without circles, in random orders of start and of facts."""
    edges = {n: {b for a, b in pairs if a == n and b < n} for n in range(8)}
    rules = [
        rule(f"p{n}", *(f"p{one}" for one in sorted(edges[n])), ready=(LOG,)) for n in range(8)
    ]
    run = Run(*rules)
    run.start(*(f"p{n}-{n}" for n in arrival))
    for n in [*ready, *range(8)]:
        run.fact(f"p{n}-{n}")
    assert run.waiting == []
    order = [(type(action), int(action.name[1])) for action in run.told]
    for n, needed in edges.items():
        for one in needed:
            assert order.index((ReportReady, one)) < order.index((ReleaseStart, n))
    assert sorted(run.kinds(ReportReady)) == [f"p{n}-{n}" for n in range(8)]


@given(st.dictionaries(st.integers(0, 5), st.sets(st.integers(0, 5)), max_size=6))
def test_a_circle_is_found_if_there_is_one(graph):
    edges = {str(n): [str(one) for one in others] for n, others in graph.items()}
    found = circle(edges)
    left = {n: set(others) for n, others in edges.items()}
    while free := [n for n, others in left.items() if not others & left.keys()]:
        for n in free:
            del left[n]
    assert bool(found) == bool(left)
    assert all(b in edges[a] for a, b in itertools.pairwise(found))
