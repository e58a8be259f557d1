"""What differs between two specifications of a process, and which one of a new plan it is.

Paths of temporary files do not count: the launcher writes the parameters of a node to a new file
at each evaluation, and so may a launch file. Their contents are compared.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence

from launcher.base import text_file
from launcher.base.model.parameter_sections import parameters, sections
from launcher.base.model.record import Record
from launcher.base.model.spec import ProcessSpec

_SHOWN = 40  # characters of a value
# Applied to a running process; it is not restarted for them.
POLICIES = ("restart policy", "stop policy")


class Comparable(Record):
    """A spec, and its command line with contents in place of temporary files."""

    spec: ProcessSpec
    words: tuple[object, ...]


def comparable(spec: ProcessSpec) -> Comparable:
    """Read the temporary files now: the next evaluation may write them again."""
    parameters = () if spec.ros is None else spec.ros.parameters
    generated = {one.file: one.generated for one in parameters if one.generated is not None}
    return Comparable(spec, tuple(_content(word, generated) for word in spec.argv))


def _content(word: str, generated: Mapping[str | None, Mapping[str, object]]) -> object:
    if word in generated:
        return generated[word]
    option, _, path = word.rpartition("=")
    if os.path.dirname(path) != tempfile.gettempdir():
        return word
    with contextlib.suppress(OSError, ValueError):
        return option, text_file.read_bytes(path)
    return word


def differences(old: Comparable, new: Comparable) -> list[str]:
    """What has changed, for users; empty if nothing has. Names of nodes and labels are equal."""
    return [*_of_command(old, new), *_of_environment(old.spec.env, new.spec.env)] + [
        text for text, value in _FIELDS.items() if value(old.spec) != value(new.spec)
    ]


_FIELDS: dict[str, Callable[[ProcessSpec], object]] = {
    "working directory": lambda spec: spec.cwd,
    "shell": lambda spec: spec.shell,
    "emulate_tty": lambda spec: spec.emulate_tty,
    "output": lambda spec: spec.output,
    "limits": lambda spec: spec.limits,
    "restart policy": lambda spec: spec.restart,
    "stop policy": lambda spec: spec.stop,
}


def needs_restart(changes: Sequence[str]) -> bool:
    return any(change not in POLICIES for change in changes)


def _of_command(old: Comparable, new: Comparable) -> Iterator[str]:
    if old.words == new.words:
        return
    before, after = _parameters(old.words), _parameters(new.words)
    names = [name for name in {**before, **after} if before.get(name) != after.get(name)]
    yield from (f"parameter {_change(name, before, after)}" for name in names)
    if not names or _plain(old.words) != _plain(new.words):
        yield "command line"


def _plain(words: Sequence[object]) -> list[object]:
    """The words without contents of files."""
    return [word for word in words if isinstance(word, str)]


def _change(name: str, before: Mapping[str, object], after: Mapping[str, object]) -> str:
    if name not in before:
        return f"{name} is new: {_short(after[name])}"
    if name not in after:
        return f"{name} is gone"
    return f"{name}: {_short(before[name])} -> {_short(after[name])}"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


def _parameters(words: Sequence[object]) -> dict[str, object]:
    """The parameters in generated files."""
    found: dict[str, object] = {}
    for word in words:
        if isinstance(word, Mapping):
            for section in sections(word):
                found.update((name, value) for name, _, value in parameters(section.parameters))
    return found


def _of_environment(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    # Without values: they may be secret.
    names = sorted(name for name in {*old, *new} if old.get(name) != new.get(name))
    if names:
        yield f"environment ({', '.join(names)})"


# ---- identity


def match(old: Sequence[Comparable], new: Sequence[Comparable]) -> dict[int, int]:
    """Index in `new` -> index in `old`, for those that are the same process.

    They have the same label. Of several, in this order: those with the same command, the same node,
    the same place in the launch file, and what is left in order.
    """
    found: dict[int, int] = {}
    for key in (_by_command, _by_node, _by_place, _by_label):
        taken = set(found.values())
        left: dict[object, list[int]] = {}
        for index, one in enumerate(old):
            if index not in taken:
                left.setdefault(key(one), []).append(index)
        for index, one in enumerate(new):
            if index not in found and key(one) is not None and left.get(key(one)):
                found[index] = left[key(one)].pop(0)
    return found


def _by_command(one: Comparable) -> object:
    return (one.spec.label, _node(one), repr(one.words))


def _by_node(one: Comparable) -> object:
    node = _node(one)
    return None if node is None else (one.spec.label, node)


def _by_place(one: Comparable) -> object:
    return (one.spec.label, one.spec.place)


def _by_label(one: Comparable) -> object:
    return one.spec.label


def _node(one: Comparable) -> object:
    ros = one.spec.ros
    return None if ros is None or ros.node_name is None else (ros.namespace, ros.node_name)
