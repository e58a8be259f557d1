"""What was received of each frame, the tree that they make, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from launcher.ros.tf.arithmetic import is_unit
from launcher.ros.tf.frame_buffer import StampedTransform, refusal

_SECOND_NS = 1_000_000_000
_OLD_S = 1.0  # a moving frame that is older is a problem, or if it lacks some of its periods
_OLD_PERIODS = 5
_AHEAD_S = 0.1  # of the clock
_FAR_S = 86400.0  # from the clock: stamps of a simulation, or of a player
_DENORMALIZED = "TF_DENORMALIZED_QUATERNION from Kilted on: the length of its quaternion is not 1"
_AUTHORITY = "default_authority"  # as tf2 calls one that it does not know


class TfSample(NamedTuple):
    """The transforms of one message; `broadcaster` is a node, empty if unknown."""

    received_ns: int
    is_static: bool
    broadcaster: str
    transforms: list[StampedTransform]


class FrameProblem(NamedTuple):
    """`frame` is empty for a problem of the whole tree."""

    kind: str
    frame: str
    text: str


@dataclass(slots=True)
class ParentCourse:
    """What was received of a frame below one parent: the stamps, and the nodes that broadcast."""

    is_static: bool = False
    received_ns: int = 0
    count: int = 0
    newest_ns: int = 0
    oldest_ns: int = 0
    nodes: set[str] = field(default_factory=set)

    def take(self, stamp_ns: int, sample: TfSample) -> None:
        self.is_static, self.received_ns = sample.is_static, sample.received_ns
        self.newest_ns = max(self.newest_ns, stamp_ns) if self.count else stamp_ns
        self.oldest_ns = min(self.oldest_ns, stamp_ns) if self.count else stamp_ns
        self.count += 1
        if sample.broadcaster:
            self.nodes.add(sample.broadcaster)

    @property
    def buffer_s(self) -> float:
        return (self.newest_ns - self.oldest_ns) / _SECOND_NS

    @property
    def rate_hz(self) -> float | None:
        """None for a static frame, and for one message."""
        span_s = self.buffer_s
        return None if self.is_static or not span_s else (self.count - 1) / span_s

    def age_s(self, now_ns: int) -> float:
        return (now_ns - self.newest_ns) / _SECOND_NS

    def is_far(self, now_ns: int) -> bool:
        """Whether its stamps are of another clock: an age would say nothing."""
        return not self.is_static and abs(self.age_s(now_ns)) > _FAR_S

    def is_old(self, now_ns: int) -> bool:
        limit_s = max(_OLD_S, _OLD_PERIODS / self.rate_hz if self.rate_hz else 0.0)
        return not self.is_static and self.age_s(now_ns) > limit_s


@dataclass(slots=True)
class FrameCourse:
    """What was received of one frame, whose last transform is below `parent`.

    `broadcasters` with the time of the last message.
    """

    parent: str
    parents: dict[str, ParentCourse] = field(default_factory=dict)
    broadcasters: dict[str, int] = field(default_factory=dict)

    @property
    def last(self) -> ParentCourse:
        return self.parents[self.parent]

    def take(self, stamped: StampedTransform, sample: TfSample) -> None:
        self.parent = stamped.parent
        self.parents.setdefault(stamped.parent, ParentCourse()).take(stamped.stamp_ns, sample)
        if sample.broadcaster:
            self.broadcasters[sample.broadcaster] = sample.received_ns

    def forget(self, before_ns: int) -> None:
        """Who has sent nothing since then; the rates begin anew."""
        for one in self.parents.values():
            one.count, one.oldest_ns = 1, one.newest_ns
        parents = {name: one.received_ns for name, one in self.parents.items()}
        for kept, times in ((self.parents, parents), (self.broadcasters, {**self.broadcasters})):
            limit_ns = min(before_ns, max(times.values(), default=0))  # the last one stays
            for name in [name for name, at_ns in times.items() if at_ns < limit_ns]:
                del kept[name]

    def nodes_of(self, parent: str) -> str:
        """Those that broadcast it below this parent."""
        return ", ".join(sorted(self.parents[parent].nodes & self.broadcasters.keys()))


class FrameTree:
    """All frames of some messages; times of the questions are those of the clock."""

    def __init__(self) -> None:
        self.courses: dict[str, FrameCourse] = {}
        self._ignored: dict[tuple[str, str], int] = {}  # (child, why) -> how many

    def take(self, sample: TfSample) -> None:
        for stamped in sample.transforms:
            refused = refusal(stamped)
            why = refused or (None if is_unit(stamped.transform.rotation) else _DENORMALIZED)
            if why is not None:
                key = (stamped.child, _by(sample.broadcaster, why))
                self._ignored[key] = self._ignored.get(key, 0) + 1
            if refused is not None:
                continue
            course = self.courses.get(stamped.child)
            if course is None:
                course = FrameCourse(stamped.parent)
                self.courses[stamped.child] = course
            course.take(stamped, sample)

    def forget(self, before_ns: int) -> None:
        """What was received before, but for static frames, which are sent once."""
        self._ignored.clear()
        for course in self.courses.values():
            if not course.last.is_static:
                course.forget(before_ns)

    def clock_ns(self, now_ns: int) -> int:
        """The time of the stamps if all are of another clock, as in a bag of a simulation."""
        moving = [one.last for one in self.courses.values() if not one.last.is_static]
        if moving and all(one.is_far(now_ns) for one in moving):
            return max(one.newest_ns for one in moving)
        return now_ns

    def roots(self) -> list[str]:
        """Frames without a parent, and one of each loop."""
        parents = {parent for course in self.courses.values() for parent in course.parents}
        return [*sorted(parents - self.courses.keys()), *(loop[0] for loop in self._loops())]

    def _loops(self) -> list[list[str]]:
        """The frames of each loop, from the least name on, child before parent."""
        found: list[list[str]] = []
        seen: set[str] = set()
        for start in sorted(self.courses):
            way: dict[str, None] = {}
            frame = start
            while frame in self.courses and frame not in seen:
                seen.add(frame)
                way[frame] = None
                frame = self.courses[frame].parent
            if frame in way:
                loop = list(way)[list(way).index(frame) :]
                least = loop.index(min(loop))
                found.append(loop[least:] + loop[:least])
        return found

    # ---- problems

    def problems(self, now_ns: int) -> list[FrameProblem]:
        return [
            *(FrameProblem("loop", loop[0], _loop_text(loop)) for loop in self._loops()),
            *(one for frame in sorted(self.courses) for one in self._of_frame(frame, now_ns)),
            *self._several_trees(),
            *(
                FrameProblem("ignored", frame, f"{frame or 'a frame'}: {number} ignored, {why}")
                for (frame, why), number in sorted(self._ignored.items())
            ),
        ]

    def _of_frame(self, frame: str, now_ns: int) -> Iterator[FrameProblem]:
        course = self.courses[frame]
        if len(course.parents) > 1:
            parents = (_by(course.nodes_of(name), name) for name in course.parents)
            text = f"{frame} has several parents: {' and '.join(parents)}"
            yield FrameProblem("several parents", frame, text)
        elif len(course.broadcasters) > 1:
            text = f"{frame} is broadcast by several nodes: {', '.join(course.broadcasters)}"
            yield FrameProblem("several broadcasters", frame, text)
        last, age_s = course.last, course.last.age_s(now_ns)
        if last.is_far(now_ns):
            stamp = f"its stamp {last.newest_ns / _SECOND_NS:.1f}"
            text = f"{frame}: {stamp} is far from now (simulated time?)"
            yield FrameProblem("old" if age_s > 0 else "future", frame, text)
        elif last.is_old(now_ns):
            yield FrameProblem(
                "old", frame, f"{frame} is old: its last transform is {age_s:.1f} s old"
            )
        elif not last.is_static and age_s < -_AHEAD_S:
            text = f"{frame} is {-age_s:.1f} s in the future: clocks differ"
            yield FrameProblem("future", frame, text)

    def _several_trees(self) -> Iterator[FrameProblem]:
        roots = self.roots()
        if len(roots) > 1:
            text = f"there are {len(roots)} unconnected trees: {', '.join(roots)}"
            yield FrameProblem("several trees", "", text)

    # ---- as text, data and a drawing

    def lines(self, now_ns: int) -> Iterator[str]:
        """Problems first, then the trees."""
        problems = [f"problem: {problem.text}" for problem in self.problems(now_ns)]
        yield from [*problems, ""] if problems else []
        rows = self.rows(now_ns)
        width = max((len(shown) for shown, _ in rows), default=0)
        yield from (f"{shown:{width}}  {facts}".rstrip() for shown, facts in rows)

    def rows(self, now_ns: int) -> list[tuple[str, str]]:
        """The trees: each frame below its parents, and what is known of it.

        What is below a frame is shown where its last transform is.
        """
        below: dict[str, list[str]] = {}
        for child in sorted(self.courses, reverse=True):
            for parent in self.courses[child].parents:
                below.setdefault(parent, []).append(child)
        rows: list[tuple[str, str]] = []
        for root in self.roots():
            waiting, seen = [(root, self._parent(root), "", "")], {root}
            while waiting:
                frame, parent, branch, indent = waiting.pop()
                rows.append((f"{branch}{frame}", self._facts(frame, parent, now_ns)))
                if parent != self._parent(frame):
                    continue
                children = [
                    child
                    for child in below.get(frame, ())
                    if child not in seen or self._parent(child) != frame
                ]
                seen.update(child for child in children if self._parent(child) == frame)
                waiting += (
                    (child, frame, f"{indent}└─ ", f"{indent}   ")
                    if child == children[0]
                    else (child, frame, f"{indent}├─ ", f"{indent}│  ")
                    for child in children
                )
        return rows

    def _parent(self, frame: str) -> str:
        """That of its last transform; an empty text for a root."""
        return self.courses[frame].parent if frame in self.courses else ""

    def _facts(self, frame: str, parent: str, now_ns: int) -> str:
        if frame not in self.courses:
            return ""
        course = self.courses[frame]
        one, nodes = course.parents[parent], course.nodes_of(parent)
        if one.is_static:
            return _by(nodes, "static")
        rate = "one transform" if one.rate_hz is None else f"{one.rate_hz:.1f} Hz"
        if one.is_far(now_ns):
            oldest, newest = one.oldest_ns / _SECOND_NS, one.newest_ns / _SECOND_NS
            ages = f"stamps {oldest:.2f} to {newest:.2f}"
        else:
            oldest_s = one.age_s(now_ns) + one.buffer_s
            ages = f"newest {one.age_s(now_ns):.2f} s, oldest {oldest_s:.2f} s old"
        return _by(nodes, f"{rate}, buffer {one.buffer_s:.2f} s, {ages}")

    def document(self, now_ns: int) -> dict[str, Any]:
        return {
            "frames": [
                {
                    "frame": frame,
                    "parent": course.parent,
                    "static": course.last.is_static,
                    "broadcasters": list(course.broadcasters),
                    "transforms": course.last.count,
                    "rate_hz": course.last.rate_hz,
                    "buffer_s": course.last.buffer_s,
                    "newest_ns": course.last.newest_ns,
                    "oldest_ns": course.last.oldest_ns,
                }
                for frame, course in sorted(self.courses.items())
            ],
            "roots": self.roots(),
            "problems": [problem._asdict() for problem in self.problems(now_ns)],
        }

    def dot(self, now_ns: int) -> str:
        """The drawing as `view_frames` of tf2_tools makes it."""
        if not self.courses:
            return 'digraph G { "No tf data received" }\n'
        edges = [
            self._edge(frame, parent, one, course.nodes_of(parent))
            for frame, course in self.courses.items()
            for parent, one in course.parents.items()
        ]
        recorded = _quoted(f"Recorded at time: {now_ns / _SECOND_NS}")
        legend = 'subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";'
        ends = (f"}}->{_quoted(root)};" for root in self.roots()[:1])
        lines = [*edges, "edge [style=invis];", f" {legend}", f"{recorded}[ shape=plaintext ] ;"]
        return "\n".join(["digraph G {", *lines, *ends, "}\n"])

    @staticmethod
    def _edge(frame: str, parent: str, one: ParentCourse, nodes: str) -> str:
        # tf2 divides by a tenth of a millisecond where there is one transform
        rate = 10000.0 if one.rate_hz is None else round(one.rate_hz, 3)
        times = (0, 0) if one.is_static else (one.newest_ns, one.oldest_ns)
        newest, oldest = (round(time_ns / _SECOND_NS, 6) for time_ns in times)
        facts = {
            "Broadcaster": nodes or _AUTHORITY,
            "Average rate": rate,
            "Buffer length": 0.0 if one.is_static else round(one.buffer_s, 3),
            "Most recent transform": newest,
            "Oldest transform": oldest,
        }
        label = "".join(f"{name}: {value}\\n" for name, value in facts.items())
        return f'{_quoted(parent)} -> {_quoted(frame)}[label=" {label}"];'


def _by(nodes: str, text: str) -> str:
    return f"{text} (by {nodes})" if nodes else text


def _loop_text(loop: Iterable[str]) -> str:
    frames = list(loop)
    return f"the frames are a loop: {' -> '.join([*frames, frames[0]])} (child -> parent)"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
