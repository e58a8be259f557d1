"""The operator's side of systemd on a host, without one: framing, the journal, exits, facts."""

from __future__ import annotations

import json
import shlex
import subprocess

import pytest

from launcher.base.model.events import Outcome
from launcher.base.model.spec import RestartMode, RestartPolicy
from launcher.hosts.engine.systemd import host_facts, journal, run_manifest
from launcher.hosts.engine.systemd.exits import outcome_of_record, outcome_of_unit
from launcher.hosts.engine.systemd.journal import JournalLine, JournalReader, Note, UnitMessage
from launcher.hosts.engine.systemd.journal_events import Owners
from launcher.hosts.engine.systemd.recent_output import MUCH, RecentOutput
from launcher.hosts.engine.systemd.samples import Samples
from launcher.hosts.engine.systemd.scripts import read_properties, written
from launcher.hosts.engine.systemd.sessions import HostClock
from launcher.hosts.engine.systemd.shell import Answers, ScriptRequest, ScriptResult
from launcher.hosts.file.order import Order
from tests.support.journal import entry

# ---- the shell


def answers_of(*scripts: str) -> tuple[list[ScriptResult], Answers]:
    """What a real shell answers."""
    got: list[ScriptResult] = []
    answers = Answers(lambda beat: None)
    text = b"".join(answers.framed(ScriptRequest(script, got.append)) for script in scripts)
    done = subprocess.run(["/bin/sh"], input=text, capture_output=True, check=True)
    answers.feed(done.stdout)
    return got, answers


def test_each_script_is_answered_with_its_exit_code():
    got, answers = answers_of("echo one; false", "cat", "echo 'a\nb' >&2", "exit 7")

    assert [(one.code, one.text) for one in got] == [(1, "one"), (0, ""), (0, "a\nb"), (7, "")]
    assert answers.unanswered == []


def test_answers_come_in_any_pieces_with_beats_in_between():
    beats: list[float] = []
    got: list[ScriptResult] = []
    answers = Answers(beats.append)
    answers.framed(ScriptRequest("x", got.append))
    text = b"Welcome!\n\x01H 1.5\x02\x01A 1 0 he\x01H 2.5\x02llo\x02\x01H 3.5\x02"
    for place in range(len(text)):
        answers.feed(text[place : place + 1])

    assert [one.text for one in got] == ["hello"]
    assert beats == [1.5, 2.5, 3.5]


def test_what_was_not_answered_is_known():
    answers = Answers(lambda beat: None)
    first, second = ScriptRequest("a"), ScriptRequest("b", lasts=False)
    answers.framed(first)
    answers.framed(second)

    assert answers.unanswered == [first, second]


@pytest.mark.parametrize("content", [b"", b"a\0b\n\xff", b"E\n" * 50])
def test_files_are_written_as_they_are(tmp_path, content: bytes):
    path = tmp_path / "it's a file"
    subprocess.run(["/bin/sh"], input=written(str(path), content).encode(), check=True)

    assert path.read_bytes() == content


# ---- the journal


def read(*entries: bytes) -> list[object]:
    return list(JournalReader("k3").feed(b"".join(entries)))


def line(message: object, **fields: object) -> JournalLine:
    (one,) = read(entry(SYSLOG_IDENTIFIER="launcher-k3", MESSAGE=message, PRIORITY="6", **fields))
    assert isinstance(one, JournalLine)
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
    assert isinstance(one, JournalLine)
    assert one.stream == "stderr"


def test_records_and_messages():
    note = entry(SYSLOG_IDENTIFIER="launcher-k3-events", MESSAGE="start 1 abc 77")
    message = entry(MESSAGE_ID=journal.FAILED, USER_UNIT="u", UNIT_RESULT="start-limit-hit")
    other = entry(SYSLOG_IDENTIFIER="launcher-other", MESSAGE="x")

    assert read(note, message, other) == [
        Note(("start", "1", "abc", "77"), 0, 2.5),
        UnitMessage(journal.FAILED, "u", 0, "start-limit-hit", 2.5),
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
    found = host_facts.read_facts(text)

    assert (found.version, found.cursor, found.has_launcher) == (254, "c9", True)
    assert found.installed == ("launcher-a", "launcher-b c")
    assert not found.lingers
    assert host_facts.why_unusable(found) == ""
    root = text.replace("uid 1000", "uid 0")
    why = [
        host_facts.why_unusable(host_facts.read_facts(one.replace("state degraded", state)))
        for one, state in ((text, "state offline"), (text, "state "), (root, "state "))
    ]
    assert why == [
        "was not booted with systemd: boot it with systemd",
        "the service manager of me does not answer: install libpam-systemd there",
        "its service manager does not answer: look at systemctl status there",
    ]
    with pytest.raises(KeyError):
        host_facts.read_facts("This account is not available.")


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


def stat(cpu_ticks: int, threads: int = 7, pages: int = 256) -> str:
    """What follows the name in /proc/PID/stat."""
    return (
        f"S 1 1 1 0 -1 4194304 1 0 0 0 {cpu_ticks} 50 0 0 20 0 {threads} 0 100 1000 {pages} "
        + "0 " * 20
    )


def units(up_s: float) -> str:
    """The first line of an answer, so many seconds after the host was started."""
    return f"units 100 4096 {up_s:.2f}"


def test_samples_are_sums_of_all_processes_of_a_unit():
    found = Samples()
    lines = [units(10.0), f"process 77 77 5 {stat(150)}", f"process 77 78 2 {stat(10, 1, 4)}"]

    (first,) = found.read("\n".join(lines), {3: 77}, 10.0).values()
    assert (first["pid"], first["threads"], first["fds"], first["processes"]) == (77, 8, 7, 2)
    assert (first["rss_bytes"], first["uss_bytes"]) == (260 * 4096, None)
    assert first["cpu_percent"] is None
    # One of them has ended, another is new.
    lines = [units(12.0), f"process 77 77 5 {stat(230)}", f"process 77 79 2 {stat(-30)}"]
    memory = [
        "/proc/77/smaps_rollup:Private_Clean: 4 kB",
        "/proc/77/smaps_rollup:Private_Dirty: 8 kB",
    ]
    (second,) = found.read("\n".join([*lines, *memory]), {3: 77}, 12.0).values()
    assert second["cpu_percent"] == pytest.approx((80 + 20) / 2.0)
    assert second["uss_bytes"] == 12 * 1024
    # It stays until it is read again, and that of a restarted process is unknown.
    (third,) = found.read("\n".join(lines), {3: 77}, 15.0).values()
    assert third["uss_bytes"] == 12 * 1024
    again = [units(18.0), f"process 80 80 5 {stat(1)}"]
    (fourth,) = found.read("\n".join(again), {3: 80}, 18.0).values()
    assert (fourth["uss_bytes"], fourth["cpu_percent"]) == (None, None)


def test_memory_is_read_of_new_processes_and_then_every_ten_seconds():
    found = Samples()
    looks = []
    for now in range(0, 60, 3):
        looks.append("grep" in found.script([77], now))
        found.read(f"{units(now)}\nprocess 77 77 5 {stat(1)}", {3: 77}, now)
    assert [3 * n for n, look in enumerate(looks) if look] == [0, 3, 15, 27, 39, 51]


def test_cpu_time_is_divided_by_the_time_between_looks_and_not_between_answers():
    found = Samples()
    for up_s, cpu_ticks, came_s in ((50.0, 0, 10.0), (53.0, 150, 15.9), (56.0, 300, 16.0)):
        text = f"{units(up_s)}\nprocess 77 77 5 {stat(cpu_ticks)}"
        (sample,) = found.read(text, {3: 77}, came_s).values()

    assert sample["cpu_percent"] == pytest.approx(50.0)
    assert found.read("sh: Killed", {3: 77}, 17.0) == {}


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
    text = json.dumps(run_manifest.encode("k3abcd", "t.launch.py", 5.0, {7: order}))

    assert "secret" not in text
    found = run_manifest.decode(text)
    assert (found.run, found.title, found.started) == ("k3abcd", "t.launch.py", 5.0)
    assert (found.orders[7].restart, found.orders[7].number) == (order.restart, 4)
    with pytest.raises(ValueError, match="record"):
        run_manifest.decode("{}")


@pytest.mark.parametrize("run", ["", "..", "../..", "k3abc", "k3abcd\n", "k3/bcd", "K3ABCD", "*"])
def test_a_manifest_with_another_id_is_none(run: str):
    text = json.dumps(run_manifest.encode(run, "t", 5.0, {}))

    with pytest.raises(ValueError, match="id"):
        run_manifest.decode(text)


def test_texts_of_a_manifest_are_shown_without_control_characters():
    document = run_manifest.encode("k3abcd", "a\x1b[2J\nb", 5.0, {})
    found = run_manifest.decode(json.dumps({**document, "operator": "\x9b0m"}))

    assert (found.title, found.operator) == ("a\\x1b[2J\\nb", "\\x9b0m")
