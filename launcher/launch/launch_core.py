"""A run: the interpreter as the engine sees it, and a supervisor with its helpers."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence

from launcher.base.errors import LaunchFileError
from launcher.base.model.events import (
    LoadComponent,
    ProcessExited,
    ProcessStarted,
    SpawnFailed,
    StartProcess,
)
from launcher.launch.time_limit import limited
from launcher.packages import reading_once

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.base.errors import LauncherError
    from launcher.base.model.events import Effect, Event, LoadRequest
    from launcher.base.model.reload_changes import Known
    from launcher.base.model.run_options import RunOptions
    from launcher.base.model.spec import ProcessSpec
    from launcher.language.description import LaunchDescription
    from launcher.language.interpreter import Interpreter
    from launcher.language.interpreter.later import Later
    from launcher.launch.launch_options import SettingsSource
    from launcher.launch.reloading import Reevaluation
    from launcher.launch.run_plan import RunStep
    from launcher.launch.target import LaunchRequest
    from launcher.posix.reactor import Reactor
    from launcher.run.core_driver import Core
    from launcher.run.run import Launched
    from launcher.run.supervisor import Supervisor

MAX_RECORDED_STEPS = 2000  # bounds the memory for the plan of a run
_STARTED_OR_ENDED = (ProcessStarted, ProcessExited, SpawnFailed)
_FIRST_SERVICE = 1 << 30  # ids of processes of the launch file are smaller


class LaunchCore:
    """An interpreter whose start is limited in time, and which records what the run did.

    Its `services` are processes of the launcher's own, which start first and stop last. The
    interpreter does not have them: no handler is called for them, and no run goes on for their
    sake. `adapt` makes of a process in a plan what options make of it. `source` has the options for
    a reload.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        description: LaunchDescription,
        request: LaunchRequest,
        adapt: Callable[[ProcessSpec], ProcessSpec] = lambda spec: spec,
        source: SettingsSource | None = None,
        services: Sequence[ProcessSpec] = (),
    ) -> None:
        self.interpreter = interpreter
        self._description = description
        self._request = request
        self._adapt = adapt
        self._source = source
        self.effects: Sequence[Effect] = ()  # of the static part
        self._steps: list[RunStep] = []
        self._services = dict(enumerate(services, _FIRST_SERVICE))
        self._started: set[int] = set()  # by a reload; the interpreter has the event already

    def evaluate(self) -> None:
        """Visit the static part, before any file or process is created; LauncherError."""
        try:
            with limited(self._request.time_limit, self._request.path), reading_once():
                self.effects = self.interpreter.start()
        except LaunchFileError as fault:
            from launcher.launch import mistakes

            # What a warning is about is often the reason.
            for warning in self.interpreter.warnings:
                print(warning.render(), file=sys.stderr)
            errors = self._unknown_arguments()
            errors += mistakes.of_launch_file(
                fault,
                self._description,
                self.interpreter.context,
                self._request.arguments,
                os.environ,
            )
            error = mistakes.together(errors, fault)
            raise error from error.__cause__
        if self.interpreter.unused_arguments:
            from launcher.launch import mistakes

            errors = self._unknown_arguments()
            if errors:
                raise mistakes.together(errors)

    def _unknown_arguments(self) -> list[LauncherError]:
        """Of those that were given, unless any are accepted; prints warnings."""
        if self._request.lenient:
            return []
        from launcher.launch import launch_checks

        with limited(self._request.time_limit, self._request.path):
            errors, warnings = launch_checks.unknown_arguments(self.interpreter, self._description)
        for warning in warnings:
            print(f"warning: {warning}", file=sys.stderr)
        return errors

    @property
    def starts(self) -> list[ProcessSpec]:
        """The processes of the static part."""
        return [one.spec for one in self.effects if isinstance(one, StartProcess)]

    @property
    def loads(self) -> list[LoadRequest]:
        """The components that the static part loads."""
        found = [one for one in self.effects if isinstance(one, LoadComponent)]
        return [load for one in found for load in (one.request, *one.rest)]

    def later(self) -> Later:
        """What may follow the static part, as far as that is known; before `start`."""
        from launcher.language.interpreter.later import later  # for few runs
        from launcher.posix.stdio import silence

        with limited(self._request.time_limit, self._request.path), silence():
            return later(self.interpreter)

    def start(self) -> Sequence[Effect]:
        """Begin the run: the effects of the static part, which are recorded."""
        self._steps.append((time.monotonic(), None, self.effects))
        if not self._services:
            return self.effects
        found = self._services.items()
        services = [StartProcess(process_id=number, spec=spec) for number, spec in found]
        return [*services, *self.effects]

    def handle(self, event: Event) -> Sequence[Effect]:
        process_id = getattr(event, "process_id", None)
        if process_id is not None and process_id not in self.interpreter.host.processes:
            return ()  # a service, or a process that the launch file does not have any more
        if process_id in self._started and isinstance(event, _STARTED_OR_ENDED):
            self._started.discard(process_id)
            if isinstance(event, ProcessStarted):
                return ()
        effects = self.interpreter.handle(event)
        if effects and len(self._steps) < MAX_RECORDED_STEPS:
            self._steps.append((time.monotonic(), _ended_process(event), effects))
        return effects

    def watches_output(self, process_id: int) -> bool:
        """Whether the launch file has a handler for the output of this process."""
        return self.interpreter.watches_output(process_id)

    @property
    def has_failed(self) -> bool:
        return self.interpreter.failure is not None

    def switched_off(self) -> Sequence[ProcessSpec]:
        """The processes that conditions have kept away, if the interpreter notes scopes."""
        scopes = self.interpreter.host.scopes
        return () if scopes is None else scopes.off

    def intentions(self) -> Sequence[str]:
        """What the launch file would still do by itself."""
        return self.interpreter.intentions()

    def read_options(self) -> RunOptions:
        """The options of the run, with its supervision files as they are now; LauncherError."""
        assert self._source is not None  # a script has none, and cannot be reloaded
        return self._source.read()

    def evaluate_again(
        self,
        known: Sequence[Known],
        options: RunOptions,
        adapt: Callable[[ProcessSpec], ProcessSpec],
        elapsed_s: float,
    ) -> Reevaluation:
        """Evaluate the launch file as it is now, which changes nothing yet; LauncherError.

        `adapt` applies the options. The first timers of the run count for `elapsed_s`.
        """
        from launcher.launch import reloading

        effects = [effect for _, _, effects in self._steps for effect in effects]
        return reloading.evaluate(
            self._request,
            self.interpreter,
            [one for one in known if one.process_id not in self._services],
            effects=effects,
            rules=options.start_rules,
            adapt=adapt,
            elapsed_s=elapsed_s,
        )

    def adopt(self, evaluation: Reevaluation) -> None:
        """From now on the launch file is the one that was evaluated; its plan begins here."""
        evaluation.adopt(self.interpreter)
        self.interpreter = evaluation.interpreter
        self._description = evaluation.description
        self._started = set(evaluation.started)
        self._steps = [(time.monotonic(), None, evaluation.plan_effects)]

    def stay_while(self, condition: Callable[[], bool]) -> None:
        """Do not end for want of processes while this is true."""
        self.interpreter.stay_while(condition)

    def is_steered(self, spec: ProcessSpec) -> bool:
        """Whether the launch file has asked its node for transitions, or to load components."""
        from launcher.launch import reloading

        return reloading.is_steered(spec, [one for _, _, some in self._steps for one in some])

    def launch_files(self) -> list[str]:
        """The launch file, what its evaluation has read, and the supervision files."""
        from launcher.launch import reloading

        settings = [] if self._source is None else map(os.path.abspath, self._source.paths)
        return [*reloading.launch_files(self._request, self.interpreter), *settings]

    def plan(self) -> Mapping[str, Any]:
        """The plan document of the run so far."""
        from launcher.launch.run_plan import run_document

        return run_document(self.interpreter, self._request.path, self._steps, self._adapt)

    def plan_lines(self) -> Sequence[str]:
        """The same as a tree, line by line."""
        from launcher.launch.run_plan import run_text

        return run_text(self.interpreter, self._request.path, self._steps, self._adapt)


def _ended_process(event: Event) -> int | None:
    """The process whose end this event reports."""
    return event.process_id if isinstance(event, (ProcessExited, SpawnFailed)) else None


@contextlib.contextmanager
def supervising(
    core: Core, options: RunOptions, launched: Launched
) -> Iterator[tuple[Supervisor, Reactor]]:
    """A supervisor that is ready to run; UsageError for options that a part cannot use."""
    from launcher.output.stdout import StdoutWriter, passes_colour, wants_colour
    from launcher.posix.reactor import Reactor
    from launcher.run.run import Run
    from launcher.run.supervisor import Supervisor

    environment = dict(os.environ)
    with Reactor() as reactor:
        plain = not passes_colour(1, environment)
        screen = StdoutWriter(reactor, colour=wants_colour(1, environment), plain=plain)
        if options.format != "default":
            screen.format = options.format
        run = Run(core, reactor, screen, options, launched, environment)
        yield Supervisor(run), reactor


def launched(request: LaunchRequest, **more: Any) -> Launched:
    """What a run of the request shows to its clients, with `more` of its fields."""
    from launcher.run.run import Launched

    words = tuple(f"{name}:={value}" for name, value in request.arguments)
    return Launched(target=str(request.path), arguments=words, **more)
