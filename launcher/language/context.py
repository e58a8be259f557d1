"""LaunchContext: the state that entities read and change while they are visited."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Mapping, MutableMapping

from launcher.language import launch_session
from launcher.language.configurations import Configurations
from launcher.language.events.base import EventHandlers
from launcher.language.launch_session import copy_environment, replace_environment
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.events.base import BaseEventHandler, Event
    from launcher.language.host import EntityHost
    from launcher.language.substitution import Substitution


class _Locals:
    """Read-only attribute access to the context's locals."""

    def __init__(self, values: dict[str, Any]) -> None:
        self.__dict__["_values"] = values

    def __getattr__(self, key: str) -> Any:
        values = self.__dict__["_values"]
        if key not in values:
            known = ", ".join(values)
            raise AttributeError(
                f"context.locals does not contain attribute '{key}', it contains: [{known}]"
            )
        return values[key]

    def __setattr__(self, key: str, value: object) -> None:
        raise AttributeError(f"can't set attribute '{key}', locals are read-only")


@public("launch.launch_context")
class LaunchContext:
    """Launch configurations, environment, locals, event handlers and the event queue.

    `environment` is `os.environ` itself, as in ROS 2: launch files and the programs that
    `Command` runs see what was set. The owner of the context restores it afterwards.
    """

    noninteractive: bool = read_only("Whether no terminal is attached.")
    is_shutdown: bool = read_only("Whether the run is being stopped.")
    launch_configurations: Configurations = read_only(
        "The configurations of the current scope, to read and to write."
    )

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = False) -> None:
        self.__argv = argv if argv is not None else []
        self.__noninteractive = noninteractive
        self._event_queue: deque[Event] = deque()
        self._event_handlers = EventHandlers()
        self._completion_futures: list[Any] = []
        self._callers_loop: Any = None  # the asyncio loop in which `run_async` runs
        self._is_of_test = False
        # The launch files of the run so far, and where each was included last.
        self._includers: dict[str, FileLine | None] = {}
        self.__host: EntityHost | None = None
        self.__globals: dict[str, Any] = {}
        self.__locals: dict[str, Any] = {}
        self.__locals_stack: list[dict[str, Any]] = []
        self.__launch_configurations = Configurations(
            self._configuration_read, self._configuration_written
        )
        self.__launch_configurations_stack: list[Configurations | None] = []  # None: the same
        self.__environment_stack: list[Mapping[str, str]] = []
        self.__environment_reset: Mapping[str, str] = dict(os.environ)
        self.__is_shutdown = False

    @property
    def _host(self) -> EntityHost:
        """The host of this run; a NullHost if none was set."""
        if self.__host is None:
            from launcher.language.host import NullHost

            self.__host = NullHost()
        return self.__host

    @_host.setter
    def _host(self, host: EntityHost) -> None:
        self.__host = host

    @property
    def argv(self) -> Any:
        """The words `name:=value` of the command line."""
        launch_session.current().note_arguments_read()
        return self.__argv

    def _set_is_shutdown(self, state: bool) -> None:
        self.__is_shutdown = state

    @property
    def asyncio_loop(self) -> Any:
        """The loop of the caller of `run_async`; else one for coroutines of the launch file."""
        return self._callers_loop or self._host.asyncio_loop()

    def add_completion_future(self, completion_future: object) -> None:
        """Keep the run going until this future is done."""
        self._completion_futures.append(completion_future)

    # ---- locals

    def _push_locals(self) -> None:
        self.__locals_stack.append(dict(self.__locals))

    def _pop_locals(self) -> None:
        if not self.__locals_stack:
            raise RuntimeError("locals stack unexpectedly empty")
        self.__locals = self.__locals_stack.pop()

    def extend_globals(self, extensions: dict[str, Any]) -> None:
        """Add locals that stay for the whole run; those of `extend_locals` hide them."""
        self.__globals.update(extensions)

    def extend_locals(self, extensions: dict[str, Any]) -> None:
        """Add locals until the end of the event that is being handled."""
        self.__locals.update(extensions)

    def get_locals_as_dict(self) -> dict[str, Any]:
        """All locals, those of `extend_globals` included."""
        return {**self.__globals, **self.__locals}

    @property
    def locals(self) -> Any:
        return _Locals(self.get_locals_as_dict())

    # ---- launch configurations

    def _push_launch_configurations(self, replaced_by: Configurations | None = None) -> None:
        """Begin a scope, with the configurations of now or a copy of these."""
        if replaced_by is None:
            self.__launch_configurations_stack.append(None)
            self.__launch_configurations.begin_scope()
        else:
            self.__launch_configurations_stack.append(self.__launch_configurations)
            self.__launch_configurations = replaced_by.snapshot()

    def _pop_launch_configurations(self) -> None:
        if not self.__launch_configurations_stack:
            raise RuntimeError("launch_configurations stack unexpectedly empty")
        outer = self.__launch_configurations_stack.pop()
        if outer is None:
            self.__launch_configurations = self.__launch_configurations.end_scope()
        else:
            self.__launch_configurations = outer

    def _lost_later(self) -> list[str]:
        """Names set in the scopes around the current visit, which a later visit does not see."""
        lost: list[str] = []
        if self.__launch_configurations_stack:
            replaced = [one for one in self.__launch_configurations_stack if one is not None]
            outermost = [*replaced, self.__launch_configurations][0]
            lost += self.__launch_configurations.differing(outermost)
        if self.__environment_stack:
            outside = self.__environment_stack[0]
            lost += [f"${name}" for name in os.environ if outside.get(name) != os.environ[name]]
        return lost

    def _outer_configuration(self, name: str) -> Any:
        """The value outside of the innermost scope, None without one."""
        replaced = self.__launch_configurations_stack[-1:]
        if replaced and replaced[0] is not None:
            return replaced[0].peek(name)
        return self.__launch_configurations.outer(name)

    def _configuration_read(self, name: str) -> None:
        self._host.configuration_read(name)

    def _configuration_written(self, name: str, value: object, origin: FileLine | None) -> None:
        self._host.configuration_written(name, value, origin)

    # ---- environment

    @property
    def environment(self) -> MutableMapping[str, str]:
        """The environment of the current scope, to read and to write: `os.environ`."""
        return os.environ

    def _push_environment(self) -> None:
        self.__environment_stack.append(copy_environment())

    def _pop_environment(self) -> None:
        if not self.__environment_stack:
            raise RuntimeError("environment stack unexpectedly empty")
        replace_environment(self.__environment_stack.pop())

    def _remember_environment(self, environment: Mapping[str, str]) -> None:
        """Set the environment that ResetEnvironment restores."""
        self.__environment_reset = dict(environment)

    def _reset_environment(self) -> None:
        replace_environment(self.__environment_reset)

    # ---- events

    def would_handle_event(self, event: Event) -> bool:
        """Whether any registered handler matches."""
        return any(handler.matches(event) for handler in self._event_handlers.of(event))

    def register_event_handler(self, event_handler: BaseEventHandler, append: bool = False) -> None:
        """Add a handler before those registered earlier, or with `append` after them."""
        self._event_handlers.add(event_handler, is_last=append)

    def unregister_event_handler(self, event_handler: BaseEventHandler) -> None:
        """Remove a handler; ValueError if it is not registered."""
        self._event_handlers.remove(event_handler)

    def emit_event_sync(self, event: Event) -> None:
        if self._host.accepts(event):
            self._event_queue.append(event)

    async def emit_event(self, event: Event) -> None:
        """Queue an event, from a coroutine."""
        self.emit_event_sync(event)

    def perform_substitution(self, substitution: Substitution) -> str:
        """The text of a substitution in this context."""
        return substitution.perform(self)
