"""What is played in the console of the fleet for tests and pictures."""

from __future__ import annotations

from tests.support.screen_terminal import ScreenTerminal

SILENCE = "robot_2 has not reported in 5.0 s"
RECOVERY = "robot_2 is reporting"
F2, DOWN = "\x1bOQ", "\x1b[B"


def drill(terminal: ScreenTerminal) -> None:
    """Kill robot_2 in the console, see that the monitor notices, start it, see it recover."""
    _wait_for_work(terminal)
    terminal.enter("solo monitor")
    terminal.wait_for("monitor-2 is shown alone")
    terminal.wait_until(lambda: "solo monitor  hidden " in terminal.text, "the filter in the bar")
    warned, recovered = count(terminal, SILENCE), count(terminal, RECOVERY)
    terminal.enter("kill robot_2")
    terminal.wait_for("robot_2-4 ended in ")
    terminal.wait_until(lambda: "robot_2 stopped" in terminal.text, "the bar shows it")
    terminal.wait_until(lambda: count(terminal, SILENCE) > warned, "the monitor's warning")
    terminal.enter("start robot_2")
    terminal.wait_for("robot_2-4 started with pid ")
    terminal.wait_until(lambda: count(terminal, RECOVERY) > recovered, "that it is back")
    terminal.wait_until(lambda: "robot_2 stopped" not in terminal.text, "the bar shows it")


def picker(terminal: ScreenTerminal) -> None:
    """Stop robot_2 in the picker."""
    _wait_for_work(terminal)
    terminal.type(F2)
    terminal.wait_until(lambda: ">1 dispatcher-1 " in terminal.text, "the list")
    terminal.type("4")
    terminal.wait_until(lambda: ">4 robot_2-4 " in terminal.text, "robot_2")
    terminal.type("s")
    terminal.wait_for("> stop robot_2-4", "robot_2-4 stopped in ")
    terminal.wait_until(lambda: ">4 robot_2-4     stopped: " in terminal.text, "its end")
    terminal.wait_until(lambda: "s start" in terminal.text, "what s does now")


def picker_log(terminal: ScreenTerminal) -> None:
    """Search for robot_3 in the picker, and read its log."""
    _wait_for_work(terminal)
    terminal.type(F2)
    terminal.wait_until(lambda: ">1 dispatcher-1 " in terminal.text, "the list")
    terminal.type("/bot_3\r")
    terminal.wait_until(lambda: "processes: 1  /bot_3" in terminal.text, "it is found")
    terminal.type("\r")
    terminal.wait_until(lambda: "logs robot_3-5: running, following" in terminal.text, "its log")
    terminal.wait_until(
        lambda: "Received task " in terminal.text.partition(", following")[2], "its lines"
    )
    terminal.wait_until(lambda: "q back" in terminal.text, "the keys")


def _wait_for_work(terminal: ScreenTerminal) -> None:
    for text in ("[robot_2]: Received task ", "[robot_3]: Received task ", RECOVERY):
        terminal.wait_until(lambda text=text: count(terminal, text), text, 90.0)
    terminal.wait_for_prompt()


def count(terminal: ScreenTerminal, text: str) -> int:
    """How often this was shown, also where a narrow terminal has wrapped it."""
    return "".join(terminal.scrolled).replace(" ", "").count(text.replace(" ", ""))
