"""Patterns of processes in a hosts file: names, namespaces, packages, includes and groups."""

from __future__ import annotations

import enum
import os
import re
from collections.abc import Sequence
from fnmatch import fnmatchcase

from launcher.base.document.fields import FieldError, near
from launcher.base.model.record import Record
from launcher.base.model.ros_arguments import full_node_name
from launcher.base.model.spec import ProcessSpec, Scope

_WILDCARDS = re.compile(r"[*?\[]")


class PatternKind(enum.Enum):
    """What a pattern is compared with; see docs/reference/hosts-file.md."""

    WORD = "word"  # without a prefix: name of the process or of its node
    PATH = "path"  # begins with '/': the full name of the node
    PROCESS = "process"
    PACKAGE = "package"
    INCLUDE = "include"
    GROUP = "group"


PREFIXES = tuple(
    kind.value for kind in PatternKind if kind not in (PatternKind.WORD, PatternKind.PATH)
)


class Rank(enum.IntEnum):
    """How exact a match is; the smallest decides."""

    EXACT = 0  # full name of the node, name of the process with its number
    NAME = 1  # name of the node, label of the process
    PATTERN = 2  # wildcards, package, include, group
    ALL_NODES = 3  # `/**`
    ALL = 4  # `**`


class ProcessPattern(Record):
    """A pattern that was parsed; `body` is without its prefix."""

    text: str
    kind: PatternKind
    body: str

    @classmethod
    def parse(cls, value: object) -> ProcessPattern:
        """FieldError (a ValueError) with a hint, if it is not a pattern."""
        if not isinstance(value, str) or not value.strip():
            raise FieldError("expected a pattern of processes", hint="as in robot_1 or /robot_1/**")
        prefix, colon, body = value.partition(":")
        if colon:
            return cls(value, *_with_prefix(prefix, body))
        if value.startswith("/"):
            _check_path(value)
            return cls(value, PatternKind.PATH, value)
        if "/" in value:
            hint = f"names of nodes and namespaces begin with '/': /{value}"
            raise FieldError(f"'{value}' is neither a name nor a full name", hint=hint)
        return cls(value, PatternKind.WORD, value)

    @property
    def has_wildcards(self) -> bool:
        return _WILDCARDS.search(self.body) is not None

    def rank(self, spec: ProcessSpec) -> Rank | None:
        """How it matches a process; None if it does not."""
        if not self._matches(spec):
            return None
        if self.kind is PatternKind.WORD and self.body in ("*", "**"):
            return Rank.ALL
        if self.kind is PatternKind.PATH and self.body == "/**":
            return Rank.ALL_NODES
        if self.has_wildcards or self.kind in (
            PatternKind.PACKAGE,
            PatternKind.INCLUDE,
            PatternKind.GROUP,
        ):
            return Rank.PATTERN
        if self.kind is PatternKind.PATH or self.body == spec.name != spec.label:
            return Rank.EXACT
        return Rank.NAME

    def _matches(self, spec: ProcessSpec) -> bool:
        if self.kind is PatternKind.PATH:
            name = node_name(spec)
            return name is not None and path_matches(name.split("/")[1:], self._segments)
        if self.kind is PatternKind.PACKAGE:
            package = spec.ros and spec.ros.package
            return bool(package) and fnmatchcase(str(package), self.body)
        if self.kind in (PatternKind.INCLUDE, PatternKind.GROUP):
            return self.scope_of(spec) is not None
        words = [spec.name, spec.label]
        if self.kind is PatternKind.WORD:
            words.append((node_name(spec) or "").rpartition("/")[2])
        return self.body == "**" or any(fnmatchcase(word, self.body) for word in words if word)

    @property
    def _segments(self) -> list[str]:
        return self.body.split("/")[1:]

    def scope_of(self, spec: ProcessSpec) -> int | None:
        """The depth of the innermost include or group that it names, around the process."""
        names = self._names_include if self.kind is PatternKind.INCLUDE else self._names_group
        return max((n for n, scope in enumerate(spec.scopes) if names(scope)), default=None)

    def _names_include(self, scope: Scope) -> bool:
        return not scope.line and is_file(scope.path, self.body)

    def _names_group(self, scope: Scope) -> bool:
        if not scope.line:
            return False
        if self.body.startswith("/"):
            pushed = (scope.namespace or "").split("/")
            return path_matches(pushed, self.body.split("/"))
        file, _, line = self.body.rpartition(":")
        return scope.line == int(line) and is_file(scope.path, file)

    def is_wider_than(self, other: ProcessPattern, spec: ProcessSpec) -> bool:
        """Whether the other is an exception from this one, for a process that both match.

        `/a/**` is wider than `/a/b/**`, an include or a group than one inside of it.
        """
        scoped = (PatternKind.INCLUDE, PatternKind.GROUP)
        if self.kind in scoped and other.kind in scoped:
            mine, its = self.scope_of(spec), other.scope_of(spec)
            return mine is not None and its is not None and mine < its
        mine_under, its_under = _namespace(self), _namespace(other)
        if mine_under is None or its_under is None:
            return False
        return its_under != mine_under and its_under.startswith(mine_under)


def _namespace(pattern: ProcessPattern) -> str | None:
    """`/a/` of `/a/**`; None for other patterns."""
    before = pattern.body.removesuffix("**")
    if pattern.kind is not PatternKind.PATH or before == pattern.body or _WILDCARDS.search(before):
        return None
    return before


def _with_prefix(prefix: str, body: str) -> tuple[PatternKind, str]:
    if prefix not in PREFIXES:
        known = [f"{one}:" for one in PREFIXES]
        raise FieldError(f"unknown kind of pattern '{prefix}:'", hint=near(f"{prefix}:", known))
    kind = PatternKind(prefix)
    if not body.strip() or body != body.strip():
        example = {
            PatternKind.PROCESS: "process:rviz2",
            PatternKind.PACKAGE: "package:nav2_*",
            PatternKind.INCLUDE: "include:robot.launch.py",
            PatternKind.GROUP: "group:/robot_1 or group:robot.launch.py:42",
        }[kind]
        raise FieldError(f"'{prefix}:' needs a name directly behind it", hint=f"as in {example}")
    if kind is PatternKind.GROUP:
        _check_group(body)
    return kind, body


def _check_group(body: str) -> None:
    if body.startswith("/"):
        if "**" in body:
            raise FieldError("a group is named by its namespace", hint="as in group:/robot_1")
        return
    file, colon, line = body.rpartition(":")
    if not colon or not file or not (line.isascii() and line.isdigit()) or int(line[:9]) == 0:
        message = f"'{body}' is neither the namespace nor the place of a group"
        raise FieldError(message, hint="as in group:/robot_1 or group:robot.launch.py:42")


def _check_path(text: str) -> None:
    segments = text.split("/")[1:]
    if any(not segment for segment in segments):
        what = text.rstrip("/") or "/"
        hint = f"the nodes in a namespace are {what.rstrip('/')}/**"
        raise FieldError(f"'{text}' has an empty name between its slashes", hint=hint)
    for segment in segments:
        if "**" in segment and segment != "**":
            hint = "'**' stands for whole names: /robot_1/**"
            raise FieldError(f"'{segment}' is not a name with wildcards", hint=hint)


def node_name(spec: ProcessSpec) -> str | None:
    """The full name of the node; its last part is empty if the program chooses it.

    None for a process that is no node, as far as its command line says.
    """
    ros = spec.ros
    if ros is None or ros.node_name is None:
        given = full_node_name(spec.argv) if "--ros-args" in spec.argv else None
        if given is not None or ros is None:
            return given
    return f"{(ros.namespace or '').rstrip('/')}/{ros.node_name or ''}"


def path_matches(names: Sequence[str], pattern: Sequence[str]) -> bool:
    """Whether names fit a pattern, part by part; `**` stands for any number of them.

    An empty name is unknown, and fits only a wildcard.
    """
    if not pattern:
        return not names
    if pattern[0] == "**":
        return any(path_matches(names[n:], pattern[1:]) for n in range(len(names) + 1))
    return bool(names) and (
        fnmatchcase(names[0], pattern[0]) and path_matches(names[1:], pattern[1:])
    )


def is_file(path: str, text: str) -> bool:
    """Whether `text`, which may have wildcards, is the end of a path: its file name, or more."""
    path, text = os.path.normpath(path), os.path.normpath(text)
    number = text.count("/")
    parts = path.rsplit("/", number + 1)[-number - 1 :]
    return fnmatchcase(path if text.startswith("/") else "/".join(parts), text)
