"""Rates, delays and bandwidths from arrival times, in the format of ros2cli."""

from __future__ import annotations

import pytest

from launcher.ros.topics.statistics import (
    BANDWIDTH_HEAD,
    NANOS,
    RATE_HEAD,
    Arrivals,
    Bandwidth,
    Delays,
    bandwidth_cells,
    bandwidth_text,
    delay_text,
    rate_cells,
    rate_text,
    spread,
    table,
)


def arrivals(*times_s: float, window: int = 10000) -> Arrivals:
    found = Arrivals(window)
    for time_s in times_s:
        found.add(round(time_s * NANOS))
    return found


def test_a_report_has_the_shape_of_ros2_topic_hz():
    found = spread([198_000_000, 202_000_000])
    assert found is not None
    assert rate_text(found) == (
        "average rate: 5.000\n\tmin: 0.198s max: 0.202s std dev: 0.00200s window: 2"
    )


def test_a_report_is_due_when_a_message_has_come_since_the_last_one():
    found = arrivals(0.0)
    assert found.due() is None  # one message is no interval
    found.add(NANOS // 2)
    report = found.due()
    assert report is not None
    assert (report.rate_hz, report.window) == (2.0, 1)
    assert found.due() is None  # nothing new since
    found.add(NANOS)
    assert found.due() is not None


def test_the_window_keeps_the_latest():
    report = arrivals(0, 10, 11, 12, 13, window=3).now()
    assert report is not None
    assert (report.max_s, report.window) == (1.0, 3)


def test_a_clock_that_is_set_back_starts_anew():
    assert arrivals(100, 101, 5, 6).count == 2


@pytest.mark.parametrize(
    ("end_s", "rate_hz"), [(4.0, 1.0), (5.9, 1.0), (8.0, 0.5)], ids=["end", "pause", "silence"]
)
def test_the_mean_rate_counts_a_silence_but_not_a_pause(end_s, rate_hz):
    assert arrivals(0, 1, 2, 3, 4).mean_rate_hz(round(end_s * NANOS)) == rate_hz


def test_no_message_is_no_rate():
    assert arrivals().mean_rate_hz(NANOS) == 0.0
    assert arrivals(1.0).mean_rate_hz(9 * NANOS) == 0.0


@pytest.mark.parametrize(
    ("sizes", "seconds", "text"),
    [
        (
            [100, 200],
            1.0,
            "300 B/s from 2 messages\n\tMessage size mean: 150 B min: 100 B max: 200 B",
        ),
        (
            [1000, 2000],
            1.0,
            "3.00 KB/s from 2 messages\n\tMessage size mean: 1.50 KB min: 1.00 KB max: 2.00 KB",
        ),
        (
            [3_000_000] * 2,
            1.0,
            "6.00 MB/s from 2 messages\n\tMessage size mean: 3.00 MB min: 3.00 MB max: 3.00 MB",
        ),
    ],
    ids=["bytes", "kilobytes", "megabytes"],
)
def test_bandwidth_has_one_unit_for_all(sizes, seconds, text):
    found = Bandwidth(100)
    for size in sizes:
        found.add(0, size)
    due = found.due(round(seconds * NANOS))
    assert due is not None
    assert bandwidth_text(*due) == text


def test_delays_say_when_nothing_new_has_come():
    delays = Delays(10)
    assert delays.due() is None
    delays.add(NANOS // 4)
    first, second = delays.due(), delays.due()
    assert first is not None
    assert second is not None
    text = delay_text(first[0], fresh=first[1])
    assert text.startswith("average delay: 0.250\n\tmin: 0.250s max: 0.250s")
    assert delay_text(second[0], fresh=second[1]) == "no new messages"


def test_rates_of_several_topics_are_a_table():
    one, two = spread([NANOS]), spread([8_000_000, 12_000_000])
    assert one is not None
    assert two is not None
    rows = [("/a", *rate_cells(one)), ("/long/name", *rate_cells(two))]
    assert table(RATE_HEAD, rows) == (
        "  topic        rate    min_delta   max_delta   std_dev   window\n"
        "===============================================================\n"
        "/a           1.000     1.000       1.000       0.00000   1     \n"
        "/long/name   100.000   0.008       0.012       0.00200   2     \n"
    )


def test_bandwidths_of_several_topics_are_a_table():
    rows = [
        ("/a", *bandwidth_cells(300.0, [100, 200])),
        ("/b", *bandwidth_cells(3000.0, [1000, 2000])),
    ]
    assert table(BANDWIDTH_HEAD, rows) == (
        "topic   bandwidth   window     mean      min       max  \n"
        "========================================================\n"
        "/a      300 B/s     2        150 B     100 B     200 B  \n"
        "/b      3.00 KB/s   2        1.50 KB   1.00 KB   2.00 KB\n"
    )
