"""Client processes that answer requests, with real ones."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from launcher.posix.reactor import Reactor
from launcher.run.helpers.answering_process import AnsweringProcess
from launcher.run.run import Run

PROGRAM = """
import json, sys
print("a library prints this")
print(7, flush=True)
settings = json.loads(sys.argv[1])
for line in sys.stdin:
    request = json.loads(line)
    if request["do"] == "die":
        sys.exit(3)
    if request["do"] == "reply":
        print(json.dumps({"is": settings["word"], "id": request["id"]}), flush=True)
"""


class Client:
    """A client process and what has come of it; `answers` are those to requests, by a word."""

    def __init__(self, folder: Path) -> None:
        (folder / "answering_program.py").write_text(PROGRAM, encoding="utf-8")
        self.reactor = Reactor()
        self.answers: dict[str, Any] = {}
        run = SimpleNamespace(
            reactor=self.reactor,
            env={**os.environ, "PYTHONPATH": str(folder)},
            log=SimpleNamespace(warn=lambda text: None),
            adopt_helper=lambda pid: None,
            housekeeper=SimpleNamespace(ledger=SimpleNamespace(died=lambda code, start_s: None)),
        )
        self.process = AnsweringProcess(
            cast(Run, run),
            "answering_program",
            {"word": "done"},
            name="the program",
            without="nothing is done",
            goodbye_s=10.0,
            on_message=lambda message: self.process.answer(message["id"], message),
        )

    def ask(self, what: str) -> None:
        self.process.ask({"do": what}, lambda answer: self.answers.update({what: answer}))

    def turn_until_answered(self, what: str) -> None:
        """AssertionError after a minute."""
        deadline = time.monotonic() + 60.0
        while what not in self.answers:
            assert time.monotonic() < deadline
            self.reactor.turn()


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    made = Client(tmp_path)
    yield made
    made.process.close()
    made.reactor.close()


def test_each_request_gets_its_answer_or_an_error_at_the_end(client: Client):
    client.ask("nothing yet")
    client.process.start()
    client.ask("wait")
    client.ask("reply")
    client.turn_until_answered("reply")
    assert client.answers == {
        "nothing yet": {"error": "the program is not running"},
        "reply": {"is": "done", "id": 3},
    }
    client.process.close()
    assert client.answers["wait"] == {"error": "the run has ended"}


def test_a_death_answers_what_was_requested(client: Client):
    client.process.start()
    client.ask("die")
    client.turn_until_answered("die")
    assert client.answers == {"die": {"error": "the program died"}}
