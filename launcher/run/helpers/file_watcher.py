"""Starts the process that watches files (launcher.run.watch), and restarts it if it dies."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.base.text import how_it_ended
from launcher.posix.reactor import Reactor, Timer
from launcher.run.helpers.json_lines import JsonLinesProcess, own_end

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

MAX_STARTS = 4  # then the run continues without one
RESTART_DELAY_S = 0.5


class FileWatcher:
    """`on_message` gets its messages; `on_start` is called when it has to be told everything.

    It ends with the launcher, since its input ends then.
    """

    def __init__(
        self,
        reactor: Reactor,
        env: Mapping[str, str],
        warn: Callable[[str], None],
        *,
        on_start: Callable[[], None],
        on_message: Callable[[Mapping[str, Any]], None],
    ) -> None:
        self._reactor = reactor
        self._env = own_end(env)
        self._warn = warn
        self._on_start = on_start
        self._on_message = on_message
        self._process: JsonLinesProcess | None = None
        self._started = 0
        self._timer: Timer | None = None

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        self._timer = None
        self._started += 1
        try:
            self._process = JsonLinesProcess(
                self._reactor,
                "launcher.run.watch",
                self._env,
                on_message=self._on_message,
                on_end=self._ended,
            )
        except OSError as error:
            self._warn(f"files are not watched: {error.strerror}")
            return
        self._on_start()

    def send(self, message: Mapping[str, object]) -> None:
        if self._process is not None:  # else: it will be told everything
            self._process.send(message)

    def _ended(self, code: int, line: str) -> None:
        self._process = None
        reason = f": {line}" if line else ""
        is_restarted = self._started < MAX_STARTS
        what = "restarting it" if is_restarted else "files are not watched any more"
        self._warn(f"the file watcher died ({how_it_ended(code)}){reason}; {what}")
        if is_restarted:
            self._timer = self._reactor.call_later(RESTART_DELAY_S, self.start)

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._process is not None:
            self._process.close()  # it has nothing to clean up
            self._process = None
