"""A verb as other programs see it: a tool with a name, a description and arguments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from launcher.base.command_help import sentence
from launcher.base.model.record import Record, replace
from launcher.base.run_verb import BadCallError, Verb
from launcher.base.text import did_you_mean
from launcher.web.remote.argument import ToolArgument

RUN = "run"  # the argument that chooses a run


class Tool(Record):
    """`verb` is that of the control socket; None: `name` is run as the command of a shell.

    `flags` are the spellings of options of that command by the names of arguments; the other
    arguments are words. `limit_s` is how long a call takes at most. `changing` are the arguments
    without which the verb changes nothing: a tool that `is_read_only` refuses them.
    """

    name: str
    help: str
    arguments: tuple[ToolArgument, ...]
    is_read_only: bool
    limit_s: float
    verb: Verb | None = None
    flags: Mapping[str, str] = {}
    about: str = ""
    changing: tuple[str, ...] = ()

    @property
    def only_reading(self) -> Tool | None:
        """It, without what changes something; None if nothing is left."""
        if self.is_read_only:
            return self
        kept = tuple(one for one in self.arguments if one.name not in self.changing)
        return replace(self, arguments=kept, is_read_only=True) if self.changing else None

    @property
    def description(self) -> str:
        """What it does, for a program that chooses among tools."""
        return " ".join(filter(None, [sentence(self.help), self.about]))

    def schema(self) -> dict[str, Any]:
        """The JSON Schema of its arguments."""
        found: dict[str, Any] = {
            "type": "object",
            "properties": {one.name: one.schema() for one in self.arguments},
            "additionalProperties": False,
        }
        required = [one.name for one in self.arguments if one.is_required]
        return {**found, "required": required} if required else found

    def checked(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The arguments of a call, with defaults; null is as if absent. BadCallError."""
        self.refuse_unknown(given)
        found = {}
        for argument in self.arguments:
            name, value = argument.name, given.get(argument.name)
            if value is not None:
                found[name] = argument.check(value, self.name)
            elif argument.default is not None:
                found[name] = argument.default
            elif argument.is_required:
                raise BadCallError("bad-request", f"{self.name} needs '{name}': {argument.help}")
        return found

    def refuse_unknown(self, names: Iterable[str]) -> None:
        """BadCallError if one is not the name of an argument."""
        known = [one.name for one in self.arguments]
        for name in names:
            if name not in known and name in self.changing:
                problem = f"'{self.name}' with '{name}' changes something, and this only reads"
                raise BadCallError("read-only", problem)
            if name not in known:
                hint = did_you_mean(name, known) or f"known: {', '.join(known) or 'none'}"
                raise BadCallError("bad-option", f"{self.name} has no argument '{name}'", hint)

    def words(self, given: Mapping[str, Any]) -> list[str]:
        """The words behind the command of a shell, of checked arguments."""
        options, plain = [], []
        for name, value in given.items():
            flag = self.flags.get(name)
            values = value if isinstance(value, list) else [value]
            if flag is None:
                plain += [str(one) for one in values]
            elif isinstance(value, bool):
                options += [flag] if value else []
            else:
                options += [f"{flag}={one}" for one in values]
        return [*options, *(["--", *plain] if plain else [])]
