"""The commands of a CMakeLists.txt, read without running CMake.

Only what is certain is reported: commands in `if` blocks, functions and macros, and those after a
`return` in an `if`, are kept apart, and variables that they may set are unknown.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from launcher.workspace.building.sources.source_text import PackageText, SourceError

_TOKEN = re.compile(
    r"""
      (?P<comment> \#\[(?P<c>=*)\[ (?:.|\n)*? \](?P=c)\] | \#[^\n]* )
    | (?P<bracket> \[(?P<b>=*)\[ (?:.|\n)*? \](?P=b)\] )
    | (?P<quoted> "(?:[^"\\]|\\(?:.|\n))*" )
    | (?P<open> \( )
    | (?P<close> \) )
    | (?P<space> [\s;]+ )
    | (?P<word> (?:[^\s()#"\\;]|\\.)+ )
    """,
    re.VERBOSE,
)
_VARIABLE = re.compile(r"\$\{([\w.+/-]+)\}")
_UNKNOWN = re.compile(r"\$(<|\w*\{)")  # generator expressions, `$ENV{X}`, nested variables
# These make no file, define no command of a package, and set no variable of ours.
_PLAIN = re.compile(
    r"add_(compile_(definitions|options)|definitions|dependencies|executable|library"
    r"|link_options|test)|ament_(?!auto_)\w+|block|break|cmake_(minimum_required|parse_arguments"
    r"|path|policy)|continue|else(if)?|enable_(language|testing)|end\w+|find_\w+|foreach|function"
    r"|get_\w+|if|include_directories|install|link_(directories|libraries)|list|macro|math"
    r"|mark_as_advanced|message|option|project|return|rosidl_\w+|separate_arguments"
    r"|set(_\w*propert(y|ies))?|source_group|string|target_\w+|unset|variable_watch|while"
)
_MAKES_FILES = ("COPY", "COPY_FILE", "DOWNLOAD", "GENERATE", "RENAME", "WRITE")
# These may make files, but have their own rules, or make them only when the package is compiled.
_OF_CMAKE = ("add_custom_command", "add_custom_target", "configure_file", "execute_process", "file")
# They set no variable whose name they are given.
_WITHOUT_RESULT = (
    "project", "find_package", "rosidl_generate_interfaces", "install", "message",
    "ament_export_dependencies", "ament_package", "cmake_minimum_required",
    "if", "elseif", "else", "endif", "foreach", "endforeach", "while", "endwhile",
)  # fmt: skip
_BLOCKS = {
    "if": "endif", "function": "endfunction", "macro": "endmacro", "while": "endwhile",
    "block": "endblock",
}  # fmt: skip
_DEFINITIONS = ("function", "macro")
_FOLDERS = (
    "CMAKE_CURRENT_SOURCE_DIR", "CMAKE_CURRENT_LIST_DIR", "CMAKE_SOURCE_DIR", "PROJECT_SOURCE_DIR"
)  # fmt: skip
_PROJECT_NAMES = ("PROJECT_NAME", "CMAKE_PROJECT_NAME")


@dataclass(frozen=True)
class Argument:
    """A word of a command, with its place."""

    text: str
    line: int
    is_quoted: bool = False


@dataclass(frozen=True)
class CMakeCommand:
    """A command; its name in lower case. Not `is_complete` if some arguments are unknown."""

    name: str
    line: int
    arguments: tuple[Argument, ...]
    is_complete: bool = True

    @property
    def words(self) -> list[str]:
        return _texts(self.arguments)


@dataclass
class Values:
    """The values of a variable; not `is_complete` if there may be others."""

    arguments: list[Argument] = field(default_factory=list)
    is_complete: bool = True


class CMakeFile:
    """The commands that CMake certainly runs. SourceError if the file cannot be read."""

    def __init__(self, path: str) -> None:
        # CMake and colcon accept any encoding.
        self.source = PackageText(path, errors="replace")
        self.folder = os.path.dirname(os.path.abspath(path))
        self.commands: list[CMakeCommand] = []
        self.conditional: list[CMakeCommand] = []  # that may not run
        self._bodies: dict[str, Sequence[CMakeCommand]] = {}  # of functions and macros
        self._defined: set[str] = set()  # their names
        self._variables = {name: Values([Argument(self.folder, 0)]) for name in _FOLDERS}
        self._run(list(_commands(self.source)))

    @property
    def project(self) -> CMakeCommand | None:
        return next(iter(self.named("project")), None)

    def named(self, *names: str) -> list[CMakeCommand]:
        return [command for command in self.commands if command.name in names]

    def has(self, *names: str) -> bool:
        """Whether such a command is anywhere in the file."""
        return any(one.name in names for one in (*self.commands, *self.conditional))

    @property
    def may_do_more(self) -> bool:
        """Whether a command is from elsewhere: other files, or macros of packages."""
        return any(map(self._is_foreign, (*self.commands, *self.conditional)))

    @property
    def makes_files(self) -> bool:
        """Whether a command may make files before CMake looks for them."""
        return self.may_do_more or any(
            one.name in ("configure_file", "execute_process")
            or (one.name == "file" and one.arguments and one.arguments[0].text in _MAKES_FILES)
            for one in (*self.commands, *self.conditional)
        )

    def _is_foreign(self, command: CMakeCommand) -> bool:
        if command.name == "include":  # a module of CMake, or a file
            return re.fullmatch(r"\w+", "".join(command.words[:1])) is None
        is_known = command.name in (*_OF_CMAKE, *self._defined) or _PLAIN.fullmatch(command.name)
        return not is_known

    # ---- a walk over the commands, with variables

    def _run(self, commands: Sequence[CMakeCommand]) -> None:
        index = 0
        while index < len(commands):
            command = commands[index]
            end = _end_of(commands, index)
            body = commands[index + 1 : end]
            if command.name == "foreach":
                self._foreach(command, body)
            elif command.name in _DEFINITIONS:
                self._define(command, body)
            elif command.name in _BLOCKS:
                self._skip(*body)
            else:
                self._step(command)
            index = end + 1
            if _may_leave(command, body):
                self._skip(*commands[index:])
                return

    def _step(self, raw: CMakeCommand) -> None:
        arguments, is_complete = self._expanded(raw.arguments)
        command = CMakeCommand(raw.name, raw.line, tuple(arguments), is_complete)
        self.commands.append(command)
        match command.name, arguments:
            case "project", [name, *_]:
                self._variables |= dict.fromkeys(_PROJECT_NAMES, Values([name]))
            case "set", [name, *values]:
                words = [value.text for value in values]
                if "CACHE" in words:  # the user may have given another value
                    values, is_complete = [], False
                self._variables[name.text] = Values(values, is_complete)
            case "list", [Argument(text="APPEND"), name, *values]:
                old = self._variables.get(name.text, Values())
                self._variables[name.text] = Values(
                    [*old.arguments, *values], old.is_complete and is_complete
                )
            case "file", [Argument(text="GLOB"), name, *patterns]:
                is_complete = is_complete and not self.makes_files
                self._variables[name.text] = Values(self._matches(patterns), is_complete)
            case "string", [Argument(text="REPLACE"), old, new, name, *values]:
                replaced = [
                    Argument(value.text.replace(old.text, new.text), value.line) for value in values
                ]
                self._variables[name.text] = Values(replaced, is_complete)
            case _:
                self._forget(command)

    def _define(self, command: CMakeCommand, body: Sequence[CMakeCommand]) -> None:
        for name in command.arguments[:1]:
            self._bodies[name.text.lower()] = body
            self._defined.add(name.text.lower())
        self._skip(*body)

    def _skip(self, *commands: CMakeCommand) -> None:
        """Record commands that may not run; what they may set is unknown."""
        for raw in commands:
            arguments, is_complete = self._expanded(raw.arguments)
            command = CMakeCommand(raw.name, raw.line, tuple(arguments), is_complete)
            self.conditional.append(command)
            self._forget(command)

    def _forget(self, command: CMakeCommand) -> None:
        """Take variables as unknown that a command may set."""
        arguments = command.arguments
        names = {one.text for one in arguments if not one.is_quoted} & self._variables.keys()
        if command.name in _WITHOUT_RESULT:
            names = set()
        elif command.name == "include" and not re.fullmatch(r"\w+", "".join(_texts(arguments[:1]))):
            names = self._variables.keys() - {*_FOLDERS, *_PROJECT_NAMES}  # a file, not a module
        is_append = command.name == "list" and _texts(arguments[:1]) == ["APPEND"]
        for name in names:
            old = self._variables[name].arguments if is_append else []
            self._variables[name] = Values(old, is_complete=False)
        body = self._bodies.pop(command.name, ())  # without it a recursive one would not end
        self._skip(*body)
        if body:
            self._bodies[command.name] = body

    def _foreach(self, command: CMakeCommand, body: Sequence[CMakeCommand]) -> None:
        if not command.arguments:
            return
        name, *rest = command.arguments
        listed = [one for one in rest if one.text not in ("IN", "ITEMS", "LISTS")]
        if any(one.text == "LISTS" for one in rest):
            listed = [Argument(f"${{{one.text}}}", one.line) for one in listed]
        if "RANGE" in [one.text for one in rest]:
            listed = []
        values, is_complete = self._expanded(listed)
        for value in values:
            self._variables[name.text] = Values([value])
            self._run(body)
        if not is_complete:
            self._skip(*body)

    def _expanded(self, arguments: Sequence[Argument]) -> tuple[list[Argument], bool]:
        """The arguments with values of variables; those with unknown ones are left out."""
        found: list[Argument] = []
        are_complete = True
        for argument in arguments:
            names = _VARIABLE.findall(argument.text)
            values = [self._variables.get(name, Values(is_complete=False)) for name in names]
            is_complete = all(value.is_complete for value in values)
            text = _VARIABLE.sub(lambda match: self._joined(match[1]), argument.text)
            if _VARIABLE.fullmatch(argument.text):
                found += _elements(values[0], argument)
            elif is_complete and not _UNKNOWN.search(text):
                found.append(replace(argument, text=text))
            else:
                is_complete = False
            are_complete = are_complete and is_complete
        return found, are_complete

    def _joined(self, name: str) -> str:
        return ";".join(_texts(self._variables.get(name, Values()).arguments))

    def _matches(self, words: Sequence[Argument]) -> list[Argument]:
        """The files that the patterns of `file(GLOB ...)` match."""
        found: list[Argument] = []
        relative = None
        rest = iter(words)
        for word in rest:
            if word.text == "RELATIVE":
                relative = os.path.join(self.folder, next(rest, word).text)
            elif word.text == "LIST_DIRECTORIES":
                next(rest, None)  # true or false
            else:
                for path in sorted(glob.glob(os.path.join(glob.escape(self.folder), word.text))):
                    text = os.path.relpath(path, relative) if relative else path
                    found.append(Argument(text, word.line))
        return found


def _texts(arguments: Sequence[Argument]) -> list[str]:
    return [argument.text for argument in arguments]


def _elements(values: Values, argument: Argument) -> list[Argument]:
    """The elements of a list that is the value of `${NAME}`; "" only if that is in quotes."""
    parts = [
        replace(one, text=part) for one in values.arguments for part in one.text.split(";") if part
    ]
    return parts or ([replace(argument, text="")] if argument.is_quoted else [])


def _may_leave(command: CMakeCommand, body: Sequence[CMakeCommand]) -> bool:
    """Whether the commands after this one, or after its block, may not run."""
    if command.name in _DEFINITIONS:
        return False
    leaving = ("return",) if command.name == "foreach" else ("return", "break", "continue")
    return any(one.name in leaving for one in (command, *body))


def _end_of(commands: Sequence[CMakeCommand], index: int) -> int:
    """The index of the command that ends a block; the same index if it begins none."""
    begin = commands[index].name
    end = "endforeach" if begin == "foreach" else _BLOCKS.get(begin)
    if end is None:
        return index
    depth = 0
    for position in range(index, len(commands)):
        if commands[position].name == begin:
            depth += 1
        elif commands[position].name == end:
            depth -= 1
            if depth == 0:
                return position
    return len(commands)


def _commands(source: PackageText) -> Iterator[CMakeCommand]:
    """All commands as written; SourceError for a syntax error."""
    text, position, line = source.text, 0, 1
    name: tuple[str, int] | None = None
    arguments: list[Argument] = []
    depth = 0
    while position < len(text):
        found = _TOKEN.match(text, position)
        if found is None:
            raise _unreadable(source, text[position], line, position)
        token, kind = found[0], found.lastgroup
        kind = "bracket" if kind == "b" else "comment" if kind == "c" else kind
        if depth == 0 and kind not in ("comment", "space", "open", "word"):
            raise source.error(f"'{token[:20]}' is outside of a command", line, at=token[:20])
        if kind == "open":
            depth += 1
            if depth == 1 and name is None:
                raise source.error("'(' without the name of a command before it", line, at="(")
        elif kind == "close":
            depth -= 1
            if depth == 0 and name is not None:
                yield CMakeCommand(name[0].lower(), name[1], tuple(arguments))
                name, arguments = None, []
        elif kind == "word" and depth == 0:
            if name is not None:
                raise source.error(f"'{name[0]}' is not followed by '('", name[1], at=name[0])
            name = (token, line)
        elif kind in ("word", "quoted", "bracket"):
            arguments.append(_argument(token, kind, line))
        line += token.count("\n")
        position = found.end()
    if depth and name is not None:
        raise source.error(f"the '(' of {name[0]} is not closed", name[1], at=name[0])


def _argument(token: str, kind: str, line: int) -> Argument:
    if kind == "quoted":
        return Argument(re.sub(r"\\(.)", r"\1", token[1:-1]), line, is_quoted=True)
    if kind == "bracket":
        return Argument(token[token.index("[", 1) + 1 : token.rindex("]", 0, -1)], line, True)
    return Argument(re.sub(r"\\(.)", r"\1", token), line)


def _unreadable(source: PackageText, char: str, line: int, position: int) -> SourceError:
    column = source.line_of(position)[1]
    if char == '"':
        return source.error("the text in quotation marks is not closed", line, column)
    return source.error(f"unexpected character '{char}'", line, column)
