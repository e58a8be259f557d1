"""What the page of `smoke --html` is told of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import ExitCode, UsageError
from launcher.base.model.run_events import Resources, Sample
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.observe.facts import Facts, LogLine, ObservedMessage, ProcessEvent
from launcher.smoke.observe.last_state import LastState
from launcher.smoke.reports import html_report, page_lines, page_processes
from launcher.smoke.reports.moments import item, moment_s
from launcher.smoke.reports.result import Judged, SmokeResult
from tests.smoke.unit.facts import END_S, ended, seen, started

START_S = 1_700_000_000.0


def line(text: str, at_s: float = 1.0, process: str | None = "a-1") -> LogLine:
    return LogLine(at_s=at_s, process=process, text=text, stream="stdout")


def judged(name: str, outcome: Decision = Decision.MET, **more: Any) -> Judged:
    decided_s = more.pop("decided_s", None)
    verdict = Verdict(outcome=outcome, expected="x happens", **more)
    expectation = Expectation(kind="log", subject="x", name=name)
    return Judged(expectation=expectation, verdict=verdict, decided_s=decided_s)


def result(*found: Judged, facts: Facts | None = None, **more: Any) -> SmokeResult:
    given = {"folder": Path("nowhere"), "words": ("x",), "domain_id": 1, **more}
    return SmokeResult(judged=found, facts=facts or seen(), started_s=START_S, **given)


def told(one: SmokeResult) -> dict[str, dict[str, Any]]:
    """The messages by their events; the last one of each."""
    found = {message["event"]: message for message in html_report.messages(one, "x.launch.py")}
    assert json.dumps(list(found.values()))
    return found


def sampled(at_s: float, **cpu: float) -> ProcessEvent[Resources]:
    processes = {
        f"{name}-1": Sample(
            pid=7, cpu_percent=value, rss_bytes=9, uss_bytes=7, threads=1, fds=3, processes=1
        )
        for name, value in cpu.items()
    }
    return ProcessEvent(at_s=at_s, event=Resources(processes))


# ---- lines


def test_lines_have_levels_and_times():
    rows = page_lines.rows_of([line("[WARN] [1.0] [n]: x", 2.5), line("y", 3.0, None)], START_S)
    assert rows == [
        ("a-1", "stdout", START_S + 2.5, "WARN", "[WARN] [1.0] [n]: x"),
        (None, "stdout", START_S + 3.0, "INFO", "y"),
    ]


def test_a_log_that_is_too_long_keeps_its_beginning_and_its_end():
    rows = page_lines.rows_of([line(f"{number}") for number in range(1000)], 0.0)
    assert page_lines.shortened(rows) == rows
    short = page_lines.shortened(rows, most=100)
    assert len(short) == 100
    assert [row.text for row in short[:10]] == [f"{number}" for number in range(10)]
    assert short[10].stream == "skipped"
    assert short[10].text == "901 lines are left out of this file: 901 of a-1"
    assert [row.text for row in short[11:]] == [f"{number}" for number in range(911, 1000)]


def test_a_log_of_long_lines_is_too_long_as_well():
    rows = page_lines.rows_of([line("x" * 30_000) for _ in range(100)], 0.0)
    assert rows[0].text.endswith("x… (10,000 more characters)")
    short = page_lines.shortened(rows, characters=500_000)
    assert sum(len(row.text) for row in short) <= 510_000
    assert len([row for row in short if row.stream == "skipped"]) == 1


def test_the_last_error_has_its_number_on_the_page():
    rows = page_lines.rows_of([line("[ERROR] one"), line("[ERROR] two"), line("fine")], 0.0)
    assert page_lines.last_errors(rows) == {
        "a-1": {"time": 1.0, "text": "[ERROR] two", "number": 2}
    }


# ---- processes


def test_rows_are_those_before_the_stop_with_exits_since_then():
    last = LastState()
    row = {"name": "a-1", "label": "a", "state": "RUNNING", "pid": 5, "last_exit": None}
    last.take_rows([row, {**row, "name": "b-2", "pid": 6}])
    last.stop()
    last.take_rows([])
    events = (*started("a-1", "b-2"), ended("a-1", -9, 19.5), ended("b-2", 0, END_S + 0.1))
    found = page_processes.rows_of(result(facts=seen(events=events), last_state=last), {}, {})
    assert [(one["state"], one["pid"]) for one in found] == [("EXITED", None), ("RUNNING", 6)]
    assert found[0]["last_exit"]["text"] == "SIGKILL"
    assert found[0]["last_exit"]["wall_s"] == START_S + 19.5


def test_a_process_that_was_over_before_anybody_asked_has_a_row():
    facts = seen(events=(*started("a-1"), ended("a-1", 3, 0.2)))
    (row,) = page_processes.rows_of(result(facts=facts), {}, {"a-1": {"lines": [2.0, 3.0]}})
    assert (row["label"], row["state"], row["last_exit"]["returncode"]) == ("a", "EXITED", 3)
    assert row["lines_per_s"] == 3.0


def test_the_history_is_what_was_sampled():
    events = (*started("a-1", "b-1"), sampled(1.0, a=5.0), sampled(2.0, a=6.0, b=1.0))
    facts = seen(events=events, lines=(line("z", 0.5), line("x", 1.5), line("y", 1.6)))
    found = page_processes.history_of(facts, START_S)
    assert found["wall"] == [START_S + 1.0, START_S + 2.0]
    assert found["processes"]["a-1"] == {"cpu": [5.0, 6.0], "memory": [7, 7], "lines": [1.0, 2.0]}
    assert found["processes"]["b-1"]["cpu"] == [None, 1.0]


@pytest.mark.parametrize("count", (0, 1, 600, 601, 1199, 1200, 3601))
def test_a_long_history_keeps_its_peaks(count: int):
    samples = [sampled(float(number), a=1.0) for number in range(count)]
    if samples:
        samples[count // 2] = sampled(float(count // 2), a=99.0)
    found = page_processes.history_of(seen(events=(*started("a-1"), *samples)), START_S)
    lines = found["processes"]["a-1"]
    assert {len(values) for values in lines.values()} == {len(found["wall"])}
    assert len(found["wall"]) <= page_processes.MAX_SAMPLES
    assert found["wall"] == sorted(found["wall"])
    if samples:
        assert max(lines["cpu"]) == 99.0
        assert found["wall"][-1] == START_S + count - 1


# ---- expectations


def test_an_expectation_has_its_moment_and_its_sentence():
    met = judged("a", seen="after 2 s", at_s=2.0, decided_s=2.3)
    late = judged("b", seen="15 MB at most", at_s=4.0)
    failed = judged("c", Decision.VIOLATED, seen="", guess="it died", decided_s=9.0)
    found = told(result(met, late, failed))["expectations"]["items"]
    assert found == [
        {"title": "a", "state": "passed", "wall": START_S + 2.0, "detail": "after 2 s"},
        {"title": "b", "state": "passed", "wall": START_S + END_S + 0.5, "detail": "15 MB at most"},
        {
            "title": "c",
            "state": "failed",
            "wall": START_S + 9.0,
            "detail": "expected: x happens; seen: nothing; maybe: it died",
        },
    ]


def test_what_failed_as_a_whole_is_one_more():
    found = told(result(gave_up=True, trouble="no process was started"))["expectations"]["items"]
    assert [(one["state"], one["detail"]) for one in found] == [
        ("failed", "not ready in time; no process was started")
    ]


def test_an_open_expectation_has_no_moment():
    expectation = Expectation(kind="log", subject="x", name="a")
    assert item(expectation, None, None)["state"] == "open"
    assert moment_s(Verdict(outcome=Decision.VIOLATED, expected="x", at_s=3.0), 5.0) == 3.0


# ---- the rest


def test_the_report_is_in_the_page():
    hello = told(result(judged("a", Decision.VIOLATED)))["hello"]
    assert hello["read_only"] and hello["run"]["target"] == "x.launch.py"
    assert hello["frozen"]["report"]["exit_code"] == ExitCode.NOT_MET
    assert hello["ended"]["text"] == "Smoke test: failed, exit code 3."


def test_events_are_those_of_the_log_without_samples():
    facts = seen(events=(*started("a-1"), sampled(1.0, a=1.0), ended("a-1", 3, 5.0)))
    events = told(result(facts=facts))["run_events"]["items"]
    assert [one["event"] for one in events] == ["started", "ended"]
    assert [one["text"] for one in events] == [
        "started, pid 4242, restart 2",
        "ended (exit code 3)",
    ]
    assert (events[1]["wall_s"], events[1]["returncode"]) == (START_S + 5.0, 3)


def test_the_output_of_a_launcher_that_has_started_nothing_is_the_log():
    lines = told(result(last_lines=("error: no such file",)))["lines"]["lines"]
    assert [row.text for row in lines] == ["error: no such file"]


def test_the_last_messages_of_each_topic_are_there():
    messages = tuple(
        ObservedMessage(at_s=number / 10, topic="/t", content={"data": number}, watch="one")
        for number in range(50)
    )
    twice = (*messages, ObservedMessage(at_s=6.0, topic="/t", content={}, watch="two"))
    found = html_report.messages(result(facts=seen(messages=twice)), "x")
    assert [one["data"] for one in found if one["event"] == "message"] == [{}]
    found = html_report.messages(result(facts=seen(messages=messages)), "x")
    data = [one["data"]["data"] for one in found if one["event"] == "message"]
    assert data == list(range(30, 50))


def test_topics_have_the_rate_before_the_stop():
    times = (1.0, 2.0, *(12.0 + number / 2 for number in range(16)), END_S + 0.3)
    messages = tuple(
        ObservedMessage(at_s=at_s, topic="/t", content=1, watch="one") for at_s in times
    )
    once = ObservedMessage(at_s=3.0, topic="/once", content=1, watch="two")
    found = told(result(facts=seen(messages=(*messages, once))))["topics"]["topics"]
    assert found["/t"] == {
        "rate_hz": 2.0,
        "bytes_per_s": None,
        "age_s": 0.0,
        "count": 19,
        "state": "subscribed",
        "error": None,
    }
    assert (found["/once"]["rate_hz"], found["/once"]["age_s"]) == (0.0, END_S - 3.0)


def test_graphs_of_a_starting_system_are_not_all_kept():
    last = LastState()
    for number, names in enumerate((["/a"], ["/a"], ["/a", "/b"], ["/a", "/b"])):
        last.take_graph({"number": number, "nodes": [{"name": name} for name in names]})
    assert [graph["number"] for graph in last.graphs] == [1, 3]


def test_a_refusal_is_a_page_with_the_error(tmp_path: Path):
    path = tmp_path / "deep" / "page.html"
    html_report.write_refusal(path, UsageError("no such </script> file"), "x.launch.py")
    text = path.read_text(encoding="utf-8")
    assert "<title>x.launch.py: not run</title>" in text


def test_several_runs_are_in_one_file_and_the_first_that_failed_is_chosen(tmp_path: Path):
    path = tmp_path / "page.html"
    runs = [result(judged("a")), result(judged("a", Decision.VIOLATED)), result(judged("a"))]
    html_report.write(path, runs, "x.launch.py", ())
    text = path.read_text(encoding="utf-8")
    assert '"run 2: failed, exit code 3"' in text and '"chosen": 1' in text
    assert 'id="frozen-2"' in text
