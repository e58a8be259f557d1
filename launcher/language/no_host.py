"""NoHost: the host of a context that nobody runs."""

from __future__ import annotations

from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.event import Event
    from launcher.language.origin import Origin


class NoHost:
    """The host of a context that nobody runs: a launch file made it to perform substitutions."""

    def __init__(self) -> None:
        self._processes = 0
        self.shutdown_pending = False

    def accepts(self, event: Event) -> bool:
        """Queue everything; nobody will look."""
        return True

    def later(self, step: Callable[[], None]) -> None:
        """Nothing runs later here."""

    def next_process_number(self) -> int:
        """Count, so that `prepare` works."""
        self._processes += 1
        return self._processes

    def spawn(self, action: Any) -> None:
        """No process is started by a context without a run."""

    def request(self, effect: Any) -> None:
        """Nobody carries it out."""

    def process_of(self, action: Any) -> int | None:
        """No process lives here."""
        return None

    def call_later(self, delay_s: float, callback: Callable[[], None]) -> int:
        """Time does not pass here."""
        return 0

    def cancel_call(self, timer_id: int) -> None:
        """Nothing to forget."""

    def log(self, logger: str, level: str, text: str) -> None:
        """Nobody listens."""

    def visiting(self, entity: Any) -> None:
        """Nobody watches."""

    def visited(self) -> None:
        """Nobody watches."""

    def skipped(self, action: Any) -> None:
        """Nobody watches."""

    def warn_surprise(self, text: str, origin: Origin | None) -> None:
        """Nobody listens."""

    def configuration_read(self, name: str) -> None:
        """Nobody wants to know."""

    def configuration_written(self, name: str, value: Any, origin: Origin | None) -> None:
        """Nobody wants to know."""

    def declared(self, argument: Any, value: str) -> None:
        """Nobody wants to know."""

    def remember_file(self, path: str, content: Any) -> None:
        """The file stays, as with ROS 2."""

    def load_component(self, request: Any, done: Callable[[Any], None]) -> None:
        """No container is asked."""

    def change_state(self, request: Any, done: Callable[[Any], None]) -> None:
        """No node is asked."""

    def watch_lifecycle(self, node: str, seen: Callable[[Any], None]) -> None:
        """Nothing is seen."""

    def asyncio_loop(self) -> Any:
        """None, as in ROS 2 before the run starts."""
        return None
