"""Stacks that a program tells itself, without py-spy."""

from __future__ import annotations

from launcher.run.stacks.warm_stacks import parse

ANSWER = """pid 7
thread 8 left
3 work\0/opt/arm.py
thread 0 -
thread 7 MainThread
12 spin\0/opt/my arm.py
1 <module>\0/opt/my arm.py
end 7
"""


def test_an_answer_is_found_between_those_of_others_the_main_thread_first():
    other = "pid 70\nthread 70 MainThread\nend 70\n"
    dump = parse(7, other + ANSWER + other)
    assert dump is not None
    assert [(one.tid, one.name) for one in dump.threads] == [
        (7, "MainThread"),
        (0, "-"),
        (8, "left"),
    ]
    assert dump.place == "spin (/opt/my arm.py:12)"
    assert [frame.function for frame in dump.threads[0].frames] == ["spin", "<module>"]


def test_half_an_answer_is_none():
    assert parse(7, ANSWER[:-6]) is None
    assert parse(70, ANSWER) is None
    assert parse(7, "") is None
