"""The transforms of the last seconds, and lookups between any two frames, as tf2 does them.

Texts of errors are those of tf2. Times are nanoseconds; 0 is the latest time that all transforms
between two frames have.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from typing import NamedTuple

from launcher.ros.tf.arithmetic import Transform, between, is_unit, normalized

CACHE_NS = 10_000_000_000
_DEEPEST = 1000  # frames above each other; more is a loop


class StampedTransform(NamedTuple):
    """A transform from the frame `child` into its `parent`, as it is published."""

    parent: str
    child: str
    stamp_ns: int
    transform: Transform


class TfError(Exception):
    """There is no such transform; the text is tf2's."""


class _NoDataError(TfError):
    """A frame has no transform at this time."""

    def __init__(self, text: str, newest_ns: int) -> None:
        super().__init__(text)
        self.newest_ns = newest_ns


def refusal(stamped: StampedTransform) -> str | None:
    """Why no listener takes it: the name of tf2's error with what is wrong; None for a good one."""
    if stamped.parent == stamped.child:
        return "TF_SELF_TRANSFORM: parent and child are the same frame"
    if not stamped.child:
        return "TF_NO_CHILD_FRAME_ID: the child has no name"
    if not stamped.parent:
        return "TF_NO_FRAME_ID: the parent has no name"
    numbers = (*stamped.transform.translation, *stamped.transform.rotation)
    if any(math.isnan(number) for number in numbers):
        return "TF_NAN_INPUT: it contains nan"
    try:
        normalized(stamped.transform.rotation)
    except ValueError as error:
        return f"TF_DENORMALIZED_QUATERNION: {error}"
    return None


def seconds_text(time_ns: int) -> str:
    sec, nsec = divmod(time_ns, 1_000_000_000)
    return f"{sec + 1e-9 * nsec:.6f}"


class _Moving:
    """Transforms of one child in the order of their stamps; those that are too old are dropped."""

    def __init__(self, keep_ns: int | None) -> None:
        self._keep_ns = keep_ns
        self._stamps: list[int] = []
        self._items: list[StampedTransform] = []

    @property
    def newest(self) -> StampedTransform:
        return self._items[-1]

    @property
    def newest_ns(self) -> int:
        return self._stamps[-1]

    def insert(self, item: StampedTransform) -> bool:
        """False if it is older than all that is kept."""
        if self._stamps and self._keep_ns is not None:
            oldest_ns = self.newest_ns - self._keep_ns
            late = bisect_left(self._stamps, oldest_ns)
            del self._stamps[:late], self._items[:late]
            if item.stamp_ns < oldest_ns:
                return False
        place = bisect_right(self._stamps, item.stamp_ns)
        same = bisect_left(self._stamps, item.stamp_ns)
        if item not in self._items[same:place]:
            self._stamps.insert(place, item.stamp_ns)
            self._items.insert(place, item)
        return True

    def at(self, time_ns: int) -> StampedTransform:
        first_ns, last_ns = self._stamps[0], self._stamps[-1]
        if time_ns in (0, last_ns):
            return self._items[-1]
        if time_ns == first_ns:
            return self._items[0]
        if len(self._stamps) == 1:
            known = f"but only time {seconds_text(last_ns)} is in the buffer"
            raise self._no_data(f" at time {seconds_text(time_ns)}, {known}")
        wanted = f"Requested time {seconds_text(time_ns)}"
        if time_ns > last_ns:
            known = f"but the latest data is at time {seconds_text(last_ns)}"
            raise self._no_data(f" into the future.  {wanted} {known}")
        if time_ns < first_ns:
            known = f"but the earliest data is at time {seconds_text(first_ns)}"
            raise self._no_data(f" into the past.  {wanted} {known}")
        after = bisect_right(self._stamps, time_ns)
        one, other = self._items[after - 1], self._items[after]
        if one.parent != other.parent:
            return one
        ratio = (time_ns - one.stamp_ns) / (other.stamp_ns - one.stamp_ns)
        return one._replace(transform=between(one.transform, other.transform, ratio))

    def _no_data(self, text: str) -> _NoDataError:
        return _NoDataError(f"Lookup would require extrapolation{text}", self.newest_ns)


class _Fixed:
    """A static transform: it holds at all times."""

    newest_ns = 0

    def __init__(self) -> None:
        self.newest: StampedTransform

    def insert(self, item: StampedTransform) -> bool:
        self.newest = item
        return True

    def at(self, time_ns: int) -> StampedTransform:
        return self.newest


class _Climb(NamedTuple):
    """The way up from a frame to `top`; `error` if there is no transform of that at the time."""

    top: str
    transform: Transform
    error: _NoDataError | None
    way: tuple[str, ...]


class TransformBuffer:
    """Transforms by their child; `keep_ns` None keeps all."""

    def __init__(self, keep_ns: int | None = CACHE_NS) -> None:
        self._keep_ns = keep_ns
        self._caches: dict[str, _Moving | _Fixed] = {}
        self._frames: dict[str, None] = {}  # in the order in which tf2 numbers them

    def add(self, stamped: StampedTransform, *, is_static: bool) -> str | None:
        """Why it was ignored; None if it was not."""
        if (why := refusal(stamped)) is not None:
            return why
        cache, kind = self._caches.get(stamped.child), _Fixed if is_static else _Moving
        if not isinstance(cache, kind):
            cache = _Fixed() if is_static else _Moving(self._keep_ns)
        if not is_unit(stamped.transform.rotation):  # Jazzy takes it, Kilted does not
            rotation = normalized(stamped.transform.rotation)
            stamped = stamped._replace(transform=stamped.transform._replace(rotation=rotation))
        self._frames.update({stamped.child: None, stamped.parent: None})
        if not cache.insert(stamped):
            return "TF_OLD_DATA: it is older than all that is kept"
        self._caches[stamped.child] = cache
        return None

    def frames_text(self) -> str:
        """A line for each frame with a parent."""
        return "".join(
            f"Frame {frame} exists with parent {self._caches[frame].newest.parent}.\n"
            for frame in self._frames
            if frame in self._caches
        )

    def why_not(self, target: str, source: str, time_ns: int = 0) -> str | None:
        """Why there is no such transform (yet); None if there is."""
        if target == source:
            return None
        for argument, frame in (("target_frame", target), ("source_frame", source)):
            if (fault := self._fault(frame)) is not None:
                return (
                    f'Invalid frame ID "{frame}" passed to canTransform argument {argument} - '
                    + (fault or "frame does not exist")
                )
        try:
            self._walk(target, source, time_ns)
        except TfError as error:
            return str(error)
        return None

    def lookup(self, target: str, source: str, time_ns: int = 0) -> StampedTransform:
        """The transform that brings data of `source` into `target`; TfError."""
        if target == source:
            cache = self._caches.get(target)
            stamp_ns = time_ns or (cache.newest_ns if cache else 0)
            return StampedTransform(target, source, stamp_ns, Transform())
        for argument, frame in (("target_frame", target), ("source_frame", source)):
            passed = f'"{frame}" passed to lookupTransform argument {argument}'
            if (fault := self._fault(frame)) is not None:
                if fault:
                    raise TfError(f"Invalid argument {passed} - {fault}")
                raise TfError(f"{passed} does not exist. ")
        stamped, _ = self._walk(target, source, time_ns)
        return stamped

    def chain(self, target: str, source: str) -> tuple[str, ...]:
        """All frames on the way from `source` to `target`, now; TfError."""
        return (target,) if target == source else self._walk(target, source, 0)[1]

    def _fault(self, frame: str) -> str | None:
        """What is wrong with a name; an empty text if there is no such frame, None if there is."""
        if not frame:
            return "in tf2 frame_ids cannot be empty"
        if frame[0] == "/":
            return "in tf2 frame_ids cannot start with a '/'"
        return None if frame in self._frames else ""

    def _walk(
        self, target: str, source: str, time_ns: int
    ) -> tuple[StampedTransform, tuple[str, ...]]:
        time_ns = time_ns or self._common_ns(target, source)
        up = self._climb(source, (target,), time_ns)
        if up.top == target:
            return StampedTransform(target, source, time_ns, up.transform), up.way
        down = self._climb(target, (up.top, source), time_ns)
        if down.top == source:
            result = down.transform.inverse()
            return StampedTransform(target, source, time_ns, result), down.way[::-1]
        if down.top != up.top:
            raise self._failure(target, source, up.error, down.error)
        result = down.transform.inverse().after(up.transform)
        way = _shortest(up.way, down.way)
        return StampedTransform(target, source, time_ns, result), way

    def _climb(self, frame: str, stops: tuple[str, ...], time_ns: int) -> _Climb:
        """Go up from a frame to one of the stops, to a root, or to where data are missing."""
        total, way, error = Transform(), [frame], None
        while frame not in stops and (cache := self._caches.get(frame)) is not None:
            try:
                item = cache.at(time_ns)
            except _NoDataError as found:
                error = found
                break
            if len(way) > _DEEPEST:
                raise self._loop()
            total, frame = item.transform.after(total), item.parent
            way.append(frame)
        return _Climb(frame, total, error, tuple(way))

    @staticmethod
    def _failure(
        target: str, source: str, up: _NoDataError | None, down: _NoDataError | None
    ) -> TfError:
        """Of two ways that do not meet; of two with missing data, that with the newer data."""
        error = down if up is None or (down and down.newest_ns > up.newest_ns) else up
        if error is None:
            return _unconnected(target, source)
        way = f"from frame [{source}] to frame [{target}]"
        return TfError(f"{error}, when looking up transform {way}")

    def _common_ns(self, target: str, source: str) -> int:
        """The latest time that all moving transforms between two frames have; 0 if all are static.

        TfError if the frames are not connected, or in a loop.
        """
        up = self._latest(source, target)
        parents = {parent: place for place, (_, parent) in enumerate(up, 1)}
        if target in parents:
            return _earliest(up)
        down = self._latest(target, source)
        for place, (_, parent) in enumerate(down, 1):
            if parent == source:
                return _earliest(down[:place])
            if parent in parents:
                return _earliest(down[:place] + up[: parents[parent]])
        raise _unconnected(target, source)

    def _latest(self, frame: str, stop: str) -> list[tuple[int, str]]:
        """The latest time and the parent of each frame on the way up."""
        found: list[tuple[int, str]] = []
        while frame != stop and (cache := self._caches.get(frame)) is not None:
            found.append((cache.newest_ns, cache.newest.parent))
            frame = cache.newest.parent
            if len(found) > _DEEPEST:
                raise self._loop()
        return found

    def _loop(self) -> TfError:
        text = "The tf tree is invalid because it contains a loop."
        return TfError(f"{text}\n{self.frames_text()}\n")


def _shortest(up: tuple[str, ...], down: tuple[str, ...]) -> tuple[str, ...]:
    """From the start of one way to that of the other, by the first frame that both have."""
    meeting = next(frame for frame in up if frame in down)
    return (*up[: up.index(meeting) + 1], *down[: down.index(meeting)][::-1])


def _earliest(times: list[tuple[int, str]]) -> int:
    return min((stamp_ns for stamp_ns, _ in times if stamp_ns), default=0)


def _unconnected(target: str, source: str) -> TfError:
    return TfError(
        f"Could not find a connection between '{target}' and '{source}' because they are not part "
        "of the same tree.Tf has two or more unconnected trees."
    )
