"""The operator's side of systemd on a host, without one: framing, the journal, exits, facts."""

from __future__ import annotations

import json
import shlex
import subprocess
from types import SimpleNamespace

import pytest

from launcher.engine.hosts import backlog
from launcher.engine.hosts.backlog import Backlog, last_lines
from launcher.engine.hosts.driver import HostsDriver
from launcher.engine.hosts.link import LinkState
from launcher.engine.hosts.systemd import facts, journal, journal_events, manifest, samples
from launcher.engine.hosts.systemd.clock import HostClock
from launcher.engine.hosts.systemd.exits import outcome_of_record, outcome_of_unit
from launcher.engine.hosts.systemd.journal import JournalReader, Line, Message, Note
from launcher.engine.hosts.systemd.journal_events import BURST, Flood, JournalEvents
from launcher.engine.hosts.systemd.owners import Owners
from launcher.engine.hosts.systemd.recent_output import MUCH, RecentOutput
from launcher.engine.hosts.systemd.scripts import read_properties, written
from launcher.engine.hosts.systemd.shell import Answer, Answers, Request
from launcher.engine.posix.reactor import Reactor
from launcher.hosts.order import Order
from launcher.model.events import Outcome
from launcher.model.record import replace
from launcher.model.spec import RestartMode, RestartPolicy

# ---- the shell


def answers_of(*scripts: str) -> tuple[list[Answer], Answers]:
    """What a real shell answers."""
    got: list[Answer] = []
    answers = Answers(lambda beat: None)
    text = b"".join(answers.framed(Request(script, got.append)) for script in scripts)
    done = subprocess.run(["/bin/sh"], input=text, capture_output=True, check=True)
    answers.feed(done.stdout)
    return got, answers


def test_each_script_is_answered_with_its_exit_code():
    got, answers = answers_of("echo one; false", "cat", "echo 'a\nb' >&2", "exit 7")

    assert [(one.code, one.text) for one in got] == [(1, "one"), (0, ""), (0, "a\nb"), (7, "")]
    assert answers.unanswered == []


def test_answers_come_in_any_pieces_with_beats_in_between():
    beats: list[float] = []
    got: list[Answer] = []
    answers = Answers(beats.append)
    answers.framed(Request("x", got.append))
    text = b"Welcome!\n\x01H 1.5\x02\x01A 1 0 he\x01H 2.5\x02llo\x02\x01H 3.5\x02"
    for place in range(len(text)):
        answers.feed(text[place : place + 1])

    assert [one.text for one in got] == ["hello"]
    assert beats == [1.5, 2.5, 3.5]


def test_what_was_not_answered_is_known():
    answers = Answers(lambda beat: None)
    first, second = Request("a"), Request("b", lasts=False)
    answers.framed(first)
    answers.framed(second)

    assert answers.unanswered == [first, second]


@pytest.mark.parametrize("content", [b"", b"a\0b\n\xff", b"E\n" * 50])
def test_files_are_written_as_they_are(tmp_path, content: bytes):
    path = tmp_path / "it's a file"
    subprocess.run(["/bin/sh"], input=written(str(path), content).encode(), check=True)

    assert path.read_bytes() == content


# ---- the journal


def entry(**fields: object) -> bytes:
    general = {"__CURSOR": "c1", "__MONOTONIC_TIMESTAMP": "2500000", "_UID": "0"}
    return json.dumps({**general, **fields}).encode() + b"\n"


def read(*entries: bytes) -> list[object]:
    return list(JournalReader("k3").feed(b"".join(entries)))


def line(message: object, **fields: object) -> Line:
    (one,) = read(entry(SYSLOG_IDENTIFIER="launcher-k3", MESSAGE=message, PRIORITY="6", **fields))
    assert isinstance(one, Line)
    return one


@pytest.mark.parametrize(
    ("message", "data"),
    [
        ("grün", "grün\n".encode()),
        ([27, 91, 49, 109, 255], b"\x1b[1m\xff\n"),
        (None, b"\n"),
        (["first", "second"], b"first\n"),
    ],
)
def test_messages_of_all_kinds_are_bytes(message: object, data: bytes):
    assert line(message).data == data


def test_pieces_of_a_long_line_are_one_line():
    assert line("x", _LINE_BREAK="line-max").data == b"x"
    assert line("x", _LINE_BREAK="eof").data == b"x"
    assert line("x", _LINE_BREAK="pid-change").data == b"x\n"


def test_streams_are_told_by_their_priority():
    assert line("x").stream == "stdout"
    (one,) = read(entry(SYSLOG_IDENTIFIER="launcher-k3", MESSAGE="x", PRIORITY="5"))
    assert isinstance(one, Line)
    assert one.stream == "stderr"


def test_records_and_messages():
    note = entry(SYSLOG_IDENTIFIER="launcher-k3-events", MESSAGE="start 1 abc 77")
    message = entry(MESSAGE_ID=journal.FAILED, USER_UNIT="u", UNIT_RESULT="start-limit-hit")
    other = entry(SYSLOG_IDENTIFIER="launcher-other", MESSAGE="x")

    assert read(note, message, other) == [
        Note(("start", "1", "abc", "77"), 0, 2.5),
        Message(journal.FAILED, "u", 0, "start-limit-hit", 2.5),
    ]


def test_the_cursor_is_behind_whole_entries():
    reader = JournalReader("k3")
    one, other = entry(__CURSOR="c1"), entry(__CURSOR="c2")

    assert list(reader.feed(one + other[:-5])) == []
    assert reader.cursor == "c1"
    reader.restart()
    assert list(reader.feed(b"no json\n" + other)) == []
    assert (reader.cursor, reader.damaged) == ("c2", 1)


def test_the_journal_is_followed_from_behind_the_cursor():
    assert "--after-cursor=c1" in journal.words("k3", "c1")
    assert "--cursor=c0" in journal.words("k3", None, first="c0")
    assert "--after-cursor=c1" in journal.words("k3", "c1", first="c0")
    assert "--since=now" in journal.words("k3", None)


def test_the_past_has_the_first_of_the_last_lines_and_what_says_whose_they_are():
    def note(second: int) -> bytes:
        text, at = f"start 1 i{second} 7{second}", f"{second}000000"
        return entry(SYSLOG_IDENTIFIER="launcher-k3-events", MESSAGE=text, __MONOTONIC_TIMESTAMP=at)

    def line(text: str, cursor: str) -> bytes:
        return entry(
            SYSLOG_IDENTIFIER="launcher-k3", MESSAGE=text, __CURSOR=cursor, _STREAM_ID="s1"
        )

    told = [note(1), note(3), line(journal.announcement(1), "c3")]
    text = b"".join([*told, line("x", "c5")]).decode()
    notes, lines, cursor = journal.read_past("k3", text, 4.0)

    assert cursor == "c5"
    assert [one.words[3] for one in notes] == ["71"]
    assert [journal.announced(one) for one in lines] == [1]
    notes, lines, cursor = journal.read_past("k3", text, 2.0)
    assert (len(notes), len(lines), cursor) == (1, 1, None)  # the line is one of those since then
    notes, lines, cursor = journal.read_past("k3", b"".join(told[:2]).decode(), 4.0)
    assert (len(notes), lines, cursor) == (2, [], None)
    assert journal.read_past("k3", "", 4.0) == ([], [], None)


def test_the_past_is_asked_for_by_what_lines_are_and_not_by_all_entries():
    _, records, streams, output = journal.past("k3", 5, 1000, [3, 7]).splitlines()

    assert records.endswith("SYSLOG_IDENTIFIER=launcher-k3-events _UID=1000")
    texts = ["MESSAGE=launcher: output of 3", "MESSAGE=launcher: output of 7"]
    assert shlex.split(streams)[-3:] == ["SYSLOG_IDENTIFIER=launcher-k3", *texts]
    assert "--lines=200 " in streams
    assert "--lines=35 SYSLOG_IDENTIFIER=launcher-k3 " in output
    assert "MESSAGE=" not in (past := journal.past("k3", 0, 0, []))
    assert "--lines=1 SYSLOG_IDENTIFIER=launcher-k3 " in past  # new lines are behind it


def test_a_cursor_is_gone_if_another_entry_is_at_its_place():
    assert not journal.is_gone("c1", '{"__CURSOR":"c1"}')
    assert journal.is_gone("c1", '{"__CURSOR":"c2"}')
    assert not journal.is_gone("c1", "")  # it may not be read
    assert "'--cursor=s=1;i=2'" in journal.entry_at("s=1;i=2")


# ---- exits


@pytest.mark.parametrize(
    ("record", "outcome"),
    [
        (("exit-code", "exited", "3"), Outcome(returncode=3)),
        (("signal", "killed", "KILL"), Outcome(returncode=-9)),
        (("oom-kill", "killed", "KILL"), Outcome(returncode=-9, out_of_memory=True)),
        (("core-dump", "dumped", "SEGV"), Outcome(returncode=-11, core_dumped=True)),
        (("signal", "killed", "RTMIN+3"), Outcome(returncode=-37)),
    ],
)
def test_exits_by_their_record(record: tuple[str, str, str], outcome: Outcome):
    assert outcome_of_record(*record) == outcome


def test_exits_by_the_properties_of_the_unit():
    text = "Id=a\nExecMainCode=1\nExecMainStatus=4\n\nId=b\nExecMainCode=2\nExecMainStatus=15\n"
    one, other = read_properties(text)

    assert outcome_of_unit(one) == Outcome(returncode=4)
    assert outcome_of_unit(other) == Outcome(returncode=-15)
    assert outcome_of_unit({}) == Outcome(returncode=-9)


# ---- the rest


def test_the_clock_takes_the_fastest_of_the_first_beats():
    clock = HostClock()
    for late in (0.3, 0.1, 0.2):
        clock.heard(10.0, 110.0 + late)

    assert clock.here(20.0, 500.0) == pytest.approx(120.1)
    assert clock.here(20.0, 119.0) == 119.0  # not in the future


def test_facts():
    text = (
        "uid 1000\nuser me\nhome /home/me\nruntime /run/user/1000\nversion 254.5-1\n"
        "state degraded\nboot_id x\nuptime_s 5.5\n"
        "installed launcher-a\ninstalled launcher-b c\n"
        'entry {"__CURSOR":"c9"}\npython ./p\nlauncher yes\n'
    )
    found = facts.read_facts(text)

    assert (found.version, found.cursor, found.has_launcher) == (254, "c9", True)
    assert found.installed == ("launcher-a", "launcher-b c")
    assert not found.lingers
    assert facts.why_unusable(found) == ""
    root = text.replace("uid 1000", "uid 0")
    why = [
        facts.why_unusable(facts.read_facts(one.replace("state degraded", state)))
        for one, state in ((text, "state offline"), (text, "state "), (root, "state "))
    ]
    assert why == [
        "was not booted with systemd: boot it with systemd",
        "the service manager of me does not answer: install libpam-systemd there",
        "its service manager does not answer: look at systemctl status there",
    ]
    with pytest.raises(KeyError):
        facts.read_facts("This account is not available.")


def test_much_output_may_have_more_behind_it():
    recent = RecentOutput()
    recent.add(10)
    recent.ended()
    assert not recent.may_be_behind
    recent.add(MUCH)
    recent.add(1)
    recent.ended()
    assert recent.may_be_behind
    recent.looked()
    assert not recent.may_be_behind
    recent.ended()  # the next time
    assert not recent.may_be_behind


def test_owners_of_output_are_forgotten_with_the_starts_after_the_next():
    owners = Owners()
    for start in range(1000):
        owners.started(7, pid=100 + start % 3)
        owners.add(f"stream{start}", 7)
        owners.started(8, pid=5)  # the same again and again

    assert [owners.get(f"stream{start}") for start in (997, 998, 999)] == [None, 7, 7]
    assert (owners.get(100), owners.get(5)) == (7, 8)
    assert len(owners) == 5


def test_a_flood_is_told_once():
    flood = Flood()

    assert [flood.is_above(1.0) for _ in range(2 * BURST)].count(True) == 1


def test_a_mark_comes_with_its_record_or_when_nothing_comes_any_more(monkeypatch):
    monkeypatch.setattr(journal_events, "SILENT_S", 0.3)
    came: list[str] = []
    with Reactor() as reactor:
        events = JournalEvents("bot1", None, reactor, {})  # type: ignore[arg-type]
        events.when_marked("a", lambda: came.append("a"))
        events.when_marked("b", lambda: came.append("b"))
        events.feed(Note(words=("mark", "a"), uid=0, monotonic_s=1.0), 1.0)
        until_s = reactor.now() + 0.3
        while len(came) < 2:
            reactor.turn()
        assert came == ["a", "b"]
        assert reactor.now() >= until_s - 0.1  # the second was awaited
        events.close()


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

    def past_told(self, host: str) -> None:
        self.lines.append((-1, b"past told", 0.0))

    def warn(self, host: str, text: str) -> None:
        self.warnings.append(text)


def lone_line(pid: int, text: bytes, stream_id: str = "", at_s: float = 1.0) -> Line:
    """One whose unit the journal does not know."""
    return Line("", pid, 0, stream_id, "stdout", text, at_s)


def attached(reactor: Reactor) -> tuple[JournalEvents, Unit, Heard]:
    """At a run that was attached to at 5 s."""
    heard, unit = Heard(), Unit(3)
    events = JournalEvents("bot1", heard, reactor, {3: unit})  # type: ignore[arg-type, dict-item]
    events.by_unit["u"] = 3
    events.begin(5.0)
    return events, unit, heard


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


@pytest.mark.parametrize(
    ("state", "is_shown"), [(LinkState.UNREACHABLE, False), (LinkState.GONE, True)]
)
def test_the_past_of_a_host_is_awaited_as_long_as_it_may_return(state: LinkState, is_shown: bool):
    shown: list[bytes] = []
    reader = SimpleNamespace(feed=lambda process, stream, data, at_s: shown.append(data))
    fleet = SimpleNamespace(pause=None, named=str, link_changed=lambda *state: None)
    with Reactor() as reactor:
        driver = HostsDriver(reactor, reader, None, None, fleet)  # type: ignore[arg-type]
        driver._remote[1] = SimpleNamespace(host=SimpleNamespace(name="bot1", lines=0))  # type: ignore[assignment]
        driver.begin_with(1, ["bot1", "bot2"])
        driver.output(1, "both", b"past\n", 1.0)
        driver.link_changed("bot1", state, "")
        driver.past_told("bot2")

    assert bool(shown) == is_shown


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
        events = JournalEvents("bot1", heard, reactor, units)  # type: ignore[arg-type]
        events.by_unit.update(u=3, v=4)
        events.feed(Line("v", 80, 0, "s4", "stdout", text, 1.0), 1.0)  # another one
        units[3].order = replace(units[3].order, merge=True)  # has no such streams
        events.feed(Line("u", 70, 0, "s3", "stdout", text, 1.0), 1.0)
        events.close()

    assert [(number, data) for number, data, _ in heard.lines] == [(4, text), (3, text)]


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

    assert heard.warnings == ["output of an unknown process: red"]


# ---- the last lines of a run that is attached to


def test_the_last_lines_are_those_of_all_hosts():
    held = [
        (1, "both", b"a1\n", 1.0),
        (1, "both", b"a3\n", 3.0),
        (2, "both", b"b2\n", 2.0),
        (2, "both", b"b4 ", 4.0),  # a long line in pieces
        (2, "both", b"b4\n", 4.1),
        (3, "both", b"unfinished", 5.0),
    ]

    assert [one[2] for one in last_lines(held, 3)] == [b"a3\n", b"b4 ", b"b4\n", b"unfinished"]
    assert [one[2] for one in last_lines(held, 9)][:3] == [b"a1\n", b"b2\n", b"a3\n"]
    assert last_lines(held, 0) == []


class Begun(Backlog):
    """Of two hosts, the last two lines; `shown` is what it has shown."""

    def __init__(self, reactor: Reactor, lines: int = 2) -> None:
        self.shown: list[bytes] = []
        show = lambda number, stream, data, at_s: self.shown.append(data)  # noqa: E731
        super().__init__(lines, ("bot1", "bot2"), reactor, show)

    def line(self, host: str, data: bytes, at_s: float) -> None:
        self.add(host, (1, "both", data, at_s))


def test_output_is_held_until_all_hosts_have_told_their_last_lines():
    with Reactor() as reactor:
        one = Begun(reactor)
        one.line("bot2", b"b2\n", 2.0)
        one.line("bot1", b"a1\n", 1.0)
        one.line("bot1", b"a3\n", 3.0)
        one.told("bot1")
        assert one.shown == []
        one.told("bot2")
        one.told("bot2")
        one.close()

    assert one.shown == [b"b2\n", b"a3\n"]


@pytest.mark.parametrize("lines", [0, 2])
def test_new_output_is_not_cut(lines: int):
    new = [b"%d\n" % number for number in range(5)]
    with Reactor() as reactor:
        one = Begun(reactor, lines)
        one.line("bot1", b"past\n", 1.0)
        one.told("bot1")
        for data in new:
            one.line("bot1", data, 2.0)
        one.told("bot2")
        one.line("bot2", b"last\n", 3.0)

    assert one.shown == [b"past\n", *new, b"last\n"][not lines :]


@pytest.mark.parametrize("is_event", [False, True])
def test_the_past_of_a_late_host_is_cut_and_in_order(monkeypatch, is_event: bool):
    monkeypatch.setattr(backlog, "WAIT_S", 0.1)
    with Reactor() as reactor:
        one = Begun(reactor)
        one.line("bot1", b"a\n", 2.0)
        one.line("bot2", b"b1\n", 1.0)
        one.told("bot1")
        if is_event:
            one.flush()
        while not one.shown:
            reactor.turn()
        one.line("bot1", b"new\n", 9.0)
        one.line("bot2", b"b4\n", 4.0)
        one.line("bot2", b"b3\n", 3.0)
        assert one.shown == [b"a\n", b"new\n"]
        one.told("bot2")

    assert one.shown == [b"a\n", b"new\n", b"b3\n", b"b4\n"]


def test_all_that_is_held_is_shown_at_the_end():
    with Reactor() as reactor:
        one = Begun(reactor)
        one.line("bot1", b"a\n", 1.0)
        one.close()

    assert one.shown == [b"a\n"]


def test_samples_come_from_proc():
    stat = "S 1 1 1 0 -1 4194304 1 0 0 0 150 50 0 0 20 0 7 0 100 1000 256 " + "0 " * 20
    found = samples.Samples()

    (first,) = found.read(f"units 100 4096\n77 5 {stat}", {3: 77}, 10.0).values()
    assert (first["pid"], first["threads"], first["rss_bytes"]) == (77, 7, 256 * 4096)
    assert first["cpu_percent"] is None
    later = stat.replace(" 150 50 ", " 250 50 ")
    (second,) = found.read(f"units 100 4096\n77 5 {later}", {3: 77}, 12.0).values()
    assert second["cpu_percent"] == pytest.approx(50.0)


def test_a_manifest_has_no_values_of_variables():
    order = Order(
        name="a-1",
        label="a",
        words=(("/bin/a",),),
        environment={"TOKEN": "secret"},
        files={"f": b"secret"},
        restart=RestartPolicy(RestartMode.ALWAYS, delay_s=2.0),
        number=4,
    )
    text = json.dumps(manifest.encode("k3abcd", "t.launch.py", 5.0, {7: order}))

    assert "secret" not in text
    found = manifest.decode(text)
    assert (found.run, found.title, found.started) == ("k3abcd", "t.launch.py", 5.0)
    assert (found.orders[7].restart, found.orders[7].number) == (order.restart, 4)
    with pytest.raises(ValueError, match="record"):
        manifest.decode("{}")


@pytest.mark.parametrize("run", ["", "..", "../..", "k3abc", "k3abcd\n", "k3/bcd", "K3ABCD", "*"])
def test_a_manifest_with_another_id_is_none(run: str):
    text = json.dumps(manifest.encode(run, "t", 5.0, {}))

    with pytest.raises(ValueError, match="id"):
        manifest.decode(text)


def test_texts_of_a_manifest_are_shown_without_control_characters():
    document = manifest.encode("k3abcd", "a\x1b[2J\nb", 5.0, {})
    found = manifest.decode(json.dumps({**document, "operator": "\x9b0m"}))

    assert (found.title, found.operator) == ("a\\x1b[2J\\nb", "\\x9b0m")
