"""One node of the fleet as a process, and what it printed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import psutil

from launcher.run.monitor import shared_memory
from tests.support.repository import REPOSITORY

# Fast DDS prints this of a port that another process on the machine opens or closes just then.
_PORT_COMPLAINT = re.compile("Failed init_port fast(?:rtps|dds)_port")


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One line of output."""

    text: str

    @property
    def logged_s(self) -> float:
        """When the node says that it logged this; seconds since the epoch."""
        return float(self.text.split("] [", 2)[1])


class NodeProcess:
    """A started node. Its output is read by a thread, so the node never blocks on it."""

    def __init__(self, name: str, *, env: Mapping[str, str], settings: Mapping[str, Any]) -> None:
        self.name = name
        self.lines: list[Line] = []
        command = [sys.executable, "-m", f"group_gp1.{name}", "--ros-args"]
        for key, value in settings.items():
            command += ["-p", f"{key}:={value}"]
        self._process = subprocess.Popen(
            command,
            cwd=REPOSITORY,
            env=dict(env),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    @property
    def output(self) -> str:
        return "\n".join(line.text for line in list(self.lines))

    def matching(self, text: str) -> list[Line]:
        """The lines so far that contain the text."""
        return [line for line in list(self.lines) if text in line.text]

    def log_texts(self) -> list[str]:
        """What the node logged so far, without level, time stamp and name."""
        logged = (re.match(r"\[\w+\] \[[\d.]+\] \[\w+\]: (.*)", x.text) for x in list(self.lines))
        return [match[1] for match in logged if match]

    def signal(self, signum: int) -> None:
        self._process.send_signal(signum)

    def wait(self, timeout_s: float = 60.0) -> int:
        """The exit code, with all output read; raises TimeoutExpired."""
        code = self._process.wait(timeout_s)
        self._reader.join(timeout_s)
        return code

    def stop(self) -> int:
        """Ask for an orderly end and wait for it."""
        self.signal(signal.SIGINT)
        return self.wait()

    def kill(self) -> None:
        """End it at once, whatever state it is in."""
        if self.running:
            os.killpg(self.pid, signal.SIGKILL)
        self.wait()

    def catches(self, signum: int) -> bool:
        """Whether the process has installed a handler for the signal by now."""
        status = Path(f"/proc/{self.pid}/status").read_text(encoding="ascii")
        mask = re.search(r"^SigCgt:\t(\w+)$", status, re.MULTILINE)
        return mask is not None and bool(int(mask[1], 16) >> (signum - 1) & 1)

    def _read(self) -> None:
        assert self._process.stdout is not None
        for text in self._process.stdout:
            if without_complaints(text):
                self.lines.append(Line(text=text.rstrip("\n")))


def without_complaints(text: str) -> str:
    """The text without the lines in which Fast DDS complains of a port."""
    lines = text.splitlines(keepends=True)
    return "".join(line for line in lines if not _PORT_COMPLAINT.search(line))


def line_of(pipe: IO[str] | None) -> str:
    """The next line that is no such complaint; empty at the end."""
    assert pipe is not None
    return next(filter(without_complaints, pipe), "")


def shared_memory_of(pid: int) -> set[Path]:
    """The files of Fast DDS in /dev/shm that a process has in use, with their locks."""
    try:
        maps = psutil.Process(pid).memory_maps()
    except psutil.Error:
        return set()
    mapped = {Path(one.path) for one in maps if one.path.startswith("/dev/shm/fast")}
    return {path.with_name(name) for path in mapped for name in _companions(path.name)}


def free_shared_memory(paths: Iterable[Path]) -> None:
    """Remove those of these files that nobody uses: a killed process had its peers' mapped, too."""
    shared_memory.free({re.sub(r"^sem\.|_(el|sl|mutex)$", "", path.name) for path in paths})


def _companions(name: str) -> tuple[str, str, str]:
    """The file itself, its lock and, where it is a port, its semaphore."""
    return name, f"{name}_el", f"sem.{name}_mutex"
