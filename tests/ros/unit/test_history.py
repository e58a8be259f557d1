"""Which messages are the history of a topic."""

from __future__ import annotations

import pytest

from launcher.ros.topics.topic_history import TopicHistory

S = 1_000_000_000
START = 1_000 * S


def judged(times: list[tuple[float, float] | tuple[float, float, bytes]]) -> list[bool]:
    """For messages by the seconds at which they were sent and received; subscribed at 0."""
    history = TopicHistory(START)
    return [
        history.has(*(publisher or [b"one"]), START + round(sent * S), START + round(received * S))
        for sent, received, *publisher in times
    ]


@pytest.mark.parametrize(
    ("times", "expected"),
    [
        ([(-2.5, 0.1), (-1.5, 0.1), (-0.5, 0.1), (0.5, 0.5), (1.5, 1.5)], [1, 1, 1, 0, 0]),
        ([(0.2, 0.2), (1.2, 1.2)], [0, 0]),
        # a second publisher is discovered later, while the first goes on
        ([(-0.5, 0.1), (0.5, 0.5), (-3.0, 0.9), (-2.0, 0.9), (1.5, 1.5)], [1, 0, 1, 1, 0]),
        # the history of a burst has the intervals of that burst
        ([(-1.0 + n / 1000, 0.1 + n / 1000) for n in range(5)], [1, 1, 1, 1, 1]),
        ([(-3600.0 + n / 200, 0.1 + n / 200) for n in range(22)], [1] * 20 + [0] * 2),
        # two publishers, one with a clock that is an hour behind
        (
            [(-1.0, 0.1), (-3600.0, 0.2, b"two"), (0.3, 0.3), (-3599.0, 1.2, b"two")],
            [1, 1, 0, 0],
        ),
        # the clock of the sender is an hour behind, or ahead
        ([(-3600.5, 0.1), (-3599.5, 1.1), (-3598.5, 2.1)], [1, 0, 0]),
        ([(3600.5, 1.1), (3601.5, 2.1), (3602.5, 3.1)], [1, 0, 0]),
        ([(3597.5, 0.1), (3598.5, 0.1), (3599.5, 0.5), (3600.5, 1.5)], [1, 1, 1, 0]),
        # long after the start everything counts
        ([(-3600.0, 11.0), (-3605.0, 12.0)], [0, 0]),
    ],
    ids=[
        "periodic",
        "none",
        "late",
        "burst",
        "fast-behind",
        "two",
        "behind",
        "ahead",
        "history-ahead",
        "long-after",
    ],
)
def test_history(times, expected):
    assert judged(times) == [bool(one) for one in expected]
