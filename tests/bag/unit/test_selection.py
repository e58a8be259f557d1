"""Which topics are recorded and played."""

from __future__ import annotations

import re

import pytest

from launcher.bag.bag_actions import action_of, renamed
from launcher.bag.bag_model import Topic
from launcher.bag.topic_selection import Selection, expression
from launcher.bag.verbs.play import COMMAND
from launcher.bag.verbs.topics import warn_of_unknown
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


def test_what_is_named_and_excluded():
    selection = Selection(
        exclude_regex=re.compile("chat"), exclude_services=["/srv"], exclude_types=["x"]
    )
    assert selection.excludes("/chat", STRING)
    assert selection.excludes("/srv/_service_event", "")
    assert selection.excludes("/a", "x")
    assert not selection.excludes("/a", STRING)


def test_nothing_named_is_empty():
    assert Selection(exclude_topics=["/a"], hidden=True).is_empty
    assert not Selection(types=[STRING]).is_empty


def test_an_expression_that_is_none():
    with pytest.raises(UsageError, match=r"'\[' is not a regular expression"):
        expression("[")


FOLD = {
    "/f/_action/feedback": "fleet/action/Fold_FeedbackMessage",
    "/f/_action/status": "action_msgs/msg/GoalStatusArray",
    "/f/_action/send_goal/_service_event": "fleet/action/Fold_SendGoal_Event",
    "/f/_action/cancel_goal/_service_event": "action_msgs/srv/CancelGoal_Event",
    "/f/_action/get_result/_service_event": "fleet/action/Fold_GetResult_Event",
}
OTHERS = {"/f": STRING, "/srv/_service_event": "std_srvs/srv/SetBool_Event"}


@pytest.mark.parametrize(
    ("selection", "expected"),
    [
        (Selection(all_topics=True), {"/f"}),
        (Selection(all_services=True), {"/srv/_service_event"}),
        (Selection(all_actions=True), {*FOLD}),
        (Selection(actions=["/f"]), {*FOLD}),
        (Selection(actions=["/g"]), set()),
        (Selection(regex=re.compile("^/f$")), {"/f", *FOLD}),
        (Selection(regex=re.compile("send_goal")), set()),  # of the name of the action
        (Selection(all_actions=True, exclude_actions=["/f"]), set()),
        (Selection(all_actions=True, exclude_regex=re.compile("f")), set()),
        (Selection(topics=["/f/_action/status"]), {"/f/_action/status"}),
        (
            Selection(all_actions=True, exclude_topics=["/f/_action/status"]),
            {*FOLD} - {"/f/_action/status"},
        ),
        (
            Selection(all_topics=True, hidden=True),
            {"/f", "/f/_action/status", "/f/_action/feedback"},
        ),
    ],
)
def test_the_five_topics_of_an_action(selection: Selection, expected: set[str]):
    types = {**FOLD, **OTHERS}
    assert {name for name, kind in types.items() if selection.has(name, kind)} == expected


@pytest.mark.parametrize(
    ("topic", "names", "expected"),
    [
        ("/f", {"/f": "/g"}, "/g"),
        ("/f/_action/status", {"/f": "/g"}, "/g/_action/status"),
        (
            "/f/_action/send_goal/_service_event",
            {"/f": "/g"},
            "/g/_action/send_goal/_service_event",
        ),
        ("/f/_action/status", {"/f": "/g", "/f/_action/status": "/s"}, "/s"),
        ("/srv/_service_event", {"/srv": "/other"}, "/other/_service_event"),
        ("/srv/_service_event", {"/s": "/other"}, "/srv/_service_event"),
    ],
)
def test_a_new_name_of_an_action_or_a_service_is_one_of_its_topics(topic, names, expected):
    kind = {**FOLD, **OTHERS}[topic]
    assert renamed(Topic(name=topic, type=kind), names) == expected


def test_names_that_are_not_in_a_bag(capsys):
    topics = [Topic(name=name, type=kind) for name, kind in {**FOLD, **OTHERS}.items()]
    words = "a --topics /f /ff --exclude-topics /g --services /srv --actions /h -m /f:=/x /i:=/y"
    warn_of_unknown(COMMAND.parse(words.split()), topics)
    said = [line.split()[1] for line in capsys.readouterr().err.splitlines()]
    assert said == ["/ff", "/g", "/h", "/i"]


def test_an_action_is_enough_to_select():
    assert not Selection(all_actions=True).is_empty
    assert not Selection(actions=["/f"]).is_empty


def test_topics_with_such_names_and_other_types_belong_to_no_action():
    assert action_of("/f/_action/feedback", STRING) is None
    assert action_of("/_action/status", FOLD["/f/_action/status"]) is None
    assert action_of("/ns/f/_action/status", FOLD["/f/_action/status"]) == "/ns/f"


@pytest.mark.parametrize("word", ["x", "-x", "-0", "1.5"])
def test_a_rate_of_the_status_may_be_below_0(word: str):
    assert COMMAND.parse(["a", "--progress-bar-update-rate=-1"]).progress_bar_update_rate == -1
    with pytest.raises(UsageError, match=f"'{word}' is not a whole number of at least -1"):
        COMMAND.parse(["a", f"--progress-bar-update-rate={word}"])
