"""Rates of the last seconds, as the probe's request `traffic` gives them."""

from __future__ import annotations

import pytest

from launcher.ros.probe.topic_traffic import NANOS, Traffic


def received(*times_s: float, size_bytes: int = 100) -> Traffic:
    traffic = Traffic()
    for at_s in times_s:
        traffic.add(round(at_s * NANOS), size_bytes)
    return traffic


def rate(traffic: Traffic, now_s: float, since_s: float = 0.0) -> float:
    return traffic.rate_hz(round(now_s * NANOS), round(since_s * NANOS))


@pytest.mark.parametrize("hertz", [0.5, 1, 7, 1000])
def test_a_steady_topic_has_its_rate_whenever_it_is_asked(hertz):
    for now_s in (20.0, 20.3, 20.9):
        times_s = [number / hertz for number in range(int(now_s * hertz) + 1)]
        assert rate(received(*times_s), now_s) == pytest.approx(hertz, rel=1e-3)


def test_the_rate_of_a_topic_that_fell_silent_declines_to_zero():
    traffic = received(*(number / 10 for number in range(101)))  # the last one after 10 s
    rates = [rate(traffic, now_s) for now_s in (10.1, 11, 12, 14, 16)]
    assert rates == sorted(rates, reverse=True)
    assert (rates[0], rates[-1]) == (pytest.approx(10), 0.0)


def test_a_single_message_counts_for_the_window():
    assert rate(received(9.5), 10) == pytest.approx(1 / 5)
    assert rate(received(9.5), 10, since_s=8) == pytest.approx(1 / 2)
    assert rate(received(9.5), 10, since_s=9.4) == pytest.approx(1)


def test_messages_that_come_all_at_once_are_no_high_rate():
    """The backlog of a latched topic."""
    assert rate(received(*[9.99] * 5), 10, since_s=9.9) == pytest.approx(5)


def test_what_is_older_than_the_window_is_forgotten():
    traffic = received(*(number / 100 for number in range(10_000)), size_bytes=10)
    traffic.add(100 * NANOS, 1000)
    assert len(traffic._buckets) <= 21
    assert traffic.mean_bytes() == pytest.approx(12, abs=0.2)


def test_times_that_run_backwards_do_no_harm():
    traffic = received(10.0, 9.7, 10.1, 9.9)
    assert rate(traffic, 10.1) == pytest.approx(30)
    assert traffic.mean_bytes() == 100


def test_nothing_received_is_zero():
    assert (rate(Traffic(), 5.0), Traffic().mean_bytes()) == (0.0, 0.0)
