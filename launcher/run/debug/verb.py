"""`debug`: start a process under debugpy, and print where an editor attaches."""

from __future__ import annotations

from launcher.base import strict_json
from launcher.base.run_verb import BadCallError
from launcher.run.debug.debugger import Debugger, NotDebuggableError, debugger_for
from launcher.run.processes.process import Process
from launcher.run.requests.process_selection import refuse_part
from launcher.run.requests.request_queue import ProcessRequest, Purpose
from launcher.run.requests.request_result import Kind, Result
from launcher.run.requests.result_sentences import sentence

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.part import VerbRequest

POLL_S = 0.1
LISTENS_S = 60.0  # importing debugpy takes a second, or much longer on a busy machine


def serve(request: VerbRequest) -> None:
    """Answer when the debugger listens; BadCallError."""
    chosen = request.chosen()
    if len(chosen) > 1:
        names = ", ".join(process.name for process in chosen)
        raise BadCallError("bad-request", f"debug takes one process, not {names}")
    refuse_part("debug", request.call.names, chosen[0].spec)
    DebugRequest(request).begin(chosen[0])


class DebugRequest:
    """One request for one process."""

    def __init__(self, request: VerbRequest) -> None:
        self._run = request.run
        self._options = request.call.options
        self._exchange = request.exchange

    def begin(self, process: Process) -> None:
        """(Re)start the process; BadCallError if it cannot run under the debugger."""
        if process.host is not None:
            where = f"{process.name} runs on {process.host_name}"
            raise BadCallError("wrong-state", f"{where}: debug works on this machine only")
        if process.next_debugger is not None:
            text = f"{process.name} is being started under a debugger by another request"
            raise BadCallError("wrong-state", text)
        waits, port = bool(self._options.get("wait", True)), self._options.get("port")
        try:
            debugger = debugger_for(process.spec, port, waits=waits, before=process.debugger)
        except NotDebuggableError as error:
            raise BadCallError("bad-option", f"{process.name}: {error}", error.hint) from None
        process.next_debugger = debugger

        def restarted(result: Result) -> None:
            if result.kind is Kind.STARTED and process.debugger is debugger:
                self._await(process, debugger, self._run.reactor.now() + LISTENS_S)
                return
            if process.next_debugger is debugger:
                process.next_debugger = None
            self._exchange.fail(BadCallError("wrong-state", sentence(result)))

        control = self._run.process_control
        request = control.ask(process, ProcessRequest(Purpose.DEBUG, restarted))

        def left() -> None:
            control.withdraw(process, request)
            if process.next_debugger is debugger:  # nobody would attach
                process.next_debugger = None

        self._exchange.on_end = left

    def _await(self, process: Process, debugger: Debugger, until_s: float) -> None:
        if process.debugger is not debugger:
            end = process.last_end and process.last_end.outcome
            text = f"{process.name} ended before debugpy listened ({end}); `logs` has its output"
            self._exchange.fail(BadCallError("wrong-state", text))
        elif debugger.is_listening:
            self._answer(process, debugger)
        elif self._run.reactor.now() > until_s:
            text = f"{process.name}: debugpy does not listen after {LISTENS_S:.0f} s"
            self._exchange.fail(BadCallError("wrong-state", text))
        else:
            again = lambda: self._await(process, debugger, until_s)  # noqa: E731
            self._run.reactor.call_later(POLL_S, again)

    def _answer(self, process: Process, debugger: Debugger) -> None:
        assert process.child is not None
        does = "waits for" if debugger.waits else "runs, and accepts"
        state = f"{does} a debugger at {debugger.address}"
        self._run.log.log("INFO", process.name, f"process {state}")
        entry = strict_json.dumps(debugger.configuration)
        text = [
            f"{process.name} {state} (pid {process.child.pid})",
            "VS Code: an entry for `configurations` in .vscode/launch.json:",
            f"    {entry}",
            f"`restart {process.spec.label}` starts it without the debugger",
        ]
        result = {
            "name": process.name,
            "pid": process.child.pid,
            "address": debugger.address,
            "waits": debugger.waits,
            "configuration": debugger.configuration,
        }
        self._exchange.reply(result, text)
