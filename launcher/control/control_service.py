"""Answers the requests of clients of the control socket, one method or table row per verb."""

from __future__ import annotations

import functools
import os
import re
import signal
from collections.abc import Callable, Mapping, Sequence

from launcher import __version__
from launcher.base.model.run_events import Asked
from launcher.base.option import load
from launcher.base.run_verb import BadCallError, Call
from launcher.base.text import count
from launcher.control import answer_lines, status, verbs
from launcher.control.log_followers import Logs
from launcher.control.peer import Exchange
from launcher.control.protocol import DISCOVERY_VARIABLES, VERSION, Request, to_json
from launcher.output.filters import Pattern, level_named
from launcher.packages import distribution
from launcher.run.output.screen_filters import ScreenFilters, Shown
from launcher.run.processes.process import Process
from launcher.run.requests.process_control import ProcessControl
from launcher.run.requests.process_selection import ProcessNames, refuse_part, resolve
from launcher.run.requests.request_queue import Done, ProcessRequest
from launcher.run.requests.request_result import Kind, Result
from launcher.run.requests.result_sentences import sentence, shown_sentence, shown_sentences
from launcher.run.run import Run

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


class RunRequest:
    """A verb of a part that is to be carried out."""

    def __init__(self, run: Run, call: Call, exchange: Exchange) -> None:
        self.run = run
        self.call = call
        self.exchange = exchange

    def chosen(self, names: Sequence[str] | None = None) -> list[Process]:
        """The processes that these words name, by default those of the call."""
        return chosen(self.run, self.call.names if names is None else names)


def chosen(run: Run, names: Sequence[str]) -> list[Process]:
    """The processes with these names; all of them if there are none. BadCallError."""
    processes = run.processes
    if not names:
        return processes
    places = resolve(names, [ProcessNames.of(process.spec) for process in processes])
    return [processes[place] for place in places]


class Service:
    """Serves one run; a request that waits for something is answered when it has happened."""

    def __init__(self, run: Run, filters: ScreenFilters, logs: Logs) -> None:
        self._run = run
        self._filters = filters
        self._logs = logs

    def hello(self) -> dict[str, Any]:
        """The first line for each client."""
        run = self._run
        return {
            "protocol": VERSION,
            "launcher": __version__,
            "ros": distribution.title(run.env),
            "run": {
                "id": run.id,
                "pid": os.getpid(),
                "target": run.launched.target,
                "arguments": list(run.launched.arguments),
                "started_wall_s": run.started_wall_s,
                "log_dir": run.log_dir,
                "domain_id": _domain_id(run.env),
                "discovery": _discovery(run.env),
                "processes": [process.name for process in run.processes],
            },
            **{name: value for part in run.parts for name, value in part.greeting().items()},
        }

    def serve(self, request: Request, exchange: Exchange) -> None:
        self._safely(request.verb, exchange, lambda: self._answer(request, exchange))

    def _answer(self, request: Request, exchange: Exchange) -> None:
        call = verbs.check(request.verb, request.names, request.options)
        name = call.verb.name
        if call.verb.serve:
            load(call.verb.serve)(RunRequest(self._run, call, exchange))
        elif name in _PROCESS_VERBS:
            do = functools.partial(_PROCESS_VERBS[name], self._run.process_control)
            self._each(call, exchange, do)
        elif name in _FILTER_VERBS:
            _show(call, exchange, _FILTER_VERBS[name](self._filters, self._chosen(call)))
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

            self._run.log.log("ERROR", "launch", traceback.format_exc().rstrip())
            exchange.fail(BadCallError("internal", f"'{verb}' failed; the log has more"))

    def _chosen(self, call: Call) -> list[Process]:
        return chosen(self._run, call.names)

    # ---- read-only verbs

    def _rows(self, call: Call, *, looks: bool = True) -> dict[str, Any]:
        return {
            "processes": status.rows(self._run, self._chosen(call), looks=looks),
            "sampled_every_s": self._run.housekeeper.sample_period_s,
        }

    def _do_ps(self, call: Call, exchange: Exchange) -> None:
        def answer(unanswered: Sequence[Mapping[str, Any]] = ()) -> None:
            result = self._rows(call)
            if call.options.get("responsive"):
                result["unknown_response"] = [one["name"] for one in unanswered if one["asked"]]
                result["unanswered"] = list(unanswered)
            text = [*answer_lines.table(result["processes"]), *answer_lines.notes(result)]
            exchange.reply(result, text)

        if call.options.get("responsive"):
            from launcher.run.monitor.responsiveness import Responsiveness

            self._run.parts.need(Responsiveness).ask(self._chosen(call), answer)
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
                from launcher.run.monitor.responsiveness import Responsiveness

                self._run.parts.need(Responsiveness).look()
                exchange.item(self._rows(call, looks=False))
                self._run.reactor.call_later(period_s, send_sample)

        send_sample()

    def _do_info(self, call: Call, exchange: Exchange) -> None:
        base = self._run.env
        found = [status.info(self._run, process, base) for process in self._chosen(call)]
        text = [line for one in found for line in answer_lines.info_lines(one)]
        exchange.reply({"processes": found}, text)

    def _do_plan(self, call: Call, exchange: Exchange) -> None:
        core = self._run.core
        exchange.reply(core.plan(), core.plan_lines())

    def _do_help(self, call: Call, exchange: Exchange) -> None:
        topic = call.options.get("topic")
        if topic not in (None, verbs.EVERYTHING):
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
        events = self._run.log.events
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
                self._run.process_control.withdraw(process, request)

        exchange.on_end = left
        for process in chosen:
            requests.append((process, do(process, done)))

    def _do_kill(self, call: Call, exchange: Exchange) -> None:
        kill = functools.partial(
            self._run.process_control.kill,
            signum=call.options.get("signal", signal.SIGKILL),
            as_crash=bool(call.options.get("as_crash")),
        )
        self._each(call, exchange, lambda process, done: kill(process, done=done))

    def _do_send(self, call: Call, exchange: Exchange) -> None:
        data = (call.options["text"] + "\n").encode(errors="surrogateescape")
        control = self._run.process_control
        self._each(call, exchange, lambda process, done: control.send(process, data, done))

    def _do_quit(self, call: Call, exchange: Exchange) -> None:
        running = sum(process.child is not None for process in self._run.processes)
        self._run.log.note(Asked("quit"))
        self._run.shutdown.stop("quit requested by a user")
        text = f"the run is being stopped: {count(running, 'process')} still running"
        exchange.reply({"running": running}, [text])

    # ---- screen filters

    def _do_level(self, call: Call, exchange: Exchange) -> None:
        word = call.options.get("level")
        if word is None:
            _show(call, exchange, self._filters.levels(self._chosen(call)))
            return
        try:
            level = level_named(word)
        except ValueError as error:
            hint = "known levels: DEBUG, INFO, WARN, ERROR, FATAL, ALL"
            raise BadCallError("bad-option", str(error), hint) from None
        _show(call, exchange, self._filters.level(level, self._chosen(call)))

    def _do_format(self, call: Call, exchange: Exchange) -> None:
        """The form of lines on the screen of the run."""
        from launcher.output import line_format

        word, screen = call.options.get("format"), self._run.screen
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
        _show(call, exchange, self._filters.grep(pattern, self._chosen(call)))


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
