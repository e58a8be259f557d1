"""Paths into messages."""

from __future__ import annotations

import math
from typing import Any

import pytest

from launcher.web.graph_feed import KEEP_S, Series, numbers_at

MESSAGE = {
    "pose": {"x": 1.5},
    "ranges": [1, 2, {"deep": 3}],
    "is_on": True,
    "data": '{"robot_id": 4, "list": [5, {"n": 6}], "inner": "{\\"n\\": 7}"}',
    "text": "words",
    "number": "8",
    "bad": ["nan", float("inf"), "NaN", "1e999", 10**400],
}


@pytest.mark.parametrize(
    ("path", "number"),
    [
        ("pose.x", 1.5),
        ("ranges[1]", 2),
        ("ranges[2].deep", 3),
        ("is_on", 1),
        ("data.robot_id", 4),
        ("data.list[1].n", 6),
        ("data.inner.n", 7),
        ("number", 8),
        ("text", None),
        ("pose", None),
        ("pose.y", None),
        ("pose[0]", None),
        ("ranges[9]", None),
        ("ranges.x", None),
        *((f"bad[{index}]", math.nan) for index in (0, 2)),
        *((f"bad[{index}]", math.inf) for index in (1, 3, 4)),
    ],
)
def test_numbers_at(path: str, number: Any) -> None:
    assert numbers_at(MESSAGE, path) == pytest.approx(number, nan_ok=True)


def test_a_series_keeps_the_last_minutes_and_tells_what_is_new() -> None:
    series = Series()
    series.add(0.0, 1.0)
    series.add(10.0, None)
    assert series.take_new() == [(0.0, 1.0)]
    series.add(KEEP_S + 1, 2.0)
    assert series.take_new() == [(KEEP_S + 1, 2.0)]
    assert series.all() == [(KEEP_S + 1, 2.0)]


def test_numbers_that_are_not_finite_are_one_gap() -> None:
    series = Series()
    for wall, value in enumerate([math.nan, 1.0, math.inf, math.nan, 2.0]):
        series.add(float(wall), value)
    assert series.all() == [(1.0, 1.0), (2.0, None), (4.0, 2.0)]
