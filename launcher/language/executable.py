"""Executable: a command with its working directory and environment."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping

from launcher.language.launch_session import copy_environment
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    optional_substitutions,
    perform_substitutions,
)
from launcher.language.substitutions.configuration import LaunchConfiguration

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.action import Action
    from launcher.language.context import LaunchContext


@public("launch.descriptions.executable")
class Executable:
    """A command; `prepare` sets the properties `final_...`."""

    name: list[Substitution] | None = read_only()
    prefix: list[Substitution] = read_only("Words in front of the command, as one text.")
    cmd: list[list[Substitution]] = read_only("The words; may be extended until `prepare`.")
    cwd: list[Substitution] | None = read_only()
    env: object = read_only(
        "(name, value) pairs of the whole environment, None for that of the context."
    )
    additional_env: object = read_only("(name, value) pairs that are added to the environment.")
    arguments: Iterable[Any] | None = read_only("The words given in addition to `cmd`.")
    final_name: str | None = read_only("The label with the number of the process.")
    final_cmd: list[str] | None = read_only()
    final_cwd: str | None = read_only()
    final_env: dict[str, str] | None = read_only()

    def __init__(
        self,
        *,
        cmd: Iterable[Any],
        prefix: object = None,
        name: Any = None,
        cwd: object = None,
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None,
        arguments: Iterable[Any] | None = None,
    ) -> None:
        self.__cmd = [normalize_to_list_of_substitutions(word) for word in cmd]
        if arguments is not None:
            self.__cmd += [normalize_to_list_of_substitutions(word) for word in arguments]
        self.__prefix = normalize_to_list_of_substitutions(
            LaunchConfiguration("launch-prefix", default="") if prefix is None else prefix
        )
        # The filter applies to `launch-prefix` of the command line, not to `prefix`.
        self.__prefix_filter = (
            [LaunchConfiguration("launch-prefix-filter", default="")] if prefix is None else None
        )
        self.__name = optional_substitutions(name)
        self.__cwd = optional_substitutions(cwd)
        self.__env = _pairs(env)
        self.__additional_env = _pairs(additional_env)
        self.__arguments = arguments
        self.__final_cmd: list[str] | None = None
        self.__final_cwd: str | None = None
        self.__final_env: dict[str, str] | None = None
        self.__final_name: str | None = None
        self._label: str | None = None

    def _rename(self, name: str) -> None:
        """Set the final name: a process of an earlier evaluation keeps its number."""
        self.__final_name = name

    def prepare(self, context: LaunchContext, action: Action) -> None:
        """Perform all substitutions; `action` is for subclasses."""
        self.apply_context(context)

    def apply_context(self, context: LaunchContext) -> None:
        """Perform all substitutions."""
        cmd = [perform_substitutions(context, word) for word in self.__cmd]
        self.__final_cmd = [*self._prefix_words(context, cmd), *cmd]
        if self.__name is None and not self.__final_cmd:
            # Imported only for an error.
            from launcher.language.diagnostics.bad_entries import NoCommandError

            raise NoCommandError
        self._label = (
            os.path.basename(self.__final_cmd[0])
            if self.__name is None
            else perform_substitutions(context, self.__name)
        )
        self.__final_name = f"{self._label}-{context._host.next_process_number()}"
        self.__final_cwd = (
            None if self.__cwd is None else perform_substitutions(context, self.__cwd)
        )
        env = _copy_of(context) if self.__env is None else _perform(context, self.__env)
        env.update(_perform(context, self.__additional_env or []))
        self.__final_env = env

    def _prefix_words(self, context: LaunchContext, cmd: list[str]) -> list[str]:
        if self.__prefix_filter is not None:
            pattern = perform_substitutions(context, self.__prefix_filter)
            if pattern and re.match(pattern, os.path.basename("".join(cmd[:1]))) is None:
                return []
        prefix = perform_substitutions(context, self.__prefix)
        if not prefix:
            return []
        import shlex  # most commands have no prefix

        return shlex.split(prefix)


def _pairs(env: Mapping[Any, Any] | None) -> Any:
    if env is None:
        return None
    return [
        (normalize_to_list_of_substitutions(name), normalize_to_list_of_substitutions(value))
        for name, value in env.items()
    ]


def _copy_of(context: LaunchContext) -> dict[str, str]:
    environment = context.environment  # of a context of somebody's test, another mapping
    return copy_environment() if environment is os.environ else dict(environment)


def _perform(context: LaunchContext, pairs: Any) -> dict[str, str]:
    return {
        perform_substitutions(context, name): perform_substitutions(context, value)
        for name, value in pairs
    }


def of_description(name: str, doc: str) -> property:
    """A property of actions: of their command `final_NAME` once there is one, else `NAME`."""

    def get(action: Any) -> Any:
        final = getattr(action.process_description, f"final_{name}")
        return getattr(action.process_description, name) if final is None else final

    return property(get, doc=doc)
