"""Checks `.msg`, `.srv`, `.action` and `.idl` files with rosidl's own parsers.

rosidl reads a file only while CMake runs, and reports mistakes as a traceback without a line.
"""

from __future__ import annotations

import contextlib
import io
import keyword
import os
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from launcher.base.text import count
from launcher.workspace.building.checks.interface_errors import explained, name_error
from launcher.workspace.building.sources.source_text import PackageText, SourceError, SourceWarning

SUFFIXES = (".msg", ".srv", ".action", ".idl")
_PARTS = {".msg": 1, ".srv": 2, ".action": 3}
_SEPARATOR = "---"

# The generated code has fields as members of C structures, in files of C and of C++.
_KEYWORDS = frozenset(
    re.findall(
        r"\w+",
        "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl "
        "const constexpr const_cast continue decltype default delete "
        "do double dynamic_cast else enum explicit export extern false float for friend goto if "
        "inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq "
        "private protected public register reinterpret_cast restrict return short signed "
        "sizeof static static_assert static_cast struct switch template this thread_local throw "
        "true try typedef typeid typename union unsigned using virtual void volatile wchar_t while "
        "xor xor_eq",
    )
)
_LATER_KEYWORDS = frozenset(("concept", "consteval", "constinit", "requires"))  # of C++20


class Reference(NamedTuple):
    """A field of another interface's type: `package/Type`, and as it is written in a line."""

    package: str
    name: str
    line: int
    written: str


class InterfaceFile:
    """An interface file of a package: its mistakes, and the types that it uses.

    Raises SourceError if the file cannot be read.
    """

    def __init__(self, package: str, path: str) -> None:
        self.package = package
        self.source = PackageText(path)
        self.name, self.suffix = os.path.splitext(os.path.basename(path))
        self.problems: list[SourceError] = []
        self.references: list[Reference] = []
        wrong = name_error(self.source, self.name, self.suffix)
        if wrong is not None:
            self.problems.append(wrong)
        if wrong is not None and not isinstance(wrong, SourceWarning):
            pass
        elif self.source.has_bom:
            message = "the file begins with a byte order mark, which rosidl does not understand"
            hint = "save it as UTF-8 without a byte order mark (BOM)"
            self.problems.append(self.source.error(message, 1, hint=hint))
        elif self.suffix == ".idl":
            self._read_idl()
        else:
            self._read_parts()

    # ---- .msg, .srv, .action

    def _read_parts(self) -> None:
        parts: list[list[tuple[int, str]]] = [[]]
        for number, line in enumerate(self.source.text.splitlines(), start=1):
            if line == _SEPARATOR and self.suffix != ".msg":
                parts.append([])
            else:
                parts[-1].append((number, line))
        if len(parts) != _PARTS[self.suffix]:
            self._refuse_parts(len(parts), _PARTS[self.suffix])
            return
        for part in parts:
            self._read_part(part)

    def _refuse_parts(self, given: int, needed: int) -> None:
        what = {".srv": "request and response", ".action": "goal, result and feedback"}
        message = (
            f"{what[self.suffix]} are separated by {count(needed - 1, 'line')} '---', "
            f"this file has {given - 1}"
        )
        lines = self.source.lines
        near = [n for n, line in enumerate(lines, 1) if re.fullmatch(r"\s*-{2,}\s*(#.*)?", line)]
        wrong = [number for number in near if lines[number - 1] != _SEPARATOR]
        hint = "the line must be exactly '---'" if wrong else None
        if given > needed:
            wrong = [number for number in near if lines[number - 1] == _SEPARATOR][needed - 1 :]
        self.problems.append(self.source.error(message, wrong[0] if wrong else 1, hint=hint))

    def _read_part(self, lines: list[tuple[int, str]]) -> None:
        seen: dict[str, int] = {}
        for number, line in lines:
            element = self._element(number, line)
            if element is None:
                continue
            if element.name in seen:
                message = f"'{element.name}' is already in line {seen[element.name]}"
                self.problems.append(
                    self.source.error(message, number, at=_last(line, element.name))
                )
            seen.setdefault(element.name, number)

    def _element(self, number: int, line: str) -> Any:
        """The field or constant of a line as rosidl reads it; None for others and for mistakes."""
        from rosidl_adapter.parser import parse_message_string

        try:
            with _silent():
                message = parse_message_string(self.package, "Name", line)
        except Exception as problem:  # rosidl raises all kinds: IndexError, TypeError, ...
            self.problems.append(explained(self.source, number, line, problem))
            return None
        elements = [*message.fields, *message.constants]
        if not elements:
            return None
        wrong = self._beyond_parser(number, line, elements[0], is_field=bool(message.fields))
        if wrong is not None:
            self.problems.append(wrong)
            return None
        return elements[0]

    def _beyond_parser(
        self, number: int, line: str, element: Any, *, is_field: bool
    ) -> SourceError | None:
        """What the parser accepts, and generators or compilers do not."""
        type_ = element.type
        if not is_field:
            return self._unwritable(number, line, type_, element.value)
        reserved = _keyword(element.name)
        if reserved is not None:
            what, is_certain = reserved
            at = _last(line, element.name)
            hint = f"use another name, for example '{element.name}_value'"
            report = self.source.error if is_certain else self.source.warning
            self.problems.append(report(f"'{element.name}' is {what}", number, at=at, hint=hint))
        if type_.pkg_name is None:
            if type_.type in ("time", "duration"):
                return explained(self.source, number, line, LookupError(type_.type))
            return self._unwritable(number, line, type_.type, element.default_value)
        written = line.split()[0].partition("[")[0]
        self.references.append(Reference(type_.pkg_name, type_.type, number, written))
        return None

    def _unwritable(
        self, number: int, line: str, type_: object, value: object
    ) -> SourceError | None:
        """The error for numbers that cannot be written as literals of C."""
        for one in value if isinstance(value, list) else [value]:
            limit = 3.4028235677973366e38 if type_ == "float32" else 1.7976931348623157e308
            if isinstance(one, float) and not -limit <= one <= limit:
                message = f"a value of {type_} is a finite number, up to {limit:.2g}"
                at = line.partition("#")[0].replace("=", " ").split()[-1]
                return self.source.error(message, number, at=at)
        return None

    # ---- .idl

    def _read_idl(self) -> None:
        from lark.exceptions import UnexpectedInput

        try:
            with _silent():
                content = _parsed_idl(self.source.text)
        except UnexpectedInput as problem:
            self.problems.append(self._unexpected(problem))
        except Exception as problem:
            text = str(problem).strip().splitlines()
            message = text[0] if text else "this IDL is not supported by rosidl"
            word = next(iter(re.findall(r"[A-Za-z_]\w*$", message)), "")
            place = self.source.find(word) if word else (None, None)
            self.problems.append(self.source.error(message, *place))
        else:
            self._refer_from_idl(content)

    def _unexpected(self, problem: Any) -> SourceError:
        """The error for a text that the grammar of IDL does not allow."""
        from lark.exceptions import UnexpectedEOF

        expected = getattr(problem, "allowed", None) or getattr(problem, "expected", None) or ()
        hint = "is a ';' missing before it?" if "SEMICOLON" in expected else None
        if isinstance(problem, UnexpectedEOF):
            last = len(self.source.text.rstrip().splitlines()) or 1
            return self.source.error("the file ends inside a definition", last)
        return self.source.error("not understood as IDL", problem.line, problem.column, hint=hint)

    def _refer_from_idl(self, content: object) -> None:
        defined = _defined_type(content)
        folder = os.path.basename(os.path.dirname(os.path.abspath(self.source.path)))
        expected = (self.package, folder, self.name)
        if defined is not None and (*defined.namespaces, defined.name) != expected:
            given = "::".join(map(str, (*defined.namespaces, defined.name)))
            place = self.source.find(defined.name)
            hint = "the modules are package and folder, the name that of the file"
            message = f"this file must define {'::'.join(expected)}, not {given}"
            self.problems.append(self.source.error(message, *place, hint=hint))
        for type_ in _named_types(content):
            package, name = type_.namespaces[0], type_.name
            written = "::".join((*type_.namespaces, name))
            line, _ = self.source.find(written)
            self.references.append(Reference(str(package), str(name), line or 1, written))


def _keyword(name: str) -> tuple[str, bool] | None:
    """What a name is that a field should not have, and whether its package cannot be compiled."""
    if name in _KEYWORDS:
        return "a keyword of C or C++: the generated code could not be compiled", True
    if name in _LATER_KEYWORDS:
        return "a keyword of C++20: code that uses that could not be compiled", False
    if keyword.iskeyword(name):
        # rosidl only warns, and generates a module with a syntax error.
        return "a keyword of Python: the generated module cannot be imported", False
    return None


def _parsed_idl(text: str) -> Any:
    from rosidl_parser.parser import parse_idl_string

    return parse_idl_string(text)


def _defined_type(content: Any) -> Any:
    """The NamespacedType that an IDL file defines."""
    from rosidl_parser import definition

    for element in content.elements:
        match element:
            case definition.Message():
                return element.structure.namespaced_type
            case definition.Service() | definition.Action():
                return element.namespaced_type
    return None


def _named_types(content: Any) -> Iterator[Any]:
    """The types of other interfaces that the fields of an IDL file have."""
    from rosidl_parser import definition

    messages: list[Any] = []
    for element in content.elements:
        match element:
            case definition.Message():
                messages.append(element)
            case definition.Service():
                messages += [element.request_message, element.response_message]
            case definition.Action():
                messages += [element.goal, element.result, element.feedback]
    for message in messages:
        for member in message.structure.members:
            type_ = member.type
            if isinstance(type_, definition.AbstractNestedType):
                type_ = type_.value_type
            if isinstance(type_, definition.NamespacedType):
                yield type_


def _last(line: str, word: str) -> str | None:
    """The end of the code of a line that begins with the word, for the caret."""
    found = re.search(rf"(?<=\s){re.escape(word)}(?!\w).*", line)
    return found[0] if found else None


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Without what rosidl prints about a mistake before it raises."""
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        yield
