"""Resource budgets: parsing, and when a process is over its budget."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.errors import UsageError
from launcher.run.monitor.budget_parser import parse_words
from launcher.run.monitor.budgets import Budget, BudgetAction, Judge
from launcher.run.monitor.resources import Sample

MB = 1024**2


def sample(pid: int = 7, **used: float | None) -> Sample:
    usage = {"cpu_percent": 1.0, "uss_bytes": MB, "threads": 3, "fds": 9, **used}
    return Sample(pid=pid, rss_bytes=2 * MB, processes=1, **usage)


# ---- judging


def test_a_process_over_its_budget_for_long_enough_is_reported_once():
    judge = Judge([Budget(pattern="robot_*", memory_bytes=10 * MB, for_s=5.0)])
    used = {"robot_2-4": sample(uss_bytes=11 * MB)}
    told = {now: judge.judge(used, float(now)) for now in range(10)}
    assert [now for now, verdicts in told.items() if verdicts] == [5]
    assert str(told[5][0]) == (
        "robot_2-4 uses 11.0 MiB (USS), more than its budget of 10.0 MiB (USS), for 5 s now"
    )


def test_a_moment_below_the_limit_begins_the_count_anew():
    judge = Judge([Budget(pattern="*", cpu_percent=80.0, for_s=2.0)])
    loads = [90.0, 90.0, 80.0, 90.0, 90.0, 90.0]
    told = [judge.judge({"a": sample(cpu_percent=x)}, float(t)) for t, x in enumerate(loads)]
    assert [len(verdicts) for verdicts in told] == [0, 0, 0, 0, 0, 1]


def test_a_node_has_its_budget_by_its_own_name_too():
    judge = Judge([Budget(pattern="robot_2", fds=10, for_s=0)])
    over = {"robot-4": sample(fds=11)}
    assert judge.judge(over, 0.0, {"robot-4": ["robot", "/robot_1", "robot_1"]}) == []
    assert len(judge.judge(over, 1.0, {"robot-4": ["robot", "/robot_2", "robot_2"]})) == 1


@pytest.mark.parametrize("gap", [{}, {"a": sample(pid=8, threads=50)}], ids=["gone", "restarted"])
def test_a_restarted_process_is_judged_anew(gap: dict[str, Sample]):
    judge = Judge([Budget(pattern="a", threads=10, for_s=2.0)])
    over = {"a": sample(pid=7, threads=50)}
    told = [judge.judge(used, float(t)) for t, used in enumerate([over, gap, over, over, over])]
    assert [len(verdicts) for verdicts in told] == [0, 0, 0, 0, 1]


def test_each_budget_and_each_limit_is_judged_by_itself():
    judge = Judge(
        [
            Budget(pattern="a", fds=8, threads=2, for_s=0.0),
            Budget(pattern="*", fds=5, for_s=0.0, action=BudgetAction.STOP_RUN),
            Budget(pattern="b", fds=1, for_s=0.0),
        ]
    )
    told = judge.judge({"a": sample()}, 0.0)
    assert [(v.resource, v.limit, v.action.value) for v in told] == [
        ("threads", 2, "warn"),
        ("fds", 8, "warn"),
        ("fds", 5, "stop-run"),
    ]


def test_an_unknown_value_is_not_over_budget():
    judge = Judge([Budget(pattern="*", cpu_percent=0.0, memory_bytes=0, for_s=0.0)])
    assert judge.judge({"a": sample(cpu_percent=None, uss_bytes=None)}, 0.0) == []


@pytest.mark.parametrize(
    ("pattern", "covered"),
    [
        ("robot_2", {"robot_2-4"}),
        ("robot_*", {"robot_2-4", "robot_2-arm-5"}),
        ("robot_2-4", {"robot_2-4"}),
        ("robot_2-arm", {"robot_2-arm-5"}),
        ("Robot_2", set()),
    ],
)
def test_a_pattern_names_processes_with_or_without_their_number(pattern: str, covered: set[str]):
    budget = Budget(pattern=pattern)
    assert {name for name in ("robot_2-4", "robot_2-arm-5") if budget.covers(name)} == covered


@given(
    fds=st.lists(st.integers(0, 6), min_size=1, max_size=40),
    steps=st.lists(st.integers(0, 3), min_size=40, max_size=40),
    for_s=st.integers(0, 6),
)
def test_there_is_exactly_one_verdict_per_period_over_the_limit(fds, steps, for_s):
    judge = Judge([Budget(pattern="a", fds=3, for_s=float(for_s))])
    now, since, expected, told = 0, None, [], []
    for value, step in zip(fds, steps):  # noqa: B905  (steps are spare)
        now += step
        if value <= 3:
            since = None
        elif since is None:
            since, is_told = now, False
        if since is not None and not is_told and now - since >= for_s:
            is_told = True
            expected.append(now)
        told += [now for _ in judge.judge({"a": sample(fds=value)}, float(now))]
    assert told == expected


# ---- reading


def test_an_option_holds_a_whole_budget():
    (budget,) = parse_words(["robot_*:memory=200M,cpu=80%,threads=40,fds=100,for=2.5,action=stop"])
    assert budget == Budget(
        pattern="robot_*",
        cpu_percent=80.0,
        memory_bytes=200 * MB,
        threads=40,
        fds=100,
        for_s=2.5,
        action=BudgetAction.STOP_RUN,
    )


@pytest.mark.parametrize(
    ("text", "size_bytes"),
    [("0", 0), ("512", 512), ("1.5K", 1536), ("2m", 2 * MB), ("1GiB", 1024 * MB), ("3 MB", 3 * MB)],
)
def test_bytes_may_have_a_unit(text: str, size_bytes: int):
    assert parse_words([f"a:memory={text}"])[0].memory_bytes == size_bytes


@pytest.mark.parametrize(
    ("word", "message", "hint"),
    [
        ("robot_1", "invalid budget", "PATTERN:KEY=VALUE"),
        (":cpu=1", "invalid budget", "PATTERN:KEY=VALUE"),
        ("a:cpu", "has no value", "cpu=80%"),
        ("a:memroy=1M", "unknown key 'memroy'", "did you mean 'memory'?"),
        ("a:xyz=1", "unknown key 'xyz'", "cpu, memory, threads, fds, for, action"),
        ("a:memory=1T", "invalid value '1T' for 'memory'", "200M"),
        ("a:memory=" + "9" * 400, "for 'memory'", "200M"),
        ("a:cpu=-1", "invalid value '-1' for 'cpu'", "percent of one core"),
        ("a:cpu=nan", "invalid value 'nan' for 'cpu'", "percent of one core"),
        ("a:threads=1.5", "invalid value '1.5' for 'threads'", "whole number"),
        ("a:cpu=1,for=soon", "invalid value 'soon' for 'for'", "seconds"),
        ("a:cpu=1,action=restrat", "invalid value 'restrat'", "did you mean 'restart'?"),
        ("a:cpu=1,cpu=2", "'cpu' is given twice", ""),
        ("a:for=10", "no limit for 'a'", "memory=200M"),
    ],
)
def test_a_wrong_option_value_is_reported_with_the_correct_form(word: str, message: str, hint: str):
    with pytest.raises(UsageError) as caught:
        parse_words([word])
    assert message in caught.value.message
    assert hint in (caught.value.hint or "")


@given(st.text())
def test_any_option_value_is_read_or_a_clean_error(text: str):
    try:
        (budget,) = parse_words([text])
    except UsageError:
        return
    assert text.startswith(f"{budget.pattern}:")
