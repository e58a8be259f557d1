"""`launch TARGET [name:=value ...]`: run a launch file until its processes have ended."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence

from launcher.command_line import Command, option
from launcher.commands import VERBS
from launcher.commands.launch.options import RUN_OPTIONS, run_options
from launcher.commands.launch.target import (
    ABOUT_TARGET,
    READING_OPTIONS,
    SYNOPSIS,
    TARGET,
    LaunchRequest,
)
from launcher.commands.launch.time_limit import limited
from launcher.errors import OF_SMOKE, ExitCode, LaunchFileError, UsageError, exit_code_table
from launcher.model.options import RunOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.commands.launch.helpers import Helpers
    from launcher.commands.launch.run_plan import RunStep
    from launcher.interpreter import Interpreter
    from launcher.language.description import LaunchDescription
    from launcher.language.session import Session
    from launcher.model.events import Effect, Event

# What serves the control socket takes 15 ms to import; the first processes start meanwhile.
HELPERS_DELAY_S = 0.05
MAX_RECORDED_STEPS = 2000  # bounds the memory for the plan of a run

COMMAND = Command(
    "launch",
    VERBS["launch"],
    arguments=(TARGET,),
    synopsis=SYNOPSIS,
    about=f"""\
{ABOUT_TARGET} The word `launch` may be left out.

Ctrl-C stops all processes in order: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL; press it
again to skip a wait.""",
    options=(
        option(
            "-s, --show-args, --show-arguments",
            "list the arguments of the launch file, as `args` does",
            name="show_args",
        ),
        option(
            "-p, --print, --print-description",
            "show what would be started, as `plan` does",
            name="print_plan",
        ),
        option(
            "-a, --show-all-subprocesses-output",
            "send the output of every process to the screen and to the log",
            name="show_all",
        ),
        *READING_OPTIONS,
    ),
    groups=(("options about the run", RUN_OPTIONS),),
    epilog="\n".join(exit_code_table(code for code in ExitCode if code not in OF_SMOKE)),
)


def main(words: Sequence[str]) -> int:
    """Run the launch file that `words` name; the exit code."""
    parsed = COMMAND.parse(words)
    options = run_options(parsed)
    request = LaunchRequest.of(parsed)
    if parsed.show_args:
        from launcher.commands import args

        return args.show(request)
    if parsed.show_all:
        # Launch files hand the environment on to other launchers, as with ROS 2.
        os.environ["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "both"
    if parsed.print_plan:
        from launcher.commands import plan

        return plan.show(request)
    return launch(request, options)


def launch(request: LaunchRequest, options: RunOptions) -> int:
    """Evaluate the launch file, then run what it describes."""
    from launcher import frontends
    from launcher.engine.logs.run_directory import new_run_path
    from launcher.interpreter import Interpreter
    from launcher.language.compat import vocabulary

    run_path = new_run_path(os.environ) if options.log_files else None
    words = [request.path, *(f"{name}:={value}" for name, value in request.arguments)]
    with vocabulary(words) as session:
        # Launch files ask where the logs of their run are.
        session.log_dir = run_path
        _read_log_formats()
        with limited(request.time_limit, request.path):
            description = frontends.load(request.path)
            if not request.lenient and not _is_declared(request, description):
                from launcher.commands.launch import checks

                checks.refuse_unknown_arguments(request)
                description = frontends.load(request.path)  # the plan has used the first one up
        interpreter = Interpreter(
            description,
            path=request.path,
            arguments=request.arguments,
            noninteractive=request.noninteractive or sys.stdin is None or not sys.stdin.isatty(),
        )
        try:
            core = LaunchCore(interpreter, description, request)
            core.evaluate()
            _check(core, interpreter, options)
            code = _supervise(core, options, run_path, request, session)
        finally:
            interpreter.close()
    if interpreter.failure is not None:
        print(interpreter.failure.render(), file=sys.stderr)
        return ExitCode.PROCESS_FAILED
    return code


def _read_log_formats() -> None:
    """Apply ROS 2's variables for the formats of the launcher's own lines; UsageError."""
    if not any(os.environ.get(f"OVERRIDE_LAUNCH_{what}_FORMAT") for what in ("SCREEN", "LOG")):
        return
    try:
        from launcher.language import log

        log.reset()
    except ValueError as error:
        raise UsageError(str(error), hint="for example: '[{levelname}] [{name}]: {msg}'") from None


def _is_declared(request: LaunchRequest, description: LaunchDescription) -> bool:
    """Whether the launch file declares all given arguments, so that no dry run is needed."""
    names = {name for name, _ in request.arguments}
    if not names:
        return True
    try:
        declared = description.get_launch_arguments()
    except Exception:
        return True  # the run reports the error, with its place
    return names <= {argument.name for argument in declared}


def _check(core: LaunchCore, interpreter: Interpreter, options: RunOptions) -> None:
    """UsageError for a domain or a required process with which the run cannot work."""
    domain = interpreter.environment.get("ROS_DOMAIN_ID", "")
    is_usual = not domain or (domain.isdecimal() and len(domain) < 3)
    if is_usual and not options.required:
        return  # nearly always, so that nothing is imported for it
    from launcher.commands.launch import checks

    checks.refuse_domain(domain, core.effects)
    if not interpreter.may_start_more:
        checks.refuse_missing(options.required, core.effects)


class LaunchCore:
    """An interpreter whose start is limited in time, and which records what the run did."""

    def __init__(
        self, interpreter: Interpreter, description: LaunchDescription, request: LaunchRequest
    ) -> None:
        self._interpreter = interpreter
        self._description = description
        self._request = request
        self.effects: Sequence[Effect] = ()  # of the static part
        self._steps: list[RunStep] = []

    def evaluate(self) -> None:
        """Visit the static part, before any file or process is created; LauncherError."""
        try:
            with limited(self._request.time_limit, self._request.path):
                self.effects = self._interpreter.start()
        except LaunchFileError as fault:
            from launcher.commands.launch import mistakes

            errors = mistakes.of_launch_file(
                fault,
                self._description,
                self._interpreter.context,
                self._request.arguments,
                os.environ,
            )
            raise mistakes.together(errors) from fault

    def start(self) -> Sequence[Effect]:
        """Begin the run: the effects of the static part, which are recorded."""
        self._steps.append((time.monotonic(), None, self.effects))
        return self.effects

    def handle(self, event: Event) -> Sequence[Effect]:
        effects = self._interpreter.handle(event)
        if effects and len(self._steps) < MAX_RECORDED_STEPS:
            self._steps.append((time.monotonic(), _ended_process(event), effects))
        return effects

    def watches_output(self, process_id: int) -> bool:
        """Whether the launch file wants the output of this process."""
        return self._interpreter.watches_output(process_id)

    def plan(self) -> Mapping[str, Any]:
        """The plan document of the run so far."""
        from launcher.commands.launch.run_plan import run_document

        return run_document(self._interpreter, self._request.path, self._steps)

    def plan_lines(self) -> Sequence[str]:
        """The same as a tree, line by line."""
        from launcher.commands.launch.run_plan import run_text

        return run_text(self._interpreter, self._request.path, self._steps)


def _ended_process(event: Event) -> int | None:
    """The process whose end this event reports."""
    from launcher.model.events import ProcessExited, SpawnFailed

    return event.process_id if isinstance(event, (ProcessExited, SpawnFailed)) else None


def _supervise(
    core: LaunchCore,
    options: RunOptions,
    run_path: str | None,
    request: LaunchRequest,
    session: Session,
) -> ExitCode:
    from launcher.engine.output.stdout import StdoutWriter, passes_colour, wants_colour
    from launcher.engine.posix.reactor import Reactor
    from launcher.engine.supervisor import Supervisor

    environment = dict(os.environ)
    run_id = f"{os.getpid()}-{os.urandom(6).hex()}"
    with Reactor() as reactor:
        plain = not passes_colour(1, environment)
        screen = StdoutWriter(reactor, colour=wants_colour(1, environment), plain=plain)
        supervisor = Supervisor(
            core,
            env=environment,
            reactor=reactor,
            screen=screen,
            run_id=run_id,
            run_path=run_path,
            options=options,
            wishes=session,
        )
        if not options.control:
            return supervisor.run()
        started = time.time()
        opened: list[Helpers] = []

        def open_helpers() -> None:
            from launcher.commands.launch.helpers import Helpers

            helpers = Helpers(
                supervisor,
                reactor=reactor,
                screen=screen,
                options=options,
                environment=environment,
            )
            opened.append(helpers)
            helpers.open(request, run_id=run_id, started=started)

        supervisor.on_begun = lambda: reactor.call_later(HELPERS_DELAY_S, open_helpers)
        try:
            return supervisor.run()
        finally:
            for helpers in opened:
                helpers.close()
