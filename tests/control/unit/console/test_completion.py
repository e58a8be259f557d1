"""What the console completes while a line is typed."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from launcher.control.console.completion import WordCompleter
from tests.control.unit.console.rows import FLEET, process


async def no_words(words: Sequence[str]) -> Sequence[tuple[str, str]]:
    return ()


def completed(text: str, fleet: list[dict[str, object]] = FLEET) -> list[str]:
    completer = WordCompleter(lambda: fleet, no_words)
    found = [c.text for c in completer.get_completions(Document(text), CompleteEvent())]
    return [one.removesuffix(" ") for one in found]


def test_a_blank_follows_what_was_completed():
    completer = WordCompleter(lambda: FLEET, no_words)
    (only,) = completer.get_completions(Document("unm"), CompleteEvent())
    assert only.text == "unmute "


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("un", ["unmute"]),
        ("kill r", ["robot_1", "robot_2", "robot_*"]),
        ("kill robot_1 r", ["robot_2", "robot_*"]),
        ("kill -s SIGTE", ["SIGTERM"]),
        ("kill -", ["-s", "--signal", "--as-crash"]),
        ("level W", ["WARN"]),
        ("level WARN d", ["dispatcher"]),
        ("stop robot_*", ["robot_1-2 robot_2-3"]),
        ("send robot_1 r", []),
        ("logs -n 5 d", ["dispatcher"]),
        ("logs -n ", []),
        ("grep r", []),
        ("help r", []),
        ("format c", ["compact"]),
        ("nonsense r", []),
        ("launcher un", ["unmute"]),
        ("python -m launcher kill robot_1 r", ["robot_2", "robot_*"]),
    ],
)
def test_what_fits_at_the_cursor_is_offered(typed: str, offered: list[str]):
    assert completed(typed) == offered


def test_nodes_and_namespaces_are_offered():
    fleet = [process("talker-1", node_names=["/east/talker"], namespace="/east")]
    assert completed("info /e", fleet) == ["/east/talker", "/east"]


def asked_for(text: str) -> tuple[list[str], list[str]]:
    """The words that were asked for, and what is offered."""
    asked: list[str] = []

    async def ask(words: Sequence[str]) -> Sequence[tuple[str, str]]:
        asked.extend(words)
        return [("/chatter", "a topic"), ("a b", ""), ("--field=", "")]

    async def all_of(completer: WordCompleter) -> list[str]:
        found = completer.get_completions_async(Document(text), CompleteEvent())
        return [completion.text async for completion in found]

    return asked, asyncio.run(all_of(WordCompleter(lambda: FLEET, ask)))


@pytest.mark.parametrize("program", ["", "launcher "])
def test_words_of_a_verb_for_shells_are_asked_for(program: str):
    asked, offered = asked_for(f"{program}topic echo /ch")
    assert asked == ["topic", "echo", "/ch"]
    assert offered == ["/chatter ", "'a b' ", "--field="]


@pytest.mark.parametrize("text", ["kill ro", "to", "attach ", "nonsense "])
def test_words_of_other_verbs_are_not_asked_for(text: str):
    asked, offered = asked_for(text)
    assert asked == []
    assert offered == [f"{one} " for one in completed(text)]


def test_verbs_of_shells_are_offered():
    assert "topic" in completed("to") and "param" in completed("pa")
    assert "attach" not in completed("att")
