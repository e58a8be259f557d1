"""How many lines a client of `logs` gets in a flood."""

from __future__ import annotations

from launcher.control.log_followers import BURST_S, LineAllowance

RATE = 100


def test_what_stays_below_the_rate_is_all_sent():
    allowance = LineAllowance(RATE)

    assert all(allowance.take("robot", 1, index / RATE) for index in range(10 * RATE))
    assert allowance.left_out() == {}


def test_a_burst_is_sent_and_a_flood_is_not():
    allowance = LineAllowance(RATE)
    sent = sum(allowance.take("robot", 1, index / 5000) for index in range(50_000))  # 10 s

    assert RATE * 10 <= sent <= RATE * (10 + BURST_S) + 1
    assert allowance.left_out() == {"robot": 50_000 - sent}
    assert not allowance.has_left_out


def test_each_process_has_its_own():
    allowance = LineAllowance(RATE)
    while allowance.take("flood", 100, 0.0):
        pass

    assert allowance.take("quiet", 1, 0.0)
    assert allowance.left_out() == {"flood": 100}


def test_a_large_block_is_sent_whole_and_paid_later():
    allowance = LineAllowance(RATE)

    assert allowance.take("robot", 10 * RATE, 0.0)
    assert not allowance.take("robot", 1, 0.9)
    assert allowance.take("robot", 1, 1.1)
