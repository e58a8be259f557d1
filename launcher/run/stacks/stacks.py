"""Asks what processes of a run are doing, several at the same time and each only once."""

from __future__ import annotations

import functools
from collections import deque
from collections.abc import Callable, Sequence

from launcher.base.model.record import Record
from launcher.base.run_verb import BadCallError
from launcher.packages.extras import install_command
from launcher.posix import proc
from launcher.run.part import Part
from launcher.run.processes.process import Process
from launcher.run.stacks import py_spy, warm_stacks
from launcher.run.stacks.dump import Dump, command_of, document, lines, of_kernel
from launcher.run.stacks.py_spy import Completed, ShortCommand

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.part import VerbRequest
    from launcher.run.run import Run


TIMEOUT_S = 10.0
RETRY_S = 0.3  # py-spy cannot read an interpreter that is just being started, or changing much
TRIES = 4
AT_ONCE = 3  # each takes a processor for some ten milliseconds
MOST_PROCESSES = 16  # below one process of the run


class DumpRequest(Record):
    """Whose stacks are wanted, and how."""

    pid: int
    native: bool = False
    with_locals: bool = False


Done = Callable[[Dump], None]


class Stacks(Part):
    """Dumps stacks; requests for the same process are answered by the same dump."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._waiting: dict[DumpRequest, list[Done]] = {}
        self._queue: deque[tuple[DumpRequest, int]] = deque()
        self._running: dict[DumpRequest, ShortCommand] = {}

    def dump(self, request: DumpRequest, done: Done) -> None:
        """Call `done` with the stacks of this process, or with what is known instead."""
        if request in self._waiting:
            self._waiting[request].append(done)
            return
        self._waiting[request] = [done]
        if not py_spy.is_python(request.pid):
            self._answer(request, _of_other_program(request.pid))
        elif py_spy.find() is None:
            hint = f"{install_command('debug')} installs py-spy"
            self._ask(request, "py-spy is not installed", hint)
        else:
            self._queue.append((request, TRIES))
            self._start_some()

    def _start_some(self) -> None:
        while self._queue and len(self._running) < AT_ONCE:
            self._start(*self._queue.popleft())

    def _start(self, request: DumpRequest, tries: int) -> None:
        program = py_spy.find() or "py-spy"
        words = py_spy.words(
            program, request.pid, native=request.native, with_locals=request.with_locals
        )
        ended = functools.partial(self._ended, request, tries, program)
        try:
            self._running[request] = ShortCommand(self._reactor, words, ended, timeout_s=TIMEOUT_S)
        except OSError as error:
            problem = f"{program} cannot be started: {error.strerror}"
            self._answer(request, of_kernel(request.pid, problem, install_command("debug")))

    def _ask(self, request: DumpRequest, problem: str, hint: str) -> None:
        """Ask the process itself, where py-spy cannot be used."""

        def answered(dump: Dump | None) -> None:
            if dump is None and not proc.is_alive(request.pid):
                dump = _ended_meanwhile(request.pid)
            elif dump is None:
                more = f"{problem}, and it does not answer: C code holds the GIL, or it was forked"
                dump = of_kernel(request.pid, more, hint)
            elif request.native or request.with_locals:
                missing = "no native calls and local variables: " + problem
                dump = Dump(dump.pid, dump.command, dump.threads, missing, hint)
            self._answer(request, dump)

        if not warm_stacks.ask(self._reactor, request.pid, answered):
            self._answer(request, of_kernel(request.pid, problem, hint))

    def _ended(self, request: DumpRequest, tries: int, program: str, completed: Completed) -> None:
        del self._running[request]
        dump = _result(request.pid, completed)
        if completed.returncode and py_spy.is_denied(completed):
            self._ask(request, *py_spy.repair(request.pid, program))
        elif dump is None and tries > 1 and proc.is_alive(request.pid):
            again = functools.partial(self._again, request, tries - 1)
            self._reactor.call_later(RETRY_S, again)
        else:
            self._answer(request, dump or _without(request.pid, completed))
        self._start_some()

    def _again(self, request: DumpRequest, tries: int) -> None:
        if request in self._waiting:  # else: closed meanwhile
            self._queue.append((request, tries))
            self._start_some()

    def _answer(self, request: DumpRequest, dump: Dump) -> None:
        for done in self._waiting.pop(request, ()):
            done(dump)

    def end_helpers(self) -> None:
        """Drop all requests."""
        self._waiting.clear()
        self._queue.clear()
        for command in self._running.values():
            command.close()
        self._running.clear()


def _result(pid: int, completed: Completed) -> Dump | None:
    """The dump; None if another try may succeed."""
    if completed.returncode == 0:
        try:
            return py_spy.parse(pid, completed.output)
        except ValueError as error:
            return of_kernel(pid, str(error), "")
    return None


def _without(pid: int, completed: Completed) -> Dump:
    if not proc.is_alive(pid):
        return _ended_meanwhile(pid)
    return of_kernel(pid, py_spy.failure(completed), "")


def _ended_meanwhile(pid: int) -> Dump:
    return Dump(pid, command_of(pid), problem="it has ended meanwhile")


def _of_other_program(pid: int) -> Dump:
    if not proc.is_alive(pid):
        return _ended_meanwhile(pid)
    hint = f"gdb -p {pid} -batch -ex 'thread apply all bt'"
    return of_kernel(pid, "this is no Python program", hint)


def members(pid: int) -> list[int]:
    """The Python programs among a process and its descendants; the process itself if none is.

    A debugger may have an interpreter in it, too: it counts only where nothing else does.
    """
    family = sorted(proc.family([pid]))
    found = list(filter(py_spy.is_interpreter, family)) or list(filter(py_spy.is_python, family))
    return found[:MOST_PROCESSES] or [pid]


def serve(request: VerbRequest) -> None:
    """Answer when the last process is done; BadCallError if none of them runs here."""
    StackRequest(request).ask(request.chosen())


class StackRequest:
    """One request: it is answered in the order of the names."""

    def __init__(self, request: VerbRequest) -> None:
        self._stacks = request.run.parts.need(Stacks)
        self._options = request.call.options
        self._exchange = request.exchange
        self._found: dict[str, list[Dump]] = {}
        self._missing = 0

    def ask(self, processes: Sequence[Process]) -> None:
        """BadCallError if none of them runs here."""
        refusals = {process.name: _refusal(process) for process in processes}
        wanted = [process for process in processes if not refusals[process.name]]
        if not wanted:
            raise BadCallError("wrong-state", "; ".join(refusals.values()))
        requests = {process.name: self._requests(process) for process in wanted}
        self._missing = sum(map(len, requests.values()))
        for name, refusal in refusals.items():
            self._found[name] = [Dump(0, "", problem=refusal)] if refusal else []
        for name, some in requests.items():
            for request in some:
                self._stacks.dump(request, functools.partial(self._arrived, name))

    def _requests(self, process: Process) -> list[DumpRequest]:
        assert process.child is not None
        native, with_locals = (bool(self._options.get(name)) for name in ("native", "locals"))
        pids = members(process.child.pid)
        return [DumpRequest(pid, native=native, with_locals=with_locals) for pid in pids]

    def _arrived(self, name: str, dump: Dump) -> None:
        self._found[name].append(dump)
        self._missing -= 1
        if self._missing:
            return
        for dumps in self._found.values():
            dumps.sort(key=lambda one: one.pid)
        result = [
            {"name": name, "stacks": [document(one) for one in dumps if one.pid]}
            for name, dumps in self._found.items()
        ]
        text = [line for name, dumps in self._found.items() for line in _text(name, dumps)]
        self._exchange.reply({"processes": result}, text)


def _refusal(process: Process) -> str:
    if process.host is not None:
        return f"{process.name} runs on {process.host_name}: stacks are read on this machine only"
    if process.child is None:
        return f"{process.name} is not running ({process.machine.state.value})"
    return ""


def _text(name: str, dumps: Sequence[Dump]) -> list[str]:
    if not dumps[0].pid:
        return [dumps[0].problem]
    return [f"{name}: {line}" if line[:1] != " " else line for one in dumps for line in lines(one)]
