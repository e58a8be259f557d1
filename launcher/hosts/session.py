"""Sessions with a host for commands that wait: a shared connection, and one command.

A run has an event loop instead (`engine/hosts`).
"""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence

from launcher.hosts.failures import SSH_FAILED, HostError, Problem, failure, no_ssh
from launcher.hosts.ssh import (
    CONNECT_TIMEOUT_S,
    READY,
    Connection,
    private_folder,
    quoted,
    ssh_environment,
)

_END_S = 2.0  # an orderly end of a connection takes less


class Master:
    """A connection that sessions share. HostError from `open` if there is none to be had.

    It ends with this process, however that ends, since its standard input is a pipe from here.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Master:
        self.open()
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def open(self, timeout_s: float = CONNECT_TIMEOUT_S + 5) -> None:
        """Connect, and return when sessions can share the connection."""
        self._process = _start(self._connection, self._connection.master(), stdin=subprocess.PIPE)
        if not _is_ready(self._process, timeout_s):
            returncode = self._process.poll()
            error = self._end()
            text = error if returncode is not None else "Connection timed out"
            raise failure(self._connection.host, text, returncode)

    def close(self) -> None:
        """End the connection and what still uses it; idempotent."""
        if self._process is not None:
            self._end()

    def _end(self) -> str:
        """End it, and return its messages."""
        process, self._process = self._process, None
        assert process is not None
        messages = ""
        for signum in (0, signal.SIGTERM, signal.SIGKILL):
            process.send_signal(signum)
            try:
                # Closes its standard input, which ends it.
                messages = process.communicate(timeout=_END_S)[1].decode(errors="replace")
                break
            except subprocess.TimeoutExpired:
                continue
        if self._connection.control_path is not None:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(self._connection.control_path)
        return messages


def _is_ready(process: subprocess.Popen[bytes], timeout_s: float) -> bool:
    """Whether it has printed `READY`; a login shell may print other lines before."""
    assert process.stdout is not None
    deadline, seen, marker = time.monotonic() + timeout_s, b"", f"{READY}\n".encode()
    while (left_s := deadline - time.monotonic()) > 0:
        if not select.select([process.stdout], [], [], left_s)[0]:
            break
        block = os.read(process.stdout.fileno(), 65536)
        if not block:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(_END_S)
            break
        seen += block
        if seen.startswith(marker) or b"\n" + marker in seen:
            return True
    return False


@contextlib.contextmanager
def masters_folder() -> Iterator[str]:
    """A private folder for the sockets of masters; removed at the end."""
    folder = private_folder()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run(
    connection: Connection,
    command: str | Sequence[str],
    *,
    data: bytes = b"",
    timeout_s: float | None = None,
) -> subprocess.CompletedProcess[bytes]:
    """Run a script of the POSIX shell there, or words; `data` is its standard input.

    HostError if ssh fails or the time is over; the exit code of the command is in the result.
    """
    script = command if isinstance(command, str) else f"exec {quoted(command)}"
    process = _start(connection, connection.session(script), stdin=subprocess.PIPE)
    try:
        output, errors = process.communicate(data, timeout=timeout_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        message = f"no answer within {timeout_s:g} s"
        raise HostError(connection.host, Problem.TIMEOUT, message) from None
    except BaseException:
        process.kill()
        process.wait()
        raise
    if process.returncode == SSH_FAILED:
        raise failure(connection.host, errors.decode(errors="replace"), process.returncode)
    return subprocess.CompletedProcess(process.args, process.returncode, output, errors)


def _start(connection: Connection, words: Sequence[str], *, stdin: int) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(
            words,
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=ssh_environment(os.environ),
            start_new_session=True,
        )
    except FileNotFoundError:
        raise no_ssh(connection.host) from None
