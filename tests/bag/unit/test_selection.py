"""Which topics are recorded and played."""

from __future__ import annotations

import re

import pytest

from launcher.bag.topic_selection import Selection, expression
from launcher.base.errors import UsageError

STRING = "std_msgs/msg/String"
NAMES = ("/a", "/ab", "/_hidden", "/a/_private/x", "/srv/_service_event", "/other/_service_event")


@pytest.mark.parametrize(
    ("selection", "expected"),
    [
        (Selection(all_topics=True), {"/a", "/ab"}),
        (Selection(all_topics=True, hidden=True), {"/a", "/ab", "/_hidden", "/a/_private/x"}),
        (Selection(all_services=True), {"/srv/_service_event", "/other/_service_event"}),
        (Selection(services=["/srv"]), {"/srv/_service_event"}),
        (Selection(topics=["/srv/_service_event"]), {"/srv/_service_event"}),
        (Selection(all_services=True, exclude_services=["/srv"]), {"/other/_service_event"}),
        (Selection(topics=["/_hidden"]), {"/_hidden"}),
        (Selection(regex=re.compile("^/a")), {"/a", "/ab"}),
        (Selection(regex=re.compile("srv")), {"/srv/_service_event"}),
        (Selection(all_topics=True, exclude_regex=re.compile("b$")), {"/a"}),
        (Selection(topics=["/a"], exclude_topics=["/a"]), set()),
        (Selection(all_topics=True, exclude_types=[STRING]), set()),
        (Selection(types=[STRING]), {"/a", "/ab"}),
        (Selection(types=["std_msgs/msg/Bool"]), set()),
        (Selection(topics=["/ab"], types=["x"]), {"/ab"}),
    ],
)
def test_what_is_selected(selection: Selection, expected: set[str]):
    assert {name for name in NAMES if selection.has(name, STRING)} == expected


def test_nothing_named_is_empty():
    assert Selection(exclude_topics=["/a"], hidden=True).is_empty
    assert not Selection(types=[STRING]).is_empty


def test_an_expression_that_is_none():
    with pytest.raises(UsageError, match=r"'\[' is not a regular expression"):
        expression("[")
