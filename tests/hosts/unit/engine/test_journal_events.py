"""What becomes of entries of the journal of a host: lines by process, starts, marks."""

from __future__ import annotations

from typing import Any, cast

from launcher.base.model.record import replace
from launcher.hosts.engine.systemd import journal, journal_events
from launcher.hosts.engine.systemd.journal import JournalLine, JournalReader, Note
from launcher.hosts.engine.systemd.journal_events import BURST, REST_LOOKS, Flood, JournalEvents
from launcher.hosts.file.order import Order
from launcher.posix.reactor import Reactor
from tests.support.journal import entry


class Unit:
    """A process, as far as the journal has to do with it."""

    def __init__(self, process_id: int) -> None:
        self.process_id = process_id
        self.order = Order(name="a-1", label="a", words=(("a",),), environment={})
        self.starts: list[str] = []

    def wrote(self, size: int) -> None:
        pass

    def noted_start(self, invocation: str, pid: int, at_s: float) -> None:
        self.starts.append(invocation)


class Heard:
    """A listener, as far as lines go."""

    def __init__(self) -> None:
        self.lines: list[tuple[int, bytes, float]] = []
        self.warnings: list[str] = []

    def output(self, process_id: int, stream: str, data: bytes, at_s: float) -> None:
        self.lines.append((process_id, data, at_s))

    def past_complete(self, host: str) -> None:
        self.lines.append((-1, b"past told", 0.0))

    def warn(self, host: str, text: str) -> None:
        self.warnings.append(text)


def events_of(reactor: Reactor, heard: Heard, units: dict[int, Unit]) -> JournalEvents:
    return JournalEvents("bot1", cast(Any, heard), reactor, cast(Any, units))


def lone_line(pid: int, text: bytes, stream_id: str = "", at_s: float = 1.0) -> JournalLine:
    """One whose unit the journal does not know."""
    return JournalLine("", pid, 0, stream_id, "stdout", text, at_s)


def attached(reactor: Reactor) -> tuple[JournalEvents, Unit, Heard]:
    """At a run that was attached to at 5 s."""
    heard, unit = Heard(), Unit(3)
    events = events_of(reactor, heard, {3: unit})
    events.by_unit["u"] = 3
    events.begin(5.0)
    return events, unit, heard


def test_a_flood_is_told_once():
    flood = Flood()

    assert [flood.is_above(1.0) for _ in range(2 * BURST)].count(True) == 1


def test_a_mark_comes_with_its_record_or_when_nothing_comes_any_more(monkeypatch):
    monkeypatch.setattr(journal_events, "SILENT_S", 0.3)
    came: list[str] = []
    with Reactor() as reactor:
        events = events_of(reactor, Heard(), {})
        events.when_marked("a", lambda: came.append("a"))
        begun_s = reactor.now()
        events.when_marked("b", lambda: came.append("b"))
        events.feed(Note(words=("mark", "a"), uid=0, monotonic_s=1.0), 1.0)
        while len(came) < 2:
            reactor.turn()
        assert came == ["a", "b"]
        assert reactor.now() >= begun_s + 0.3  # the second was awaited
        events.close()


def test_silence_is_told_after_what_is_not_finished(monkeypatch):
    monkeypatch.setattr(journal_events, "REST_PERIOD_S", 0.02)
    heard = Heard()
    with Reactor() as reactor:
        events = events_of(reactor, heard, {3: Unit(3)})
        events.by_unit["u"] = 3

        def write(text: bytes) -> None:
            events.feed(JournalLine("u", 7, 0, "s", "stdout", text, 1.0), 1.0)

        write(b"a line\n")
        write(b"a piece of ")
        events.is_paused = True
        end_s = reactor.now() + 2 * REST_LOOKS * 0.02
        while reactor.now() < end_s:
            reactor.turn()
        assert [text for _, text, _ in heard.lines] == [b"a line\n", b"a piece of "]
        events.is_paused = False
        while heard.lines[-1][1]:
            reactor.turn()
        assert "rest" not in events._timers
        events.close()


def test_lines_of_what_ran_before_it_was_attached_to_are_of_it():
    with Reactor() as reactor:
        events, unit, heard = attached(reactor)
        events.feed(lone_line(70, b"early\n"), 1.0)  # the record of its start comes after it
        events.feed(Note(("start", "3", "i1", "70"), 0, 1.5), 1.5)
        events.feed(Note(("start", "3", "i2", "71"), 0, 2.0), 2.0)
        events.started(3, 77)  # as systemd has said it
        events.feed(lone_line(77, b"one\n", "s1"), 3.0)
        events.feed(lone_line(78, b"of a child\n", "s1"), 4.0)
        events.feed(lone_line(71, b"late\n"), 4.5)
        events.close()

    assert [line[1:] for line in heard.lines] == [
        (b"early\n", 1.0),
        (b"one\n", 3.0),
        (b"of a child\n", 4.0),
        (b"late\n", 4.5),
    ]
    assert unit.starts == []  # they are past
    assert heard.warnings == []


def test_the_past_ends_with_the_first_entry_of_now():
    with Reactor() as reactor:
        events, _, heard = attached(reactor)
        events.started(3, 77)
        events.feed(Note(("mark", "m0"), 0, 4.8), 4.8)  # of an earlier launcher
        events.feed(lone_line(77, b"a\n", at_s=4.9), 4.9)
        events.feed(lone_line(77, b"b\n", at_s=5.0), 5.0)
        events.end_past()
        events.close()

    assert [data for _, data, _ in heard.lines] == [b"a\n", b"past told", b"b\n"]


def test_lines_after_a_restart_of_what_was_attached_to_are_of_it():
    with Reactor() as reactor:
        events, unit, heard = attached(reactor)
        events.started(3, 77)
        events.feed(lone_line(78, b"new\n", "s2", 6.0), 6.0)
        events.feed(Note(("start", "3", "i3", "78"), 0, 6.1), 6.1)
        events.feed(lone_line(79, b"of its child\n", "s2", 6.2), 6.2)
        events.close()

    assert [data for _, data, _ in heard.lines] == [b"past told", b"new\n", b"of its child\n"]
    assert unit.starts == ["i3"]


def test_a_stream_says_itself_whose_it_is():
    text = f"{journal.announcement(3)}\n".encode()
    with Reactor() as reactor:
        events, _, heard = attached(reactor)
        for one in (text, b"of a child that has ended\n", text):  # also told twice
            events.feed(lone_line(79, one, "s3"), 6.0)
        events.close()

    assert [data for _, data, _ in heard.lines] == [b"of a child that has ended\n"]
    assert journal.announced(lone_line(3, b"launcher: output of x\n", "s3")) == -1


def test_a_process_may_write_what_streams_begin_with():
    text = f"{journal.announcement(3)}\n".encode()
    with Reactor() as reactor:
        heard, units = Heard(), {3: Unit(3), 4: Unit(4)}
        events = events_of(reactor, heard, units)
        events.by_unit.update(u=3, v=4)
        events.feed(JournalLine("v", 80, 0, "s4", "stdout", text, 1.0), 1.0)  # another one
        units[3].order = replace(units[3].order, merge=True)  # has no such streams
        events.feed(JournalLine("u", 70, 0, "s3", "stdout", text, 1.0), 1.0)
        events.uid = 1000  # all streams of a user begin so
        events.feed(JournalLine("u", 70, 1000, "s5", "stdout", text, 1.0), 1.0)
        events.feed(lone_line(71, b"of a child\n", "s5"), 1.0)
        events.close()

    found = [(number, data) for number, data, _ in heard.lines]
    assert found == [(4, text), (3, text), (3, b"of a child\n")]


def test_an_unfinished_line_of_a_past_life_of_a_process_ends_there():
    with Reactor() as reactor:
        events, _, heard = attached(reactor)
        for at_s in (4.0, 6.0):  # the exit that ends the second one is told
            (one,) = JournalReader("k3").feed(
                entry(
                    SYSLOG_IDENTIFIER="launcher-k3",
                    MESSAGE="abc",
                    _LINE_BREAK="eof",
                    _SYSTEMD_UNIT="u",
                    __MONOTONIC_TIMESTAMP=f"{at_s:.0f}000000",
                )
            )
            events.feed(one, at_s)
        events.close()

    assert [data for _, data, _ in heard.lines] == [b"abc\n", b"past told", b"abc"]


def test_output_of_an_unknown_process_is_told_without_colours(monkeypatch):
    monkeypatch.setattr(journal_events, "LIMBO_S", 0.0)
    with Reactor() as reactor:
        events, _, heard = attached(reactor)
        events.feed(lone_line(99, b"\x1b[0mred\x1b[31m\n"), 1.0)
        while not heard.warnings:
            reactor.turn()
        events.close()

    assert heard.warnings == ["1 line of an unknown process; the first: red"]
