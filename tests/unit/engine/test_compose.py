"""Composed processes: what the launch file is told of them, and whose line is whose."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from launcher.engine.compose.core import ComposedCore, Composition
from launcher.engine.compose.output import GroupOutput
from launcher.errors import LauncherError
from launcher.model import events
from launcher.model.record import replace
from launcher.model.spec import ProcessSpec

GROUP = 1 << 29


def spec(name: str, *, is_essential: bool = False) -> ProcessSpec:
    label = name.rpartition("-")[0]
    return ProcessSpec(name=name, label=label, argv=("p",), env={}, is_essential=is_essential)


class RecordingCore:
    """Starts three processes, of which 1 and 3 are composed; answers events as it is told."""

    def __init__(self) -> None:
        self.seen: list[events.Event] = []
        self.answers: list[events.Effect] = []
        self.has_failed = False

    def start(self) -> Sequence[events.Effect]:
        return [events.StartProcess(number, spec(f"p-{number}")) for number in (1, 2, 3)]

    def handle(self, event: events.Event) -> Sequence[events.Effect]:
        self.seen.append(event)
        answers, self.answers = self.answers, []
        return answers

    def watches_output(self, process_id: int) -> bool:
        return True

    def plan(self) -> dict[str, object]:
        return {"a": 1}

    def plan_lines(self) -> Sequence[str]:
        return ["a"]

    def intentions(self) -> Sequence[str]:
        return ["b"]


def composed(*, essential: bool = False) -> tuple[ComposedCore, RecordingCore]:
    inner = RecordingCore()
    members = (spec("p-1"), spec("p-3", is_essential=essential))
    group = replace(spec("composed-1"), members=members)

    def late(one: ProcessSpec) -> str | None:
        return f"{one.name} is late" if one.label == "p" else None

    core = ComposedCore(inner, Composition(((group, (1, 3)),), ("why",)), late)
    effects = core.start()
    assert effects == [
        events.LogMessage(logger="launch", level="INFO", text="why"),
        events.StartProcess(GROUP, group),
        events.StartProcess(2, spec("p-2")),
    ]
    return core, inner


def test_events_of_the_group_are_those_of_its_members():
    core, inner = composed()
    core.handle(events.ProcessStarted(GROUP, 77))
    core.handle(events.ProcessStarted(2, 78))
    assert inner.seen == [
        events.ProcessStarted(number, pid) for number, pid in ((1, 77), (3, 77), (2, 78))
    ]
    inner.seen.clear()
    core.handle(events.SpawnFailed(GROUP, 2, "no such file", will_restart=True))
    assert inner.seen == [
        events.SpawnFailed(number, 2, "no such file", will_restart=True) for number in (1, 3)
    ]


def test_a_member_that_ends_by_itself_is_told_once():
    core, inner = composed()
    core.handle(events.ProcessStarted(GROUP, 77))
    inner.seen.clear()
    core.handle(events.MemberExited(GROUP, 0, 77, 0))
    assert inner.seen == [events.ProcessExited(1, 77, 0)]
    core.handle(events.ProcessExited(GROUP, 77, -9))
    assert inner.seen[1:] == [events.ProcessExited(3, 77, -9)]


def test_a_member_that_takes_the_group_with_it_is_told_with_its_own_code_at_the_end():
    core, inner = composed()
    core.handle(events.ProcessStarted(GROUP, 77))
    inner.seen.clear()
    core.handle(events.MemberExited(GROUP, 1, 77, 3))
    core.handle(events.MemberExited(GROUP, 0, 77, -2))
    assert inner.seen == []
    core.handle(events.ProcessExited(GROUP, 77, 3, will_restart=True))
    assert inner.seen == [
        events.ProcessExited(1, 77, -2, will_restart=True),
        events.ProcessExited(3, 77, 3, will_restart=True),
    ]
    inner.seen.clear()
    core.handle(events.ProcessStarted(GROUP, 80))  # all of them begin again
    core.handle(events.ProcessExited(GROUP, 80, 0))
    assert inner.seen[2:] == [events.ProcessExited(number, 80, 0) for number in (1, 3)]


def test_members_of_a_group_that_is_restarted_are_told_when_it_has_ended():
    core, inner = composed()
    core.handle(events.ProcessStarted(GROUP, 77))
    inner.seen.clear()
    for index in (0, 1):
        core.handle(events.MemberExited(GROUP, index, 77, 0, with_process=True))
    assert inner.seen == []
    core.handle(events.ProcessExited(GROUP, 77, 0, will_restart=True))
    assert inner.seen == [
        events.ProcessExited(number, 77, 0, will_restart=True) for number in (1, 3)
    ]


def test_an_essential_member_is_told_at_the_end_of_the_group():
    core, inner = composed(essential=True)
    core.handle(events.ProcessStarted(GROUP, 77))
    inner.seen.clear()
    core.handle(events.MemberExited(GROUP, 1, 77, 0))
    assert inner.seen == []
    core.handle(events.ProcessExited(GROUP, 77, 0))
    assert inner.seen == [events.ProcessExited(number, 77, 0) for number in (1, 3)]


def test_effects_on_a_member_become_requests_to_the_group():
    core, inner = composed()
    inner.answers = [
        events.SignalProcess(3, 15),
        events.StopProcess(1),
        events.WriteStdin(1, b"x"),
        events.StopProcess(2),
        events.CancelTimer(1),
        events.StartProcess(9, spec("p-9")),
        events.StartProcess(10, spec("q-10")),
    ]
    effects = core.handle(events.TimerFired(5))
    warning = "p-1 is composed, and has no standard input"
    assert effects == [
        events.WriteStdin(GROUP, b"1 15\n"),
        events.WriteStdin(GROUP, b"0 2\n"),
        events.LogMessage(logger="launch", level="WARNING", text=warning),
        events.StopProcess(2),
        events.CancelTimer(1),
        events.LogMessage(logger="launch", level="INFO", text="p-9 is late"),
        events.StartProcess(9, spec("p-9")),
        events.StartProcess(10, spec("q-10")),
    ]


def test_the_rest_is_that_of_the_core():
    core, inner = composed()
    assert (core.plan(), core.plan_lines(), core.intentions()) == ({"a": 1}, ["a"], ["b"])
    assert (core.watches_output(GROUP), core.watches_output(2)) == (False, True)
    inner.has_failed = True
    assert core.has_failed
    with pytest.raises(LauncherError, match="cannot be reloaded"):
        core.evaluate_again()
    with pytest.raises(LauncherError, match="cannot be reloaded"):
        core.launch_files()


# ---- output


TOKEN = "0123456789abcdef" * 2


class Told:
    def __init__(self) -> None:
        self.events: list[tuple[int, Sequence[str]]] = []
        names = [("a-1", b"[a] "), ("b-2", b"[b] ")]
        tell = lambda index, words: self.events.append((index, words))  # noqa: E731
        self.output = GroupOutput(("group-1", b"[g] "), names, tell)
        assert list(self.output.parts(f"\x1e\x1d{TOKEN}\n".encode())) == []

    def parts(self, text: str) -> list[tuple[str, str]]:
        return [(one.name, one.lines.decode()) for one in self.output.parts(text.encode())]


def log(logger: str, text: str = "hello") -> str:
    return f"[INFO] [1795628591.310558812] [{logger}]: {text}\n"


def test_marked_lines_are_those_of_their_member():
    told = Told()
    assert told.parts("\x1e0\x1fone\n\x1e0\x1ftwo\n\x1e1\x1f\nplain\n") == [
        ("a-1", "one\ntwo\n"),
        ("b-2", "\n"),
        ("group-1", "plain\n"),
    ]
    (first, *_) = told.output.parts(b"\x1e1\x1fx\n")
    assert (first.prefix, first.kept) == (b"[b] ", b"[b-2] x\n")


def test_lines_of_rcl_are_told_apart_by_their_logger():
    told = Told()
    assert told.parts(log("fleet.a")) == [("group-1", log("fleet.a"))]
    told.parts(f"\x1e0\x1d{TOKEN} node /fleet/a fleet.a\n\x1e1\x1d{TOKEN} node /b b\n")
    colour = f"\x1b[33m{log('b.part.deep')}"
    assert told.parts(log("fleet.a") + colour + log("rcl") + log("bb")) == [
        ("a-1", log("fleet.a")),
        ("b-2", colour),
        ("group-1", log("rcl") + log("bb")),
    ]
    assert told.output.nodes == {"/fleet/a": 0, "/b": 1}


def test_what_follows_a_line_of_a_logger_belongs_to_it_in_the_same_block():
    told = Told()
    told.parts(f"\x1e0\x1d{TOKEN} node /a a\n")
    assert told.parts(f"x\n{log('a')}  second\nthird\n\x1e1\x1fy\n") == [
        ("group-1", "x\n"),
        ("a-1", f"{log('a')}  second\nthird\n"),
        ("b-2", "y\n"),
    ]
    assert told.parts("third\n") == [("group-1", "third\n")]


def test_a_logger_of_two_members_is_that_of_none():
    told = Told()
    told.parts(f"\x1e0\x1d{TOKEN} node /a a\n\x1e1\x1d{TOKEN} node /a a\n")
    assert told.parts(log("a")) == [("group-1", log("a"))]


def test_events_are_told_and_not_shown():
    told = Told()
    assert told.parts(f"\x1e0\x1fa\n\x1e1\x1d{TOKEN} exit -2\r\n\x1e0\x1fb\n") == [
        ("a-1", "a\n"),
        ("a-1", "b\n"),
    ]
    assert told.events == [(1, ["exit", "-2"])]


@pytest.mark.parametrize(
    "line", ["\x1e0\x1dexit 1", "\x1e0\x1d", f"\x1e0\x1d{'f' * 32} exit 1", f"\x1e\x1d{'f' * 32}"]
)
def test_a_program_cannot_write_events(line):
    told = Told()
    assert told.parts(f"{line}\n") == [("group-1", f"{line}\n")]
    event = f"\x1e0\x1d{TOKEN} exit 1\n".encode()
    (part,) = told.output.parts(event, has_events=False)
    assert (part.name, told.events) == ("group-1", [])
    told.output.begin()  # another life has another token
    assert told.parts(event.decode()) == [("group-1", event.decode())]
    assert told.events == []


@pytest.mark.parametrize(
    "line",
    ["\x1e7\x1fno such member", "\x1ex\x1f", "\x1e", "\x1e0", "\x1e99999999\x1f", "\x1e0\x1d"],
)
def test_other_text_with_such_characters_does_no_harm(line):
    told = Told()
    parts = told.parts(f"{line}\n")
    assert parts == [("group-1", f"{line}\n")]
    assert told.events == []
