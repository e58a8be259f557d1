"""The end of a run on a terminal that reads slowly."""

from __future__ import annotations

import re

import pytest

from tests.support.benches import Bench
from tests.support.screen_terminal import ScreenTerminal

SLOW_BYTES_PER_S = 40_000
LINES = 12_000  # 0.3 MB: more than the queue, or than the pipe to the console
BURST = f'sh("for i in $(seq {LINES}); do echo burst $i; done; exit 4", name="big"),'
OPTIONS = ["--console", pytest.param("--no-console", marks=pytest.mark.thorough)]
FLOOD = 'sh("while :; do echo line line line line line; done", name="flood"),'


def slow(terminal: ScreenTerminal) -> ScreenTerminal:
    terminal.bytes_per_s, terminal.emulates = SLOW_BYTES_PER_S, False
    return terminal


@pytest.mark.thorough
@pytest.mark.parametrize("option", OPTIONS)
def test_a_slow_terminal_gets_every_line_and_the_reason_of_the_failure(bench: Bench, option: str):
    options = [] if option == "--console" else [option]
    terminal = slow(bench.screen_terminal(BURST, *options))
    assert terminal.exit_code() == 1
    numbers = map(int, re.findall(rb"\[big-1\]\S* burst (\d+)", terminal.raw))
    # a line may be in two blocks: then its first part has been above the prompt
    assert {*range(1, LINES + 1)} - {*numbers} == set()
    end = terminal.raw[-2000:]
    assert b"dropped" not in end
    assert re.search(rb"exit code 4.*exit code 1\b", end, re.DOTALL), end


@pytest.mark.thorough
@pytest.mark.parametrize("option", OPTIONS)
def test_after_ctrl_c_a_slow_terminal_gets_the_summary_and_how_much_was_dropped(
    bench: Bench, option: str
):
    options = [] if option == "--console" else [option]
    terminal = bench.screen_terminal(FLOOD, *options)
    if not options:
        terminal.wait_for_prompt()
    slow(terminal)
    begun = len(terminal.raw)
    terminal.wait_until(lambda: len(terminal.raw) > begun + 3 * SLOW_BYTES_PER_S, "a flood")
    terminal.ctrl_c()
    terminal.exit_code()
    end = terminal.raw[-2000:]
    whole_line = rb"\[flood-1\]\S* line line line line line\r\n\S*"
    warning = rb"\[WARNING\] \[launch\]:\S* the terminal is slow: [1-9]\d* lines dropped\r\n"
    assert re.search(whole_line + warning + rb".*\bexit code \d", end, re.DOTALL), end
