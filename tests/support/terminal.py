"""A command in a real pseudo-terminal, as a text stream."""

from __future__ import annotations

import contextlib
import re
import signal
from collections.abc import Mapping, Sequence
from pathlib import Path

import pexpect
import psutil

from launcher.posix import proc

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
TIMEOUT_S = 60.0


class Terminal:
    """Types, reads and waits. Use `with`: what is left in the end is killed."""

    def __init__(
        self, command: Sequence[str], *, env: Mapping[str, str], cwd: Path | str | None = None
    ) -> None:
        self._child = pexpect.spawn(
            command[0],
            list(command[1:]),
            env=dict(env),
            cwd=None if cwd is None else str(cwd),
            encoding="utf-8",
            codec_errors="replace",
            dimensions=(40, 160),
            timeout=TIMEOUT_S,
        )
        self._seen: list[str] = []

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *exc: object) -> None:
        try:
            self._child.close(force=True)
        except pexpect.ExceptionPexpect:  # it was still there 0.1 s after SIGKILL
            self._child.wait()

    @property
    def pid(self) -> int:
        return self._child.pid

    @property
    def raw(self) -> str:
        """All that was read so far, as the terminal got it."""
        return "".join(self._seen)

    @property
    def text(self) -> str:
        """The same without colours and with plain newlines."""
        return _COLOUR.sub("", self.raw).replace("\r\n", "\n")

    def wait_for(self, text: str, timeout_s: float = TIMEOUT_S) -> None:
        """Read until this text has come after what was waited for before."""
        try:
            self._child.expect_exact(text, timeout=timeout_s)
        except (pexpect.TIMEOUT, pexpect.EOF) as error:
            self._keep()
            kind = type(error).__name__
            raise AssertionError(f"{kind}: did not see {text!r}; saw:\n{self.text}") from None
        self._keep()

    def _keep(self) -> None:
        after = self._child.after
        self._seen.append((self._child.before or "") + (after if isinstance(after, str) else ""))

    def wait_for_all(self, *texts: str, timeout_s: float = TIMEOUT_S) -> None:
        """Read until each of these has come, in whatever order."""
        missing = [text for text in texts if text not in self.text]
        while missing:
            pattern = [re.escape(text) for text in missing]
            try:
                self._child.expect(pattern, timeout=timeout_s)
            except (pexpect.TIMEOUT, pexpect.EOF):
                self._keep()
                raise AssertionError(f"did not see {missing}; saw:\n{self.text}") from None
            self._keep()
            missing = [text for text in missing if text not in self.text]

    def type(self, text: str) -> None:
        """Type this."""
        self._child.send(text)

    def ctrl_c(self) -> None:
        """Type Ctrl-C: the terminal signals whatever is in the foreground."""
        self._child.sendintr()

    def signal(self, signum: int) -> None:
        """Signal the command itself."""
        self._child.kill(signum)

    def exit_code(self, timeout_s: float = TIMEOUT_S) -> int:
        """Read to the end; the exit code, negative for a signal."""
        try:
            self._child.expect(pexpect.EOF, timeout=timeout_s)
        except pexpect.TIMEOUT:
            self._keep()
            raise AssertionError(f"it has not ended; saw:\n{self.text}") from None
        self._keep()
        self._child.wait()
        if self._child.signalstatus is not None:
            return -self._child.signalstatus
        return self._child.exitstatus

    def kill(self) -> None:
        """SIGKILL, which nobody can catch."""
        self._child.kill(signal.SIGKILL)


def marked_processes(variable: str, value: str) -> dict[str, psutil.Process]:
    """Command line -> process of all whose environment has this entry, zombies left out.

    Psutil takes one whose main thread has ended for a zombie.
    """
    found = {}
    entry = f"{variable}={value}".encode()
    for pid in proc.pids():
        if entry in proc.environment(pid):
            with contextlib.suppress(psutil.NoSuchProcess):
                found[f"{' '.join(proc.command_line(pid))} [{pid}]"] = psutil.Process(pid)
    return found
