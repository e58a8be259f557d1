"""A suspicion is confirmed by time or count, and heals."""

from __future__ import annotations

from launcher.faults.model.fault_life import Debounce, FaultChange, FaultLife, FaultState


def test_what_lasts_is_confirmed_and_heals_when_it_has_held_long_enough():
    life = FaultLife(Debounce(confirm_s=1.0, heal_s=3.0))

    assert life.violated(10.0) is FaultChange.SUSPECTED
    assert life.violated(10.9) is None
    assert life.violated(11.0) is FaultChange.CONFIRMED
    assert (life.first_s, life.confirmed_s, life.count) == (10.0, 11.0, 1)
    assert life.held(12.0) is None
    assert life.violated(13.0) is None  # one fault, and not two
    assert life.held(15.9) is None
    assert life.held(16.0) is FaultChange.HEALED
    assert (life.last_s, life.healed_s, life.state) == (13.0, 16.0, FaultState.HEALED)


def test_what_is_seen_once_is_dismissed():
    life = FaultLife(Debounce(confirm_s=1.0))
    life.violated(10.0)

    assert life.held(10.5) is FaultChange.DISMISSED
    assert (life.state, life.count) == (None, 0)
    assert life.violated(11.2) is FaultChange.SUSPECTED  # the time counts anew
    assert life.violated(12.1) is None


def test_it_may_come_again_and_a_suspicion_of_it_be_dismissed():
    life = FaultLife(Debounce(confirm_s=1.0, heal_s=1.0))
    for now_s in (1.0, 2.0):
        life.violated(now_s)
    life.held(3.0)

    assert life.violated(10.0) is FaultChange.SUSPECTED
    assert life.held(10.5) is FaultChange.DISMISSED
    assert life.state is FaultState.HEALED
    life.violated(20.0)
    assert life.violated(21.0) is FaultChange.CONFIRMED
    assert (life.count, life.first_s) == (2, 20.0)


def test_a_count_and_certainty_need_no_time():
    counted = FaultLife(Debounce(times=3))
    assert counted.violated(1.0, times=2) is FaultChange.SUSPECTED
    assert counted.violated(1.0, times=1) is FaultChange.CONFIRMED

    assert FaultLife(Debounce()).violated(1.0, certain=True) is FaultChange.CONFIRMED


def test_it_counts_from_when_it_began():
    life = FaultLife(Debounce(confirm_s=1.0))

    assert life.violated(10.0, since_s=8.5) is FaultChange.CONFIRMED
    assert life.first_s == 8.5
