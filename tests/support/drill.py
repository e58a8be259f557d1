"""The fleet drill of docs/fleet.md: commands to type, and output to expect."""

from __future__ import annotations

from tests.support.glass import Glass

SILENCE = "robot_2 has not reported in 5.0 s"
RECOVERY = "robot_2 is reporting"


def drill(glass: Glass) -> None:
    """Kill robot_2 in the console, see that the monitor notices, start it, see it recover."""
    glass.wait_for("[robot_2]: Received task ", "[robot_3]: Received task ", patience_s=90.0)
    glass.wait_for(RECOVERY)  # whom the monitor has never heard, it does not miss
    glass.wait_for_prompt()
    glass.enter("solo monitor")
    glass.wait_for("monitor-2 is shown alone")
    warned, recovered = count(glass, SILENCE), count(glass, RECOVERY)
    glass.enter("kill robot_2")
    glass.wait_for("robot_2-4 stopped in ")
    glass.wait_until(lambda: "robot_2 stopped" in glass.text, "the bar tells")
    glass.wait_until(lambda: count(glass, SILENCE) > warned, "the monitor's warning")
    glass.enter("start robot_2")
    glass.wait_for("robot_2-4 started with pid ")
    glass.wait_until(lambda: count(glass, RECOVERY) > recovered, "that it is back")
    glass.wait_until(lambda: "robot_2 stopped" not in glass.text, "the bar tells")


def count(glass: Glass, text: str) -> int:
    """How many rows so far have this."""
    return sum(text in row for row in glass.scrolled)
