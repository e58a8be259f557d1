"""py-spy: where it is, how it is called, what its answers mean."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import sys
from collections.abc import Callable, Sequence

from launcher.base import strict_json
from launcher.base.model.record import Record
from launcher.posix import proc
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import execute, reap
from launcher.run.stacks.dump import Dump, StackFrame, Thread, command_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


VARIABLE = "LAUNCHER_PY_SPY"  # its path, for one with capabilities; empty: use none
_DENIED = re.compile("permission denied|operation not permitted", re.IGNORECASE)
_PYTHON = re.compile(r"(python|pypy)[\d.]*[a-z]*")


def find() -> str | None:
    """The program: that of the variable, beside this Python, or in the PATH."""
    named = os.environ.get(VARIABLE)
    if named is not None:
        return named or None
    beside = os.path.join(os.path.dirname(sys.executable), "py-spy")
    return beside if os.access(beside, os.X_OK) else shutil.which("py-spy")


def is_usable() -> bool:
    """Whether it is there, and the kernel probably lets it look into processes of this user."""
    if find() is None:
        return False
    return os.geteuid() == 0 or _ptrace_scope() == "0" or bool(os.environ.get(VARIABLE))


def _ptrace_scope() -> str:
    return proc.read("sys", "kernel/yama/ptrace_scope").strip().decode() or "0"


def is_interpreter(pid: int) -> bool:
    """Whether its program is a Python interpreter."""
    try:
        program = os.path.basename(os.readlink(f"{proc.ROOT}/{proc.living_thread(pid)}/exe"))
    except OSError:
        return False
    return bool(_PYTHON.fullmatch(program))


def is_python(pid: int) -> bool:
    """Whether it is a Python interpreter, or has one in it."""
    return is_interpreter(pid) or any("/libpython" in path for path in proc.mapped(pid))


def words(program: str, pid: int, *, native: bool = False, with_locals: bool = False) -> list[str]:
    """The command for the stacks of a process.

    It stops the process for some milliseconds, which it cannot with one that is stopped already.
    """
    command = [program, "dump", "--json", "--full-filenames", "--pid", str(pid)]
    if proc.is_suspended(pid) or proc.is_traced(pid):
        command.append("--nonblocking")
    elif native:
        command.append("--native")
    return [*command, *(["--locals"] if with_locals else [])]


def parse(pid: int, output: bytes) -> Dump:
    """The dump that it has printed; ValueError if that is none."""
    try:
        threads = [_thread(entry) for entry in strict_json.loads(output)]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"unknown output of py-spy: {error!r}") from None
    threads.sort(key=lambda thread: (thread.tid != pid, thread.tid))
    return Dump(pid, command_of(pid), tuple(threads))


def _thread(entry: dict[str, Any]) -> Thread:
    state = "active" if entry["active"] else "idle"
    state += ", holds the GIL" if entry["owns_gil"] else ""
    frames = tuple(map(_frame, entry["frames"]))
    return Thread(int(entry["os_thread_id"] or 0), entry["thread_name"] or "-", state, frames)


def _frame(entry: dict[str, Any]) -> StackFrame:
    found = tuple((one["name"], str(one["repr"])) for one in entry["locals"] or ())
    return StackFrame(entry["name"], entry["filename"], int(entry["line"]), found)


def is_denied(completed: Completed) -> bool:
    """Whether the kernel has forbidden it to look into the process."""
    return bool(_DENIED.search(completed.errors.decode(errors="replace")))


def failure(completed: Completed) -> str:
    """Why there is no dump, in its own words."""
    if completed.returncode is None:
        return "py-spy did not end in time"
    first, *causes = completed.errors.decode(errors="replace").split("\n\nStack backtrace")[
        0
    ].splitlines() or ["no message"]
    details = [cause.strip().partition(": ")[2] for cause in causes[2:]]
    return ": ".join(["py-spy", first.removeprefix("Error: "), *filter(None, details)])


def repair(pid: int, program: str) -> tuple[str, str]:
    """(which rule forbids it, how to allow it)."""
    try:
        owner = os.stat(f"{proc.ROOT}/{pid}").st_uid
    except OSError:
        owner = os.geteuid()
    if os.geteuid() not in (0, owner):
        why = f"it belongs to user {owner}"
        command = f"sudo {shlex.quote(program)} dump --pid {pid}"
        return f"py-spy may not look into it: {why}", command
    scope = _ptrace_scope()
    rule = f"py-spy may not look into it: kernel.yama.ptrace_scope is {scope}"
    allow = f"sudo setcap cap_sys_ptrace=eip {shlex.quote(os.path.realpath(program))}"
    match scope:
        case "0":
            what = "py-spy may not look into it: it runs without the capability SYS_PTRACE"
            return what, "containers: --cap-add SYS_PTRACE (Kubernetes: capabilities: add)"
        case "1":
            return rule, f"sudo sysctl kernel.yama.ptrace_scope=0, or for py-spy alone: {allow}"
        case "2":
            return rule, allow
    return rule, "nothing can be traced until the next boot; see kernel.yama.ptrace_scope"


class Completed(Record):
    """How it ended; `returncode` is None if it had to be killed at its time limit."""

    returncode: int | None
    output: bytes
    errors: bytes


class ShortCommand:
    """Starts `words`, and calls `done` when they have ended; OSError if they cannot be started.

    Its output goes to memory, so that it never waits for a reader.
    """

    def __init__(
        self,
        reactor: Reactor,
        words: Sequence[str],
        done: Callable[[Completed], None],
        *,
        timeout_s: float,
    ) -> None:
        self._reactor = reactor
        self._done = done
        self._is_late = False
        null = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
        self._files = null, os.memfd_create("output"), os.memfd_create("errors")
        try:
            self._pid = execute(words, env=os.environ, streams=self._files)
        except OSError:
            self._close_files()
            raise
        self._pidfd = os.pidfd_open(self._pid)
        reactor.add_reader(self._pidfd, self._exited)
        self._timer = reactor.call_later(timeout_s, self._kill)

    def _kill(self) -> None:
        self._is_late = True
        os.kill(self._pid, signal.SIGKILL)

    def _exited(self) -> None:
        returncode, _ = self._reap()
        _, output, errors = (os.pread(fd, os.fstat(fd).st_size, 0) for fd in self._files)
        self._close_files()
        self._done(Completed(None if self._is_late else returncode, output, errors))

    def _reap(self) -> tuple[int, bool]:
        self._timer.cancel()
        self._reactor.remove(self._pidfd)
        end = reap(self._pidfd)
        os.close(self._pidfd)
        return end

    def _close_files(self) -> None:
        for fd in self._files:
            os.close(fd)

    def close(self) -> None:
        """Kill it; `done` is not called any more. Only before it has ended."""
        os.kill(self._pid, signal.SIGKILL)
        self._reap()
        self._close_files()
