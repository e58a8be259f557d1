"""Reads a YAML document, and collects its mistakes with their lines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import yaml

from launcher.base import text_file, yaml_bounds
from launcher.base.document.fields import Field, FieldType, near
from launcher.base.document.source_location import KeyPath, SourceMap, entries_of
from launcher.base.errors import LauncherError, LaunchFileError, SeveralErrors
from launcher.base.text import suggest

QUOTES = "a string with a brace, a bracket or ': ' in it needs quotes"
BAD: object = object()  # what `parsed` returns instead of an invalid value
_NEWLINE = b"\n"
# What no YAML may contain: control characters and half characters.
_UNPRINTABLE = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
# The C library reads a long file twenty times as fast.
_YAML: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_KEPT = ("tag:yaml.org,2002:null", "tag:yaml.org,2002:merge")


def _texts_only(resolvers: Mapping[Any, Any]) -> dict[Any, Any]:
    kept = {
        first: [resolver for resolver in some if resolver[0] in _KEPT]
        for first, some in resolvers.items()
    }
    return {first: some for first, some in kept.items() if some}


class TextLoader(_YAML):  # type: ignore[misc]
    """Reads every scalar but `null` as a text: `yes`, `0777` and `1.10` stay what they are."""

    yaml_implicit_resolvers = _texts_only(yaml.SafeLoader.yaml_implicit_resolvers)


def text_of(path: str, what: str) -> str:
    """The text of a file; LaunchFileError if it cannot be read. `what`: `the expectations`."""
    try:
        text = text_file.read(path)
    except OSError as error:
        raise LaunchFileError(f"cannot read {what}: {error.strerror}", where=path) from None
    except UnicodeDecodeError as error:
        wrong, before = error.object[error.start], error.object[: error.start]
        raise LaunchFileError(
            f"the byte 0x{wrong:02x} is not UTF-8",
            hint="save the file as UTF-8",
            where=f"{path}:{len(before.split(_NEWLINE))}",
        ) from None
    except ValueError as error:  # a path with a NUL
        raise LaunchFileError(f"cannot read {what}: {error}") from None
    if text_file.is_pointer(text):
        raise LaunchFileError(
            text_file.pointer_sentence("it"), hint=text_file.POINTER_HINT, where=path
        )
    return text


def together(errors: Sequence[LauncherError]) -> LauncherError:
    """One error for all of them, in order of their lines."""
    in_order = sorted(errors, key=_line)
    return in_order[0] if len(in_order) == 1 else SeveralErrors(in_order)


def _line(error: LauncherError) -> int:
    line = (error.where or "").rpartition(":")[2]
    return int(line) if line.isdigit() else 0


class DocumentReader:
    """One document; `errors` are the mistakes so far.

    `what` is the document with its article, for messages; `loader` a loader of PyYAML.
    """

    def __init__(self, text: str, path: str, *, what: str, hint: str, loader: Any = _YAML) -> None:
        self.text = text
        self.path = path
        self.source = SourceMap(text, path)
        self.errors: list[LauncherError] = []
        self._what = what
        self._hint = hint
        self._loader = loader

    def document(self) -> Mapping[object, object] | None:
        """The mapping that the document is; None if it is empty or something else.

        LauncherError if it is not YAML.
        """
        self._refuse_controls()
        try:
            yaml_bounds.check(self.text, self._loader)
            loader = self._loader(self.text)
        except (yaml.YAMLError, ValueError) as error:
            raise self._yaml_error(error) from None
        try:
            root = loader.get_single_node()
            if root is None:
                return None
            self._refuse_duplicates(root)
            self.source.root = root
            document = loader.construct_document(root)
        except (yaml.YAMLError, ValueError, TypeError) as error:
            raise self._yaml_error(error) from None
        finally:
            loader.dispose()
        if not isinstance(document, Mapping):
            self.wrong((), f"{self._what} must be a mapping", self._hint)
            return None
        return document

    def _refuse_controls(self) -> None:
        """Characters that YAML's reader reports without their line."""
        found = _UNPRINTABLE.search(self.text)
        if found is None:
            return
        before = self.text[: found.start()].split("\n")
        rest = self.text[found.start() :].partition("\n")[0]
        raise LaunchFileError(
            f"invalid YAML: the character U+{ord(found[0]):04X} is not allowed",
            hint="remove it; is this file a text in UTF-8?",
            where=f"{self.path}:{len(before)}",
            source_line=before[-1] + rest,
            column=len(before[-1]) + 1,
        )

    def _yaml_error(self, error: Exception) -> LauncherError:
        mark, message = yaml_bounds.place_of(error), yaml_bounds.message_of(error)
        if mark is None:
            return LaunchFileError(f"invalid YAML: {message}", where=self.path)
        lines = self.source.lines
        line = lines[mark.line] if mark.line < len(lines) else ""
        return self.source.error_at(
            mark, f"invalid YAML: {message}", self.hint_of(error, line, mark.column, message)
        )

    def hint_of(self, error: Exception, line: str, column: int, message: str) -> str | None:
        """What to do about an error of YAML's reader in a line, at a column from 0."""
        if "\t" in line[: column + 1]:
            return "indent YAML with spaces, not with tabs"
        if "expected" in message or "not allowed" in message:
            return QUOTES
        return None

    def _refuse_duplicates(self, root: yaml.Node) -> None:
        """Duplicate keys, of which YAML's reader silently takes the last one."""
        open_nodes: set[int] = set()
        visited: set[int] = set()  # what aliases repeat is visited once

        def visit(node: yaml.Node) -> None:
            if id(node) in open_nodes:
                self.errors.append(self.source.error_at(node.start_mark, "recursive alias"))
                raise SeveralErrors(self.errors)
            if id(node) in visited:
                return
            visited.add(id(node))
            open_nodes.add(id(node))
            keys: set[object] = set()
            for name, key, value in entries_of(node):
                if name in keys and key is not None and name != "<<":
                    message = f"duplicate key '{name}'"
                    self.errors.append(self.source.error_at(key.start_mark, message))
                keys.add(name)
                visit(value)
            open_nodes.discard(id(node))

        visit(root)

    # ---- fields

    def fields(
        self, entry: Mapping[object, object], known: Sequence[Field], path: KeyPath, what: str
    ) -> dict[str, Any]:
        """The parsed values of an entry, without the wrong ones."""
        types = {field.name: field.type for field in known}
        values: dict[str, Any] = {}
        for name, value in entry.items():
            if name not in types:
                hint = near(name, types)
                self.wrong((*path, name), f"unknown key '{name}' of {what}", hint)
            else:
                values[str(name)] = self.parsed(types[str(name)], value, (*path, name))
        meant = meant_names(entry, types)
        for field in known:
            if field.required and field.name not in entry and field.name not in meant:
                self.wrong(path, f"{what} needs '{field.name}': {field.doc}")
        return {name: value for name, value in values.items() if value is not BAD}

    def parsed(self, type_: FieldType, value: object, path: KeyPath) -> Any:
        """The value; BAD after a mistake."""
        try:
            return type_.parse(value)
        except ValueError as error:
            for one in getattr(error, "all", (error,)):
                inner: KeyPath = getattr(one, "path", ())
                hint = getattr(one, "hint", None)
                self.wrong((*path, *inner), str(one), hint, value=not getattr(one, "key", False))
            return BAD

    def wrong(
        self, path: KeyPath, message: str, hint: str | None = None, *, value: bool = False
    ) -> None:
        """A mistake at the key (or the value) of the path."""
        self.errors.append(self.source.error(path, message, hint, value=value))


def meant_names(entry: Mapping[object, object], known: Iterable[str]) -> set[str | None]:
    """What the unknown names of an entry are similar to: that is not missing."""
    names = list(known)
    return {suggest(str(name), names) for name in entry if name not in names}
