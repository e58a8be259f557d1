"""What is due when messages have some time."""

from __future__ import annotations

from launcher.bag.ros.record_services import MessageTimes

PUBLISH, RECEIVE = 1, 2


def test_what_is_due_is_done_once():
    times, done = MessageTimes(), []
    times.when("split", "/a", RECEIVE, 10, lambda: done.append("split"))
    times.note("/b", 20, 20)
    times.note("/a", 20, 9)
    assert done == []
    times.note("/a", 9, 10)
    times.note("/a", 11, 12)
    assert done == ["split"]


def test_a_time_that_has_passed_is_due_at_once():
    times, done = MessageTimes(), []
    times.note("/a", 5, 6)
    times.when("split", "", RECEIVE, 6, lambda: done.append("any"))
    times.when("split", "/a", PUBLISH, 5, lambda: done.append("a"))
    times.when("split", "/b", PUBLISH, 5, lambda: done.append("b"))
    assert done == ["any", "a"]
    times.clear()
    times.note("/b", 9, 9)
    assert done == ["any", "a"]


def test_the_newer_request_of_a_kind_counts():
    times, done = MessageTimes(), []
    times.when("split", "", PUBLISH, 5, lambda: done.append("old"))
    times.when("resume", "", PUBLISH, 5, lambda: done.append("resume"))
    times.when("split", "", PUBLISH, 6, lambda: done.append("new"))
    times.note("/a", 5, 5)
    assert done == ["resume"]
    times.note("/a", 6, 6)
    assert done == ["resume", "new"]
