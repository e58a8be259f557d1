"""The client's side of the control socket, with blocking calls and timeouts."""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.base.errors import ExitCode
from launcher.base.model.record import Record
from launcher.control.protocol import Request
from launcher.posix.socket_directory import ControlError

HELLO_TIMEOUT_S = 5.0
READ_BYTES = 64 * 1024


class Reply(Record):
    """The last answer to a request: `text` for users, `result` for programs."""

    result: dict[str, Any]
    text: tuple[str, ...]


class RefusedError(ControlError):
    """The run refused the request; `code` is one of the protocol's."""

    def __init__(self, code: str, message: str, hint: str | None) -> None:
        super().__init__(message, hint=hint)
        self.code = code
        if code in ("bad-option", "bad-request", "unknown-verb", "bad-launch-file"):
            self.exit_code = ExitCode.USAGE


class NoRunError(ControlError):
    """No run listens at the socket, or it has ended."""


class SilentError(ControlError):
    """The run did not answer in time."""


class Connection:
    """A connection to the run that listens at `path`: one request at a time, or one stream.

    `hello` is the first line that the run sends. Close it, or use `with`. Raises ControlError.
    """

    def __init__(self, path: Path | str, *, timeout_s: float = HELLO_TIMEOUT_S) -> None:
        self.path = Path(path)
        self._buffer = b""
        self._ids = itertools.count(1)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self.hello = self._connect(timeout_s)
        except ControlError:
            self.close()
            raise

    def _connect(self, timeout_s: float) -> dict[str, Any]:
        try:
            self._socket.settimeout(timeout_s)
            self._socket.connect(os.fsencode(self.path))
            hello = self._read_object(time.monotonic() + timeout_s)
        except (FileNotFoundError, ConnectionRefusedError):
            raise NoRunError(f"{self.path}: no run listens there") from None
        except TimeoutError:
            raise SilentError(f"{self.path}: the run does not answer") from None
        except OSError as error:
            raise ControlError(f"{self.path}: {error.strerror or error}") from None
        if "run" not in hello:
            raise _refusal(hello)
        return hello

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def fileno(self) -> int:
        """For `select`; see `has_line` for what is buffered."""
        return self._socket.fileno()

    def close(self) -> None:
        self._socket.close()

    def shutdown(self) -> None:
        """Wake up a thread that waits for an answer: it gets NoRunError."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def ask(
        self,
        verb: str,
        names: Sequence[str] = (),
        *,
        timeout_s: float | None = None,
        **options: Any,
    ) -> Reply:
        """Send a request and wait until it is carried out, at most `timeout_s`.

        Raises RefusedError; NoRunError if the run ends, SilentError at the timeout.
        """
        request_id = self.send(verb, names, **options)
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            answer = self._answer(deadline)
            if answer.get("id") != request_id or "item" in answer:
                continue  # belongs to an earlier stream
            return _reply(answer)

    def follow(
        self, verb: str, names: Sequence[str] = (), **options: Any
    ) -> Iterator[dict[str, Any]]:
        """Items of a stream, until the run ends."""
        request_id = self.send(verb, names, **{"follow": True, **options})
        while (item := self.next_item(request_id)) is not None:
            yield item

    def next_item(self, request_id: int) -> dict[str, Any] | None:
        """Next item of the stream that `send` has requested; None at its end."""
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
        """Whether a line is buffered, which `select` cannot know."""
        return b"\n" in self._buffer

    def send(self, verb: str, names: Sequence[str] = (), **options: Any) -> int:
        """Send a request and return its id; `read` or `next_item` get the answers."""
        request_id = next(self._ids)
        request = Request(request_id, verb, tuple(names), options)
        self._socket.settimeout(HELLO_TIMEOUT_S)
        try:
            self._socket.sendall(request.line())
        except OSError as error:
            raise _lost(error) from None
        return request_id

    def read(self, timeout_s: float | None = None) -> dict[str, Any]:
        """Next line of the run, for clients that send several requests at once."""
        return self._answer(None if timeout_s is None else time.monotonic() + timeout_s)

    def wait_for_end(self, timeout_s: float | None = None) -> bool:
        """Wait for the end of the run; False at the timeout."""
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
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
            found = strict_json.loads(line)
        except ValueError:
            found = None
        if not isinstance(found, dict):
            raise ControlError("the server at this socket does not use the launcher's protocol")
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
