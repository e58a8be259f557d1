"""The grammar of command lines: tables of options, and the one parser that reads words by them.

`launcher.base.command_help` prints the same tables. argparse is not used: importing it takes longer
than importing all that is needed to start the first process.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from types import SimpleNamespace

from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.model.record import Record
from launcher.base.option import HELP, WORKSPACE, Option
from launcher.base.text import did_you_mean

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


def split_at_dashes(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """The words before and behind `--`, behind which are those of another program."""
    words = list(words)
    place = words.index("--") if "--" in words else len(words)
    return words[:place], words[place + 1 :]


class Command(Record):
    """A command with what it takes: arguments and options, or nested `commands`.

    `groups` are further options, each with a title; of each tuple of names in `exclusive`
    one may be given. `elsewhere` has options of other programs, with a hint each. `shorthand` maps
    an unknown option to the option and the value that it stands for. With `abbreviations`, as in
    argparse and so in ros2cli, `--js` is `--json`, `-tn5` is `-t -n 5`, and a negative number or a
    word with a space is no option. `run` is for the caller.
    """

    name: str
    help: str
    arguments: tuple[Option, ...] = ()
    options: tuple[Option, ...] = ()
    groups: tuple[tuple[str, tuple[Option, ...]], ...] = ()
    commands: tuple[Command, ...] = ()
    synopsis: str = ""
    about: str = ""
    epilog: str = ""
    exclusive: tuple[tuple[str, ...], ...] = ()
    elsewhere: tuple[tuple[tuple[str, ...], str], ...] = ()
    shorthand: Callable[[str], tuple[Option, Any] | None] | None = None
    abbreviations: bool = False
    in_shell: bool = True
    run: Callable[[Parsed], int] | None = None

    @property
    def all_options(self) -> tuple[Option, ...]:
        """Those of the groups, and those of every command, included."""
        general = (WORKSPACE, HELP) if self.in_shell else (HELP,)
        return (*self.options, *(one for _, group in self.groups for one in group), *general)

    @property
    def usage(self) -> str:
        """`topic list [options]`, after the name of the program."""
        from launcher.base.program import program

        words = [program()] if self.in_shell else []
        shapes = [*(one.spelling for one in self.arguments), "[options]"]
        more = self.synopsis or ("VERB ..." if self.commands else " ".join(shapes))
        return " ".join([*words, self.name, more]).rstrip()

    def parse(self, words: Sequence[str]) -> Parsed:
        """The values of the options; UsageError, HelpRequested."""
        parsed = self.read(words)
        if parsed.problem is not None:
            raise parsed.problem
        return parsed

    def read(self, words: Sequence[str]) -> Parsed:
        """As `parse`, but the first mistake is the `problem` of what is returned."""
        if not self.commands:
            return _WordReader(self, words).result()
        front, words = self.take_front(words)
        if words[:1] == ["--"]:
            words = words[1:]
        if not words or words[0] in HELP.flags:
            raise HelpRequested(self, ExitCode.OK if words else ExitCode.USAGE)
        for command in self.commands:
            if command.name == f"{self.name} {words[0]}":
                own = {flag for one in command.all_options for flag in one.flags}
                taken = [part for one in front if one[0].partition("=")[0] in own for part in one]
                return command.read([*taken, *words[1:]])
        if words[0].startswith("-"):
            hint = f"usage: {self.usage}"
            raise UsageError(f"unknown option '{words[0]}' in front of the verb", hint=hint)
        from launcher.base.synonyms import meant_below  # only mistakes need it

        names = [command.name.rpartition(" ")[2] for command in self.commands]
        hint = meant_below(words[0], names) or f"known: {', '.join(names)}"
        raise UsageError(f"unknown verb '{self.name} {words[0]}'", hint=hint)

    def take_front(self, words: Sequence[str]) -> tuple[list[list[str]], list[str]]:
        """The options in front of the verb, each with its value, and the other words; UsageError.

        Our own options and those that all our commands have may stand there.
        """
        if not words or not words[0].startswith("-"):
            return [], list(words)
        from launcher.base.command_front import take_front  # not on the way to a first process

        each = [{flag: one for one in c.all_options for flag in one.flags} for c in self.commands]
        metavars = {flag: one.metavar for one in self.options for flag in one.flags}
        for flag, option in each[0].items():
            if option is not HELP and all(flag in one for one in each):
                metavars[flag] = option.metavar
        return take_front(words, metavars)


class Parsed(SimpleNamespace):
    """The value of each option by its name.

    `command` is the parsed one; `given` has its words in order, each with the option that it
    belongs to (None: an argument) and its value.
    """

    command: Command
    given: list[tuple[Option | None, list[str], Any]]
    problem: LauncherError | None


class UnknownOptionError(UsageError):
    """No option of the command is spelled like this word."""

    def __init__(self, word: str, hint: str) -> None:
        super().__init__(f"unknown option '{word}'", hint=hint)
        self.word = word


class HelpRequested(Exception):
    """Raised by --help, or by a command without its verb: print the help of `command`."""

    def __init__(self, command: Command, exit_code: ExitCode = ExitCode.OK) -> None:
        super().__init__(command.name)
        self.command = command
        self.exit_code = exit_code


class _WordReader:
    def __init__(self, command: Command, words: Iterable[str]) -> None:
        self._command = command
        self._spellings = {flag: one for one in command.all_options for flag in one.flags}
        self._queue = deque(words)
        self._plain: list[str] = []
        self._values: dict[str, Any] = {}
        self._given: list[tuple[Option | None, list[str], Any]] = []
        self._problem: LauncherError | None = None

    def result(self) -> Parsed:
        while self._queue:
            word = self._queue.popleft()
            try:
                self._take(word)
            except LauncherError as error:
                self._problem = self._problem or error
        try:
            self._fill_arguments()
            self._check_exclusive()
        except LauncherError as error:
            self._problem = self._problem or error
        known = (*self._command.all_options, *self._command.arguments)
        defaults = {one.name: one.default for one in known}
        return Parsed(
            **{**defaults, **self._values},
            command=self._command,
            given=self._given,
            problem=self._problem,
        )

    # ---- words

    def _take(self, word: str) -> None:
        rest = self._rest_argument()
        if word == "--":
            self._given.append((None, [word], None))
            self._add_plain(*self._queue)
            self._queue.clear()
        elif rest == "...":
            self._add_plain(word, *self._queue)
            self._queue.clear()
        elif rest == "text" and not (word.startswith("--") or word in HELP.flags):
            self._add_plain(word)
        elif self._is_option(word):
            self._take_option(word)
        else:
            self._add_plain(word)

    def _add_plain(self, *words: str) -> None:
        self._plain += words
        self._given += [(None, [word], word) for word in words]

    def _rest_argument(self) -> str | None:
        """`...` or `text` if the next plain word belongs to an argument of that count."""
        arguments = self._command.arguments
        if arguments and len(self._plain) >= len(arguments) - 1:
            return arguments[-1].count if arguments[-1].count in ("...", "text") else None
        return None

    def _is_option(self, word: str) -> bool:
        if not word.startswith("-") or len(word) == 1:
            return False
        if not self._command.abbreviations or self._found(word.partition("=")[0]) is not None:
            return True
        if _is_negative(word) and not any(map(_is_negative, self._spellings)):
            return False
        return " " not in word

    def _found(self, flag: str) -> Option | None:
        if flag in self._spellings or not self._command.abbreviations or flag[:2] != "--":
            return self._spellings.get(flag)
        meant = {
            one.name: one
            for name, one in self._spellings.items()
            if name.startswith(flag) and one is not WORKSPACE
        }
        return next(iter(meant.values())) if len(meant) == 1 else None

    def _take_option(self, word: str) -> None:
        flag, has_value, value = word.partition("=")
        option = self._found(flag)
        if option is HELP:
            raise HelpRequested(self._command)
        if option is None:
            self._take_unknown(word)
        elif option.count == "=":
            self._set(option, [word], self._read(option, flag, value))
        elif option.is_flag:
            if has_value:
                raise UsageError(f"{flag} takes no value", hint=self._usage())
            self._set(option, [word], option.value() if callable(option.value) else option.value)
        elif option.count == "?":
            self._take_optional(option, flag, value if has_value else None)
        elif option.count == "+":
            words = [value] if has_value else self._values_after(flag, option)
            values = [self._read(option, flag, one) for one in words]
            self._set(option, [word, *([] if has_value else words)], values)
        else:
            more = [] if has_value else [self._value_after(flag, option)]
            self._set(option, [word, *more], self._read(option, flag, more[0] if more else value))

    def _take_optional(self, option: Option, flag: str, value: str | None) -> None:
        if value is not None:
            self._set(option, [flag], self._read(option, flag, value))
            return
        words, known = [flag], option.value
        if self._queue and not self._is_option(self._queue[0]):
            try:
                known = self._read(option, flag, self._queue[0])
            except UsageError:
                if _is_negative(f"-{self._queue[0].removeprefix('-')}"):  # a wrong number
                    raise
            else:  # otherwise it is the next argument
                words.append(self._queue.popleft())
        self._set(option, words, known)

    def _take_unknown(self, word: str) -> None:
        command = self._command
        if command.shorthand is not None and (meant := command.shorthand(word)) is not None:
            self._set(meant[0], [word], meant[1])
            return
        first = self._spellings.get(word[:2])
        if command.abbreviations and first is not None and len(word) > 2:
            if first.metavar:
                self._set(first, [word], self._read(first, word[:2], word[2:]))
            else:
                self._queue.extendleft([f"-{word[2:]}", word[:2]])
            return
        from launcher.base.synonyms import meant_option  # only mistakes need it

        flag = word.partition("=")[0]
        hint = meant_option(flag, self._spellings, command.elsewhere) or self._usage()
        if first is not None and first.metavar and len(word) > 2 and not command.abbreviations:
            hint = f"write {word[:2]} {word[2:]}; {hint}"
        if not word.startswith("--") and len(word) > 2 and command.arguments:
            hint += "; an argument that begins with '-' goes behind --"
        raise UnknownOptionError(word, hint)

    def _value_after(self, flag: str, option: Option) -> str:
        if not self._queue or self._queue[0] == "--" or self._is_known(self._queue[0]):
            raise UsageError(f"{flag} needs a value: {option.metavar}", hint=self._usage())
        return self._queue.popleft()

    def _values_after(self, flag: str, option: Option) -> list[str]:
        values = [self._value_after(flag, option)]
        while self._queue and self._queue[0] != "--" and not self._is_option(self._queue[0]):
            values.append(self._queue.popleft())
        return values

    def _is_known(self, word: str) -> bool:
        return word.partition("=")[0] in self._spellings

    # ---- values

    def _read(self, option: Option, flag: str, word: str) -> Any:
        if option.choices and word not in option.choices:
            raise UsageError(
                f"{flag}: '{word}' is not one of {', '.join(option.choices)}",
                hint=did_you_mean(word, option.choices),
            )
        try:
            return option.read(word)
        except ValueError as error:
            example = f"{flag} {option.metavar}" if "=" in option.metavar else None
            hint = getattr(error, "hint", None) or example
            raise UsageError(f"{flag}: {error}", hint=hint) from None

    def _set(self, option: Option, words: list[str], value: object) -> None:
        self._given.append((option, words, value))
        if option.repeat == "all":
            self._values[option.name] = (*self._values.get(option.name, ()), value)
        elif option.repeat == "once" and option.name in self._values:
            raise UsageError(f"{option.flags[0]} is given twice", hint=self._usage())
        else:
            self._values[option.name] = value

    def _check_exclusive(self) -> None:
        for names in self._command.exclusive:
            flags = [one.flags[-1] for one, *_ in self._given if one and one.name in names]
            flags += [
                one.metavar
                for one in self._command.arguments
                if one.name in names and one.name in self._values
            ]
            others = [flag for flag in flags if flag != flags[0]]
            if others:
                raise UsageError(f"{flags[0]} and {others[0]} exclude each other")

    def _fill_arguments(self) -> None:
        arguments, words = self._command.arguments, deque(self._plain)
        for place, argument in enumerate(arguments):
            most = 1 if argument.count in "1?" else len(words)
            wanted = sum(_least(later) for later in arguments[place + 1 :])
            # What comes later takes nothing from an argument that is needed itself.
            size = max(_least(argument), min(most, len(words) - wanted))
            taken = [words.popleft() for _ in range(min(size, len(words)))]
            names = argument.metavar.split()
            if len(taken) < _least(argument) or len(taken) % len(names):
                after = f" after '{taken[-1]}'" if taken else ""
                self._refuse(f"{names[len(taken) % len(names)]} is missing{after}")
            values = [self._read(argument, argument.metavar, word) for word in taken]
            if argument.count not in "1?":
                self._values[argument.name] = values
            elif values:
                self._values[argument.name] = values[0]
        if words:
            self._refuse(f"unexpected argument '{words[0]}'")

    def _refuse(self, message: str) -> NoReturn:
        raise UsageError(message, hint=self._usage())

    def _usage(self) -> str:
        return f"usage: {self._command.usage}"


def _is_negative(word: str) -> bool:
    """Whether it is a number below 0, for Python or YAML: `-5`, `-.5`, `-1e3`, `-.inf`."""
    text = word[1:]
    if word[:1] != "-" or text[:1] not in tuple("0123456789."):
        return False
    try:
        float(text.lower().removeprefix(".") if text.lower() == ".inf" else text)
    except ValueError:
        return False
    return True


def _least(argument: Option) -> int:
    return len(argument.metavar.split()) if argument.count in "1+" else 0
