"""Command: the output of a command."""

from __future__ import annotations

import os
import selectors
import shlex
import subprocess

from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    MAX_TEXT,
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    too_long,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_POLICIES = ("fail", "ignore", "warn", "capture")
_READ_BYTES = 65536


@public("launch.substitutions.command")
class Command(Substitution):
    """The standard output of a command; `on_stderr` is the policy for standard error.

    `fail` raises, `ignore` drops it, `warn` logs it, `capture` adds it to the output.
    """

    command: list[Substitution] = read_only()
    on_stderr: list[Substitution] = read_only()

    def __init__(self, command: object, *, on_stderr: object = "fail") -> None:
        self.__command = normalize_to_list_of_substitutions(command)
        self.__on_stderr = normalize_to_list_of_substitutions(on_stderr)

    def describe(self) -> str:
        return f"Command({describe_substitutions(self.command)})"

    def perform(self, context: LaunchContext) -> str:
        """The output; SubstitutionFailure if the command is missing or fails."""
        command = perform_substitutions(context, self.command)
        policy = perform_substitutions(context, self.on_stderr)
        if policy not in _POLICIES:
            raise SubstitutionFailure(
                "expected 'on_stderr' to be one of: 'fail', 'ignore', 'warn' or 'capture'"
            )
        result = _run(shlex.split(command), merged=policy == "capture")
        if result.returncode != 0:
            output = f"\nCaptured stderr output: {result.stderr}" if result.stderr else ""
            raise SubstitutionFailure(f"executed command failed. Command: {command}{output}")
        if result.stderr:
            self._report_stderr(context, command, result.stderr, policy)
        return result.stdout

    @staticmethod
    def _report_stderr(context: LaunchContext, command: str, stderr: str, policy: str) -> None:
        message = (
            f"executed command showed stderr output. Command: {command}\n"
            f"Captured stderr output:\n{stderr}"
        )
        if policy == "fail":
            raise SubstitutionFailure(message)
        if policy == "warn":
            context._host.log("launch.substitutions.command", "WARNING", message)


def _run(words: list[str], *, merged: bool) -> subprocess.CompletedProcess[str]:
    if not words:
        raise IndexError("the command of $(command) is empty")  # the type as in ROS 2
    stderr = subprocess.STDOUT if merged else subprocess.PIPE
    try:
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=stderr, text=True)
    except FileNotFoundError as error:
        raise SubstitutionFailure(f"file not found: {error}") from error
    with process:
        try:
            texts = _read([one for one in (process.stdout, process.stderr) if one is not None])
        except BaseException:
            process.kill()
            raise
    return subprocess.CompletedProcess(words, process.returncode, *texts)


def _read(streams: list[Any]) -> list[str]:
    """What comes to the ends of the streams; SubstitutionFailure if it is too much."""
    parts: dict[Any, list[bytes]] = {stream: [] for stream in streams}
    size = 0
    with selectors.DefaultSelector() as open_streams:
        for stream in streams:
            open_streams.register(stream, selectors.EVENT_READ)
        while open_streams.get_map():
            for key, _ in open_streams.select():
                part = os.read(key.fd, _READ_BYTES)
                parts[key.fileobj].append(part)
                size += len(part)
                if not part:
                    open_streams.unregister(key.fileobj)
                if size > MAX_TEXT:
                    raise too_long("a command")
    return [
        _lines(b"".join(parts[stream]).decode(stream.encoding, stream.errors)) for stream in streams
    ]


def _lines(text: str) -> str:
    """As a file in text mode has it."""
    return text.replace("\r\n", "\n").replace("\r", "\n")
