"""The least work that Python needs for each row: a script with the standard library only.

    python reference.py spawn COMMANDS            start all, nothing else
    python reference.py prefix COMMANDS           ... and put `[name-N] ` before each line
    python reference.py prefix --pty COMMANDS     the same through pseudo-terminals
    python reference.py prefix --respawn COMMANDS restart exited processes at once

COMMANDS is a JSON list of lists of words. SIGINT ends `prefix` in order.
"""

from __future__ import annotations

import json
import os
import pty
import selectors
import signal
import subprocess
import sys
import termios

READ_BYTES = 64 * 1024


class Prefixer:
    """Reads every child, prefixes whole lines, writes the result of each read at once."""

    def __init__(self, *, through_pty: bool, respawn: bool) -> None:
        self._selector = selectors.DefaultSelector()
        self._open_pair = _open_pty if through_pty else os.pipe
        self._respawn = respawn
        self._stopping = False
        self._children: dict[int, tuple[list[str], bytes, subprocess.Popen[bytes]]] = {}
        self._partial: dict[int, bytes] = {}

    def start(self, command: list[str], prefix: bytes) -> None:
        """Start one child and listen to it."""
        read_end, write_end = self._open_pair()
        child = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=write_end,
            stderr=write_end,
            start_new_session=True,
        )
        os.close(write_end)
        self._children[read_end] = (command, prefix, child)
        self._partial[read_end] = b""
        self._selector.register(read_end, selectors.EVENT_READ)
        if self._stopping:  # meanwhile: `stop` did not know this one yet
            os.killpg(child.pid, signal.SIGINT)

    def stop(self, *_: object) -> None:
        self._stopping = True
        for running in self._children.values():
            os.killpg(running[2].pid, signal.SIGINT)

    def run(self) -> None:
        """Run until the last child has exited."""
        signal.signal(signal.SIGINT, self.stop)
        while self._children:
            for key, _ in self._selector.select():
                self._read(key.fd)

    def _read(self, fd: int) -> None:
        try:
            chunk = os.read(fd, READ_BYTES)
        except OSError:
            chunk = b""  # EIO: the end of a pseudo-terminal
        if not chunk:
            self._end(fd)
            return
        head, newline, tail = chunk.rpartition(b"\n")
        if not newline:
            self._partial[fd] += tail
            return
        prefix = self._children[fd][1]
        lines = self._partial[fd] + head
        self._partial[fd] = tail
        _write(prefix + lines.replace(b"\n", b"\n" + prefix) + b"\n")

    def _end(self, fd: int) -> None:
        self._selector.unregister(fd)
        os.close(fd)
        command, prefix, child = self._children.pop(fd)
        child.wait()
        if self._respawn and not self._stopping:
            self.start(command, prefix)


def _open_pty() -> tuple[int, int]:
    ours, theirs = pty.openpty()
    attributes = termios.tcgetattr(theirs)
    attributes[1] &= ~termios.OPOST
    termios.tcsetattr(theirs, termios.TCSANOW, attributes)
    return ours, theirs


def _write(block: bytes) -> None:
    while block:
        block = block[os.write(1, block) :]


def _spawn_all(commands: list[list[str]]) -> None:
    pids = [os.posix_spawn(command[0], command, os.environ) for command in commands]
    for pid in pids:
        os.waitpid(pid, 0)


def main(words: list[str]) -> None:
    """Run the command line `words`."""
    commands: list[list[str]] = json.loads(words[-1])
    if words[0] == "spawn":
        _spawn_all(commands)
        return
    prefixer = Prefixer(through_pty="--pty" in words, respawn="--respawn" in words)
    for number, command in enumerate(commands, 1):
        prefixer.start(command, f"[{os.path.basename(command[0])}-{number}] ".encode())
    prefixer.run()


if __name__ == "__main__":
    main(sys.argv[1:])
