"""`faults` in the console, and the mark in its status bar."""

from __future__ import annotations

from tests.support.benches import Bench
from tests.support.watcher_stand_in import IN_PLACE, Reports


def test_the_mark_comes_and_goes_and_the_table_is_shown(bench: Bench):
    reports = Reports(bench.folder)
    bench.env.update(reports.env)
    actions = f'{IN_PLACE} sh("exec cat", name="cat")'
    terminal = bench.screen_terminal(actions, "--watchful", columns=120)
    terminal.wait_for_prompt()
    reports.fault("confirmed")
    terminal.wait_until(lambda: terminal.below_prompt(1).startswith("1 fault | cat"), "the mark")
    terminal.enter("faults")
    terminal.wait_for("| active  robot_1 reports")
    terminal.enter("faults -f")
    terminal.wait_for("any key ends this")
    reports.fault("healed", state="healed", healed_s=1.0)
    terminal.wait_for("healed: robot_1 reports: no message")
    terminal.wait_until(lambda: terminal.below_prompt(1).startswith("cat "), "no mark")
    terminal.ctrl_c()
    terminal.wait_until(lambda: "any key ends this" not in terminal.text, "the end of the stream")
    terminal.ctrl_c()
    terminal.exit_code()
