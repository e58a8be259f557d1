"""A client process of a run that takes orders and answers requests, in lines of JSON."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping

from launcher.base import strict_json
from launcher.run.helpers.client_process import ClientProcess

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.run import Run

    Message = dict[str, Any]

Done = Callable[["Message"], object]


class AnsweringProcess(ClientProcess):
    """`python -m MODULE SETTINGS`, the settings in JSON; the rest is as for `ClientProcess`.

    `on_message` is called with each JSON object that it writes; other lines are skipped, since
    libraries print some. It calls `answer` for those that answer requests.
    """

    def __init__(
        self,
        run: Run,
        module: str,
        settings: Mapping[str, object],
        *,
        name: str,
        without: str,
        goodbye_s: float,
        on_message: Callable[[Message], object],
    ) -> None:
        super().__init__(
            run,
            (module, strict_json.packed(settings)),
            name=name,
            without=without,
            goodbye_s=goodbye_s,
            on_line=self._heard,
            on_exit=lambda is_restarted: self._fail(f"{name} died"),
        )
        self._on_message = on_message
        self._waiting: dict[int, Done] = {}
        self._ids = itertools.count(1)

    def order(self, message: Mapping[str, object]) -> bool:
        """Send a message; False if it is not running."""
        return self.send(strict_json.packed(message).encode())

    def ask(self, request: Mapping[str, object], done: Done) -> None:
        """Send a request with an `id`; `done` gets the answer, or `{"error": TEXT}` for none."""
        number = next(self._ids)
        if self.order({**request, "id": number}):
            self._waiting[number] = done
        else:
            done({"error": f"{self._name} is not running"})

    def answer(self, number: int, message: Message) -> None:
        """This message is the answer to the request with this `id`, if that is still waiting."""
        done = self._waiting.pop(number, None)
        if done is not None:
            done(message)

    def _heard(self, line: bytes) -> None:
        try:
            message = strict_json.unpacked(line)
        except ValueError:
            return
        if isinstance(message, dict):
            self._on_message(message)

    def _fail(self, error: str) -> None:
        """Nobody will answer what has been requested."""
        waiting, self._waiting = self._waiting, {}
        for done in waiting.values():
            done({"error": error})

    def close(self) -> None:
        """Let it finish, and wait for its exit: the end of the run."""
        super().close()
        self._fail("the run has ended")
