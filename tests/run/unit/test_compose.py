"""Composed processes: what the launch file is told of them, and whose line is whose."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from launcher.base.errors import LauncherError
from launcher.base.model import events
from launcher.base.model.record import replace
from launcher.base.model.spec import ProcessSpec
from launcher.output.lines import CUT_MARK, LINE_LIMIT
from launcher.run.compose.composed_core import ComposedCore, Composition
from launcher.run.compose.group_output import GroupOutput

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


TOKEN = "0123456789abcdef"
MARK = f"\x1e{TOKEN}"


def frame(index: int, text: str, *, ends: bool = True) -> str:
    return f"{MARK}{index}{chr(0x1F) if ends else chr(0x1D)}{text}\n"


class Told:
    """A group with two members, which has told its token."""

    def __init__(self) -> None:
        self.ends: list[tuple[int, int]] = []
        names = [("a-1", b"[a] "), ("b-2", b"[b] ")]
        tell = lambda index, code: self.ends.append((index, code))  # noqa: E731
        self.output = GroupOutput(("group-1", b"[g] "), names, tell)
        self.begin()

    def begin(self, token: str = TOKEN) -> None:
        self.output.begin()
        self.buffer = self.output.buffer()
        self.output.take(f"token {token}".encode())

    def feed(self, text: str) -> list[tuple[str, str]]:
        """(name, lines) of what is complete when this was read as well."""
        lines, _ = self.buffer.feed(text.encode())
        return self._named(lines)

    def finish(self) -> list[tuple[str, str]]:
        return self._named(self.buffer.take_partial()[0])

    def _named(self, lines: bytes) -> list[tuple[str, str]]:
        parts = self.output.parts(lines, self.buffer.mark) if lines else ()
        return [(one.name, one.lines.decode()) for one in parts]


def log(logger: str, text: str = "hello") -> str:
    return f"[INFO] [1795628591.310558812] [{logger}]: {text}\n"


def test_lines_in_frames_are_those_of_their_member():
    told = Told()
    text = frame(0, "one") + frame(0, "two") + frame(1, "") + "plain\n"
    assert told.feed(text) == [("a-1", "one\ntwo\n"), ("b-2", "\n"), ("group-1", "plain\n")]
    lines, _ = told.buffer.feed(frame(1, "x").encode())
    (first,) = told.output.parts(lines, told.buffer.mark)
    assert (first.prefix, first.kept) == (b"[b] ", b"[b-2] x\n")


def test_a_line_may_come_in_several_frames():
    told = Told()
    assert told.feed(frame(0, "one, ", ends=False)) == []
    assert told.feed(frame(1, "other") + frame(0, "two, ", ends=False)) == [("b-2", "other\n")]
    assert told.feed(frame(0, "three")) == [("a-1", "one, two, three\n")]
    for _ in range(2 * LINE_LIMIT // 1000):
        assert told.feed(frame(0, "x" * 1000, ends=False)) == []
    ((_, line),) = told.feed(frame(0, "end"))
    assert line == "x" * LINE_LIMIT + CUT_MARK.decode() + "\n"


def test_a_frame_may_come_within_a_line_that_is_written_in_pieces():
    told = Told()
    assert told.feed(f"some {frame(0, 'own')}thing") == [("a-1", "own\n")]
    assert told.buffer.partial == b"some thing", "it is shown if nothing follows"
    assert told.feed(f" {frame(1, 'x')}else\nand ") == [
        ("b-2", "x\n"),
        ("group-1", "some thing else\n"),
    ]
    assert told.finish() == [("group-1", "and \n")]


TEXT = (
    f"some {frame(0, 'a' * 20)}thing\n{frame(1, 'b', ends=False)}{frame(1, 'c')}\x1e{frame(0, '')}"
    f"{log('x')}\x1e{TOKEN[:5]}\n{frame(1, chr(0x1E) + 'd')}"
)


@pytest.mark.parametrize("size", range(1, len(TEXT)))
def test_however_it_is_read_the_lines_are_the_same(size: int):
    told = Told()
    found = [part for at in range(0, len(TEXT), size) for part in told.feed(TEXT[at : at + size])]
    of = {name: "".join(lines for one, lines in found if one == name) for name, _ in found}
    assert of == {
        "a-1": "a" * 20 + "\n\n",
        "b-2": "bc\n\x1ed\n",
        "group-1": f"some thing\n\x1e{log('x')}\x1e{TOKEN[:5]}\n",
    }
    assert told.finish() == []


def test_what_a_killed_process_had_begun_is_shown():
    told = Told()
    told.feed(frame(0, "begun ", ends=False) + "partial " + frame(0, "own", ends=False)[:-1])
    assert told.finish() == [("group-1", "partial \n"), ("a-1", "begun own\n")]


def test_lines_of_rcl_are_told_apart_by_their_logger():
    told = Told()
    assert told.feed(log("fleet.a")) == [("group-1", log("fleet.a"))]
    told.output.take(b"0 node /fleet/a fleet.a")
    told.output.take(b"1 node /b b")
    colour = f"\x1b[33m{log('b.part.deep')}"
    assert told.feed(log("fleet.a") + colour + log("rcl") + log("bb")) == [
        ("a-1", log("fleet.a")),
        ("b-2", colour),
        ("group-1", log("rcl") + log("bb")),
    ]
    assert told.output.nodes == {"/fleet/a": 0, "/b": 1}


def test_what_follows_a_line_of_a_logger_belongs_to_it_in_the_same_block():
    told = Told()
    told.output.take(b"0 node /a a")
    assert told.feed(f"x\n{log('a')}  second\nthird\n{frame(1, 'y')}") == [
        ("group-1", "x\n"),
        ("a-1", f"{log('a')}  second\nthird\n"),
        ("b-2", "y\n"),
    ]
    assert told.feed("third\n") == [("group-1", "third\n")]


def test_a_logger_of_two_members_is_that_of_none():
    told = Told()
    told.output.take(b"0 node /a a")
    told.output.take(b"1 node /a a")
    assert told.feed(log("a")) == [("group-1", log("a"))]


def test_the_end_of_a_member_is_told_behind_all_that_was_written_before():
    told = Told()
    order: list[object] = []
    told.output.take(b"1 exit -2")
    assert told.output.has_ends and told.ends == []

    def read() -> None:
        order.append(list(told.ends))
        if len(order) == 1:
            told.output.take(b"0 exit 3")  # comes with what is read

    told.output.settle(read)
    assert order == [[], [(1, -2)]], "it is read for each"
    assert told.ends == [(1, -2), (0, 3)]
    assert not told.output.has_ends


@pytest.mark.parametrize(
    "message", [b"", b"0", b"0 exit", b"0 exit x", b"x exit 0", b"2 exit 0", b"0 node", b"token x"]
)
def test_other_messages_do_no_harm(message: bytes):
    told = Told()
    told.output.take(message)
    told.output.settle(lambda: None)
    assert told.ends == []
    assert told.feed(frame(0, "x")) == [("a-1", "x\n")]


@pytest.mark.parametrize(
    "line",
    [
        *("\x1e7\x1fx", "\x1e0\x1fx", "\x1e", "\x1e\x1e", f"{MARK}", f"{MARK}x", f"{MARK}0"),
        *(f"{MARK}9999999\x1fx", f"\x1e{'f' * 16}0\x1fx", "0 exit 1"),
    ],
)
def test_a_program_cannot_write_frames_or_messages(line: str):
    told = Told()
    assert told.feed(f"{line}\n") == [("group-1", f"{line}\n")]
    assert told.ends == []


def test_another_life_has_another_token_and_what_is_left_of_the_last_one_its_own():
    told = Told()
    before = told.buffer
    told.begin("f" * 16)
    assert told.feed(frame(0, "x")) == [("group-1", frame(0, "x"))]
    assert before.feed(frame(0, "x").encode()) == (frame(0, "x").encode(), 0)
