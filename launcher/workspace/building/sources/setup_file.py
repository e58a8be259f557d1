"""setup.py and setup.cfg of Python packages, read without running them."""

from __future__ import annotations

import ast
import configparser
import os
import re
import sys
from functools import cached_property

from launcher.workspace.building.sources.source_text import PackageText, SourceError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Modules whose import does not call `setup`.
_HARMLESS = {*sys.stdlib_module_names, "setuptools", "distutils"} - {"importlib", "runpy"}
_MAKING_FILES = {
    *("call", "check_call", "check_output", "copy", "copy2", "copyfile", "copytree", "makedirs"),
    *("mkdir", "open", "Popen", "run", "symlink", "symlink_to", "system", "touch"),
    *("write_bytes", "write_text"),
}


class SetupFile:
    """A setup.py. SourceError if it cannot be read, or is not Python."""

    def __init__(self, path: str) -> None:
        self.source = PackageText(path)
        try:
            self._tree = ast.parse(self.source.text)
        except SyntaxError as error:
            raise self.source.error(
                f"syntax error: {error.msg}", error.lineno, error.offset
            ) from None
        except ValueError as error:  # a null byte
            raise self.source.error(str(error)) from None
        names = [one for one in ast.walk(self._tree) if isinstance(one, ast.Name)]
        stored = [one.id for one in names if isinstance(one.ctx, ast.Store)]
        self._names = {name: text for name, text in self._assignments() if stored.count(name) == 1}

    @cached_property
    def call(self) -> ast.Call | None:
        """The call of `setup`."""
        calls = (node for node in ast.walk(self._tree) if isinstance(node, ast.Call))
        return next((one for one in calls if re.search(r"\bsetup$", ast.unparse(one.func))), None)

    @cached_property
    def is_certain(self) -> bool:
        """Whether `setup` is called with what is written in its call, and finds no other files:
        at the top, or where the file is the program, and nothing makes files before.
        """
        called = (one.func for one in ast.walk(self._tree) if isinstance(one, ast.Call))
        names = (ast.unparse(one).rpartition(".")[2] for one in called)
        return any(one is self.call for one in self._at_top()) and not {*names} & _MAKING_FILES

    def _at_top(self) -> Iterator[ast.expr]:
        for node in self._tree.body:
            match node:
                case ast.If(test=ast.Compare(left=ast.Name(id="__name__")), body=body):
                    yield from (one.value for one in body if isinstance(one, ast.Expr))
                case ast.Expr(value=value):
                    yield value

    @property
    def report(self) -> Callable[..., SourceError]:
        """What makes an error of a mistake in the call, or a warning if it is not certain."""
        return self.source.error if self.is_certain else self.source.warning

    @property
    def may_call_setup(self) -> bool:
        """Whether `setup` may be called: here, under another name, or by a module or text."""
        for node in ast.walk(self._tree):
            match node:
                case ast.Import(names=aliases):
                    modules = [one.name for one in aliases]
                case ast.ImportFrom(module=module):
                    modules = [module or ""]
                case ast.Name(id=name, ctx=ast.Load()) | ast.Attribute(attr=name):
                    if re.search(r"setup(?!tools)|^(exec|eval|getattr|__import__)$", name):
                        return True
                    continue
                case ast.alias(name=name, asname=str()):
                    modules = [name] if name == "setup" else []
                case _:
                    continue
            if any(module.partition(".")[0] not in _HARMLESS for module in modules):
                return True
        return False

    def argument(self, name: str) -> ast.expr | None:
        """An argument of `setup`; None without one, or if it comes from a dictionary."""
        call = self.call
        keywords = call.keywords if call else []
        return next((word.value for word in keywords if word.arg == name), None)

    @property
    def has_more(self) -> bool:
        """Whether `setup` has arguments that are not written in its call: `**kwargs`."""
        return self.call is None or any(word.arg is None for word in self.call.keywords)

    def text(self, name: str) -> tuple[str, ast.expr] | None:
        """The value of an argument and its place, if it is a text or a name of one."""
        value = self.argument(name)
        text = self.value_of(value) if value is not None else None
        return (text, value) if value is not None and text is not None else None

    def place(self, node: ast.expr) -> tuple[int, int]:
        """Line and column, from 1, of an expression: ast counts bytes."""
        before = self.source.lines[node.lineno - 1].encode()[: node.col_offset]
        return node.lineno, len(before.decode(errors="replace")) + 1

    def value_of(self, node: ast.expr) -> str | None:
        """The text of an expression; None if it is known only when setup.py runs."""
        match node:
            case ast.Constant(value=str(text)):
                return text
            case ast.Name(id=name):
                return self._names.get(name)
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                return _joined([self.value_of(left), self.value_of(right)])
            case ast.JoinedStr(values=values):
                return _joined([self._part(value) for value in values])
            case ast.Call(args=args) if ast.unparse(node.func) in ("os.path.join", "join"):
                parts = [self.value_of(arg) for arg in args]
                return None if None in parts else os.path.join("", *(part or "" for part in parts))
        return None

    def _part(self, node: ast.expr) -> str | None:
        match node:
            case ast.FormattedValue(value=value, conversion=-1, format_spec=None):
                return self.value_of(value)
        return self.value_of(node)

    def _assignments(self) -> Iterator[tuple[str, str]]:
        for node in self._tree.body:
            match node:
                case ast.Assign(targets=[ast.Name(id=name)], value=ast.Constant(value=str(text))):
                    yield name, text


def _joined(parts: list[str | None]) -> str | None:
    return None if None in parts else "".join(part or "" for part in parts)


def configured_name(path: str) -> str | None:
    """The name of the package in a setup.cfg; None without one, or if it cannot be read."""
    parser = configuration(path)
    return parser.get("metadata", "name", fallback=None) if parser else None


def configuration(path: str) -> configparser.RawConfigParser | None:
    """A setup.cfg, parsed as by setuptools; None if there is none, or it cannot be read."""
    try:
        return _parsed(path)
    except (configparser.Error, UnicodeDecodeError, OSError):
        return None


def configuration_error(path: str) -> tuple[str, int | None] | None:
    """Why a setup.cfg cannot be read, and the line; None if it can."""
    try:
        _parsed(path)
    except (configparser.DuplicateSectionError, configparser.DuplicateOptionError) as error:
        name = getattr(error, "option", error.section)
        return f"'{name}' is there twice", error.lineno
    except configparser.MissingSectionHeaderError as error:
        return "the line is in no section", error.lineno
    except configparser.ParsingError as error:
        return "the line is neither [SECTION] nor KEY = VALUE", error.errors[0][0]
    except (UnicodeDecodeError, OSError):  # SourceText reports it
        return None
    return None


def _parsed(path: str) -> configparser.RawConfigParser | None:
    parser = configparser.RawConfigParser()
    return parser if parser.read(path, encoding="utf-8") else None
