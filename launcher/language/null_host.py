"""The host of a LaunchContext that a launch file creates itself, to perform substitutions."""

from __future__ import annotations

from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class NullHost:
    """Accepts every request (see `launcher.language.host.Host`) and does nothing."""

    def __init__(self) -> None:
        self._processes = 0
        self.shutdown_pending = False

    def accepts(self, event: Any) -> bool:
        return True

    def next_process_number(self) -> int:
        self._processes += 1
        return self._processes

    def process_of(self, action: Any) -> int | None:
        return None

    def call_later(self, delay_s: float, callback: Callable[[], None]) -> int:
        return 0

    def asyncio_loop(self) -> Any:
        """None, as in ROS 2 before the run starts."""
        return None

    def _ignore(self, *args: Any, **kwargs: Any) -> None:
        pass

    later = spawn = request = cancel_call = log = _ignore
    visiting = visited = skipped = warn_quirk = _ignore
    configuration_read = configuration_written = declared = remember_file = _ignore
    load_component = change_state = watch_lifecycle = _ignore
