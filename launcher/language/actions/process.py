"""ExecuteLocal and ExecuteProcess, and the handlers of process events."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable, Mapping

from launcher.base.model import events as model
from launcher.base.model.spec import RosIdentity
from launcher.language import frontend_registry
from launcher.language.action import Action
from launcher.language.actions.output import output_policy
from launcher.language.events.handlers import OnActionEventBase, OnShutdown, TargetedHandler
from launcher.language.events.process import (
    ProcessExited,
    ProcessIO,
    ProcessStarted,
    ProcessStdin,
    ShutdownProcess,
    SignalProcess,
)
from launcher.language.executable import Executable, of_description
from launcher.language.future import Future
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.language.substitutions.configuration import LaunchConfiguration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.entity import LaunchDescriptionEntity
    from launcher.language.events.base import Event


_OVERRIDE = "OVERRIDE_LAUNCH_PROCESS_OUTPUT"
_SIGTERM_TIMEOUT = LaunchConfiguration("sigterm_timeout", default=5)
_SIGKILL_TIMEOUT = LaunchConfiguration("sigkill_timeout", default=5)


@public("launch.actions.execute_local")
class ExecuteLocal(Action):
    """Starts a process on this machine; timeouts and `respawn_delay` are in seconds.

    The process is started when the event that is being handled is done, so everything that is
    visited together is visited before its first process starts.
    """

    process_description: Executable = read_only()
    shell: bool = read_only("Whether a shell runs the command.")
    emulate_tty: bool = read_only("Whether the process gets a pseudo terminal.")
    sigkill_timeout: list[Substitution] = read_only("Seconds from SIGTERM to SIGKILL.")
    sigterm_timeout: list[Substitution] = read_only("Seconds from SIGINT to SIGTERM.")
    output: Any = read_only(
        "The destination of output: substitutions, or a dictionary as it was given."
    )
    output_format: str = read_only("How a line of output is shown.")
    cached_output: bool = read_only("Whether output is kept for `get_stdout` and `get_stderr`.")
    process_details: dict[str, Any] | None = read_only(
        "Name, command, folder, environment, and the pid once it runs; None before a visit.",
        of="__process_event_args",
    )
    return_code: int | None = read_only(
        "The last exit code; None before the first exit and after a restart."
    )
    _respawn_delay_given: object = read_only(of="__respawn_delay")

    def __init__(
        self,
        *,
        process_description: Executable,
        shell: bool = False,
        sigterm_timeout: object = _SIGTERM_TIMEOUT,
        sigkill_timeout: object = _SIGKILL_TIMEOUT,
        emulate_tty: bool = False,
        output: Any = "log",
        output_format: str = "[{this.process_description.final_name}] {line}",
        cached_output: bool = False,
        log_cmd: bool = False,
        on_exit: object = None,
        respawn: object = False,
        respawn_delay: float | None = None,
        respawn_max_retries: int = -1,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.__process_description = process_description
        self.__shell = shell
        self.__sigterm_timeout = normalize_to_list_of_substitutions(sigterm_timeout)
        self.__sigkill_timeout = normalize_to_list_of_substitutions(sigkill_timeout)
        self.__emulate_tty = emulate_tty
        output = os.environ.get(_OVERRIDE, output)
        self.__output = (
            output if isinstance(output, dict) else normalize_to_list_of_substitutions(output)
        )
        self.__output_format = output_format
        self.__log_cmd = log_cmd
        self.__cached_output = cached_output
        self.__on_exit = on_exit
        if not isinstance(respawn, bool):
            # Imported here: most launch files give a plain bool.
            from launcher.language.type_utils import normalize_typed_substitution

            respawn = normalize_typed_substitution(respawn, bool)
        self.__respawn: Any = respawn
        self.__respawn_delay = respawn_delay
        self.__respawn_max_retries = respawn_max_retries
        self.__process_event_args: dict[str, Any] | None = None
        self.__completed_future: Future | None = None
        streams = ("stdout", "stderr") if cached_output else ()
        self.__buffers = {stream: io.StringIO() for stream in streams}
        self.__executed = False
        self.__return_code: int | None = None
        # Here, although `execute` sets them: later attributes would not be in the shared keys of
        # the class, and each action would take 1.3 KB more.
        self._chooses_output = True
        self._output_given: Any = None
        self._output_policy: Any = None

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """The entities of `on_exit`, if it is a list."""
        return self.__on_exit if isinstance(self.__on_exit, list) else []

    def prepare(self, context: LaunchContext) -> None:
        """Perform the substitutions of the command, and fill `process_details`."""
        self.__process_description.prepare(context, self)
        self.__process_event_args = {
            "action": self,
            "name": self.__process_description.final_name,
            "cmd": self.__process_description.final_cmd,
            "cwd": self.__process_description.final_cwd,
            "env": self.__process_description.final_env,
        }
        if not isinstance(self.__respawn, bool):
            from launcher.language.type_utils import perform_typed_substitution

            self.__respawn = perform_typed_substitution(context, self.__respawn, bool)

    def execute(self, context: LaunchContext) -> Any:
        """Prepare, register the process's own handlers, request its start.

        RuntimeError if it was executed before.
        """
        self.prepare(context)
        if self.__executed:
            raise RuntimeError(
                f"ExecuteLocal action '{self.__process_description.final_name}': "
                f"executed more than once: {self.describe()}"
            )
        self.__executed = True
        if context.is_shutdown:
            return None
        handlers = self._own_handlers()
        for handler in handlers:
            context.register_event_handler(handler)
        try:
            self.__completed_future = Future()
            given = self.__output
            self._output_given = (
                given if isinstance(given, dict) else perform_substitutions(context, given)
            )
            self._output_policy = output_policy(self._output_given)
            context._host.spawn(self)
        except Exception:
            for handler in handlers:
                context.unregister_event_handler(handler)
            raise
        return None

    def _own_handlers(self) -> list[Any]:
        handlers: list[Any] = [
            TargetedHandler(ShutdownProcess, self._on_shutdown_process),
            TargetedHandler(SignalProcess, self._on_signal_process),
            TargetedHandler(ProcessStdin, self._on_stdin),
        ]
        if type(self)._shutdown_process is not ExecuteLocal._shutdown_process:
            handlers.append(OnShutdown(on_shutdown=self._on_shutdown))
        if self.__on_exit is not None:
            handlers.append(OnProcessExit(target_action=self, on_exit=self.__on_exit))
        if self.__cached_output:
            handlers.append(
                OnProcessIO(
                    target_action=self,
                    on_stdout=lambda event: self._cache(event, self.__buffers["stdout"]),
                    on_stderr=lambda event: self._cache(event, self.__buffers["stderr"]),
                )
            )
        return handlers

    @staticmethod
    def _cache(event: ProcessIO, buffer: io.StringIO) -> None:
        buffer.write(event.text.decode(errors="replace"))

    def _on_shutdown_process(self, event: Any, context: LaunchContext) -> Any:
        if not event.process_matcher(self):
            return None
        return self._shutdown_process(context, send_sigint=True)

    def _shutdown_process(self, context: LaunchContext, *, send_sigint: bool) -> Any:
        """Stop the process; overridden by subclasses that clean up, which call super()."""
        process_id = context._host.process_of(self)
        if process_id is not None and not context._host.shutdown_pending:
            context._host.request(model.StopProcess(process_id=process_id))

    def _on_shutdown(self, event: Any, context: LaunchContext) -> Any:
        send_sigint = not event.due_to_sigint or context.noninteractive
        return self._shutdown_process(context, send_sigint=send_sigint)

    def _on_signal_process(self, event: Any, context: LaunchContext) -> None:
        if not event.process_matcher(self):
            return
        process_id = context._host.process_of(self)
        if process_id is None:
            if self.__return_code is None:
                raise RuntimeError("Signal event received before subprocess transport available.")
            return
        name = self.__process_description.final_name
        text = f"sending signal '{event.signal_name}' to process[{name}]"
        context._host.log(str(name), "INFO", text)
        context._host.request(model.SignalProcess(process_id=process_id, signum=int(event.signal)))

    def _on_stdin(self, event: Any, context: LaunchContext) -> None:
        process_id = context._host.process_of(self)
        if event.action is self and process_id is not None:
            context._host.request(model.WriteStdin(process_id=process_id, data=event.text))

    # ---- for the interpreter

    def _spawn_emulates_tty(self, context: LaunchContext) -> bool:
        # Read at the start of the process, so a later SetLaunchConfiguration applies.
        if "emulate_tty" not in context.launch_configurations:
            return bool(self.__emulate_tty)
        from launcher.language.conditions import evaluate_condition_expression

        value = context.launch_configurations["emulate_tty"]
        return evaluate_condition_expression(context, normalize_to_list_of_substitutions(value))

    def _respawn_settings(self) -> tuple[Any, float | None, int]:
        delay_s = self.__respawn_delay
        is_number = isinstance(delay_s, (int, float))
        return self.__respawn, delay_s if is_number else None, self.__respawn_max_retries

    def _ros_identity(self) -> RosIdentity | None:
        return None

    def _rename(self, name: str) -> None:
        """The name of its process, which has run since an earlier evaluation of the launch file."""
        self.process_description._rename(name)
        if self.__process_event_args is not None:
            self.__process_event_args["name"] = name

    def _started(self, pid: int) -> dict[str, Any]:
        assert self.__process_event_args is not None
        self.__process_event_args["pid"] = pid
        self.__return_code = None
        return self.__process_event_args

    def _exited(self, returncode: int) -> None:
        self.__return_code = returncode

    def _completed(self) -> None:
        if self.__completed_future is not None:
            self.__completed_future.set_result(None)

    def get_asyncio_future(self) -> Any:
        """Done when the process has exited and will not be restarted."""
        return self.__completed_future

    def get_stdout(self) -> str:
        """The standard output so far; RuntimeError without `cached_output`."""
        return self._cached("stdout")

    def get_stderr(self) -> str:
        """The standard error so far; RuntimeError without `cached_output`."""
        return self._cached("stderr")

    def _cached(self, stream: str) -> str:
        if not self.__cached_output:
            raise RuntimeError(
                f"cached output must be true to be able to get {stream}, "
                f"proc '{self.__process_description.name}'"
            )
        return self.__buffers[stream].getvalue()


@public("launch.actions.execute_process")
class ExecuteProcess(ExecuteLocal):
    """Starts a process from the words of its command line."""

    name = of_description("name", "The label with its number once visited, else what was given.")
    cmd = of_description("cmd", "The final words once visited, else what was given.")
    cwd = of_description("cwd", "The final folder once visited, else what was given.")
    env = of_description("env", "The final environment once visited, else what was given.")

    def __init__(
        self,
        *,
        cmd: Iterable[Any],
        prefix: object = None,
        name: object = None,
        cwd: object = None,
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None,
        **kwargs: Any,
    ) -> None:
        if isinstance(cmd, str):
            # Imported only for a mistake.
            from launcher.language.diagnostics.text_uses import warn_of_letters

            warn_of_letters("cmd", cmd, self._origin)
        executable = Executable(
            cmd=cmd, prefix=prefix, name=name, cwd=cwd, env=env, additional_env=additional_env
        )
        super().__init__(process_description=executable, **kwargs)
        self._chooses_output = "output" in kwargs or _OVERRIDE in os.environ

    @classmethod
    def parse(cls, entity: object, parser: Any, ignore: list[str] | None = None) -> Any:
        """(class, keyword arguments) of an XML or YAML entity."""
        return frontend_registry.parse_with("ExecuteProcess", cls, entity, parser, ignore)

    @classmethod
    def _parse_cmdline(cls, cmd: str, parser: Any) -> Any:
        return frontend_registry.parse_with("ExecuteProcess.cmdline", cls, cmd, parser)

    @property
    def additional_env(self) -> Any:
        return self.process_description.additional_env


@public("launch.event_handlers.on_process_start")
class OnProcessStart(OnActionEventBase):
    """Reacts when a process was started."""

    def __init__(self, *, target_action: object = None, on_start: object, **kwargs: object) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_start,
            target_event_cls=ProcessStarted,
            target_action_cls=ExecuteLocal,
            **kwargs,
        )


@public("launch.event_handlers.on_process_exit")
class OnProcessExit(OnActionEventBase):
    """Reacts when a process exited, also by a signal."""

    def __init__(self, *, target_action: object = None, on_exit: object, **kwargs: object) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_exit,
            target_event_cls=ProcessExited,
            target_action_cls=ExecuteLocal,
            **kwargs,
        )


@public("launch.event_handlers.on_process_io")
class OnProcessIO(OnActionEventBase):
    """Reacts to bytes that a process wrote."""

    def __init__(
        self,
        *,
        target_action: object = None,
        on_stdin: Callable[[ProcessIO], Any] | None = None,
        on_stdout: Callable[[ProcessIO], Any] | None = None,
        on_stderr: Callable[[ProcessIO], Any] | None = None,
        **kwargs: object,
    ) -> None:
        self._callbacks = (on_stdin, on_stdout, on_stderr)

        def on_io(event: Event, context: LaunchContext) -> Any:
            assert isinstance(event, ProcessIO)
            if event.from_stdout:
                return on_stdout(event) if on_stdout is not None else None
            if event.from_stderr:
                return on_stderr(event) if on_stderr is not None else None
            return on_stdin(event) if on_stdin is not None else None

        super().__init__(
            action_matcher=target_action,
            on_event=on_io,
            target_event_cls=ProcessIO,
            target_action_cls=ExecuteLocal,
            **kwargs,
        )
