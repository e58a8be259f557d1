"""Selection of processes by name, label, node, namespace or glob pattern."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from launcher.base.model.record import Record
from launcher.base.model.run_options import program_of
from launcher.base.model.spec import ProcessSpec
from launcher.base.run_verb import FOR_ALL, BadCallError
from launcher.base.text import one_of, suggest

_PATTERN = "*?["
_SHOWN = 12  # names in a message


class ProcessNames(Record):
    """All names of a process; `nodes` are full names of ROS nodes (`/fleet/robot_1`).

    `programs` select it if no other name does: `talker` for a process of talker.py.
    """

    name: str
    label: str
    nodes: tuple[str, ...] = ()
    namespace: str | None = None
    programs: tuple[str, ...] = ()

    @classmethod
    def of(cls, spec: ProcessSpec) -> ProcessNames:
        nodes, namespace = nodes_of(spec)
        programs = () if spec.members else program_of(spec.label)
        if namespace is not None and not nodes:
            programs += tuple(_full_name(namespace, name) for name in programs)
        return cls(spec.name, spec.label, nodes, namespace, programs)

    @property
    def all(self) -> tuple[str, ...]:
        """All words that select the process."""
        short = tuple(node.rpartition("/")[2] for node in self.nodes)
        nodes = self.nodes
        if not nodes and self.namespace is not None:
            # The program names its node itself, usually like its executable.
            nodes = (_full_name(self.namespace, self.label),)
        return (self.name, self.label, *short, *nodes)


def nodes_of(spec: ProcessSpec) -> tuple[tuple[str, ...], str | None]:
    """(full names of its nodes, its namespace), as far as the launch file gives them."""
    if spec.members:
        return tuple(node for one in spec.members for node in nodes_of(one)[0]), None
    if spec.ros is None:
        return (), None
    namespace, node = spec.ros.namespace or "/", spec.ros.node_name
    return (() if node is None else (_full_name(namespace, node),)), namespace


def _full_name(namespace: str, node: str) -> str:
    return node if node.startswith("/") else f"{namespace.rstrip('/')}/{node}"


def resolve(words: Iterable[str], processes: Sequence[ProcessNames]) -> list[int]:
    """Indices in `processes` that the words select, in order and without repetition.

    A word is the name of a process, its label, its node with or without namespace, a glob pattern
    of any of these (`robot_*`), or a namespace, which selects all below it; if none of these, its
    program without `.py` or `.sh`. Raises BadCallError for a word that selects nothing, or several
    processes without being a pattern.
    """
    found: dict[int, None] = {}
    for word in words:
        found.update(dict.fromkeys(_select(word, processes)))
    return sorted(found)


def parts_meant(words: Sequence[str], spec: ProcessSpec) -> tuple[ProcessSpec, ...]:
    """The nodes of a composed process that the words select, or the process itself."""
    own = (spec.name, spec.label)
    if not spec.members or not words or any(fnmatchcase(n, word) for word in words for n in own):
        return (spec,)
    places = [ProcessNames.of(one) for one in spec.members]
    meant = [any(fnmatchcase(n, word) for word in words for n in one.all) for one in places]
    return tuple(one for one, is_meant in zip(spec.members, meant, strict=True) if is_meant)


def refuse_part(verb: str, words: Sequence[str], spec: ProcessSpec) -> None:
    """BadCallError if they name only nodes of a process that has several."""
    if parts_meant(words, spec) != (spec,):
        nodes = [one.name for one in spec.members]
        raise BadCallError(
            "wrong-state",
            f"{spec.name} is the process of {len(nodes)} nodes: {_listed(nodes, 'and')}",
            f"to {verb} all of them: {verb} {spec.name}",
        )


def _select(word: str, processes: Sequence[ProcessNames]) -> list[int]:
    exact = [i for i, one in enumerate(processes) if one.name == word]
    if exact:
        return exact
    found = [i for i, one in enumerate(processes) if word in one.all]
    if not found and any(character in word for character in _PATTERN):
        found = _like(word, [one.all for one in processes])
        found = found or _like(word, [one.programs for one in processes])
        return found or _unknown(word, processes)
    if not found and word.startswith("/"):
        below = [i for i, one in enumerate(processes) if _is_below(word, one)]
        if below:
            return below
    found = found or [i for i, one in enumerate(processes) if word in one.programs]
    if len(found) > 1:
        raise BadCallError(
            "ambiguous-name",
            f"'{word}' is ambiguous: {_listed([processes[i].name for i in found], 'or')}",
            f"choose one, or '{word}*' for all of them",
        )
    return found or _unknown(word, processes)


def _like(pattern: str, names: Sequence[tuple[str, ...]]) -> list[int]:
    return [i for i, some in enumerate(names) if any(fnmatchcase(one, pattern) for one in some)]


def _is_below(group: str, one: ProcessNames) -> bool:
    if one.namespace is None:
        return False
    root = group.rstrip("/") + "/"
    return (one.namespace.rstrip("/") + "/").startswith(root)


def _unknown(word: str, processes: Sequence[ProcessNames]) -> list[int]:
    similar = suggest(word, [spelling for one in processes for spelling in one.all])
    if word == "all":
        hint = f"{FOR_ALL}; "
    elif word and sum(one.name.startswith(word) for one in processes) > 1:
        hint = f"did you mean '{word}*'? "
    else:
        meant = [one.name for one in processes if similar in one.all]
        hint = f"did you mean {one_of(meant)}? " if meant else ""
    known = _listed([one.name for one in processes], "and") or "none yet"
    raise BadCallError("unknown-name", f"unknown process '{word}'", f"{hint}known: {known}")


def _listed(names: Sequence[str], word: str) -> str:
    if len(names) > _SHOWN:
        return f"{', '.join(names[:_SHOWN])} {word} {len(names) - _SHOWN} more"
    if len(names) > 1:
        return f"{', '.join(names[:-1])} {word} {names[-1]}"
    return "".join(names)
