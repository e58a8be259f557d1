"""Executable: a command with its working directory and environment."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Mapping

from launcher.language.naming import public
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

    from launcher.language.context import LaunchContext


@public("launch.descriptions.executable")
class Executable:
    """A command; `prepare` sets the properties `final_...`."""

    def __init__(
        self,
        *,
        cmd: Iterable[Any],
        prefix: Any = None,
        name: Any = None,
        cwd: Any = None,
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

    @property
    def name(self) -> list[Substitution] | None:
        return self.__name

    @property
    def prefix(self) -> list[Substitution]:
        """Words in front of the command, as one text."""
        return self.__prefix

    @property
    def cmd(self) -> list[list[Substitution]]:
        """The words; may be extended until `prepare`."""
        return self.__cmd

    @property
    def cwd(self) -> list[Substitution] | None:
        return self.__cwd

    @property
    def env(self) -> Any:
        """(name, value) pairs of the whole environment, None for that of the context."""
        return self.__env

    @property
    def additional_env(self) -> Any:
        """(name, value) pairs that are added to the environment."""
        return self.__additional_env

    @property
    def arguments(self) -> Iterable[Any] | None:
        """The words given in addition to `cmd`."""
        return self.__arguments

    @property
    def final_name(self) -> str | None:
        """The label with the number of the process."""
        return self.__final_name

    @property
    def final_cmd(self) -> list[str] | None:
        return self.__final_cmd

    @property
    def final_cwd(self) -> str | None:
        return self.__final_cwd

    @property
    def final_env(self) -> dict[str, str] | None:
        return self.__final_env

    def _rename(self, name: str) -> None:
        """Set the final name: a process of an earlier evaluation keeps its number."""
        self.__final_name = name

    def prepare(self, context: LaunchContext, action: Any) -> None:
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
        env = _shared(context.environment) if self.__env is None else _perform(context, self.__env)
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


def _shared(environment: Mapping[str, str]) -> dict[str, str]:
    """A copy with strings that all copies share: `os.environ` makes new ones each time, 10 KB."""
    return {sys.intern(name): sys.intern(value) for name, value in environment.items()}


def _perform(context: LaunchContext, pairs: Any) -> dict[str, str]:
    return {
        perform_substitutions(context, name): perform_substitutions(context, value)
        for name, value in pairs
    }
