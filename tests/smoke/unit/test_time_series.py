"""What is measured of plain times and values, in smoke runs and in watched ones."""

from __future__ import annotations

import pytest

from launcher.smoke.judges.time_series import (
    GROWTH_S,
    Pause,
    fell_silent,
    growth_per_s,
    latency_s,
    longest_gap,
    rate,
)
from launcher.smoke.observe.message_stamp import stamp_s

STEADY = [10.0 + number / 2 for number in range(21)]  # 2 Hz, to 20 s


def test_a_rate_is_that_of_the_intervals_whatever_the_window():
    assert rate(STEADY, 0.0, 20.4, counts_start=False) == (2.0, 10.0)
    assert not fell_silent(STEADY, 20.4)


def test_a_silent_topic_is_measured_to_the_end_and_a_late_one_from_the_start():
    assert fell_silent(STEADY, 30.0)
    assert rate(STEADY, 0.0, 30.0, counts_start=False) == (1.0, 20.0)
    assert rate(STEADY, 0.0, 20.0, counts_start=True) == (1.0, 20.0)


@pytest.mark.parametrize(
    ("times", "counts_start", "gap"),
    [
        ([1.0, 2.0, 5.0, 6.0], False, Pause(start_s=2.0, end_s=5.0)),
        ([1.0, 2.0, 5.0], False, Pause(start_s=5.0, end_s=9.0, is_open=True)),
        ([7.0, 8.0], False, Pause(start_s=7.0, end_s=8.0)),
        ([7.0, 8.0], True, Pause(start_s=0.0, end_s=7.0)),
        ([9.5], False, Pause(start_s=9.5, end_s=9.5, is_open=True)),  # later than the window
        ([], True, Pause(start_s=0.0, end_s=9.0, is_open=True)),
        ([], False, None),
    ],
)
def test_the_longest_gap_may_be_one_that_goes_on(times, counts_start, gap):
    assert longest_gap(times, 0.0, 9.0, counts_start=counts_start) == gap


def test_one_message_in_twenty_may_be_late():
    assert latency_s([0.01] * 19 + [5.0]) == 0.01
    assert latency_s([0.01] * 18 + [5.0, 5.0]) == 5.0
    assert latency_s([0.01, 0.02, 0.03]) == 0.03


@pytest.mark.parametrize("count", [20, 1000])
def test_growth_is_the_slope_without_steps_and_peaks(count):
    samples = [(float(at_s), 100.0 + 3.0 * at_s) for at_s in range(count)]
    assert growth_per_s(samples) == pytest.approx(3.0)
    peak = [(at_s, 9e9 if at_s in (5, 6) else value) for at_s, value in samples]
    assert growth_per_s(peak) == pytest.approx(3.0)
    step = [(at_s, 100.0 + 900.0 * (at_s > 0.8 * count)) for at_s, _ in samples]
    assert growth_per_s(step) == 0.0


def test_a_short_time_has_no_growth():
    assert growth_per_s([(0.0, 1.0), (GROWTH_S - 0.1, 2.0)]) is None
    assert growth_per_s([(0.0, 1.0), (GROWTH_S, 11.0)]) == pytest.approx(1.0)
    assert growth_per_s([]) is None


@pytest.mark.parametrize(
    ("content", "seconds"),
    [
        ({"header": {"stamp": {"sec": 3, "nanosec": 500_000_000}, "frame_id": ""}}, 3.5),
        ({"clock": {"sec": 3, "nanosec": 0}}, 3.0),
        ({"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}}, None),
        ({"data": 1, "header": {"stamp": {"sec": 3, "nanosec": 0}}}, None),
        ({"transforms": []}, None),
        ({}, None),
        (None, None),
    ],
)
def test_the_stamp_of_a_message_is_the_time_it_begins_with(content, seconds):
    assert stamp_s(content) == seconds
