"""Answers of the control socket as lines of text."""

from __future__ import annotations

import pytest

from launcher.control.format import event_line, filters


def test_a_request_is_an_event_of_one_line():
    item = {"wall_s": 0, "monotonic_s": 0.0, "event": "asked", "process": "a-1", "verb": "stop"}
    assert event_line(item).endswith(" requested a-1 verb=stop")


@pytest.mark.parametrize(
    ("hidden", "text"),
    [(0, "muted"), (1, "muted, 1 line not shown"), (2, "muted, 2 lines not shown")],
)
def test_hidden_lines_are_counted_if_there_are_any(hidden: int, text: str):
    assert filters({"muted": True, "muted_lines": hidden}) == text


def test_a_process_without_filters_has_nothing_hidden():
    assert filters({"muted_lines": 3}) == ""
