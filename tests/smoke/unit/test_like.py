"""`like: good.mcap`: mistakes with their lines, and the verdict on a recording."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.bag.comparing.topic_traits import Traits, traits_of
from launcher.bag.topic_course import TopicTimes
from launcher.base.errors import LauncherError
from launcher.smoke.expect.expectation import Decision
from launcher.smoke.expect.likeness import traits_of_bag
from launcher.smoke.judges import judge
from launcher.smoke.preflight import script_checks
from launcher.smoke.preflight.loader import parse
from tests.smoke.unit.facts import running, seen
from tests.support.bags import START_NS, counting, message, string_topic, write_bag

TYPE = "std_msgs/msg/String"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """With a bag `good`: 10 Hz for 5 s, one message, and what every node has."""
    messages = [
        *counting("/steady", 50),
        message("/once", 1, "x"),
        *counting("/rosout", 20),
        *counting("/_hidden", 20),
    ]
    write_bag(tmp_path / "good", sorted(messages, key=lambda one: one.log_ns))
    return tmp_path


def recorded(**traits: list[float]) -> dict[str, Traits]:
    """Topics with the times of their messages in seconds."""
    return {
        f"/{name}": traits_of(string_topic(f"/{name}"), times_at(times))
        for name, times in traits.items()
    }


def times_at(times_s: list[float]) -> TopicTimes:
    found = TopicTimes()
    found.add([START_NS + int(one * 1e9) for one in times_s])
    return found


def every(period_s: float, until_s: float = 5.0) -> list[float]:
    return [n * period_s for n in range(int(until_s / period_s))]


def verdict(folder: Path, entry: str, found: dict[str, Traits] | None, **facts: object):
    script = parse(f"expect: [{{like: {entry}}}]", str(folder / "x.expect.yaml"))
    (expectation,) = script.expectations
    return judge(expectation, seen(recorded=found, **facts))


@pytest.mark.parametrize("entry", ["good", "good/good_0.mcap", "{bag: good, rates: 5 %}"])
def test_a_run_like_the_recording(folder: Path, entry: str):
    found = verdict(folder, entry, recorded(steady=every(0.1), once=[2.0]))
    assert found.outcome is Decision.MET
    assert found.seen == "51 messages"
    assert found.expected.startswith("2 topics as in good")


@pytest.mark.parametrize(
    ("entry", "found", "text"),
    [
        ("good", {"once": [1.0]}, "/steady: not there"),
        ("good", {"once": [], "steady": every(0.1)}, "/once: no message"),
        ("good", {"once": [1.0], "steady": every(0.2)}, "10 Hz in good, 5 Hz in this run"),
        ("good", {"once": [1.0], "steady": []}, "/steady: no message"),
        ("good", {"once": [1.0], "steady": [1.0]}, "10 Hz in good, 0 Hz in this run"),
        (
            "good",
            {"once": [1.0], "steady": [t for t in every(0.1) if not 2 < t < 2.6]},
            "/steady: the longest gap is 0.1 s in good, 0.6 s in this run",
        ),
        ("{bag: good, rates: 1}", {"steady": every(0.103), "once": [1.0]}, "/steady: 10 Hz in"),
        ("{bag: good, topics: [/rosout]}", {}, "/rosout: not there"),
    ],
)
def test_a_run_that_differs(folder: Path, entry: str, found, text: str):
    judged = verdict(folder, entry, recorded(**found))
    assert judged.outcome is Decision.VIOLATED
    assert text in judged.seen


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{bag: good, rates: 60 %}", {"steady": every(0.2), "once": [1.0]}),
        ("{bag: good, exclude: [/o*]}", {"steady": every(0.1)}),
        ("{bag: good, topics: [/st*]}", {"steady": every(0.1)}),
        (
            "{bag: good, gaps: 600 %}",
            {"once": [1.0], "steady": [t for t in every(0.1) if not 2 < t < 2.6]},
        ),
        ("good", {"once": [1.0], "steady": [t for t in every(0.1) if not 2 < t < 2.15]}),
    ],
)
def test_what_is_tolerated_or_left_out(folder: Path, entry: str, found):
    assert verdict(folder, entry, recorded(**found)).outcome is Decision.MET


def test_another_type(folder: Path):
    found = recorded(steady=every(0.1), once=[1.0])
    found["/steady"] = Traits(name="/steady", type="x/msg/X", count=50, rate_hz=10.0, gap_s=0.1)
    judged = verdict(folder, "good", found)
    assert f"/steady: {TYPE} in good, x/msg/X in this run" in judged.seen


def test_without_a_recording_it_is_not_met_and_says_why(folder: Path):
    judged = verdict(folder, "good", None, troubles=("the recorder failed: no space",))
    assert judged.outcome is Decision.VIOLATED
    assert judged.seen == "nothing was recorded; the recorder failed: no space"


def test_it_is_open_while_the_system_runs(folder: Path):
    script = parse("expect: [{like: good}]", str(folder / "x.expect.yaml"))
    assert judge(script.expectations[0], running(3.0)).outcome is Decision.OPEN
    assert script.recorded_topics() == ("/steady", "/once")
    assert script.run_time_s() == 5.0  # the least; the bag has 4.9 s
    assert script.completed().expectations[0].name == "like good"


@pytest.mark.parametrize(
    ("entry", "text", "hint"),
    [
        ("bad", "x.expect.yaml:2: there is no bag at", None),
        ("{bag: good,\n   topics: [/staedy]}", "2: good has no topic /staedy", "'/steady'?"),
        ("{bag: good, exclude: ['/*']}", "2: good has no topic to compare", None),
        ("x.expect.yaml", "x.expect.yaml is not a bag", "ends in .mcap or .db3"),
    ],
)
def test_mistakes_are_told_with_their_lines(folder: Path, entry: str, text: str, hint):
    (folder / "x.expect.yaml").write_text(f"expect:\n- like: {entry}\n")
    script = parse((folder / "x.expect.yaml").read_text(), str(folder / "x.expect.yaml"))
    (error,) = script_checks.of_script(script).errors
    assert text in error.render()
    assert hint is None or hint in (error.hint or "")


def test_wrong_entries_are_told_with_their_lines():
    with pytest.raises(LauncherError) as raised:
        parse("expect:\n- like:\n    bag: a\n    rate: 20 %\n", "x.yaml")
    assert "x.yaml:4: 'like' has no 'rate'" in raised.value.render()
    assert "did you mean 'rates'?" in raised.value.render()


def test_traits_of_a_bag(folder: Path):
    from launcher.bag.reader import Bag

    found = traits_of_bag(Bag(str(folder / "good")), ["/steady", "/none"])
    assert list(found) == ["/steady"]
    assert (found["/steady"].count, found["/steady"].rate_hz) == (50, 10.0)
