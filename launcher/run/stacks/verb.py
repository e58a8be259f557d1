"""`stack`: what the threads of processes are doing."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from launcher.base.run_verb import BadCallError
from launcher.run.process import Process
from launcher.run.stacks.dump import Dump, document, lines
from launcher.run.stacks.stacks import Stacks, Wish, members

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.part import VerbRequest


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
        wishes = {process.name: self._wishes(process) for process in wanted}
        self._missing = sum(map(len, wishes.values()))
        for name, refusal in refusals.items():
            self._found[name] = [Dump(0, "", problem=refusal)] if refusal else []
        for name, some in wishes.items():
            for wish in some:
                self._stacks.dump(wish, functools.partial(self._arrived, name))

    def _wishes(self, process: Process) -> list[Wish]:
        assert process.child is not None
        native, with_locals = (bool(self._options.get(name)) for name in ("native", "locals"))
        pids = members(process.child.pid)
        return [Wish(pid, native=native, with_locals=with_locals) for pid in pids]

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
