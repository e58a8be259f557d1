"""What the events of a run say about its processes."""

from __future__ import annotations

from tests.smoke.unit.facts import event, ready, running, started, unready


def test_a_process_that_others_hold_back_is_unready_until_it_is_started():
    first = (unready("a-1", 0.1), event("waiting", "b-2", 0.1))
    released = (ready("a-1", 7.0), event("released", "b-2", 7.0, why="ready"))
    later = started("b-2", at_s=7.1)
    assert running(1.0, events=first).unready() == ("a-1", "b-2")
    assert running(7.05, events=(*first, *released)).unready() == ("b-2",)
    assert running(8.0, events=(*first, *released, *later)).unready() == ()
    lacking = (*first, *released, unready("b-2", 7.1))
    assert running(8.0, events=lacking).unready() == ("b-2",)
