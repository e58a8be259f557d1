"""The tutorial does what it says: its commands are typed, and what it shows has to come.

`console` blocks are typed in a terminal, that of their title or the first one, and blocks of other
kinds are the files that their titles name. A line `$ ...` is a command, `> ...` is for the console
of a run, `^C` is Ctrl-C, and the lines below are what comes: numbers may differ, `...` is anything.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path

import psutil
import pytest

from launcher.packages.distribution import title
from tests.support.repository import docs_page
from tests.support.ros_domain import ros_domain
from tests.support.screen_terminal import ScreenTerminal
from tests.support.terminal import marked_processes
from tests.support.waiting import wait_until

BLOCK = re.compile(
    r'^```(?P<kind>\w+)(?: title="(?P<title>.+?)")?\n(?P<text>.*?)^```$', re.M | re.S
)
MARK = "LAUNCHER_TUTORIAL"  # the processes of this test have this variable
DEADLINE_S = 200.0  # a build on a busy machine takes a minute
# Everything else with digits differs from run to run.
EXACT = r"exit code \d+|\d+ of \d+ expectations|\d+ packages?:|\d+ passed|\d+ built, \d+ unchanged"
VARIABLE = re.compile(
    rf"(?P<exact>{EXACT})|(?P<any>\.\.\.)|(?P<number>\d+(?:\.\d+)?)|(?P<blanks>\s+)"
)
FAST_DDS = "[RTPS_"  # complains on a busy machine, of a port that somebody just gives up
# The environment of the tests is there already.
MAKE_ENVIRONMENT = "python3 -m venv .venv"
INSTALL = re.compile(r'pip install "ros2-launcher\[([\w,]+)\] @ git\+URL#subdirectory=launcher"')


@dataclass(slots=True)
class Step:
    """What is typed, and what comes then."""

    terminal: str
    typed: str
    shown: list[str] = field(default_factory=list)
    ends: bool = True  # whether the shell has its prompt again when it has come

    @property
    def is_command(self) -> bool:
        return self.typed.startswith("$ ")


@dataclass(frozen=True, slots=True)
class File:
    path: str
    text: str


def steps_of(page: str) -> Iterator[Step | File]:
    for block in BLOCK.finditer(page):
        if block["kind"] != "console":
            yield File(block["title"], block["text"])
            continue
        step = None
        for line in block["text"].splitlines():
            if line.startswith(("$ ", "> ", "^C")):
                if step is not None:
                    yield step
                step = Step(block["title"] or "Terminal 1", line)
            else:
                assert step is not None, f"a block begins with what comes: {line}"
                step.shown.append(line)
        assert step is not None, f"an empty block: {block[0]}"
        yield step


def script_of(page: str) -> list[Step | File]:
    """All of it; a command ends if the next line for its terminal is another command."""
    script = list(steps_of(page))
    last: dict[str, Step] = {}
    for step in script:
        if isinstance(step, Step):
            if step.terminal in last:
                last[step.terminal].ends = step.is_command
            last[step.terminal] = step
    return script


def pattern_of(line: str) -> str:
    """A regular expression for a line that may come where the page has this one."""
    parts, end = [], 0
    for found in VARIABLE.finditer(line):
        parts.append(re.escape(line[end : found.start()]))
        by_kind = {
            "exact": re.escape(found[0]),
            "any": ".*",
            "number": r"\d+(?:\.\d+)?",
            "blanks": r"\s+",
        }
        parts.append(by_kind[found.lastgroup or ""])
        end = found.end()
    return "".join([*parts, re.escape(line[end:])])


def are_all_there(shown: list[str], rows: list[str]) -> bool:
    """In whatever order, since processes write at the same time."""
    lines = [pattern_of(line) for line in shown if line != "..."]
    return all(any(re.fullmatch(line, row) for row in rows) for line in lines)


def are_the_same(shown: list[str], rows: list[str]) -> bool:
    lines = [r"(?:.*\n)*?" if line == "..." else pattern_of(line) + r"\n" for line in shown]
    return re.fullmatch("".join(lines), "".join(f"{row}\n" for row in rows)) is not None


class Desk:
    """The terminals of a reader."""

    def __init__(self, folder: Path, env: dict[str, str], stack: ExitStack) -> None:
        self._folder, self._env, self._stack = folder, env, stack
        self._terminals: dict[str, ScreenTerminal] = {}
        self._commands: dict[str, int] = {}  # row of the last one

    def do(self, step: Step | File) -> None:
        if isinstance(step, File):
            (self._place("Terminal 1") / step.path).write_text(step.text, encoding="utf-8")
        elif step.typed == f"$ {MAKE_ENVIRONMENT}":
            scripts = self._place(step.terminal) / ".venv/bin"
            scripts.mkdir(parents=True)
            (scripts / "activate").write_text(f"PATH={Path(sys.executable).parent}:$PATH\n")
        elif install := INSTALL.fullmatch(step.typed[2:]):
            extras = metadata.metadata("ros2-launcher").get_all("Provides-Extra") or []
            assert set(install[1].split(",")) <= set(extras)
        else:
            begin = self._type(step)
            self._look(step, begin)

    def _terminal(self, name: str) -> ScreenTerminal:
        if name not in self._terminals:
            shell = ["bash", "--norc", "--noprofile", "-i"]
            terminal = ScreenTerminal(shell, env=self._env, cwd=self._folder, columns=180, rows=50)
            self._terminals[name] = self._stack.enter_context(terminal)
        return self._terminals[name]

    def _place(self, name: str) -> Path:
        terminal = self._terminal(name)
        self._wait(terminal, lambda: self._is_idle(terminal), "the prompt of the shell")
        return Path(os.readlink(f"/proc/{terminal.pid}/cwd"))

    def _type(self, step: Step) -> int:
        """The number of the row behind which the answer comes."""
        terminal = self._terminal(step.terminal)
        if step.typed == "^C":
            terminal.ctrl_c()
            return self._commands[step.terminal]
        if step.is_command:
            self._wait(terminal, lambda: self._is_idle(terminal), "the prompt of the shell")
        else:
            self._wait(terminal, lambda: terminal.prompt_row >= 0, "the prompt of the console")
        before = terminal.scrolled.count(step.typed)
        terminal.enter(step.typed[2:])
        self._wait(terminal, lambda: terminal.scrolled.count(step.typed) > before, step.typed)
        row = _last(step.typed, terminal.scrolled)
        if step.is_command:
            self._commands[step.terminal] = row
        return row

    def _look(self, step: Step, begin: int) -> None:
        terminal = self._terminal(step.terminal)

        def answer() -> list[str]:
            rows = terminal.scrolled
            # The place of what is typed in the console changes while its prompt is drawn again.
            row = _last(step.typed, rows) if step.typed.startswith("> ") else begin
            return [text for text in rows[row + 1 :] if FAST_DDS not in text]

        if step.ends:
            self._wait(terminal, lambda: self._is_idle(terminal), f"the end of {step.typed}")
            if step.is_command:
                rows = _without_blank_end(answer())[:-1]
                assert are_the_same(step.shown, rows), _difference(step, rows)
                return
        try:
            self._wait(terminal, lambda: are_all_there(step.shown, answer()), step.typed)
        except AssertionError:
            raise AssertionError(_difference(step, answer())) from None

    def _wait(self, terminal: ScreenTerminal, fact: Callable[[], bool], what: str) -> None:
        """Until it holds. The others are read, too: a terminal that is full stops its programs."""

        def look() -> bool:
            for other in self._terminals.values():
                if other is not terminal:
                    other.read(0.0)
            return fact()

        terminal.wait_until(look, what, DEADLINE_S)

    def _is_idle(self, terminal: ScreenTerminal) -> bool:
        return _without_blank_end(terminal.scrolled)[-1:] == ["$"]


def _difference(step: Step, rows: list[str]) -> str:
    return "\n".join([f"after {step.typed!r}, expected:", *step.shown, "and there was:", *rows])


def _last(row: str, rows: list[str]) -> int:
    return len(rows) - 1 - rows[::-1].index(row)


def _without_blank_end(rows: list[str]) -> list[str]:
    return rows[: max((number for number, row in enumerate(rows, 1) if row), default=0)]


def _page() -> str:
    """With the ROS 2 in use."""
    return docs_page("tutorial").replace("(ROS 2 Jazzy, from wheels)", f"({title()})")


@pytest.mark.thorough
def test_everything_in_the_tutorial_works_in_its_order(tmp_path: Path):
    with ros_domain(tmp_path / "log") as env, ExitStack() as stack:
        env |= {MARK: str(tmp_path), "PS1": "$ ", "TERM": "xterm-256color", "HISTFILE": ""}
        folder = tmp_path / "home"
        folder.mkdir()
        try:
            desk = Desk(folder, env, stack)
            for step in script_of(_page()):
                desk.do(step)
            assert {process.name() for process in _left(tmp_path)} == {"bash"}
        finally:
            for process in _left(tmp_path):
                with contextlib.suppress(psutil.NoSuchProcess):
                    process.kill()
            wait_until(lambda: not _left(tmp_path), "the end of all processes")


def _left(tmp_path: Path) -> list[psutil.Process]:
    return list(marked_processes(MARK, str(tmp_path)).values())


@pytest.mark.unit
def test_every_block_of_the_tutorial_is_typed_or_a_file():
    page = docs_page("tutorial")
    blocks = list(BLOCK.finditer(page))
    assert len(re.findall(r"^```", page, re.M)) == 2 * len(blocks)
    assert all(block["kind"] == "console" or block["title"] for block in blocks)


@pytest.mark.unit
@pytest.mark.parametrize(
    ("line", "row", "fits"),
    [
        ("seen: 1 Hz, after 0.5 s", "seen: 0.994 Hz, after 12 s", True),
        ("smoke: 2 of 3 expectations met", "smoke: 1 of 3 expectations met", False),
        ("| clock-1    running   12", "| clock-1  running  4711", True),
        ("hint: ...; end", "hint: anything; end", True),
        ("data: hello 12", "data: hullo 12", False),
    ],
)
def test_a_line_of_the_page_fits_rows_that_differ_in_numbers(line: str, row: str, fits: bool):
    assert bool(re.fullmatch(pattern_of(line), row)) == fits
