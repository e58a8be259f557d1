"""Watches a run (`--expect`, `--watchful`): the table of its faults, and the verb `faults`.

Its process is `launcher.faults.watcher`, which judges; here is what the run has of it.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping

from launcher.base import strict_json
from launcher.base.model.fault_events import FaultConfirmed, FaultHealed
from launcher.base.run_verb import BadCallError
from launcher.base.text import count, did_you_mean, escape, several
from launcher.control.fault_texts import (
    NO_FAULT,
    NOT_WATCHING,
    fault_line,
    is_gone,
    is_reported,
    mute_lines,
)
from launcher.faults.watch_options import settings_of
from launcher.posix.reactor import Timer
from launcher.run.helpers.answering_process import AnsweringProcess
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.helpers.answering_process import Done
    from launcher.run.part import Exchange, VerbRequest
    from launcher.run.processes.process import Process
    from launcher.run.run import Run

    Document = dict[str, Any]  # a fault; docs/reference/faults.md

GOODBYE_S = 5.0  # to write the history and incidents to a slow disk
SILENT_S = 8.0  # one that has written nothing for so long does not watch: it has a line every 2 s
HANGING_S = 30.0  # the same, for a warning: a busy machine is none
CHECK_S = 5.0
MODULE = "launcher.faults.watcher"
_CHANGES = ("acknowledge", "mute", "unmute")
_OF_PROCESSES = ("no deaths: ", "not suspended: ", "responds: ")  # before the name of one


class FaultWatch(Part):
    """Starts the watcher, passes on requests, and keeps what it has reported.

    `faults` is by name; `left` has the expectations that are left to smoke, each as `expectation`
    and `why`. `listeners` get each fault that has changed, with the change: `suspected`,
    `confirmed`, `dismissed`, `healed`, `updated` or `forgotten`. `names` are those of the faults
    that there may be, as `checks.check` has them, and `when_named` is called with the watch when
    they have come. `mutes` has `reason` and `until_s` by the names of muted faults, seen or not.
    """

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self.faults: dict[str, Document] = {}
        self.left: list[Document] = []
        self.names: list[str] = []
        self.mutes: dict[str, Document] = {}
        self.when_named: list[Callable[[FaultWatch], object]] = []
        self.listeners: list[Callable[[Document, str], object]] = []
        self._heard_s = run.reactor.now()
        self._hangs = False
        self._timer: Timer | None = None
        settings = settings_of(run)
        self._expect: str | None = settings["expect"]
        self._process = AnsweringProcess(
            run,
            MODULE,
            settings,
            name="the watcher",
            without="the run is not watched",
            goodbye_s=GOODBYE_S,
            on_message=self._heard,
        )
        self._process.greeting = _begin(None)

    def begin(self) -> None:
        self._heard_s = self.run.reactor.now()
        self._process.start()
        self._timer = self.run.reactor.call_later(CHECK_S, self._check)

    @property
    def is_watching(self) -> bool:
        """Whether the watcher runs, and has written something lately."""
        return self._process.pid is not None and self._silent_s <= SILENT_S

    @property
    def _silent_s(self) -> float:
        return self.run.reactor.now() - self._heard_s

    def _check(self) -> None:
        """Warn, once each time, of a watcher that does not go on."""
        self._timer = self.run.reactor.call_later(CHECK_S, self._check)
        hangs = self._process.pid is not None and self._silent_s > HANGING_S
        if hangs and not self._hangs:
            self.run.log.warn("the watcher does not respond: faults are not reported")
        self._hangs = hangs

    def table(self) -> list[Document]:
        """All faults, by their first time."""
        return sorted(self.faults.values(), key=lambda one: one["first_s"])

    def active(self) -> list[Document]:
        """Those that were confirmed and are not healed."""
        return [one for one in self.table() if one["state"] == "active"]

    def reported(self) -> list[Document]:
        """The same without those that are muted."""
        return [one for one in self.active() if is_reported(one)]

    def is_root(self, fault: Mapping[str, Any], quiet: tuple[str, ...] = ("muted",)) -> bool:
        """Whether it follows from no other, or only from such as are `quiet` (fields of faults).

        What is kept quiet must not hide what follows from it.
        """
        seen = {fault["fault"]}
        while fault["follows"] is not None and fault["follows"] not in seen:
            seen.add(fault["follows"])
            root = self.faults.get(fault["follows"])
            if root is None or not any(root[name] is not None for name in quiet):
                return False
            fault = root
        return True

    # ---- what the watcher reports

    def _heard(self, report: Document) -> None:
        self._heard_s = self.run.reactor.now()
        if "alive" in report or "fault" in report:
            self._process.greeting = _begin(time.time())
        if "mutes" in report:
            self.mutes = report["mutes"]
        if "note" in report:
            self.run.log.warn(f"watching: {report['note']}")
        elif "mistake" in report:
            self._process.give_up()
            self.run.log.warn(f"the run is not watched:\n{report['mistake']}")
        elif "left" in report:
            self.left = report["left"]
        elif "names" in report:
            if not self.names and "counts" in report:
                self._say_what(*report["counts"])
            self.names = report["names"]
            for listener in self.when_named:
                listener(self)
        elif "fault" in report:
            self._changed(report["fault"], report["change"])
        if "id" in report:
            self._process.answer(report["id"], report)

    def _say_what(self, expectations: int, implied: int) -> None:
        """What is watched, and what is muted since earlier runs, at the start."""
        own = ""
        if self._expect is not None:
            own = f"{count(expectations, 'expectation')} of {os.path.basename(self._expect)} and "
        left = f"; {len(self.left)} left to smoke" if self.left else ""
        self.run.log.log("INFO", "launch", f"watching: {own}{implied} of every run{left}")
        if muted := [one["fault"] for one in self.muted()]:
            text = f"muted since an earlier run: {several(muted)} (`faults` lists them)"
            self.run.log.log("INFO", "launch", f"watching: {text}")

    def muted(self) -> list[Document]:
        """The mutes in force: `fault`, `reason` and `until_s`, by name."""
        now_s = time.time()
        return [
            {"fault": name, **mute}
            for name, mute in sorted(self.mutes.items())
            if mute["until_s"] is None or mute["until_s"] > now_s
        ]

    def may_come(self, name: str) -> bool:
        """Whether a fault of this name was seen, or may be."""
        possible = self.possible()
        if name in self.faults or name in possible:
            return True
        heads = (one[:-1] for one in possible if one.endswith("*"))
        return any(name.startswith(head) and name != head for head in heads)

    def possible(self) -> list[str]:
        """`names`, where those of faults about one process are of processes of the run."""
        named = [one for one in self.names if one[:-1] not in _OF_PROCESSES]
        heads = [head for head in _OF_PROCESSES if f"{head}*" in self.names]
        return named + [f"{head}{process.name}" for head in heads for process in self.run.processes]

    def _changed(self, fault: Document, change: str) -> None:
        if is_gone({**fault, "change": change}):
            self.faults.pop(fault["fault"], None)
        else:
            self.faults[fault["fault"]] = fault
        if fault["muted"] is None:
            self._log(fault, change)
        for listener in tuple(self.listeners):
            listener(fault, change)

    def _log(self, fault: Document, change: str) -> None:
        """Lines and entries of the event log for what was confirmed, and for its end."""
        log, process = self.run.log, self._process_of(fault)
        if change == "confirmed":
            follows = None if self.is_root(fault) else fault["follows"]
            event = FaultConfirmed(
                fault["fault"], fault["seen"], fault["incident"], fault["cause"], follows
            )
            log.log("WARNING" if follows is None else "INFO", "launch", event.text)
            log.note(event, process)
        elif change == "healed":
            active_s = round(fault["healed_s"] - fault["confirmed_s"], 1)
            healed = FaultHealed(fault["fault"], active_s, fault["incident"])
            log.log("INFO", "launch", healed.text)
            log.note(healed, process)

    def _process_of(self, fault: Document) -> Process | None:
        """The process that it is about, if it is one."""
        names = fault["processes"]
        if len(names) != 1:
            return None
        return next((p for p in self.run.processes if p.name == names[0]), None)

    # ---- requests

    def change(self, what: str, fault: str, more: Document, done: Done) -> None:
        """Acknowledge, mute or unmute; `done` gets the answer, with `error` if it is refused."""
        self._process.ask({"do": what, "fault": fault, **more}, done)

    def stopping(self) -> None:
        """What happens now is the end of the run, and no fault."""
        self._process.order({"do": "stop"})

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._process.order({"do": "end"})
        self._process.close()

    # ---- what is known of the run and its processes

    def greeting(self) -> Mapping[str, object]:
        """How many faults are active, for the status bar of the console."""
        return {"active_faults": len(self.reported())}

    def row(self, process: Process) -> Mapping[str, object]:
        """The names of the active faults that are about it, in `ps`.

        One that follows from another is not about all that publish its topic.
        """
        name = process.name
        return {
            "faults": [
                one["fault"]
                for one in self.reported()
                if one["processes"] == [name] or (name in one["processes"] and not one["follows"])
            ]
        }


def _begin(written_s: float | None) -> bytes:
    """The first line for a watcher, with the time of the last one of an earlier watcher."""
    return strict_json.packed({"do": "begin", "written_s": written_s}).encode()


def serve(request: VerbRequest) -> None:
    """The verb `faults`: the table, a stream of changes, or a change by a user; BadCallError."""
    run, options, exchange = request.run, request.call.options, request.exchange
    if not run.options.watchful and run.options.expect is None:
        hint = "start the run with --watchful, or with --expect FILE"
        raise BadCallError("wrong-state", "this run is not watched", hint)
    watch = run.parts.need(FaultWatch)  # which may not have begun yet
    change = _change_in(options)
    if change is not None:
        _serve_change(watch, change, options, exchange)
    elif options.get("follow"):
        _follow(watch, exchange)
    else:
        _show(watch, exchange)


def _change_in(options: Mapping[str, Any]) -> str | None:
    """Which change is requested; BadCallError for options that do not belong together."""
    changes = [name for name in _CHANGES if name in options]
    excluding = [*changes, *(["follow"] if options.get("follow") else [])]
    problem = None
    if changes and len(excluding) > 1:
        problem = f"'{excluding[0]}' and '{excluding[1]}' exclude each other"
    elif "for_s" in options and "mute" not in changes:
        problem = "a time belongs to 'mute'"
    elif "reason" in options and not {"acknowledge", "mute"} & {*changes}:
        problem = "a reason belongs to 'acknowledge' and 'mute'"
    if problem is not None:
        raise BadCallError("bad-option", f"faults: {problem}")
    return changes[0] if changes else None


def _show(watch: FaultWatch, exchange: Exchange) -> None:
    table, mutes, is_watching = watch.table(), watch.muted(), watch.is_watching
    result = {
        "faults": table,
        "mutes": mutes,
        "left_to_smoke": watch.left,
        "watching": is_watching,
    }
    lines = [fault_line(one) for one in table]
    if not is_watching:
        lines.append(NOT_WATCHING)
    elif not table:
        lines.append(NO_FAULT)
    exchange.reply(result, [*lines, *mute_lines(mutes, table)])


def _serve_change(
    watch: FaultWatch, change: str, options: Mapping[str, Any], exchange: Exchange
) -> None:
    name = options[change]
    is_meant = {"mute": watch.may_come(name), "unmute": name in watch.mutes}
    if name not in watch.faults and not is_meant.get(change):
        if watch.may_come(name):
            raise BadCallError("wrong-state", f"'{name}' was not seen yet, and is not muted")
        hint = did_you_mean(name, [*watch.faults, *watch.mutes, *watch.possible()])
        hint = hint or "`faults` lists them"
        raise BadCallError("bad-option", f"no fault '{name}'", hint)
    more = {"reason": options.get("reason"), "for_s": options.get("for_s"), "wall_s": time.time()}

    def done(answer: Document) -> None:
        if "error" in answer:
            exchange.fail(BadCallError("wrong-state", answer["error"]))
        elif "fault" not in answer:
            exchange.reply({"faults": []}, [f"{change}d: {escape(name)}, which was not seen yet"])
        else:
            exchange.reply({"faults": [answer["fault"]]}, [fault_line(answer["fault"])])

    watch.change(change, name, more, done)


def _follow(watch: FaultWatch, exchange: Exchange) -> None:
    exchange.is_stream = True

    def send(fault: Document, change: str) -> None:
        exchange.item({**fault, "change": change})

    for fault in watch.table():
        send(fault, "present")
    watch.listeners.append(send)
    exchange.on_end = lambda: watch.listeners.remove(send)
