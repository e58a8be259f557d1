"""The fleet drill of docs/fleet.md: commands to type, and output to expect."""

from __future__ import annotations

from tests.support.screen_terminal import ScreenTerminal

SILENCE = "robot_2 has not reported in 5.0 s"
RECOVERY = "robot_2 is reporting"


def drill(terminal: ScreenTerminal) -> None:
    """Kill robot_2 in the console, see that the monitor notices, start it, see it recover."""
    terminal.wait_for("[robot_2]: Received task ", "[robot_3]: Received task ", timeout_s=90.0)
    terminal.wait_for(RECOVERY)  # whom the monitor has never heard, it does not miss
    terminal.wait_for_prompt()
    terminal.enter("solo monitor")
    terminal.wait_for("monitor-2 is shown alone")
    warned, recovered = count(terminal, SILENCE), count(terminal, RECOVERY)
    terminal.enter("kill robot_2")
    terminal.wait_for("robot_2-4 stopped in ")
    terminal.wait_until(lambda: "robot_2 stopped" in terminal.text, "the bar tells")
    terminal.wait_until(lambda: count(terminal, SILENCE) > warned, "the monitor's warning")
    terminal.enter("start robot_2")
    terminal.wait_for("robot_2-4 started with pid ")
    terminal.wait_until(lambda: count(terminal, RECOVERY) > recovered, "that it is back")
    terminal.wait_until(lambda: "robot_2 stopped" not in terminal.text, "the bar tells")


def count(terminal: ScreenTerminal, text: str) -> int:
    """How many rows so far have this."""
    return sum(text in row for row in terminal.scrolled)
