"""Connection: a client's end of a run's socket. Plain blocking sockets with time-outs."""

from __future__ import annotations

import itertools
import json
import os
import socket
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from launcher.control.protocol import VERSION
from launcher.control.socket_directory import ControlError
from launcher.model.record import Record

HELLO_PATIENCE_S = 5.0
READ_BYTES = 64 * 1024


class Reply(Record):
    """The last answer to a request; `text` is for people, `result` for programs."""

    result: dict[str, Any]
    text: tuple[str, ...]


class RefusedError(ControlError):
    """The run said no; `code` is the protocol's, `message` and `hint` are for people."""

    def __init__(self, code: str, message: str, hint: str | None) -> None:
        super().__init__(message, hint=hint)
        self.code = code


class NoRunError(ControlError):
    """Nobody listens there (any more)."""


class SilentError(ControlError):
    """It does not answer in time."""


class Connection:
    """Ask one thing after the other, or follow one stream. Close it, or use `with`.

    `hello` is the run's first line. Raises ControlError.
    """

    def __init__(self, path: Path | str, *, patience_s: float = HELLO_PATIENCE_S) -> None:
        self.path = Path(path)
        self._buffer = b""
        self._ids = itertools.count(1)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.settimeout(patience_s)
            self._socket.connect(os.fsencode(self.path))
            first = self._read_object(time.monotonic() + patience_s)
        except (FileNotFoundError, ConnectionRefusedError):
            self.close()
            raise NoRunError(f"{self.path}: no run listens there") from None
        except OSError as error:
            self.close()
            if isinstance(error, TimeoutError):
                raise SilentError(f"{self.path}: the run does not answer") from None
            raise ControlError(f"{self.path}: {error.strerror or error}") from None
        except ControlError:
            self.close()
            raise
        if "run" not in first:
            self.close()
            raise _refusal(first)
        self.hello: dict[str, Any] = first

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def fileno(self) -> int:
        """For `select` and the like; what has been read already does not show there."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close it; more than once does no harm."""
        self._socket.close()

    # ---- asking

    def ask(
        self,
        verb: str,
        names: Sequence[str] = (),
        *,
        patience_s: float | None = None,
        **options: Any,
    ) -> Reply:
        """The answer, which comes when it has happened; `patience_s` None waits for it.

        Raises RefusedError, and ControlError if the run ends or does not answer in time.
        """
        request_id = self.send(verb, names, **options)
        deadline = None if patience_s is None else time.monotonic() + patience_s
        while True:
            answer = self._answer(deadline)
            if answer.get("id") != request_id or "item" in answer:
                continue  # left over from a stream
            return _reply(answer)

    def follow(
        self, verb: str, names: Sequence[str] = (), **options: Any
    ) -> Iterator[dict[str, Any]]:
        """The items of a stream, until the run ends."""
        request_id = self.send(verb, names, **{"follow": True, **options})
        while (item := self.next_item(request_id)) is not None:
            yield item

    def next_item(self, request_id: int) -> dict[str, Any] | None:
        """The next item of the stream that `send` has asked for; None at its end."""
        while True:
            answer = self._answer(None)
            if answer.get("id") != request_id:
                continue
            if "item" not in answer:
                _reply(answer)
                return None
            item: dict[str, Any] = answer["item"]
            return item

    @property
    def has_line(self) -> bool:
        """Whether a line has been read already that nobody has asked for: `select` misses it."""
        return b"\n" in self._buffer

    def send(self, verb: str, names: Sequence[str] = (), **options: Any) -> int:
        """Send a request without waiting; its id. `read` brings the answers."""
        request_id = next(self._ids)
        request = {
            "protocol": VERSION,
            "id": request_id,
            "verb": verb,
            "names": list(names),
            "options": options,
        }
        self._socket.settimeout(HELLO_PATIENCE_S)
        try:
            self._socket.sendall(json.dumps(request).encode() + b"\n")
        except OSError as error:
            raise _lost(error) from None
        return request_id

    def read(self, patience_s: float | None = None) -> dict[str, Any]:
        """The next line of the run as it is, for those who follow several things at once."""
        return self._answer(None if patience_s is None else time.monotonic() + patience_s)

    def wait_for_end(self, patience_s: float | None = None) -> bool:
        """Wait until the run has ended; whether it has."""
        deadline = None if patience_s is None else time.monotonic() + patience_s
        while True:
            try:
                self._answer(deadline)
            except SilentError:
                return False
            except ControlError:
                return True

    def _answer(self, deadline: float | None) -> dict[str, Any]:
        try:
            return self._read_object(deadline)
        except TimeoutError:
            raise SilentError("the run does not answer") from None
        except OSError as error:
            raise _lost(error) from None

    def _read_object(self, deadline: float | None) -> dict[str, Any]:
        while b"\n" not in self._buffer:
            self._socket.settimeout(_left_s(deadline))
            chunk = self._socket.recv(READ_BYTES)
            if not chunk:
                raise NoRunError("the run has ended")
            self._buffer += chunk
        line, _, self._buffer = self._buffer.partition(b"\n")
        try:
            found = json.loads(line)
        except ValueError:
            found = None
        if not isinstance(found, dict):
            raise ControlError("what listens there does not speak the launcher's protocol")
        return found


def _left_s(deadline: float | None) -> float | None:
    if deadline is None:
        return None
    left_s = deadline - time.monotonic()
    if left_s <= 0:
        raise TimeoutError
    return left_s


def _reply(answer: dict[str, Any]) -> Reply:
    if not answer.get("ok"):
        raise _refusal(answer)
    return Reply(answer.get("result") or {}, tuple(answer.get("text") or ()))


def _refusal(answer: dict[str, Any]) -> RefusedError:
    error = answer.get("error") or {}
    message = str(error.get("message", "the run refused"))
    return RefusedError(str(error.get("code", "refused")), message, error.get("hint"))


def _lost(error: OSError) -> ControlError:
    if isinstance(error, (BrokenPipeError, ConnectionResetError)):
        return NoRunError("the run has ended")
    return ControlError(f"the connection to the run is lost: {error.strerror or error}")
