"""What is recorded of healthy runs: names, rates, lines, and the file as a whole."""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from launcher.smoke.observe.facts import Ending, Facts, LogLine, ObservedMessage, UsageSample
from launcher.smoke.preflight.loader import parse
from launcher.smoke.record import entries
from launcher.smoke.record.document import Head, document_of
from launcher.smoke.record.name_patterns import Names, without_random
from launcher.smoke.record.observed_run import ObservedRun
from launcher.smoke.record.recorded_runs import Runs
from launcher.smoke.record.recording_session import write
from launcher.smoke.record.timeliness_expectations import limit_s
from launcher.smoke.record.topic_expectations import Rate, number_text, rate_of
from tests.smoke.unit.facts import (
    EMPTY,
    END_S,
    ended,
    graph,
    publisher,
    samples,
    seen,
    started,
    subscription,
    texts,
    ticks,
)
from tests.smoke.unit.facts import lines as lines_of

# ---- names


@pytest.mark.parametrize(
    ("name", "pattern"),
    [
        ("/robot_1", "/robot_1"),
        ("/camera_front2", "/camera_front2"),
        ("/facade_deadbeef", "/facade_deadbeef"),
        ("/tool_137_1795229958766869", "/tool_*"),
        ("/listener_host_77_12345678901", "/listener_host_*"),
        ("/transform_listener_impl_55d0c8e1f2a0", "/transform_listener_impl_*"),
        ("/private_550e8400_e29b_41d4_a716_446655440000", "/private_*"),
        ("/private_550e8400e29b41d4a716446655440000/data", "/private_*/data"),
    ],
)
def test_a_part_that_is_random_is_a_pattern_even_with_one_run(name: str, pattern: str):
    assert without_random(name, pids={77, 137}) == pattern


def test_names_that_differ_between_runs_become_a_pattern_and_others_stay():
    names = Names([["/a_12", "/long_123456", "/b"], ["/a_13", "/long_123456", "/c"]], [(), ()])
    assert names.common() == ["/a_*", "/long_123456"]
    assert names.missing() == ["/b", "/c"]
    assert names.of("/a_13", 1) == "/a_*" and names.of("/b", 0) is None


# ---- rates


def clock(period_s: float, count: int, jitter_s: float = 0.0) -> list[float]:
    chance = random.Random(7)
    return [number * period_s + chance.uniform(-jitter_s, jitter_s) for number in range(count)]


def rate(*runs: Sequence[float]) -> Rate:
    found = rate_of(runs)
    assert found is not None
    return found


def test_the_tolerance_grows_with_the_jitter():
    texts = [rate(clock(1.0, 15, jitter_s)).text for jitter_s in (0.0, 0.1, 0.3)]
    assert texts[0] == "1 Hz ± 15 %"
    tolerances = [rate(clock(1.0, 15, jitter_s)).tolerance for jitter_s in (0.0, 0.1, 0.3)]
    assert tolerances == sorted(set(tolerances))


def test_the_tolerance_covers_all_runs_and_the_delays_of_short_periods():
    both = rate(clock(1.0, 15), clock(1.1, 15))
    assert both.hz * (1 - both.tolerance) < 1 / 1.1 and both.hz * (1 + both.tolerance) > 1.0
    assert rate(clock(0.01, 1500)).tolerance > rate(clock(1.0, 15)).tolerance


def test_what_has_no_rate_gets_none():
    chance = random.Random(1)
    moody = [sum(chance.expovariate(1.0) for _ in range(n)) for n in range(1, 16)]
    assert rate_of([moody]) is None
    assert rate_of([clock(4.0, 4)]) is None  # too few
    assert rate_of([clock(1.0, 15), []]) is None
    assert rate_of([[1.0] * 9]) is None


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "0.5"),
        (1.0, "1"),
        (4.7654, "4.77"),
        (99.96, "100"),
        (1234.5, "1234"),
        (0.0667, "0.0667"),
    ],
)
def test_a_number_is_written_without_an_exponent(value: float, text: str):
    assert number_text(value) == text


def test_a_rate_is_written_with_few_digits():
    assert rate(clock(1 / 0.502, 15)).text.startswith("0.5 Hz")
    assert rate(clock(1 / 29.97, 450)).text.startswith("30 Hz")


# ---- lines


def said(*texts: str) -> list[LogLine]:
    return list(lines_of(*texts))


HEAD = "[INFO] [1795229956.758952768] [robot_3]: "


@pytest.mark.parametrize(
    ("text", "constant"),
    [
        (f"{HEAD}Robot is ready", "Robot is ready"),
        (f"{HEAD}Backlog 1: x for y", "Backlog"),
        (f"{HEAD}started with pid 137", "started with pid"),
        (f"{HEAD}loaded 'abc' from /opt", "loaded"),
        ("plain text of print()", "plain text of print"),
        ("[WARN] [1.5] [a]: slow network", None),
        ("  indented, as in a traceback", None),
        ("12345", None),
        ("ok", None),
    ],
)
def test_the_constant_part_of_a_line(text: str, constant: str | None):
    assert entries.constant(said(text)[0]) == constant


def test_the_line_that_says_ready_is_preferred_and_must_be_in_every_run():
    one = said("Reading the file", "hello there 1", "Node is ready (3)", "engine started")
    other = said("Reading the file", "hello there 2", "engine started")
    assert entries.readiness([one, one]) == ("Node is ready", [one[2], one[2]])
    assert entries.readiness([one, other]) == ("engine started", [one[3], other[2]])
    assert entries.readiness([one[:2], other[:2]]) == ("Reading the file", [one[0], other[0]])
    assert entries.readiness([one[:1], other[1:]]) is None


def test_the_expression_of_a_line_matches_it():
    (line,) = said(f"{HEAD}Fleet report -- a+b (all)")
    found = entries.readiness([[line]])
    assert found is not None and found[0] == r"Fleet report -- a\+b"


# ---- the file


QOS = {"durability": "TRANSIENT_LOCAL"}
PIDS = {"robot_1-1": 4711, "setup-2": 4712}


def run(pid: str = "137", **changes: Any) -> Facts:
    """A run of a node and of a process that ends."""
    ends = (
        publisher("/beat", "/robot_1", **QOS),
        subscription("/beat", f"/watch_{pid}"),
        publisher(f"/private_{pid}", f"/watch_{pid}"),
    )
    services = {"/reset": ("std_srvs/srv/Empty",), "/do/_action/send_goal": ("a/action/Do",)}
    facts = seen(
        graphs=(EMPTY, graph(*ends, services=services)),
        events=(*started("robot_1-1", "setup-2"), ended("setup-2", 0, 1.0)),
        lines=lines_of("I am ready", at_s=1.5),
        messages=ticks("/beat", 0.5),
        samples=samples("robot_1-1", (5, 40), (5, 42)),
    )
    return replace(facts, **changes)


def recorded(*runs: Facts, arguments: dict[str, str] | None = None, for_s: float = 15.0) -> str:
    head = Head(target="x.launch.py", arguments=arguments or {}, options=(), for_s=for_s)
    return document_of(Runs(ObservedRun(one, for_s) for one in runs), head).text


def test_a_recorded_file_says_what_all_runs_have_in_common():
    text = recorded(run("137"), run("138"), arguments={"debug": "true"})
    script = parse(text, "x.yaml")
    told = {(e.kind, str(getattr(e.subject, "pattern", e.subject))) for e in script.expectations}
    assert told >= {
        *(("node", "/robot_1"), ("node", "/watch_*"), ("topic", "/beat"), ("qos", "/beat")),
        *(("rate", "/beat"), ("service", "/reset"), ("service", "/do/_action/send_goal")),
        *(("log", "I am ready"), ("memory", "robot_1"), ("process", "setup")),
        *(("process", "robot_1"), ("no_errors", "*"), ("shared_memory", "clean")),
    }
    assert script.arguments == {"debug": "true"} and script.for_s == 15.0
    by_kind = {e.kind: e for e in script.expectations}
    assert by_kind["rate"].after == "ready" and by_kind["rate"].get("is").text == "2 Hz ± 15 %"
    assert by_kind["service"].get("call") is False  # it might have an effect
    assert by_kind["topic"].get("publishers").text == "1"
    assert "left out: /private_*: another name in each run" in text
    assert "42 MB at most" in text and "robot_1, below: 90 MB" in text
    assert max(map(len, text.splitlines())) <= 100


def aged(*delays_s: float) -> tuple[ObservedMessage, ...]:
    """Messages of `/beat` that begin with a stamp, so much earlier than their arrival."""
    ages = itertools.cycle(delays_s)
    return tuple(replace(m, stamp_s=m.at_s - next(ages)) for m in ticks("/beat", 0.5))


def test_gaps_are_recorded_for_topics_with_a_rate_and_latencies_where_there_are_stamps():
    text = recorded(run(messages=aged(0.08, 0.09)), run(messages=aged(0.1, 0.12)))
    assert "{gap: /beat, below: 2 s, after: ready}  # seen 500 ms at most" in text
    assert "{latency: /beat, below: 500 ms, after: ready}  # seen 90 ms and 120 ms" in text
    assert "latency" not in recorded(run(), run())
    assert "gap: /beat" not in recorded(run(), run(messages=ticks("/beat", 3.0)))
    simulated = recorded(run(messages=aged(1e9)), run(messages=aged(1e9)))
    assert "left out: /beat: its stamps are no times of day" in simulated


@pytest.mark.parametrize(
    ("seen_s", "least_s", "found"),
    [(0.1, 1.0, 1.0), (0.34, 1.0, 2.0), (1.02, 1.0, 5.0), (0.001, 0.2, 0.2), (9.0, 1.0, 50.0)],
)
def test_a_limit_is_rounded_up_so_that_the_next_recording_has_the_same(seen_s, least_s, found):
    assert limit_s(seen_s, least_s) == pytest.approx(found)


def test_ids_that_do_not_repeat_are_recorded():
    def told(*ids: int) -> Any:
        return texts("/beat", *({"task_id": f"a-{n}", "robot_id": 1, "n": n} for n in ids))

    recording = recorded(run(messages=told(*range(9))), run(messages=told(*range(9))))
    unique = [e for e in parse(recording, "x.yaml").expectations if e.kind == "unique"]
    assert [(one.subject, one.get("key")) for one in unique] == [("/beat", ("task_id",))]
    for repeated in (told(*range(8), 0), ()):
        assert "unique" not in recorded(run(messages=told(*range(9))), run(messages=repeated))


def test_what_differs_between_runs_is_wide_or_left_out_with_the_reason():
    more = graph(
        publisher("/beat", "/robot_1", **QOS), publisher("/beat", "/robot_2"), nodes=("/extra",)
    )
    text = recorded(run(), run(graphs=(EMPTY, more), messages=ticks("/beat", 3.0)))
    assert "'>= 1'" in text and "1 to 2 publishers" in text
    assert "left out: /extra: not in every run" in text
    assert "left out: /reset: not in every run" in text
    assert "rate: /beat" not in text
    parse(text, "x.yaml")


def test_a_process_that_exits_late_or_is_restarted_is_left_out():
    late = run(events=(*started("robot_1-1", "setup-2"), ended("setup-2", 0, END_S - 1)))
    assert "left out: setup: it exited late or not in every run" in recorded(run(), late)
    again = ended("setup-2", 0, 3.0, restart_in_s=1.0)
    restarted = run(events=(*started("robot_1-1", "setup-2"), again))
    assert "left out: setup: it was restarted" in recorded(restarted, restarted)


def test_an_exit_soon_after_a_slow_start_is_not_late():
    begin_s = END_S - 3.1
    events = (*started("robot_1-1", "setup-2", at_s=begin_s), ended("setup-2", 0, begin_s + 0.5))
    slow = run(events=events, graphs=(), messages=(), lines=())
    assert "{process: setup, exits: 0}" in recorded(slow, for_s=3.0)


def test_memory_that_was_measured_late_is_left_out():
    def sampled(at_s: float) -> Facts:
        return run(samples=(UsageSample(at_s, "robot_1-1", None, 40 << 20),))

    assert "{memory: robot_1, below: 80 MB}" in recorded(sampled(10.0))
    assert "memory: robot_1" not in recorded(sampled(12.0))


def test_a_system_that_ends_by_itself_is_recorded():
    ending = Ending(asked_s=None, down_s=0.5, returncode=0)
    events = (*started("setup-2"), ended("setup-2", 0, 0.4))
    brief = run(events=events, ending=ending, graphs=(), messages=(), steps={"start": 0.0})
    assert "{process: setup, exits: 0}" in recorded(brief, brief)


def test_a_lifecycle_node_is_recorded_with_its_state_and_other_services_are_not_called():
    services = {
        "/engine/get_state": ("lifecycle_msgs/srv/GetState",),
        "/engine/change_state": ("lifecycle_msgs/srv/ChangeState",),
    }
    facts = run(graphs=(EMPTY, graph(nodes=("/engine",), services=services)))
    head = Head(target="x", arguments={}, options=(), for_s=15.0)
    text = document_of(Runs([ObservedRun(facts, 15.0, {"/engine/get_state": "active"})]), head).text
    (service,) = [e for e in parse(text, "x.yaml").expectations if e.kind == "service"]
    assert service.subject == "/engine/get_state"
    assert service.get("where").text == "m.current_state.label == 'active'"


def test_what_comes_after_the_nodes_is_waited_for():
    late = run(events=(*started("robot_1-1"), *started("setup-2", at_s=6.0)), messages=())
    text = recorded(late)
    assert parse(text, "x.yaml").for_s == 20.0
    assert parse(recorded(run()), "x.yaml").for_s == 15.0


def test_a_first_line_that_comes_late_is_left_out():
    late = lines_of("I am ready", at_s=END_S - 1)
    assert "left out: robot_1: its first line came late" in recorded(run(lines=late))


def test_a_run_without_anything_of_ros_is_recorded():
    text = recorded(run(graphs=(), messages=(), lines=()))
    kinds = {e.kind for e in parse(text, "x.yaml").expectations}
    assert {"process", "memory"} <= kinds and "node" not in kinds


# ---- writing


def test_a_file_is_written_whole_and_none_is_replaced(tmp_path: Path):
    path = tmp_path / "new" / "x.yaml"
    write(path, "one", is_forced=False)
    with pytest.raises(FileExistsError):
        write(path, "two", is_forced=False)
    assert path.read_text("utf-8") == "one"
    write(path, "two", is_forced=True)
    assert path.read_text("utf-8") == "two"
    assert list(path.parent.iterdir()) == [path]


def test_a_replaced_file_keeps_its_link_and_its_permissions(tmp_path: Path):
    path, link = tmp_path / "x.yaml", tmp_path / "link.yaml"
    path.write_text("one", encoding="utf-8")
    path.chmod(0o640)
    link.symlink_to(path)
    write(link, "two", is_forced=True)
    assert link.is_symlink() and path.read_text("utf-8") == "two"
    assert path.stat().st_mode & 0o777 == 0o640


def test_nothing_is_left_of_a_file_that_cannot_be_written(tmp_path: Path):
    folder = tmp_path / "x.yaml"
    folder.mkdir()
    with pytest.raises(OSError, match="directory"):
        write(folder, "one", is_forced=True)
    assert list(tmp_path.iterdir()) == [folder] and not list(folder.iterdir())
