"""The stacks of a process as data, and as lines of text."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.model.record import Record, as_dict
from launcher.base.text import escape, shown_path
from launcher.posix import proc


class StackFrame(Record):
    """A call; `line` is 0 where it is not known. `locals` are (name, value)."""

    function: str
    file: str
    line: int
    locals: tuple[tuple[str, str], ...] = ()

    @property
    def place(self) -> str:
        """`blocked (robot.py:7)`."""
        line = f":{self.line}" if self.line else ""
        return f"{self.function} ({shown_path(self.file)}{line})"


class Thread(Record):
    """A thread, and its frames from the innermost on (none of programs that are no Python)."""

    tid: int
    name: str
    state: str
    frames: tuple[StackFrame, ...] = ()


class Dump(Record):
    """The threads of a process; the main thread is the first.

    `problem` says why there are no Python stacks, and `hint` what to do.
    """

    pid: int
    command: str
    threads: tuple[Thread, ...] = ()
    problem: str = ""
    hint: str = ""

    @property
    def place(self) -> str:
        """Where the main thread is; empty if it is not known."""
        frames = self.threads[0].frames if self.threads else ()
        return frames[0].place if frames else ""


def document(dump: Dump) -> dict[str, object]:
    """Ready for JSON."""
    threads = [
        {
            **as_dict(thread),
            "frames": [as_dict(frame) | {"locals": dict(frame.locals)} for frame in thread.frames],
        }
        for thread in dump.threads
    ]
    return {**as_dict(dump), "threads": threads}


def lines(dump: Dump) -> list[str]:
    """As text, the innermost call of each thread first."""
    text = [f"pid {dump.pid}: {dump.command}"]
    for thread in dump.threads:
        text.append(f"  thread {thread.tid} {thread.name} ({thread.state})")
        for frame in thread.frames:
            text.append(f"    {frame.place}")
            text += [escape(f"        {name} = {value}") for name, value in frame.locals]
    text += [f"  {dump.problem}"] * bool(dump.problem)
    return text + [f"  hint: {dump.hint}"] * bool(dump.hint)


def of_kernel(pid: int, problem: str, hint: str) -> Dump:
    """What the kernel shows of any process: the state of each thread."""
    living = (tid for tid in proc.threads(pid) if proc.living_thread(tid) == tid)
    tids = sorted(living, key=lambda tid: (tid != pid, tid))
    threads = tuple(Thread(tid, proc.command_name(tid), proc.describe_state(tid)) for tid in tids)
    return Dump(pid, command_of(pid), threads, problem, hint)


def command_of(pid: int) -> str:
    """Its command line; its name where it has none."""
    words: Sequence[str] = proc.command_line(pid)
    return escape(" ".join(words), keep="") or f"[{proc.command_name(pid)}]"
