"""A verb about a running launch: its usage, its options, and a request to carry it out."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.base.command_line import Command
from launcher.base.model.record import Record
from launcher.base.option import Option, option

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_NAME, _NAMES = "[NAME]", "[NAME ...]"
FOR_ALL = "'*' stands for all processes"
TEXT = option("TEXT", "a line for its standard input")


class Verb(Record):
    """A verb, whose arguments are read from its usage.

    `behind`: options that the words behind the name set, the last one by the last word; `rest`:
    the option that all of them set, with blanks between. `streams`: with the option `follow` it
    sends items until the run ends. `shell`: it is also a command of the shell. `shorthand` reads
    words such as -9. `serve` answers requests: `module:function`, or empty if the service of the
    control socket does. `changing` names the options with which a verb that otherwise
    only reads changes something.
    """

    usage: str
    help: str
    options: tuple[Option, ...] = ()
    behind: tuple[Option, ...] = ()
    rest: Option | None = None
    streams: bool = False
    shell: bool = True
    shorthand: Callable[[str], tuple[Option, str] | None] | None = None
    serve: str = ""
    changing: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The first word of the usage."""
        return self.usage.partition(" ")[0]

    @property
    def names(self) -> str:
        """How many processes: none, one, perhaps (at most one), some, or any (none: all)."""
        if "[NAME ...]" in self.usage:
            return "any"
        if "NAME ..." in self.usage:
            return "some"
        if _NAME in self.usage:
            return "perhaps"
        return "one" if " NAME" in self.usage else "none"

    @property
    def argument(self) -> str | None:
        """The option that an optional first word sets."""
        return next((one.name for one in self.options if not one.flags), None)

    @property
    def text(self) -> str | None:
        """The option that all words after the name set."""
        return None if self.rest is None else self.rest.name

    def option(self, name: str) -> Option | None:
        """The option with this name in requests."""
        known = (*self.options, *self.behind, *((self.rest,) if self.rest else ()))
        return next((option for option in known if option.name == name), None)

    def command(
        self,
        *,
        in_shell: bool = False,
        about: str = "",
        common: tuple[Option, ...] = (),
        as_json: Option | None = None,
    ) -> Command:
        """Its command line: in the console, or in a shell with `as_json` and `common` options."""
        arguments = [option(f"[{self.argument.upper()}]")] if self.argument else []
        if self.names != "none":
            arguments.append(option(_NAME if self.text or self.behind else _NAMES, name="names"))
        arguments += self.behind
        if self.rest:
            arguments.append(self._words(self.rest, are_mixed=in_shell or bool(self.options)))
        usage = f"{self.usage} [--run ID] [--json]" if in_shell else self.usage
        return Command(
            self.name,
            self.help,
            arguments=tuple(arguments),
            options=(
                *(option for option in self.options if option.flags),
                *((as_json,) if as_json else ()),
            ),
            groups=(("options of all verbs about a run", common),) if common else (),
            synopsis=usage.removeprefix(self.name).strip(),
            about=about,
            elsewhere=((("--all", "-a"), FOR_ALL),) if self.names == "some" else (),
            shorthand=self.shorthand,
            in_shell=in_shell,
        )

    @staticmethod
    def _words(rest: Option, *, are_mixed: bool) -> Option:
        """The argument that takes all words; options may stand between them if they are mixed."""
        if not are_mixed:
            return option(rest.metavar, count="...")
        help = f"{rest.help}; put -- before words that begin with --"
        return option(rest.spelling, help, name=rest.name, count="text")


class Call(Record):
    """A verb with its names and options: the body of a request."""

    verb: Verb
    names: tuple[str, ...]
    options: Mapping[str, Any]


class BadCallError(Exception):
    """A request that cannot be carried out; `code` is one of the protocol's."""

    def __init__(self, code: str, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.hint = hint

    @property
    def document(self) -> dict[str, str | None]:
        """The `error` of an answer in JSON."""
        return {"code": self.code, "message": self.message, "hint": self.hint}
