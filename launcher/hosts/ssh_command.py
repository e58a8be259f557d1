"""One command on a host, for callers that wait; a run has an event loop (`hosts/engine`)."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence

from launcher.hosts.failures import SSH_FAILED, HostError, Problem, failure, no_ssh
from launcher.hosts.ssh import SshConnection, quoted, ssh_environment


def run(
    connection: SshConnection,
    command: str | Sequence[str],
    *,
    data: bytes = b"",
    timeout_s: float | None = None,
) -> subprocess.CompletedProcess[bytes]:
    """Run a script of the POSIX shell there, or words; `data` is its standard input.

    HostError if ssh fails or the time is over; the exit code of the command is in the result.
    """
    script = command if isinstance(command, str) else f"exec {quoted(command)}"
    process = _start(connection, script)
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


def _start(connection: SshConnection, script: str) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(
            connection.session(script),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=ssh_environment(os.environ),
            start_new_session=True,
        )
    except FileNotFoundError:
        raise no_ssh(connection.host) from None
