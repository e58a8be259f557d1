"""Carries out what a supervision file says about faults (`on:`)."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.model.fault_action import WHEN, FaultAction
from launcher.base.model.fault_events import ActionTaken, FaultConfirmed
from launcher.base.run_verb import BadCallError
from launcher.base.text import did_you_mean
from launcher.faults.actions import desktop
from launcher.faults.actions.action_budget import ActionBudget
from launcher.faults.actions.outside_program import Done, OutsideProgram
from launcher.faults.fault_watch import FaultWatch
from launcher.launch.supervise.fault_fields import is_url
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.base.model.run_options import RunOptions
    from launcher.run.run import Run

    Document = Mapping[str, Any]  # a fault

WEBHOOK = "launcher.faults.actions.webhook"
MAX_RUNNING = 16  # commands and webhooks at the same time
MAX_VARIABLE = 2000
_VARIABLES = {
    "LAUNCHER_FAULT": "fault",
    "LAUNCHER_FAULT_STATE": "state",
    "LAUNCHER_FAULT_CAUSE": "cause",
    "LAUNCHER_INCIDENT": "incident",
}


class UnwatchedActions(Part):
    """In a run without a control socket, which nothing can watch."""

    def begin(self) -> None:
        _warn_of_no_watch(self.run)


def _warn_of_no_watch(run: Run) -> None:
    hint = "start it with --watchful, or with --expect FILE"
    where = run.options.fault_actions[0].where
    run.log.warn(f"{where}: 'on' is not used: the run is not watched; {hint}")


class FaultActions(Part):
    """Listens to the watch. Requests for processes are those of a user; programs are outside."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._budgets: dict[FaultAction, ActionBudget] = {}
        self._programs: list[OutsideProgram] = []  # that may be running
        self._useless: set[FaultAction] = set()
        self._unmatched: set[FaultAction] = set()

    def begin(self) -> None:
        self._check()
        watch = self.run.parts.find(FaultWatch)
        if watch is not None:
            watch.listeners.append(self._changed)
            watch.when_named.append(self._check_names)
            self._check_names(watch)
            for fault in watch.active():  # confirmed while this was imported
                self._changed(fault, WHEN[0])

    def follow(self, before: RunOptions) -> None:
        if self.run.options.fault_actions != before.fault_actions:
            self._check()
            if (watch := self.run.parts.find(FaultWatch)) is not None:
                self._check_names(watch)

    def _check(self) -> None:
        """Warn of what can never be done in this run."""
        actions = self.run.options.fault_actions
        if actions and self.run.parts.find(FaultWatch) is None:
            _warn_of_no_watch(self.run)
        lacks = {
            "snapshot": self.run.options.record is None and "the run is not recorded (--record)",
            "desktop": desktop.sender(self.run.env) is None
            and "there is no desktop, or neither notify-send nor busctl",
        }
        found = {one: why for one in actions if (why := lacks.get(one.kind) or self._lack(one))}
        for one, why in found.items():
            if one not in self._useless:
                self.run.log.warn(f"{one.where}: '{one.kind}' is not used: {why}")
        self._useless = {*found}

    def _lack(self, action: FaultAction) -> str | None:
        """What the environment must have for a webhook, and has not."""
        url, env = _url_of(action, self.run.agent_env), self.run.agent_env
        lacking = [name for _, name in action.headers if name not in env]
        if action.kind != "webhook" or (is_url(url) and not lacking):
            return None
        return f"the environment has no usable {lacking[0] if lacking else action.url[1:]}"

    def _check_names(self, watch: FaultWatch) -> None:
        """Warn of patterns that no fault can match, as soon as it is known which there may be."""
        actions = self.run.options.fault_actions if watch.names else ()
        names = watch.possible()
        found = {one for one in actions if not one.may_fit(names)}
        for one in actions:
            if one not in found or one in self._unmatched:
                continue
            left = [name for name in watch.left if one.may_fit([name["expectation"]])]
            hint = did_you_mean(one.pattern, names)
            more = f": '{left[0]['expectation']}' is left to smoke" if left else ""
            more = more or (f" ({hint})" if hint else "")
            self.run.log.warn(f"{one.where}: '{one.pattern}' matches no fault{more}")
        self._unmatched = found

    # ---- faults

    def _changed(self, fault: Document, change: str) -> None:
        is_quiet = fault["muted"] is not None or fault["acknowledged"] is not None
        if change not in WHEN or is_quiet or self.run.shutdown.has_begun:
            return
        # Nothing is done for a root that is muted or acknowledged, so what follows is one.
        watch = self.run.parts.find(FaultWatch)
        follows = watch is None or not watch.is_root(fault, ("muted", "acknowledged"))
        for action in self.run.options.fault_actions:
            is_meant = action.when == change and action not in self._useless
            if is_meant and action.fits(fault["fault"], follows=follows):
                self._take(action, fault)

    def _take(self, action: FaultAction, fault: Document) -> None:
        made = ActionBudget(action.times, action.period_s)
        budget = self._budgets.setdefault(action, made)
        if not budget.take(self.run.reactor.now()):
            if budget.is_first_refusal:
                bound = f"at most {action.times} per {action.period_s:g} s"
                text = f"{action.text}: not done for fault '{fault['fault']}': {bound}"
                self.run.log.warn(f"{text} ({action.where})")
            return
        done = functools.partial(self._done, action, fault)
        try:
            _DO[action.kind](self, action, fault, done)
        except BadCallError as error:
            done(False, f"{error}; {error.hint}" if error.hint else str(error))
        except OSError as error:
            done(False, error.strerror or str(error))

    def _done(self, action: FaultAction, fault: Document, ok: bool, detail: str) -> None:
        event = ActionTaken(fault["fault"], action.text, ok, detail)
        self.run.log.log("INFO" if ok else "WARNING", "launch", event.text)
        self.run.log.note(event)

    # ---- processes of the run

    def _request(self, action: FaultAction, fault: Document, done: Done) -> None:
        """As the verb of this name does it; BadCallError for an unknown process."""
        from launcher.control.control_service import chosen
        from launcher.faults.actions.process_request import ProcessRequests

        processes = chosen(self.run, action.names)
        ProcessRequests(self.run, action, processes, done)

    # ---- the rest

    def _snapshot(self, action: FaultAction, fault: Document, done: Done) -> None:
        from launcher.bag.flight.flight_recorder import FlightRecorderProcess

        recorder = self.run.parts.find(FlightRecorderProcess)
        if recorder is None:
            done(False, "the flight recorder is not running")
            return

        def answered(answer: Document) -> None:
            done("error" not in answer, answer.get("error") or answer["snapshot"])

        event = FaultConfirmed(fault["fault"], fault["seen"], fault["incident"], fault["cause"])
        recorder.snapshot(event.text, answered, of_fault=True)

    def _command(self, action: FaultAction, fault: Document, done: Done) -> None:
        more = {name: _variable(fault[field]) for name, field in _VARIABLES.items()}
        env = {**self.run.agent_env, **more}

        def say(line: str) -> None:
            self.run.log.log("INFO", "launch", f"{action.text}: {line}")

        self._start(action, action.words, env, fault, on_line=say, done=done)

    def _webhook(self, action: FaultAction, fault: Document, done: Done) -> None:
        env = self.run.agent_env
        headers = {header: env[name] for header, name in action.headers}
        url = _url_of(action, env)
        request = {"url": url, "headers": headers, "within_s": action.within_s, "body": fault}
        answers: list[str] = []

        def ended(ok: bool, how: str) -> None:
            done(ok, answers[0] if len(answers) == 1 else how)

        words = (sys.executable, "-m", WEBHOOK)
        self._start(action, words, env, request, on_line=answers.append, done=ended)

    def _notify(self, action: FaultAction, fault: Document, done: Done) -> None:
        program = desktop.sender(self.run.env)
        words = desktop.words(program or "notify-send", fault)
        self._start(action, words, self.run.env, fault, on_line=lambda line: None, done=done)

    def _start(
        self,
        action: FaultAction,
        words: Sequence[str],
        env: Mapping[str, str],
        document: object,
        *,
        on_line: Callable[[str], object],
        done: Done,
    ) -> None:
        self._programs = [one for one in self._programs if one.is_running]
        if len(self._programs) >= MAX_RUNNING:
            done(False, f"{MAX_RUNNING} others are running")
            return
        program = OutsideProgram(
            self.run.reactor,
            words,
            env,
            strict_json.packed(document).encode(),
            within_s=action.within_s,
            on_line=on_line,
            done=done,
        )
        self._programs.append(program)

    # ---- the end of the run

    def stopping(self) -> None:
        for program in self._programs:
            program.end("the run is being stopped")

    def end_helpers(self) -> None:
        for program in self._programs:
            program.kill()

    def close(self) -> None:
        for program in self._programs:
            program.close()


_DO: dict[str, Callable[[FaultActions, FaultAction, Document, Done], None]] = {
    "restart": FaultActions._request,
    "stop": FaultActions._request,
    "start": FaultActions._request,
    "snapshot": FaultActions._snapshot,
    "run": FaultActions._command,
    "webhook": FaultActions._webhook,
    "desktop": FaultActions._notify,
}


def _url_of(action: FaultAction, env: Mapping[str, str]) -> str:
    return env.get(action.url[1:], "") if action.url.startswith("$") else action.url


def _variable(value: object) -> str:
    """A value for the environment."""
    text = "" if value is None else str(value).replace("\0", " ")
    return os.fsdecode(text[:MAX_VARIABLE].encode("utf-8", "replace"))
