"""Answers the requests of clients of the control socket, one method or table row per verb."""

from __future__ import annotations

import functools
import os
import re
import signal
from collections.abc import Callable, Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.base.text import count
from launcher.control import format, status, verbs
from launcher.control.logs import Logs
from launcher.control.peer import Exchange
from launcher.control.protocol import DISCOVERY_VARIABLES, VERSION, Request, to_json
from launcher.control.results import sentence, shown_sentence, shown_sentences
from launcher.control.selection import ProcessNames, refuse_part, resolve
from launcher.control.server import Server
from launcher.control.verbs import BadCallError, Call
from launcher.output.filters import Pattern, level_named
from launcher.posix import socket_directory
from launcher.posix.socket_directory import ControlError
from launcher.run.output.screen_filters import ScreenFilters, Shown
from launcher.run.process import Process
from launcher.run.process_control import ProcessControl
from launcher.run.request_queue import Done, ProcessRequest
from launcher.run.request_result import Kind, Result
from launcher.run.run_control import RunControl

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

LAST_LINES = 100
LAST_LINES_BEFORE_NEW = 10  # of `logs -f`, as with tail(1)
SHORTEST_PERIOD_S = 0.1

# Verbs that do the same to each of the selected processes.
_PROCESS_VERBS = {
    "stop": ProcessControl.stop,
    "start": ProcessControl.start,
    "restart": ProcessControl.restart,
    "pause": ProcessControl.suspend,
    "resume": ProcessControl.resume,
}
_FILTER_VERBS = {
    "mute": ScreenFilters.mute,
    "unmute": ScreenFilters.unmute,
    "solo": ScreenFilters.solo,
    "show": ScreenFilters.show,
}


class Identity(Record):
    """A run, as its clients see it. `started` is in seconds since 1970."""

    run_id: str
    launcher: str
    target: str
    arguments: tuple[str, ...]
    started: float
    environment: Mapping[str, str]


class Service:
    """Serves one run; a request that waits for something is answered when it has happened."""

    def __init__(self, control: RunControl, identity: Identity) -> None:
        self._control = control
        self._identity = identity
        self._logs = Logs(control)

    def hello(self) -> dict[str, Any]:
        """The first line for each client."""
        identity = self._identity
        return {
            "protocol": VERSION,
            "launcher": identity.launcher,
            "run": {
                "id": identity.run_id,
                "pid": os.getpid(),
                "target": identity.target,
                "arguments": list(identity.arguments),
                "started": identity.started,
                "log_dir": self._control.log_dir,
                "domain_id": _domain_id(identity.environment),
                "discovery": _discovery(identity.environment),
                "processes": [process.name for process in self._control.processes],
            },
        }

    def serve(self, request: Request, exchange: Exchange) -> None:
        self._safely(request.verb, exchange, lambda: self._answer(request, exchange))

    def _answer(self, request: Request, exchange: Exchange) -> None:
        call = verbs.check(request.verb, request.names, request.options)
        name = call.verb.name
        if name in _PROCESS_VERBS:
            do = functools.partial(_PROCESS_VERBS[name], self._control.process_control)
            self._each(call, exchange, do)
        elif name in _FILTER_VERBS:
            _show(call, exchange, _FILTER_VERBS[name](self._control.filters, self._chosen(call)))
        else:
            getattr(self, f"_do_{name}")(call, exchange)

    def _safely(self, verb: str, exchange: Exchange, do: Callable[[], None]) -> None:
        try:
            do()
        except BadCallError as problem:
            exchange.fail(problem)
        except Exception:
            # A bug in a verb must not end the run.
            import traceback

            self._control.log.log("ERROR", "launch", traceback.format_exc().rstrip())
            exchange.fail(BadCallError("internal", f"'{verb}' failed; the log has more"))

    def _chosen(self, call: Call) -> list[Process]:
        """The processes that the request names; all of them if it names none."""
        processes = self._control.processes
        if not call.names:
            return processes
        places = resolve(call.names, [ProcessNames.of(process.spec) for process in processes])
        return [processes[place] for place in places]

    # ---- read-only verbs

    def _rows(self, call: Call) -> dict[str, Any]:
        return {
            "processes": [status.row(self._control, p) for p in self._chosen(call)],
            "sampled_every_s": self._control.housekeeper.sample_period_s,
        }

    def _do_ps(self, call: Call, exchange: Exchange) -> None:
        def answer(unknown: Sequence[str] = ()) -> None:
            result = self._rows(call)
            if call.options.get("responsive"):
                result["unknown_response"] = list(unknown)
            text = [*format.table(result["processes"]), *format.notes(result)]
            exchange.reply(result, text)

        if call.options.get("responsive"):
            self._control.responsiveness.ask(self._chosen(call), answer)
        else:
            answer()

    def _do_top(self, call: Call, exchange: Exchange) -> None:
        if not call.options.get("follow"):
            self._do_ps(call, exchange)
            return
        self._chosen(call)  # an unknown name fails now, not in a timer
        period_s = max(SHORTEST_PERIOD_S, call.options.get("period_s", 1.0))
        exchange.is_stream = True

        def send_sample() -> None:
            if exchange.is_open:
                self._control.responsiveness.look()
                exchange.item(self._rows(call))
                self._control.reactor.call_later(period_s, send_sample)

        send_sample()

    def _do_info(self, call: Call, exchange: Exchange) -> None:
        base = self._identity.environment
        found = [status.info(self._control, process, base) for process in self._chosen(call)]
        text = [line for one in found for line in format.info_lines(one)]
        exchange.reply({"processes": found}, text)

    def _do_stack(self, call: Call, exchange: Exchange) -> None:
        from launcher.control.stack import StackRequest

        StackRequest(self._control, call, exchange).ask(self._chosen(call))

    def _do_debug(self, call: Call, exchange: Exchange) -> None:
        from launcher.control.debug import DebugRequest

        chosen = self._chosen(call)
        if len(chosen) > 1:
            names = ", ".join(process.name for process in chosen)
            raise BadCallError("bad-request", f"debug takes one process, not {names}")
        refuse_part("debug", call.names, chosen[0].spec)
        DebugRequest(self._control, call, exchange).begin(chosen[0])

    def _do_plan(self, call: Call, exchange: Exchange) -> None:
        core = self._control.core
        exchange.reply(core.plan(), core.plan_lines())

    def _do_help(self, call: Call, exchange: Exchange) -> None:
        topic = call.options.get("topic")
        if topic is not None:
            verb = verbs.known(topic)
            entry = {"name": verb.name, "usage": verb.usage, "help": verb.help}
            exchange.reply({"verbs": [entry]}, verbs.manual(verb))
            return
        table = [{"name": v.name, "usage": v.usage, "help": v.help} for v in verbs.VERBS]
        width = max(len(verb.usage) for verb in verbs.VERBS)
        text = [f"{verb.usage:<{width}}  {verbs.explained(verb)}" for verb in verbs.VERBS]
        exchange.reply({"verbs": table}, text)

    def _do_pick(self, call: Call, exchange: Exchange) -> None:
        raise BadCallError("bad-request", "pick works only in the console of the run")

    def _do_logs(self, call: Call, exchange: Exchange) -> None:
        chosen = self._chosen(call) if call.names else None
        follow = bool(call.options.get("follow"))
        default = LAST_LINES_BEFORE_NEW if follow else LAST_LINES
        items = self._logs.last(chosen, call.options.get("lines", default))
        if not follow:
            text = [_with_name(item) for item in items]
            exchange.reply({"lines": items}, text)
            return
        exchange.is_stream = True
        exchange.past_items(map(to_json, items))
        self._logs.follow(chosen, exchange, call.options.get("max_rate"))

    def _do_events(self, call: Call, exchange: Exchange) -> None:
        events = self._control.log.events
        history = events.history() if call.options.get("history", True) else []
        if not call.options.get("follow"):
            exchange.reply_raw("events", history)
            return
        exchange.is_stream = True
        exchange.past_items(history)
        events.listeners.append(exchange.item_raw)
        exchange.on_end = lambda: events.listeners.remove(exchange.item_raw)

    # ---- control of processes

    def _each(
        self, call: Call, exchange: Exchange, do: Callable[[Process, Done], ProcessRequest]
    ) -> None:
        """Do it to each selected process, and answer when it is done for all.

        What has not begun when the client goes is not done.
        """
        chosen = self._chosen(call)
        for process in chosen:
            refuse_part(call.verb.name, call.names, process.spec)
        results: dict[str, Result] = {}
        requests: list[tuple[Process, ProcessRequest]] = []

        def done(result: Result) -> None:
            results[result.process] = result
            if len(results) == len(chosen):
                _answer(exchange, [results[process.name] for process in chosen])

        def left() -> None:
            for process, request in requests:
                self._control.process_control.withdraw(process, request)

        exchange.on_end = left
        for process in chosen:
            requests.append((process, do(process, done)))

    def _do_watch(self, call: Call, exchange: Exchange) -> None:
        from launcher.control import watches

        watches.serve(self._control, call, exchange, self._chosen)

    def _do_reload(self, call: Call, exchange: Exchange) -> None:
        from launcher.control import reloads

        reloads.serve(self._control, call, exchange)

    def _do_kill(self, call: Call, exchange: Exchange) -> None:
        kill = functools.partial(
            self._control.process_control.kill,
            signum=call.options.get("signal", signal.SIGKILL),
            as_crash=bool(call.options.get("as_crash")),
        )
        self._each(call, exchange, lambda process, done: kill(process, done=done))

    def _do_send(self, call: Call, exchange: Exchange) -> None:
        data = (call.options["text"] + "\n").encode(errors="surrogateescape")
        control = self._control.process_control
        self._each(call, exchange, lambda process, done: control.send(process, data, done))

    def _do_detach(self, call: Call, exchange: Exchange) -> None:
        try:
            detached = self._control.detach()
        except LauncherError as error:
            raise BadCallError("wrong-state", error.message) from None
        result = {
            "left": [{"name": name, "host": host} for name, host in detached.left],
            "stopped": list(detached.stopped),
            "dropped": list(detached.dropped),
        }
        exchange.reply(result, detached.sentences)

    def _do_quit(self, call: Call, exchange: Exchange) -> None:
        running = sum(process.child is not None for process in self._control.processes)
        self._control.quit("quit requested by a user")
        text = f"the run is being stopped: {count(running, 'process')} still running"
        exchange.reply({"running": running}, [text])

    # ---- screen filters

    def _do_level(self, call: Call, exchange: Exchange) -> None:
        word = call.options.get("level")
        if word is None:
            _show(call, exchange, self._control.filters.levels(self._chosen(call)))
            return
        try:
            level = level_named(word)
        except ValueError as error:
            hint = "known levels: DEBUG, INFO, WARN, ERROR, FATAL, ALL"
            raise BadCallError("bad-option", str(error), hint) from None
        _show(call, exchange, self._control.filters.level(level, self._chosen(call)))

    def _do_loglevel(self, call: Call, exchange: Exchange) -> None:
        from launcher.control.loglevel import answer

        answer(self._control, self._chosen(call), call, exchange)

    def _do_snapshot(self, call: Call, exchange: Exchange) -> None:
        from launcher.control.snapshot import answer

        answer(self._control, call, exchange)

    def _do_web(self, call: Call, exchange: Exchange) -> None:
        from launcher.control.page import answer

        answer(self._control, exchange)

    def _do_format(self, call: Call, exchange: Exchange) -> None:
        """The form of lines on the screen of the run."""
        from launcher.output import line_format

        word, screen = call.options.get("format"), self._control.screen
        if word is not None:
            try:
                screen.format = line_format.check(word)
            except ValueError as error:
                raise BadCallError("bad-option", str(error)) from None
        exchange.reply({"format": screen.format}, [f"format: {screen.format}"])

    def _do_grep(self, call: Call, exchange: Exchange) -> None:
        text = call.options.get("pattern")
        try:
            pattern = Pattern(text) if text else None
        except (re.error, ValueError, OverflowError, RecursionError) as error:
            raise BadCallError("bad-option", f"invalid pattern '{text}': {error}") from None
        _show(call, exchange, self._control.filters.grep(pattern, self._chosen(call)))


def _answer(exchange: Exchange, results: Sequence[Result]) -> None:
    """Fail only if nothing was done for any process."""
    text = [sentence(result) for result in results]
    if any(result.done for result in results):
        entries = [
            {"name": result.process, "done": result.done, "text": line}
            for result, line in zip(results, text, strict=True)
        ]
        exchange.reply({"processes": entries}, text)
        return
    is_stopping = any(result.kind is Kind.RUN_STOPPING for result in results)
    exchange.fail(BadCallError("stopping" if is_stopping else "wrong-state", "; ".join(text)))


def _show(call: Call, exchange: Exchange, changes: Sequence[Shown]) -> None:
    entries = [
        {"name": one.process, "text": shown_sentence(one), "hidden_lines": one.hidden_lines}
        for one in changes
    ]
    exchange.reply({"processes": entries}, shown_sentences(changes, is_everyone=not call.names))


def _with_name(item: Mapping[str, Any]) -> str:
    return item["text"] if item["process"] is None else f"[{item['process']}] {item['text']}"


def _domain_id(environment: Mapping[str, str]) -> int | None:
    """The ROS domain of the run; None if it is not a number."""
    text = environment.get("ROS_DOMAIN_ID") or "0"
    return int(text) if text.isdecimal() and len(text) < 10 else None


def _discovery(environment: Mapping[str, str]) -> dict[str, str]:
    """The variables with which the nodes of the run are found, where the usual ones do not do."""
    if not environment.get("ROS_DISCOVERY_SERVER") and not environment.get("ROS_STATIC_PEERS"):
        return {}
    return {name: environment.get(name, "") for name in DISCOVERY_VARIABLES}


def open_control(control: RunControl, identity: Identity) -> Server | None:
    """Start the control server of a run; warns and returns None if there is no place for it."""
    service = Service(control, identity)
    try:
        return Server(
            control.reactor,
            lambda: socket_directory.prepare(identity.run_id, os.environ, os.getuid()),
            hello=service.hello,
            serve=service.serve,
            warn=control.log.warn,
        )
    except ControlError as error:
        control.log.warn(f"cannot open the control socket: {error.message}")
        return None
