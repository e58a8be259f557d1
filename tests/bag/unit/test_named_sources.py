"""What `bag record` says about names that are not recorded."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from launcher.bag.ros.named_sources import NamedSources
from launcher.bag.ros.recorder import RecorderOptions
from launcher.bag.topic_selection import Selection

STRING = "std_msgs/msg/String"
EVENTS = "/_service_event"
PUBLISHED = {
    "/chat": STRING,
    f"/sb{EVENTS}": "std_srvs/srv/SetBool_Event",
    "/fib/_action/status": "action_msgs/msg/GoalStatusArray",
}


class _Observer:
    """A graph with these topics, and a service that does not publish its calls."""

    node: Any = SimpleNamespace(get_service_names_and_types=lambda: [("/quiet", ["x"])])

    def topic_types(self) -> dict[str, list[str]]:
        return {name: [kind] for name, kind in PUBLISHED.items()}

    def infos(self, name: str, direction: object) -> list[str]:
        return [name] if name in PUBLISHED else []


def named(repeat: dict[str, int] | None = None, **what: Any) -> NamedSources:
    options = RecorderOptions(selection=Selection(**what), repeat=repeat or {})
    observer: Any = _Observer()
    return NamedSources(observer, options)


@pytest.mark.parametrize(
    ("what", "recorded", "said"),
    [
        ({"topics": ["/chat"]}, ["/chat"], []),
        ({"topics": ["/chatt"]}, [], ["/chatt was not published (did you mean '/chat'?)"]),
        ({"topics": ["/chat"]}, [], ["/chat is not recorded"]),  # with the reason before
        ({"topics": ["/chat"], "exclude_topics": ["/chat"]}, [], ["/chat is excluded"]),
        ({"topics": ["/chat"], "exclude_types": [STRING]}, [], ["/chat is excluded"]),
        ({"services": ["/sb"]}, [f"/sb{EVENTS}"], []),
        (
            {"services": ["/sb", "/sbb"]},
            [f"/sb{EVENTS}"],
            ["service /sbb did not publish its calls (did you mean '/sb'?)"],
        ),
        (
            {"services": ["/quiet"]},
            [],
            ["service /quiet did not publish its calls: its introspection is off"],
        ),
        ({"services": ["/sb"], "exclude_services": ["/sb"]}, [], ["service /sb is excluded"]),
        ({"actions": ["/fib"]}, ["/fib/_action/status"], []),
        ({"actions": ["/fob"]}, [], ["action /fob was not there (did you mean '/fib'?)"]),
        ({"actions": ["/fib"], "exclude_actions": ["/fib"]}, [], ["action /fib is excluded"]),
    ],
)
def test_what_is_missing_at_the_end(what, recorded, said):
    found = {name: PUBLISHED[name] for name in recorded}
    expected = [f"warning: {one}" for one in said]
    assert list(named(**what).missing_at_the_end(found)) == expected


def test_what_is_missing_yet():
    sources = named(topics=["/x"], services=["/y"], actions=["/z"])
    assert list(sources.missing_yet({})) == [
        "/x does not appear to be published yet",
        "service /y does not appear to publish its calls yet",
        "action /z does not appear to be there yet",
    ]
    assert sources.kinds == "topic, service or action"
    assert named(topics=["/x"]).kinds == "topic"
    assert not named(all_topics=True)


def test_what_is_not_repeated():
    sources = named({"/other": 2, "/chat": 1}, all_topics=True)
    (said,) = sources.missing_at_the_end({"/chat": STRING})
    assert said == "warning: /other is not repeated, since it was not recorded"
