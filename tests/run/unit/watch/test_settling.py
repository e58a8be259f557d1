"""When changes of files are over, by a fake clock."""

from __future__ import annotations

from launcher.run.watch.folders import LONGEST_S, QUIET_S, Settling


def test_a_file_is_over_when_it_was_quiet_long_enough():
    settling = Settling()
    assert settling.due_s is None
    settling.note(["a"], 10.0)
    assert settling.due_s == 10.0 + QUIET_S
    assert settling.take(10.0 + QUIET_S / 2) == []
    settling.note(["a"], 10.1)
    assert settling.take(10.0 + QUIET_S) == []
    assert settling.take(10.1 + QUIET_S) == ["a"]
    assert settling.due_s is None


def test_many_files_are_over_together():
    settling = Settling()
    step_s = QUIET_S / 8
    for number in range(50):
        settling.note([str(number)], number * step_s)
        assert settling.take(number * step_s) == []
    assert len(settling.take(49 * step_s + QUIET_S)) == 50


def test_a_file_that_changes_for_ever_does_not_hold_up_the_others():
    settling = Settling()
    settling.note(["once"], 0.0)
    now, taken = 0.0, []
    while not taken and now < 2 * LONGEST_S:
        settling.note(["always"], now)
        now += QUIET_S / 2
        taken = settling.take(now)
    assert taken == ["once"]
    assert LONGEST_S <= now < 2 * LONGEST_S
    assert settling.busy == ["always"]
