"""Actor: does the commands of a scenario to a system, each in a thread of its own.

A step that takes its time (a stop that waits for a stubborn process) must not delay the others.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from launcher.errors import LauncherError
from launcher.smoke.steps import Command
from launcher.smoke.system import System

PAUSE_LOOK_S = 0.05


class Actor:
    """`do` returns at once; `on_done(error)` is called in the command's thread."""

    def __init__(self, system: System, is_over: threading.Event) -> None:
        self._system = system
        self._is_over = is_over

    def do(
        self,
        command: Command,
        on_done: Callable[[str | None], None],
        on_over: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_over` is called at the end of a pause."""

        def work() -> None:
            try:
                self._carry_out(command)
            except LauncherError as error:
                on_done(error.message + (f" ({error.hint})" if error.hint else ""))
                return
            on_done(None)
            self._end_pause(command, on_over)

        threading.Thread(target=work, daemon=True, name=command.text).start()

    def _end_pause(self, command: Command, on_over: Callable[[], None]) -> None:
        time_s = command.words.get("time_s")
        if command.verb != "pause" or time_s is None:
            return
        end_s = time.monotonic() + time_s
        while time.monotonic() < end_s and not self._is_over.is_set():
            time.sleep(min(PAUSE_LOOK_S, max(0.0, end_s - time.monotonic())))
        try:
            self._system.resume(command.words["name"])
        except LauncherError:
            return  # it has ended meanwhile
        on_over()

    def _carry_out(self, command: Command) -> None:
        words: dict[str, Any] = command.words
        system = self._system
        verbs: dict[str, Callable[[], object]] = {
            "kill": lambda: system.kill(words["name"], words["signal"]),
            "stop": lambda: system.stop_process(words["name"]),
            "start": lambda: system.start_process(words["name"]),
            "restart": lambda: system.restart_process(words["name"]),
            "pause": lambda: system.pause(words["name"]),
            "resume": lambda: system.resume(words["name"]),
            "send": lambda: system.send(words["name"], words["text"]),
            "publish": lambda: system.publish(words["topic"], words["type"], words["value"]),
            "set": lambda: system.set_parameter(words["node"], words["parameter"], words["value"]),
            "call": lambda: system.call(words["service"], words["type"], words.get("value")),
        }
        verbs[command.verb]()
