"""Expectations that hold while a run lives."""

from __future__ import annotations

import re
from typing import Any

import pytest

from launcher.smoke.expect.evaluator import EVALUATOR
from launcher.smoke.observe.facts import ObservedMessage, QueryAnswer
from tests.faults.unit.watched import LISTENER, MIB, PAIR, TALKER, WatchedRun, row
from tests.smoke.unit.facts import publisher, subscription


def talking(*entries: str, **more: Any) -> WatchedRun:
    """A run with a publisher and a subscription of /t."""
    run = WatchedRun(*entries, **more)
    run.rows(TALKER, LISTENER)
    run.graph(*PAIR)
    return run


# ---- nodes, processes, parameters


def test_a_node_that_leaves_is_a_fault_and_heals():
    run = talking("node: /talker")
    run.wait(1)
    run.graph(subscription("/t"))
    run.wait(1)
    fault = run.fault("node /talker")
    assert (fault.is_active, fault.finding.processes) == (True, ("talker-1",))
    assert fault.origin.place == "x.yaml:2"
    run.graph(*PAIR)
    run.wait(4)
    assert run.states()["node /talker"] == "healed"
    assert run.changes("node /talker") == ["suspected", "confirmed", "healed"]


def test_what_never_held_counts_when_its_time_is_over():
    run = WatchedRun("node: /late, within: 20 s", "node: /never")
    run.now_s = 1.0
    run.rows(TALKER)
    run.graph(*PAIR)
    run.wait(13)
    assert run.states() == {}
    run.wait(5)
    assert run.states() == {"node /never": "active"}
    run.wait(5)
    assert run.states() == {"node /never": "active", "node /late": "active"}


def test_in_a_file_for_other_arguments_only_what_has_held_once_is_expected():
    text = "arguments: {robots: '3'}"
    given = {"arguments": ["robots:=2"], "text": text}
    run, as_written = (
        talking("node: /r3", "node: /talker", **{**given, **more})
        for more in ({}, {"arguments": ["robots:=3"]})
    )
    for one in (run, as_written):
        one.wait(2)
        one.graph(subscription("/t"))
        one.wait(2)

    assert run.states() == {"node /talker": "active"}
    assert as_written.states() == {"node /talker": "active", "node /r3": "active"}


def test_a_process_that_is_just_started_or_asked_for_is_settling():
    run = talking("node: /talker")
    run.wait(1)
    run.happen("asked", "talker-1", verb="restart")
    run.graph(subscription("/t"))
    run.wait(3)
    assert run.states() == {}
    run.wait(3)
    assert run.states() == {"node /talker": "active"}


def test_a_process_that_does_not_run():
    run = talking("process: talker")
    run.rows(row("talker-1", None, state="EXITED"), LISTENER)
    run.wait(2)
    assert run.only().finding.seen == "talker-1 has exited"
    run.rows(TALKER, LISTENER)
    run.wait(3)
    assert set(run.states().values()) == {"healed"}


def test_a_parameter_that_drifts_and_a_node_that_does_not_answer():
    run = talking("parameter: gain, node: /talker, is: 3")
    (check,) = [one for one in run.checks if hasattr(one, "expectation")]
    key = check.expectation.key

    def answer(**given: Any) -> None:
        run.look(answers={key: (QueryAnswer(at_s=run.now_s, **given),)})
        run.wait(1.4)

    answer(value=3)
    answer(error="no answer")
    assert run.states() == {}
    answer(value=4)
    answer(value=4)
    assert run.only().is_active
    assert run.only().cause == "/talker has another value: gain is 4"
    answer(value=3)
    answer(value=3)
    assert set(run.states().values()) == {"healed"}


def test_a_node_that_is_expected_once_is_there_once():
    expected = [one.origin.expected for one in WatchedRun("node: /a, count: 1").checks[-1:]]
    assert expected[0].startswith("node /a is there once")


# ---- lines


def test_errors_are_counted_once_and_without_those_of_the_launcher():
    run = talking("no_errors: '*', except: [known]")
    run.print("[ERROR] [talker]: known", "[INFO] fine")
    run.print("[ERROR] [launch]: bad", process=None)  # type: ignore[arg-type]
    run.wait(1)
    assert run.states() == {}
    run.print("[ERROR] [talker]: bad")
    run.wait(1)
    assert run.only().is_active and run.only().finding.processes == ("talker-1",)
    assert "bad" in run.only().finding.seen
    run.wait(5)
    assert set(run.states().values()) == {"healed"}
    assert run.only().life.count == 1


@pytest.mark.parametrize("pause_s", [0.0, 0.2])
def test_a_traceback_whose_lines_come_in_two_looks_is_one_fault_with_its_error(pause_s: float):
    run = talking("no_tracebacks: '*'")
    run.print("fine")
    run.wait(1)
    run.print("Traceback (most recent call last):", '  File "x.py", line 1, in f')
    run.wait(pause_s)
    run.print("ValueError: seven")
    run.wait(1)

    assert "ValueError: seven" in run.only().finding.seen
    assert run.only().life.count == 1


def test_a_flood_of_lines_costs_a_bounded_part():
    run = talking("log: 'boom|bang', count: 0", "no_tracebacks: '*'")
    for _ in range(5):
        run.print(*["[INFO] nothing"] * 20_000)
    run.print("boom")
    run.wait(1)

    assert run.states() == {"log boom|bang": "active"}
    assert len(run.story.lines) == 3000


# ---- messages


def message(run: WatchedRun, value: int, watch: str = "") -> ObservedMessage:
    return ObservedMessage(at_s=run.now_s, topic="/t", content={"data": value}, watch=watch)


def evaluated(run: WatchedRun, *values: int) -> None:
    """Receive them, and look until their conditions are known."""
    run.look(messages=tuple(message(run, value) for value in values))
    (check,) = [one for one in run.checks if hasattr(one, "expectation")]
    waiting = check._waiting if hasattr(check, "_waiting") else check.times._waiting
    for _ in range(1000):
        if not waiting:
            return
        run.look()
    raise AssertionError("it is still being evaluated")


def test_messages_that_do_not_satisfy_conditions():
    run = talking("message: /t, all: true, where: 'm.data < 10'")
    evaluated(run, 1, 2)
    assert run.states() == {}
    evaluated(run, 3, 12)
    fault = run.only()
    assert fault.is_active and fault.finding.message == {"data": 12}
    assert fault.finding.processes == ("talker-1",)
    evaluated(run, 4)
    run.wait(1)
    evaluated(run, 5)
    run.now_s += 3
    evaluated(run, 6)
    assert run.states() == {fault.id: "healed"}
    assert fault.rule == "wrong value"
    EVALUATOR.close()


def test_an_evaluation_that_never_ends_is_a_fault_and_stops_no_other_check():
    run = talking("rate: /t, is: 9 to 11 Hz, where: 'm.data < 9**9**9'")
    for _ in range(2000):
        run.look(messages=(message(run, 1),))
        if run.states() and "takes more" in run.only().finding.seen:
            break
    run.wait(1)
    assert "takes more than" in run.only().finding.seen
    assert run.only().is_active
    (check,) = [one for one in run.checks if hasattr(one, "expectation")]
    run.look(messages=tuple(message(run, n) for n in range(5000)))
    assert len(check.times._waiting) <= 2000  # type: ignore[attr-defined]
    EVALUATOR.close()


# ---- rates, gaps, latencies


@pytest.mark.parametrize("hz", [0.2, 1, 10, 500])
def test_a_rate_holds_is_halved_stops_and_heals(hz: float):
    run = talking(f"rate: /t, is: {hz} Hz ± 20 %")
    window_s = max(2.0, 10 / hz)
    run.wait(3 * window_s, hz=hz)
    assert run.states() == {}
    run.wait(2 * window_s + 1, hz=hz / 2)
    assert run.only().is_active and run.only().finding.value == pytest.approx(hz / 2, rel=0.2)
    run.wait(3 * window_s + 3, hz=hz)
    assert set(run.states().values()) == {"healed"}
    run.wait(max(1.0, 3.6 / (0.8 * hz)) + 0.8)
    assert run.only().is_active and run.only().finding.seen.startswith("silent for ")


def test_a_rate_that_is_too_high_and_one_with_bursts():
    run = talking("rate: /t, is: 9 to 11 Hz")
    run.wait(4, hz=10)
    for _ in range(10):  # all ten of a second at once: the rate is right
        run.arrive("/t", *(run.now_s + n / 1000 for n in range(10)))
        run.wait(1)
    assert "confirmed" not in run.changes("rate /t")
    run.wait(5, hz=20)
    assert run.only().is_active and run.only().finding.value == pytest.approx(20, rel=0.1)


def test_a_topic_that_never_comes_is_a_fault_after_the_grace():
    run = WatchedRun("rate: /t, is: 9 to 11 Hz")
    run.now_s = 1.0
    run.arrive("/t")
    run.wait(13)
    assert run.states() == {}
    run.wait(3)
    assert run.only().is_active and run.only().finding.seen == "no message"


def test_a_parameter_of_a_node_that_never_comes_is_a_fault():
    run = WatchedRun("parameter: speed, node: /ghost, is: 1")
    run.rows(TALKER)
    run.graph(*PAIR)
    run.wait(3)

    assert run.only().is_active and run.only().finding.seen == "there is no node /ghost"


def test_a_probe_that_answers_late_is_no_silence():
    run = talking("rate: /t, is: 9 to 11 Hz", "gap: /t, below: 1 s")
    run.wait(4, hz=10)
    known_s = run.now_s
    for _ in range(15):
        run.story.arrivals_s = known_s
        run.story.now_s = run.now_s
        run.table.look([], run.story)
        for check in run.checks:
            for found in check.look(run.story):
                assert found.finding is None
        run.now_s += 0.2
    run.arrive("/t", *(known_s + n / 10 for n in range(30)))
    run.wait(4, hz=10)
    assert run.reports == []


def test_a_pause_is_seen_while_it_goes_on_and_when_it_was_short():
    run = talking("gap: /t, below: 2 s")
    run.wait(4, hz=5)
    run.wait(2.4)
    assert run.only().is_active and run.only().finding.seen.startswith("silent for 2.")
    run.wait(6, hz=5)
    assert set(run.states().values()) == {"healed"}
    run.arrive("/t", run.now_s + 5)  # both ends of the pause come at once
    run.now_s += 5
    run.look()
    assert run.only().finding.seen.startswith("a pause of ")
    run.wait(1)
    assert run.only().is_active and run.only().life.count == 2


def test_latencies():
    run = talking("latency: /t, below: 50 ms")
    run.wait(5, hz=20, delay_s=0.01)
    assert run.states() == {}
    run.wait(5, hz=20, delay_s=0.2)
    assert run.only().is_active and run.only().finding.value == pytest.approx(0.2)
    run.wait(7, hz=20, delay_s=0.01)
    assert set(run.states().values()) == {"healed"}
    run.wait(10)
    assert set(run.states().values()) == {"healed"}  # nothing comes: another question


# ---- usage


def sampled(run: WatchedRun, seconds: int, **rates: float) -> None:
    """Samples of the talker, one a second; `mib` a second more, `cpu` in percent."""
    rss = run.story.samples["talker-1"][-1][2] if run.story.samples else 50 * MIB
    for _ in range(seconds):
        rss += int(rates.get("mib", 0.0) * MIB)  # type: ignore[operator]
        run.rows({**TALKER, "rss_bytes": rss, "cpu_percent": rates.get("cpu", 1.0)})
        run.wait(1)


def test_memory_that_grows_without_end():
    run = WatchedRun("memory: talker, growth: 6 MB/min")
    sampled(run, 30, mib=0.05)
    assert run.states() == {}
    sampled(run, 9, mib=1.0)
    assert run.only().is_active and run.only().rule == "growth"
    assert "it seems to leak" in str(run.only().cause)
    sampled(run, 70)
    assert set(run.states().values()) == {"healed"}


@pytest.mark.parametrize("before", [0.0, 0.01])
def test_growth_is_reported_since_it_began(before: float):
    run = WatchedRun("memory: talker, growth: 6 MB/min")
    sampled(run, 50, mib=before)
    begun_s = run.now_s
    sampled(run, 20, mib=1.4)
    fault = run.only()
    assert fault.life.first_s == pytest.approx(begun_s, abs=1.5)
    assert run.incidents[0].opened_s == fault.life.first_s
    found = re.search(r"grown by ([\d.]+) MB in (\d+) s", fault.finding.seen)
    assert found is not None and float(found[1]) / int(found[2]) == pytest.approx(1.4, abs=0.1)
    assert fault.finding.value == pytest.approx(1.4 * 60, rel=0.05)


def test_the_start_of_a_process_is_no_growth():
    run = WatchedRun("memory: talker, growth: 1 MB/min")
    for second in range(20):
        size = 20 * MIB + min(second, 8) * 10 * MIB
        run.rows({**TALKER, "rss_bytes": size, "uptime_s": float(second)})
        run.wait(1)
    assert run.states() == {}


def test_the_size_of_memory_and_processor_time():
    run = WatchedRun("memory: talker, below: 100 MB", "cpu: talker, below: 50 %")
    sampled(run, 12, cpu=20.0)
    assert run.states() == {}
    sampled(run, 12, cpu=95.0)
    assert run.only().origin.kind == "cpu" and run.only().rule == "busy process"
    run.rows({**TALKER, "uss_bytes": 200 * MIB})
    run.wait(2)
    assert {fault.origin.kind for fault in run.table.faults.values()} == {"cpu", "memory"}


def test_confirm_and_heal_are_as_the_expectation_says():
    run = talking("node: /talker, confirm: 5 s, heal: 1 s")
    run.wait(1)
    run.graph(subscription("/t"))
    run.wait(4)
    assert set(run.states().values()) == {"suspected"}
    run.wait(2)
    assert run.only().is_active
    run.graph(*PAIR, publisher("/u"))
    run.wait(1.2)
    assert set(run.states().values()) == {"healed"}
