"""A future that needs no event loop: the end of an action that continues after its visit."""

from __future__ import annotations

from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class Future:
    """The part of `asyncio.Future` that launch entities and their callers use.

    Callbacks run at once when the result is set (asyncio runs them in its next iteration).
    """

    def __init__(self) -> None:
        self._done = False
        self._result: object = None
        self._callbacks: list[Callable[[Any], object]] = []

    def done(self) -> bool:
        """Whether a result was set or the future was cancelled."""
        return self._done

    def cancelled(self) -> bool:
        """Always False: an action cannot be cancelled this way."""
        return False

    def cancel(self) -> bool:
        """Always False, as for a future that cannot be cancelled."""
        return False

    def result(self) -> Any:
        """The result; RuntimeError while there is none."""
        if not self._done:
            raise RuntimeError("Result is not set.")
        return self._result

    def exception(self) -> BaseException | None:
        """Always None: failures end the launch."""
        return None

    def set_result(self, result: object) -> None:
        """Mark as done and run the callbacks; a second time changes nothing."""
        if self._done:
            return
        self._done = True
        self._result = result
        callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback(self)

    def add_done_callback(self, callback: Callable[[Any], object]) -> None:
        """Call `callback(self)` when done, at once if it is already."""
        if self._done:
            callback(self)
        else:
            self._callbacks.append(callback)
